# Runs `ticktrue shake` on the gallery: causes are named, mended programs and clean programs give no finding.
# SPDX-License-Identifier: MIT
#
#   causes_test.py TICKTRUE PROGRAMS LIBRARY [--full] [NAME...]
#
# PROGRAMS is the folder of the built programs, LIBRARY is libticktrue. Without --full, a mended program only runs under
# the perturbations that name its cause, and no processor is emulated. With --full, each clean program runs under each
# perturbation of class A separately, at least 50 times. The last lines count causes, calls and false alarms.
import concurrent.futures
import json
import os
import shlex
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
    ("library_flush", ["flush_to_zero"], None, "B"),
    ("cycle_counter", ["cycle_counter"], "rdtsc", "A"),
    ("host_name", ["host_name"], "gethostname", "A"),
    ("process_number", ["process_id"], "getpid", "A"),
    ("user_name", ["user"], None, "A"),
    ("save_mode", ["file_mode"], None, "A"),
    ("file_limit", ["file_limit"], None, "A"),
    ("terminal", ["output"], None, "A"),
    ("environment_order", ["environment"], None, "A"),
    ("graph_order.py", ["hash_seed"], None, "A"),
    ("chipmunk_separate", ["address_layout"], None, "A"),
    ("numpy_sine.py", ["library_dispatch"], None, "B"),
]
# Causes that only another build shows: program, perturbations that name the cause.
BUILT = [
    ("fused_products", ["contraction"]),
    ("argument_order", ["other_compiler"]),
    ("overflow", ["no_optimisation"]),
]
# Programs that this machine may be unable to run: the permission or hardware that they need.
NEEDED = {"cycle_counter": "x86_64", "user_name": "user namespace", "library_flush": "x86_64"}
CLEAN = ["integers", "containers", "threads", "clocks", "files", "floats", "processes", "qsort_ids", "clean_python.py",
         "event_queue", "texts", "pools", "sorting", "fixed_point", "hash_table", "grid", "python_market.py",
         "numpy_field.py", "box2d_pile", "chipmunk_pile", "bullet_pile"]
PACKAGES = {"box2d_pile": "libbox2d-dev", "chipmunk_separate": "libchipmunk-dev", "numpy_sine.py": "python3-numpy", "chipmunk_pile": "libchipmunk-dev", "bullet_pile": "libbullet-dev",
            "numpy_field.py": "python3-numpy"}
# Scenes that this project's engine runs, without a program.
SCENES = [("stack?boxes=6", 60), ("mixed_pile?bodies=40", 60)]
# Rules of tests/causes/rules_plugin.cpp, and the perturbations that move them.
PLUGIN = [("garbage", ["heap_fill"]), ("local_hour", ["time_zone"]), ("clean", [])]
RUNS_MIN = 50  # of a clean program, with something changed
# act of tests/causes/rude.cpp, outcome, words in the report
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


class Skipped(Exception):
    pass


def python_with(module):
    for python in (sys.executable, "/usr/bin/python3"):
        if subprocess.run([python, "-c", "import " + module], capture_output=True).returncode == 0:
            return python
    return None


class Gallery:
    named = 0  # named causes
    named_by_build = 0
    sites = 0  # named causes with the place of the call
    clean_runs = []  # perturbed runs of each clean program
    alarms = 0  # clean programs that a perturbation of class A moved
    time_max_s = 600  # of one command

    def __init__(self, tool, programs, library, full):
        self.tool, self.programs, self.full = tool, programs, full
        self.environment = dict(os.environ, TICKTRUE_LIBRARY=library, TICKTRUE_PROGRESS="never")
        self.environment.pop("PYTHONHASHSEED", None)

    def words(self, name, clean=False):
        if not name.endswith(".py"):
            program = os.path.join(self.programs, name)
            if not os.path.exists(program):
                raise Skipped(f"it was not built: apt-get install {PACKAGES[name]}" if name in PACKAGES else "not built")
            return [program]
        python = python_with("numpy") if "numpy" in name else sys.executable
        if python is None:
            raise Skipped(f"apt-get install {PACKAGES[name]}")
        return [python, os.path.join(SOURCE, "clean" if clean else "", name)]

    def run(self, words, codes):
        done = subprocess.run(words, env=self.environment, stdin=subprocess.DEVNULL, capture_output=True,
                              timeout=self.time_max_s)
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

    def require(self, name):
        if NEEDED.get(name) == "x86_64" and os.uname().machine != "x86_64":
            raise Skipped("it is of x86-64 alone")
        if NEEDED.get(name) == "user namespace" and subprocess.run(["unshare", "--user", "true"]).returncode != 0:
            raise Skipped("this system permits no user namespace")

    def mistake(self, folder, name, rows, function, kind):
        self.require(name)
        report = self.shake(folder, self.words(name), self.options() + ["--class", "A,B"], [1, 6])
        moved = {row["name"]: row for row in report["perturbations"] if row["outcome"] not in
                 ("same", "not_applicable", "not_run")}
        named = [row for row in rows if row in moved or row in report["fixed_by"]]
        if not named and name == "cycle_counter":
            repeating = self.shake(folder, self.words(name) + ["mended"], self.options(), [0])
            reasons = [row["reason"] for row in repeating["perturbations"] if row["name"] == name]
            if reasons == ["this machine does not trap rdtsc"]:
                raise Skipped(reasons[0])
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
            self.sites += 1
        if named[0] == "library_dispatch":
            cause = moved[named[0]]["cause"] or {}
            features = cause.get("cpu_features", [])
            # numpy's kernel needs both features, so disabling one is enough. AVX-512 must also be disabled if the
            # processor has it.
            if not {"AVX2", "FMA3"} & set(features) or {"AVX2", "FMA3"} <= set(features) or len(features) > 2:
                raise Failed(f"{name}: found the features {features}, expected AVX2 or FMA3, narrowed")
            if "_multiarray_umath" not in cause.get("module", ""):
                raise Failed(f"{name}: found the module {cause.get('module')}, expected numpy's _multiarray_umath")
        self.named += 1
        return f"{named[0]}: " + (moved[named[0]]["run"].get("column", "as recorded") if named[0] in moved
                                  else "held still")

    def mended(self, folder, name, rows):
        options = ["--class", "A,B"] + (self.options() if self.full else ["--vary", ",".join(rows)])
        report = self.shake(folder, self.words(name) + ["mended"], options, [0])
        return f"{report['runs']} runs"

    def rebuild(self, name):
        library = os.path.dirname(self.environment["TICKTRUE_LIBRARY"])
        words = ["sh", os.path.join(SOURCE, "build.sh"), os.path.join(SOURCE, "builds", name + ".cpp"), library]
        return ["--rebuild", shlex.join(words), "--class", "B",
                "--vary", "other_compiler,no_optimisation,contraction,this_processor"]

    def built(self, folder, name, rows):
        report = self.shake(folder, self.words(name), self.rebuild(name), [1])
        outcomes = {row["name"]: row for row in report["perturbations"]}
        if all(outcomes[row]["outcome"] == "not_applicable" for row in rows):
            raise Skipped(outcomes[rows[0]]["reason"])
        if not any(outcomes[row]["outcome"] == "diverged" for row in rows):
            raise Failed(f"{name}: found {report['perturbations']}, expected {rows}")
        self.named_by_build += 1
        return rows[0] + ": " + outcomes[rows[0]]["run"]["column"]

    def built_mended(self, folder, name):
        report = self.shake(folder, self.words(name) + ["mended"], self.rebuild(name), [0])
        return f"{report['runs']} runs"

    def count_clean(self, name, report):
        """In a full run, every perturbation by itself."""
        changed = sum(row["runs"] for row in report["perturbations"])
        self.clean_runs.append(changed)
        if not report["repeats"] or report["moved"]["A"]:
            self.alarms += 1
            moved = [(row["name"], row["run"]) for row in report["perturbations"] if "run" in row]
            raise Failed(f"{name}: found {report['moved']}, {moved}, expected nothing")
        if self.full and changed < RUNS_MIN:
            raise Failed(f"{name}: found {changed} changed runs, expected at least {RUNS_MIN}")
        return f"{report['runs']} runs, {report['not_applicable']} not applicable"

    def clean_options(self):
        return ["--class", "A"] + (["--alone", "--seeds", "2", "--no-narrow"] if self.full else [])

    def clean(self, folder, name):
        return self.count_clean(name, self.shake(folder, self.words(name, clean=True), self.clean_options(), [0, 1, 6]))

    def scene(self, folder, name, ticks):
        words = [self.tool, "shake", name, "--ticks", str(ticks), "--json"] + self.clean_options()
        return self.count_clean(name, json.loads(self.run(words, [0, 1, 6])))

    def instruction(self, folder):
        report = self.shake(folder, self.words("hardware_random"), ["--class", "A"], [6])
        if report["fixed_by"] or not any("rdrand at " in place and "hardware_random.cpp" in place
                                         for place in report["instructions"]):
            raise Failed(f"hardware_random: found {report['fixed_by']}, {report['instructions']}, expected rdrand")
        self.named += 1
        self.sites += 1
        return report["instructions"][0]

    def hints(self, folder):
        """The commands that the report of a session prints run as printed."""
        words = self.words("environment_order")
        trace = os.path.join(folder, "game.ttr")
        self.run(words + ["--record", trace], [0])
        tools = os.path.dirname(self.tool) + ":" + self.environment["PATH"]
        other = dict(self.environment, TICKTRUE_ADDED="1", PATH=tools)
        done = subprocess.run(["env", "-i", "PATH=" + tools] + words + ["--verify", trace], env=other,
                              stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60)
        commands = [line.split("again", 1)[1].strip() for line in
                    (done.stdout + done.stderr).splitlines() if line.startswith("  again   ticktrue ")]
        if done.returncode != 1 or not commands or any("  # shows " not in command for command in commands):
            raise Failed(f"hints: found status {done.returncode}, {done.stdout}{done.stderr}, expected a command")
        for command in commands:
            ran = subprocess.run(["sh", "-c", command], env=other, stdin=subprocess.DEVNULL, capture_output=True,
                                 text=True, timeout=300)
            if ran.returncode != 1 or "A environment" not in ran.stdout:
                raise Failed(f"hints: {command}: found {ran.returncode}, {ran.stdout}{ran.stderr}, expected environment")
        return f"{len(commands)} commands"

    def order(self, folder):
        """A perturbation changes what it names and no other variable: the order of the others stays as it is."""
        words = self.words("environment_order")
        trace = os.path.join(folder, "game.ttr")
        # Perturbations set these variables before the variable whose position the program reads.
        names = ["LANG", "LC_ALL", "TZ", "PYTHONHASHSEED", "LD_PRELOAD", "GLIBC_TUNABLES"]
        other = {name: {"LD_PRELOAD": "", "GLIBC_TUNABLES": ""}.get(name, "C") for name in names}
        other.update({name: value for name, value in self.environment.items() if name not in other and name != "PATH"})
        other["PATH"] = self.environment["PATH"]
        for command in [words + ["--record", trace],
                        [self.tool, "shake", trace, "--json", "--alone", "--no-narrow", "--class", "A,B", "--"] + words]:
            done = subprocess.run(command, env=other, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                                  timeout=300)
        rows = json.loads(done.stdout)["perturbations"]
        moved = [row["name"] for row in rows if row["outcome"] not in ("same", "not_applicable")]
        if done.returncode != 1 or moved != ["environment"]:
            raise Failed(f"order: found {moved}, exit code {done.returncode}, expected environment alone")
        return f"{sum(row['outcome'] == 'same' for row in rows)} perturbations leave the order as it is"

    def plugin(self, folder, rule, expected):
        """A trace of a plug-in needs no program: the cause within the library is named, and a clean one is quiet."""
        library = os.path.join(self.programs, "librules_plugin.so")
        trace = os.path.join(folder, "game.ttr")
        self.run([self.tool, "record", rule, "--plugin", library, "--ticks", "60", "--detail", "full", "-o", trace], [0])
        words = [self.tool, "shake", trace, "--plugin", library, "--json", "--class", "A,B"] + self.options()
        report = json.loads(self.run(words, [1] if expected else [0]))
        rows = {row["name"]: row for row in report["perturbations"]}
        moved = [name for name, row in rows.items() if row["outcome"] not in ("same", "not_applicable")]
        others = [name for name in moved if name not in expected and not name.startswith("heap_")]
        if not report["repeats"] or others or not set(expected) <= set(moved) or (not expected and moved):
            raise Failed(f"plugin {rule}: found {moved}, repeats {report['repeats']}, expected {expected}")
        for name in expected:
            run = rows[name]["run"]
            if (run["tick"], run["table"], run["column"]) != (20, "units", "score"):
                raise Failed(f"plugin {rule}: {name}: found {run}, expected units.score of tick 20")
        return ", ".join(expected) or f"{report['runs']} runs"

    def documents(self):
        rows = self.run([self.tool, "shake", "--list"], [0]).splitlines()
        with open(os.path.join(SOURCE, "../../docs/causes.md"), encoding="utf-8") as file:
            text = file.read()
        for row in rows:
            kind, name, what = row.split(None, 2)
            if f"| `{name}` | {kind} | {what} |" not in text:
                raise Failed(f"docs/causes.md: found no row for {row}")
        for name, *_ in MISTAKES + BUILT:
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
    for name, rows in BUILT:
        jobs.append((name, lambda folder, n=name, r=rows: gallery.built(folder, n, r)))
        jobs.append((name + " mended", lambda folder, n=name: gallery.built_mended(folder, n)))
    jobs.append(("hints", gallery.hints))
    jobs.append(("order", gallery.order))
    jobs.append(("documents", lambda folder: gallery.documents()))
    for name in CLEAN:
        jobs.append((name + " clean", lambda folder, n=name: gallery.clean(folder, n)))
    for name, ticks in SCENES:
        jobs.append((name + " scene", lambda folder, n=name, t=ticks: gallery.scene(folder, n, t)))
    for rule, rows in PLUGIN:
        jobs.append(("plugin " + rule, lambda folder, r=rule, e=rows: gallery.plugin(folder, r, e)))
    for way, outcome, text in RUDE:
        jobs.append(("rude " + way, lambda folder, w=way, o=outcome, t=text: gallery.rude(folder, w, o, t)))
    jobs = [job for job in jobs if not only or job[0].split()[0] in only]
    failures = 0

    def work(job):
        start = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            try:
                return job[0], "ok     " + job[1](folder), time.monotonic() - start
            except Skipped as reason:
                return job[0], "skipped " + str(reason), time.monotonic() - start
            except (Failed, subprocess.TimeoutExpired, json.JSONDecodeError) as failure:
                return job[0], "FAILED " + str(failure), time.monotonic() - start

    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        for name, text, seconds in pool.map(work, jobs):
            print(f"{name:28} {seconds:5.1f} s  {text}", flush=True)
            failures += text.startswith("FAILED")
    print(f"causes named: {gallery.named} without another build, {gallery.sites} of them with the call, "
          f"{gallery.named_by_build} by --rebuild")
    print(f"clean: {len(gallery.clean_runs)} programs, {sum(gallery.clean_runs)} runs with one thing changed, "
          f"{gallery.alarms} false alarms")
    print(f"{len(jobs)} runs, {failures} failed")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
