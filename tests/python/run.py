"""Runs tests of the Python package of a build folder; ends with 77, and says so, where they cannot be run.

usage: run.py BUILD [PYTEST ARGUMENTS]     for instance a file of this folder
"""
import importlib.util
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))


def main():
    build = os.path.abspath(sys.argv[1])
    package = os.path.join(build, "python")
    missing = [name for name in ("pytest", "numpy") if not importlib.util.find_spec(name)]
    if missing or not os.path.exists(package):
        print("SKIPPED: the Python package was NOT tested:",
              "missing " + ", ".join(missing) if missing else "it was not built (-DOVERTET_PYTHON=ON)")
        return 77
    os.environ.update(OVERTET_PROGRAM=os.path.join(build, "bin", "overtet"), PYTHONDONTWRITEBYTECODE="1",
                      PYTHONPATH=os.pathsep.join([package, HERE]))
    os.chdir(HERE)
    os.execv(sys.executable, [sys.executable, "-B", "-m", "pytest", "-q", "-p", "no:cacheprovider", *sys.argv[2:]])


if __name__ == "__main__":
    sys.exit(main())
