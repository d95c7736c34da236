# Runs `ticktrue unsaved` on programs that omit one variable each, on clean programs, and on programs that cannot be
# examined.
# SPDX-License-Identifier: MIT
#
#   unsaved_test.py TICKTRUE FOLDER_OF_PROGRAMS STATIC_PROGRAM
import argparse
import json
import os
import re
import subprocess
import sys
import tempfile

# The expected first thing of a finding: a name, or the place of the allocation.
PLANTED = {
    "global": ("variable", "combo_global"),
    "file_static": ("variable", "lcg_state"),
    "function_static": ("variable", "count_calls()::calls_of_spawn"),
    "class_static": ("variable", "Spawner::next_id"),
    "struct_member": ("variable", "file_settings"),
    "twister_global": ("variable", "twister_global"),
    "twister_heap": ("heap", "make_rng"),
    "rand": ("generator", ""),
    "distribution": ("variable", "spread_values"),
    "heap_pointer": ("heap", "Ai"),
    "heap_member": ("heap", "make_ai"),
    "heap_float": ("heap", "make_ai"),
    "heap_bool": ("heap", "make_ai"),
    "calloc_table": ("heap", "make_table"),
    "vector_growth": ("variable", "pushed_values"),
    "vector_order": ("holder", "free_slots"),
    "deque": ("variable", "pending_events"),
    "map": ("variable", "visits_map"),
    "unordered_map": ("variable", "cost_map"),
    "set": ("variable", "seen_set"),
    "list": ("variable", "turn_list"),
    "string": ("variable", "log_text"),
    "thread_local": ("variable", "streak_of_thread"),
    "module": ("variable", "level_of_module"),
    "cache": ("variable", "cached_sum"),
    "local": ("stack", ""),
}
# A variable of every planted program that differs after load without harm.
HARMLESS = ["frames_shown", "last_message"]
CLEAN = ["plain", "pure_cache", "pure_hash_cache", "allocations", "log_buffer", "frames", "containers", "scratch",
         "particles", "history", "printing", "large_blocks", "forks"]
REFUSED = {
    "without_saves": "the session has no load callback: nothing to compare",
    "threads": "found 2 threads, expected one",
    "crash": "crashed",
    "hang": "hung",
    "diverges": "it differs from the trace without any load",
}


def run(args, folder, program, name, words):
    trace = os.path.join(folder, name + ".ttr")
    subprocess.run([program, name, "--record", trace], check=True, stdout=subprocess.DEVNULL)
    return subprocess.run([args.ticktrue, "unsaved", trace, *words, "--", program, name], capture_output=True,
                          text=True, cwd=folder)


def check_planted(args, folder, name):
    kind, expected = PLANTED[name]
    done = run(args, folder, os.path.join(args.programs, "unsaved_planted"), name, ["--json"])
    if done.returncode != 1:
        return f"exit code {done.returncode}, expected 1: {done.stdout}{done.stderr}"
    report = json.loads(done.stdout)
    if report["unexplained"] or report["not_loaded"]:
        return f"found columns without a cause: {report}"
    field = {"heap": "function", "holder": "holder"}.get(kind, "name")
    kind = "heap" if kind == "holder" else kind
    named = [thing[field] for finding in report["findings"] for thing in finding["things"] if thing["kind"] == kind]
    if not any(expected in found for found in named):
        return f"found {[f['things'] for f in report['findings']]}, expected {kind} {expected}"
    if any(not finding["columns"] or "x" not in finding["columns"][0] for finding in report["findings"]):
        return f"found other columns than units.x: {report['findings']}"
    wrong = [thing["name"] for finding in report["findings"] for thing in finding["things"]
             if thing["name"] in HARMLESS or (thing["kind"] == "variable" and expected not in thing["name"]
                                              and name != "cache" and not (kind == "heap"))]
    return f"found {wrong}, which move nothing" if wrong else ""


def run_printed(args, folder, command):
    """A command that a report prints, the whole line in a shell."""
    path = os.path.dirname(os.path.abspath(args.ticktrue)) + os.pathsep + os.environ["PATH"]
    return subprocess.run(["sh", "-c", command], cwd=folder, env={**os.environ, "PATH": path}, stdin=subprocess.DEVNULL,
                          capture_output=True, text=True)


def check_printed_commands(args, folder):
    """A session whose restored ticks differ prints the command that finds out why. A program that differs without a load
    is told with the command that looks for the cause. Each runs as printed."""
    program = os.path.join(args.programs, "unsaved_planted")
    clean = os.path.join(args.programs, "unsaved_clean")
    trace = os.path.join(folder, "printed in two words.ttr")
    subprocess.run([program, "global", "--record", trace], check=True, stdout=subprocess.DEVNULL)
    done = subprocess.run([program, "global", "--verify", trace, "--mode", "restore"], capture_output=True, text=True)
    found = re.search(r"^  again +(ticktrue unsaved .*  # names what the save lacks)$", done.stdout, re.M)
    if done.returncode != 1 or not found:
        return f"exit code {done.returncode}, found {done.stdout}, expected a line `again ticktrue unsaved ...`"
    ran = run_printed(args, folder, found.group(1))
    if ran.returncode != 1 or "combo_global" not in ran.stdout:
        return f"{found.group(1)}: exit code {ran.returncode}: {ran.stdout}{ran.stderr}"
    done = run(args, folder, clean, "diverges", [])
    found = re.search(r"^  (ticktrue shake .*  # looks for the cause of that)$", done.stderr, re.M)
    if done.returncode != 2 or not found:
        return f"diverges: exit code {done.returncode}, found {done.stdout}{done.stderr}, expected a command of shake"
    ran = run_printed(args, folder, found.group(1))
    if ran.returncode != 0 or "control         same" not in ran.stdout:
        return f"{found.group(1)}: exit code {ran.returncode}: {ran.stdout}{ran.stderr}"
    return ""


def check_not_reproducible(args, folder):
    """Ticks that a copy of the process does not repeat: what the save lacks cannot be told, and the report says so with
    the command that looks for the cause."""
    program = os.path.join(args.programs, "unsaved_clean")
    done = run(args, folder, program, "instances", ["--json"])
    report = json.loads(done.stdout) if done.stdout else {}
    if done.returncode != 6 or report.get("verdict") != "not_reproducible" or report["findings"] \
            or not report["saves_loaded"]:
        return f"instances: exit code {done.returncode}, expected 6: {done.stdout}{done.stderr}"
    done = run(args, folder, program, "instances", [])
    if not re.match(r"not_reproducible .*instances\.ttr ", done.stdout) \
            or not re.search(r"^  note +the same ticks from the same memory end otherwise at tick [0-9]+$", done.stdout, re.M):
        return f"instances: found {done.stdout}{done.stderr}, expected not_reproducible and a note of the tick"
    found = re.search(r"^next  (ticktrue shake .*  # looks for the cause: .*)$", done.stdout, re.M)
    if done.returncode != 6 or not found or [found.group(1)] != report["next"]:
        return f"instances: exit code {done.returncode}, found {done.stdout}, expected {report['next']}"
    ran = run_printed(args, folder, found.group(1))
    if ran.returncode != 0 or "control         same" not in ran.stdout:
        return f"{found.group(1)}: exit code {ran.returncode}: {ran.stdout}{ran.stderr}"
    return ""


def check_box2d(args, folder):
    """A save of a game on Box2D that holds what the game can see: the block of Box2D that lacks is named."""
    program = os.path.join(args.programs, "box2d_rollback")
    if not os.path.exists(program):
        print("unsaved_test: box2d_rollback skipped: it was not built: apt-get install libbox2d-dev")
        return ""
    trace = os.path.join(folder, "box2d.ttr")
    for way, code in [([], 1), (["mended"], 0)]:
        subprocess.run([program, *way, "--record", trace, "--force"], check=True, stdout=subprocess.DEVNULL)
        done = subprocess.run([args.ticktrue, "unsaved", trace, "--json", "--", program, *way], capture_output=True,
                              text=True, cwd=folder)
        if done.returncode != code:
            return f"box2d_rollback {way}: exit code {done.returncode}, expected {code}: {done.stdout}{done.stderr}"
        report = json.loads(done.stdout)
        named = [(thing["kind"], thing["function"].split("(")[0]) for finding in report["findings"]
                 for thing in finding["things"]]
        if named != ([] if way else [("heap", "b2BlockAllocator::Allocate")]):
            return f"box2d_rollback {way}: found {report['findings']}"
    return ""


def check_limit(args, folder):
    """More windows differ than are examined: the report says how many were not."""
    program = os.path.join(args.programs, "unsaved_planted")
    trace = os.path.join(folder, "long.ttr")
    subprocess.run([program, "global", "--record", trace], check=True, stdout=subprocess.DEVNULL,
                   env={**os.environ, "TICKS": "600"})
    done = subprocess.run([args.ticktrue, "unsaved", trace, "--", program, "global"], capture_output=True, text=True,
                          cwd=folder, env={**os.environ, "TICKS": "600"})
    if done.returncode != 1 or not re.search(r"note +[1-9][0-9]* windows with other columns were not examined", done.stdout):
        return f"exit code {done.returncode}, found {done.stdout}{done.stderr}, expected a note of windows not examined"
    return ""


def check_clean(args, folder, name):
    before = set(os.listdir(folder))
    done = run(args, folder, os.path.join(args.programs, "unsaved_clean"), name, [])
    if done.returncode != 0 or not done.stdout.startswith("nothing unsaved moves a column"):
        return f"exit code {done.returncode}, found {done.stdout}{done.stderr}"
    left = set(os.listdir(folder)) - before - {name + ".ttr"}
    return f"found files that were left: {left}" if left else ""


def check_refused(args, folder, name):
    done = run(args, folder, os.path.join(args.programs, "unsaved_clean"), name, ["--timeout", "5"])
    if done.returncode != 2 or REFUSED[name] not in done.stderr:
        return f"exit code {done.returncode}, found {done.stdout}{done.stderr}, expected {REFUSED[name]}"
    return ""


def check_usage(args, folder):
    trace = os.path.join(folder, "plain.ttr")
    static = os.path.join(folder, "static.ttr")
    subprocess.run([args.static, "plain", "--record", static], check=True, stdout=subprocess.DEVNULL)
    for words, expected in [([static, "--", args.static, "plain"], "found no preload library in it"),
                            ([trace, "--", "/bin/true"], "/bin/true: no session wrote findings"),
                            ([trace], "unsaved: found no program"),
                            ([trace + "x", "--", "/bin/true"], "No such file")]:
        done = subprocess.run([args.ticktrue, "unsaved", *words], capture_output=True, text=True)
        if done.returncode != 2 or expected not in done.stderr:
            return f"{words}: exit code {done.returncode}, found {done.stdout}{done.stderr}, expected {expected}"
    return ""


def main():
    parser = argparse.ArgumentParser()
    for name in ["ticktrue", "programs", "static"]:
        parser.add_argument(name)
    parser.add_argument("--only", default="")
    args = parser.parse_args()
    faults = count = 0
    with tempfile.TemporaryDirectory() as folder:
        for check, names in [(check_planted, PLANTED), (check_clean, CLEAN), (check_refused, REFUSED)]:
            for name in names:
                if args.only and name not in args.only.split(","):
                    continue
                count += 1
                fault = check(args, folder, name)
                if fault:
                    faults += 1
                    print(f"unsaved_test: error: {name}: {fault}")
        for check in [] if args.only else [check_usage, check_printed_commands, check_not_reproducible, check_box2d, check_limit]:
            fault = check(args, folder)
            if fault:
                faults += 1
                print(f"unsaved_test: error: {fault}")
    print(f"unsaved_test: {count} programs, {faults} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
