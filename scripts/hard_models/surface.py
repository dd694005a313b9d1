"""Surfaces: lists of points and of faces. What makes them closed, oriented and manifold; OFF files."""

from .errors import Unreadable
from .exact import integers, normal


class Surface:
    def __init__(self, points, faces):
        self.points = [tuple(p) for p in points]
        self.faces = [tuple(f) for f in faces]

    def next_corner(self):
        """(a, b) -> c for every face (a, b, c); of several faces at a directed edge the last."""
        return {(f[k], f[(k + 1) % 3]): f[(k + 2) % 3] for f in self.faces for k in range(3)}

    def components(self):
        """Lists of faces, in the order of their first ones."""
        at = {}
        for i, f in enumerate(self.faces):
            for v in f:
                at.setdefault(v, []).append(i)
        seen, out = set(), []
        for start in range(len(self.faces)):
            if start in seen:
                continue
            seen.add(start)
            component, todo = [], [start]
            while todo:
                i = todo.pop()
                component.append(i)
                for v in self.faces[i]:
                    for j in at.pop(v, ()):
                        if j not in seen:
                            seen.add(j)
                            todo.append(j)
            out.append(sorted(component))
        return out

    def only(self, faces):
        """The surface of these faces, without points that are not used."""
        used = sorted({v for f in faces for v in f})
        new = {v: i for i, v in enumerate(used)}
        return Surface([self.points[v] for v in used], [tuple(new[v] for v in f) for f in faces])

    def has_flat_face(self):
        points = integers(self.points)
        return any(normal(*(points[v] for v in f)) == (0, 0, 0) for f in self.faces)


def joined(*surfaces):
    points, faces = [], []
    for s in surfaces:
        faces += [tuple(v + len(points) for v in f) for f in s.faces]
        points += s.points
    return Surface(points, faces)


def flipped(surface):
    return Surface(surface.points, [(a, c, b) for a, b, c in surface.faces])


def faults(surface):
    """Why the surface is not closed, oriented and manifold; "" if it is."""
    n = len(surface.points)
    across = {}
    for f in surface.faces:
        if len(set(f)) != 3 or min(f) < 0 or max(f) >= n:
            return f"face {f} does not have three corners"
        for k in range(3):
            if (f[k], f[(k + 1) % 3]) in across:
                return f"two faces go from vertex {f[k]} to {f[(k + 1) % 3]}"
            across[f[k], f[(k + 1) % 3]] = f[(k + 2) % 3]
    degree = [0] * n
    first = [None] * n
    for (a, b), _ in across.items():
        if (b, a) not in across:
            return f"the edge from vertex {a} to {b} has one face"
        degree[a] += 1
        first[a] = b
    for v in range(n):
        if first[v] is None:
            return f"vertex {v} has no face"
        around, b = 0, first[v]
        while around == 0 or b != first[v]:
            b = across[v, b]
            around += 1
        if around != degree[v]:
            return f"the faces at vertex {v} form more than one fan"
    return ""


def write_off(surface, path, comments=()):
    with open(path, "w", encoding="ascii") as file:
        file.write(off_text(surface, comments))


def off_text(surface, comments=()):
    lines = ["OFF", *("# " + line for line in comments), f"{len(surface.points)} {len(surface.faces)} 0"]
    lines += [" ".join(map(repr, map(float, p))) for p in surface.points]
    lines += ["3 " + " ".join(map(str, f)) for f in surface.faces]
    return "\n".join(lines) + "\n"


def read_off(path):
    """The surface and the comments of a file that write_off() made."""
    try:
        with open(path, encoding="ascii") as file:
            lines = file.read().splitlines()
        comments = [line[1:].strip() for line in lines if line.startswith("#")]
        rows = [line.split() for line in lines if line.strip() and not line.startswith("#")]
        n, m = int(rows[1][0]), int(rows[1][1])
        points = [tuple(map(float, row)) for row in rows[2 : 2 + n]]
        faces = [tuple(map(int, row[1:4])) for row in rows[2 + n : 2 + n + m]]
    except (OSError, ValueError, IndexError) as e:
        raise Unreadable(f"{path}: {e}") from e
    if len(faces) != m or any(len(x) != 3 for x in points + faces):
        raise Unreadable(f"{path}: not a surface as this script writes them")
    return Surface(points, faces), comments
