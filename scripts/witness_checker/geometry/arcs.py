"""Where arcs of great circles cross: the link of a vertex, or two faces with a common corner."""

from ..errors import Refuted
from .vectors import cross, det, dot, sign


def cross_at(a, b, c, d):
    """Where arcs a-b and c-d cross: (direction, True where c-d goes to the left of a-b), or None.

    They must not touch. Arcs are shorter than half a great circle.
    """
    n1, n2 = cross(a, b), cross(c, d)
    sa, sb, sc, sd = (sign(dot(m, x)) for m, x in ((n2, a), (n2, b), (n1, c), (n1, d)))
    if 0 in (sa, sb, sc, sd):

        def within(x, normal, begin, end):
            return dot(normal, x) == 0 and det(normal, begin, x) >= 0 and det(normal, x, end) >= 0

        if any((within(c, n1, a, b), within(d, n1, a, b), within(a, n2, c, d), within(b, n2, c, d))):
            raise Refuted("faces at the vertex touch, but do not cross, each other")
        return None
    if sa == sb or sc == sd or sa == sc:
        return None
    return tuple(sa * x for x in cross(n1, n2)), sd > 0


def is_fold(shared, x, y):
    """Whether arcs from a shared corner to x and y begin in the same direction."""
    return det(shared, x, y) == 0 and dot(cross(shared, x), cross(shared, y)) > 0
