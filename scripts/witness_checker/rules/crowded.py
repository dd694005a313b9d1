"""Rule `crowded`: a vertex whose edges have no room for the turns that B0 asks for.

{"rule": "crowded", "vertices": [v], "B0": [b]}

B0 = 2 c + sum k_e. The number of times that the outer side of an edge is covered, where it is least, bounds k_e. Next to
the vertex it bounds c + k_e, since layers over the vertex cover everything around it.
"""

from ..errors import Refuted
from ..fields import vertex_and_b0
from ..geometry.edges import levels
from ..geometry.ring import ring_of


def check(surface, witness):
    v, value = vertex_and_b0(surface, witness)
    room = []  # next to the vertex, all along
    for r in ring_of(surface, v):
        found = list(levels(surface, v, r))
        room.append((found[0], min(found)))
    most = max(0, min(value // 2, min(near for near, _ in room)))
    for c in range(most + 1):
        turns = sum(max(0, min(near - c, least)) for near, least in room)
        if turns >= value - 2 * c:
            raise Refuted(f"the edges of vertex {v} have room for {turns} turns, with {c} layers over it")
    return f"B0 of vertex {v} is {value}, and its edges have no room for so many turns"
