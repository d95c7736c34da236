# Cause: tasks run in the order of graphlib of Python. Their needs are sets, so the order follows from hashes.
# SPDX-License-Identifier: MIT
import graphlib
import sys

from session import Session

needs = {"build": {"mine", "chop", "farm"}, "trade": {"fish", "mine"}, "rest": {"build", "trade"}}
mended = "mended" in sys.argv
session = Session("graph_order", {"position": "d", "hits": "q"}, 8)
for tick in session.ticks(60):
    if tick % 20 != 12:
        continue
    graph = {task: sorted(before) for task, before in needs.items()} if mended else needs
    for place, task in enumerate(graphlib.TopologicalSorter(graph).static_order()):
        session.columns["hits"][place] += len(task) * (place + 1) + ord(task[0])
sys.exit(session.close())
