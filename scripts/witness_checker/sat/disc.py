"""Whether a link bounds a disc in so many layers, as a formula.

Tets at p meet a tiny sphere around p in triangles that all turn the same way. With one turn around every interior edge
they make surfaces that lie on the sphere without branch points: one whose boundary is the link, and c others
without boundary. The link cuts the sphere into cells with winding numbers w, which are the numbers of layers of all
of them together.

A surface without boundary or branch points that lies on the sphere covers it just once, since the sphere has no other
coverings. So it has one layer over every cell. Take the c surfaces away: w - c layers are left, which are
glued into one surface, and from each of them one comes to the boundary.

That one is a disc just when its Euler number is 1, which says what the sum of the k_e must be (`geometry/euler.py`;
it is B0 - 2 c). The formula says, for one c: gluings of w - c layers over the pieces that are right around
crossings and corners (`layers.py`), sum k is this number, each k at most what its edge has room for, and no
layer makes a surface without boundary. The last: follow a layer over the cell that has the least layers
along a tree to all other cells. It makes a closed surface just when it never ends and no other piece leads
somewhere else.
"""

from ..geometry.euler import at_crossing, turns_needed
from ..sets import Sets
from .formula import FALSE, TRUE, Formula
from .layers import around_crossing, around_edge, gluing
from .names import name_layers
from .solver import can_be_satisfied


def bounds_a_disc(link, w, most):
    """w: {cell: layers}; most: per corner the turns that its edge has room for; negative where nothing is possible."""
    if min(most) < 0:
        return False
    fewer = ({cell: m - c for cell, m in w.items()} for c in range(min(w.values()) + 1))
    return any(can_be_satisfied(disc_formula(link, x, most, turns_needed(link, x))) for x in fewer)


def disc_formula(link, w, most, number):
    """Gluings of so many layers into one surface, with so many extra turns together."""
    formula, alike = Formula(), Sets()
    for k in range(link.corners):
        if min(most[k], w[link.outside(k)]) <= 0:  # no turns: glued alike on both sides
            alike.join(link.into[(k - 1) % link.corners, k], link.outof[k, k])
    pieces = [alike.root(k) for k in range(len(link.pieces))]
    regions = {x: (link.left(x), link.right(x)) for x in pieces}
    kinds = name_layers(regions, w)
    ways = {x: gluing(formula, w[outer], kinds[x]) for x, (outer, _) in regions.items()}
    ways = [ways[x] for x in pieces]
    for k in range(len(link.crossings)):
        around_crossing(formula, *(ways[x] for x in at_crossing(link, k)))
    turns = []
    for k in range(link.corners):
        before, after = link.into[(k - 1) % link.corners, k], link.outof[k, k]
        if alike.root(before) != alike.root(after) or min(most[k], w[link.outside(k)]) > 0:
            turns += around_edge(formula, ways[before], ways[after], most[k])
    formula.count_is(turns, number)
    base = min(w, key=w.get)
    for layer in range(w[base]):
        comes_to_an_end(formula, link, w, ways, base, layer)
    return formula


def comes_to_an_end(formula, link, w, ways, base, layer):
    """The layer over cell `base` is no part of a surface without boundary."""
    at = {base: [TRUE if m == layer else FALSE for m in range(w[base])]}  # over a cell: whether it is this layer
    stack = [base]
    for cell in stack:
        for k in range(len(link.pieces)):
            if link.left(k) == cell and link.right(k) not in at:
                at[link.right(k)] = [formula.new() for _ in range(w[cell] + 1)]
                stack.append(link.right(k))
                follow_inside(formula, ways[k], at[cell], at[link.right(k)])
            elif link.right(k) == cell and link.left(k) not in at:
                at[link.left(k)] = [formula.new() for _ in range(w[cell] - 1)]
                stack.append(link.left(k))
                follow_outside(formula, ways[k], at[cell], at[link.left(k)])
    ends = []
    for k in range(len(link.pieces)):
        outside, inside = at[link.left(k)], at[link.right(k)]
        for b, here in enumerate(inside):
            ends.append(formula.new())
            formula.add(-ends[-1], here)
            for a, there in enumerate(outside):
                formula.implies((ends[-1], ways[k][a][b]), -there)
    formula.add(*ends)


def follow_inside(formula, way, outside, inside):
    for b, here in enumerate(inside):
        for a, there in enumerate(outside):
            formula.same((way[a][b],), here, there)
        formula.implies((way[-1][b],), -here)


def follow_outside(formula, way, inside, outside):
    for a, here in enumerate(outside):
        for b, there in enumerate(inside):
            formula.same((way[a][b],), here, there)
