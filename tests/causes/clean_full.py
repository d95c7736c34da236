# Runs `ticktrue shake` on every clean program of the gallery, with each perturbation of class A separately. A stopped
# run can be continued.
# SPDX-License-Identifier: MIT
#
#   clean_full.py TICKTRUE PROGRAMS LIBRARY RESULTS [NAME...]
#
# TICKTRUE, PROGRAMS and LIBRARY are as in causes_test.py. RESULTS is a file with a line for each program: the digest of
# tool, library and program, the name, the verdict, the number of perturbed runs, and seconds. A program with a line for
# its digest does not run again. Exit code 1: an alarm, or a program that could not run.
import hashlib
import json
import os
import subprocess
import sys
import tempfile
import time

from causes_test import CLEAN, SCENES, Failed, Gallery, Skipped

TIME_MAX_S = 7200  # of one program; the machine may have other work


def digest_of(paths):
    digest = hashlib.sha256()
    for path in paths:
        with open(path, "rb") as file:
            digest.update(hashlib.sha256(file.read()).digest())
    return digest.hexdigest()[:16]


def read_results(path):
    rows = {}
    if os.path.exists(path):
        with open(path, encoding="utf-8") as file:
            for line in file:
                cells = line.rstrip("\n").split("\t")
                if len(cells) == 5:
                    rows[cells[1]] = cells
    return rows


def run(gallery, name, ticks):
    """Verdict and number of changed runs."""
    count = len(gallery.clean_runs)
    try:
        with tempfile.TemporaryDirectory() as folder:
            if ticks:
                gallery.scene(folder, name, ticks)
            else:
                gallery.clean(folder, name)
        verdict = "quiet"
    except Skipped as reason:
        verdict = f"skipped: {reason}"
    except (Failed, subprocess.TimeoutExpired, json.JSONDecodeError) as failure:
        verdict = "FAILED: " + " ".join(str(failure).split())[:2000]
    return verdict, sum(gallery.clean_runs[count:])


def main():
    if len(sys.argv) < 5:
        print("usage: clean_full.py TICKTRUE PROGRAMS LIBRARY RESULTS [NAME...]", file=sys.stderr)
        return 2
    tool, programs, library, results = sys.argv[1:5]
    gallery = Gallery(tool, programs, library, True)
    gallery.time_max_s = TIME_MAX_S
    source = os.path.join(os.path.dirname(os.path.abspath(__file__)), "clean")
    names = [(name, 0) for name in CLEAN] + SCENES
    names = [(name, ticks) for name, ticks in names if not sys.argv[5:] or name in sys.argv[5:]]
    rows = read_results(results)
    for name, ticks in names:
        parts = [tool, library, os.path.join(source if name.endswith(".py") else programs, name)]
        digest = digest_of([part for part in parts if os.path.isfile(part)])
        if name not in rows or rows[name][0] != digest:
            start = time.monotonic()
            verdict, changed = run(gallery, name, ticks)
            rows[name] = [digest, name, verdict, str(changed), f"{time.monotonic() - start:.0f}"]
            with open(results, "a", encoding="utf-8") as file:
                file.write("\t".join(rows[name]) + "\n")
        print(f"{name:24} {rows[name][3]:>4} changed runs  {rows[name][4]:>5} s  {rows[name][2]}", flush=True)
    mine = [rows[name] for name, _ in names]
    quiet = [row for row in mine if row[2] == "quiet"]
    failed = sum(row[2].startswith("FAILED") for row in mine)
    print(f"{len(mine)} programs, {len(quiet)} quiet in {sum(int(row[3]) for row in quiet)} changed runs, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
