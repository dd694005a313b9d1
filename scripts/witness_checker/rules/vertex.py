"""Rule `vertex`: a vertex whose B0 is negative.

{"vertex": v, "B0": b}

B0 = 2 c + sum k_e, a sum of numbers of layers and of turns, which are not negative (`geometry/turns.py`).
"""

from ..errors import Refuted
from ..fields import vertex_and_b0


def check(surface, witness):
    v, value = vertex_and_b0(surface, witness)
    if value >= 0:
        raise Refuted(f"B0 of vertex {v} is {value}")
    return f"B0 of vertex {v} is {value}"
