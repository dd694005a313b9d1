"""Elastic bodies: as the program moves them, and frame by frame."""
import os
import pickle
import subprocess

import numpy as np
import overtet
import pytest
import surfaces

PROGRAM = os.environ["OVERTET_PROGRAM"]


@pytest.fixture(scope="module")
def mesh():
    V, F = surfaces.worm()
    return overtet.tetrahedralize(V, F, labels=(np.asarray(V)[F].mean(axis=1)[:, 0] > 0).astype(int) + 1)


def test_patch(mesh):
    A = np.array([[.1, .05, 0], [0, -.1, .02], [.03, 0, .05]])
    for material in ("neo-hookean", "corotated", "st-venant-kirchhoff"):
        found = overtet.elastic(mesh, material=material, tolerance=1e-13,
                                held=[("all", lambda x, y, z, t: A @ (x, y, z) + 1)])
        assert abs(found.V - (mesh.V + mesh.V @ A.T + 1)).max() < 1e-12 and found.converged
        assert np.ptp(found.von_mises) < 1e-11


def test_the_same_as_the_program(mesh, tmp_path):
    overtet.write(tmp_path / "worm.vtu", mesh)
    subprocess.run([PROGRAM, "solve", "elastic", tmp_path / "worm.vtu", "-o", tmp_path / "u.vtu", "--fix", "label:1", "--pull",
                    "vertices:0,1=0;0;0.01*t", "--gravity", "0,0,-0.02", "--dynamic", "--frames", "3", "--step", "0.5",
                    "--damping", "0.1,0.2"], stdout=subprocess.PIPE, text=True, check=True)
    seen = []
    found = overtet.elastic(mesh, held=[(1, None), ([0, 1], lambda x, y, z, t: (0, 0, .01 * t))], gravity=(0, 0, -.02), dynamic=True,
                            frames=3, step=.5, damping=(.1, .2), each_frame=lambda body, step: seen.append((body.time, step.time)))
    theirs = overtet.read_mesh(tmp_path / "u.vtu")
    assert np.array_equal(theirs.V, found.V) and seen == [(.5, .5), (1, 1), (1.5, 1.5)]
    assert np.array_equal(theirs.vertex_data["velocity"], found.velocities)
    assert pickle.loads(pickle.dumps(found)).steps[2].time == 1.5


def test_frame_by_frame(mesh):
    vertex = int(mesh.boundary[mesh.labels == 2][0, 0])
    body = overtet.Elastic(mesh, held=[(1, None), ([vertex], None)], dynamic=True, step=1, method="quasi-newton", tolerance=1e-3)
    place = mesh.V[vertex] + (0, 0, .02)
    body.move_held([vertex], [place])
    for _ in range(3):
        assert body.step().least_ratio > 0
    assert np.array_equal(body.places[vertex], place) and body.time == 3
    assert len(body.von_mises()) == len(mesh.T) and body.von_mises_at_vertices()[vertex] > 0
    with pytest.raises(overtet.UsageError, match="not held"):
        body.move_held([int(np.setdiff1d(mesh.boundary, mesh.boundary[mesh.labels == 1])[1])], [place])
    with pytest.raises(overtet.UsageError, match="a place for each"):
        body.move_held([vertex], [place, place])


def test_what_is_wrong_is_said(mesh):
    held = [(1, None)]
    for wrong, said in (({}, "can still move"), ({"held": [("nose", None)]}, "no label named 'nose'"), ({"held": [7]}, "pairs"),
                        ({"held": [(1, (1, 2))]}, "3 numbers"), ({"held": held, "gravity": 1}, "3 numbers"),
                        ({"held": held, "material": "rubber"}, "material is 'rubber'"), ({"held": held, "poisson": .5}, "Poisson"),
                        ({"held": held, "frames": 0}, "frames is 0"), ({"held": held, "forces": [(1, (0, 0, 1))]}, "at vertices"),
                        ({"held": held, "rest": mesh.V[:5]}, "rest shape")):
        with pytest.raises(overtet.UsageError, match=said):
            overtet.elastic(mesh, **wrong)
    with pytest.raises(overtet.BadInput, match="not finite"):
        overtet.elastic(mesh, held=[(1, (0, 0, float("nan")))])

    def fails(x, y, z, t):
        raise LookupError("no way here")
    with pytest.raises(LookupError, match="no way here"):
        overtet.elastic(mesh, held=[(1, fails)])
