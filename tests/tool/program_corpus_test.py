# `ticktrue corpus --command`: the parts of a program that a stored verdict depends on. No verdict is lost or wrongly
# kept.
# SPDX-License-Identifier: MIT
#
#   program_corpus_test.py TICKTRUE COMPILER INCLUDE LIBRARY_FOLDER [NAME...]
#
# A small game is built several times. Each run of the game appends a line to a file, so that the test can count runs.
import argparse
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time

GAME = r"""
#include <dlfcn.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "ticktrue.h"
extern "C" int rule(int value);
const char* volatile build = "build " BUILD;
int main(int argc, char** argv) {
  const char* runs = getenv("GAME_RUNS");
  FILE* file = runs == nullptr ? nullptr : fopen(runs, "a");
  if (file != nullptr) fprintf(file, "%s\n", build), fclose(file);
  int length = 40;
  for (int i = 1; i + 1 < argc; ++i) {
    if (strcmp(argv[i], "--load") == 0 && dlopen(argv[i + 1], RTLD_NOW) == nullptr) return 9;
    if (strcmp(argv[i], "--sleep") == 0) usleep(atoi(argv[i + 1]) * 1000);
    if (strcmp(argv[i], "--length") == 0) length = atoi(argv[i + 1]);
  }
  if (getenv("GAME_CRASHES") != nullptr) raise(SIGKILL);
  ticktrue_options options = {};
  options.struct_size = sizeof options;
  options.name = "corpus_game";
  ticktrue_session* session = ticktrue_open_arguments(&options, argc, argv);
  long long x = 0;
  ticktrue_column(session, "world", "x", &x, TICKTRUE_I64, 1, 1, 0);
  for (int tick = 0; tick < length; ++tick) {
    if (ticktrue_begin_tick(session, 0) != TICKTRUE_OK) break;
    x += rule(tick) + (tick == FAULT ? 1 : 0);
    if (ticktrue_end_tick(session) != TICKTRUE_OK) break;
  }
  return ticktrue_close(session);
}
"""
RULES = r"""
extern "C" const char* rules_build();
const char* rules_build() { return "rules " BUILD; }
extern "C" int rule(int value);
int rule(int value) { return 3 * value + 1; }
"""
MORE = 'extern "C" const char* more(); const char* more() { return "more " BUILD; }\n'
failures = 0


class Work:
    """A folder with a few traces, a program beside them, and a store."""

    def __init__(self, args, built):
        self.args, self.built = args, built
        self.folder = tempfile.mkdtemp(prefix="ticktrue_program_corpus_")
        self.runs_file = os.path.join(self.folder, "runs")
        self.game, self.rules = os.path.join(self.folder, "game"), os.path.join(self.folder, "librules.so")
        self.install("1")
        self.put("rules_1", self.rules)
        os.mkdir(os.path.join(self.folder, "traces"))
        self.count = 0

    def record(self, count):
        for _ in range(count):
            name = os.path.join(self.folder, "traces", f"t{self.count:02}.ttr")
            subprocess.run([self.game, "--length", str(20 + self.count), "--record", name], check=True,
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            self.count += 1
        return self

    def put(self, name, path):
        # A new file, because a running program cannot be overwritten.
        shutil.copy(os.path.join(self.built, name), path + ".new")
        os.rename(path + ".new", path)

    def install(self, build):
        self.put("game_" + build, self.game)

    def path(self, name):
        return os.path.join(self.folder, name)

    def environment(self, **more):
        return {**os.environ, "GAME_RUNS": self.runs_file, **more}

    def start(self, *words, **more):
        return subprocess.Popen([self.args.ticktrue, *words], cwd=self.folder, env=self.environment(**more), text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def tool(self, *words, **more):
        process = self.start(*words, **more)
        out, err = process.communicate(timeout=120)
        return process.returncode, out, err

    def verify(self, *words, command="./game --verify {}", **more):
        """Exit code, the last line, messages, and how often the program ran."""
        before = self.runs()
        code, out, err = self.tool("corpus", "verify", "traces", "--cache", "store", "--no-sync", "--command", command, *words,
                                   **more)
        return code, out.strip().split("\n")[-1], err, self.runs() - before

    def report(self, *words, command="./game --verify {}"):
        return self.tool("corpus", "report", "store", "traces", "--command", command, *words)

    def runs(self):
        try:
            with open(self.runs_file) as file:
                return len(file.readlines())
        except FileNotFoundError:
            return 0

    def verdicts(self):
        store = self.path("store")
        return sum(len(os.listdir(os.path.join(store, name))) for name in os.listdir(store) if len(name) == 2)

    def close(self):
        shutil.rmtree(self.folder)


def expect(is_right, *found):
    global failures
    if is_right:
        return
    failures += 1
    line = sys._getframe(1).f_lineno
    print(f"program_corpus_test: error: line {line}: found", *found, file=sys.stderr)


def expect_verified(work, count, verdict="match", **how):
    code, line, err, runs = work.verify(**how)
    expect(line.endswith(f": {count} {verdict}; 0 cached, {count} verified"), line, err)
    expect(runs == count, runs, line)


def expect_cached(work, count, **how):
    code, line, err, runs = work.verify(**how)
    expect(code == 0 and line.endswith(f": {count} match; {count} cached, 0 verified"), code, line, err)
    expect(runs == 0 and err == "", runs, err)


def green_is_cached(work):
    work.record(3)
    expect_verified(work, 3)
    expect_cached(work, 3)
    code, out, err = work.report()
    expect(code == 0 and "3 traces: 3 match; 3 cached" in out, code, out, err)
    code, out, err = work.tool("corpus", "report", "store", "traces")
    expect(code == 2 and "no verdict of this build" in err, code, out, err)
    # The same program in another place.
    os.mkdir(work.path("bin"))
    shutil.copy(work.game, work.path("bin/renamed"))
    shutil.copy(work.rules, work.path("bin/librules.so"))
    expect_cached(work, 3, command="bin/renamed --verify {}")
    code, line, err, runs = work.verify("--recheck", "100%")
    expect(code == 0 and runs == 3 and "3 rechecked" in line, code, line, runs)


def another_program_is_verified_anew(work):
    work.record(2)
    expect_verified(work, 2)
    work.install("2")
    expect_verified(work, 2)
    work.install("1")
    expect_cached(work, 2)
    expect_verified(work, 2, command="./game --verify {} --sleep 0")
    expect_cached(work, 2, command="./game --verify {} --sleep 0")
    work.put("rules_2", work.rules)
    expect_verified(work, 2)
    # One file that a word names, and one that an option names.
    for text in "one", "two":
        with open(work.path("settings"), "w") as file:
            file.write(text)
        expect_verified(work, 2, command="./game --verify {} --settings=settings")
        expect_cached(work, 2, command="./game --verify {} --settings=settings")
    os.mkdir(work.path("levels"))
    for text in "one", "two":
        with open(work.path("levels/first"), "w") as file:
            file.write(text)
        code, line, err, runs = work.verify("--program-file", "levels")
        expect(code == 0 and runs == 2, code, line, err, runs)
        code, line, err, runs = work.verify("--program-file", "levels")
        expect(code == 0 and runs == 0, code, line, err, runs)


def red_is_red_again(work):
    work.record(2)
    work.install("faulty")
    for _ in range(2):
        code, line, err, runs = work.verify()
        expect(code == 1 and "2 diverged; 0 cached, 2 verified" in line, code, line, err)
        expect(runs == 4, runs)  # a finding is run twice
    code, out, err = work.report()
    expect(code == 1 and "tick 10" in out, code, out, err)
    work.install("1")
    expect_verified(work, 2)
    # If a signal ended a program, the next run may succeed. The verdict is not stored, and is no conflict.
    work.install("2")
    code, line, err, runs = work.verify(GAME_CRASHES="1")
    expect(code == 1 and "2 diverged" in line, code, line, err)
    expect(work.report()[0] == 2, work.report())
    expect_verified(work, 2)
    # The same for a program that takes too long.
    words = {"command": "./game --verify {} --sleep 1500"}
    code, line, err, runs = work.verify("--timeout", "1", **words)
    expect(code == 1 and "2 diverged" in line, code, line, err)
    expect_verified(work, 2, **words)


def what_does_not_count_is_not_stored(work):
    work.record(2)
    more = {"command": "./game --verify {} --load ./libmore.so"}
    shutil.copy(os.path.join(work.built, "more_1"), work.path("libmore.so"))
    # A word of the command names the library.
    expect_verified(work, 2, **more)
    expect_cached(work, 2, **more)
    work.put("more_2", work.path("libmore.so"))
    expect_verified(work, 2, **more)
    # No word of the command names the library.
    more = {"command": f"./game --verify {{}} --load {work.folder}/./more/../libmore.so"}
    os.mkdir(work.path("more"))
    expect_verified(work, 2, **more)  # a word, if different from the entry in the folder
    loader = work.path("loader.sh")
    with open(loader, "w") as file:
        file.write('#!/bin/sh\nexec ./game --verify "$1" --load ./libmore.so\n')
    os.chmod(loader, 0o755)
    for _ in range(2):
        code, line, err, runs = work.verify(command="./loader.sh {}")
        expect(code == 0 and runs == 2 and "2 match; 0 cached, 2 verified" in line, code, line, err, runs)
        expect(err.count("verdicts are not stored") == 1, err)
        expect("--program-file " + work.game in err and "--program-file ./libmore.so" in err, err)
        expect(work.report(command="./loader.sh {}")[0] == 2, err)
    named = ["--program-file", "game", "--program-file", "libmore.so"]
    for run_count in 2, 0:
        code, line, err, runs = work.verify(*named, command="./loader.sh {}")
        expect(code == 0 and runs == run_count and "not stored" not in err, code, line, err, runs)
    with open(loader, "a") as file:
        file.write("# another script\n")
    code, line, err, runs = work.verify(*named, command="./loader.sh {}")
    expect(code == 0 and runs == 2, code, line, err, runs)
    expect(work.report(*named, command="./loader.sh {}")[0] == 0, "another report")


def a_program_that_changes_meanwhile_gives_no_verdict(work):
    work.record(4)
    for part, sleep in ("game", 700), ("rules", 701):
        command = f"./game --verify {{}} --sleep {sleep}"
        before = work.runs()
        process = work.start("corpus", "verify", "traces", "--cache", "store", "--command", command, "-j", "1")
        while work.runs() < before + 2:
            time.sleep(0.02)
        time.sleep(0.2)  # until its libraries are loaded
        work.put(part + "_2", work.game if part == "game" else work.rules)
        out, err = process.communicate(timeout=60)
        expect(process.returncode == 2 and "a file of the program changed" in err, process.returncode, out, err)
        code, out, err = work.report(command=command)
        expect(code == 2 and "4 missing" in out, code, out, err)
        work.put(part + "_1", work.game if part == "game" else work.rules)
        code, out, err = work.report(command=command)
        expect(code == 2 and "1 cached, 0 verified, 3 missing" in out, code, out, err)


def a_killed_worker_loses_nothing(work):
    work.record(12)
    words = {"command": "./game --verify {} --sleep 300"}
    call = ["corpus", "verify", "traces", "--cache", "store", "--no-sync", "--command", words["command"], "--claim", "--lease", "1",
            "-j", "1"]
    workers = [work.start(*call) for _ in range(3)]
    while work.runs() < 4:
        time.sleep(0.02)
    workers[0].send_signal(signal.SIGKILL)
    outs = [worker.communicate(timeout=60) for worker in workers]
    for worker, (out, err) in list(zip(workers, outs))[1:]:
        expect(worker.returncode == 0 and "12 traces: 12 match" in out, worker.returncode, out, err)
    expect(12 <= work.runs() <= 14, work.runs())
    expect(work.verdicts() == 12, work.verdicts())
    code, out, err = work.report(**words)
    expect(code == 0 and "12 match; 12 cached" in out, code, out, err)
    expect_cached(work, 12, **words)
    # No worker has a claim.
    left = [name for _, _, names in os.walk(work.path("store/claims")) for name in names]
    expect(not left, left)


def shards_and_slurm_share_the_work(work):
    work.record(5)
    for shard in "1/2", "2/2":
        code, line, err, runs = work.verify("--shard", shard)
        expect(code == 0 and 0 < runs < 5, code, line, err, runs)
    expect_cached(work, 5)
    time.sleep(1.1)  # the log is ordered by seconds
    work.install("2")
    code, script, err = work.tool("corpus", "slurm", "traces", "--cache", "store", "--command", "./game --verify {}",
                                  "--program-file", "traces/../librules.so", "--program-commit", "f00d", "--timeout", "77")
    expect(code == 0 and "--timeout 77" in script, code, script, err)
    with open(work.path("job.sh"), "w") as file:
        file.write(script)
    before = work.runs()
    for word in "worker", "worker", "report":
        done = subprocess.run(["sh", work.path("job.sh"), word], cwd="/", env=work.environment(), capture_output=True, text=True)
        expect(done.returncode == 0 and "5 traces: 5 match" in done.stdout, word, done.returncode, done.stdout, done.stderr)
    expect(work.runs() == before + 5, work.runs() - before)
    time.sleep(1.1)
    work.install("faulty")
    expect(work.verify("--program-commit", "bad1")[0] == 1, "another exit code")
    code, out, err = work.tool("corpus", "log", "traces/t00.ttr", "--cache", "store")
    expect(code == 0 and "3 verdicts in store" in out, code, out, err)
    expect("first changed by commit bad1" in out and "last match before it: commit f00d" in out, out)


def words_that_are_refused(work):
    work.record(1)
    for words, message in [
        (["--command", "./no_game {}"], "./no_game: found no such program"),
        (["--command", "./game {} | cat"], "found | outside of quotes"),
        (["--command", "./game", "--mode", "twice"], "--mode: found it with --command"),
        (["--command", "./game", "--program-file", "nowhere"], "nowhere: found no such file or folder"),
        (["--program-file", "game"], "--program-file: found no --command"),
        (["--command", "./game", "--program-commit", "a b"], "--program-commit: expected"),
    ]:
        code, out, err = work.tool("corpus", "verify", "traces", "--cache", "store", *words)
        expect(code == 2 and message in err, words, code, out, err)
    os.remove(work.rules)
    code, line, err, runs = work.verify()
    expect(code == 2 and "librules.so" in err and runs == 0, code, line, err, runs)


def build(args, folder):
    def compile(name, source, *words):
        path = os.path.join(folder, name)
        with open(path + ".cpp", "w") as out:
            out.write(source)
        subprocess.run([args.compiler, "-O1", "-I", args.include, path + ".cpp", "-o", path, *words], check=True)

    for number in "1", "2":
        compile("rules_" + number, RULES, f'-DBUILD="{number}"', "-shared", "-fPIC", "-Wl,-soname,librules.so")
        compile("more_" + number, MORE, f'-DBUILD="{number}"', "-shared", "-fPIC")
    shutil.copy(os.path.join(folder, "rules_1"), os.path.join(folder, "librules.so"))
    for name, fault in ("1", -1), ("2", -1), ("faulty", 10):
        compile("game_" + name, GAME, f'-DBUILD="{name}"', f"-DFAULT={fault}", "-L", folder, "-lrules", "-L", args.library,
                "-lticktrue", "-ldl", "-Wl,-rpath,$ORIGIN:" + args.library)


def main():
    parser = argparse.ArgumentParser()
    for name in "ticktrue", "compiler", "include", "library":
        parser.add_argument(name)
    parser.add_argument("names", nargs="*")
    args = parser.parse_args()
    tests = [green_is_cached, another_program_is_verified_anew, red_is_red_again, what_does_not_count_is_not_stored,
             a_program_that_changes_meanwhile_gives_no_verdict, a_killed_worker_loses_nothing, shards_and_slurm_share_the_work,
             words_that_are_refused]
    with tempfile.TemporaryDirectory(prefix="ticktrue_program_corpus_") as built:
        build(args, built)
        for test in tests:
            if args.names and test.__name__ not in args.names:
                continue
            work = Work(args, built)
            begin = time.monotonic()
            test(work)
            print(f"{test.__name__}: {time.monotonic() - begin:.1f} s", flush=True)
            work.close()
    if failures:
        sys.exit(f"program_corpus_test: error: {failures} expectations failed")


main()
