"""B0 once more, by counting: what a disc in given layers needs so that its Euler number is 1.

Let tets at a vertex make a surface on a tiny sphere around it, without branch points, whose boundary is the link, and
which has w layers over a cell of the sphere. Every cell is a disc (the link is connected), so there are as many
faces as layers. A piece of the link with m layers outside has one edge each, and one at the boundary. At a crossing with
m layers in front of both strands there is a vertex each, and two on the boundary, one a strand. At a corner
with m layers outside there are m - k + 1 vertices: k layers outside take part in the turns of the vertex on the boundary.
So the surface, where it is connected, is a disc just when

    sum k = sum over corners (m + 1) + sum over crossings (m + 2) - sum over pieces (m + 1) + sum over cells w - 1

With c closed layers among the w this is B0 = 2 c + sum k: each of them adds 2 to the Euler number. Nothing here has to
do with directions and turns, as `turns.py` has; both must give the same number. The link must be in general position.
"""

from ..errors import Grazed
from .cover import Disc
from .winding import DIRECTIONS, ahead


def turns_needed(link, w):
    """The sum of the extra turns of a disc in so many layers (B0, where some may be closed)."""
    corners = sum(w[link.outside(k)] + 1 for k in range(link.corners))
    crossings = sum(w[in_front(link, k)] + 2 for k in range(len(link.crossings)))
    pieces = sum(w[link.left(k)] + 1 for k in range(len(link.pieces)))
    return corners + crossings - pieces + sum(w.values()) - 1


def at_crossing(link, k):
    """The pieces of strands f and g around a crossing: of f in front of g, of g in front of f, and those behind."""
    i, j, left = link.crossings[k]
    node = link.corners + k
    f, g = (link.into[i, node], link.outof[i, node]), (link.into[j, node], link.outof[j, node])
    # In front of a strand is its left. Where g goes to the left of f, g leaves into what is in front of f.
    return (f[0], g[1], f[1], g[0]) if left else (f[1], g[0], f[0], g[1])


def in_front(link, k):
    """The cell in front of both strands of a crossing."""
    return link.left(at_crossing(link, k)[0])


def b0_by_counting(surface, v):
    """B0 of a vertex whose link is in general position, from the winding numbers around it."""
    disc, own = Disc(surface, v), set(surface.at_vertex[v])
    for d in DIRECTIONS:
        try:
            more = ahead(surface, surface.points[v], 1, d, own) - disc.layers(d)
        except Grazed:
            continue
        return turns_needed(disc.link, {cell: layers + more for cell, layers in disc.w.items()})
    return None
