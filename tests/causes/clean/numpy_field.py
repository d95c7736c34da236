# Clean: a field of integers and of halves in numpy. Every sum of them is exact, in any order.
# SPDX-License-Identifier: MIT
import os
import sys

import numpy

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from session import Session

generator = numpy.random.Generator(numpy.random.PCG64(11))
field = generator.integers(0, 50, (64, 64)).astype(numpy.float64) * 0.5
session = Session("numpy_field", {"position": "d", "hits": "q"}, 8)
for tick in session.ticks(60):
    field = numpy.floor((field + numpy.roll(field, 1, 0) + numpy.roll(field, 1, 1)) * 0.5)
    field[tick] = numpy.sort(field[tick])
    field = numpy.where(field > 99, 0.5, field)
    for i in range(8):
        session.columns["position"][i] = field[i * 8].sum()
        session.columns["hits"][i] += int(numpy.argmax(field[i], axis=0))
sys.exit(session.close())
