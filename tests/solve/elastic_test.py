"""overtet solve elastic: the worm that bites its tail, read back with VTK; a collection of frames; and what it refuses."""
import json
import os
import re
import subprocess
import sys
import tempfile

import numpy
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

PROGRAM, SOURCE = sys.argv[1:3]
sys.path.insert(0, os.path.join(SOURCE, "examples"))
import overlap  # noqa: E402


def run(*words, code=0):
    done = subprocess.run([PROGRAM, *words], capture_output=True, text=True, check=False)
    assert done.returncode == code, (words, done.returncode, done.stderr)
    return done.stdout + done.stderr


def read(path):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    grid = reader.GetOutput()
    data = grid.GetPointData()
    names = [data.GetArrayName(i) for i in range(data.GetNumberOfArrays())]
    tets = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4)
    return vtk_to_numpy(grid.GetPoints().GetData()), tets, {name: vtk_to_numpy(data.GetArray(name)) for name in names}


def main():
    with tempfile.TemporaryDirectory() as folder:
        def file(name):
            return os.path.join(folder, name)
        subprocess.run([sys.executable, "-B", os.path.join(SOURCE, "scripts", "make_sample"), file("worm.obj"),
                        str(overlap.DEGREES), "16"], check=True, stdout=subprocess.DEVNULL)
        run("mesh", file("worm.obj"), "-o", file("worm.vtu"))
        start, tets, _ = read(file("worm.vtu"))

        # The tail is held, the head pulled: where both are, the tail barely moves.
        figures = json.loads(run("solve", "elastic", file("worm.vtu"), "-o", file("pulled.vtu"), "--fix", "label:tail", "--traction",
                                 "label:head=0;0;2e-3", "--json"))
        assert figures["end"] == "converged" and figures["residual"] <= 1e-8 and figures["least_ratio"] > 0, figures
        places, same, data = read(file("pulled.vtu"))
        assert (same == tets).all() and abs(places - data["displacement"] - start).max() < 1e-15 * 8
        assert (data["von_mises"] >= 0).all() and figures["most_von_mises"] == data["von_mises"].max()
        moved = numpy.linalg.norm(data["displacement"], axis=1)
        hit, weights = overlap.tets_at(start, tets, overlap.PLACE)
        assert len(hit) == 2
        tail, head = sorted(float(w @ moved[tets[t]]) for t, w in zip(hit, weights))
        assert head > .1 and tail < .05 * head, (tail, head)
        edges = places[tets[:, 1:]] - places[tets[:, :1]]
        assert (numpy.linalg.det(edges) > 0).all()

        # Released into the shape that it was made in: all goes back.
        run("solve", "elastic", file("pulled.vtu"), "--rest", file("worm.vtu"), "-o", file("back.vtu"), "--fix", "label:tail")
        assert abs(read(file("back.vtu"))[0] - start).max() < 1e-6

        # Motion: a file a frame, and the collection that lists them; the same on any number of threads.
        words = ["solve", "elastic", file("worm.vtu"), "--fix", "label:tail", "--gravity", "0,0,-0.01", "--dynamic", "--frames", "4",
                 "--step", "0.5", "--damping", "0.1,0.01", "--pull", "label:head=0; 0.05*t; 0"]
        for method in ("newton", "quasi-newton"):
            for threads in ("1", "2"):
                run(*words, "-o", file(f"film{threads}.pvd"), "--method", method, "--threads", threads)
            with open(file("film1.pvd"), encoding="ascii") as f:
                frames = re.findall(r'timestep="([^"]*)" file="([^"]*)"', f.read())
            assert [float(t) for t, _ in frames] == [0, .5, 1, 1.5, 2] and frames[4][1] == "film1_0004.vtu"
            for _, name in frames:
                with open(file(name), "rb") as one, open(file(name.replace("film1", "film2")), "rb") as two:
                    assert one.read() == two.read(), name
            places, _, data = read(file("film1_0004.vtu"))
            label = numpy.isclose(data["displacement"][:, 1], .1, atol=1e-12)
            assert label.sum() > 20 and abs(data["velocity"]).max() > 0

        # What cannot be moved so is said, and the frames before it are there.
        said = run("solve", "elastic", file("worm.vtu"), "-o", file("cut.pvd"), "--fix", "all", "--pull", "vertices:0=0.1*t;0.1*t;5*t",
                   "--frames", "5", code=4)
        assert "tet" in said and "flat" in said, said
        with open(file("cut.pvd"), encoding="ascii") as f:
            names = re.findall(r'file="([^"]*)"', f.read())
        assert 1 <= len(names) < 6 and all(os.path.exists(file(n)) for n in names)
        assert not os.path.exists(file(f"cut_{len(names):04d}.vtu"))

        # Wrong words.
        held = ["--fix", "label:tail"]
        for words, said in (
                (["-o", "q.vtu"], "can still move"),
                (["-o", "q.vtu", "--fix", "label:nose"], "no label named 'nose'"),
                (["-o", "q.vtu", *held, "--pull", "label:head=1;2"], "three formulas"),
                (["-o", "q.vtu", *held, "--pull", "label:head=1;2;3;4"], "three formulas"),
                (["-o", "q.vtu", *held, "--pull", "label:head=1;2;q"], "formula 'q'"),
                (["-o", "q.vtu", *held, "--gravity", "1,2"], "X,Y,Z"),
                (["-o", "q.vtu", *held, "--poisson", "0.5"], "--poisson"),
                (["-o", "q.vtu", *held, "--step", "0.5"], "--dynamic"),
                (["-o", "q.vtu", *held, "--force", "label:head=0;0;1"], "at vertices"),
                (["-o", "q.vtu", *held, "--traction", "vertices:1=0;0;1"], "on triangles"),
                (["-o", "q.vtu", *held, "--value", "all=1"], "no option of elastic"),
                (["-o", "q.mesh", *held], ".pvd"),
                (["-o", "q.vtu", *held, "--material", "rubber"], "rubber")):
            words = [file(w) if w.startswith("q.") else w for w in words]
            assert said in run("solve", "elastic", file("worm.vtu"), *words, code=2), (words, said)
            assert not os.path.exists(file("q.vtu"))
        os.rename(file("worm.vtu"), file("worm_0001.vtu"))
        assert "overwrite the input" in run("solve", "elastic", file("worm_0001.vtu"), "-o", file("worm.pvd"), *held, code=2)


main()
