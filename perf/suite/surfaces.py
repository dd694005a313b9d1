"""Surfaces as arrays: reads OFF, OBJ and PLY (binary, little endian), writes what other programs read. Needs numpy."""
import numpy

ROWS = 1 << 20  # written at a time


def read_off(data):
    words = numpy.array(b" ".join(line.split(b"#")[0] for line in data.split(b"\n")).split()[1:])
    points, count = int(words[0]), int(words[1])
    V = words[3:3 + 3 * points].astype(float).reshape(-1, 3)
    rows = words[3 + 3 * points:3 + 3 * points + 4 * count].astype(int).reshape(-1, 4)
    if (rows[:, 0] != 3).any():
        raise ValueError("the OFF file has faces that are no triangles")
    return V, rows[:, 1:]


def read_obj(data):
    lines = [line.split() for line in data.split(b"\n")]
    V = numpy.array([line[1:4] for line in lines if line[:1] == [b"v"]]).astype(float)
    corners = [[int(corner.split(b"/")[0]) for corner in line[1:]] for line in lines if line[:1] == [b"f"]]
    if any(len(face) != 3 for face in corners):
        raise ValueError("the OBJ file has faces that are no triangles")
    F = numpy.array(corners)
    return V, numpy.where(F < 0, F + len(V), F - 1)


def read_ply(data):
    head, body = data.split(b"end_header\n", 1)
    if b"format binary_little_endian" not in head:
        raise ValueError("the PLY file is not binary little endian")
    points = faces = 0
    columns = []
    element = b""
    for line in head.split(b"\n"):
        words = line.split()
        if words[:1] == [b"element"]:
            element = words[1]
            if element == b"vertex":
                points = int(words[2])
            else:
                faces = int(words[2])
        elif words[:1] == [b"property"] and element == b"vertex":
            columns.append((words[2].decode(), {b"float": "<f4", b"double": "<f8"}[words[1]]))
    table = numpy.frombuffer(body, dtype=columns, count=points)
    V = numpy.stack([table[axis] for axis in "xyz"], axis=1).astype(float)
    rows = numpy.frombuffer(body, dtype=[("n", "u1"), ("v", "<i4", 3)], count=faces, offset=table.nbytes)
    return V, rows["v"].astype(int)


def read(path):
    """#V x 3 coordinates and #F x 3 corners. Raises ValueError."""
    with open(path, "rb") as file:
        data = file.read()
    if data.startswith(b"ply"):
        return read_ply(data)
    return read_obj(data) if path.lower().endswith(".obj") else read_off(data)


def write_ply(path, V, F):
    rows = numpy.empty(len(F), dtype=[("n", "u1"), ("v", "<i4", 3)])
    rows["n"], rows["v"] = 3, F
    with open(path, "wb") as file:
        file.write(b"ply\nformat binary_little_endian 1.0\n"
                   b"element vertex %d\nproperty double x\nproperty double y\nproperty double z\n"
                   b"element face %d\nproperty list uchar int vertex_indices\nend_header\n" % (len(V), len(F)))
        V.astype("<f8").tofile(file)
        rows.tofile(file)


def write_off(path, V, F):
    with open(path, "w", encoding="ascii") as file:
        file.write("OFF\n%d %d 0\n" % (len(V), len(F)))
        for rows, form in ((V, "%.17g %.17g %.17g\n"), (F, "3 %d %d %d\n")):
            for begin in range(0, len(rows), ROWS):
                part = rows[begin:begin + ROWS]
                file.write(form * len(part) % tuple(part.ravel().tolist()))


def write_gmsh(path, V, F):
    """MSH 4.1, binary: one discrete surface, with the tag 1."""
    def put(file, kind, *numbers):
        numpy.array(numbers, kind).tofile(file)
    with open(path, "wb") as file:
        file.write(b"$MeshFormat\n4.1 1 8\n")
        put(file, "<i4", 1)
        file.write(b"\n$EndMeshFormat\n$Entities\n")
        put(file, "<u8", 0, 0, 1, 0)
        put(file, "<i4", 1)
        put(file, "<f8", *V.min(axis=0), *V.max(axis=0))
        put(file, "<u8", 0, 0)
        file.write(b"\n$EndEntities\n$Nodes\n")
        put(file, "<u8", 1, len(V), 1, len(V))
        put(file, "<i4", 2, 1, 0)
        put(file, "<u8", len(V))
        numpy.arange(1, len(V) + 1).astype("<u8").tofile(file)
        V.astype("<f8").tofile(file)
        file.write(b"\n$EndNodes\n$Elements\n")
        put(file, "<u8", 1, len(F), 1, len(F))
        put(file, "<i4", 2, 1, 2)
        put(file, "<u8", len(F))
        rows = numpy.empty((len(F), 4), "<u8")
        rows[:, 0], rows[:, 1:] = numpy.arange(1, len(F) + 1), F + 1
        rows.tofile(file)
        file.write(b"\n$EndElements\n")


def volume(V, F):
    """What the surface encloses, each place as often as it is enclosed."""
    total = 0.0
    for begin in range(0, len(F), ROWS):
        a, b, c = (V[F[begin:begin + ROWS, k]] - V[0] for k in range(3))
        total += float(numpy.einsum("ij,ij->", numpy.cross(a, b), c)) / 6
    return total
