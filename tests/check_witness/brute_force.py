"""Gluings found by trying all of them, to compare with what the solver says.

Nothing here knows how formulas are made: layers are followed step by step around a place, parts are joined and counted,
and names of layers are all tried. A gluing is a tuple: for each layer outside the one inside.
"""

import itertools

import support  # noqa: F401  (says where the package is)
from witness_checker.sets import Sets


class TooLong(Exception):
    pass


def all_ways(layers):
    return list(itertools.permutations(range(layers + 1), layers))


def some_choice(domains, conditions, final=lambda chosen: True, steps=20000):
    """Whether values of all unknowns satisfy all conditions, (unknowns, test), and the final one."""
    order = []
    for unknowns, _ in sorted(conditions, key=lambda c: sum(len(domains[x]) for x in c[0])):
        order += [x for x in unknowns if x not in order]
    order += [x for x in domains if x not in order]
    complete = [[c for c in conditions if c[0] and max(map(order.index, c[0])) == k] for k in range(len(order))]
    chosen = {}

    def descend(k):
        nonlocal steps
        if k == len(order):
            return final(chosen)
        for chosen[order[k]] in domains[order[k]]:
            steps -= 1
            if steps < 0:
                raise TooLong
            if all(test(*(chosen[x] for x in unknowns)) for unknowns, test in complete[k]) and descend(k + 1):
                return True
        return False

    return descend(0)


def walk_around(halves, layers, strands):
    """Follows all layers around a place.

    halves: per region around it, counter-clockwise, (gluing, whether its inside comes first, going counter-clockwise).
    layers: per sector, sector q between half q and half q + 1. strands: per half its strand.
    Extra turns of what begins here, or None where something is wrong.
    """
    m = len(halves)

    def over(sector, layer):
        way, inside_first = halves[(sector + 1) % m]
        if not inside_first:
            return way[layer]
        return way.index(layer) if layer in way else None

    passed, turns = set(), 0
    for k, (way, inside_first) in enumerate(halves):
        if inside_first:
            continue
        sector, steps = k, 0
        layer = next(x for x in range(layers[k]) if x not in way)
        while layer is not None:
            if (sector, layer) in passed:
                return None
            passed.add((sector, layer))
            layer = over(sector, layer)
            sector, steps = (sector + 1) % m, steps + 1
        if strands[sector] != strands[k] or (m > 2 and steps != 2):
            return None
        turns = (steps - 1) // m
    for sector in range(m):
        for start in set(range(layers[sector])) - {x for s, x in passed if s == sector}:
            layer = start
            for step in range(m):
                layer = None if layer is None else over((sector + step) % m, layer)
            if layer != start:
                return None
    return turns


def turns_at(link, w, glued, node):
    """glued: {piece: gluing}."""
    halves = link.around[node]
    # To the left of a piece that begins here comes, counter-clockwise, what is outside.
    ways = [(glued[piece], begins) for piece, begins in halves]
    strands = [link.pieces[piece][2] if len(halves) > 2 else 0 for piece, _ in halves]
    return walk_around(ways, [w[link.cell[half]] for half in halves], strands)


def closed_parts(link, w, glued):
    """How many parts of what has been glued have no boundary."""
    parts, bounded = Sets(), set()
    for k, way in glued.items():
        for outer, inner in enumerate(way):
            parts.join((link.left(k), outer), (link.right(k), inner))
        bounded |= {(link.right(k), x) for x in range(len(way) + 1) if x not in way}
    everything = {parts.root((cell, x)) for cell in w for x in range(w[cell])}
    return len(everything - {parts.root(x) for x in bounded})


def is_filled(link, w, value, most):
    """Whether a link bounds a disc, by the sum that B0 must be."""
    return some_gluing(link, w, most, lambda closed, turns: value == 2 * closed + turns)


def some_gluing(link, w, most, right):
    """Whether a gluing is right around all nodes, and by its closed parts and the sum of its extra turns."""
    turns = {}

    def at(node, pieces):
        def test(*ways):
            turns[node] = turns_at(link, w, dict(zip(pieces, ways)), node)
            return turns[node] is not None and (node >= link.corners or turns[node] <= most[node])

        return test

    def final(glued):
        return right(closed_parts(link, w, glued), sum(turns[k] for k in range(link.corners)))

    domains = {k: all_ways(w[link.left(k)]) for k in range(len(link.pieces))}
    conditions = []
    for node, halves in enumerate(link.around):
        pieces = tuple(dict.fromkeys(piece for piece, _ in halves))
        conditions.append((pieces, at(node, pieces)))
    return some_choice(domains, conditions, final)


def renamed(way, outside, inside):
    """A gluing after new names: outside and inside say for each old name the new one."""
    out = [None] * len(way)
    for layer, where in enumerate(way):
        out[outside[layer]] = inside[where]
    return tuple(out)


def undo(names):
    return tuple(names.index(k) for k in range(len(names)))


def names_across(condition, chosen, layers):
    """Per sector of a condition the change of names from f to g, or from left to right."""
    out = [tuple(range(m)) for m in layers]
    for (sector, _, undone), change in zip(condition.changes, chosen):
        out[sector] = undo(change) if undone else change
    return out


def curve_test(condition):
    """Around a crossing: everything is first renamed to names that do not change, then followed around."""

    def test(*chosen):
        f_front, g_front, f_behind, g_behind = chosen[:4]
        m = len(f_front)
        front, of_g, of_f, behind = names_across(condition, chosen[4:], (m, m + 1, m + 1, m + 2))
        # All by the names at g.
        f_front, f_behind = renamed(f_front, front, of_g), renamed(f_behind, of_f, behind)
        # Counter-clockwise: in front of both, over f, of g, over g, of none, over f, of f, over g.
        halves = [(g_front, True), (f_front, False), (g_behind, False), (f_behind, True)]
        return walk_around(halves, (m, m + 1, m + 2, m + 1), "gfgf") is not None

    return test


def edge_test(condition):
    def test(*chosen):
        left, right = chosen[:2]
        m = len(left)
        outside, inside = names_across(condition, chosen[2:], (m, m + 1))
        left = renamed(left, outside, inside)
        turns = walk_around([(left, True), (right, False)], (m, m + 1), "ee")
        return turns is not None and turns <= condition.most

    return test


def can_be_glued(regions, names, layers, conditions):
    domains = {r: all_ways(layers[outer]) for r, (outer, _) in regions.items()}
    domains |= {name: list(itertools.permutations(range(layers[shell]))) for name, shell in names.items()}
    tests = []
    for c in conditions:
        unknowns = (*c.regions, *(name for _, name, _ in c.changes))
        tests.append((unknowns, (curve_test if c.most is None else edge_test)(c)))
    return some_choice(domains, tests)
