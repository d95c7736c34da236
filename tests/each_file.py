# Parses each source file of a build separately. A unity build hides missing includes and colliding names.
# SPDX-License-Identifier: MIT
#
#   each_file.py BUILD [--only WORD] [--newest N] [-j N]
#
# BUILD was configured without unity and has compile_commands.json. A file that is compiled several times, for example
# for each precision, is parsed once. Precompiled headers are disabled, because they also hide missing includes. Exit
# code 1: a file failed.
import argparse
import concurrent.futures
import json
import os
import resource
import shlex
import subprocess
import sys
import time

LEFT_OUT = {"-c": 1, "-o": 2, "-Winvalid-pch": 1}  # options to remove, with the number of words of each


def syntax_command(command):
    words, left = [], 0
    parts = shlex.split(command)
    for i, word in enumerate(parts):
        if left == 0 and word == "-include" and "cmake_pch" in parts[i + 1]:
            left = 2
        left = left or LEFT_OUT.get(word, 0)
        if left > 0:
            left -= 1
            continue
        words.append(word)
    return words + ["-fsyntax-only"]


def parse(entry):
    done = subprocess.run(syntax_command(entry["command"]), cwd=entry["directory"], capture_output=True, text=True)
    return entry["file"], done.returncode, done.stdout + done.stderr


def newest_sources(count):
    """The sources that git changed last."""
    log = subprocess.run(["git", "log", "-n", "300", "--format=", "--name-only", "--diff-filter=AMR"],
                         capture_output=True, text=True, check=True)
    return list(dict.fromkeys(name for name in log.stdout.split("\n") if name.endswith(".cpp")))[:count]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build")
    parser.add_argument("--only", default="", help="files with this word in their path")
    parser.add_argument("--newest", type=int, metavar="N", help="the N sources of this folder that git changed last")
    parser.add_argument("-j", type=int, default=os.cpu_count())
    args = parser.parse_args()
    with open(os.path.join(args.build, "compile_commands.json")) as file:
        entries = {entry["file"]: entry for entry in json.load(file) if args.only in entry["file"]}
    if args.newest:
        newest = {os.path.realpath(name) for name in newest_sources(args.newest)}
        entries = {path: entry for path, entry in entries.items() if os.path.realpath(path) in newest}
    generated = [path for path in entries if path.startswith(os.path.realpath(args.build) + os.sep)]
    for path in generated:
        del entries[path]
    if not entries:
        print(f"each_file: error: {args.build}: found no file with '{args.only}' in its path")
        return 2
    start = time.time()
    failed = []
    with concurrent.futures.ThreadPoolExecutor(args.j) as pool:
        for number, (path, code, text) in enumerate(pool.map(parse, entries.values()), 1):
            if code != 0 or text:
                print(f"{path}\n{text}", flush=True)
            if code != 0:
                failed.append(path)
            if number % 100 == 0:
                print(f"each_file: {number} of {len(entries)}", flush=True)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    for path in failed:
        print(f"each_file: error: {path}: does not compile by itself")
    print(f"each_file: {len(entries)} files, {len(failed)} failed, {len(generated)} generated ones left out, "
          f"{time.time() - start:.0f} s, {used.ru_utime + used.ru_stime:.0f} s of processor time")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
