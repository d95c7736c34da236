#!/usr/bin/env python3
"""Observables of short runs of scenes that are not chaotic, as lines `scene column value ...`.

usage: observables.py TOOL               prints them
       observables.py TOOL FILE          exits 1 if one differs from those in FILE by at least 1 %, and names it; 0 otherwise
A column differs if a value moves by 1 % of the largest magnitude that the column has in the run.
"""
# SPDX-License-Identifier: MIT
import os
import subprocess
import sys
import tempfile

TICKS = 180
EVERY = 20
SHARE = 0.01
LEAST = {'overlap': 1e-5, 'joint_gap': 1e-5}  # magnitudes below count as this, m; of other columns: 1e-3
SCENES = (
    'stack?boxes=6', 'stack?boxes=5&substeps=4', 'stack?boxes=4&solver=pgs', 'pyramid?base=5&substeps=4', 'slide?speed=4',
    'slide?speed=4&integrator=rk4&substeps=4', 'projectile', 'projectile?integrator=velocity_verlet', 'pendulum',
    'pendulum?integrator=rk4', 'pendulum?integrator=position_verlet', 'pendulum?solver=pgs', 'pendulum?substeps=auto',
    'chain?links=6&angle=1', 'chain?links=6&angle=1&substeps=4', 'bridge?planks=8', 'bridge?planks=8&substeps=auto',
    'joint_grid?columns=6', 'card_house?tents=2', 'billiards?speed=2', 'scenes/gears.json', 'scenes/pulley.json', 'scenes/car.json',
    'scenes/friction_ramp.json', 'scenes/bounce.json', 'scenes/pusher.json', 'scenes/compounds.json',
)
COLUMNS = 'energy,kinetic,overlap,joint_gap,speed_max,bodies.*.x,bodies.*.y,bodies.*.angle'


def observables(tool):
    """{(scene, column): values}; a run that fails has none"""
    found = {}
    root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    with tempfile.TemporaryDirectory() as folder:
        trace = os.path.join(folder, 'a.ttr')
        for scene in SCENES:
            place = os.path.join(root, scene) if scene.endswith('.json') else scene
            subprocess.run([tool, 'record', place, '--ticks', str(TICKS), '-o', trace, '--force'], capture_output=True, timeout=60)
            table = subprocess.run([tool, 'replay', trace, '--every', str(EVERY), '--format', 'csv', '--columns', COLUMNS],
                                   capture_output=True, text=True, timeout=60)
            lines = [line.split(',') for line in table.stdout.splitlines()]
            for number, column in enumerate(lines[0] if lines else []):
                found[scene, column] = [line[number] for line in lines[1:]]
    return found


def read(path):
    found = {}
    with open(path) as lines:
        for line in lines:
            scene, column, *values = line.rstrip('\n').split('\t')
            found[scene, column] = values
    return found


def moved(before, after):
    """The first column that differs, or nothing."""
    for key, values in before.items():
        others = after.get(key)
        if others is None or len(others) != len(values):
            return '%s %s: no value' % key
        largest = max([LEAST.get(key[1], 1e-3)] + [abs(float(value)) for value in values])
        for value, other in zip(values, others):
            if not abs(float(value) - float(other)) <= SHARE * largest:
                return '%s %s: %s, %s before' % (*key, other, value)
    return None


def main():
    found = observables(sys.argv[1])
    if len(sys.argv) < 3:
        for (scene, column), values in found.items():
            print('\t'.join([scene, column, *values]))
        return 0
    difference = moved(read(sys.argv[2]), found)
    if difference:
        print('moved: ' + difference)
    return 1 if difference else 0


if __name__ == '__main__':
    sys.exit(main())
