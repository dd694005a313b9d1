"""A closed oriented surface in integers: the file's doubles times a power of two, which loses nothing.

Doubles are kept beside them for boxes only. Boxes skip what is far away, and are so much too large
(`FAR`, relative to the coordinates, against roundings of 1e-15) that nothing near is ever skipped.
"""

import numpy as np

from ..errors import Refuted, Unreadable
from .vectors import cross, dot, sub

FAR = 1e-12
TINY = 1e-300  # where doubles lose digits


class Surface:
    def __init__(self, points, faces):
        ratios = [[x.as_integer_ratio() for x in p] for p in points]
        self.scale = max(d for p in ratios for _, d in p)  # powers of two: the largest will do
        self.points = [tuple(n * (self.scale // d) for n, d in p) for p in ratios]
        self.faces = faces
        self.twin = face_left_of_edges(faces)  # (a, b): the face with this edge in this direction
        self.at_vertex = [[] for _ in points]
        for f, corners in enumerate(faces):
            for v in corners:
                self.at_vertex[v].append(f)
        self.index = np.array(faces)
        self.float_points = np.array(points)
        corners = self.float_points[self.index]  # F x 3 x 3
        self.low, self.high = corners.min(axis=1), corners.max(axis=1)
        self.size = float(np.abs(self.float_points).max())
        self.shadows = {}  # of winding.py
        self.rest = self.away = None  # what it moves away from, and in which direction

    def corners(self, f):
        a, b, c = self.faces[f]
        return self.points[a], self.points[b], self.points[c]

    def normal(self, f):
        a, b, c = self.corners(f)
        return cross(sub(b, a), sub(c, a))

    def edges_of(self, f):
        a, b, c = self.faces[f]
        return (a, b), (b, c), (c, a)

    def faces_near(self, q):
        """Faces among which are all that contain a point."""
        near = np.array([float(x / self.scale) for x in q])
        room = FAR * (self.size + float(np.abs(near).max())) + TINY
        return [int(f) for f in np.nonzero(((self.low <= near + room) & (self.high >= near - room)).all(axis=1))[0]]

    def box(self, a, b):
        """Of the segment from vertex a to vertex b, exactly."""
        pa, pb = self.float_points[a], self.float_points[b]
        return np.minimum(pa, pb), np.maximum(pa, pb)

    def faces_in(self, low, high):
        """Faces whose boxes meet a box."""
        return [int(g) for g in np.nonzero(((self.low <= high) & (self.high >= low)).all(axis=1))[0]]

    def faces_at(self, q):
        """The faces that contain a point."""
        found = set()
        for f in self.faces_near(q):
            corners, n = self.corners(f), self.normal(f)
            walls = (cross(n, sub(corners[(k + 1) % 3], corners[k])) for k in range(3))
            if dot(n, sub(q, corners[0])) == 0 and all(
                dot(wall, sub(q, corners[k])) >= 0 for k, wall in enumerate(walls)
            ):
                found.add(f)
        return found

    def component(self, vertex, away):
        """The component of a vertex, with the same numbers, moved from the rest by as little as you like."""
        found, stack = set(self.at_vertex[vertex]), list(self.at_vertex[vertex])
        while stack:
            for s, t in self.edges_of(stack.pop()):
                f = self.twin[t, s]
                if f not in found:
                    found.add(f)
                    stack.append(f)
        points = [tuple(float(x) for x in p) for p in self.float_points]
        out = Surface(points, [c for f, c in enumerate(self.faces) if f in found])
        others = [c for f, c in enumerate(self.faces) if f not in found]
        if not others:
            raise Refuted("there is nothing to move away from")
        out.rest, out.away = Surface(points, others), away
        return out


def face_left_of_edges(faces):
    """For each directed edge its face; every edge must be used once in each direction."""
    twin = {}
    for f, (a, b, c) in enumerate(faces):
        for s, t in ((a, b), (b, c), (c, a)):
            if s == t or (s, t) in twin:
                raise Unreadable(f"edge {s}-{t} is not used once in each direction")
            twin[s, t] = f
    for s, t in twin:
        if (t, s) not in twin:
            raise Unreadable(f"edge {s}-{t} has only one face")
    return twin
