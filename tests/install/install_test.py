"""Installs a build into a new folder and uses it from outside: the program, the Python module if it was built, a
consumer that CMake builds, and the same one that pkg-config describes.

usage: install_test.py SOURCE BUILD CXX
"""
import os
import subprocess
import sys
import tempfile

SOURCE, BUILD, CXX = (os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]), sys.argv[3])
CONSUMER = os.path.join(SOURCE, "tests", "install", "consumer")

USE_PYTHON = """import overtet, sys
overtet.write(sys.argv[2], overtet.tetrahedralize(overtet.clean_up(overtet.read(sys.argv[1]))))
print(overtet._api._helper())
"""


def run(*command, expect=0, **more):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **more)
    if done.returncode != expect:
        sys.exit(f"{' '.join(command)}\nended with {done.returncode}, not {expect}:\n{done.stdout}")
    return done.stdout


def text_of(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def find(folder, name):
    for where, _, names in os.walk(folder):
        if name in names:
            return os.path.join(where, name)
    sys.exit(f"There is no {name} in {folder}.")


def check_headers(prefix):
    """All public headers are there, and nothing of src/ or kernels/."""
    public = sorted(os.listdir(os.path.join(SOURCE, "include", "overtet")))
    assert sorted(os.listdir(os.path.join(prefix, "include", "overtet"))) == public
    for name in ("overtet-config.cmake", "overtet-targets.cmake", "overtet.pc"):
        for place in (SOURCE, BUILD):
            assert place not in text_of(find(prefix, name)), f"{name} knows {place}"


def main():
    with tempfile.TemporaryDirectory() as temporary:
        prefix = os.path.join(temporary, "prefix")
        run("cmake", "--install", BUILD, "--prefix", prefix)
        check_headers(prefix)
        helper = find(os.path.join(prefix, "libexec"), "overtet-tetgen")

        worm = os.path.join(temporary, "worm.off")
        run(sys.executable, "-B", os.path.join(SOURCE, "scripts", "make_sample"), worm)
        program = os.path.join(prefix, "bin", "overtet")
        expected = os.path.join(temporary, "program.mesh")
        run(program, "mesh", worm, "-o", expected)

        module = os.path.join(prefix, "lib", "python3", "dist-packages")
        assert os.path.exists(module) == os.path.exists(os.path.join(BUILD, "python")), "the Python module is not installed"
        if os.path.exists(module):
            out = os.path.join(temporary, "module.mesh")
            told = run("/usr/bin/python3", "-B", "-c", USE_PYTHON, worm, out, env=dict(os.environ, PYTHONPATH=module))
            assert told.split() == [helper], told
            assert text_of(out) == text_of(expected), "the module makes another mesh than the program"

        # Linked statically, a program cannot know where the prefix was moved to: it is told.
        def check(consumer):
            out = consumer + ".mesh"
            print(run(consumer, worm, out, helper).strip())
            assert text_of(out) == text_of(expected), f"{consumer} makes another mesh than the program"
            assert "no such" in run(consumer, "no such.off", out, expect=1)

        by_cmake = os.path.join(temporary, "cmake")
        run("cmake", "-S", CONSUMER, "-B", by_cmake, "-DCMAKE_PREFIX_PATH=" + prefix, "-DCMAKE_CXX_COMPILER=" + CXX)
        run("cmake", "--build", by_cmake)
        check(os.path.join(by_cmake, "consumer"))

        folder = os.path.dirname(find(prefix, "overtet.pc"))
        described = dict(os.environ, PKG_CONFIG_PATH=folder)
        flags = run("pkg-config", "--cflags", "--libs", "overtet", env=described).split()
        assert run("pkg-config", "--variable=tetgen_helper", "overtet", env=described).strip(), "no tetgen_helper"
        by_pkg_config = os.path.join(temporary, "by_pkg_config")
        libraries = os.path.dirname(folder)  # for a shared one
        run(CXX, "-std=c++20", os.path.join(CONSUMER, "main.cpp"), "-o", by_pkg_config, *flags,
            "-Wl,-rpath," + libraries)
        check(by_pkg_config)


main()
