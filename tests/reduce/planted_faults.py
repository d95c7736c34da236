# Plants faults in sessions of a thousand bodies, reduces the sessions, and checks the results. Prints a line for each,
# and medians.
# SPDX-License-Identifier: MIT
#
#   planted_faults.py TICKTRUE [--broken PROGRAM] [--bodies N] [--only WORD] [--keep FOLDER] [--limits]
#
# broken_build.py builds PROGRAM. Without PROGRAM, faults are only planted in scenes: values that are not finite, and
# broken expectations. A result counts if its command shows the failure in the same stage, table and column as the whole
# session, and passes without the planted fault. --limits: exit code 1 if a median exceeds its goal.
import argparse
import copy
import json
import os
import random
import statistics
import subprocess
import sys
import tempfile

import broken_build

TICKS = 600
INPUT_COUNT = 180
GOALS = {"bodies": 8, "inputs %": 5, "seconds": 60, "bytes": 10_000}


def shape_of(rng):
    kind = rng.random()
    if kind < 0.55:
        return {"type": "box", "half_size": [0.4, 0.3]}
    if kind < 0.8:
        return {"type": "circle", "radius": round(rng.uniform(0.3, 0.45), 3)}
    return {"type": "polygon", "vertices": [[-0.4, -0.3], [0.4, -0.3], [0.1, 0.4]]}


def pair_of_bodies(scene, name, x, y):
    for i in range(2):
        scene["bodies"].append({"name": f"{name}_{i}", "position": [x + i, y],
                                "shapes": [{"type": "box", "half_size": [0.3, 0.3]}]})


def session_of(seed, body_count):
    """A pile that falls on a floor, with some joints and forces beside it, and pushes of a person."""
    rng = random.Random(seed)
    scene = {"name": "pile", "settings": {"precision": "f32"}, "gravity": [0, -10],
             "bodies": [{"name": "floor", "type": "static", "position": [0, -1],
                         "shapes": [{"type": "box", "half_size": [80, 1]}]}],
             "joints": [], "forces": [], "inputs": ["spawn", "impulse", "force", "set_velocity"],
             "prototypes": [{"name": "stone", "shapes": [{"type": "box", "half_size": [0.4, 0.4]}]}]}
    for i in range(6):
        pair_of_bodies(scene, f"rod_{i}", -60 + 3 * i, 2)
        scene["joints"].append({"type": "distance", "body_a": f"rod_{i}_0", "body_b": f"rod_{i}_1", "length": 1.0})
        pair_of_bodies(scene, f"spring_{i}", 40 + 3 * i, 2)
        scene["forces"].append({"type": "spring", "body": f"spring_{i}_0", "other": f"spring_{i}_1", "stiffness": 50,
                                "rest_length": 1.3})
    scene["bodies"].append({"name": "leaf", "position": [60, 8], "shapes": [{"type": "circle", "radius": 0.4}]})
    scene["forces"].append({"type": "quadratic_drag", "body": "leaf", "coefficient": 0.4})
    columns = 45
    left = body_count - len(scene["bodies"])
    for i in range(left):
        x = (i % columns - columns / 2) * 1.1 + rng.uniform(-0.05, 0.05)
        scene["bodies"].append({"name": f"stone_{i}", "position": [round(x, 4), round(0.6 + (i // columns) * 1.0, 4)],
                                "angle": round(rng.uniform(-0.3, 0.3), 4), "shapes": [shape_of(rng)]})
    inputs = []
    for tick in sorted(rng.randrange(TICKS) for _ in range(INPUT_COUNT)):
        inputs.append({"tick": tick, "kind": "impulse", "body": rng.randrange(1, len(scene["bodies"])),
                       "ix": round(rng.uniform(-2, 2), 3), "iy": round(rng.uniform(0, 2), 3)})
    return scene, inputs, rng


class Fault:
    """A session with its fault, the option that asks for it, and the same session with the fault taken out."""

    def __init__(self, name, scene, inputs, words, mend=None, planted=None):
        self.name, self.scene, self.inputs, self.words = name, scene, inputs, words
        self.mend, self.planted = mend, planted


def add_input(inputs, **values):
    inputs.append(values)
    inputs.sort(key=lambda one: one["tick"])


def without_planted(scene, inputs):
    for part in ("forces", "joints"):
        scene[part] = [one for one in scene.get(part, []) if not one.get("name", "").startswith("planted")]
    for body in scene["bodies"]:
        if body.get("name", "").startswith("planted"):
            for shape in body["shapes"]:
                shape.pop("tangent_speed", None)
    return scene, []


def without_inputs(scene, inputs):
    return scene, []


def stones_of(scene):
    """How many bodies of the pile faults are planted on."""
    return min(300, sum(body.get("name", "").startswith("stone_") for body in scene["bodies"]))


def planted_body(scene, rng, radius=0.4, name="planted", y=None):
    index = len(scene["bodies"])
    x = rng.uniform(-20, 20)
    scene["bodies"].append({"name": name, "position": [round(x, 3), y or 30 + rng.uniform(0, 4)],
                            "shapes": [{"type": "circle", "radius": radius}]})
    return index


def not_finite(i, body_count):
    scene, inputs, rng = session_of(100 + i, body_count)
    kind = i % 5
    mend = without_planted
    if kind == 0:  # a repelling force that grows with the distance
        body = planted_body(scene, rng)
        center = [scene["bodies"][body]["position"][0] + 0.5, 10]
        scene["forces"].append({"name": "planted", "type": "central", "body": "planted", "center": center,
                                "coefficient": -(0.002 + 0.001 * i), "exponent": 3})
    elif kind == 1:  # a spring that is far too stiff for a tick, on a body of the pile
        stone = f"stone_{rng.randrange(stones_of(scene))}"
        scene["forces"].append({"name": "planted", "type": "spring", "body": stone, "stiffness": 1e10 * (1 + i),
                                "point": [rng.uniform(-20, 20), 5.0], "rest_length": 1})
    elif kind == 2:  # a push that no float can hold
        feather = planted_body(scene, rng, radius=0.0001)
        scene["bodies"][feather]["shapes"][0]["density"] = 3.5e-8
        add_input(inputs, tick=rng.randrange(50, 500), kind="impulse", body=feather, ix=1e24, iy=0, px=3, py=2)
        mend = without_inputs
    elif kind == 3:  # a spring between two bodies of the pile
        a, b = rng.sample(range(stones_of(scene)), 2)
        scene["forces"].append({"name": "planted", "type": "spring", "body": f"stone_{a}", "other": f"stone_{b}",
                                "stiffness": 1e12, "rest_length": 0.5})
    else:  # a force that kicks one tick long
        feather = planted_body(scene, rng, radius=0.0001)
        scene["bodies"][feather]["shapes"][0]["density"] = 3.5e-8
        add_input(inputs, tick=rng.randrange(50, 500), kind="force", body=feather, fx=1e24, fy=-1e24)
        mend = without_inputs
    return Fault(f"not_finite_{i}", scene, inputs, ["--not-finite"], mend)


def energy(i, body_count):
    scene, inputs, rng = session_of(200 + i, body_count)
    kind = i % 6
    expect, mend = "speed_max < 60", without_planted
    if kind == 0:
        stone = f"stone_{rng.randrange(stones_of(scene))}"
        scene["forces"].append({"name": "planted", "type": "spring", "body": stone, "stiffness": 3e5 * (1 + i),
                                "point": [rng.uniform(-20, 20), 25.0], "rest_length": 1})
    elif kind == 1:
        body = planted_body(scene, rng)
        scene["bodies"][body]["shapes"] = [{"type": "box", "half_size": [3, 0.2]}]
        scene["joints"].append({"name": "planted", "type": "revolute", "body_a": "floor", "body_b": "planted",
                                "anchor_a": [scene["bodies"][body]["position"][0],
                                             scene["bodies"][body]["position"][1] + 1],
                                "motor": {"speed": 90, "force_max": 1e6}})
        expect = "kinetic < 2e4"
    elif kind == 2:
        scene["bodies"].append({"name": "planted", "type": "static", "position": [rng.uniform(-15, 15), 0.0],
                                "shapes": [{"type": "box", "half_size": [1, 0.2], "friction": 5,
                                            "tangent_speed": 300}]})
        expect = "speed_max < 25"
    elif kind == 3:
        a, b = rng.sample(range(stones_of(scene)), 2)
        scene["joints"].append({"name": "planted_1", "type": "distance", "body_a": f"stone_{a}",
                                "body_b": f"stone_{b}", "length": 1.0})
        scene["joints"].append({"name": "planted_2", "type": "distance", "body_a": f"stone_{a}",
                                "body_b": f"stone_{b}", "length": 4.0})
        expect = "joint_gap < joint_gap_start + 0.5"
        scene["joints"][-1]["anchor_a"] = [30, 0]
    elif kind == 4:  # a limit of the game that a person exceeds
        for _ in range(12):
            add_input(inputs, tick=rng.randrange(50, 500), kind="spawn", prototype="stone", x=rng.uniform(-15, 15), y=30)
        expect, mend = "bodies < bodies_start + 5", without_inputs
    else:
        body = planted_body(scene, rng)
        scene["forces"].append({"name": "planted", "type": "central", "body": "planted", "coefficient": -3,
                                "center": [scene["bodies"][body]["position"][0] + 0.2, 25.0], "exponent": 1})
        expect = "energy < energy_start + 1e5"
    return Fault(f"energy_{i}", scene, inputs, ["--expect", expect], mend)


FLIPS = [  # stage, table, column, lane, bit, where, where lane, lower, upper
    ("inputs", "bodies", "velocity", 0, 3, "velocity", 1, -100, -6),
    ("inputs", "bodies", "position", 0, 2, "angular_velocity", 0, 4, 100),
    ("inputs", "bodies", "rotation", 1, 4, "rotation", 1, 0.9, 1),
    ("aabb_tree", "bodies", "velocity", 1, 5, "position", 0, 12, 12.02),
    ("aabb_tree", "bodies", "position", 1, 1, "velocity", 0, 4, 100),
    ("narrow_phase", "contacts", "normal_force", 0, 4, "normal_force", 0, 60, 1e9),
    ("narrow_phase", "contacts", "feature", 0, 1, "tangent_force", 0, 15, 1e9),
    ("narrow_phase", "contacts", "tangent_force", 0, 6, "normal_force", 1, 40, 1e9),
    ("narrow_phase", "bodies", "velocity", 0, 1, "velocity", 0, 3, 100),
    ("impacts", "bodies", "position", 0, 1, "velocity", 1, -100, -8),
    ("impacts", "bodies", "velocity", 1, 2, "position", 0, 30, 31),
    ("impacts", "contacts", "normal_force", 0, 9, "normal_force", 0, 80, 1e9),
    ("tgs_soft", "bodies", "velocity", 0, 0, "velocity", 0, 2.5, 100),
    ("tgs_soft", "bodies", "position", 1, 0, "angular_velocity", 0, -100, -5),
    ("tgs_soft", "bodies", "rotation", 0, 3, "rotation", 0, -1, 0),
    ("tgs_soft", "bodies", "angular_velocity", 0, 7, "position", 1, 0.2, 0.295),
    ("tgs_soft", "contacts", "normal_force", 0, 0, "normal_force", 0, 100, 1e9),
    ("tgs_soft", "contacts", "tangent_force", 1, 2, "tangent_force", 1, 15, 1e9),
    ("tgs_soft", "joints", "linear_force", 0, 3, "linear_force", 0, 2, 1e9),
    ("tgs_soft", "world", "gravity", 1, 3, "tick", 0, 300, 1000),
    ("tgs_soft", "bodies", "velocity", 1, 1, "position", 0, -60, -59),
]


def broken(number, body_count, program):
    scene, inputs, _ = session_of(300 + number, body_count)
    return Fault(f"broken_{number}", scene, inputs, ["--against-build", program], planted=str(number))


def flipped(i, body_count, program):
    scene, inputs, _ = session_of(400 + i, body_count)
    return Fault(f"flip_{i}", scene, inputs, ["--against-build", program],
                 planted="flip " + " ".join(str(word) for word in FLIPS[i]))


class Failed(Exception):
    pass


class Planter:
    def __init__(self, tool, broken_program, folder):
        self.tool, self.broken_program, self.folder = tool, broken_program, folder
        self.environment = dict(os.environ, TICKTRUE_PROGRESS="never")
        self.environment["PATH"] = os.path.dirname(os.path.abspath(tool)) + ":" + self.environment["PATH"]

    def run(self, words, codes, planted=None):
        environment = dict(self.environment)
        environment.pop("TICKTRUE_PLANTED", None)
        if planted:
            environment["TICKTRUE_PLANTED"] = planted
        done = subprocess.run(words, env=environment, capture_output=True, text=True, timeout=1200)
        if done.returncode not in codes:
            raise Failed(f"{' '.join(words)}: exit code {done.returncode}, expected {codes}: "
                         + done.stdout[-300:] + done.stderr[-500:])
        return done.stdout

    def reduce(self, fault):
        folder = os.path.join(self.folder, fault.name)
        os.makedirs(folder, exist_ok=True)
        scene, inputs, out = (os.path.join(folder, name) for name in ("scene.json", "inputs.jsonl", "out"))
        with open(scene, "w") as file:
            json.dump(fault.scene, file)
        with open(inputs, "w") as file:
            file.writelines(json.dumps(one) + "\n" for one in fault.inputs)
        text = self.run([self.tool, "reduce", scene, "--inputs", inputs, "--ticks", str(TICKS), "-o", out, "--json"]
                        + fault.words, [0], fault.planted)
        report = json.loads(text)
        self.check(fault, report, out)
        return report

    def check(self, fault, report, out):
        first, last = report["first_failure"], report["failure"]
        for part in ("kind", "stage", "table", "column"):
            if first[part] != last[part]:
                raise Failed(f"{fault.name}: {part}: found {last[part]}, expected {first[part]}")
        with open(os.path.join(out, "command")) as file:
            self.run(["sh", "-c", file.read()], [1], fault.planted)
        self.run([os.path.join(out, "test.sh")], [1], fault.planted)
        if fault.planted:
            trace = os.path.join(out, "trace.ttr")
            found = json.loads(self.run([self.broken_program, "verify", trace, "--json"], [1], fault.planted))["divergence"]
            if (found["stage"], found["table"], found["rows"][0]["column"]) != (
                    first["stage"], first["table"], first["column"]):
                raise Failed(f"{fault.name}: verify finds {found['stage']} {found['table']} {found['columns']}, "
                             f"expected {first['stage']} {first['table']}.{first['column']}")
            self.run([os.path.join(out, "test.sh")], [0])
            return
        with open(os.path.join(out, "scene.json")) as file:
            scene = json.load(file)
        scene, inputs = fault.mend(copy.deepcopy(scene), [])
        mended = os.path.join(self.folder, fault.name, "mended.json")
        with open(mended, "w") as file:
            json.dump(scene, file)
        words = [self.tool, "reduce", mended, "--ticks", str(report["ticks"]["after"])]
        if fault.mend is without_planted:
            words += ["--inputs", os.path.join(out, "inputs.jsonl")]
        self.run(words + ["--once"] + fault.words, [0])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("tool")
    parser.add_argument("--broken")
    parser.add_argument("--bodies", type=int, default=1000)
    parser.add_argument("--only", default="")
    parser.add_argument("--keep")
    parser.add_argument("--limits", action="store_true")
    options = parser.parse_args()
    makers = [(f"not_finite_{i}", not_finite, (i, options.bodies)) for i in range(10)]
    makers += [(f"energy_{i}", energy, (i, options.bodies)) for i in range(10)]
    if options.broken:
        program = os.path.abspath(options.broken)
        makers += [(f"broken_{number}", broken, (number, options.bodies, program)) for number in broken_build.CHANGES]
        makers += [(f"flip_{i}", flipped, (i, options.bodies, program)) for i in range(len(FLIPS))]
    rows, failures = [], []
    with tempfile.TemporaryDirectory() as temporary:
        planter = Planter(os.path.abspath(options.tool), options.broken and os.path.abspath(options.broken),
                          options.keep or temporary)
        for name, make, arguments in makers:
            if not any(name == word or name.startswith(word + "_") for word in options.only.split(",") if word) and options.only:
                continue
            fault = make(*arguments)
            try:
                report = planter.reduce(fault)
            except (Failed, subprocess.TimeoutExpired) as error:
                failures.append(name)
                print(f"FAILED  {name}: {error}", flush=True)
                continue
            rows.append({"bodies": report["bodies"]["after"], "inputs": report["inputs"]["after"],
                         "inputs %": 100 * report["inputs"]["after"] / report["inputs"]["before"],
                         "ticks": report["ticks"]["after"], "bytes": report["size"], "runs": report["runs"],
                         "seconds": report["seconds"]})
            last = report["failure"]
            print(f"{name:<14} {rows[-1]['bodies']:4} bodies {rows[-1]['inputs']:3} inputs {rows[-1]['ticks']:4} ticks "
                  f"{rows[-1]['bytes']:6} bytes {rows[-1]['runs']:5} runs {rows[-1]['seconds']:6.1f} s  {last['kind']} "
                  f"{last['stage'] or '-'} {last['table'] or '-'}.{last['column'] or '-'}", flush=True)
    is_above = False
    if rows:
        print(f"{len(rows)} of {len(rows) + len(failures)} reduced and checked; median (largest)")
        for part in ("bodies", "inputs %", "ticks", "bytes", "runs", "seconds"):
            values = [row[part] for row in rows]
            median = statistics.median(values)
            is_above |= part in GOALS and median > GOALS[part]
            print(f"  {part:<9} {median:.1f} ({max(values):.1f})")
    sys.exit(1 if failures or not rows or (options.limits and is_above) else 0)


if __name__ == "__main__":
    main()
