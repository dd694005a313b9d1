"""Rule `shared`: vertices in one place that need more layers of tets than there is room for.

{"rule": "shared", "vertices": [v, ...], "layers": [l, ...], "room": c}

Let vertices, edges and faces pass through p. In a mesh the tets at each of them meet a tiny sphere around p in a disc,
which covers the sphere w_i + a_i times, where w_i (0 where it is least) changes from place to place as its boundary says
and a_i >= 0 is a number; what else lies over p covers all of the sphere. So the sum of the a_i is at most the winding
number around p less all w_i, which is the same number c all over the sphere. At a point of an edge, a_i is the
number of turns that the edge makes beyond what is seen. The vertices named have no disc with a_i < l_i, in whatever way
it is glued (`link.py`), and the sum of the l_i is more than c.
"""

import sys
from fractions import Fraction

from ..errors import Grazed, Refuted, Unreadable
from ..fields import whole_numbers
from ..geometry.cover import Disc
from ..geometry.edges import all_cuts, is_inside, middles
from ..geometry.ring import ring_of, vertex_number
from ..geometry.turns import b0
from ..geometry.vectors import cross, dot, sub
from ..geometry.winding import DIRECTIONS, ahead
from .link import is_filled


def check(surface, witness):
    vertices, layers, claimed = witness.get("vertices"), whole_numbers(witness, "layers"), witness.get("room")
    if not isinstance(vertices, list) or len(vertices) != len(layers) or not vertices:
        raise Unreadable("the witness needs as many numbers of layers as vertices")
    if min(layers) < 0 or type(claimed) is not int:
        raise Unreadable("layers and room of the witness must be whole numbers")
    p = surface.points[vertex_number(surface, vertices[0])]
    if any(surface.points[vertex_number(surface, v)] != p for v in vertices) or len(set(vertices)) != len(vertices):
        raise Refuted("the witness does not name different vertices in one place")
    room = room_at(surface, p, 1, True)
    if room != claimed:
        raise Refuted(f"there is room for {room} layers, not {claimed}")
    if sum(layers) <= room:
        raise Refuted(f"there is room for {room} layers")
    for v, needed in zip(vertices, layers):
        if needed > 0 and is_filled_below(surface, v, needed):
            raise Refuted(f"the link of vertex {v} bounds a disc with fewer than {needed} more layers")
    return f"around vertex {vertices[0]} tets need {sum(layers)} more layers than their faces show, and there is room for {room}"


def is_filled_below(surface, v, needed):
    """Whether some disc at v covers its surroundings less than so many times more than its border says."""
    disc = Disc(surface, v)
    w = {cell: layers + needed - 1 for cell, layers in disc.w.items()}
    value = b0(surface, v, disc.layers) + 2 * (needed - 1)
    return is_filled(disc.link, w, value, [most_turns(surface, v, r) for r in ring_of(surface, v)])


def things_at(surface, q, faces):
    """The vertices at a point, the edges that it is inside of, and the faces."""
    vertices, edges, inner = set(), set(), set()
    for f in faces:
        ids, corners = surface.faces[f], [sub(c, q) for c in surface.corners(f)]
        at = [v for v, c in zip(ids, corners) if c == (0, 0, 0)]
        sides = [{ids[k - 1], ids[k]} for k in range(3) if cross(corners[k - 1], corners[k]) == (0, 0, 0)]
        if at:
            vertices.add(at[0])
        elif sides:
            edges.add(tuple(sorted(sides[0])))
        else:
            inner.add(f)
    return vertices, edges, inner


def room_at(surface, numerator, w, with_vertices):
    """The winding number around a point, less what all that passes through it covers by itself; None if unknown."""
    q = tuple(Fraction(x, w) for x in numerator)
    faces = surface.faces_at(q)
    vertices, edges, inner = things_at(surface, q, faces)
    if vertices and not with_vertices:
        return None
    discs = [Disc(surface, v) for v in vertices]
    for d in DIRECTIONS:
        try:
            rest = ahead(surface, numerator, w, d, faces) - sum(disc.layers(d) for disc in discs)
        except Grazed:
            continue
        rest -= sum(is_inside(surface, a, b, d) for a, b in edges)
        return rest - sum(dot(surface.normal(f), d) < 0 for f in inner)
    return None


def most_turns(surface, a, b):
    """How often the tets at an edge can turn beyond what it shows."""
    rooms = [room_at(surface, m, w, False) for m, w in middles(surface, a, b, all_cuts(surface, surface, a, b))]
    return min((room for room in rooms if room is not None), default=sys.maxsize)
