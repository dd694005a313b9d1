"""What others install, and what measures: pip install from the checkout, offline, and perf/python/overhead."""
import importlib.util
import os
import subprocess
import sys

import pytest
import surfaces

SOURCE = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", ".."))
PROGRAM = os.environ["OVERTET_PROGRAM"]
BUILD = os.path.dirname(os.path.dirname(os.path.abspath(PROGRAM)))


def run(*command, **more):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **more)
    assert done.returncode == 0, done.stdout
    return done.stdout


@pytest.fixture()
def worm(tmp_path):
    import overtet
    path = tmp_path / "worm.off"
    overtet.write(path, overtet.Surface(*surfaces.worm()))
    return path


@pytest.mark.skipif(any(not importlib.util.find_spec(m) for m in ("pip", "setuptools", "wheel")),
                    reason="python3-pip, python3-setuptools or python3-wheel is missing: pip install was NOT tested")
def test_pip_install(tmp_path, worm):
    target, mesh = tmp_path / "installed", tmp_path / "out.mesh"
    environment = dict(os.environ, OVERTET_BUILD_DIR=BUILD, PIP_NO_INPUT="1", PIP_DISABLE_PIP_VERSION_CHECK="1")
    environment.pop("PYTHONPATH")
    run(sys.executable, "-m", "pip", "install", "--no-build-isolation", "--no-index", "--no-deps", "--target", target, SOURCE,
        env=environment, cwd=tmp_path)
    assert {"__init__.py", "py.typed", "_core.pyi", "overtet-tetgen"} < set(os.listdir(target / "overtet"))
    told = run(sys.executable, "-B", "-c", "import overtet, sys\n"
               "mesh = overtet.tetrahedralize(overtet.read(sys.argv[1]))\novertet.write(sys.argv[2], mesh)\n"
               "print(overtet.__file__, overtet._api._helper())", worm, mesh, cwd=tmp_path,
               env=dict(environment, PYTHONPATH=str(target)))
    assert told.split() == [str(target / "overtet" / "__init__.py"), str(target / "overtet" / "overtet-tetgen")]
    theirs = tmp_path / "theirs.mesh"
    run(PROGRAM, "mesh", worm, "-o", theirs)
    assert mesh.read_bytes() == theirs.read_bytes()


def test_overhead_is_measured(worm):
    told = run(sys.executable, "-B", os.path.join(SOURCE, "perf", "python", "overhead"), "--build", BUILD, "--rounds", "1",
               worm)
    assert "worm.off" in told and "DIFFER" not in told
