"""Rule `stack`: coplanar faces that lie on each other, between which the winding number becomes negative.

{"rule": "stack", "face": f, "place": [x, y, z], "vertices": [...], "moves": [...], "winding": w}

Positive tets stay positive when their vertices move by little enough, whatever the moves. So a surface with a mesh still
has one when its vertices v move by eps * m_v * n, n the normal of the face named, for every small enough eps > 0, and
then its winding number is nowhere negative. The faces through the place q have it inside, and none is parallel to
n; one with q = sum b_k p_k meets the line q + s n at s = eps * sum b_k m_k after the moves. What the surface winds
around q from below, and from there on one less or more for every face in that order, says how often it winds
around what lies between.
"""

import collections
from fractions import Fraction

from ..errors import Refuted, Unreadable
from ..fields import point_of, whole_numbers
from ..geometry.ring import vertex_number
from ..geometry.vectors import cross, dot, sign, sub
from ..geometry.winding import winding


def check(surface, witness):
    vertices, moves = (whole_numbers(witness, key) for key in ("vertices", "moves"))
    if len(set(vertices)) != len(moves) or len(vertices) != len(moves):
        raise Unreadable("the witness needs as many moves as vertices")
    move = {vertex_number(surface, v): m for v, m in zip(vertices, moves)}
    face, claimed = witness.get("face"), witness.get("winding")
    if type(face) is not int or not 0 <= face < len(surface.faces):
        raise Unreadable(f"{face!r} is not a face")
    numerator, w = point_of(surface, witness, "place")
    n = surface.normal(face)
    heights = heights_of(surface, tuple(Fraction(x, w) for x in numerator), n, move)
    level = below = lowest = winding_below(surface, numerator, w, n, heights)
    steps = collections.Counter()
    for f, height in heights.items():
        steps[height] -= sign(dot(surface.normal(f), n))
    for height in sorted(steps):
        level += steps[height]
        lowest = min(lowest, level)
    if lowest >= 0:
        raise Refuted(f"the winding number is nowhere below {lowest} after the moves")
    if lowest != claimed:
        raise Refuted(f"the winding number is {lowest} after the moves, not {claimed}")
    return f"the winding number goes from {below} to {lowest} in a stack of {len(heights)} faces"


def heights_of(surface, q, n, move):
    """The faces that have the point q inside, and how far each moves there, to eps and the length of n."""
    heights = {}
    for f in surface.faces_near(q):
        corners, normal = surface.corners(f), surface.normal(f)
        if dot(normal, sub(q, corners[0])) != 0:
            continue
        weights = [dot(normal, cross(sub(corners[k - 1], corners[k - 2]), sub(q, corners[k - 2]))) for k in range(3)]
        if min(weights) < 0:
            continue
        if min(weights) == 0 or dot(normal, n) == 0:
            raise Refuted(f"the place is on the border of face {f}, or the face is parallel to the moves")
        heights[f] = sum(x * move.get(v, 0) for x, v in zip(weights, surface.faces[f])) / Fraction(sum(weights))
    if not heights:
        raise Refuted("no face has the place inside")
    return heights


def winding_below(surface, numerator, w, n, through):
    """The winding number next to a point inside of these faces, on the side of all of them that is against n."""
    level, d = winding(surface, numerator, w, set(through))
    for f in through:
        side = sign(dot(surface.normal(f), d))
        if side == sign(dot(surface.normal(f), n)):
            level += side
    return level
