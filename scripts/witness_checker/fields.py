"""What witnesses hold: numbers, points, lists; and refusals of what is none of these."""

import math
from fractions import Fraction

from .errors import Refuted, Undecided, Unreadable
from .geometry.euler import b0_by_counting
from .geometry.ring import vertex_number
from .geometry.turns import b0


def whole_number(witness, key):
    try:
        return int(witness[key])
    except (TypeError, ValueError, OverflowError, KeyError) as e:
        raise Unreadable(f"the witness's number {key!r} cannot be read: {e}") from e


def whole_numbers(witness, key):
    out = witness.get(key)
    if not isinstance(out, list) or not all(type(x) is int for x in out):
        raise Unreadable(f"{key!r} of the witness is not a list of whole numbers")
    return out


def number_pairs(witness, key):
    out = witness.get(key)
    if not isinstance(out, list) or not all(
        isinstance(x, list) and len(x) == 2 and all(type(y) is int for y in x) for x in out
    ):
        raise Unreadable(f"{key!r} of the witness is not a list of pairs of whole numbers")
    return out


def point_of(surface, witness, key):
    """A point (numbers, or fractions as text) in the surface's integers: (numerator, denominator)."""
    try:
        point = [Fraction(x) * surface.scale for x in witness[key]]
    except (TypeError, ValueError, ZeroDivisionError, OverflowError, KeyError) as e:
        raise Unreadable(f"{key!r} of the witness is not three numbers: {e}") from e
    if len(point) != 3:
        raise Unreadable(f"{key!r} of the witness is not three numbers")
    w = math.lcm(*(x.denominator for x in point))
    return tuple(int(x * w) for x in point), w


def vertices_and_b0(surface, witness):
    """The vertices that a witness names, whose B0 is what it says: [(vertex, B0)]."""
    if "vertex" in witness:
        vertices, values = [witness["vertex"]], [witness.get("B0")]
    else:
        vertices, values = witness.get("vertices"), witness.get("B0")
    if not isinstance(vertices, list) or not isinstance(values, list) or len(vertices) != len(values) or not vertices:
        raise Unreadable("the witness needs as many values B0 as vertices")
    for v, claimed in zip(vertices, values):
        value = sure_b0(surface, vertex_number(surface, v))
        if value != claimed:
            raise Refuted(f"B0 of vertex {v} is {value}, not {claimed}")
    return list(zip(vertices, values))


def sure_b0(surface, v):
    """B0 of a vertex, found in two ways, the second where its link is in general position."""
    value = b0(surface, v)
    try:
        other = b0_by_counting(surface, v)
    except Refuted:
        return value
    if other not in (None, value):
        raise Undecided(f"B0 of vertex {v} is {value} by its turns, and {other} by its layers")
    return value


def vertex_and_b0(surface, witness):
    """The same of a witness about one vertex."""
    if isinstance(witness.get("vertices"), list) and len(witness["vertices"]) != 1:
        raise Unreadable("the witness needs one vertex and its B0")
    return vertices_and_b0(surface, witness)[0]
