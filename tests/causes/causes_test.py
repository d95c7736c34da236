# Runs `ticktrue shake` over the gallery: causes are named, mended twins and clean programs are quiet.
# SPDX-License-Identifier: MIT
#
#   causes_test.py TICKTRUE PROGRAMS LIBRARY [--full] [NAME...]
#
# PROGRAMS is the folder of the built programs, LIBRARY libticktrue. Without --full, mended programs are run under the
# perturbations that are to blame alone, and no processor is emulated.
import concurrent.futures
import json
import os
import subprocess
import sys
import tempfile
import time

SOURCE = os.path.dirname(os.path.abspath(__file__))

# program, perturbations that name the cause (one is enough), function of the call, class
MISTAKES = [
    ("heap_garbage", ["heap_fill"], "malloc", "A"),
    ("freed_memory", ["heap_fill"], "free", "A"),
    ("pointer_order", ["heap_order"], "malloc", "A"),
    ("address_hash", ["address_layout"], None, "A"),
    ("alignment_peel", ["heap_alignment"], None, "A"),  # any earlier block moves the later ones
    ("stack_garbage", ["stack_fill"], None, "A"),
    ("locale_comma", ["locale"], None, "A"),
    ("time_zone", ["time_zone"], None, "A"),
    ("directory_order", ["directory_order"], "readdir", "A"),
    ("thread_count", ["processors"], "get_nprocs", "A"),
    ("thread_order", ["thread_start", "one_cpu"], None, "A"),
    ("steady_clock", ["uptime"], "clock_gettime", "A"),
    ("wall_clock_seed", ["date"], "clock_gettime", "A"),
    ("random_bytes", ["random"], "getrandom", "A"),
    ("shared_generator", ["rand_draws"], "rand", "A"),
    ("working_folder", ["working_folder"], None, "A"),
    ("hash_seed.py", ["hash_seed"], None, "A"),
    ("sort_ties", ["sort_ties"], "qsort", "B"),
    ("libm_sine", ["libm_of_cpu"], "sin", "B"),
    ("libm_python.py", ["libm_of_cpu"], "sin", "B"),
    ("denormals", ["flush_to_zero"], None, "B"),
]
CLEAN = ["integers", "containers", "threads", "clocks", "files", "floats", "processes", "qsort_ids", "clean_python.py"]
# way of tests/causes/rude.cpp, outcome, words of the report
RUDE = [
    ("crash", "crashed", "in tick 9"),
    ("exit", "no_result", "ended with status 7"),
    ("hang", "hung", "did not end within 3 s"),
    ("escape", "same", "left running"),
    ("print", "same", ""),
    ("close", "same", ""),
]


class Failed(Exception):
    pass


class Gallery:
    def __init__(self, tool, programs, library, full):
        self.tool, self.programs, self.full = tool, programs, full
        self.environment = dict(os.environ, TICKTRUE_LIBRARY=library, TICKTRUE_PROGRESS="never")
        self.environment.pop("PYTHONHASHSEED", None)

    def words(self, name, clean=False):
        if not name.endswith(".py"):
            return [os.path.join(self.programs, name)]
        return [sys.executable, os.path.join(SOURCE, "clean" if clean else "", name)]

    def run(self, words, codes):
        done = subprocess.run(words, env=self.environment, stdin=subprocess.DEVNULL, capture_output=True, timeout=600)
        if done.returncode not in codes:
            raise Failed(f"{' '.join(words)}: exit code {done.returncode}, expected {codes}\n"
                         + done.stdout.decode(errors="replace")[-3000:] + done.stderr.decode(errors="replace")[-1000:])
        return done.stdout.decode(errors="replace")

    def shake(self, folder, words, options, codes):
        trace = os.path.join(folder, "game.ttr")
        self.run(words + ["--record", trace, "--force"], [0])
        text = self.run([self.tool, "shake", trace, "--json"] + options + ["--"] + words, codes)
        return json.loads(text)

    def options(self):
        return [] if self.full else ["--vary=-cpu_model"]

    def mistake(self, folder, name, rows, function, kind):
        report = self.shake(folder, self.words(name), self.options() + ["--class", "A,B"], [1, 6])
        moved = {row["name"]: row for row in report["perturbations"] if row["outcome"] not in
                 ("same", "not_applicable", "not_run")}
        named = [row for row in rows if row in moved or row in report["fixed_by"]]
        if not named:
            raise Failed(f"{name}: found {sorted(moved)} and {report['fixed_by']}, expected {rows}")
        if kind == "B" and any(row["class"] == "A" for row in moved.values()):
            raise Failed(f"{name}: found {sorted(moved)}, expected nothing of class A")
        if function:
            cause = moved[named[0]]["cause"] if named[0] in moved else report["fixed_call"]
            if not cause or cause.get("function") != function:
                raise Failed(f"{name}: {named[0]}: found the cause {cause}, expected a call of {function}")
            stem = name.split(".")[0]
            if not name.endswith(".py") and not cause["source"].endswith(f"{stem}.cpp"):
                raise Failed(f"{name}: {named[0]}: found the call in {cause['source']}, expected {stem}.cpp")
        return f"{named[0]}: " + (moved[named[0]]["run"].get("column", "as recorded") if named[0] in moved
                                  else "held still")

    def mended(self, folder, name, rows):
        options = ["--class", "A,B"] + (self.options() if self.full else ["--vary", ",".join(rows)])
        report = self.shake(folder, self.words(name) + ["mended"], options, [0])
        return f"{report['runs']} runs"

    def clean(self, folder, name):
        report = self.shake(folder, self.words(name, clean=True), ["--class", "A"], [0])
        if not report["repeats"] or report["moved"]["A"]:
            raise Failed(f"{name}: found {report['moved']}, expected nothing")
        return f"{report['runs']} runs, {report['not_applicable']} not applicable"

    def instruction(self, folder):
        report = self.shake(folder, self.words("hardware_random"), ["--class", "A"], [6])
        if report["fixed_by"] or not any("rdrand at " in place and "hardware_random.cpp" in place
                                         for place in report["instructions"]):
            raise Failed(f"hardware_random: found {report['fixed_by']}, {report['instructions']}, expected rdrand")
        return report["instructions"][0]

    def documents(self):
        rows = self.run([self.tool, "shake", "--list"], [0]).splitlines()
        with open(os.path.join(SOURCE, "../../docs/causes.md"), encoding="utf-8") as file:
            text = file.read()
        for row in rows:
            kind, name, what = row.split(None, 2)
            if f"| `{name}` | {kind} | {what} |" not in text:
                raise Failed(f"docs/causes.md: found no row for {row}")
        for name, *_ in MISTAKES:
            if f"`{name}`" not in text:
                raise Failed(f"docs/causes.md: found no `{name}`")
        return f"{len(rows)} perturbations"

    def rude(self, folder, way, outcome, words):
        code = 0 if outcome == "same" else 1
        report = self.shake(folder, self.words("rude") + [way], ["--vary", "environment", "--timeout", "3"], [code])
        row = report["perturbations"][0]
        text = json.dumps(report)
        if row["outcome"] != outcome or words not in text:
            raise Failed(f"rude {way}: found {row['outcome']} and no {words!r} in {text}, expected {outcome}")
        left = subprocess.run(["pgrep", "-f", os.path.join(self.programs, "rude") + " " + way], capture_output=True)
        if left.stdout.strip():
            raise Failed(f"rude {way}: found processes {left.stdout.decode().split()}, expected none")
        return outcome


def main():
    words = [word for word in sys.argv[1:] if word != "--full"]
    if len(words) < 3:
        print("usage: causes_test.py TICKTRUE PROGRAMS LIBRARY [--full] [NAME...]", file=sys.stderr)
        return 2
    full = "--full" in sys.argv
    gallery = Gallery(words[0], words[1], words[2], full)
    only = set(words[3:])
    jobs = []
    for name, rows, function, kind in MISTAKES:
        jobs.append((name, lambda folder, n=name, r=rows, f=function, k=kind: gallery.mistake(folder, n, r, f, k)))
        jobs.append((name + " mended", lambda folder, n=name, r=rows: gallery.mended(folder, n, r)))
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        if " rdrand" in file.read():
            jobs.append(("hardware_random", gallery.instruction))
            jobs.append(("hardware_random mended", lambda folder: gallery.mended(folder, "hardware_random", ["random"])))
    jobs.append(("documents", lambda folder: gallery.documents()))
    for name in CLEAN:
        jobs.append((name + " clean", lambda folder, n=name: gallery.clean(folder, n)))
    for way, outcome, text in RUDE:
        jobs.append(("rude " + way, lambda folder, w=way, o=outcome, t=text: gallery.rude(folder, w, o, t)))
    jobs = [job for job in jobs if not only or job[0].split()[0] in only]
    failures = 0

    def work(job):
        start = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            try:
                return job[0], "ok     " + job[1](folder), time.monotonic() - start
            except (Failed, subprocess.TimeoutExpired, json.JSONDecodeError) as failure:
                return job[0], "FAILED " + str(failure), time.monotonic() - start

    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        for name, text, seconds in pool.map(work, jobs):
            print(f"{name:28} {seconds:5.1f} s  {text}", flush=True)
            failures += text.startswith("FAILED")
    print(f"{len(jobs)} runs, {failures} failed")
    return 1 if failures else 0


sys.exit(main())
