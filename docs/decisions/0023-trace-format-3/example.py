#!/usr/bin/env python3
"""A reader and a writer of format version 3 as the draft describes it: makes the worked example and tries its checks."""
import ctypes, struct, sys
lib = ctypes.CDLL("libxxhash.so.0")
lib.XXH3_64bits_withSeed.restype = ctypes.c_uint64
lib.XXH3_64bits_withSeed.argtypes = [ctypes.c_char_p, ctypes.c_size_t, ctypes.c_uint64]
H = lambda b, seed=0: lib.XXH3_64bits_withSeed(bytes(b), len(b), seed)
u8, u16, u32, u64 = (lambda f: lambda v: struct.pack("<" + f, v))("B"), *[(lambda f: lambda v: struct.pack("<" + f, v))(f) for f in "HIQ"]
f64 = lambda v: struct.pack("<d", v)
text = lambda s: u32(len(s.encode())) + s.encode()
M, W = 0xd6e8feb86659fd93, (1 << 64) - 1
def mix(h, w):
    x = ((h ^ w) * M) & W
    return x ^ (x >> 32)
def varint(v):
    out = b""
    while v > 127: out += bytes([v & 127 | 128]); v >>= 7
    return out + bytes([v])
SETUP, FACTS, CHECKPOINT, TICKS, IMAGE, END, INDEX, FOOTER, SHOWN, SAVE, PEER = range(1, 12)
UNCHAINED = {FACTS, INDEX, FOOTER, SHOWN, SAVE, PEER}
SYNC = b"\xf5TTC"
INF = float("inf")

def file_header():
    b = bytes.fromhex("895454520d0a1a0a") + u16(3) + u16(0)
    return b + u32(H(b) & 0xffffffff)
CHAIN_START = H(file_header())
link = lambda chain, kind, tick: H(u8(kind) + u64(tick), chain)
def content_hash(b):
    return H(b"".join(map(u64, [len(b)] + [H(b[i:i + 16384]) for i in range(0, len(b), 16384)])))
def root_hash(schema, rows):
    l = []
    for t, (n, data) in zip(schema, rows):
        if not t["judged"]: continue
        l += [H(t["name"].encode()), n] + [H(data[i:i + 16384]) for i in range(0, len(data), 16384)]
    return H(b"".join(map(u64, l)))

SIZE = {3: 4, 7: 4, 1: 1}
def column(name, type_, lanes, offset, target=0, optional=0, klass=0):
    return text(name) + u8(type_) + u8(lanes) + u16(offset) + f64(-INF) + f64(INF) + u16(target) + u8(optional) + u8(klass)
def schema_bytes(schema):
    out = u16(len(schema))
    for t in schema:
        sizes = [0, 0]; cols = b""
        for (name, ty, lanes, target, opt, klass) in t["columns"]:
            cols += column(name, ty, lanes, sizes[klass], target, opt, klass); sizes[klass] += SIZE[ty] * lanes
        out += text(t["name"]) + u8(t["form"]) + u16(t["parent"]) + u32(sizes[0]) + u32(sizes[1]) + u8(t["key"]) + u16(len(t["columns"])) + cols
    return out

SCHEMA = [
    dict(name="units", form=0, parent=0, key=1, judged=True, columns=[("id", 3, 1, 0, 0, 0), ("hp", 3, 1, 0, 0, 0), ("glow", 7, 1, 0, 0, 1)]),
    dict(name="units.name", form=3, parent=1, key=2, judged=True, columns=[("owner", 3, 1, 1, 0, 0), ("index", 3, 1, 0, 0, 0), ("size", 3, 1, 0, 0, 0), ("bytes", 3, 2, 0, 0, 0)]),
]
FEATURES = 1 | 2 | 4 | 8 | 16     # shown, saves, marks, notes, tail

class Writer:
    def __init__(self, features=FEATURES):
        self.out = bytearray(file_header()); self.chain = CHAIN_START; self.seq = 0; self.tick = 0; self.features = features; self.log = []
        setup = (text("mygame") + u32(1) + text("duel") + f64(1 / 64) + u8(1) + u64(0) + u64(0) + u32(600) + u32(features) + u32(2)
                 + schema_bytes(SCHEMA) + u16(1) + text("move") + u32(1) + b"\x2a")
        self.seed = CHAIN_START
        self.chunk(SETUP, setup); self.seed = self.chain
        self.facts_check = self.chunk(FACTS, u8(0) + u16(1) + text("caller.game.fused") + text("no"))
    def header(self, kind, size):
        h = SYNC + u8(kind) + u8(1 if kind == TICKS else 0) + u16(0) + u32(self.seq) + u32(size) + u64(self.tick) + u64(self.chain)
        self.seq += 1; self.at = len(self.out)
        check = H(h, self.seed); self.out += h + u64(check); self.log.append((self.at, kind)); return check
    def chunk(self, kind, payload, fields=b"", data=None):
        check = self.header(kind, len(payload)); self.out += payload
        trailer = H(payload, check); self.out += u64(trailer)
        if kind not in UNCHAINED:
            self.chain = H(payload if data is None else data, H(fields, link(self.chain, kind, self.tick)))
        return trailer
    def checkpoint(self, tick, rows, time, shown, save):
        self.tick = tick
        image = u8(0) + varint(len(rows)); skip = 0
        for n, data in rows: image += varint(0) + u32(n) + data
        fields = u64(root_hash(SCHEMA, rows)) + u64(len(image)) + u64(0) + u32(len(image)) + f64(time)
        self.checkpoint_offset = len(self.out)
        self.chunk(CHECKPOINT, fields + u8(0) + image, fields, image)
        if self.features & 1:
            s = varint(1) + varint(0) + u32(len(shown) // 4) + shown
            self.chunk(SHOWN, u64(content_hash(s)) + u64(len(s)) + u64(0) + u32(len(s)) + u8(0) + s)
        if self.features & 2:
            self.chunk(SAVE, u64(content_hash(save)) + u64(len(save)) + u64(0) + u32(len(save)) + u8(0) + save)
    def open(self):
        self.running = link(self.chain, TICKS, self.tick); self.outside = self.header(TICKS, 0xffffffff); self.count = 0
    def record(self, tag, body):
        sized = tag in (2, 3, 4) or tag >= 64
        b = u8(tag) + (varint(len(body)) if sized else b"") + body
        if 64 <= tag < 128: self.outside = H(b, self.outside); check = self.outside
        else: self.running = H(b, self.running); check = self.running
        self.out += b + u16(check & 0xffff)
        if tag == 5: self.count += 1
    def close(self):
        b = u8(15) + u32(self.count)
        self.outside = H(b, self.outside); self.running = H(b, self.running)
        self.out += b + u64(self.outside) + u64(self.running)
        self.chain = self.running; self.tick += self.count
    def finish(self):
        self.chunk(END, u8(1) + text(""))
        at = len(self.out)
        index_check = self.chunk(INDEX, u32(1) + u32(1) + u64(self.first) + u64(self.checkpoint_offset))
        self.chunk(FOOTER, u64(at) + u64(index_check) + u64(self.facts_check))

def state(hp, name):
    data = name.encode(); pieces = b""; n = 0
    for i in range(0, len(data), 8):
        part = data[i:i + 8]; pieces += u32(7) + u32(n) + u32(len(part)) + part.ljust(8, b"\0"); n += 1
    return [(1, u32(7) + u32(hp)), (n, pieces)]
def trail(marks, names):
    t, per = 0x9e3779b9, {}
    for name, value in marks:
        k = H(name.encode()); i = names.index(name); h, c = per.get(i, (k, 0))
        per[i] = (mix(h, value), c + 1); t = mix(mix(t, k), value)
    return t, per
def marks_body(marks, names):
    t, per = trail(marks, names); body = u64(t) + varint(len(per)); last = -1
    for i in sorted(per):
        h, c = per[i]; body += varint(i - last - 1) + varint(c) + u32(mix(h, c) & 0xffffffff); last = i
    return body

def example(features=FEATURES, shown=struct.pack("<f", .5), save=b"save of tick 8"):
    w = Writer(features); w.first = 8
    w.checkpoint(8, state(100, "Ada Lovelace"), 8 / 64, shown, save)
    w.open()
    w.record(2, b"\x01")
    if features & 8: w.record(67, text("log") + b"hit by 3")
    w.record(3, u64(root_hash(SCHEMA, state(97, "Ada Lovelace"))))
    if features & 4:
        w.record(64, b"rand"); w.record(65, marks_body([("rand", 5), ("rand", 9)], ["rand"]))
    w.record(5, u64(root_hash(SCHEMA, state(97, "Ada Lovelace"))))
    w.record(5, u64(root_hash(SCHEMA, state(97, "Ada L."))))
    w.close(); w.finish(); return w

class Bad(Exception): pass
def need(c, what):
    if not c: raise Bad(what)
def read(b):
    """Everything that is proven; raises Bad at the first thing that is not."""
    need(len(b) >= 16 and b[:8] == bytes.fromhex("895454520d0a1a0a"), "magic")
    need(struct.unpack("<I", b[12:16])[0] == H(b[:12]) & 0xffffffff, "file header")
    need(b[8:12] == u16(3) + u16(0), "version")
    at, chain, seed, seq, tick, state_, facts_check, index = 16, CHAIN_START, CHAIN_START, 0, 0, "setup", 0, None
    while state_ != "done":
        h = b[at:at + 40]; need(len(h) == 40, "cut"); need(h[:4] == SYNC, "sync")
        kind, flags, res, s, size, t, c, check = struct.unpack("<BBHIIQQQ", h[4:])
        need(H(h[:32], seed) == check, "header"); need(s == seq and c == chain and res == 0, "order")
        need((flags == 1) == (kind == TICKS), "flags"); seq += 1
        order = {"setup": [SETUP], "facts": [FACTS], "first": [CHECKPOINT], "body": [SHOWN, SAVE, TICKS, CHECKPOINT, END], "index": [INDEX], "footer": [FOOTER]}
        need(kind in order[state_], "kind")
        if state_ == "first": tick = t
        need(t == tick, "tick")
        if kind == TICKS:
            p = at + 40; running, outside, n = link(chain, TICKS, tick), check, 0
            while True:
                need(p < len(b), "cut"); tag = b[p]; q = p + 1
                if tag == 15:
                    need(q + 20 <= len(b), "cut"); count, o, r = struct.unpack("<IQQ", b[q:q + 20])
                    outside = H(b[p:q + 4], outside); running = H(b[p:q + 4], running)
                    need(count == n and o == outside and r == running, "close"); at = q + 20; break
                if tag in (2, 3, 4) or tag >= 64:
                    v = s_ = 0
                    while True:
                        need(q < len(b), "cut"); v |= (b[q] & 127) << s_; s_ += 7; q += 1
                        if not b[q - 1] & 128: break
                        need(s_ < 28, "size")
                    size_ = v
                else:
                    need(tag in (1, 5, 6), "tag"); size_ = 8
                e = q + size_; need(e + 2 <= len(b), "cut")
                if 64 <= tag < 128: need(tag <= 67, "tag"); outside = H(b[p:e], outside); val = outside
                else: running = H(b[p:e], running); val = running
                need(struct.unpack("<H", b[e:e + 2])[0] == val & 0xffff, "record"); n += tag in (5, 6); p = e + 2
            chain = running; tick += n; continue
        need(at + 48 + size <= len(b), "cut"); p = b[at + 40:at + 40 + size]
        trailer = struct.unpack("<Q", b[at + 40 + size:at + 48 + size])[0]; need(trailer == H(p, check), "trailer")
        here = at; at += 48 + size
        if kind not in UNCHAINED:
            fields, data = (p[:36], p[37:]) if kind == CHECKPOINT else (b"", p)
            chain = H(data, H(fields, link(chain, kind, tick)))
        if kind == SETUP: seed = chain; state_ = "facts"
        elif kind == FACTS: facts_check = trailer; state_ = "first"
        elif kind == CHECKPOINT: state_ = "body"
        elif kind in (SHOWN, SAVE): need(struct.unpack("<Q", p[:8])[0] == content_hash(p[29:]), "content hash")
        elif kind == END: state_ = "index"
        elif kind == INDEX: index = (here, trailer); state_ = "footer"
        elif kind == FOOTER:
            need(struct.unpack("<QQQ", p) == (index[0], index[1], facts_check), "footer"); state_ = "done"
    need(at == len(b), "behind the footer"); return chain, tick

def identity(setup=b"\x2a"):
    judged = []
    for t in SCHEMA:
        cols = [c for c in t["columns"] if c[5] == 0]
        if cols: judged.append(dict(t, columns=cols))
    return H(text("mygame") + u32(1) + f64(1 / 64) + schema_bytes(judged) + u32(len(setup)) + setup)

if __name__ == "__main__":
    w = example(); b = bytes(w.out)
    print("bytes", len(b), "read", "%016x %d" % read(b))
    print("chain_start %016x identity %016x session_identity %016x" % (CHAIN_START, w.seed, identity()))
    print("roots %016x %016x %016x" % tuple(root_hash(SCHEMA, state(*s)) for s in ((100, "Ada Lovelace"), (97, "Ada Lovelace"), (97, "Ada L."))))
    other = example(shown=struct.pack("<f", .25), save=b"another save, longer"); assert read(bytes(other.out))[0] == read(b)[0] and bytes(other.out) != b
    print("another shown value, another save: same chain")
    missed = 0; whole = set()
    for i in range(len(b)):
        for bit in range(8):
            c = bytearray(b); c[i] ^= 1 << bit
            try: read(bytes(c)); missed += 1
            except Bad as e: whole.add(str(e))
    cuts = 0
    for i in range(len(b)):
        try: read(b[:i]); cuts += 1
        except Bad: pass
    # leave out, double or swap whole chunks and outside records
    ends = [o for o, _ in w.log] + [len(b)]
    moved = 0
    for i in range(len(w.log)):
        for j in range(len(w.log)):
            parts = [b[:16]] + [b[ends[k]:ends[k + 1]] for k in range(len(w.log))]
            x = parts[:]; x[i + 1], x[j + 1] = x[j + 1], x[i + 1]
            y = parts[:i + 1] + parts[i + 2:]; z = parts[:i + 2] + parts[i + 1:]
            for v in ([x] if i != j else []) + [y, z]:
                try: read(b"".join(v)); moved += 1
                except Bad: pass
    print("flips missed", missed, "of", 8 * len(b), "cuts taken for whole", cuts, "chunks moved unseen", moved)
    if len(sys.argv) > 1:
        names = {1: "setup", 2: "facts", 3: "checkpoint", 4: "ticks", 6: "end", 7: "index", 8: "footer", 9: "shown", 10: "save"}
        for (o, k), e in zip(w.log, ends[1:]): print("%04x %-10s %d bytes" % (o, names[k], e - o))
        o = [o for o, k in w.log if k == 4][0]; e = [e for (x, k), e in zip(w.log, ends[1:]) if k == 4][0]
        print("ticks", b[o:e].hex(" "))
        for kk in (3, 9, 10):
            o, e = [(x, e) for (x, k), e in zip(w.log, ends[1:]) if k == kk][0]; print(names[kk], b[o:e].hex(" "))
        print("header", b[:16].hex(" "))
