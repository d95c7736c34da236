#!/usr/bin/env python3
"""Energy of seeded bridges of pinned planks under falling boxes, by setting (docs/measurements/2026-11-27-bridges.md).

usage: bridges.py scene SEED PRECISION SETTING        prints a scene
       bridges.py run A..B [SETTINGS] [PRECISIONS]     runs seeds A to B-1: a line of JSON each in $OUT (bridges.jsonl)
       bridges.py table                                tables of $OUT
$TICKTRUE is the program, otherwise the one on the path. Settings: the names in SETTINGS, with commas.

A seed gives 4 to 20 planks of 1 m x .2 m and 1 kg. 40 % of the bridges are taut, the others 1 to 10 % slack, hung as the
catenary of rods. One to three boxes of .2 to 2 m and .2 to 8 kg (seeds divisible by 10: 8 to 20 kg) fall .5 to 10 m.
Seeds from 1000 on have heavier boxes (heavy_boxes), seeds from 2000 on one tilted box. Restitution 0, friction .6, 5 s at 60 Hz.
Energies are over that of the fall, the sum of m g h. `mean2` is the mean of the last 2 s.
"""
# SPDX-License-Identifier: MIT
import json, math, os, random, subprocess, sys, tempfile

BIN = os.environ.get("TICKTRUE", "ticktrue")
OUT = os.environ.get("OUT", "bridges.jsonl")
G = 10.0
SETTINGS = {
    "auto": {"substeps": "auto"},
    "auto_nobudget": {"substeps": "auto", "substep_budget": 0},
    "auto_iter": {"substeps": "auto", "joints": "iterative"},
    "iter64": {"substeps": 64},
    "iter64b": {"substeps": 64, "_shift": 1e-5},   # the same, boxes shifted: how much a run is chance
    "iter256": {"substeps": 256},
    "iter1024": {"substeps": 256, "dt": "1/240"},
    "dir4": {"substeps": 4, "joints": "direct"},
    "dir8": {"substeps": 8, "joints": "direct"},
    "dir16": {"substeps": 16, "joints": "direct"},
    "dir64": {"substeps": 64, "joints": "direct"},
    "dir64b": {"substeps": 64, "joints": "direct", "_shift": 1e-5},
    "dir256": {"substeps": 256, "joints": "direct"},
    "dir256b": {"substeps": 256, "joints": "direct", "_shift": 1e-5},
    "dir1024": {"substeps": 256, "joints": "direct", "dt": "1/240"},
    # references: many short ticks, so that overlap at an impact is small (fixed substeps have no speculative contacts)
    "fine_dir": {"substeps": 4, "joints": "direct", "dt": "1/3840"},
    "fine_dirb": {"substeps": 4, "joints": "direct", "dt": "1/3840", "_shift": 1e-5},
    "fine_dir16": {"substeps": 16, "joints": "direct", "dt": "1/960"},
    "fine_iter": {"substeps": 4, "dt": "1/3840"},
    "fine_iter16": {"substeps": 16, "dt": "1/960"},
    "auto_fine": {"substeps": "auto", "dt": "1/480"},
    "autob": {"substeps": "auto", "_shift": 1e-5},
    "fine2_dir": {"substeps": 4, "joints": "direct", "dt": "1/15360"},
    "dir4096": {"substeps": 256, "joints": "direct", "dt": "1/960"},
}

def catenary(n, span):
    """Angles of n equal rods that hang between two pegs at the same height, span apart."""
    if span >= n: return [0.0] * n
    ks = [i - (n - 1) / 2 for i in range(n)]
    lo, hi = 0.0, 1e6
    for _ in range(200):
        mid = (lo + hi) / 2
        if sum(math.cos(math.atan(k * mid)) for k in ks) > span: lo = mid
        else: hi = mid
    return [math.atan(k * lo) for k in ks]

def make(seed):
    r = random.Random(f"bridge {seed}")
    n = r.randint(4, 20)
    taut = r.random() < 0.4
    slack = 0.0 if taut else r.uniform(0.01, 0.10)
    span = n * (1 - slack)
    boxes = []
    for _ in range(r.choice([1, 1, 1, 2, 3])):
        size = r.uniform(0.2, 2.0)
        mass = math.exp(r.uniform(math.log(0.2), math.log(8)))
        if seed % 10 == 0: mass = r.uniform(8, 20)
        fall = math.exp(r.uniform(math.log(0.5), math.log(10)))
        x = r.uniform(-0.5, 0.5) * max(0.5, span - size - 0.5)
        boxes.append(dict(size=size, mass=mass, fall=fall, x=x))
    if seed >= 1000: boxes = heavy_boxes(r, span, seed)
    if seed >= 2000:  # the third family: one tilted box of 4 to 12 kg from 5 to 10 m on a bridge that is slack by .5 to 5 %
        slack = r.uniform(0.005, 0.05)
        span = n * (1 - slack)
        boxes = [dict(size=r.uniform(0.2, 2), mass=r.uniform(4, 12), fall=r.uniform(5, 10), angle=r.uniform(0, 1.57),
                      x=r.uniform(-0.5, 0.5) * (span - 2))]
    return dict(seed=seed, n=n, slack=slack, span=span, boxes=boxes, arc=seed >= 1000 and r.random() < 0.5)

def heavy_boxes(r, span, seed):
    """The second family: heavier boxes, falls spread evenly; half of the slack bridges start as an arc and swing."""
    boxes = []
    for _ in range(r.choice([1, 1, 2, 3, 4])):
        size = r.uniform(0.2, 2.0)
        mass = r.choice([2 * size * size, r.uniform(1, 8), r.uniform(1, 8), r.uniform(8, 20)])
        boxes.append(dict(size=size, mass=mass, fall=r.uniform(0.5, 10), x=r.uniform(-0.5, 0.5) * max(0.5, span - size - 0.5)))
    return boxes

def arc(n, span):
    """Angles of n equal rods along an arc of a circle, which hangs below its pegs but not at rest."""
    lo, hi = 0.0, 3.0 / n
    for _ in range(200):
        mid = (lo + hi) / 2
        if sum(math.cos((i - (n - 1) / 2) * mid) for i in range(n)) > span: lo = mid
        else: hi = mid
    return [(i - (n - 1) / 2) * lo for i in range(n)]

def scene(b, precision, setting):
    s = dict(SETTINGS[setting]); shift = s.pop("_shift", 0.0)
    n, span = b["n"], b["span"]
    angles = arc(n, span) if b.get('arc') and span < n else catenary(n, span)
    bodies = [{"name": "banks", "type": "static", "shapes": [{"type": "circle", "radius": 0.05, "center": [-span / 2, 0], "filter": {"mask": 0}}]}]
    joints = []
    x, y = -span / 2, 0.0
    plank = []
    for i, a in enumerate(angles):
        cx, cy = x + 0.5 * math.cos(a), y + 0.5 * math.sin(a)
        plank.append((x, y, a))
        bodies.append({"name": f"p{i}", "position": [cx, cy], "angle": a, "mass": 1,
                       "shapes": [{"type": "box", "half_size": [0.5, 0.1]}]})
        joints.append({"type": "revolute", "body_a": "banks" if i == 0 else f"p{i-1}", "body_b": f"p{i}",
                       "anchor_a": [-span / 2, 0] if i == 0 else [0.5, 0], "anchor_b": [-0.5, 0]})
        x, y = x + math.cos(a), y + math.sin(a)
    joints.append({"type": "revolute", "body_a": f"p{n-1}", "body_b": "banks", "anchor_a": [0.5, 0], "anchor_b": [span / 2, 0]})
    def top(left, right):  # of the planks between two x
        best = -1e9
        for px, py, a in plank:
            for u in (0, 1):
                qx, qy = px + u * math.cos(a), py + u * math.sin(a)
                if left <= qx <= right: best = max(best, qy)
            for e in (left, right):
                if px <= e <= px + math.cos(a): best = max(best, py + (e - px) * math.tan(a))
        return (best if best > -1e8 else 0) + 0.1 / math.cos(angles[0])
    placed = []
    fall_energy = 0.0
    for i, q in enumerate(b["boxes"]):
        h = q["size"] / 2
        bottom = top(q["x"] - h, q["x"] + h) + q["fall"]
        moved = True
        while moved:
            moved = False
            for (ox, ob, oh) in placed:
                if abs(ox - q["x"]) < h + oh + 0.01 and ob - 2 * h - 0.01 < bottom < ob + 2 * oh + 0.01:
                    bottom = ob + 2 * oh + 0.02; moved = True
        placed.append((q["x"], bottom, h))
        fall_energy += q["mass"] * G * (bottom - top(q["x"] - h, q["x"] + h))
        bodies.append({"name": f"b{i}", "position": [q["x"] + shift, bottom + h], "angle": q.get("angle", 0), "mass": q["mass"],
                       "shapes": [{"type": "box", "half_size": [h, h]}]})
    settings = {"precision": precision, "dt": "1/60", **s}
    return {"name": f"bridge_{b['seed']}", "gravity": [0, -G], "settings": settings, "bodies": bodies, "joints": joints}, fall_energy

def csv_of(sc, columns, directory, ticks=None):
    path, trace = os.path.join(directory, "s.json"), os.path.join(directory, "s.ttr")
    json.dump(sc, open(path, "w"))
    per = int(sc["settings"]["dt"].split("/")[1]) // 60
    subprocess.run([BIN, "record", path, "--ticks", str((ticks or 300) * per), "-o", trace, "--force"], check=True, capture_output=True)
    out = subprocess.run([BIN, "replay", trace, "--format", "csv", "--every", str(per), "--columns", columns], check=True, capture_output=True, text=True).stdout
    lines = [l for l in out.splitlines() if l and not l.startswith("#")]
    head = lines[0].split(",")
    return head, [[float(v) for v in l.split(",")] for l in lines[1:]]

def run(seed, precision, setting, directory):
    b = make(seed)
    sc, fall = scene(b, precision, setting)
    head, rows = csv_of(sc, "energy,overlap,joint_gap", directory)
    e0 = energy0(b, sc)
    k = {c: head.index(c) for c in ("energy", "overlap", "joint_gap")}
    e = [(r[k["energy"]] - e0) / fall for r in rows]
    # the largest rise over an earlier value, too
    low, rise, rise_tick = e[0], 0.0, 0
    worst_step, worst_step_tick = 0.0, 0
    prev = 0.0
    for t, v in enumerate(e):
        if v - low > rise: rise, rise_tick = v - low, t + 1
        low = min(low, v)
        if v - prev > worst_step: worst_step, worst_step_tick = v - prev, t + 1
        prev = v
    gain = max(e)
    return dict(seed=seed, precision=precision, setting=setting, n=b["n"], slack=round(b["slack"], 4), fall=fall,
                gain=gain, gain_tick=e.index(gain) + 1, rise=rise, rise_tick=rise_tick, step=worst_step, step_tick=worst_step_tick,
                end=e[-1], mean2=sum(e[180:]) / len(e[180:]), mean_all=sum(e) / len(e),
                overlap=max(r[k["overlap"]] for r in rows), overlap_end=rows[-1][k["overlap"]],
                gap=max(r[k["joint_gap"]] for r in rows), gap_end=rows[-1][k["joint_gap"]], e=[round(v, 6) for v in e])

def energy0(b, sc):
    return sum(body["mass"] * G * body["position"][1] for body in sc["bodies"] if "mass" in body)

def load():
    data = {}
    for line in open(OUT):
        r = json.loads(line); data[(r["precision"], r["setting"], r["seed"])] = r
    return data

def table():
    d = load()
    precisions = sorted({k[0] for k in d}); names = [s for s in SETTINGS if any(k[1] == s for k in d)]
    for p in precisions:
        print(f"\n## {p}\n\n| setting | runs | gain > 1 % | > 2 % | worst | rise within a tick > 1 % | mean loss, last 2 s | median | gap > 5 cm | worst gap | overlap, worst | at the end |")
        print("|" + "---|" * 12)
        for s in names:
            rows = [v for k, v in d.items() if k[0] == p and k[1] == s]
            if not rows: continue
            losses = sorted(-v["mean2"] for v in rows)
            print(f"| {s} | {len(rows)} | {sum(v['gain'] > .01 for v in rows)} | {sum(v['gain'] > .02 for v in rows)} | {100*max(v['gain'] for v in rows):.1f} % | {sum(v['step'] > .01 for v in rows)} | {100*sum(losses)/len(losses):.2f} % | {100*losses[len(losses)//2]:.2f} % | {sum(v['gap'] > .05 for v in rows)} | {max(v['gap'] for v in rows):.2g} | {max(v['overlap'] for v in rows):.2g} | {max(v['overlap_end'] for v in rows):.2g} |")
        print(f"\nRuns in which the row loses more than the column + 2 % of the fall (mean energy of the last 2 s); mean difference, %\n")
        print("| | " + " | ".join(names) + " |\n|" + "---|" * (len(names) + 1))
        for s in names:
            cells = []
            for q in names:
                both = [(d[(p, s, x)], d[(p, q, x)]) for x in range(100000) if (p, s, x) in d and (p, q, x) in d] if s != q else []
                if not both: cells.append(""); continue
                diff = [v["mean2"] - w["mean2"] for v, w in both]
                cells.append(f"{sum(x < -.02 for x in diff)} ({100*sum(diff)/len(diff):+.2f})")
            print(f"| {s} | " + " | ".join(cells) + " |")
        for s in names:
            bad = sorted(((v["gain"], k[2]) for k, v in d.items() if k[0] == p and k[1] == s and v["gain"] > .01), reverse=True)
            if bad: print(f"gain {s}: " + ", ".join(f"{x}: {100*g:.1f}% t{d[(p,s,x)]['gain_tick']}" for g, x in bad[:30]))

if __name__ == "__main__":
    if sys.argv[1] == "scene":
        print(json.dumps(scene(make(int(sys.argv[2])), sys.argv[3], sys.argv[4])[0], indent=1))
    elif sys.argv[1] == "table": table()
    else:
        a, z = (int(v) for v in sys.argv[2].split(".."))
        settings = sys.argv[3].split(",") if len(sys.argv) > 3 else ["auto", "iter64", "dir64", "dir256", "iter256"]
        precisions = sys.argv[4].split(",") if len(sys.argv) > 4 else ["f32", "f64"]
        have = set(load()) if os.path.exists(OUT) else set()
        with tempfile.TemporaryDirectory() as directory, open(OUT, "a") as out:
            for seed in range(a, z):
                for p in precisions:
                    for s in settings:
                        if (p, s, seed) in have: continue
                        out.write(json.dumps(run(seed, p, s, directory)) + "\n"); out.flush()
