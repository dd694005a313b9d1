"""Edge collapses that leave a surface closed and manifold."""

from .surface import Surface


class Collapsible:
    def __init__(self, surface):
        self.points = list(surface.points)
        self.faces = dict(enumerate(surface.faces))
        self.at = {}
        for i, f in self.faces.items():
            for v in f:
                self.at.setdefault(v, set()).add(i)

    def surface(self):
        whole = Surface(self.points, [])
        return whole.only([self.faces[i] for i in sorted(self.faces)])

    def neighbours(self, v):
        return {w for i in self.at[v] for w in self.faces[i]} - {v}

    def edges(self):
        return sorted({(min(f[k], f[k - 1]), max(f[k], f[k - 1])) for f in self.faces.values() for k in range(3)})

    def length(self, a, b):
        """Squared, and so that nothing overflows; longer is larger, that is all."""
        d = [abs(x - y) for x, y in zip(self.points[a], self.points[b])]
        m = max(d)
        return (0.0, 0.0) if m == 0 else (m, sum((x / m) ** 2 for x in d))

    def collapse(self, a, b, point=None):
        """Moves b to a. Answers whether that leaves a manifold: no vertex but those of the edge's two faces is joined
        to both, and this is no tetrahedron's surface."""
        if a not in self.at or b not in self.at or b not in self.neighbours(a):
            return False
        both = self.neighbours(a) & self.neighbours(b)
        if len(both) != 2 or any(len(self.at[v]) <= 3 for v in both) or len(self.at[a]) + len(self.at[b]) <= 6:
            return False
        for i in sorted(self.at.pop(b)):
            f = self.faces[i]
            if a in f:
                for v in f:
                    if v != b:
                        self.at[v].discard(i)
                del self.faces[i]
            else:
                self.faces[i] = tuple(a if v == b else v for v in f)
                self.at[a].add(i)
        if point is not None:
            self.points[a] = tuple(point)
        return True


def collapse_to(surface, faces):
    """Short edges first, to their middles, until so many faces are left."""
    work = Collapsible(surface)
    while len(work.faces) > faces:
        before = len(work.faces)
        for a, b in sorted(work.edges(), key=lambda e: (work.length(*e), e))[: max(1, before // 10)]:
            if len(work.faces) > faces and a in work.at and b in work.at:
                middle = [x / 2 + y / 2 for x, y in zip(work.points[a], work.points[b])]
                work.collapse(a, b, middle)
        if len(work.faces) == before:
            break
    return work.surface()
