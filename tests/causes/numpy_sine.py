# Cause: angles are floats of 32 bits in numpy, whose sine has other bits on processors without AVX2 and FMA.
# SPDX-License-Identifier: MIT
import math
import sys

import numpy

from session import Session

mended = "mended" in sys.argv
count = 8
session = Session("numpy_sine", {"position": "d", "hits": "q"}, count)
angles = numpy.arange(count * 50, dtype=numpy.float32).reshape(count, 50)
for tick in session.ticks(60):
    if tick < 20:
        continue
    turned = angles * numpy.float32(0.37) + numpy.float32(tick)
    # Mended: whole steps of a table that the setup could hold.
    heights = numpy.floor(turned) % 7 if mended else numpy.sin(turned)
    for i in range(count):
        session.columns["position"][i] += math.fsum(float(height) for height in heights[i])
sys.exit(session.close())
