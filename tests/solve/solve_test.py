"""overtet solve, read back with VTK: fields, distances, and what it refuses."""
import json
import math
import os
import subprocess
import sys
import tempfile

import numpy
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

PROGRAM, SOURCE = sys.argv[1:3]


def run(*words, code=0):
    done = subprocess.run([PROGRAM, *words], capture_output=True, text=True, check=False)
    assert done.returncode == code, (words, done.returncode, done.stderr)
    return done.stdout + done.stderr


def read(path, name):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    grid = reader.GetOutput()
    return vtk_to_numpy(grid.GetPoints().GetData()), vtk_to_numpy(grid.GetPointData().GetArray(name)), grid


def main():
    with tempfile.TemporaryDirectory() as folder:
        def file(name):
            return os.path.join(folder, name)
        subprocess.run([sys.executable, "-B", os.path.join(SOURCE, "scripts", "make_sample"), file("worm.off"), "390", "16"],
                       check=True, stdout=subprocess.DEVNULL)
        run("mesh", file("worm.off"), "-o", file("worm.vtu"))
        for order in ("1", "2"):
            run("solve", "laplace", file("worm.vtu"), "-o", file("u.vtu"), "--value", "all=1+x-2*y+z/4", "--order", order)
            p, u, grid = read(file("u.vtu"), "u")
            assert len(u) == len(p) and grid.GetCell(0).GetNumberOfPoints() == (4 if order == "1" else 10)
            assert abs(u - (1 + p[:, 0] - 2 * p[:, 1] + p[:, 2] / 4)).max() < 1e-12
        # With a source, a label and a flux: the figures, and a formula from a file.
        with open(file("formula"), "w", encoding="ascii") as f:
            f.write("0 * x\n")
        figures = json.loads(run("solve", "poisson", file("worm.vtu"), "-o", file("p.vtu"), "--value", f"label:1=@{file('formula')}",
                                 "--source", "1", "--json"))
        assert figures["least"] == 0 and figures["most"] > 0 and figures["residual"] < 1e-10, figures
        # The distance from the tail to the head, which lie in one place, is the way through the worm.
        p, _, grid = read(file("worm.vtu"), "input_vertex")
        tail = int(numpy.argmin(read_ring(p)))
        run("solve", "geodesic", file("worm.vtu"), "-o", file("d.vtu"), "--from", f"vertices:{tail}")
        p, distance, _ = read(file("d.vtu"), "distance")
        assert distance[tail] == 0 and numpy.isfinite(distance).all() and (distance >= 0).all()
        far = int(distance.argmax())
        beeline = float(numpy.linalg.norm(p[far] - p[tail]))
        assert distance[far] > 2 * beeline, (distance[far], beeline)
        # What is wrong is said.
        for words, said in (
                (["laplace", "worm.vtu", "-o", "q.vtu", "--value", "all=x+("], "formula 'x+('"),
                (["laplace", "worm.vtu", "-o", "q.vtu", "--value", "label:77=1"], "label 77"),
                (["laplace", "worm.vtu", "-o", "q.vtu", "--value", "label:none=1"], "no label named 'none'"),
                (["laplace", "worm.vtu", "-o", "q.vtu", "--value", "here=1"], "'here' is no place"),
                (["laplace", "worm.vtu", "-o", "q.vtu", "--value", "vertices:1e9=1"], "no number of a vertex"),
                (["laplace", "worm.vtu", "-o", "q.vtu"], "No value is given"),
                (["laplace", "worm.vtu", "-o", "q.mesh", "--value", "all=1"], ".vtu or .vtk"),
                (["geodesic", "worm.vtu", "-o", "q.vtu"], "--from WHERE"),
                (["laplace", "worm.vtu", "-o", "worm.vtu", "--value", "all=1"], "overwrite the input")):
            words = [file(w) if "." in w and "=" not in w else w for w in words]
            assert said in run("solve", *words, code=2), (words, said)
            assert not os.path.exists(file("q.vtu"))
        assert "is not finite" in run("solve", "laplace", file("worm.vtu"), "-o", file("q.vtu"), "--value", "all=1/(x-x)", code=3)


def read_ring(p):
    """How far round the ring each point is, from one end of the worm: the smallest is near that end."""
    return numpy.arctan2(p[:, 1], p[:, 0]) % (2 * math.pi)


main()
