# Runs `ticktrue trail` on generated variants of a small game. Each variant has a few calls more or fewer in one
# function.
# SPDX-License-Identifier: MIT
#
#   trail_test.py TICKTRUE COMPILER INCLUDE LIBRARY_FOLDER [--count N] [--seed N]
#
# A variant is a separate program, built from a generated source. The trail must name tick, function and count of every
# planted change, compared with the original program.
import argparse
import json
import os
import random
import subprocess
import sys
import tempfile

TICKS = 30
FUNCTIONS = ["shuffle", "scatter", "spawn_wave", "choose_target", "roll_damage", "drift"]
# How a function draws: marked by the function, marked by a shared helper, or only by the C library.
DIRECT, HELPER, LIBRARY = "direct", "helper", "library"

HEAD = """
#include <stdlib.h>
#include "ticktrue.h"
static ticktrue_session* session;
static uint64_t tick;
static uint32_t own = 42;
static uint64_t sum;
static uint32_t next_number(void) { return own = own * 1664525u + 1013904223u; }
__attribute__((noinline)) static uint32_t draw(void) {
  const uint32_t value = next_number();
  ticktrue_mark(session, "draw", value);
  return value;
}
"""

MAIN = """
int main(int argc, char** argv) {
  ticktrue_options options = {0};
  options.struct_size = sizeof options;
  options.name = "variants";
  options.flags = TICKTRUE_MARKS;
  session = ticktrue_open_arguments(&options, argc, argv);
  ticktrue_column(session, "world", "tick", &tick, TICKTRUE_U64, 1, 1, 0);
  srand(7);
  while (tick < TICKS) {
    if (ticktrue_begin_tick(session, 0) != TICKTRUE_OK) break;
    CALLS
    ++tick;
    if (ticktrue_end_tick(session) != TICKTRUE_OK) break;
  }
  return ticktrue_close(session);
}
"""

# Marks made by the C++ header, whose functions are not callers.
CPP = """
#include <ticktrue.hpp>
static std::uint32_t own = 42;
__attribute__((noinline)) static void shuffle(ticktrue::Session& session, int count) {
  for (int i = 0; i < count; ++i) session.mark("pick", own = own * 1664525u + 1013904223u);
}
int main(int argc, char** argv) {
  ticktrue::Session session(argc, argv, ticktrue::Options("cpp").marks());
  std::uint32_t tick = 0;
  session.table("tick", tick);
  for (; tick < 12 && session.begin_tick(); session.end_tick()) shuffle(session, tick++ == 7 ? COUNT : 3);
  return session.close();
}
"""

CALL = {
    DIRECT: 'const uint32_t value = next_number(); ticktrue_mark(session, "pick", value); sum += value;',
    HELPER: "sum += draw();",
    LIBRARY: "sum += (uint32_t)rand();",
}


class Game:
    """How often each function draws in a tick, and by what."""

    def __init__(self, seed):
        rng = random.Random(seed)
        self.ways = [DIRECT, HELPER, LIBRARY] * 2
        rng.shuffle(self.ways)
        self.base = [rng.randint(1, 6) for _ in FUNCTIONS]
        self.step = [rng.randint(2, 5) for _ in FUNCTIONS]

    def calls(self, function, tick):
        return self.base[function] + tick % self.step[function]

    def source(self, plant=None):
        text = HEAD
        for i, name in enumerate(FUNCTIONS):
            extra = ""
            if plant and plant["function"] == i:
                extra = f" if (tick == {plant['tick']}) count += {plant['delta']};"
            text += (
                f"__attribute__((noinline)) static void {name}(void) {{\n"
                f"  int count = {self.base[i]} + (int)(tick % {self.step[i]});{extra}\n"
                f"  for (int i = 0; i < count; ++i) {{ {CALL[self.ways[i]]} }}\n}}\n"
            )
        calls = " ".join(f"{name}();" for name in FUNCTIONS)
        return text + MAIN.replace("TICKS", str(TICKS)).replace("CALLS", calls)

    def plant(self, rng):
        function = rng.randrange(len(FUNCTIONS))
        tick = rng.randrange(TICKS)
        there = self.calls(function, tick)
        delta = rng.choice([d for d in range(-there, 8) if d != 0])
        return {"function": function, "tick": tick, "delta": delta}


def build(args, folder, name, source):
    path = os.path.join(folder, name)
    with open(path + ".cpp", "w") as out:
        out.write(source)
    subprocess.run(
        [args.compiler, "-std=c++20", "-O1", "-g", "-I", args.include, path + ".cpp", "-o", path, "-L", args.library, "-lticktrue",
         "-Wl,-rpath," + args.library],
        check=True,
    )
    return path


def trail(args, trace, words, program):
    done = subprocess.run([args.ticktrue, "trail", trace, "--json", *words, "--", program], capture_output=True, text=True)
    if not done.stdout:
        sys.exit(f"trail_test: error: {program}: exit code {done.returncode}: {done.stderr}")
    return done.returncode, json.loads(done.stdout)


def check(args, folder, game, plain, trace, number, rng):
    """Empty, or what the trail says wrongly of a variant."""
    plant = game.plant(rng)
    program = build(args, folder, f"variant_{number}", game.source(plant))
    way = game.ways[plant["function"]]
    function = FUNCTIONS[plant["function"]]
    words = ["--against", plain] + (["--calls", "random"] if way == LIBRARY else [])
    code, report = trail(args, trace, words, program)
    name = {DIRECT: "pick", HELPER: "draw", LIBRARY: "libc.rand"}[way]
    there = game.calls(plant["function"], plant["tick"])
    expected = {"name": name, "here": there + plant["delta"], "there": there}
    found = report["calls"][0] if report["calls"] else None
    is_named = found and function in found["function"].split(" < ") and all(found[k] == expected[k] for k in expected)
    if code != 1 or report["tick"] != plant["tick"] or len(report["calls"]) != 1 or not is_named:
        return f"{function} {plant}, {way}: exit code {code}, tick {report['tick']}, found {report['calls']}"
    first = report["first"]
    is_extra = plant["delta"] > 0
    side = first["here"] if is_extra else first["there"]
    if first["kind"] != ("extra" if is_extra else "missing") or side["name"] != name:
        return f"{function} {plant}, {way}: first {first}"
    if function not in [frame["function"].split("(")[0] for frame in side["stack"]]:
        return f"{function} {plant}, {way}: stack {side['stack']}"
    # Without the other build, the trace only gives counts for the marks that it holds.
    if way != LIBRARY:
        code, alone = trail(args, trace, [], program)
        if code != 1 or alone["tick"] != plant["tick"] or alone["first"] is not None:
            return f"{function} {plant}, {way}: against the trace: {alone}"
        if sum(c["here"] for c in alone["calls"] if c["name"] == name) != alone["names"][0]["here"] or alone["names"][0]["name"] != name:
            return f"{function} {plant}, {way}: against the trace: {alone}"
    os.remove(program)
    return ""


def check_calls_in_traces(args, folder, game, plain):
    """Calls of the C library in a recording, and in the verification of it."""
    function = game.ways.index(LIBRARY)
    plant = {"function": function, "tick": 9, "delta": 2}
    program = build(args, folder, "more_calls", game.source(plant))
    trace = os.path.join(folder, "calls.ttr")
    preload = os.path.join(args.library, "libticktrue_shim.so")
    environment = {**os.environ, "LD_PRELOAD": preload, "TICKTRUE_CALLS": "random"}
    subprocess.run([plain, "--record", trace], check=True, stdout=subprocess.DEVNULL, env=environment)

    def verify(words, **more):
        return subprocess.run([*words, "--verify", trace], capture_output=True, text=True, **more).stdout

    there = game.calls(function, 9) + sum(
        game.calls(i, 9) for i, way in enumerate(game.ways) if way == LIBRARY and i != function)
    expected = f"marks differ first at tick 9: libc.rand {there + 2} times, recorded {there}"
    if "warning" in verify([plain], env=environment):
        return "a recording with calls, verified with calls: found a warning"
    if "libc.rand never, recorded" not in verify([plain]):
        return "a recording with calls, verified without: found no warning"
    if expected not in verify([program], env=environment):
        return f"calls in a trace: found {verify([program], env=environment)}, expected {expected}"
    without = verify([plain], env={**os.environ, "TICKTRUE_CALLS": "random"})
    if "TICKTRUE_CALLS: the preload library is not loaded" not in without:
        return f"calls without the preload library: found {without}"
    code, report = trail(args, trace, ["--calls", "random"], program)
    found = [c for c in report["calls"] if c["function"] == FUNCTIONS[function]]
    if code != 1 or report["tick"] != 9 or not found or found[0]["here"] != game.calls(function, 9) + 2:
        return f"trail of a recording with calls: found {report}"
    return ""


def run_printed(args, command, folder):
    """A command that a report prints, the whole line in a shell."""
    path = os.path.dirname(os.path.abspath(args.ticktrue)) + os.pathsep + os.environ["PATH"]
    return subprocess.run(["sh", "-c", command], cwd=folder, env={**os.environ, "PATH": path}, stdin=subprocess.DEVNULL,
                          capture_output=True, text=True)


def check_printed_commands(args, folder, game, plain):
    """What a session with marks prints where it diverges, in text and JSON, and what trail prints where runs differ."""
    with_sum = game.source().replace(
        "  srand(7);", '  ticktrue_column(session, "world", "sum", &sum, TICKTRUE_U64, 1, 1, 0);\n  srand(7);')
    there = build(args, folder, "with_sum", with_sum)
    plant = {"function": game.ways.index(DIRECT), "tick": 11, "delta": 2}
    here = build(args, folder, "sum and more", game.source(plant).replace(
        "  srand(7);", '  ticktrue_column(session, "world", "sum", &sum, TICKTRUE_U64, 1, 1, 0);\n  srand(7);'))
    trace = os.path.join(folder, "with a sum.ttr")
    subprocess.run([there, "--record", trace], check=True, stdout=subprocess.DEVNULL)
    result = os.path.join(folder, "result.json")
    done = subprocess.run([here, "--verify", trace], capture_output=True, text=True,
                          env={**os.environ, "TICKTRUE_RESULT": result})
    printed = [line.split(None, 1)[1] for line in done.stdout.splitlines() if line.startswith("  again   ticktrue ")]
    with open(result) as file:
        stored = [command for command in json.load(file)["again"] if command.startswith("ticktrue ")]
    is_whole = all("  # shows " in command for command in printed)  # the explanation is not an argument
    if [command.split()[1] for command in printed] != ["trail", "shake"] or stored != printed or not is_whole:
        return f"a session with other marks: found {done.stdout} and {stored}, expected the commands trail and shake"
    for command, code, expected in [(printed[0], 1, "tick 11, in which the state diverges"),
                                    (printed[1], 1, "A rand_draws    DIVERGED")]:
        ran = run_printed(args, command, folder)
        if ran.returncode != code or expected not in ran.stdout:
            return f"{command}: exit code {ran.returncode}, found {ran.stdout}{ran.stderr}, expected {code}, {expected}"
    # A program whose marks and state differ in each run. Trail prints the command that names the source.
    restless = with_sum.replace("#include <stdlib.h>", "#include <stdlib.h>\n#include <unistd.h>").replace(
        "    ++tick;", '    if (tick == 5) ticktrue_mark(session, "process", sum = (uint64_t)getpid());\n    ++tick;')
    program = build(args, folder, "restless sum", restless)
    for words, tried in [([], program), (["--against", program], there)]:
        command = [args.ticktrue, "trail", trace, *words, "--", tried]
        done = subprocess.run(command, capture_output=True, text=True)
        code, report = trail(args, trace, words, tried)
        found = [line.split(None, 1)[1] for line in done.stdout.splitlines() if line.startswith("  next ")]
        if code != 6 or len(found) != 1 or found != report["next"] or not found[0].startswith("ticktrue shake "):
            return f"{command}: exit code {code}, found {done.stdout}{report['next']}, expected ticktrue shake"
        ran = run_printed(args, found[0], folder)
        if ran.returncode != 6 or "process_id: held still" not in ran.stdout:
            return f"{found[0]}: exit code {ran.returncode}, found {ran.stdout}{ran.stderr}, expected process_id"
    return ""


def check_ends(args, folder, game, plain):
    """What cannot be compared, and a program that does not repeat itself."""
    restless = game.source().replace("const uint32_t value = next_number();\n  ticktrue_mark",
                                     "const uint32_t value = next_number();\n"
                                     '  if (tick == 5) ticktrue_mark(session, "process", (uint64_t)getpid());\n'
                                     "  ticktrue_mark").replace("#include <stdlib.h>",
                                                                 "#include <stdlib.h>\n#include <unistd.h>")
    program = build(args, folder, "restless", restless)
    trace = os.path.join(folder, "plain.ttr")
    code, report = trail(args, trace, [], program)
    if code != 6 or report["verdict"] != "not_reproducible" or report["tick"] != 5:
        return f"a program with other marks in each run: exit code {code}, {report}"
    unmarked = os.path.join(folder, "unmarked.ttr")
    source = game.source().replace("options.flags = TICKTRUE_MARKS;", "")
    subprocess.run([build(args, folder, "unmarked", source), "--record", unmarked], check=True,
                   stdout=subprocess.DEVNULL)
    for words, expected in [
        ([unmarked, "--", plain], "found no marks in it, expected some to compare with"),
        ([trace, "--", "/bin/true"], "/bin/true: no tick was compared"),
        ([trace], "trail: found no program, expected TRACE -- PROGRAM ARGUMENTS"),
        ([os.path.join(folder, "none.ttr"), "--", plain], "none.ttr: "),
    ]:
        done = subprocess.run([args.ticktrue, "trail", *words], capture_output=True, text=True)
        if done.returncode != 2 or expected not in done.stderr:
            return f"{words}: exit code {done.returncode}, found {done.stderr}, expected {expected}"
    return ""


def check_cpp(args, folder, game, plain):
    """The caller of a mark by the C++ header is the function of the program."""
    there = build(args, folder, "cpp_there", CPP.replace("COUNT", "3"))
    here = build(args, folder, "cpp_here", CPP.replace("COUNT", "5"))
    trace = os.path.join(folder, "cpp.ttr")
    subprocess.run([there, "--record", trace], check=True, stdout=subprocess.DEVNULL)
    code, report = trail(args, trace, ["--against", there], here)
    calls = [(c["function"], c["here"], c["there"]) for c in report["calls"]]
    if code != 1 or report["tick"] != 7 or calls != [("shuffle", 5, 3)]:
        return f"marks by the C++ header: exit code {code}, {report}"
    if not report["first"]["here"]["stack"][0]["function"].startswith("shuffle"):
        return f"marks by the C++ header: first {report['first']}"
    return ""


def main():
    parser = argparse.ArgumentParser()
    for name in ["ticktrue", "compiler", "include", "library"]:
        parser.add_argument(name)
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--seed", type=int, default=20251125)
    args = parser.parse_args()
    wrong = []
    with tempfile.TemporaryDirectory() as folder:
        game = Game(args.seed)
        plain = build(args, folder, "plain", game.source())
        trace = os.path.join(folder, "plain.ttr")
        subprocess.run([plain, "--record", trace], check=True, stdout=subprocess.DEVNULL)
        code, report = trail(args, trace, ["--against", plain, "--calls", "random,libm"], plain)
        if code != 0 or report["verdict"] != "marks_same" or report["ticks_compared"] != TICKS:
            wrong.append(f"the program against itself: {report}")
        for others in [check_calls_in_traces, check_ends, check_cpp, check_printed_commands]:
            fault = others(args, folder, game, plain)
            if fault:
                wrong.append(fault)
        rng = random.Random(args.seed + 1)
        for number in range(args.count):
            fault = check(args, folder, game, plain, trace, number, rng)
            if fault:
                wrong.append(fault)
    for fault in wrong:
        print("trail_test: error: " + fault)
    print(f"trail_test: seed {args.seed}: {args.count} planted changes, {len(wrong)} faults")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
