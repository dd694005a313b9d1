"""pip install . : CMake builds the extension and overtet-tetgen, the program that TetGen runs in; both go into the
package. `scripts/setup --python` installs what that takes.

CMAKE_ARGS: more arguments for CMake. OVERTET_BUILD_DIR: the folder to build in; one that was configured with
-DOVERTET_PYTHON=ON is not built anew.
"""
import os
import re
import shlex
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = os.path.dirname(os.path.abspath(__file__))


def version():
    with open(os.path.join(ROOT, "include", "overtet", "version.h"), encoding="utf-8") as file:
        return ".".join(re.findall(r"^#define OVERTET_VERSION_\w+ (\d+)", file.read(), re.MULTILINE))


class BuildWithCMake(build_ext):
    def run(self):
        build = os.path.abspath(os.environ.get("OVERTET_BUILD_DIR") or self.build_temp)
        if not os.path.exists(os.path.join(build, "CMakeCache.txt")):
            subprocess.check_call(["cmake", "-S", ROOT, "-B", build, "-DCMAKE_BUILD_TYPE=Release", "-DOVERTET_PYTHON=ON",
                                   "-DOVERTET_TESTS=OFF", "-DPython3_EXECUTABLE=" + sys.executable, *(["-GNinja"] if shutil.which("ninja") else []),
                                   *shlex.split(os.environ.get("CMAKE_ARGS", ""))])
        subprocess.check_call(["cmake", "--build", build, "--parallel", str(os.cpu_count()), "--target",
                               "overtet_python", "overtet-tetgen"])
        target = self.get_ext_fullpath("overtet._core")
        folder = os.path.dirname(target)
        os.makedirs(folder, exist_ok=True)
        made = os.path.join(build, "python", "overtet", os.path.basename(target))
        for path, to in ((made, target), (os.path.join(build, "bin", "overtet-tetgen"),
                                          os.path.join(folder, "overtet-tetgen"))):
            if os.path.realpath(path) != os.path.realpath(to):
                shutil.copy2(path, to)
            if shutil.which("strip"):
                subprocess.check_call(["strip", "--strip-unneeded", to])


# All that is made on the way goes into build/, as what CMake makes does.
os.makedirs(os.path.join(ROOT, "build", "pip"), exist_ok=True)
setup(options={"build": {"build_base": "build/pip"}, "egg_info": {"egg_base": "build/pip"}},
      version=version(), packages=["overtet"], package_dir={"overtet": "python/overtet"},
      package_data={"overtet": ["py.typed", "*.pyi"]}, include_package_data=False,
      ext_modules=[Extension("overtet._core", [])], cmdclass={"build_ext": BuildWithCMake}, zip_safe=False)
