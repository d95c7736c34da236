# Clean: a market of dictionaries, which keep their order, sorted by price and name; integers alone.
# SPDX-License-Identifier: MIT
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from session import Session

goods = ["wood", "iron", "salt", "wool", "fish", "gold"]
prices = {name: 10 + len(name) * i for i, name in enumerate(goods)}
session = Session("python_market", {"position": "d", "hits": "q"}, len(goods))
for tick in session.ticks(60):
    cheapest = min(prices, key=lambda name: (prices[name], name))
    prices[cheapest] += 3
    if tick % 7 == 6:
        prices.pop(cheapest)
        prices[cheapest] = 12
    for place, (name, price) in enumerate(prices.items()):
        session.columns["hits"][goods.index(name)] += price * (place + 1)
sys.exit(session.close())
