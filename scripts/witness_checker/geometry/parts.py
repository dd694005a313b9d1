"""The faces, cut along the curves in which they cross."""

import collections
import functools

from ..errors import Refuted
from ..sets import Sets
from .crossings import Crossings
from .vectors import sign


def turn(d, e):
    return d[0] * e[1] - d[1] * e[0]


class Parts:
    """face_of, holes: per part its face, and how many holes it has.

    left: {(face, node, next node): the part to the left}; after: {such a piece of border: the next one};
    pieces: of curves, (f, g, node, next node), f < g, along n_f x n_g.
    """

    def __init__(self, surface):
        self.surface = surface
        self.crossings = Crossings(surface)
        self.edge_chain, self.at = self.crossings.edge_chain, self.crossings.at
        self.left, self.after = {}, {}
        self.face_of, self.holes = [], []
        self.pieces = []
        for f in range(len(surface.faces)):
            self.cut(f)

    def cut(self, f):
        border = [x for a, b in self.surface.edges_of(f) for x in self.edge_chain(a, b)]
        inside = []
        for g in self.crossings.segments.get(f, {}):
            found = self.crossings.curve_chain(min(f, g), max(f, g))
            inside += found
            if f < g:
                self.pieces += [(f, g, x, y) for x, y in found]
        if not inside:
            self.add_part(f, border)
        else:
            self.divide(f, border, inside)

    def add_part(self, f, loop):
        self.face_of.append(f)
        self.holes.append(0)
        self.add_border(len(self.face_of) - 1, loop)

    def add_border(self, part, loop):
        f = self.face_of[part]
        for k, piece in enumerate(loop):
            self.left[(f, *piece)] = part
            self.after[(f, *loop[k - 1])] = (f, *piece)

    def divide(self, f, border, inside):
        """Cuts a face along the curves inside: loops around what is to their left, and around holes."""
        flat, together = self.flattened(f, border + inside), Sets()
        for x, y in border + inside:
            together.join(x, y)
        edge = together.root(border[0][0])
        loops = [(sum(turn(flat[x], flat[y]) for x, y in loop), loop) for loop in loops_of(f, flat, border + inside)]
        rings = []
        for area, loop in loops:
            if area > 0:
                rings.append((area, len(self.face_of), loop))
                self.add_part(f, loop)
        outside = {(y, x) for x, y in border}
        for area, loop in loops:
            here = together.root(loop[0][0])
            if area > 0:
                continue
            if here == edge:
                if set(loop) != outside:
                    raise Refuted(f"face {f} cannot be divided")
                continue
            # A hole in the smallest part that surrounds it.
            others = [ring for ring in rings if together.root(ring[2][0][0]) != here]
            around = [ring[:2] for ring in others if surrounds(f, flat, ring[2], loop[0][0])]
            if not around:
                raise Refuted(f"face {f} cannot be divided")
            part = min(around)[1]
            self.holes[part] += 1
            self.add_border(part, loop)

    def flattened(self, f, pieces):
        """The nodes in two coordinates, counter-clockwise seen from in front of the face."""
        n = self.surface.normal(f)
        drop = max(range(3), key=lambda k: abs(n[k]))
        i, j = ((drop + 1) % 3, (drop + 2) % 3)[:: 1 if n[drop] > 0 else -1]
        return {x: (self.at(x)[i], self.at(x)[j]) for piece in pieces for x in piece}


def way(flat, x, y):
    return flat[y][0] - flat[x][0], flat[y][1] - flat[x][1]


def loops_of(f, flat, pieces):
    """The borders of what lies between pieces, each with that on its left."""
    out = collections.defaultdict(list)
    for x, y in pieces:
        out[x].append(y)
        out[y].append(x)
    follow = {}  # what comes after a piece on the border of what is to its left
    for x, ends in out.items():

        def compare(y, z, x=x):
            d, e = way(flat, x, y), way(flat, x, z)
            low_d, low_e = ((k[1], k[0]) <= (0, 0) for k in (d, e))
            if low_d == low_e and turn(d, e) == 0 and y != z:
                raise Refuted(f"curves overlap in face {f}")
            return low_d - low_e or -sign(turn(d, e))

        ends.sort(key=functools.cmp_to_key(compare))
        for k, y in enumerate(ends):
            follow[y, x] = (x, ends[k - 1])
    loops, seen = [], set()
    for start in follow:
        loop, at = [], start
        while at not in seen:
            seen.add(at)
            loop.append(at)
            at = follow[at]
        if loop:
            loops.append(loop)
    return loops


def surrounds(f, flat, ring, node):
    """Whether a loop goes around a node that is not on it."""
    p = flat[node]
    crossed = 0
    for x, y in ring:
        if (flat[x][1] > p[1]) != (flat[y][1] > p[1]):
            left = turn(way(flat, x, y), (p[0] - flat[x][0], p[1] - flat[x][1]))
            if left == 0:
                raise Refuted(f"curves touch in face {f}")
            crossed += (left > 0) == (flat[y][1] > flat[x][1])
    return crossed % 2 == 1
