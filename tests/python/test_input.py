"""Arrays of all kinds: the same mesh from any memory order and type, and one sentence about what cannot be taken."""
import numpy as np
import overtet
import pytest
import surfaces

CUBE = surfaces.cube()


@pytest.fixture(scope="module")
def worm():
    return surfaces.worm()


@pytest.fixture(scope="module")
def hash_of_worm(worm):
    return overtet.tetrahedralize(*worm).hash


def test_memory_orders_and_types(worm, hash_of_worm):
    V, F = worm
    wide = np.zeros((len(V), 6))
    wide[:, ::2] = V
    unaligned = np.frombuffer(b"x" + V.tobytes(), np.uint8)[1:].view(np.float64).reshape(V.shape)
    readonly = V.copy()
    readonly.flags.writeable = False
    for other in (np.asfortranarray(V), wide[:, ::2], V[::-1].copy()[::-1], V.astype(">f8"), unaligned, readonly):
        assert overtet.tetrahedralize(other, F).hash == hash_of_worm
    for other in (F.astype(np.int64), F.astype(np.uint16), F.astype(np.uint32), F.astype(np.uint64), F.astype(">i4"),
                  np.asfortranarray(F), np.asfortranarray(F.astype(np.int64)), F.tolist()):
        assert overtet.tetrahedralize(V, other).hash == hash_of_worm
    rounded = V.astype(np.float32)
    exact = overtet.tetrahedralize(rounded, F)
    assert exact.V[:len(V)].tobytes() == rounded.astype(np.float64).tobytes()
    assert overtet.tetrahedralize(CUBE[0].astype(int).tolist(), CUBE[1].tolist()).status == "exact"


def test_input_is_left_alone_and_not_kept(worm):
    V, F = worm[0].copy(), worm[1].copy()
    before = V.tobytes(), F.tobytes()
    mesh = overtet.tetrahedralize(V, F)
    assert (V.tobytes(), F.tobytes()) == before
    assert not np.shares_memory(mesh.V, V) and not np.shares_memory(mesh.boundary, F)
    first = mesh.V[0, 0]
    V[:] = 0
    assert mesh.V[0, 0] == first and mesh.V.flags.writeable


@pytest.mark.parametrize("V, F, words", [
    (CUBE[0][:, :2], CUBE[1], "V has the shape"),
    (CUBE[0].ravel(), CUBE[1], "V has the shape"),
    (CUBE[0][None], CUBE[1], "V has the shape"),
    (CUBE[0], CUBE[1][:, :2], "F has the shape"),
    (CUBE[0], CUBE[1].astype(float), "F has the type float64"),
    (CUBE[0].astype(complex), CUBE[1], "V has the type complex128"),
    (CUBE[0].astype(np.longdouble), CUBE[1], "V has the type"),
    (CUBE[0] > 0, CUBE[1], "V has the type bool"),
    (CUBE[0].astype(object), CUBE[1], "V has the type object"),
    (CUBE[0], "faces", "F has the type"),
    ([[0, 0, 0], [1, 2]], CUBE[1], "V"),
    (CUBE[0], None, "F is missing"),
])
def test_wrong_arrays(V, F, words):
    for function in (overtet.tetrahedralize, overtet.inspect, overtet.clean_up, overtet.prepare, overtet.repair,
                     overtet.embed):
        with pytest.raises(overtet.UsageError, match=words):
            function(V, F)
        with pytest.raises(ValueError):
            function(V, F)


def test_wrong_surfaces():
    V, F = CUBE
    cases = {"nan": (np.where(np.arange(24).reshape(8, 3) == 7, np.nan, V), F),
             "infinite": (np.where(np.arange(24).reshape(8, 3) == 7, np.inf, V), F),
             "negative": (V, np.where(np.arange(36).reshape(12, 3) == 5, -1, F)),
             "beyond": (V, np.where(np.arange(36).reshape(12, 3) == 5, 8, F)),
             "far": (V, np.where(np.arange(36).reshape(12, 3) == 5, 2**40, F.astype(np.int64))),
             "least": (V, np.where(np.arange(36).reshape(12, 3) == 5, -2**63, F.astype(np.int64))),
             "open": (V, F[1:]), "no faces": (V, []), "nothing": ([], []), "no vertices": (np.empty((0, 3)), F),
             "not oriented": (V, np.vstack([F[:1, ::-1], F[1:]]))}
    for name, (v, f) in cases.items():
        with pytest.raises(overtet.BadInput) as caught:
            overtet.tetrahedralize(v, f)
        assert caught.value.code == 3 and str(caught.value).endswith("."), name
        for function in (overtet.repair, overtet.embed):
            with pytest.raises(overtet.BadInput):
                function(v, f)
        if name in ("far", "least"):
            assert caught.value.face == 1 and "Face 1" in str(caught.value)
        else:
            assert overtet.inspect(v, f).verdict == "bad-input", name
        mesh = overtet.Mesh(np.eye(4, 3), [[0, 1, 2, 3]])
        if name not in ("far", "least"):
            assert not overtet.verify(v, f, mesh), name


def test_wrong_arguments(tmp_path):
    V, F = CUBE
    mesh = overtet.tetrahedralize(V, F)
    wrong = [lambda: overtet.tetrahedralize(V, F, labels=[1, 2]), lambda: overtet.tetrahedralize(V, F, sizes=[1.0]),
             lambda: overtet.tetrahedralize(V, F, labels=np.ones(12)), lambda: overtet.tetrahedralize(V, F, improve=95),
             lambda: overtet.tetrahedralize(V, F, labels=np.full(12, 2**33)),
             lambda: overtet.tetrahedralize(V, F, sizes=np.full(8, -1.0)),
             lambda: overtet.tetrahedralize(V, F, sizes=np.full(8, np.nan)),
             lambda: overtet.tetrahedralize(V, F, on_infeasible="give up"),
             lambda: overtet.tetrahedralize(V, F, preset="fast"), lambda: overtet.tetrahedralize(V, F, max_move=2),
             lambda: overtet.tetrahedralize(V, F, max_edge=-1), lambda: overtet.tetrahedralize(V, F, max_volume=np.nan),
             lambda: overtet.tetrahedralize(V, F, threads=-1), lambda: overtet.tetrahedralize(V, F, time_limit=0),
             lambda: overtet.tetrahedralize(V, F, memory_limit=-3), lambda: overtet.tetrahedralize(V, F, progress=3),
             lambda: overtet.tetrahedralize(V, F, time_limit=np.nan), lambda: overtet.repair(V, F, max_move=-.1),
             lambda: overtet.verify(V, F, mesh.V), lambda: overtet.verify(V, F, mesh.V, mesh.T[:, :3]),
             lambda: overtet.verify(V, F, mesh, max_move=np.nan), lambda: overtet.prepare(V, F, fill_holes=2),
             lambda: overtet.prepare(V, F, tolerance=5), lambda: overtet.clean_up(V, F, places=0),
             lambda: overtet.write(tmp_path / "m.png", mesh), lambda: overtet.write(tmp_path / "m.mesh", V),
             lambda: overtet.write(tmp_path / "m.off", overtet.Surface(V, F), order=2),
             lambda: overtet.write(tmp_path / "m.mesh", mesh, order=3),
             lambda: overtet.write(tmp_path / "m.mesh", mesh, format="png"),
             lambda: overtet.write(tmp_path / "m.mesh", overtet.Mesh(mesh.V, mesh.T, layers=[1])),
             lambda: overtet.write(tmp_path / "m.vtu", overtet.Mesh(mesh.V, mesh.T, vertex_data={"x": [1.0]}))]
    for i, f in enumerate(wrong):
        with pytest.raises(overtet.UsageError) as caught:
            f()
        assert str(caught.value).endswith("."), i
    for T in ([[0, 1, 2, 99]], [[0, 1, 2, -1]]):
        with pytest.raises(overtet.BadInput):
            overtet.write(tmp_path / "m.mesh", overtet.Mesh(mesh.V, T))
    with pytest.raises(overtet.BadInput):
        overtet.write(tmp_path / "m.off", overtet.Surface(V, F + 1))
    assert list(tmp_path.iterdir()) == []


def test_rounding_of_others_does_not_matter(worm, hash_of_worm):
    """Modules built with -ffast-math, or by hand, change the floating-point environment of the thread."""
    import ctypes
    libm = ctypes.CDLL("libm.so.6")
    upward = 0x800 if libm.fegetround() == 0 else None
    if upward is None or libm.fesetround(upward) != 0:
        pytest.skip("no x86")
    try:
        again = overtet.tetrahedralize(*worm).hash
    finally:
        libm.fesetround(0)
    assert again == hash_of_worm


def test_attributes_go_along(tmp_path):
    V, F = CUBE
    surface = overtet.Surface(V, F, labels=np.arange(12), label_names={3: "lid"},
                              vertex_data={"heat": np.linspace(0, 1, 8, dtype=np.float32), "uv": V[:, :2]},
                              face_data={"kind": np.arange(12, dtype=np.uint8)})
    mesh = overtet.tetrahedralize(surface)
    assert mesh.label_names == {3: "lid"} and mesh.labels.tolist() == list(range(12))
    assert mesh.vertex_data["heat"].dtype == np.float32 and mesh.vertex_data["uv"].shape == (len(mesh.V), 2)
    assert np.array_equal(mesh.vertex_data["uv"][:8], V[:, :2])
    assert mesh.triangle_data["kind"].dtype == np.uint8
    overtet.write(tmp_path / "m.vtu", mesh)
    back = overtet.read_mesh(tmp_path / "m.vtu")
    assert np.array_equal(back.vertex_data["heat"][:8], surface.vertex_data["heat"])
    with pytest.raises(overtet.UsageError):
        overtet.tetrahedralize(overtet.Surface(V, F, vertex_data={"heat": [1.0]}))
