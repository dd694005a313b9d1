"""Rule `unpaired`: an odd number of vertices with odd B0 that covered edges join to each other and to no others.

{"rule": "unpaired", "vertices": [...], "B0": [...]}

An edge can have k_e > 0 only where the space outside of it is covered by something else all along: winding number
>= 1 on its outer side between all crossings with other faces. Summed over all vertices that such edges join,
every k_e counts twice, and so the sum of their B0 = 2 c + sum k_e is even. Vertices whose faces do not pass through each
other have an even B0 themselves.

With a key "apart": [x, y, z] the witness is about the component of the vertices named (B0, too), moved from the rest of
the surface by as little as you like in this direction. Positive tets stay positive when their vertices move by little
enough, so a surface with a mesh still has one when one of its components moves by eps * d, for every small enough eps >
0. Then it does not touch the rest any more: next to a point x of the component the rest winds around space as often as
just ahead of x in direction d. That number is added to the levels of edges (at some points of them, which is
enough for an upper bound).
"""

import collections

from ..errors import Grazed, Refuted, Unreadable
from ..fields import vertices_and_b0, whole_numbers
from ..geometry.edges import is_covered
from ..geometry.ring import link_crosses_itself, ring_of, vertex_number
from ..geometry.turns import b0
from ..geometry.winding import beside


def check(surface, witness):
    if "apart" in witness:
        surface = moved_apart(surface, witness)
    try:
        return check_group(surface, witness)
    except Grazed as e:
        raise Refuted("the component still touches the rest when it has moved") from e


def moved_apart(surface, witness):
    away, vertices = whole_numbers(witness, "apart"), witness.get("vertices")
    if len(away) != 3 or away[2] == 0:
        raise Unreadable("the witness's direction is not three whole numbers, the last of them not 0")
    if not isinstance(vertices, list) or not vertices:
        raise Unreadable("the witness names no vertex")
    return surface.component(vertex_number(surface, vertices[0]), tuple(away))


def check_group(surface, witness):
    found = vertices_and_b0(surface, witness)
    group = [v for v, _ in found]
    if len(set(group)) != len(group):
        raise Unreadable("the witness names a vertex twice")
    for v, value in found:
        if value % 2 == 0:
            raise Refuted(f"B0 of vertex {v} is even")
    odd = odd_vertices(surface, group)
    if len(odd) % 2 == 0:
        raise Refuted(f"covered edges join {len(odd)} vertices with odd B0, an even number: {sorted(odd)}")
    more = "" if len(odd) == len(group) else f" (the witness names {len(group)})"
    return f"covered edges join {len(odd)} vertices with odd B0{more}, which cannot be paired: {sorted(odd)}"


def odd_vertices(surface, group):
    """The vertices with odd B0 among all that covered edges join to the vertices named."""
    used = collections.Counter(p for p, faces in zip(surface.points, surface.at_vertex) if faces)
    seen, stack, odd = set(group), list(group), []
    while stack:
        v = stack.pop()
        beside(surface, surface.points[v], 1)  # it must not touch the rest
        if used[surface.points[v]] > 1:  # they share their layers, and the sum for one of them means nothing
            raise Refuted(f"another vertex lies where vertex {v} does")
        if v in group or (link_crosses_itself(surface, v) and b0(surface, v) % 2 != 0):
            odd.append(v)
        for r in ring_of(surface, v):
            if r not in seen and is_covered(surface, min(v, r), max(v, r)):
                seen.add(r)
                stack.append(r)
    return odd
