#!/usr/bin/env python3
"""Compares the run time of two builds of ticktrue, scene by scene: interleaved pairs, or instructions under callgrind.

Each pair runs the first build, then the second. The ratio of a scene is the median of the ratios of its pairs. Instructions
are those of the later ticks alone: the run with fewer ticks is subtracted. Hashes tell whether the physics is the same.
"""
# SPDX-License-Identifier: MIT
import argparse
import os
import re
import statistics
import subprocess
import sys
import tempfile

# scene, ticks of a timed run, ticks of the two runs under callgrind
SCENES = (
    ('large_pyramid?substeps=4', 150, 20, 60), ('many_pyramids?rows=7&columns=11&substeps=4', 150, 20, 60), ('tumbler', 300, 150, 200),
    ('joint_grid', 100, 10, 30), ('smash', 60, 20, 35), ('rain', 60, 10, 30), ('gas', 200, 20, 120), ('loose?substeps=4', 200, 20, 120),
    ('spinner', 50, 10, 20), ('thesis_mix?bodies=150', 800, 100, 400), ('thesis_mix?bodies=1000', 300, 100, 200),
    ('mixed_pile?bodies=500&substeps=4', 400, 200, 300), ('shapes?substeps=4', 600, 100, 400), ('stack?boxes=20&substeps=4', 1000, 100, 600),
    ('chain?links=50&substeps=4', 800, 100, 500), ('card_house?substeps=4', 500, 100, 300),
)


def run_scene(tool, scene, ticks, threads, prefix=()):
    """(median ms of a tick, hash)"""
    command = [*prefix, tool, 'run', scene, '--ticks', str(ticks)]
    if threads > 1:
        command += ['--threads', str(threads)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    time = re.search(r'([\d.]+) ms/tick \(median\)', done.stdout)
    state = re.search(r'hash\s+(\w+)', done.stdout)
    if done.returncode != 0 or not time or not state:
        raise RuntimeError(f"{' '.join(command)}: exit {done.returncode}: {(done.stderr or done.stdout).strip()[:200]}")
    return float(time.group(1)), state.group(1)


def timed_ratio(tools, scene, ticks, threads, pairs):
    ratios, hashes = [], set()
    for _ in range(pairs):
        (old, old_hash), (new, new_hash) = (run_scene(tool, scene, ticks, threads) for tool in tools)
        ratios.append(new / old)
        hashes |= {old_hash, new_hash}
    return statistics.median(ratios), len(hashes) == 1


def instructions(tool, scene, ticks):
    with tempfile.TemporaryDirectory() as folder:
        counts = os.path.join(folder, 'counts')
        prefix = ('valgrind', '--tool=callgrind', f'--callgrind-out-file={counts}')
        state = run_scene(tool, scene, ticks, 1, prefix)[1]
        with open(counts) as file:
            return int(re.search(r'^(?:totals|summary): (\d+)', file.read(), re.MULTILINE).group(1)), state


def counted_ratio(tools, scene, few, many):
    counts, hashes = [], set()
    for tool in tools:
        (before, _), (after, state) = instructions(tool, scene, few), instructions(tool, scene, many)
        counts.append(after - before)
        hashes.add(state)
    return counts[1] / counts[0], len(hashes) == 1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('old', help='program ticktrue of the build to compare with')
    parser.add_argument('new', help='program ticktrue of the build to be judged')
    parser.add_argument('--pairs', type=int, default=15, help='timed runs of each build (default 15)')
    parser.add_argument('--threads', type=int, default=1, help='of a timed run')
    parser.add_argument('--callgrind', action='store_true', help='count instructions on one thread instead of measuring time')
    parser.add_argument('--scenes', nargs='*', help='these alone')
    parser.add_argument('--limit', type=float, default=0, help='exit 1 if a ratio is above it; 0: none')
    options = parser.parse_args()
    tools = (options.old, options.new)
    what = 'instructions' if options.callgrind else f'time, {options.threads} thread(s), {options.pairs} pairs'
    print(f"{'scene':32}  {'new / old':>9}  physics      {what}", flush=True)
    ratios = []
    for scene, ticks, few, many in SCENES:
        if options.scenes and scene not in options.scenes:
            continue
        if options.callgrind:
            ratio, is_same = counted_ratio(tools, scene, few, many)
        else:
            ratio, is_same = timed_ratio(tools, scene, ticks, options.threads, options.pairs)
        ratios.append(ratio)
        print(f"{scene:32}  {ratio:9.3f}  {'same hash' if is_same else 'other hash'}", flush=True)
    if not ratios:
        sys.exit('compare_builds: error: --scenes: no such scene')
    print(f"{'median':32}  {statistics.median(ratios):9.3f}\n{'greatest':32}  {max(ratios):9.3f}")
    return 1 if options.limit and max(ratios) > options.limit else 0


if __name__ == '__main__':
    sys.exit(main())
