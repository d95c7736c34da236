#!/usr/bin/env python3
"""The black box of the draft: kills its writer between any two stores and inside copies, recovers, and compares the ticks."""
import random, struct, sys
from example import *

def prefix(b):
    """A truncated trace: first tick, roots of its whole ticks, root of the first checkpoint. Raises Bad where a byte is wrong."""
    at, chain, seed, seq, tick, first, roots, start = 16, CHAIN_START, CHAIN_START, 0, 0, None, [], None
    need(b[:12] == file_header()[:12] and b[:16] == file_header(), "file header")
    while at < len(b):
        h = b[at:at + 40]
        if len(h) < 40: break
        kind, flags, res, s, size, t, c, check = struct.unpack("<BBHIIQQQ", h[4:])
        need(h[:4] == SYNC and H(h[:32], seed) == check and s == seq and c == chain, "header"); seq += 1
        if kind == CHECKPOINT and first is None: first = tick = t
        need(t == tick, "tick")
        if kind == TICKS:
            p, running, outside, closed = at + 40, link(chain, TICKS, tick), check, False
            while p < len(b):
                tag = b[p]; q = p + 1
                if tag == 15:
                    if q + 20 > len(b): break
                    count, o, r = struct.unpack("<IQQ", b[q:q + 20])
                    running = H(b[p:q + 4], running); outside = H(b[p:q + 4], outside)
                    need(o == outside and r == running, "close"); p = q + 20; closed = True; break
                n = 8
                if tag in (2, 3, 4) or tag >= 64:
                    n = s_ = 0
                    while q < len(b):
                        n |= (b[q] & 127) << s_; s_ += 7; q += 1
                        if not b[q - 1] & 128: break
                else: need(tag in (1, 5), "tag")
                if q + n + 2 > len(b): break
                if 64 <= tag < 128: outside = H(b[p:q + n], outside); v = outside
                else: running = H(b[p:q + n], running); v = running
                need(struct.unpack("<H", b[q + n:q + n + 2])[0] == v & 0xffff, "record"); p = q + n + 2
                if tag == 5: roots.append(struct.unpack("<Q", b[q:q + 8])[0]); tick += 1
            if not closed: break
            chain, at = running, p; continue
        if at + 48 + size > len(b): break
        p = b[at + 40:at + 40 + size]; need(struct.unpack("<Q", b[at + 40 + size:at + 48 + size])[0] == H(p, check), "trailer")
        if kind not in UNCHAINED:
            fields, data = (p[:36], p[37:]) if kind == CHECKPOINT else (b"", p)
            chain = H(data, H(fields, link(chain, kind, tick)))
        if kind == SETUP: seed = chain
        if kind == CHECKPOINT:
            root = struct.unpack("<Q", p[:8])[0]
            if start is None: start = root
            else: need(not roots or roots[-1] == root, "checkpoint root")
        at += 48 + size
    return first, start, roots

class Box:
    """Every store goes into `ops`: (offset, bytes). A copy may be cut anywhere, the small stores are whole."""
    def __init__(self, slots, slot_size, seed):
        self.rng = random.Random(seed); self.ops = []; self.slots, self.slot_size = slots, slot_size
        w = Writer(); self.identity = w.seed; self.head = bytes(w.out); self.base = 4096 + (len(self.head) + 4095) // 4096 * 4096
        self.size = self.base + slots * slot_size; self.generation = 0; self.tick = 0; self.truth = []; self.marks = []
        self.w = w; self.begin()
    def state(self):
        return state(self.tick * 7 % 1000, "name" * (self.tick % 5))
    def put(self, data):
        self.ops.append((self.at + 64 + self.used, bytes(data), True)); self.used += len(data)
        self.ops.append((self.at + 24, u32(self.used), False))
    def flush(self):
        self.put(self.w.out); self.w.out.clear()
    def begin(self):
        self.at = self.base + self.generation % self.slots * self.slot_size; self.generation += 1; self.used = 0
        w = self.w; w.seq, w.chain, w.seed = 2, self.identity, self.identity
        w.out.clear(); w.log = []
        self.ops += [(self.at, u64(0), False), (self.at + 24, u32(0), False), (self.at + 8, u64(self.tick), False),
                     (self.at + 16, u64(H(u64(self.generation) + u64(self.tick), self.identity)), False)]
        self.checkpoint(); self.ops.append((self.at, u64(self.generation), False)); self.opened = False
    def checkpoint(self):
        self.w.checkpoint(self.tick, self.state(), self.tick / 64, b"\0\0\0\0", self.rng.randbytes(self.rng.randrange(40))); self.flush()
    def step(self):
        inputs = self.rng.randbytes(self.rng.randrange(1, 30)); w = self.w
        if self.used + 64 + len(inputs) + 200 > self.slot_size:
            if self.opened: w.close(); self.flush()
            self.begin()
        if not self.opened: w.open(); self.opened = True
        w.record(2, inputs); self.flush()
        self.tick += 1; root = root_hash(SCHEMA, self.state())
        w.record(64, b"x"); w.record(65, marks_body([("x", self.tick)], ["x"])); w.record(5, u64(root)); self.flush()
        self.truth.append(root); self.marks.append(len(self.ops))

def recover(file, head, base, slots, slot_size, identity):
    found = []
    for k in range(slots):
        at = base + k * slot_size
        generation, first, check, committed = struct.unpack("<QQQI", file[at:at + 28])
        if generation == 0 or check != H(u64(generation) + u64(first), identity) or committed > slot_size - 64: continue
        found.append((generation, first, file[at + 64:at + 64 + committed]))
    found.sort(reverse=True); run, want = [], None
    for generation, first, data in found:
        if want is not None and generation != want: break
        t, start, roots = prefix(head + data); need(t == first, "first tick")
        if run and (first + len(roots) != run[0][0] or roots[-1] != run[0][1]): break
        run.insert(0, (first, start, roots)); want = generation - 1
    return (run[0][0], [r for x in run for r in x[2]]) if run else None

if __name__ == "__main__":
    points = short = 0; held = []
    for seed in range(12):
        box = Box(4, 1600, seed)
        for _ in range(120): box.step()
        file = bytearray(box.size); done = 0; rng = random.Random(seed)
        for n, (offset, data, is_copy) in enumerate(box.ops):
            while done < len(box.marks) and box.marks[done] <= n: done += 1
            for cut in ([0] + ([rng.randrange(len(data))] if is_copy else [])):
                torn = bytearray(file); torn[offset:offset + cut] = data[:cut]
                got = recover(bytes(torn), box.head, box.base, box.slots, box.slot_size, box.identity); points += 1
                if n < 9: continue                      # the first slot is not there yet
                first, roots = got
                assert roots == box.truth[first:first + len(roots)], (seed, n)
                lost = done - (first + len(roots)); assert 0 <= lost <= 0 or lost < 0, (seed, n, lost)
                if done > 60: held.append(len(roots))
            file[offset:offset + len(data)] = data
    print("kills", points, "ticks held after the first laps: least", min(held), "most", max(held), "- every tick that had ended was recovered")
