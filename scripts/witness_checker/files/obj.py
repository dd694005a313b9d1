"""OBJ: the lines `v` and `f`, whose corners count from 1, or backwards from the last vertex."""

from .triangle import triangle


def read(data):
    points, faces = [], []
    for line in data.decode(errors="replace").splitlines():
        words = line.split("#")[0].split()
        if not words:
            continue
        if words[0] == "v":
            points.append(tuple(float(x) for x in words[1:4]))
        elif words[0] == "f":
            corners = [int(w.split("/")[0]) for w in words[1:]]
            faces.append(triangle([c - 1 if c > 0 else len(points) + c for c in corners]))
    return points, faces
