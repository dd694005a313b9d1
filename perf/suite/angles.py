"""Tet meshes as they were written, judged alike whoever wrote them. Reads MSH 4.1 (text, binary) and TetGen's .node and .ele,
tets in blocks, so that 30 million need no more memory than their corners' coordinates. Needs numpy.
"""
import numpy

BLOCK = 1 << 20  # tets
NODES = {1: 2, 2: 3, 3: 4, 4: 4, 8: 3, 9: 6, 11: 10, 15: 1}  # of Gmsh's kinds of elements
TET = 4
STEPS = 1000  # a degree, when angles are counted


def numbers(file, kind, count, text):
    if text:
        return numpy.fromfile(file, sep=" ", count=count).astype(kind)
    return numpy.fromfile(file, kind, count)


def skip_to(file, marker):
    """Reads on until behind a line with the marker."""
    for line in file:
        if line.rstrip().endswith(marker):
            return
    raise ValueError(f"no {marker.decode()}")


class Gmsh:
    def __init__(self, path):
        self.file = open(path, "rb")  # pylint: disable=consider-using-with
        skip_to(self.file, b"$MeshFormat")
        version, binary, _ = self.file.readline().split()
        if not version.startswith(b"4.1"):
            raise ValueError("this MSH file is not of version 4.1")
        self.text = binary == b"0"
        skip_to(self.file, b"$Nodes")
        self.V, self.row = self.nodes()

    def get(self, kind, count):
        return numbers(self.file, kind, count, self.text)

    def nodes(self):
        blocks, count, _, most = (int(x) for x in self.get("<u8", 4))
        V = numpy.empty((count, 3))
        row = numpy.zeros(most + 1, dtype=numpy.int64)  # of each tag
        at = 0
        for _ in range(blocks):
            self.get("<i4", 3)
            n = int(self.get("<u8", 1)[0])
            if n == 0:
                continue
            row[self.get("<u8", n).astype(numpy.int64)] = numpy.arange(at, at + n)
            V[at:at + n] = self.get("<f8", 3 * n).reshape(n, 3)
            at += n
        return V, row

    def tets(self):
        with self.file:
            skip_to(self.file, b"$Elements")
            for _ in range(int(self.get("<u8", 4)[0])):
                kind = int(self.get("<i4", 3)[2])
                left = int(self.get("<u8", 1)[0])
                while left > 0:
                    n = min(left, BLOCK)
                    rows = self.get("<u8", n * (1 + NODES[kind])).reshape(n, -1)
                    if kind == TET:
                        yield self.row[rows[:, 1:].astype(numpy.int64)]
                    left -= n


class TetGen:
    def __init__(self, node):
        self.ele = node[:-len(".node")] + ".ele"
        with open(node, "rb") as file:
            count, _, attributes, markers = (int(x) for x in file.readline().split()[:4])
            rows = numbers(file, "<f8", count * (4 + attributes + markers), True).reshape(count, -1)
        self.first = int(rows[0, 0])
        self.V = rows[:, 1:4].copy()

    def tets(self):
        with open(self.ele, "rb") as file:
            left, corners, attributes = (int(x) for x in file.readline().split()[:3])
            while left > 0:
                n = min(left, BLOCK)
                rows = numbers(file, numpy.int64, n * (1 + corners + attributes), True).reshape(n, -1)
                yield rows[:, 1:5] - self.first
                left -= n


def dihedral_angles(P):
    """Of n x 4 x 3 corners: the six dihedral angles of each tet in degrees, and six times the signed volumes."""
    a, b, c, d = (P[:, k] for k in range(4))
    normals = (numpy.cross(c - b, d - b), numpy.cross(d - a, c - a), numpy.cross(b - a, d - a), numpy.cross(c - a, b - a))
    det = -numpy.einsum("ij,ij->i", normals[3], d - a)
    angles = numpy.empty((6, len(P)))
    for n, (i, j) in enumerate((i, j) for i in range(4) for j in range(i)):
        # The two faces meet at the edge of the other two corners; their normals' cross product is that edge times det.
        k, m = (x for x in range(4) if x not in (i, j))
        length = numpy.sqrt(numpy.einsum("ij,ij->i", P[:, k] - P[:, m], P[:, k] - P[:, m]))
        cosine = -numpy.einsum("ij,ij->i", normals[i], normals[j])
        angles[n] = numpy.degrees(numpy.arctan2(numpy.abs(det) * length, cosine))
    return angles, det


def judge(path):
    """{points, tets, least, percent, volume, turned}: percent is the angle that 1 % of all dihedral angles are below, to a
    thousandth of a degree; turned, how many tets are not as most are oriented."""
    mesh = TetGen(path) if path.endswith(".node") else Gmsh(path)
    counts = numpy.zeros(180 * STEPS + 1, dtype=numpy.int64)
    least, volume, signs = numpy.inf, 0.0, [0, 0, 0]
    for T in mesh.tets():
        angles, det = dihedral_angles(mesh.V[T])
        counts += numpy.bincount((angles.ravel() * STEPS).astype(numpy.int64), minlength=len(counts))
        least = min(least, float(angles.min()))
        volume += float(numpy.abs(det).sum()) / 6
        for k, sign in enumerate((-1, 0, 1)):
            signs[k] += int((numpy.sign(det) == sign).sum())
    tets = sum(signs)
    result = {"points": len(mesh.V), "tets": tets, "least": None, "percent": None, "volume": volume,
              "turned": min(signs[0], signs[2]) + signs[1]}
    if tets:
        result.update(least=least, percent=int(numpy.searchsorted(numpy.cumsum(counts), .01 * 6 * tets)) / STEPS)
    return result
