"""Decisions in integers. Doubles become integers first: all of a model's times one power of two."""


def integers(points):
    """The points times the smallest power of two that makes all coordinates integers."""
    ratios = [tuple(float(x).as_integer_ratio() for x in p) for p in points]
    unit = max((d for p in ratios for _, d in p), default=1)
    return [tuple(n * (unit // d) for n, d in p) for p in ratios]


def volume(a, b, c, d):
    """Six times the volume of the tet, positive if the tet is."""
    ax, ay, az = a
    bx, by, bz = b[0] - ax, b[1] - ay, b[2] - az
    cx, cy, cz = c[0] - ax, c[1] - ay, c[2] - az
    dx, dy, dz = d[0] - ax, d[1] - ay, d[2] - az
    return bx * (cy * dz - cz * dy) - by * (cx * dz - cz * dx) + bz * (cx * dy - cy * dx)


def normal(a, b, c):
    ux, uy, uz = (b[k] - a[k] for k in range(3))
    vx, vy, vz = (c[k] - a[k] for k in range(3))
    return (uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx)


def turns(a, b, ring):
    """How often a closed ring of points goes around the line from a to b. Each step is less than half a turn, in
    the positive sense: that of positive tets (a, b, p, q)."""
    first = ring[0]
    side = [volume(a, b, p, first) for p in ring]
    # The first point's direction lies in the half-open arc from p to q. To the left of p is `side` positive.
    return sum(side[i] >= 0 > side[(i + 1) % len(ring)] for i in range(len(ring)))
