"""Meshes are those of the program, to the byte, and what the contract says of them holds."""
import copy
import filecmp
import json
import os
import pickle
import subprocess

import numpy as np
import overtet
import pytest
import surfaces

PROGRAM = os.environ["OVERTET_PROGRAM"]


def run_program(*arguments):
    done = subprocess.run([PROGRAM, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 0, done.stdout


@pytest.fixture(scope="module")
def worm():
    return surfaces.worm()


@pytest.fixture(scope="module")
def mesh(worm):
    return overtet.tetrahedralize(*worm)


@pytest.fixture(scope="module")
def grouped(tmp_path_factory):
    """A file with groups, and its surface."""
    path = tmp_path_factory.mktemp("grouped") / "worm.obj"
    V, F = surfaces.worm()
    groups = surfaces.worm_groups()
    with open(path, "w", encoding="ascii") as file:
        file.writelines("v %r %r %r\n" % tuple(p) for p in V.tolist())
        for number, name in enumerate(("belly", "back", "tail")):
            file.write(f"g {name}\n")
            file.writelines("f %d %d %d\n" % tuple(f) for f in (F[groups == number] + 1).tolist())
    return path


def test_what_comes_out(worm, mesh):
    V, F = worm
    assert mesh.V.dtype == np.float64 and mesh.V.shape[1] == 3 and mesh.V.flags.c_contiguous
    assert mesh.T.dtype == np.int32 and mesh.T.shape[1] == 4
    assert mesh.V[:len(V)].tobytes() == V.tobytes()
    assert np.array_equal(mesh.boundary, F) and mesh.boundary_face.tolist() == list(range(len(F)))
    assert mesh.status == "exact" and mesh.surface_vertices == len(V) and len(mesh.moved) == 0
    assert len(mesh.layers) == len(mesh.regions) == len(mesh.T) and mesh.layers.max() == 2
    assert mesh.input_vertex[:len(V)].tolist() == list(range(len(V))) and (mesh.input_vertex[len(V):] == -1).all()
    assert set(mesh.labels) == {1}
    assert mesh.quality.tets == len(mesh.T) == mesh.report["quality"]["tets"]
    assert mesh.report["result_hash"] == mesh.hash and mesh.report["status"] == "exact"
    corners = mesh.V[mesh.T]
    assert (np.linalg.det(corners[:, 1:] - corners[:, :1]) > 0).all()
    assert "tets, exact" in repr(mesh)


def test_report_fits_the_schema(mesh):
    jsonschema = pytest.importorskip("jsonschema")
    path = os.path.join(os.path.dirname(__file__), "..", "..", "docs", "report.schema.json")
    with open(path, encoding="utf-8") as file:
        jsonschema.validate(mesh.report, json.load(file))


@pytest.mark.parametrize("name", ["m.mesh", "m.msh", "m.vtu", "m.node", "m.inp", "m.vtk", "m.mesh.gz"])
@pytest.mark.parametrize("order", [1, 2])
def test_files_are_the_programs(grouped, tmp_path, name, order):
    ours, theirs = tmp_path / "ours", tmp_path / "theirs"
    ours.mkdir(), theirs.mkdir()
    surface = overtet.clean_up(overtet.read(grouped))
    assert sorted(surface.surface.label_names.values()) == ["back", "belly", "tail"]
    made = overtet.tetrahedralize(surface, threads=1)
    overtet.write(ours / name, made, order=order)
    run_program("mesh", grouped, "-o", theirs / name, "--order", order)
    names = sorted(os.listdir(theirs))
    assert sorted(os.listdir(ours)) == names
    assert filecmp.cmpfiles(ours, theirs, names, shallow=False) == (names, [], [])


def test_options_are_the_programs(worm, tmp_path):
    V, F = worm
    overtet.write(tmp_path / "in.off", overtet.Surface(V, F))
    for ours, theirs in (({"max_edge": .2}, ["--max-edge", ".2"]), ({"coarse": True, "improve": 10},
                                                                    ["--coarse", "--improve", "10"])):
        overtet.write(tmp_path / "ours.mesh", overtet.tetrahedralize(V, F, **ours))
        run_program("mesh", tmp_path / "in.off", "-o", tmp_path / "theirs.mesh", *theirs)
        assert filecmp.cmp(tmp_path / "ours.mesh", tmp_path / "theirs.mesh", shallow=False), ours


def test_repaired_as_by_the_program(tmp_path):
    V, F = surfaces.dented_ball()
    overtet.write(tmp_path / "in.off", overtet.Surface(V, F))
    made = overtet.tetrahedralize(V, F, on_infeasible="repair")
    assert made.status == "repaired" and len(made.moved) > 0
    still = np.setdiff1d(np.arange(len(V)), made.moved)
    assert made.V[still].tobytes() == V[still].tobytes()
    assert overtet.verify(made.surface, made) and not overtet.verify(V, F, made)
    assert overtet.verify(V, F, made, max_move=.06)
    overtet.write(tmp_path / "ours.vtu", made)
    run_program("mesh", tmp_path / "in.off", "-o", tmp_path / "theirs.vtu", "--on-infeasible", "repair")
    assert filecmp.cmp(tmp_path / "ours.vtu", tmp_path / "theirs.vtu", shallow=False)
    alone = overtet.repair(V, F)
    assert alone.V.tobytes() == made.V[:len(V)].tobytes() and alone.moved.tolist() == made.moved.tolist()
    assert alone.max_relative_move == made.max_relative_move <= .06


def test_embedded_as_by_the_program(worm, tmp_path):
    V, F = worm
    made = overtet.embed(V, F, threads=2)
    overtet.write(tmp_path / "in.off", overtet.Surface(V, F))
    run_program("embed", tmp_path / "in.off", "-o", tmp_path / "theirs.off")
    theirs = overtet.read(tmp_path / "theirs.off")
    assert theirs.V.tobytes() == made.V.tobytes() and theirs.F.tolist() == made.F.tolist() == F.tolist()
    assert overtet.inspect(made.V, made.F).verdict == "embedded"
    still = np.setdiff1d(np.arange(len(V)), made.moved)
    assert len(made.moved) > 0 and made.V[still].tobytes() == V[still].tobytes()
    assert .3 < made.area["p01"] <= 1 and not made.collapsed and len(made.laid_aside) == 0
    assert made.report["status"] == "embedded" and made.report["embedding"]["area"] == made.area
    assert "moved" in repr(made)


def test_sizes_and_labels(worm):
    V, F = worm
    labels = np.arange(len(F))[::-1] % 7 - 3
    fine = overtet.tetrahedralize(V, F, labels=labels, sizes=np.full(len(V), .15))
    assert fine.labels.tolist() == labels.tolist()
    assert len(fine.T) > len(overtet.tetrahedralize(V, F, sizes=np.zeros(len(V))).T)
    assert overtet.tetrahedralize(V, F, layers=False).layers is None


def test_inspect_and_verify(worm, mesh):
    V, F = worm
    found = overtet.inspect(V, F)
    assert found and found.verdict == "feasible" and found.certificate is None
    assert found.pairs.shape[1] == 2 and len(found.pairs) > 0 and (found.winding_min, found.winding_max) == (0, 2)
    assert len(found.curves) >= 1 and found.curves[0]["points"].shape[1] == 3
    assert overtet.verify(V, F, mesh.V, mesh.T) and overtet.verify(V, F, mesh)
    assert overtet.verify(overtet.Surface(V, F), mesh).quality.tets == len(mesh.T)
    turned = mesh.T.copy()
    turned[3, :2] = turned[3, 1::-1]
    wrong = overtet.verify(V, F, mesh.V, turned)
    assert not wrong and "R4" in [f["rule"] for f in wrong.failures] and "3" in repr(wrong)
    relabelled = copy.copy(mesh)
    relabelled.labels = mesh.labels + 1
    assert [f["rule"] for f in overtet.verify(overtet.Surface(V, F), relabelled).failures] == ["R7"]
    beyond = mesh.T.copy()
    beyond[0, 0] = -5
    assert [f["rule"] for f in overtet.verify(V, F, mesh.V, beyond).failures][0] == "R1"
    bad = overtet.inspect(V, F[:-1])
    assert not bad and bad.verdict == "bad-input" and not bad.closed


def test_clean_up_and_prepare():
    V, F = surfaces.cube()
    corners = overtet.Surface(V[F.ravel()], np.arange(3 * len(F)).reshape(-1, 3), labels=np.arange(len(F)))
    clean = overtet.clean_up(corners)
    assert clean.changed and "merged" in clean.summary and clean.V.shape == (8, 3)
    assert np.array_equal(corners.V[clean.vertex_of], clean.V)
    assert clean.surface.labels.tolist() == list(range(len(F)))
    assert [d["kind"] for d in clean.defects] == ["unmerged-vertex"]
    with pytest.raises(overtet.BadInput):
        overtet.clean_up(corners, strict=True)
    same = overtet.clean_up(V, F)
    assert not same.changed and same.vertex_of.tolist() == list(range(8)) and same.V.tobytes() == V.tobytes()
    with pytest.raises(overtet.BadInput):
        overtet.clean_up(V, F[1:])
    filled = overtet.prepare(overtet.Surface(V, F[1:], labels=np.full(11, 5)), fill_holes=10)
    assert not filled.remaining and (filled.face_of == -1).sum() == 1
    assert filled.surface.labels.tolist() == [0 if f < 0 else 5 for f in filled.face_of]
    assert overtet.tetrahedralize(filled).status == "exact"
    assert [s["step"] for s in filled.steps] == ["fill-holes"]


def test_files_come_back(mesh, tmp_path):
    for name in ("m.mesh", "m.vtu", "m.msh"):
        overtet.write(tmp_path / name, mesh)
        back = overtet.read_mesh(tmp_path / name)
        assert back.V.tobytes() == mesh.V.tobytes() and back.T.tobytes() == mesh.T.tobytes(), name
        assert np.array_equal(back.boundary, mesh.boundary) and np.array_equal(back.labels, mesh.labels), name
    overtet.write(tmp_path / "s.ply", overtet.Surface(mesh.V[:mesh.surface_vertices], mesh.boundary, labels=mesh.labels))
    surface = overtet.read(os.fsencode(tmp_path / "s.ply"))
    assert surface.format.startswith("PLY") and surface.labels.tolist() == mesh.labels.tolist()
    overtet.write(tmp_path / "bare.mesh", overtet.Mesh(mesh.V, mesh.T))  # made by hand
    assert len(overtet.read_mesh(tmp_path / "bare.mesh").T) == len(mesh.T)


def test_names_that_are_no_utf8(tmp_path):
    V, F = surfaces.cube()
    path = os.path.join(os.fsencode(tmp_path), b"caf\xe9.obj")
    with open(path, "wb") as file:
        file.write(b"".join(b"v %r %r %r\n" % tuple(p) for p in V.tolist()) + b"g \xe9t\xe9\n" +
                   b"".join(b"f %d %d %d\n" % tuple(f) for f in (F + 1).tolist()))
    surface = overtet.read(path)
    assert list(surface.label_names.values()) == ["\udce9t\udce9"]
    overtet.write(tmp_path / "out.msh", overtet.tetrahedralize(surface))
    assert b'"\xe9t\xe9"' in (tmp_path / "out.msh").read_bytes()
    with pytest.raises(overtet.FileError, match="nothing"):
        overtet.read(os.path.join(path, b"nothing"))


def test_pickle_and_copy(worm, mesh):
    again = pickle.loads(pickle.dumps(mesh))
    assert again.V.tobytes() == mesh.V.tobytes() and again.report == mesh.report and again.hash == mesh.hash
    assert again.quality.volume == mesh.quality.volume and again.label_names == mesh.label_names
    assert copy.deepcopy(mesh).T.tobytes() == mesh.T.tobytes()
    assert pickle.loads(pickle.dumps(overtet.inspect(*worm))).verdict == "feasible"


def test_meshio_and_vtk(mesh):
    meshio = pytest.importorskip("meshio")
    made = mesh.to_meshio()
    assert isinstance(made, meshio.Mesh)
    assert np.array_equal(made.points, mesh.V) and np.array_equal(made.cells_dict["tetra"], mesh.T)
    assert np.array_equal(made.cells_dict["triangle"], mesh.boundary)
    assert np.array_equal(made.cell_data_dict["label"]["triangle"], mesh.labels)
    assert np.array_equal(made.cell_data_dict["layers"]["tetra"], mesh.layers)
    pytest.importorskip("vtkmodules")
    grid = mesh.to_vtk()
    assert grid.GetNumberOfCells() == len(mesh.T) and grid.GetNumberOfPoints() == len(mesh.V)
    assert [grid.GetCell(7).GetPointId(k) for k in range(4)] == mesh.T[7].tolist()
    assert grid.GetCellData().GetArray("layers").GetValue(7) == mesh.layers[7]


def test_silent(worm, tmp_path, capfd):
    overtet.tetrahedralize(*worm)
    overtet.inspect(*surfaces.dented_ball())
    assert capfd.readouterr() == ("", "")
