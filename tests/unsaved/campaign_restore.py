# Runs `ticktrue campaign --restore` on programs whose save omits a variable, and on clean programs.
# SPDX-License-Identifier: MIT
#
#   campaign_restore.py TICKTRUE FOLDER_OF_PROGRAMS
#
# Each program verifies its trace in one run without a finding. Only a run from a save shows what the save omits.
import json
import os
import subprocess
import sys
import tempfile

PLANTED = ["global", "heap_pointer", "vector_growth", "map", "thread_local"]
CLEAN = ["plain", "pure_cache", "containers"]
SEEDS = 2


def campaign(tool, folder, name, record, verify, *more):
    words = [tool, "campaign", "--command", record + " --record {trace} --seed {seed}", "--verify", verify, "--seeds",
             f"1..{SEEDS}", "--out", os.path.join(folder, name), "--json", *more]
    done = subprocess.run(words, capture_output=True, text=True, cwd=folder)
    return done.returncode, json.loads(done.stdout)


def verdicts(found):
    return [row["verdict"] for row in found["rows"]]


def main():
    tool, programs = sys.argv[1], sys.argv[2]
    failures = []

    def expect(what, found, expected):
        if found != expected:
            failures.append(f"{what}: found {found}, expected {expected}")

    with tempfile.TemporaryDirectory() as folder:
        for kind, names in (("planted", PLANTED), ("clean", CLEAN)):
            for name in names:
                program = f"{programs}/unsaved_{kind} {name}"
                verify = program + " --verify {trace}"
                code, found = campaign(tool, folder, name, program, verify)
                expect(f"{name}: exit code", code, 0)
                expect(name, verdicts(found), ["match"] * SEEDS)
                code, found = campaign(tool, folder, name, program, verify, "--restore")
                expect(f"{name} --restore: judged before", found["rows"][0]["judged_before"], False)
                if kind == "clean":
                    expect(f"{name} --restore: exit code", code, 0)
                    expect(f"{name} --restore", verdicts(found), ["match"] * SEEDS)
                    continue
                expect(f"{name} --restore: exit code", code, 1)
                expect(f"{name} --restore", verdicts(found), ["state_incomplete"] * SEEDS)
                for row in found["rows"]:
                    expect(f"{name} --restore: place", (row["table"], row["column"]), ("units", "x"))
                    again = subprocess.run(["sh", "-c", row["again"].replace("ticktrue", tool, 1)], capture_output=True,
                                           text=True, cwd=folder)
                    expect(f"{name} --restore: exit code of `again`", again.returncode, 1)

        # A session that ignores the words was not verified from its saves.
        script = os.path.join(folder, "verify.sh")
        with open(script, "w") as out:
            out.write(f'exec "{programs}/unsaved_clean" plain --verify "$1"\n')
        code, found = campaign(tool, folder, "deaf", f"{programs}/unsaved_clean plain", f"sh {script} {{trace}}",
                               "--restore")
        expect("without the words: exit code", code, 3)
        expect("without the words", verdicts(found), ["incomplete"] * SEEDS)
        expect("without the words: reason", "did not take the words --mode restore" in found["rows"][0]["reason"], True)

        # A trace without saves has no place to start from.
        program = f"{programs}/unsaved_clean without_saves"
        code, found = campaign(tool, folder, "without", program, program + " --verify {trace}", "--restore")
        expect("without saves", (code, verdicts(found)), (0, ["match"] * SEEDS))

    for failure in failures:
        print(failure)
    print(f"{len(PLANTED)} programs that forget a variable, {len(CLEAN)} clean ones: {len(failures)} failures")
    return 1 if failures else 0


sys.exit(main())
