# Cause: math.sin is that of the C library, whose last bit depends on the processor.
# SPDX-License-Identifier: MIT
import math
import sys

from session import Session

mended = "mended" in sys.argv
session = Session("libm_python", {"position": "d"}, 8)
position = session.columns["position"]
for tick in session.ticks(40):
    for i in range(8):
        for k in range(100):
            angle = position[i] * (3 + k) + tick + i
            # Mended: rounds to so few bits that an ulp of the library has no effect.
            position[i] += round(math.sin(angle) * 1024) / 1024 if mended else math.sin(angle)
sys.exit(session.close())
