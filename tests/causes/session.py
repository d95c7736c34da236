# A session of libticktrue through ctypes, for the Python programs of the gallery.
# SPDX-License-Identifier: MIT
import array
import ctypes
import os
import sys

lib = ctypes.CDLL(os.environ.get("TICKTRUE_LIBRARY", "libticktrue.so"))
OK, FULL = 0, 3
TYPES = {"d": 8, "q": 6}


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
lib.ticktrue_begin_tick.argtypes = [ctypes.c_void_p, ctypes.c_void_p]
lib.ticktrue_end_tick.argtypes = [ctypes.c_void_p]
lib.ticktrue_close.argtypes = [ctypes.c_void_p]


class Session:
    """A table of `rows` rows; `columns` has an array for each name."""

    def __init__(self, name, columns, rows):
        words = [word.encode() for word in sys.argv]
        options = Options(struct_size=ctypes.sizeof(Options), name=name.encode(), version=1, detail=FULL)
        self.handle = lib.ticktrue_open_arguments(options, len(words), (ctypes.c_char_p * (len(words) + 1))(*words, None))
        self.columns = {column: array.array(kind, [0] * rows) for column, kind in columns.items()}
        for column, values in self.columns.items():
            lib.ticktrue_column(self.handle, b"units", column.encode(), values.buffer_info()[0], TYPES[columns[column]],
                                1, rows, 0)

    def ticks(self, count):
        for tick in range(count):
            if lib.ticktrue_begin_tick(self.handle, None) != OK:
                return
            yield tick
            if lib.ticktrue_end_tick(self.handle) != OK:
                return

    def close(self):
        return lib.ticktrue_close(self.handle)
