"""What the link of a vertex says by itself about how often a disc with that border covers a direction."""

from ..errors import Grazed
from .link import Link
from .ring import link_of
from .vectors import cross, det, sign
from .winding import DIRECTIONS


def cover_of(out, apex, d):
    """How often triangles from an apex to the arcs between these directions cover a direction, with sign.

    The left of an arc once more than its right: the opposite of what winding numbers do.
    """
    total = 0
    for a, b in zip(out, out[1:] + out[:1]):
        s = sign(det(apex, a, b))
        inside = [sign(det(d, x, y)) for x, y in ((apex, a), (a, b), (b, apex))]
        if s == 0 or 0 in inside:
            raise Grazed
        if inside == [s, s, s]:
            total += s
    return total


class Disc:
    """A disc around vertex v that covers some place not at all, whether there is one or not."""

    def __init__(self, surface, v):
        self.out = link_of(surface, v)
        self.link = Link(self.out)
        self.w = self.link.least_layers()
        self.beside = self.left_of_first_piece()

    def left_of_first_piece(self):
        """A direction to the left of the first piece, closer to it than any other arc."""
        begin, end, arc = self.link.pieces[0]
        arcs = list(zip(self.out, self.out[1:] + self.out[:1]))
        middle, normal = tuple(map(sum, zip(self.link.at[begin], self.link.at[end]))), cross(*arcs[arc])
        sides = [sign(det(a, b, middle)) for a, b in arcs]
        far = 1
        while True:
            found = tuple(far * x + y for x, y in zip(middle, normal))
            if all(side in (0, sign(det(a, b, found))) for side, (a, b) in zip(sides, arcs)):
                return found
            far *= 2

    def layers(self, d):
        """How often it covers a direction."""
        for apex in DIRECTIONS:
            try:
                more = cover_of(self.out, apex, self.beside) - cover_of(self.out, apex, d)
            except Grazed:
                continue
            return self.w[self.link.left(0)] + more
        raise Grazed
