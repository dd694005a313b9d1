"""What the examples of the cantilever share: a beam whose faces have labels, its mesh, and what Overtet makes of a load.

The beam is 8 long, 1 high and 1 wide, its Young's modulus 1, its Poisson's ratio 0.3. It is held at x = 0, and a force per
area along -z acts at x = 8. A small load shows the linear limit; a large one bends the tip by a third of the length.
"""
import json

import numpy
import overlap

LENGTH, YOUNG, POISSON = 8, 1.0, 0.3
SMALL, LARGE = 1e-7, 1.5e-3  # forces per area
AGREEMENT = 1e-3             # relative, of the displacement at the tip


class Cantilever:
    """The mesh as a file of each format named, its vertices, and forces at them."""

    def __init__(self, example, endings, cells=3):
        self.example = example
        path = example.path("beam.obj")
        write_box(path, cells)
        self.surface = overlap.Surface(path)
        for ending in ("vtu", *endings):
            self.path, self.vertices, self.tets = example.mesh(self.surface, f"beam.{ending}", "--max-edge", str(1.5 / cells))
        self.tip = numpy.flatnonzero(self.surface.points[:, 0] == LENGTH)  # the surface's vertices come first

    def forces(self, traction):
        """At each vertex of the tip, along z: a third of that on each of its triangles."""
        points, faces = self.surface.points, self.surface.faces[self.surface.label_of == self.surface.labels["tip"]]
        area = numpy.linalg.norm(numpy.cross(points[faces[:, 1]] - points[faces[:, 0]],
                                             points[faces[:, 2]] - points[faces[:, 0]]), axis=1) / 2
        force = numpy.zeros(len(points))
        numpy.add.at(force, faces.ravel(), numpy.repeat(-traction * area / 3, 3))
        return force

    def solve(self, traction, material):
        """Overtet's displacements, and its figures."""
        output = self.example.path("bent.vtu")
        said = self.example.run(self.example.program, "solve", "elastic", self.example.path("beam.vtu"), "-o", output, "--json",
                                "--material", material, "--young", str(YOUNG), "--poisson", str(POISSON), "--fix", "label:base",
                                "--traction", f"label:tip=0;0;{-traction}", "--tolerance", "1e-12")
        return read(output, "displacement"), json.loads(said)

    def compare(self, what, traction, material, other, seconds):
        """other: the other solver's displacements, by vertex."""
        ours, figures = self.solve(traction, material)
        wanted = numpy.linalg.norm(other[self.tip].mean(axis=0))
        self.example.small(f"{what}: difference at the tip, of its displacement of {wanted:.4g}", difference(ours, other, self.tip),
                           AGREEMENT)
        self.example.small(f"{what}: the largest difference, of the largest displacement",
                           numpy.linalg.norm(ours - other, axis=1).max() / numpy.linalg.norm(other, axis=1).max(), AGREEMENT)
        own = sum(step["seconds"] for step in figures["steps"])
        print(f"       {self.tets} tets: {own:.2f} s ({figures['iterations']} iterations); the other solver {seconds:.2f} s")


def difference(ours, other, vertices):
    """Of the mean displacement of these vertices, relative."""
    mine, wanted = ours[vertices].mean(axis=0), other[vertices].mean(axis=0)
    return numpy.linalg.norm(mine - wanted) / numpy.linalg.norm(wanted)


def read(path, name=None):
    """Of a .vtu file the data of this name, or the points."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    grid = reader.GetOutput()
    return vtk_to_numpy(grid.GetPointData().GetArray(name) if name else grid.GetPoints().GetData())


def write_box(path, cells):
    """The beam's surface: squares of 1/cells, cut in two, in the groups base, tip and sides."""
    counts = numpy.array([LENGTH * cells, cells, cells])
    numbers, points, groups = {}, [], {"base": [], "tip": [], "sides": []}

    def vertex(corner):
        if tuple(corner) not in numbers:
            numbers[tuple(corner)] = len(points) + 1
            points.append(numpy.array(corner) / cells)
        return numbers[tuple(corner)]
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for end in (0, counts[axis]):
            group = "sides" if axis > 0 else "tip" if end else "base"
            for i in range(counts[u]):
                for k in range(counts[v]):
                    square = []
                    for di, dk in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        corner = [0, 0, 0]
                        corner[axis], corner[u], corner[v] = end, i + di, k + dk
                        square.append(vertex(corner))
                    a, b, c, d = square if end else reversed(square)
                    groups[group] += [(a, b, c), (a, c, d)] if (i + k) % 2 else [(a, b, d), (b, c, d)]
    with open(path, "w", encoding="ascii") as file:
        file.writelines(f"v {x!r} {y!r} {z!r}\n" for x, y, z in numpy.array(points).tolist())
        for group, faces in groups.items():
            file.write(f"g {group}\n")
            file.writelines(f"f {a} {b} {c}\n" for a, b, c in faces)
