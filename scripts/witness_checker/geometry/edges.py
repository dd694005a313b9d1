"""How often the outer side of an edge is covered by something else, from crossing to crossing.

An edge can turn further than its faces show only where the space outside of it is covered, all along, and at most
as many times as it is covered where it is covered least.
"""

from fractions import Fraction

from ..errors import Grazed, Refuted
from .vectors import cross, det, dot, sign, sub
from .winding import beside, winding


def middles(surface, a, b, cuts):
    """A point of edge a-b in each piece between cuts, as (numerator, denominator)."""
    pa, e = surface.points[a], sub(surface.points[b], surface.points[a])
    cuts = sorted(cuts | {Fraction(0), Fraction(1)})
    for begin, end in zip(cuts, cuts[1:]):
        t = (begin + end) / 2
        yield tuple(t.denominator * pa[k] + t.numerator * e[k] for k in range(3)), t.denominator


def levels(surface, a, b):
    """The winding numbers on the outer side of edge a-b, from a on, between its crossings with other faces."""
    own = {surface.twin[a, b], surface.twin[b, a]}
    cuts = own_cuts(surface, a, b, own)
    if surface.rest is not None:
        cuts |= all_cuts(surface, surface.rest, a, b)
    for m, w in middles(surface, a, b, cuts):
        level, d = winding(surface, m, w, own)
        level -= is_inside(surface, a, b, d)
        try:
            yield level + beside(surface, m, w)
        except Grazed:
            pass  # nothing is known of this piece: others may do


def is_covered(surface, a, b):
    """Whether the outer side of edge a-b has winding number >= 1 between all its crossings with other faces."""
    return all(level >= 1 for level in levels(surface, a, b))


def own_cuts(surface, a, b, own):
    """Where edge a-b meets the planes of other faces near it: too many cuts do no harm."""
    pa, e = surface.points[a], sub(surface.points[b], surface.points[a])
    cuts = set()
    for g in surface.faces_in(*surface.box(a, b)):
        if g in own:
            continue
        n = surface.normal(g)
        here, slope = dot(n, sub(pa, surface.corners(g)[0])), dot(n, e)
        if slope != 0:
            cuts |= inner(-here, slope)
        elif here == 0:
            cuts |= flat_cuts(surface, pa, e, g, n)
    return cuts


def inner(numerator, denominator):
    """The quotient, where it is inside of an edge."""
    t = Fraction(numerator, denominator)
    return {t} if 0 < t < 1 else set()


def flat_cuts(surface, pa, e, g, n):
    """Where the edge from pa along e touches face g, in whose plane (normal n) it runs."""
    corners = surface.corners(g)
    first, last = Fraction(0), Fraction(1)
    for k in range(3):
        wall = cross(n, sub(corners[(k + 1) % 3], corners[k]))  # points into the face
        here, slope = dot(wall, sub(pa, corners[k])), dot(wall, e)
        if slope > 0:
            first = max(first, Fraction(-here, slope))
        elif slope < 0:
            last = min(last, Fraction(-here, slope))
        elif here < 0:
            return set()
    if first > last:
        return set()
    if first < last:
        raise Refuted(f"an edge runs inside face {g}, where its outer side is not defined")
    return {first}


def all_cuts(surface, rest, a, b):
    """Where edge a-b meets faces of `rest`, or enters and leaves those in whose planes it runs, and more."""
    pa, e = surface.points[a], sub(surface.points[b], surface.points[a])
    cuts = set()
    for g in rest.faces_in(*surface.box(a, b)):
        corners, n = rest.corners(g), rest.normal(g)
        walls = [(n, corners[0])] + [(cross(n, sub(corners[k - 2], corners[k])), corners[k]) for k in range(3)]
        for wall, o in walls if dot(n, e) == 0 else walls[:1]:
            slope = dot(wall, e)
            if slope != 0:
                cuts |= inner(-dot(wall, sub(pa, o)), slope)
    return cuts


def is_inside(surface, a, b, d):
    """Whether a direction from a point of edge a-b leads into the inside, as its two faces show it."""
    left, right = surface.twin[a, b], surface.twin[b, a]
    pa, e = surface.points[a], sub(surface.points[b], surface.points[a])

    def third(f):
        return sub(surface.points[next(v for v in surface.faces[f] if v not in (a, b))], pa)

    after, before = third(left), third(right)
    side = sign(det(e, after, before))
    behind_left, behind_right = dot(surface.normal(left), d) < 0, dot(surface.normal(right), d) < 0
    if side == 0:
        return dot(cross(e, after), cross(e, before)) > 0 or behind_left  # a fold is a full turn
    if side < 0:  # less than half a turn inside
        return behind_left and behind_right
    return behind_left or behind_right
