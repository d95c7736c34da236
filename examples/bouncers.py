# A simulation in Python, recorded and verified through ctypes.
# SPDX-License-Identifier: MIT
#
#   TICKTRUE_LIBRARY=PREFIX/lib/libticktrue.so python3 bouncers.py --record b.ttr
#   TICKTRUE_LIBRARY=PREFIX/lib/libticktrue.so python3 bouncers.py --verify b.ttr
#   TICKTRUE_LIBRARY=PREFIX/lib/libticktrue.so python3 bouncers.py --verify b.ttr --bug hash
#
# --bug hash: lets the order of a set of strings decide, which Python changes in every run.
import array
import ctypes
import os
import sys

lib = ctypes.CDLL(os.environ.get("TICKTRUE_LIBRARY", "libticktrue.so"))
OK, FULL, F64, I64 = 0, 3, 8, 6


class Options(ctypes.Structure):
    _fields_ = [("struct_size", ctypes.c_size_t), ("mode", ctypes.c_int32), ("detail", ctypes.c_int32),
                ("path", ctypes.c_char_p), ("name", ctypes.c_char_p), ("version", ctypes.c_uint32),
                ("flags", ctypes.c_uint32), ("setup", ctypes.c_void_p), ("setup_size", ctypes.c_size_t),
                ("title", ctypes.c_char_p), ("build", ctypes.c_char_p), ("dt", ctypes.c_double),
                ("full_first", ctypes.c_uint64), ("full_last", ctypes.c_uint64),
                ("checkpoint_interval", ctypes.c_uint32), ("rollback_max", ctypes.c_uint32)]


lib.ticktrue_open_arguments.restype = ctypes.c_void_p
lib.ticktrue_open_arguments.argtypes = [ctypes.POINTER(Options), ctypes.c_int, ctypes.POINTER(ctypes.c_char_p)]
lib.ticktrue_column.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_char_p, ctypes.c_void_p, ctypes.c_int,
                                ctypes.c_uint32, ctypes.c_uint32, ctypes.c_size_t]
lib.ticktrue_input.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t]
lib.ticktrue_begin_tick.argtypes = [ctypes.c_void_p, ctypes.POINTER(ctypes.c_double)]
lib.ticktrue_end_tick.argtypes = [ctypes.c_void_p]
lib.ticktrue_close.argtypes = [ctypes.c_void_p]

words = [word.encode() for word in sys.argv]
options = Options(struct_size=ctypes.sizeof(Options), name=b"bouncers-example", version=1, detail=FULL)
session = lib.ticktrue_open_arguments(options, len(words), (ctypes.c_char_p * (len(words) + 1))(*words, None))

names = ["ada", "bea", "cleo", "dora", "elin", "fay"]
order = set(names) if "hash" in sys.argv else names
position = array.array("d", [0.5 * i for i in range(len(names))])
velocity = array.array("d", [1.0] * len(names))
hits = array.array("q", [0] * len(names))
for name, values, kind in ((b"position", position, F64), (b"velocity", velocity, F64), (b"hits", hits, I64)):
    lib.ticktrue_column(session, b"bouncers", name, values.buffer_info()[0], kind, 1, len(names), 0)

push = ctypes.c_double()
dt = ctypes.c_double(1 / 60)
for tick in range(300):
    push.value = ((tick // 7) % 5 - 2) * 0.5
    lib.ticktrue_input(session, ctypes.byref(push), 8)
    if lib.ticktrue_begin_tick(session, ctypes.byref(dt)) != OK:
        break
    total = 0.0
    for name in order:
        total = total * 0.5 + position[names.index(name)]
    for i in range(len(names)):
        velocity[i] += (push.value - 9.8125 + 1e-3 * total) * dt.value
        position[i] += velocity[i] * dt.value
        if position[i] < 0:
            position[i], velocity[i], hits[i] = -position[i], -0.75 * velocity[i], hits[i] + 1
    lib.ticktrue_end_tick(session)
print(f"{sum(hits)} hits", flush=True)
sys.exit(lib.ticktrue_close(session))
