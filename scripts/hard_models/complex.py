"""Tets: what makes them the mesh of a solid, and the surface of it."""

from .exact import turns, volume
from .surface import Surface
from .surface import faults as surface_faults


def faces_of(tet):
    """The faces of a positive tet, seen from outside counterclockwise."""
    a, b, c, d = tet
    return (b, c, d), (a, d, c), (a, b, d), (a, c, b)


def turned(face):
    """The same oriented face, smallest corner first."""
    k = face.index(min(face))
    return face[k:] + face[:k]


def boundary(tets):
    """The oriented faces of one tet only, in order of appearance."""
    faces = {}
    for t in tets:
        for f in faces_of(t):
            a, b, c = turned(f)
            if faces.pop((a, c, b), None) is None:
                faces[a, b, c] = True
    return list(faces)


def parts_of_edges(tets):
    """(a, b) with a < b -> the pairs (p, q) for which (a, b, p, q) is a tet, with the orientation that it has."""
    out = {}
    for a, b, c, d in tets:
        for x, y, p, q in ((a, b, c, d), (a, c, d, b), (a, d, b, c), (b, c, a, d), (b, d, c, a), (c, d, a, b)):
            out.setdefault((x, y) if x < y else (y, x), []).append((p, q) if x < y else (q, p))
    return out


def chain(pairs):
    """The corners that the pairs pass, one after the other, and whether they come back to the first; None if the pairs
    form more than one path or ring."""
    after = dict(pairs)
    if len(after) != len(pairs) or len(set(after.values())) != len(pairs):
        return None
    starts = after.keys() - after.values()
    if len(starts) > 1:
        return None
    corner = min(starts) if starts else pairs[0][0]
    out = [corner]
    while corner in after:
        corner = after.pop(corner)
        if corner == out[0]:
            return (out, True) if not after else None
        out.append(corner)
    return (out, False) if not after else None


def turns_of(points, edge, pairs):
    """Turns around an interior edge; None if its tets form no ring."""
    found = chain(pairs)
    if found is None or not found[1]:
        return None
    return turns(points[edge[0]], points[edge[1]], [points[v] for v in found[0]])


def faults(points, tets):
    """Why this is not the mesh of a solid, "" if it is one: all tets are positive, they form a 3-manifold with
    boundary, they make one turn around every interior edge. Coordinates are integers."""
    for t in tets:
        if len(set(t)) != 4 or volume(*(points[v] for v in t)) <= 0:
            return f"tet {t} is not positive"
    seen = set()
    for t in tets:
        for f in map(turned, map(tuple, faces_of(t))):
            if f in seen:
                return f"two tets lie on the same side of the face {f}"
            seen.add(f)
    outside = {f for f in seen if (f[0], f[2], f[1]) not in seen}
    return edge_faults(points, tets, outside) or vertex_faults(points, tets, outside)


def edge_faults(points, tets, outside):
    border = {frozenset((f[k], f[k - 1])) for f in outside for k in range(3)}
    for edge, pairs in parts_of_edges(tets).items():
        found = chain(pairs)
        if found is None:
            return f"the tets at the edge {edge} form more than one fan"
        if found[1] == (frozenset(edge) in border):
            return f"the tets at the edge {edge} meet at its ends only"
        if found[1]:
            around = turns(points[edge[0]], points[edge[1]], [points[v] for v in found[0]])
            if around != 1:
                return f"the tets at the edge {edge} make {around} turns"
    return ""


def vertex_faults(points, tets, outside):
    """Every vertex has a link that is a disc or a sphere."""
    links = {}
    for t in tets:
        for v, f in zip(t, faces_of(t)):
            links.setdefault(v, []).append(f)
    if len(links) != len(points):
        return "a vertex has no tet"
    at_border = {v for f in outside for v in f}
    for v, link in links.items():
        corners = {x for f in link for x in f}
        edges = {frozenset((f[k], f[k - 1])) for f in link for k in range(3)}
        if len(corners) - len(edges) + len(link) != (1 if v in at_border else 2) or not connected(link):
            return f"the tets at vertex {v} form no ball"
    if outside:
        used = sorted(at_border)
        new = {v: i for i, v in enumerate(used)}
        return surface_faults(Surface([points[v] for v in used], [tuple(new[v] for v in f) for f in sorted(outside)]))
    return ""


def connected(groups):
    """Whether groups of numbers hang together by what they share."""
    parent = {x: x for g in groups for x in g}

    def root(x):
        while parent[x] != x:
            parent[x] = parent[parent[x]]
            x = parent[x]
        return x

    for g in groups:
        for x in g[1:]:
            parent[root(x)] = root(g[0])
    return len({root(x) for x in parent}) == 1


class Solid:
    """Tets and their points in integers, vertices of the boundary first: what proves that the surface has a mesh."""

    def __init__(self, points, tets):
        outside = boundary(tets)
        border = sorted({v for f in outside for v in f})
        inside = sorted({v for t in tets for v in t} - set(border))
        new = {v: i for i, v in enumerate(border + inside)}
        self.points = [points[v] for v in border + inside]
        self.tets = [tuple(new[v] for v in t) for t in tets]
        faces = sorted(turned(tuple(new[v] for v in f)) for f in outside)
        self.surface = Surface([tuple(map(float, p)) for p in self.points[: len(border)]], faces)

    def faults(self):
        if any(int(float(x)) != x for p in self.points for x in p):
            return "a coordinate is no double"
        return faults(self.points, self.tets)
