# Clean: lists, sorted sets, a generator with a seed of its own.
# SPDX-License-Identifier: MIT
import os
import random
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from session import Session

names = ["ada", "bea", "cleo", "dora", "elin", "fay"]
generator = random.Random(5)
session = Session("clean_python", {"position": "d", "hits": "q"}, len(names))
for tick in session.ticks(60):
    for name in sorted({name[:2] for name in names}):
        session.columns["position"][tick % len(names)] += len(name) * 0.25
    session.columns["hits"][generator.randrange(len(names))] += 1
sys.exit(session.close())
