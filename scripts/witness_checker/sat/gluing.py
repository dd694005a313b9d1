"""Whether the layers over regions can be glued so that what is asked of them is right, as a formula."""

import collections

from .bijections import inverse, unknown
from .formula import Formula
from .layers import around_crossing, around_edge, gluing
from .names import name_layers
from .solver import can_be_satisfied

# regions: four around a crossing, as in `around_crossing`, or two at an edge, with the most turns that it makes.
# changes: (sector, name, whether it is undone) of names across sectors.
Condition = collections.namedtuple("Condition", "regions changes most", defaults=((), None))


def can_be_glued(regions, names, layers, conditions):
    """regions: {region: (shell outside, shell inside)}; names: {name of a change: its shell}; layers: {shell: number}."""
    return can_be_satisfied(gluing_formula(regions, names, layers, conditions))


def gluing_formula(regions, names, layers, conditions):
    formula = Formula()
    conditions = sorted(conditions, key=repr)
    kinds = name_layers(regions, layers)
    ways = {r: gluing(formula, layers[outer], kinds[r]) for r, (outer, _) in regions.items()}
    used = sorted({name for c in conditions for _, name, _ in c.changes})
    change = {name: unknown(formula, layers[names[name]]) for name in used}
    for c in conditions:
        here = [ways[r] for r in c.regions]
        changes = {k: inverse(change[name]) if undone else change[name] for k, name, undone in c.changes}
        if c.most is None:
            around_crossing(formula, *here, changes)
        else:
            around_edge(formula, *here, c.most, changes)
    return formula
