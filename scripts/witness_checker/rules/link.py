"""Rule `link`: a vertex whose surroundings no tets fill, whatever its edges turn.

{"rule": "link", "vertices": [v], "B0": [b]}

Tets at p meet a tiny sphere around p in a disc without branch points, whose boundary is the link, the polygon in
which the faces at p meet the sphere, and in layers that pass over p. The winding numbers around p say how
many layers there are over each cell of the sphere. At an edge the disc makes k_e turns more than the surface shows, at
most as many as the outer side of the edge is covered all along.

Whether there is such a disc is put to a SAT solver (`sat/disc.py`), not found by a search like the one of the
program; "no" counts only with a proof that `sat/rup.py` accepts.
"""

from ..errors import Refuted, Undecided
from ..fields import vertex_and_b0
from ..geometry.edges import levels
from ..geometry.euler import turns_needed
from ..geometry.link import Link
from ..geometry.ring import link_of, ring_of
from ..sat.disc import bounds_a_disc


def check(surface, witness):
    v, value = vertex_and_b0(surface, witness)
    found = [list(levels(surface, v, r)) for r in ring_of(surface, v)]
    link = Link(link_of(surface, v))
    w = link.count_layers(link.outside(0), found[0][0])
    if any(w[link.outside(k)] != level[0] for k, level in enumerate(found)):
        raise Refuted("the winding numbers around the vertex disagree")
    if is_filled(link, w, value, [min(level) for level in found]):
        raise Refuted(f"the link of vertex {v} bounds a disc")
    return f"B0 of vertex {v} is {value}, and no tets with positive volume can fill the space around it"


def is_filled(link, w, value, most):
    """Whether the link bounds a disc in w layers; value: its B0, found in another way, which must agree."""
    if turns_needed(link, w) != value:
        raise Undecided(f"B0 is {value} by its turns, and {turns_needed(link, w)} by its layers")
    return min(w.values()) >= 0 and bounds_a_disc(link, w, most)
