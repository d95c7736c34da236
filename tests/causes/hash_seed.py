# Cause: a set of names is walked in the order of their hashes, which Python changes in every run.
# SPDX-License-Identifier: MIT
import sys

from session import Session

names = ["ada", "bea", "cleo", "dora", "elin", "fay"]
mended = "mended" in sys.argv

session = Session("hash_seed", {"position": "d", "hits": "q"}, len(names))
for tick in session.ticks(60):
    total = 0.0
    if tick >= 18:
        for name in sorted(names) if mended else set(names):
            total = total * 0.5 + len(name) + names.index(name)
    for i in range(len(names)):
        session.columns["position"][i] += 0.25 + 1e-3 * total
sys.exit(session.close())
