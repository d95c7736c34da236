# Runs the `again` lines of `ticktrue reduce` that need a tool or a plug-in with a planted fault.
# SPDX-License-Identifier: MIT
#
#   again_test.py TICKTRUE PLANTED_TOOL COUNTING_PLUGIN
#
# A printed command runs unchanged, in a shell that finds the planted tool as `ticktrue`, and shows the same failure.
# With the real tool, the same command finds nothing. tests/cli/cases/reduce.case tests the other options of reduce.
import argparse
import os
import re
import subprocess
import sys
import tempfile

SCENE = """{"name":"pushed","settings":{"events":true},"bodies":[
{"type":"static","shapes":[{"type":"box","half_size":[20,0.5]}]},
{"name":"fast","position":[3,0.8],"shapes":[{"type":"circle","radius":0.3}]},
{"position":[-3,1],"shapes":[{"type":"box","half_size":[0.5,0.5]}]},
{"position":[-3,2],"shapes":[{"type":"box","half_size":[0.5,0.5]}]}],"inputs":["impulse"]}
"""
PUSHES = """{"tick":2,"kind":"impulse","body":2,"ix":0.1}
{"tick":9,"kind":"impulse","body":1,"ix":1.4}
{"tick":11,"kind":"impulse","body":3,"ix":0.1}
"""
COUNTS = """{"tick":1,"bytes":"05"}
{"tick":4,"bytes":"0109"}
{"tick":7,"bytes":"02"}
"""


class Failed(Exception):
    pass


def write(folder, name, text):
    with open(os.path.join(folder, name), "w") as file:
        file.write(text)


def shell(folder, tools, command, code, environment=None):
    """Runs a command with `ticktrue` from the folder `tools`. Gives what it printed."""
    path = os.path.join(folder, tools) + os.pathsep + os.environ["PATH"]
    done = subprocess.run(["sh", "-c", command], cwd=os.path.join(folder, "work"), stdin=subprocess.DEVNULL,
                          env={**os.environ, "PATH": path, **(environment or {})}, capture_output=True, text=True)
    if done.returncode != code:
        raise Failed(f"{tools}: {command}: exit code {done.returncode}, expected {code}: {done.stdout}{done.stderr}")
    return done.stdout


def expect(text, *pieces):
    for piece in pieces:
        if piece not in text:
            raise Failed(f"found {text}, expected {piece}")


def again_of(text):
    found = re.findall(r"^  again +(.*)$", text, re.M)
    if len(found) != 1:
        raise Failed(f"found {text}, expected one line `again`")
    return found[0]


def check_caches(folder, words, kind):
    """A cached structure that is used too long: `--check-caches` and `--check`."""
    out = "of " + kind
    text = shell(folder, "planted", f"ticktrue reduce pushed.json --inputs pushed.jsonl --ticks 20 {words} -o '{out}'", 0)
    expect(text, f"{kind}  tick 0", "bodies   4 -> 1", "start    the state before tick")
    again = again_of(text)
    expect(again, f"ticktrue reduce '{out}/scene.json' ", f" {words} --once")
    expect(shell(folder, "planted", again, 1), f"{kind}  tick 0")
    expect(shell(folder, "whole", again, 0), "holds")
    shell(folder, "planted", f"'{out}/test.sh'", 1)
    shell(folder, "whole", f"'{out}/test.sh'", 0)


def check_plugin(folder, plugin):
    """A session of a plug-in, judged by another build of it."""
    command = f"COUNTING_FAULT=1 ticktrue --plugin {plugin} verify {{}}"
    shell(folder, "whole", f"ticktrue record --plugin {plugin} - --inputs counts.jsonl --ticks 12 -o counts.ttr", 0)
    text = shell(folder, "whole",
                 f"ticktrue --plugin {plugin} reduce counts.ttr --command '{command} --json' -o 'of a plug-in'", 0)
    expect(text, "diverged  tick 0  counts.total", "inputs   3 -> 1", "ticks    12 -> 1")
    again = again_of(text)
    expect(again, command.replace("{}", "'of a plug-in/trace.ttr'"))
    expect(shell(folder, "whole", again, 1), '"verdict": "diverged"', '"column": "total"')
    expect(shell(folder, "whole", again.replace("COUNTING_FAULT=1 ", ""), 0), '"verdict": "match"')
    # The session without the miscounted byte.
    shell(folder, "whole", f"sed 's/09/08/' 'of a plug-in/inputs.jsonl' > mended.jsonl && ticktrue record "
          f"--plugin {plugin} - --inputs mended.jsonl --ticks 1 -o mended.ttr", 0)
    shell(folder, "whole", command.replace("{}", "mended.ttr"), 0)


def main():
    parser = argparse.ArgumentParser()
    for name in ["ticktrue", "planted", "plugin"]:
        parser.add_argument(name)
    args = parser.parse_args()
    faults = 0
    with tempfile.TemporaryDirectory() as folder:
        for name, tool in [("whole", args.ticktrue), ("planted", args.planted)]:
            os.mkdir(os.path.join(folder, name))
            os.symlink(os.path.abspath(tool), os.path.join(folder, name, "ticktrue"))
        os.mkdir(os.path.join(folder, "work"))
        write(folder, "work/pushed.json", SCENE)
        write(folder, "work/pushed.jsonl", PUSHES)
        write(folder, "work/counts.jsonl", COUNTS)
        for check, words in [(check_caches, ("--check-caches", "stale_cache")), (check_caches, ("--check cold", "cold")),
                             (check_plugin, (os.path.abspath(args.plugin),))]:
            try:
                check(folder, *words)
            except Failed as fault:
                faults += 1
                print(f"again_test: error: {words[0]}: {fault}")
    print(f"again_test: 3 ways to fail, {faults} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
