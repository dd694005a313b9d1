"""The link of a vertex, cut at its crossings into pieces, which cut the sphere into cells.

The link must be in general position: no corner on an arc, no three arcs through one point, no folds.
"""

import functools
import itertools

from ..errors import Refuted
from .arcs import cross_at, is_fold
from .vectors import cross, det, sign


class Link:
    """Nodes are the corners, then the crossings; `at` has their directions.

    pieces: (node, next node, arc). To the left of a piece is the cell outside, to its right the one inside.
    crossings: (arc, other arc, whether the other one goes to the left).
    around: per node its half pieces counter-clockwise, (piece, whether it begins here).
    """

    def __init__(self, out):
        self.out = out
        self.corners = len(out)
        self.at = list(out)
        self.crossings, on = self.find_crossings()
        self.pieces = []
        self.into, self.outof = {}, {}  # (arc, node): the piece of the arc that ends, or begins, there
        for i in range(self.corners):
            self.divide(i, on[i])
        self.around = [self.half_pieces(node) for node in range(len(self.at))]
        self.cell, self.cells = self.find_cells()

    def find_crossings(self):
        n, crossings = self.corners, []
        on = [[] for _ in self.out]  # per arc the crossings on it
        for i, j in itertools.combinations(range(n), 2):
            a, b, c, d = (self.out[k % n] for k in (i, i + 1, j, j + 1))
            if j == i + 1 or (i == 0 and j == n - 1):
                if is_fold(*((b, a, d) if j == i + 1 else (a, b, c))):
                    raise Refuted("two faces at the vertex are folded onto each other")
                continue
            found = cross_at(a, b, c, d)
            if found:
                on[i].append(len(self.at))
                on[j].append(len(self.at))
                self.at.append(found[0])
                crossings.append((i, j, found[1]))
        return crossings, on

    def divide(self, i, crossings):
        """Cuts arc i into pieces."""
        begin, end = i, (i + 1) % self.corners
        normal = cross(self.out[begin], self.out[end])

        def order(x, y):
            side = sign(det(self.at[x], self.at[y], normal))
            if side == 0 and x != y:
                raise Refuted("three faces at the vertex meet in a line")
            return -side

        chain = [begin, *sorted(crossings, key=functools.cmp_to_key(order)), end]
        for x, y in zip(chain, chain[1:]):
            self.outof[i, x] = self.into[i, y] = len(self.pieces)
            self.pieces.append((x, y, i))

    def half_pieces(self, node):
        if node < self.corners:
            return [(self.outof[node, node], True), (self.into[(node - 1) % self.corners, node], False)]
        i, j, left = self.crossings[node - self.corners]
        first, last = ((self.outof[j, node], True), (self.into[j, node], False))[:: 1 if left else -1]
        return [(self.outof[i, node], True), first, (self.into[i, node], False), last]

    def find_cells(self):
        """For each side of a piece, (piece, True) the left one and (piece, False) the right one, its cell."""
        follow = {}  # what comes next on the border of a cell
        for halves in self.around:
            for leave, (piece, begins) in zip(halves, halves[1:] + halves[:1]):
                follow[piece, not begins] = leave
        cell, cells = {}, 0
        for start in follow:
            if start not in cell:
                while start not in cell:
                    cell[start] = cells
                    start = follow[start]
                cells += 1
        return cell, cells

    def left(self, piece):
        return self.cell[piece, True]

    def right(self, piece):
        return self.cell[piece, False]

    def outside(self, corner):
        """The cell outside of a corner."""
        return self.left(self.outof[corner, corner])

    def count_layers(self, cell, layers):
        """The winding numbers of all cells, from that of one of them."""
        w, stack = {cell: layers}, [cell]
        steps = {}
        for k in range(len(self.pieces)):
            steps.setdefault(self.left(k), []).append((self.right(k), 1))
            steps.setdefault(self.right(k), []).append((self.left(k), -1))
        while stack:
            x = stack.pop()
            for y, jump in steps[x]:
                if y not in w:
                    w[y] = w[x] + jump
                    stack.append(y)
                elif w[y] != w[x] + jump:
                    raise Refuted("the winding numbers around the vertex disagree")
        return w

    def least_layers(self):
        """The winding numbers of the cells, if the least of them is 0."""
        w = self.count_layers(self.left(0), 0)
        least = min(w.values())
        return {cell: layers - least for cell, layers in w.items()}
