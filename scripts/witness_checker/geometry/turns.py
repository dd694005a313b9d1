"""B0, the integer of a vertex that says how many turns tets at it must make.

Let p be a vertex, theta_i the angles inside at its edges, A the winding number integrated over a tiny sphere
around p. By Gauss and Bonnet, what positive tets do around p satisfies

    B0 = (A + sum (pi - theta_i)) / (2 pi) - 1 = 2 c + sum k_e

with c >= 0 layers that pass over p and k_e >= 0 full turns that the tets at edge e make beyond theta_e.

No angle is computed here. Choose a direction d. Walk along the link, the inside on the left, and compare where you head
with east, the way the sphere turns about d. The field of these directions has index 1 at d and at -d, and
nowhere else, so that by Gauss and Bonnet (or Poincare and Hopf)

    (A + sum (pi - theta_i)) / (2 pi) = r + w(d) + w(-d)

with w the winding number and r the number of times that the heading passes due east, counter-clockwise. On an arc it
does so at most once, where the great circle is farthest from the equator; at a corner it turns by less than pi, or
by pi clockwise at a fold (a full turn inside). So B0 is a sum of signs of determinants.
"""

from ..errors import Grazed, Refuted, Unreadable
from .ring import link_of
from .vectors import cross, det, dot, sign
from .winding import DIRECTIONS, ahead


def opposite(d):
    return (-d[0], -d[1], -d[2])


def turns_past_east(out, d):
    """How often the heading along the link passes east about d, counter-clockwise, with the inside on the left."""
    walk = out[::-1]  # the ring has the outside on the left
    total = 0
    arcs = [(a, b, cross(a, b)) for a, b in zip(walk, walk[1:] + walk[:1])]
    for (_, b, normal), (_, c, following) in zip(arcs, arcs[1:] + arcs[:1]):
        north, north_after = sign(det(normal, b, d)), sign(det(following, b, d))
        if 0 in (north, north_after):
            raise Grazed
        side = sign(dot(normal, c))
        if side == 0 and dot(normal, following) < 0:
            side = -1  # a fold
        if north == -side and north_after == side:
            total += side
    for a, b, normal in arcs:
        start, end, eastward = sign(det(normal, a, d)), sign(det(normal, b, d)), sign(dot(normal, d))
        if 0 in (start, end, eastward):
            raise Grazed
        if eastward > 0 and start != end:
            total += end
    return total


def b0(surface, v, layers=None):
    """B0 of a vertex; layers: how often what is around it is covered in a direction, if not the winding number."""
    out = link_of(surface, v)
    if any(cross(a, b) == (0, 0, 0) for a, b in zip(out, out[1:] + out[:1])):
        raise Unreadable(f"a face at vertex {v} has no area")
    own = set(surface.at_vertex[v])
    for d in DIRECTIONS:
        try:
            turns = turns_past_east(out, d)
            if layers:
                return turns + layers(d) + layers(opposite(d)) - 1
            return turns + sum(ahead(surface, surface.points[v], 1, x, own) for x in (d, opposite(d))) - 1
        except Grazed:
            continue
    raise Refuted(f"every direction from vertex {v} meets an edge")
