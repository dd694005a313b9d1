"""B0 by its definition: areas and angles, in doubles."""

import math


def unit(x):
    length = math.sqrt(sum(float(c) ** 2 for c in x))
    return [c / length for c in x]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[k - 2] * b[k - 1] - a[k - 1] * b[k - 2] for k in range(3)]


def turn_left(a, b, c):
    """The angle by which one turns left at b, on the way on the sphere from a to c."""
    before, after = unit(cross(a, b)), unit(cross(b, c))
    return math.atan2(dot(unit(b), cross(before, after)), dot(before, after))


def angle_b0(out, link, w):
    """Of a link with so many layers over its cells, the ring having the outside on its left.

    The area of a cell is 2 pi less what one turns on its border, with the cell on the left.
    """
    n = len(out)
    total = 0.0
    turned = dict.fromkeys(w, 0.0)
    for node, halves in enumerate(link.around):
        ends = [link.pieces[k][1] if begins else link.pieces[k][0] for k, begins in halves]
        for (k, begins), x, y in zip(halves, ends, ends[1:] + ends[:1]):
            # The sector from one half to the next: its border comes in along the next one, and leaves along this.
            turned[link.cell[k, begins]] += turn_left(link.at[y], link.at[node], link.at[x])
    for cell, layers in w.items():
        total += layers * (2 * math.pi - turned[cell])
    # The inside is on the right: the outside turns the other way.
    total += sum(-turn_left(out[i - 1], out[i], out[(i + 1) % n]) for i in range(n))
    value = total / (2 * math.pi) - 1
    assert abs(value - round(value)) < 1e-6, value
    return round(value)

