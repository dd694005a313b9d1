"""Fields and distances on meshes, and the fused mesh: as the program computes them, and as the contract says."""
import json
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


@pytest.mark.parametrize("order", [1, 2])
def test_linear_fields_are_exact(mesh, order):
    field = overtet.solve(mesh, values=[("all", lambda x, y, z: 1 + x - 2 * y + z / 4)], order=order)
    x, y, z = field.nodes.T
    assert abs(field.values - (1 + x - 2 * y + z / 4)).max() < 1e-12
    assert len(field.values) == len(field.nodes) and (len(field.nodes) > len(mesh.V)) == (order == 2)


def test_the_same_as_the_program(mesh, tmp_path):
    overtet.write(tmp_path / "worm.vtu", mesh)
    done = subprocess.run([PROGRAM, "solve", "poisson", tmp_path / "worm.vtu", "-o", tmp_path / "u.vtu", "--value", "all=x*y",
                           "--source", "1", "--json"], stdout=subprocess.PIPE, text=True, check=True)
    figures = json.loads(done.stdout)
    field = overtet.solve(mesh, "poisson", values=[("all", lambda x, y, z: x * y)], source=1)
    assert field.energy == figures["energy"] and field.values.max() == figures["most"]
    assert np.array_equal(overtet.read_mesh(tmp_path / "u.vtu").vertex_data["u"].ravel(), field.values)


def test_distances(mesh):
    distances = overtet.Distances(mesh)
    from_one = distances.distances_from([0])
    assert from_one[0] == 0 and np.isfinite(from_one).all() and (from_one[1:] > 0).all()
    assert np.array_equal(distances.distances_from(np.array([0])), from_one)
    label = int(mesh.labels[0])
    assert distances.distances_from(label)[mesh.boundary].max() >= 0
    assert distances.distances_from("all").max() < from_one.max()


def test_the_overlap_is_no_shortcut_but_in_the_fused_mesh(mesh):
    fused = overtet.fused(*surfaces.worm())
    assert fused.components == 1 and fused.cut_faces > 0 and fused.volume < .99 * fused.solid_volume
    assert overtet.Distances(mesh).distances_from([0]).max() > 1.3 * overtet.Distances(fused.mesh).distances_from([0]).max()


def test_what_is_wrong_is_said(mesh):
    for wrong, said in (({"values": [("nowhere", 1)]}, "no label named 'nowhere'"), ({"values": [(1.5, 1)]}, "is no place"),
                        ({"values": [7]}, "pairs"), ({"values": [("all", "x")]}, "functions of x, y and z"),
                        ({"values": []}, "No value is given"), ({"values": [(99, 1)]}, "label 99"),
                        ({"values": [("all", 1)], "order": 3}, "order is 3"),
                        ({"values": [("all", 1)], "equation": "heat"}, "equation is 'heat'")):
        with pytest.raises(overtet.UsageError, match=said):
            overtet.solve(mesh, **wrong)
    with pytest.raises(overtet.BadInput, match="not finite"):
        overtet.solve(mesh, values=[("all", float("nan"))])
    with pytest.raises(overtet.UsageError):
        overtet.Distances(mesh).distances_from([len(mesh.V)])

    def fails(x, y, z):
        raise LookupError("no value here")
    with pytest.raises(LookupError, match="no value here"):
        overtet.solve(mesh, values=[("all", fails)])
