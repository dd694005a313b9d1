"""overtet solve weights and skin: the overlap is kept apart, files read back, and what is refused."""
import json
import math
import os
import struct
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


def read(path):
    """Points, tets and the arrays of the points."""
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    grid = reader.GetOutput()
    data = grid.GetPointData()
    return (vtk_to_numpy(grid.GetPoints().GetData()), vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4),
            {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)) for i in range(data.GetNumberOfArrays())})


def axis(degrees):
    """The middle of the worm of scripts/make_sample."""
    a = math.radians(degrees)
    r = 1 - 0.011 * a
    return [r * math.sin(a), -r * math.cos(a), 0.315 * a / (2 * math.pi)]


def write(path, what):
    with open(path, "w", encoding="utf-8") as file:
        file.write(what if isinstance(what, str) else json.dumps(what))


def chain(first, last, count, step):
    """Bones along the worm; each has the one before it as its parent."""
    bones = []
    for k in range(count):
        bones.append({"name": f"bone {k}", "head": axis(first + k * step), "tail": axis(first + (k + 1) * step)})
        if k:
            bones[-1]["parent"] = f"bone {k - 1}"
    assert abs(first + count * step - last) < 1e-9
    return bones


def read_glb(path):
    """The arrays of the only primitive, and all of the JSON."""
    with open(path, "rb") as file:
        data = file.read()
    magic, version, total, size, kind = struct.unpack("<5I", data[:20])
    assert (magic, version, total, kind) == (0x46546C67, 2, len(data), 0x4E4F534A) and size % 4 == 0
    j = json.loads(data[20:20 + size])
    body_size, body_kind = struct.unpack("<2I", data[20 + size:28 + size])
    body = data[28 + size:]
    assert body_kind == 0x004E4942 and body_size == len(body) == j["buffers"][0]["byteLength"]

    def array(number):
        accessor = j["accessors"][number]
        view = j["bufferViews"][accessor["bufferView"]]
        assert view["byteOffset"] % 4 == 0
        kind = {5123: "<u2", 5125: "<u4", 5126: "<f4"}[accessor["componentType"]]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}[accessor["type"]]
        return numpy.frombuffer(body, kind, accessor["count"] * width, view["byteOffset"]).reshape(-1, width)
    return j, array


def check_glb(file, W, names, bones):
    j, array = read_glb(file("skin.glb"))
    primitive = j["meshes"][0]["primitives"][0]
    attributes = primitive["attributes"]
    p = array(attributes["POSITION"])
    shares = numpy.zeros((len(p), len(names)))
    for n in range(2):
        if f"JOINTS_{n}" not in attributes:
            continue
        joints, weights = array(attributes[f"JOINTS_{n}"]), array(attributes[f"WEIGHTS_{n}"])
        for k in range(4):
            numpy.add.at(shares, (numpy.arange(len(p)), joints[:, k]), weights[:, k])
    assert abs(shares.sum(axis=1) - 1).max() < 1e-6
    # The surface's vertices come first in the mesh.
    assert abs(shares - W[:len(p)]).max() < 2e-4, abs(shares - W[:len(p)]).max()
    joints = j["skins"][0]["joints"]
    assert [j["nodes"][n]["name"] for n in joints] == names
    inverse = array(j["skins"][0]["inverseBindMatrices"]).reshape(-1, 4, 4)  # by columns
    places = {}

    def place(node, from_):
        here = from_ + numpy.array(j["nodes"][node].get("translation", [0, 0, 0]))
        places[node] = here
        for child in j["nodes"][node].get("children", []):
            place(child, here)
    for root in j["scenes"][0]["nodes"]:
        place(root, numpy.zeros(3))
    for node, matrix, bone in zip(joints, inverse, bones):
        assert abs(places[node] - bone["head"]).max() < 1e-6
        assert abs(matrix[3, :3] + places[node]).max() < 1e-6
    # As a surface, it can be read again.
    assert f"{len(p)} vertices" in run("inspect", file("skin.glb"))


def main():
    with tempfile.TemporaryDirectory() as folder:
        def file(name):
            return os.path.join(folder, name)
        subprocess.run([sys.executable, "-B", os.path.join(SOURCE, "scripts", "make_sample"), file("worm.off"), "390", "16"],
                       check=True, stdout=subprocess.DEVNULL)
        run("mesh", file("worm.off"), "-o", file("worm.vtu"))
        # Bones through the whole worm; its ends overlap.
        bones = chain(5, 385, 19, 20)
        write(file("h.json"), {"handles": bones})
        names = [b["name"] for b in bones]
        mesh = [file("worm.vtu"), "--handles", file("h.json")]
        figures = json.loads(run("solve", "weights", *mesh, "-o", file("w.vtu"), "--json"))
        assert all(h["end"] != "stalled" and h["cut_at"] == 1 for h in figures["handles"]), figures
        p, T, data = read(file("w.vtu"))
        W = numpy.column_stack([data[n] for n in names])
        assert W.min() >= 0 and W.max() <= 1 and abs(W.sum(axis=1) - 1).max() < 1e-12
        # A place in both layers, half-way between the axis at 10 degrees and a turn later.
        place = (numpy.array(axis(10)) + axis(370)) / 2
        hit = []
        for t, corners in enumerate(p[T]):
            b = numpy.linalg.solve((corners[1:] - corners[0]).T, place - corners[0])
            if b.min() >= 0 and b.sum() <= 1:
                hit.append((t, numpy.array([1 - b.sum(), *b])))
        assert len(hit) == 2, hit
        ends = sorted([float(b @ W[T[t]][:, :5].sum(axis=1)), float(b @ W[T[t]][:, -5:].sum(axis=1))] for t, b in hit)
        assert ends[0][0] < 1e-3 and ends[0][1] > 0.99 and ends[1][0] > 0.99 and ends[1][1] < 1e-3, ends
        # The other formats say the same.
        run("solve", "weights", *mesh, "-o", file("w.csv"))
        with open(file("w.csv"), encoding="ascii") as lines:
            assert lines.readline().rstrip().split(",") == ["vertex", *names]
        csv = numpy.loadtxt(file("w.csv"), delimiter=",", skiprows=1)
        assert (csv[:, 1:] == W).all() and (csv[:, 0] == numpy.arange(len(p))).all()
        said = run("solve", "weights", *mesh, "-o", file("skin.glb"))
        assert "handles a vertex" in said, said
        check_glb(file, W, names, bones)
        # TGF, as libigl's examples have it.
        tgf = "".join(f"{k + 1} {' '.join(map(repr, axis(5 + 20 * k)))}\n" for k in range(20))
        write(file("h.tgf"), tgf + "#\n" + "".join(f"{k + 1} {k + 2} 1 0 0\n" for k in range(19)))
        run("solve", "weights", file("worm.vtu"), "--handles", file("h.tgf"), "-o", file("t.csv"))
        assert (numpy.loadtxt(file("t.csv"), delimiter=",", skiprows=1)[:, 1:] == W).all()
        # Poses: nothing moves, all moves, one end moves and the other, in the same place, does not.
        skin = ["solve", "skin", *mesh, "--pose", file("pose.json"), "-o", file("s.vtu")]
        write(file("pose.json"), {})
        for weights in ("w.vtu", "w.csv"):
            said = run(*skin, "--weights", file(weights))
            assert "all tets positive" in said and (read(file("s.vtu"))[0] == p).all(), said
        write(file("pose.json"), {names[0]: {"axis": [0, 0, 1], "degrees": 90}})
        run(*skin, "--weights", file("w.csv"))
        q, head = read(file("s.vtu"))[0], numpy.array(bones[0]["head"])
        turned = head + (p - head) @ numpy.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]])
        assert abs(q - turned).max() < 1e-13
        half = math.sqrt(0.5)
        write(file("pose.json"), {names[-4]: {"quaternion": [half, 0, 0, half], "translation": [0, 0, 0.5]}})
        run(*skin, "--weights", file("w.csv"))
        moved = numpy.linalg.norm(read(file("s.vtu"))[0] - p, axis=1)
        ends = sorted(float(b @ moved[T[t]]) for t, b in hit)
        assert ends[0] < 1e-2 and ends[1] > 0.3, ends
        write(file("pose.json"), {names[0]: {"matrix": [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]}})
        figures = json.loads(run(*skin, "--weights", file("w.csv"), "--json"))
        assert figures["flipped_tets"] == len(T) and figures["first_flipped_tet"] == 0
        # A position in two layers, and what is wrong in files.
        refused = ["solve", "weights", *mesh, "-o", file("q.vtu")]
        here = {"name": "here", "position": list(place)}
        other = {"name": "other", "vertex": 0}
        for handles, said, code in (
                ({"handles": [here, other]}, "is in 2 layers of the solid. Say which", 2),
                ({"handles": [dict(here, layer=5), other]}, "layer 5", 2),
                ({"handles": [dict(here, position=[9, 9, 9]), other]}, "outside the solid; the nearest vertex", 2),
                ({"handles": [{"name": "through", "head": axis(90), "tail": axis(220)}, other]}, "leaves the solid at", 2),
                ({"handles": [here, here]}, 'two handles are named "here"', 3),
                ({"handles": [dict(here, colour=1)]}, '"colour"', 3),
                ({"handles": [dict(here, vertex=1)]}, "either a", 3),
                ({"handles": [dict(here, position=[1, 2])]}, "three numbers", 3),
                ({"handles": [dict(here, parent="who")]}, 'the parent "who"', 3),
                ({"handles": [dict(other, vertex=10**6)]}, "no tet has", 2),
                ({"handles": []}, "no handles", 3),
                ("{", "no JSON", 3)):
            write(file("h.json"), handles)
            got = run(*refused, code=code)
            assert said in got and not os.path.exists(file("q.vtu")), (handles, got)
        write(file("h.json"), {"handles": [dict(here, layer=1), other]})
        run(*refused)
        # A bone that leaves the solid may be cut off.
        write(file("h.json"), {"handles": [{"name": "through", "head": axis(90), "tail": axis(220)}, other]})
        figures = json.loads(run(*refused, "--cut-bones", "--json"))
        assert 0 < figures["handles"][0]["cut_at"] < 0.9, figures
        write(file("bad.tgf"), "1 0 0\n#\n")
        assert "bad.tgf, line 1" in run("solve", "weights", file("worm.vtu"), "--handles", file("bad.tgf"), "-o", file("q.vtu"), code=3)
        write(file("h.json"), {"handles": bones})
        for pose, said in (({"nobody": {}}, '"nobody" is none of the handles'), ({names[0]: {"axis": [0, 0, 0], "degrees": 1}}, "axis"),
                           ({names[0]: {"matrix": [[1]]}}, "three rows"), ({names[0]: {"speed": 1}}, '"speed"')):
            write(file("pose.json"), pose)
            assert said in run(*skin, "--weights", file("w.csv"), code=3), pose
        for words, said in ((["weights", file("worm.vtu"), "-o", file("q.vtu")], "--handles FILE"),
                            (["weights", *mesh, "-o", file("q.mesh")], ".vtu, .vtk, .glb or .csv"),
                            (["weights", *mesh, "-o", file("q.vtu"), "--pose", "x"], "--pose is no option of weights"),
                            (["skin", *mesh, "-o", file("q.vtu"), "--pose", "x"], "--weights FILE"),
                            (["weights", *mesh, "-o", file("h.json")], "")):
            assert said in run("solve", *words, code=2), words


main()
