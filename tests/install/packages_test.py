"""Makes the Debian packages of a build, asks lintian for errors, installs them into an empty root, runs what is
there, removes them again. Skipped, loudly, where a tool is missing or the user is not root.

usage: packages_test.py SOURCE BUILD
"""
import glob
import os
import shutil
import subprocess
import sys
import tempfile

USE_PYTHON = """import overtet, sys
mesh = overtet.tetrahedralize(overtet.clean_up(overtet.read(sys.argv[1])))
overtet.write(sys.argv[2], mesh)
print(overtet.__file__, mesh)
"""
SOURCE, BUILD = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])


def run(*command, **more):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **more)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}\nended with {done.returncode}:\n{done.stdout}")
    return done.stdout


def files_in(root):
    return sorted(os.path.join(where, name) for where, _, names in os.walk(root) for name in names)


def main():
    missing = [tool for tool in ("cpack", "dpkg", "dpkg-deb", "dpkg-shlibdeps", "lintian") if not shutil.which(tool)]
    if missing or os.getuid() != 0:
        print("SKIPPED: the Debian packages were NOT checked:",
              "missing " + ", ".join(missing) if missing else "only root can install packages")
        sys.exit(77)
    with tempfile.TemporaryDirectory() as temporary:
        made = os.path.join(temporary, "packages")
        run("cpack", "-G", "DEB", "-B", made, "--config", os.path.join(BUILD, "CPackConfig.cmake"))
        packages = sorted(glob.glob(os.path.join(made, "*.deb")))
        names = [run("dpkg-deb", "--field", p, "Package").strip() for p in packages]
        python = "python3-overtet" in names
        pictures = "overtet-pictures" in names
        assert sorted(names) == ["libovertet-dev", "overtet"] + ["overtet-pictures"] * pictures + ["python3-overtet"] * python, names
        assert pictures == os.path.exists(os.path.join(BUILD, "bin", "overtet-picture")), names
        assert python == os.path.exists(os.path.join(BUILD, "python")), names
        print(run("lintian", "--fail-on", "error", "--allow-root", *packages))

        root = os.path.join(temporary, "root")
        for folder in ("updates", "info", "triggers"):
            os.makedirs(os.path.join(root, "var/lib/dpkg", folder))
        for name in ("status", "available"):
            open(os.path.join(root, "var/lib/dpkg", name), "w", encoding="utf-8").close()
        # Nothing else is in the root, so what the packages depend on is not either.
        dpkg = ("dpkg", "--root=" + root, "--force-depends", "--force-script-chrootless")
        before = [f for f in files_in(root) if "/var/" not in f]
        run(*dpkg, "--install", *packages)
        worm, mesh = os.path.join(temporary, "worm.off"), os.path.join(temporary, "worm.mesh")
        run(sys.executable, "-B", os.path.join(SOURCE, "scripts", "make_sample"), worm)
        program = os.path.join(root, "usr/bin/overtet")
        run(program, "mesh", worm, "-o", mesh)
        print(run(program, "verify", worm, mesh))
        if pictures:
            picture = os.path.join(temporary, "worm.png")
            run(program, "view", mesh, "--png", picture, "--size", "80x60")
            assert os.path.getsize(picture) > 200
        if python:
            again = os.path.join(temporary, "again.mesh")
            module = os.path.join(root, "usr/lib/python3/dist-packages")
            told = run("/usr/bin/python3", "-B", "-c", USE_PYTHON, worm, again, env=dict(os.environ, PYTHONPATH=module))
            assert told.startswith(module), told
            with open(mesh, "rb") as one, open(again, "rb") as other:
                assert one.read() == other.read(), "the module makes another mesh than the program"
        run(*dpkg, "--purge", *names)
        assert [f for f in files_in(root) if "/var/" not in f] == before, files_in(root)


main()
