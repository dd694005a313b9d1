"""Runs: errors, limits, Ctrl-C, callbacks, threads, processes, memory."""
import concurrent.futures
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import textwrap
import threading
import tracemalloc

import numpy as np
import overtet
import pytest
import surfaces


def python(code, *arguments, **more):
    """Starts code in a process of its own."""
    return subprocess.Popen([sys.executable, "-B", "-u", "-c", textwrap.dedent(code), *map(str, arguments)],
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **more)


def output_of(code, *arguments):
    process = python(code, *arguments)
    out = process.communicate(timeout=240)[0]
    assert process.returncode == 0, out
    return out


def test_infeasible():
    V, F = surfaces.dented_ball()
    with pytest.raises(overtet.Infeasible) as caught:
        overtet.tetrahedralize(V, F)
    error = caught.value
    assert error.code == 5 and error.certificate["rule"] and error.explanation.endswith(".")
    assert error.report["status"] == "infeasible" and error.report["witness"] == error.certificate
    assert isinstance(error, overtet.Error) and str(error) == error.message
    found = overtet.inspect(V, F)
    assert not found and found.certificate == error.certificate and found.explanation == error.explanation
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is overtet.Infeasible and again.certificate == error.certificate and str(again) == str(error)
    with pytest.raises(overtet.Infeasible):
        overtet.repair(*surfaces.dented_ball(-3), max_move=1e-6)


def test_files(tmp_path):
    V, F = surfaces.cube()
    for action in (lambda: overtet.read(tmp_path / "none.off"), lambda: overtet.read_mesh(tmp_path / "none.mesh"),
                   lambda: overtet.write(tmp_path / "no folder" / "x.off", overtet.Surface(V, F))):
        with pytest.raises(overtet.FileError) as caught:
            action()
        assert isinstance(caught.value, OSError) and caught.value.code == 7 and str(tmp_path) in str(caught.value)
        assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)
    (tmp_path / "bad.off").write_text("OFF\n3 1 0\n0 0 0\n1 x 0\n0 1 0\n3 0 1 2\n")
    with pytest.raises(overtet.BadInput, match="line 4"):
        overtet.read(tmp_path / "bad.off")


def test_limits():
    V, F = surfaces.worm(around=40)
    with pytest.raises(overtet.Limit) as caught:
        overtet.tetrahedralize(V, F, time_limit=1e-3)
    assert caught.value.reason == "time_limit" and not isinstance(caught.value, MemoryError)
    with pytest.raises(MemoryError) as caught:
        overtet.tetrahedralize(V, F, memory_limit=1)
    assert isinstance(caught.value, overtet.Limit) and caught.value.reason == "memory_limit"
    assert overtet.tetrahedralize(*surfaces.cube(), time_limit=1e300, memory_limit=float("inf")).status == "exact"


def test_no_memory():
    """With less address space than the arrays take: MemoryError, and the process goes on."""
    out = output_of("""
        import numpy as np, overtet, resource, surfaces
        V, F = surfaces.cube()
        overtet.tetrahedralize(V, F)
        big = np.zeros((6_000_000, 3))
        used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + 64 * 2**20,) * 2)
        try:
            overtet.inspect(big, F)
        except MemoryError as error:
            print(type(error).__name__)
        print(overtet.tetrahedralize(V, F).status)
        """)
    assert out.split()[-1] == "exact" and "Memory" in out.split()[0], out


def test_progress_and_log():
    V, F = surfaces.worm()
    here, stages, lines = threading.get_ident(), [], []

    def progress(stage, fraction):
        assert threading.get_ident() == here and 0 <= fraction <= 1
        stages.append(stage)
    plain = overtet.tetrahedralize(V, F)
    told = overtet.tetrahedralize(V, F, progress=progress, log=lambda level, text: lines.append((level, text)))
    assert told.hash == plain.hash
    assert "improve" in stages and "label" in stages
    assert lines and all(level in ("error", "warning", "info", "debug") and text for level, text in lines)


@pytest.mark.parametrize("which", ["progress", "log"])
def test_exceptions_of_callbacks_come_out(which):
    V, F = surfaces.worm(around=30)

    class Enough(Exception):
        pass

    def stop(*_):
        raise Enough("that will do")
    with pytest.raises(Enough, match="that will do"):
        overtet.tetrahedralize(V, F, **{which: stop})
    with pytest.raises(TypeError):
        overtet.tetrahedralize(V, F, **{which: lambda: None})


LONG_RUN = """
    import overtet, sys, surfaces
    V, F = surfaces.worm(around=int(sys.argv[1]))
    try:
        print("begins")
        overtet.tetrahedralize(V, F, progress=lambda stage, fraction: print(stage))
    except KeyboardInterrupt as interrupt:
        children = open(f"/proc/self/task/{__import__('os').getpid()}/children").read().split()
        print("interrupted", len(children), __import__("threading").active_count())
        mesh = overtet.tetrahedralize(*surfaces.cube())  # goes on
        print(mesh.status)
    """


@pytest.mark.parametrize("stage", ["begins", "immersion", "improve"])
def test_ctrl_c(stage):
    process = python(LONG_RUN, 120)
    for line in process.stdout:
        if line.split() == [stage]:
            break
        if line.split() == ["label"]:
            break
    process.send_signal(signal.SIGINT)
    out = process.communicate(timeout=120)[0]
    assert out.splitlines()[-2:] == ["interrupted 0 1", "exact"], out
    assert process.returncode == 0


def test_python_handlers_of_signals_run():
    out = output_of("""
        import overtet, os, signal, surfaces, threading
        seen = []
        signal.signal(signal.SIGUSR1, lambda *_: seen.append(1))
        threading.Timer(.3, lambda: os.kill(os.getpid(), signal.SIGUSR1)).start()
        overtet.tetrahedralize(*surfaces.worm(around=60))
        while not seen:
            signal.pause()
        print(len(seen))
        """)
    assert out == "1\n"


def test_several_threads_at_once():
    models = [surfaces.worm(degrees, around) for degrees in (300, 420) for around in (8, 10, 12)]
    alone = [overtet.tetrahedralize(V, F).hash for V, F in models]
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda m: overtet.tetrahedralize(*m, threads=1).hash, models))
        broken = [pool.submit(overtet.tetrahedralize, *surfaces.dented_ball()) for _ in range(4)]
    assert together == alone
    assert all(isinstance(b.exception(), overtet.Infeasible) for b in broken)


def test_others_run_meanwhile():
    """The GIL is free: another thread counts while a run lasts."""
    V, F = surfaces.worm(around=60)
    counted, done = [0], threading.Event()

    def count():
        while not done.is_set():
            counted[0] += 1
    before = []
    other = threading.Thread(target=count)
    other.start()
    overtet.tetrahedralize(V, F, progress=lambda *_: before.append(counted[0]))
    done.set()
    other.join()
    assert before[-1] > before[0]


def test_threads_change_nothing():
    V, F = surfaces.worm(around=14)
    assert len({overtet.tetrahedralize(V, F, threads=n).hash for n in (1, 2, 3)}) == 1


def hash_of(model):
    return overtet.tetrahedralize(*model, threads=1).hash


def test_processes():
    models = [surfaces.worm(300, around) for around in (8, 10)]
    expected = [hash_of(m) for m in models]
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        assert pool.map(hash_of, models) == expected


def test_fork_before_the_first_call():
    out = output_of("""
        import multiprocessing, overtet, surfaces
        def hash_of(model):
            return overtet.tetrahedralize(*model).hash
        if __name__ == "__main__":
            models = [surfaces.worm(300, around) for around in (8, 10)]
            with multiprocessing.get_context("fork").Pool(2) as pool:
                forked = pool.map(hash_of, models)
            print(forked == [hash_of(m) for m in models])
        """)
    assert out == "True\n"


def test_fork_after_a_call():
    """Not promised by TBB (docs/python.md), but what multiprocessing does by itself in this version of Python."""
    out = output_of("""
        import multiprocessing, overtet, surfaces
        def hash_of(model):
            return overtet.tetrahedralize(*model).hash
        if __name__ == "__main__":
            models = [surfaces.worm(300, around) for around in (8, 10)]
            expected = [hash_of(m) for m in models]
            with multiprocessing.get_context("fork").Pool(2) as pool:
                print(pool.map(hash_of, models) == expected)
        """)
    assert out == "True\n"


def test_no_copies_by_numpy():
    V, F = surfaces.worm(around=60)
    F64 = F.astype(np.int64)
    overtet.tetrahedralize(*surfaces.cube())  # imports what is imported late
    for v, f in ((V, F), (np.asfortranarray(V), F64)):
        tracemalloc.start()
        mesh = overtet.tetrahedralize(v, f)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        # Reports and small objects; numpy tells tracemalloc of every array that it allocates.
        assert peak < .25 * (V.nbytes + F.nbytes), (peak, V.nbytes + F.nbytes)
        for array in (mesh.V, mesh.T, mesh.boundary, mesh.labels, mesh.layers, mesh.regions, mesh.input_vertex):
            assert not array.flags.owndata and type(array.base).__name__ == "PyCapsule"


def test_memory_is_given_back():
    out = output_of("""
        import gc, overtet, resource, surfaces
        def resident():
            return int(open("/proc/self/statm").read().split()[1]) * resource.getpagesize()
        V, F = surfaces.worm(around=40)
        bad = surfaces.dented_ball()
        def work():
            mesh = overtet.tetrahedralize(V, F)
            overtet.inspect(V, F)
            try:
                overtet.tetrahedralize(*bad)
            except overtet.Infeasible:
                pass
            return sum(a.nbytes for a in (mesh.V, mesh.T, mesh.boundary))
        for _ in range(3):
            size = work()
        used = []
        for _ in range(24):
            work()
            gc.collect()
            used.append(resident())
        # What the heap's holes take goes up and down by a dozen meshes, with what threads happen to do.
        print(min(used[-6:]) - max(used[:6]), size)
        """)
    grown, size = map(int, out.split())
    assert grown < 3 * size, f"{grown} bytes more after 12 to 24 meshes of {size} bytes"


def test_one_copy_on_the_way_in():
    """The peak while an array is looked at: itself, and once more in the library."""
    out = output_of("""
        import numpy as np, overtet, resource, surfaces
        def peak():
            return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
        V, F = surfaces.cube()
        overtet.tetrahedralize(V, F)
        mesh = overtet.Mesh(np.eye(4, 3), [[0, 1, 2, 3]])
        big = np.ones((4_000_000, 3))
        big[:, 0] = np.arange(len(big))
        before = peak()
        far = big * 1.0
        copied = peak() - before
        del far
        before = peak()
        overtet.verify(big, np.zeros((0, 3), int), mesh)
        print((peak() - before) / big.nbytes, copied / big.nbytes)
        """)
    more, one = map(float, out.split())
    assert more < 1.5, f"{more} times the array were taken (a plain copy: {one})"
