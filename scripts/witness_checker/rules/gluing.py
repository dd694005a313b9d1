"""Rule `gluing`: crossings of faces, and edges, around which the layers of the solid cannot be glued all at once.

{"rule": "gluing", "pairs": [[f, g], ...], "layers": [m, ...], "edges": [[a, b], ...]}

Curves in which faces cross cut the faces into parts (`geometry/parts.py`). A mesh covers what is just outside of a part w
times and what is just inside w + 1 times, w the winding number outside. The layers outside go on into those inside, but
for one, which begins there; and in the same way all over the part, since tets cover both sides of it without
branch points. All sides of parts that are joined around edges and curves make a shell; over a shell that is a
sphere layers can be told apart by names, and others are cut open (`geometry/shells.py`, `cuts.py`).

Around a piece of curve of faces f and g, every layer comes back to itself after one turn, or it ends at f where it began
at f on the other side of g, and so for g. Parts on both sides of an edge that is not covered all along are glued alike;
if it is, the layer that begins at one ends at the other after no more turns than the number of times that it is
covered. The surface must be in general position: no vertex on a face, no two edges that meet, and so on.

All this is asked of the curves of the pairs that the witness names, where m layers lie in front of both faces, and of
the edges that it names, as clauses (`sat/layers.py`). A SAT solver says whether all can be right at once, where
the program searches; "no" counts only with a proof that `sat/rup.py` accepts.
"""

from ..errors import Refuted, Unreadable
from ..fields import number_pairs, whole_numbers
from ..geometry.parts import Parts
from ..geometry.shells import Shells
from ..sat.gluing import Condition, can_be_glued
from ..sets import Sets


def check(surface, witness):
    pairs, layers = number_pairs(witness, "pairs"), whole_numbers(witness, "layers")
    if len(layers) != len(pairs):
        raise Unreadable("the witness needs as many numbers of layers as pairs of faces")
    curves = {(min(x), max(x), m) for x, m in zip(pairs, layers)}
    edges = {(min(x), max(x)) for x in number_pairs(witness, "edges")}
    shells = Shells(Parts(surface), {x[:2] for x in curves} | edges)
    regions, conditions, seen = conditions_of(shells, curves, edges)
    if not conditions:
        raise Refuted("nothing that the witness names gives a condition")
    if can_be_glued(regions, shells.cuts.shell_of_name, shells.winding, conditions):
        raise Refuted("the layers can be glued around what the witness names")
    used = {x for c in conditions for x in (*c.regions, *(name for _, name, _ in c.changes))}
    return f"the layers of {len(used)} parts cannot be glued around {len(seen)} curves and edges at once"


def conditions_of(shells, curves, edges):
    """Regions, {region: (shell outside, shell inside)}; what is asked of them; and by what of the witness."""
    alike = Sets()  # parts
    for k, (edge, left, right) in enumerate(shells.edges):
        if shells.cover[edge] < 1 and not shells.cuts.is_cut(("edge", k)):
            alike.join(left, right)
    conditions, seen, regions = set(), set(), {}

    def add(owner, parts, most=None):
        if shells.cuts.left_out & set(parts):
            return
        here = tuple(map(alike.root, parts))
        regions.update((r, (shells.shell(r, 0), shells.shell(r, 1))) for r in here)
        conditions.add(Condition(here, shells.cuts.changes(owner), most))

    for k, (piece, four) in enumerate(zip(shells.parts.pieces, shells.around)):
        key = (*piece[:2], shells.layers(four[0], 0))
        if key in curves:
            seen.add(key)
            add(("curve", k), four)
    for k, (edge, *two) in enumerate(shells.edges):
        owner, most = ("edge", k), shells.cover[edge]
        if edge in edges or (most < 1 and shells.cuts.is_cut(owner)):
            seen |= {edge} & edges
            add(owner, two, most)
    return regions, conditions, seen
