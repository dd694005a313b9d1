"""Skinning weights from Python: as the program computes them, and what is refused."""
import json
import math
import os
import subprocess

import numpy as np
import overtet
import pytest
import surfaces

PROGRAM = os.environ["OVERTET_PROGRAM"]


@pytest.fixture(scope="module")
def mesh():
    return overtet.tetrahedralize(*surfaces.worm())


@pytest.fixture(scope="module")
def handles(mesh):
    n = mesh.surface_vertices
    return {"handles": [{"name": "tail", "vertex": 0}, {"name": "middle", "vertex": n // 2}, {"name": "head", "vertex": n - 1}]}


@pytest.fixture(scope="module")
def weights(mesh, handles):
    return overtet.skinning_weights(mesh, handles)


def test_weights(mesh, weights):
    w = weights.weights
    assert weights.names == ["tail", "middle", "head"] and w.shape == (len(mesh.V), 3)
    assert w.min() >= 0 and w.max() <= 1 and abs(w.sum(axis=1) - 1).max() < 1e-12
    assert w[0].tolist() == [1, 0, 0] and "stalled" not in weights.end
    assert weights.held.tolist() == [1, 1, 1] and weights.cut_at.tolist() == [1, 1, 1] and weights.shared == 0


def test_the_same_as_the_program(mesh, handles, weights, tmp_path):
    overtet.write(tmp_path / "worm.vtu", mesh)
    (tmp_path / "h.json").write_text(json.dumps(handles))
    subprocess.run([PROGRAM, "solve", "weights", tmp_path / "worm.vtu", "--handles", tmp_path / "h.json", "-o", tmp_path / "w.csv"],
                   check=True)
    assert np.array_equal(np.loadtxt(tmp_path / "w.csv", delimiter=",", skiprows=1)[:, 1:], weights.weights)
    again = overtet.skinning_weights(mesh, tmp_path / "h.json")
    assert np.array_equal(again.weights, weights.weights)


def test_poses(mesh, weights):
    still = overtet.skinned(mesh, weights, {})
    assert np.array_equal(still.mesh.V, mesh.V) and (still.flipped, still.first_flipped) == (0, -1)
    motion = {"quaternion": np.array([0, 0, math.sqrt(.5), math.sqrt(.5)]), "translation": [1, 2, 3]}
    moved = overtet.skinned(mesh, weights, {"tail": motion})
    assert abs(moved.mesh.V[0] - mesh.V[0] - [1, 2, 3]).max() < 1e-14
    assert np.array_equal(moved.mesh.V[mesh.surface_vertices - 1], mesh.V[mesh.surface_vertices - 1])
    mirror = {name: {"matrix": [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]} for name in weights.names}
    assert overtet.skinned(mesh, weights, mirror).flipped == len(mesh.T)


def test_what_is_wrong_is_said(mesh, weights):
    for kind, wrong, said in ((overtet.BadInput, {"handles": [{"name": "a"}]}, "needs either"),
                              (overtet.BadInput, {"handles": []}, "no handles"),
                              (overtet.UsageError, {"handles": [{"name": "a", "vertex": 10**7}]}, "no tet has"),
                              (overtet.UsageError, {"handles": [{"name": "a", "position": [9, 9, 9]}]}, "outside the solid"),
                              (overtet.UsageError, {"handles": [object()]}, "numbers and arrays only"),
                              (overtet.FileError, "/nowhere/h.json", "nowhere")):
        with pytest.raises(kind, match=said):
            overtet.skinning_weights(mesh, wrong)
    with pytest.raises(overtet.BadInput, match="none of the handles"):
        overtet.skinned(mesh, weights, {"who": {}})
    with pytest.raises(overtet.UsageError, match="shape"):
        overtet.skinned(overtet.Mesh(V=mesh.V[:4], T=np.array([[0, 1, 2, 3]])), weights, {})
