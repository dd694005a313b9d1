"""Shells: the sides of parts of faces, joined around edges and around curves.

A shell runs along the border of one cell of space, so it has one winding number, and the solid has that many layers all
over it. A side is (part, 0 in front or 1 behind); it is also written (face, node, next node, 0 or 1), with a
piece of the border of the part.
"""

import collections
import math
from fractions import Fraction

from ..errors import Refuted
from ..sets import Sets
from .cuts import Cuts
from .vectors import dot
from .winding import winding


class Shells:
    """edges: (edge, part on the left, part on the right) per piece of edge; around: per piece of curve of faces
    f and g the parts of f in front of g, of g in front of f, and those behind.
    sectors: (owner, side, side) with owner ("edge", number) or ("curve", number), in the order of `sat/layers.py`.
    winding: {shell: number}; cover: {edge: the number of times that it is covered all along}.
    """

    def __init__(self, parts, named):
        """named: curves (f, g) and edges (a, b) at which shells had better not be cut."""
        self.parts = parts
        self.edges, self.around, self.sectors = [], [], []
        self.find_edges()
        self.find_curves()
        self.joined = Sets()
        for _, u, v in self.sectors:
            self.joined.join(self.side(u), self.side(v))
        self.winding = {}
        self.find_layers()
        self.cover = {}
        for edge, left, _ in self.edges:
            here = self.layers(left, 0)
            self.cover[edge] = min(here, self.cover.get(edge, here))
        self.cuts = Cuts(self, named)

    def find_edges(self):
        parts, twin = self.parts, self.parts.surface.twin
        for (a, b), f in twin.items():
            if a > b:
                continue
            g = twin[b, a]
            for p, q in parts.edge_chain(a, b):
                owner = ("edge", len(self.edges))
                self.edges.append(((a, b), parts.left[f, p, q], parts.left[g, q, p]))
                self.sectors += [(owner, (f, p, q, k), (g, q, p, k)) for k in (0, 1)]

    def find_curves(self):
        parts = self.parts
        for f, g, p, q in parts.pieces:
            # Along n_f x n_g: on its left in f is what lies behind g, on its left in g what lies in front of f.
            f_behind, f_front, g_front, g_behind = (f, p, q), (f, q, p), (g, p, q), (g, q, p)
            owner = ("curve", len(self.around))
            self.around.append(tuple(parts.left[x] for x in (f_front, g_front, f_behind, g_behind)))
            self.sectors += [
                (owner, (*f_front, 0), (*g_front, 0)),
                (owner, (*f_front, 1), (*g_behind, 0)),
                (owner, (*f_behind, 0), (*g_front, 1)),
                (owner, (*f_behind, 1), (*g_behind, 1)),
            ]

    def side(self, u):
        return self.parts.left[u[:3]], u[3]

    def shell(self, part, k):
        return self.joined.root((part, k))

    def shell_of(self, u):
        return self.joined.root(self.side(u))

    def layers(self, part, k):
        return self.winding[self.shell(part, k)]

    def find_layers(self):
        """One look by a ray where nothing is known, and one more or less across every part."""
        faces = self.parts.face_of
        links = collections.defaultdict(set)
        for part in range(len(faces)):
            front, behind = self.shell(part, 0), self.shell(part, 1)
            links[front].add((behind, 1))
            links[behind].add((front, -1))
        self.look_from_faces(links)
        self.look_from_curves(links)
        if any(x not in self.winding for x in links) or min(self.winding.values()) < 0:
            raise Refuted("a winding number is unknown or negative")

    def look_from_faces(self, links):
        """From the middles of faces that nothing cuts."""
        s, faces = self.parts.surface, self.parts.face_of
        count = collections.Counter(faces)
        for part, f in enumerate(faces):
            if count[f] > 1 or self.parts.holes[part] or self.shell(part, 0) in self.winding:
                continue
            value, d = winding(s, tuple(sum(p[k] for p in s.corners(f)) for k in range(3)), 3, {f})
            self.spread(self.shell(part, 0 if dot(s.normal(f), d) > 0 else 1), value, links)

    def look_from_curves(self, links):
        s, parts = self.parts.surface, self.parts
        for (f, g, p, q), (f_front, _, f_behind, _) in zip(parts.pieces, self.around):
            if self.shell(f_front, 0) in self.winding:
                continue
            m = [(x + y) * Fraction(1, 2) for x, y in zip(parts.at(p), parts.at(q))]
            w = math.lcm(*(x.denominator for x in m))
            value, d = winding(s, tuple(int(x * w) for x in m), w, {f, g})
            before_f, before_g = (dot(s.normal(x), d) > 0 for x in (f, g))
            part = f_front if before_g else f_behind
            self.spread(self.shell(part, 0 if before_f else 1), value, links)

    def spread(self, first, value, links):
        self.winding[first] = value
        stack = [first]
        while stack:
            x = stack.pop()
            for y, jump in links[x]:
                if y not in self.winding:
                    self.winding[y] = self.winding[x] + jump
                    stack.append(y)
                elif self.winding[y] != self.winding[x] + jump:
                    raise Refuted("the winding numbers disagree")

