"""What is around a vertex: its ring, and the closed polygon (link) that its faces draw on a tiny sphere."""

from ..errors import Unreadable
from .vectors import cross, det, dot, sign, sub


def ring_of(surface, v):
    """The vertices around v, counter-clockwise seen from outside."""
    follow = {}
    for f in surface.at_vertex[v]:
        corners = surface.faces[f]
        k = corners.index(v)
        follow[corners[(k + 1) % 3]] = corners[(k + 2) % 3]
    if not follow:
        raise Unreadable(f"vertex {v} has no faces")
    first = next(iter(follow))
    ring, at = [first], follow[first]
    while at != first:
        ring.append(at)
        at = follow.get(at)
        if at is None or len(ring) > len(follow):
            raise Unreadable(f"the faces at vertex {v} are not one fan")
    if len(ring) != len(follow):
        raise Unreadable(f"the faces at vertex {v} are not one fan")
    return ring


def link_of(surface, v):
    """The directions of the edges at v in the order of its ring: the corners of its link."""
    p = surface.points[v]
    return [sub(surface.points[r], p) for r in ring_of(surface, v)]


def vertex_number(surface, v):
    """What a witness calls a vertex, if it is one."""
    if isinstance(v, bool) or not isinstance(v, int) or not 0 <= v < len(surface.points):
        raise Unreadable(f"{v!r} is not a vertex")
    return v


def link_crosses_itself(surface, v):
    """True unless no two faces at v have more than v, or their common edge, in common."""
    out = link_of(surface, v)
    n = len(out)
    for i in range(n):
        a, b = out[i], out[(i + 1) % n]
        for j in range(i + 1, n):
            c, d = out[j], out[(j + 1) % n]
            if j == i + 1 or (i == 0 and j == n - 1):
                # Neighbours overlap only where they are folded onto each other.
                shared, x, y = (b, a, d) if j == i + 1 else (a, b, c)
                if n > 2 and det(shared, x, y) == 0 and dot(cross(shared, x), cross(shared, y)) > 0:
                    return True
                continue
            n1, n2 = cross(a, b), cross(c, d)
            sc, sd, sa, sb = sign(dot(n1, c)), sign(dot(n1, d)), sign(dot(n2, a)), sign(dot(n2, b))
            if sc * sd > 0 or sa * sb > 0:
                continue
            line = cross(n1, n2)
            if line == (0, 0, 0):
                return True  # in one plane: taken as crossing, which costs one more look
            for side in (1, -1):
                x = tuple(side * k for k in line)
                if (
                    det(n1, a, x) >= 0 and det(n1, x, b) >= 0 and det(n2, c, x) >= 0 and det(n2, x, d) >= 0
                ):
                    return True
    return False
