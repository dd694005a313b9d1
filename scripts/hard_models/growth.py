"""Tets that are added one by one, so that they stay the mesh of a solid, whatever overlaps."""

from .complex import Solid, boundary, chain, parts_of_edges
from .exact import turns, volume

EDGES = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))


class Growth:
    def __init__(self, points, tets):
        """pre: the mesh of a solid."""
        self.points, self.tets = [], []
        self.across = {}  # directed edge of the boundary -> the third corner of its face
        self.star = []  # of a vertex: its tets
        self.edges = set()
        for p in points:
            self.add_point(p)
        self.add(*tets)

    def solid(self):
        return Solid(self.points, self.tets)

    def volume(self, tet):
        return volume(*(self.points[v] for v in tet))

    def faces(self):
        return sorted((a, b, c) for (a, b), c in self.across.items() if a < b and a < c)

    def add_point(self, p):
        self.points.append(tuple(p))
        self.star.append([])
        return len(self.points) - 1

    def add(self, *tets):
        """At once: between several of them the boundary need not be manifold."""
        for tet in tets:
            for v in tet:
                self.star[v].append(len(self.tets))
            self.tets.append(tuple(tet))
            self.edges.update(frozenset((tet[i], tet[j])) for i, j in EDGES)
        fresh = []
        for a, b, c in boundary(tets):
            if self.across.get((a, c)) == b:  # the other side of it
                for edge in ((a, c), (c, b), (b, a)):
                    del self.across[edge]
            else:
                fresh.append((a, b, c))
        for a, b, c in fresh:
            self.across.update({(a, b): c, (b, c): a, (c, a): b})

    def turns_with(self, tet, a, b):
        """Turns around the edge once the tet is there; None if its tets form no ring."""
        at = [self.tets[i] for i in self.star[a] if b in self.tets[i]] + [tet]
        pairs = parts_of_edges(at)[min(a, b), max(a, b)]
        found = chain(pairs)
        if found is None or not found[1]:
            return None
        low, high = min(a, b), max(a, b)
        return turns(self.points[low], self.points[high], [self.points[v] for v in found[0]])

    # Three ways to add a tet that keep a manifold a manifold, and a tunnel. They answer whether they did.

    def onto_face(self, face, point):
        """A tet with a new vertex on a face of the boundary."""
        a, b, c = face
        if volume(*(self.points[v] for v in face), point) <= 0:
            return False
        self.add((a, b, c, self.add_point(point)))
        return True

    def into_edge(self, a, b):
        """A tet between the two faces at an edge, which becomes an interior one."""
        c, d = self.across[a, b], self.across[b, a]
        tet = (a, b, c, d)
        if c == d or frozenset((c, d)) in self.edges or self.volume(tet) <= 0 or self.turns_with(tet, a, b) != 1:
            return False
        self.add(tet)
        return True

    def onto_vertex(self, v, a):
        """A tet over a vertex with three faces, which becomes an interior one."""
        b = self.across[v, a]
        c = self.across[v, b]
        if len({a, b, c}) < 3 or self.across.get((v, c)) != a or self.has_face(a, b, c):
            return False
        tet = (v, a, b, c)
        if self.volume(tet) <= 0 or any(self.turns_with(tet, v, x) != 1 for x in (a, b, c)):
            return False
        self.add(tet)
        return True

    def has_face(self, a, b, c):
        return any(b in self.tets[i] and c in self.tets[i] for i in self.star[a])

    def tunnel(self, f, g):
        """Three tets, a prism, between two faces of the boundary that no edge joins."""
        if any(x == y or frozenset((x, y)) in self.edges for x in f for y in g):
            return False
        (a, b, c), (x, z, y) = f, g
        for tets in (((a, b, c, x), (b, c, x, y), (c, x, y, z)), ((a, b, c, z), (a, b, z, x), (b, x, y, z))):
            if all(self.volume(t) > 0 for t in tets):
                self.add(*tets)
                return True
        return False

    def move(self, v, point):
        """One vertex at a time: if its tets are positive before and after, they are so on the way (their volumes are
        linear in the point), and turns around edges do not change."""
        before, self.points[v] = self.points[v], tuple(point)
        if all(self.volume(self.tets[i]) > 0 for i in self.star[v]):
            return True
        self.points[v] = before
        return False


def one_tet(rng, size):
    while True:
        points = [random_point(rng, size) for _ in range(4)]
        if volume(*points) > 0:
            return Growth(points, [(0, 1, 2, 3)])


def random_point(rng, size, middle=(0, 0, 0)):
    return tuple(m + rng.randint(-size, size) for m in middle)


def grow(growth, rng, tets, reach, share_of_tunnels=0.0):
    """Adds tets until there are so many. New vertices lie within `reach` of the middle of a face."""
    for _ in range(40 * tets):
        if len(growth.tets) >= tets:
            return
        u = rng.random()
        a, b = rng.choice(sorted(growth.across))
        if u < share_of_tunnels:
            c, d = rng.choice(sorted(growth.across))
            growth.tunnel((a, b, growth.across[a, b]), (c, d, growth.across[c, d]))
        elif u < 0.4:
            growth.into_edge(a, b)
        elif u < 0.6:
            growth.onto_vertex(a, b)
        else:
            face = (a, b, growth.across[a, b])
            middle = [sum(growth.points[v][k] for v in face) // 3 for k in range(3)]
            growth.onto_face(face, random_point(rng, reach, middle))


def spin(growth, rng, a, b, tets, reach):
    """Puts tets around an edge of the boundary, one after the other, past whole turns."""
    for _ in range(30 * tets):
        if tets == 0:
            return
        face = (a, b, growth.across[a, b])
        middle = [(growth.points[a][k] + growth.points[b][k]) // 2 for k in range(3)]
        tets -= growth.onto_face(face, random_point(rng, reach, middle))


def shake(growth, rng, moves, reach):
    """Moves single vertices, as far as they can go in halves of a random step."""
    for _ in range(moves):
        v = rng.randrange(len(growth.points))
        step = random_point(rng, reach)
        while any(step) and not growth.move(v, [x + s for x, s in zip(growth.points[v], step)]):
            step = tuple(int(s / 2) for s in step)


def weld(growth, rng, moves):
    """Moves single vertices onto others, onto middles of two others, into planes of others."""
    for _ in range(moves):
        v, a, b = (rng.randrange(len(growth.points)) for _ in range(3))
        p, q = growth.points[a], growth.points[b]
        kind = rng.randrange(3)
        if kind == 0:
            target = p
        elif kind == 1:
            target = tuple((x + y) // 2 for x, y in zip(p, q))
        else:
            k = rng.randrange(3)
            target = tuple(p[k] if i == k else x for i, x in enumerate(growth.points[v]))
        growth.move(v, target)
