"""Where faces cross: the ends of the curves of pairs, and the points in which three faces meet.

Exact, and only for surfaces in general position: where anything touches, nothing is decided (`Refuted`).

Nodes: ("v", vertex), ("e", a, b, face) where edge a-b pierces a face, ("t", f, g, h) where three faces meet.
"""

import collections
import itertools
from fractions import Fraction

import numpy as np

from ..errors import Refuted
from .arcs import cross_at, is_fold
from .vectors import cross, det, dot, sign, sub


def in_triangle(surface, f, n, x):
    """Whether the point x in the plane of face f lies in it."""
    p = surface.corners(f)
    return all(det(n, sub(p[k - 2], p[k]), sub(x, p[k])) >= 0 for k in range(3))


def touches(surface, f, n, pa, pb, heights):
    """Whether a segment with an end in the plane of face f touches the face."""
    ends = [x for x, h in zip((pa, pb), heights) if h == 0]
    if any(in_triangle(surface, f, n, x) for x in ends):
        return True
    if len(ends) < 2:
        return False
    corners, e = surface.corners(f), sub(pb, pa)
    for k in range(3):
        c, wall = corners[k], sub(corners[k - 2], corners[k])
        apart = [sign(det(n, e, sub(x, pa))) for x in (c, corners[k - 2])]
        across = [sign(det(n, wall, sub(x, c))) for x in (pa, pb)]
        if apart[0] * apart[1] <= 0 and across[0] * across[1] <= 0:
            return True
    return False


def pierces(surface, a, b, f):
    """Whether edge a-b passes through face f, which has neither of its ends."""
    pa, pb, n, corners = surface.points[a], surface.points[b], surface.normal(f), surface.corners(f)
    heights = [dot(n, sub(x, corners[0])) for x in (pa, pb)]
    if heights[0] * heights[1] > 0:
        return False
    if 0 in heights:
        if touches(surface, f, n, pa, pb, heights):
            raise Refuted(f"edge {a}-{b} touches face {f}")
        return False
    e = sub(pb, pa)
    sides = {sign(det(e, sub(corners[k], pa), sub(corners[k - 2], pa))) for k in range(3)}
    if sides >= {1, -1}:
        return False
    if 0 in sides:
        raise Refuted(f"edge {a}-{b} touches an edge of face {f}")
    return True


class Crossings:
    """segments: {face: {other face: the two ends of their curve}}; on_edge: {(a, b), a < b: faces that it pierces};
    triples: {(f, g), f < g: nodes on their curve}.
    """

    def __init__(self, surface):
        self.surface = surface
        self.segments = collections.defaultdict(dict)
        self.on_edge = collections.defaultdict(set)
        self.triples = collections.defaultdict(list)
        self.place = {}
        self.find_segments()
        self.find_triples()

    def find_segments(self):
        low, high = self.surface.low, self.surface.high
        order = np.argsort(low[:, 0], kind="stable")
        begins = low[order, 0]
        for f in range(len(self.surface.faces)):
            near = order[: np.searchsorted(begins, high[f, 0], side="right")]
            near = near[near > f]
            near = near[((low[near] <= high[f]) & (high[near] >= low[f])).all(axis=1)]
            for g in near:
                self.meet(f, int(g))

    def meet(self, f, g):
        s = self.surface
        common = set(s.faces[f]) & set(s.faces[g])
        if len(common) == 3:
            raise Refuted(f"faces {f} and {g} have the same corners")
        if len(common) == 2:
            self.refuse_fold(f, g, common)
            return
        nodes, tests = [], [(*e, g) for e in s.edges_of(f)] + [(*e, f) for e in s.edges_of(g)]
        if len(common) == 1:
            (v,) = common
            tests = [(a, b, h) for a, b, h in tests if v not in (a, b)]
            if cross_at(*(sub(s.points[x], s.points[v]) for a, b, _ in tests for x in (a, b))) is None:
                return
            nodes.append(("v", v))
        for a, b, h in tests:
            if pierces(s, a, b, h):
                edge = (min(a, b), max(a, b))
                self.on_edge[edge].add(h)
                nodes.append(("e", *edge, h))
        if nodes and len(nodes) != 2:
            raise Refuted(f"faces {f} and {g} meet in special position")
        if nodes:
            self.segments[f][g] = self.segments[g][f] = nodes

    def refuse_fold(self, f, g, common):
        s = self.surface
        a, b = common
        x, y = (next(v for v in s.faces[h] if v not in common) for h in (f, g))
        if is_fold(*(sub(s.points[v], s.points[a]) for v in (b, x, y))):
            raise Refuted(f"faces {f} and {g} are folded onto each other")

    def find_triples(self):
        s = self.surface
        corners = [set(x) for x in s.faces]
        for f in sorted(self.segments):
            partners = sorted(g for g in self.segments[f] if g > f)
            for g, h in itertools.combinations(partners, 2):
                three = (f, g, h)
                if h not in self.segments[g] or corners[f] & corners[g] & corners[h]:
                    continue
                if any(len(corners[x] & corners[y]) > 1 for x, y in itertools.combinations(three, 2)):
                    continue
                self.meet_three(three)

    def meet_three(self, three):
        s = self.surface
        n = [s.normal(x) for x in three]
        c = [dot(m, s.corners(x)[0]) for m, x in zip(n, three)]
        w = det(*n)
        if w == 0:
            raise Refuted(f"the faces {three} are parallel to one line")
        across = cross(n[1], n[2]), cross(n[2], n[0]), cross(n[0], n[1])
        x = tuple(sum(c[i] * across[i][k] for i in range(3)) for k in range(3))  # times w
        sides = set()
        for face, m in zip(three, n):
            p = s.corners(face)
            for k in range(3):
                wall = cross(m, sub(p[k - 2], p[k]))
                sides.add(sign(dot(wall, x) - w * dot(wall, p[k])) * sign(w))
        if 0 in sides:
            raise Refuted(f"the faces {three} meet on an edge")
        if sides == {1}:
            node = ("t", *three)
            self.place[node] = tuple(Fraction(y, w) for y in x)
            for pair in itertools.combinations(three, 2):
                self.triples[pair].append(node)

    def at(self, node):
        if node not in self.place:
            s = self.surface
            if node[0] == "v":
                self.place[node] = s.points[node[1]]
            else:
                pa, pb = s.points[node[1]], s.points[node[2]]
                n, o = s.normal(node[3]), s.corners(node[3])[0]
                from_a, from_b = dot(n, sub(pa, o)), dot(n, sub(pb, o))
                t = Fraction(from_a, from_a - from_b)
                self.place[node] = tuple(pa[k] + t * (pb[k] - pa[k]) for k in range(3))
        return self.place[node]

    def chain(self, nodes, along):
        """Pairs of neighbours among nodes on a line."""
        at = sorted((dot(along, self.at(x)), x) for x in nodes)
        if any(x[0] == y[0] for x, y in zip(at, at[1:])):
            raise Refuted("curves meet on an edge")
        return [(x[1], y[1]) for x, y in zip(at, at[1:])]

    def edge_chain(self, a, b):
        edge = (min(a, b), max(a, b))
        nodes = [("v", a), ("v", b)] + [("e", *edge, g) for g in self.on_edge.get(edge, ())]
        return self.chain(nodes, sub(self.surface.points[b], self.surface.points[a]))

    def curve_chain(self, f, g):
        """Pieces of the curve of faces f < g, along n_f x n_g."""
        along = cross(self.surface.normal(f), self.surface.normal(g))
        return self.chain(self.segments[f][g] + self.triples.get((f, g), []), along)
