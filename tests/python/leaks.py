"""What scripts/python_leaks runs under LeakSanitizer: every way in and out, a few times. `leaks.py lose` loses an
array on purpose, to see that it would be found."""
import ctypes
import gc
import os
import sys
import tempfile

os.environ.pop("LD_PRELOAD", None)  # not for the process that TetGen runs in
LSAN = ctypes.CDLL(None)
LSAN.__lsan_disable()  # what is made while modules are imported, and in the first round, may stay
import numpy as np  # noqa: E402
import overtet  # noqa: E402
import surfaces  # noqa: E402


def work(folder):
    V, F = surfaces.worm(around=8)
    mesh = overtet.tetrahedralize(V, F, progress=lambda *_: None, log=lambda *_: None)
    view = mesh.V[3:9]  # outlives the mesh
    assert overtet.verify(overtet.Surface(V, F), mesh)
    del mesh
    assert view.sum() == view.sum()
    overtet.inspect(V, F)
    for name in ("m.mesh", "m.vtu"):
        path = os.path.join(folder, name)
        overtet.write(path, overtet.tetrahedralize(*surfaces.cube()))
        overtet.read_mesh(path)

    def stop(*_):
        raise LookupError

    for action, expected in (
            (lambda: overtet.tetrahedralize(V, F, progress=stop), LookupError),
            (lambda: overtet.tetrahedralize(*surfaces.dented_ball()), overtet.Infeasible),
            (lambda: overtet.tetrahedralize(V, F[1:]), overtet.BadInput),
            (lambda: overtet.tetrahedralize(V, F.astype(np.int64) + 2**40), overtet.BadInput),
            (lambda: overtet.tetrahedralize(V, F, time_limit=1e-3), overtet.Limit),
            (lambda: overtet.read(os.path.join(folder, "none.off")), overtet.FileError),
            (lambda: overtet.tetrahedralize(V, F, improve=99), overtet.UsageError)):
        try:
            action()
        except expected:
            continue
        raise AssertionError(expected)
    overtet.clean_up(V[F.ravel()], np.arange(F.size).reshape(-1, 3))
    overtet.prepare(V, F[1:], fill_holes=9)


def main():
    with tempfile.TemporaryDirectory() as folder:
        work(folder)
        LSAN.__lsan_enable()
        for _ in range(3):
            work(folder)
    if sys.argv[1:] == ["lose"]:
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(overtet.tetrahedralize(*surfaces.cube()).V))
    gc.collect()
    # While the interpreter lives: what it keeps until it ends is no leak.
    lost = LSAN.__lsan_do_recoverable_leak_check()
    print("leaks found" if lost else "no leaks", flush=True)
    os._exit(1 if lost else 0)


if __name__ == "__main__":
    main()
