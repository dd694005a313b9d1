"""What gluings of layers satisfy around crossings and edges, as clauses.

A region (a part of a face, or a piece of a link) has w layers outside and w + 1 inside. A gluing says for each layer
outside as which one it goes on inside; the one left over ends at the region, where it has its boundary. So a gluing is
a bijection: from the layers outside, and one thing more (the last), the end, to the layers inside.

Where regions f and g cross, there are four sectors: in front of both, of g (inside f), of f (inside g), and of
none. What lies around the place is made of the w layers that go on all around, of the one with its boundary on f, and of
the one with its boundary on g, which do so along straight lines. Each of these w + 2 has one name behind both, whether f
or g is passed first. That is all: layers that keep their names on both ways close after one turn, and the one
that ends at f on one side of g ends at f on the other. (`around_crossing`.)

Where a region goes on over an edge there are two sectors, outside and inside. A layer outside goes in at the left
region and comes out at the right one as another or the same: a permutation of the layers outside and the
end. What does not take part in the turns of the edge comes back to itself. What begins at the end goes round k times,
from layer to layer, until it comes to the end again. So the permutation has one cycle, through the end, of k layers
more, and leaves all others where they are. (`around_edge`.)

Names of layers may change where a sector is crossed (`changes`: bijections for some sectors, from the name at f, or on
the left, to that at g, or on the right).
"""

from .bijections import equal, identity, inverse, then, unknown, with_fixed


def gluing(formula, layers, kind):
    """A region with so many layers outside; kind: of `names.py`."""
    if kind == "given":
        return identity(layers + 1)
    if kind == "sorted":
        return unknown(formula, layers + 1, lambda a, b: a == layers or b in (a, a + 1))
    return unknown(formula, layers + 1)


def swap_last(square):
    """The last two rows in the other order."""
    return [*square[:-2], square[-1], square[-2]]


def around_crossing(formula, f_front, g_front, f_behind, g_behind, changes=None):
    """f_front: the region of f in front of g, and so on. Sectors: in front of both, of g, of f, of none."""
    changes = changes or {}
    layers = len(f_front) - 1
    front, of_g, of_f, behind = (changes.get(k, identity(layers + (k + 1) // 2)) for k in range(4))
    # Rows: the layers in front of both, by their names at f, the end at f, the end at g.
    by_f = with_fixed(then(formula, f_front, of_g))
    by_f = then(formula, by_f, g_behind)
    by_g = then(formula, with_fixed(front), g_front)
    by_g = then(formula, by_g, inverse(of_f))
    by_g = swap_last(with_fixed(by_g))
    by_g = then(formula, then(formula, by_g, f_behind), behind)
    equal(formula, by_f, by_g)


def around_edge(formula, left, right, most, changes=None):
    """At most so many extra turns. Literals that say whether there are at least 1, 2, ... of them."""
    changes = changes or {}
    layers = len(left) - 1
    outside, inside = (changes.get(k, identity(layers + k)) for k in range(2))
    # From names on the left to names on the left.
    back = then(formula, with_fixed(outside), right)
    left = then(formula, left, inside)
    most = min(most, layers)
    if most <= 0:
        equal(formula, left, back)
        return []
    return one_cycle(formula, then(formula, left, inverse(back)), most)


def one_cycle(formula, turn, most):
    """The last thing's cycle has at most so many things more, and all other things stay where they are."""
    n = len(turn) - 1
    end = turn[n]
    at = [[formula.new() for _ in range(n)] for _ in range(most)]  # entry t: what comes after the end in t + 1 steps
    for a in range(n):
        formula.same((), at[0][a], end[a])
        formula.add(turn[a][a], *(step[a] for step in at))
        formula.implies((at[-1][a],), turn[a][n])
        for before, after in zip(at, at[1:]):
            formula.implies((end[a],), -after[a])
            for b in range(n):
                formula.same((turn[b][a],), after[a], before[b])
    return [formula.any_of(step) for step in at]
