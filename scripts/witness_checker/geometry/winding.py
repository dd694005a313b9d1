"""Winding numbers, by rays: the signed number of faces that a ray from a point crosses.

Exact: whether a ray crosses a face is the sign of three determinants of integers. A ray that meets an edge is
given up for another direction (`Grazed`), and so are points on the surface, unless it is known which faces they are on.
"""

from fractions import Fraction

import numpy as np

from ..errors import Grazed, Refuted
from .surface import FAR, TINY
from .vectors import det, dot, sign, sub

# Directions that no sane model has a plane along. The boxes need the last number not to be 0.
DIRECTIONS = [
    (1019, -733, 5003),
    (-2011, 1291, 4507),
    (577, 2939, -4001),
    (-1499, -2203, -3803),
    (3323, 701, 2909),
    (-811, 3461, 3301),
]


def shadow(surface, d):
    """Boxes of the faces seen along d, to skip most of them."""
    if d not in surface.shadows:
        slope = np.array([d[0] / d[2], d[1] / d[2]])
        with np.errstate(all="ignore"):
            flat = surface.float_points[:, :2] - surface.float_points[:, 2:] * slope
        flat = flat[surface.index]
        surface.shadows[d] = (slope, flat.min(axis=1), flat.max(axis=1))
    return surface.shadows[d]


def faces_ahead(surface, numerator, w, d):
    """Faces among which are all that the ray from numerator / w along d meets."""
    slope, low, high = shadow(surface, d)
    near = [float(Fraction(x, w * surface.scale)) for x in numerator]
    with np.errstate(all="ignore"):
        spot = np.array([near[0] - near[2] * slope[0], near[1] - near[2] * slope[1]])
        room = FAR * (surface.size + max(map(abs, near))) * (1 + np.abs(slope).max()) + TINY
        beside = (low > spot + room) | (high < spot - room)  # false for what is no number
    return np.nonzero(~beside.any(axis=1))[0]


def ahead(surface, numerator, w, d, skip=()):
    """Signed crossings of the ray from the integer point numerator / w along d.

    That is the winding number just ahead of the point, if the faces in `skip` are all that contain it.
    """
    if any(dot(surface.normal(f), d) == 0 for f in skip):
        raise Grazed
    total = 0
    for f in faces_ahead(surface, numerator, w, d):
        if f in skip:
            continue
        a, b, c = (sub((w * p[0], w * p[1], w * p[2]), numerator) for p in surface.corners(f))
        sides = {sign(det(p, q, d)) for p, q in ((a, b), (b, c), (c, a))}
        if sides >= {1, -1}:
            continue  # the line along d passes beside the face
        height = sign(det(a, b, c))  # < 0: the point is in front of the face
        facing = sign(dot(surface.normal(f), d))
        if 0 in sides or 0 in (facing, height):
            if height == 0 and facing != 0:
                raise Refuted(f"face {f} contains the place in question")
            raise Grazed
        if height == facing:
            total += facing
    return total


def winding(surface, numerator, w, skip=()):
    """The winding number just ahead of a point, and the direction in which it was looked at."""
    for d in DIRECTIONS:
        try:
            return ahead(surface, numerator, w, d, skip), d
        except Grazed:
            continue
    raise Refuted("every ray from a place in question meets an edge")


def beside(surface, numerator, w):
    """How often the rest winds around a point of a component, once that has moved (`Surface.component`)."""
    if surface.rest is None:
        return 0
    q = tuple(Fraction(x, w) for x in numerator)
    return ahead(surface.rest, numerator, w, surface.away, surface.rest.faces_at(q))
