#!/usr/bin/python3
"""Linear elasticity in a solid that overlaps itself, with CalculiX, and patch tests.

CalculiX reads Abaqus files: *INCLUDE, INPUT=worm.inp. Regions are element sets there (REGION_1), labels are surfaces for
loads (LABEL_2_HEAD) and node sets for supports (N_LABEL_1_TAIL); the surface BOUNDARY has all boundary faces.
"""
import os
import re
import shutil
import sys

import numpy

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, ".."))
import overlap  # noqa: E402

YOUNG, POISSON = 1.0, 0.3  # as in the .inp files
PRINTED = 2e-6  # CalculiX prints seven digits of stresses, forces and volumes


def text(x):
    """With as many digits as there is room for: CalculiX reads 20 characters of a number."""
    return next(t for t in (f"{x:.{digits}g}" for digits in range(17, 0, -1)) if len(t) <= 20)


def solve(example, name):
    """What CalculiX says, and what it writes to its .dat file: of each heading, the lines of numbers."""
    shutil.copy(os.path.join(HERE, name + ".inp"), example.folder)
    said = example.run("ccx", name)
    if "*ERROR" in said:
        sys.exit(said)
    tables, rows = {}, []
    with open(example.path(name + ".dat"), encoding="ascii") as file:
        for line in file:
            if re.search("[a-z]", line):
                tables[re.sub(r" *\(.*\)| and time.*", "", line.strip())] = rows = []
            elif line.strip():
                rows.append([float(x) for x in line.split()])
    return said, {heading: numpy.array(table) for heading, table in tables.items()}


def nodes_and_corners(path, vertices, tets):
    """The mesh that CalculiX writes with a result, from a binary .frd file."""
    with open(path, "rb") as file:
        data = file.read()

    def block(heading, kind, count):
        return numpy.frombuffer(data, kind, count, data.index(b"\n", data.index(heading)) + 1)
    return (block(b"   2C", [("number", "<i4"), ("x", "<f8", 3)], vertices)["x"],
            block(b"   3C", [("number", "<i4"), ("what", "<i4", 3), ("corners", "<i4", 4)], tets)["corners"] - 1)


def coordinates(path):
    """The vertices as CalculiX gets them, from lines "number, x, y, z"."""
    with open(path, encoding="ascii") as file:
        lines = file.read().split("*NODE, NSET=ALL_NODES\n")[1].split("*", 1)[0].splitlines()
    return numpy.array([[float(x) for x in line.split(",")[1:]] for line in lines])


def write_patch_test(example, points, outside, matrix, shift):
    """What patch.inp includes. One node more for each inside, and four for the linear displacement."""
    inside = numpy.setdiff1d(numpy.arange(len(points)), outside)
    error, linear = len(points) + 1, len(points) + len(inside) + 1
    with open(example.path("conditions.inp"), "w", encoding="ascii") as file:
        file.write("*NODE, NSET=ERRORS\n")
        file.writelines(f"{error + i}, 0, 0, 0\n" for i in range(len(inside)))
        file.write("*NODE\n")
        file.writelines(f"{linear + i}, 0, 0, 0\n" for i in range(4))
        file.write("*EQUATION\n")
        for i, v in enumerate(inside):
            x, y, z = (text(-c) for c in points[v])
            file.writelines(f"6\n{error + i}, {k}, -1, {v + 1}, {k}, 1, {linear}, {k}, {x}, {linear + 1}, {k}, {y}\n"
                            f"{linear + 2}, {k}, {z}, {linear + 3}, {k}, -1\n" for k in (1, 2, 3))
    with open(example.path("values.inp"), "w", encoding="ascii") as file:
        for node, values in enumerate(list(matrix.T) + [shift], linear):
            file.writelines(f"{node}, {k}, {k}, {text(x)}\n" for k, x in enumerate(values, 1))
        write_values(file, outside, points @ matrix.T + shift)


def write_values(file, vertices, displacement):
    for v in vertices:
        file.writelines(f"{v + 1}, {k}, {k}, {text(x)}\n" for k, x in enumerate(displacement[v], 1))


def main():
    example = overlap.Example(__doc__, {"ccx": "calculix-ccx"})
    surface = example.worm()
    path, vertices, tets = example.mesh(surface, "worm.inp")
    points = coordinates(path)
    outside = numpy.arange(len(surface.points))  # the surface's vertices come first

    # Patch test: constant strain on the whole boundary is constant strain inside.
    matrix = numpy.array([[1.0, 0.5, -0.2], [0.1, -0.7, 0.3], [0.4, 0.2, 0.6]])
    shift = numpy.array([0.1, 0.2, 0.3])
    write_patch_test(example, points, outside, matrix, shift)
    said, tables = solve(example, "patch")
    example.equal("tets", int(re.search(r"elements: *(\d+)", said)[1]), tets)
    example.close("volume", tables["total volume for set REGION_1"][0, 0], surface.volume, PRINTED)
    displacement = points @ matrix.T + shift
    errors = tables["displacements for set ERRORS"][:, 1:]
    example.equal("vertices inside", len(errors), vertices - len(outside))
    example.small("patch test: error of a linear displacement", numpy.abs(errors).max() / numpy.abs(displacement).max())
    strain = (matrix + matrix.T) / 2
    wanted = YOUNG / (1 + POISSON) * (strain + POISSON / (1 - 2 * POISSON) * numpy.trace(strain) * numpy.eye(3))
    wanted = wanted[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    stresses = tables["stresses for set REGION_1"]
    example.equal("tets with a stress", len(stresses), tets)
    example.small("patch test: error of the constant stress (7 digits are printed)",
                  numpy.abs(stresses[:, 2:] - wanted).max() / numpy.abs(wanted).max(), PRINTED)

    # The tail is held, the head pushed.
    said, tables = solve(example, "push")
    head = surface.labels["head"]
    example.equal("faces of the head", int(re.search(r"facial loads: *(\d+)", said)[1]),
                  numpy.count_nonzero(surface.label_of == head))
    force, = tables["total force for set N_LABEL_1_TAIL"]
    wanted = surface.area_vector(head)
    example.small("force at the tail, against that at the head (7 digits are printed)",
                  numpy.abs(force - wanted).max() / numpy.abs(wanted).max(), PRINTED)
    moved = numpy.linalg.norm(tables["displacements for set ALL_NODES"][:, 1:], axis=1)
    nodes, corners = nodes_and_corners(example.path("patch.frd"), vertices, tets)
    example.small("error of the vertices that CalculiX has (20 characters are read)", numpy.abs(nodes - points).max())
    example.equal("vertices after merging equal ones", len({tuple(p) for p in nodes.tolist()}), vertices)
    tail, head = example.values_of_layers(nodes, corners, moved)
    example.between("share of the head's displacement that the tail has at that place", tail / head, 0.0, 0.05)

    # A pressure on all boundary faces, the other kind of patch test; also with tets of second order.
    with open(example.path("values.inp"), "w", encoding="ascii") as file:
        write_values(file, outside[:3], -(1 - 2 * POISSON) / YOUNG * points)
    for order, integration_points in (("1", 1), ("2", 4)):
        example.mesh(surface, "worm.inp", "--order", order)
        said, tables = solve(example, "pressure")
        example.equal(f"boundary faces, order {order}", int(re.search(r"facial loads: *(\d+)", said)[1]), len(surface.faces))
        stresses = tables["stresses for set REGION_1"]
        example.equal(f"integration points with a stress, order {order}", len(stresses), integration_points * tets)
        example.small(f"patch test, order {order}: error of a constant pressure (7 digits are printed)",
                      numpy.abs(stresses[:, 2:] - [-1, -1, -1, 0, 0, 0]).max(), PRINTED)
    example.finish()


main()
