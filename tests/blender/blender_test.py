#!/usr/bin/python3
"""Runs in_blender.py in Blender without a window: the add-on on objects made there.

usage: blender_test.py OVERTET

Exit code 77 where Blender is missing.
"""
import os
import shutil
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.realpath(__file__))
ADDON = os.path.join(HERE, "..", "..", "integrations", "blender", "overtet_blender.py")


def main():
    blender = shutil.which("blender")
    if not blender:
        print("SKIPPED: the add-on is not run: install blender (scripts/setup --examples)")
        return 77
    with tempfile.TemporaryDirectory() as folder:
        surface = os.path.join(folder, "worm.off")
        subprocess.run([os.path.join(HERE, "..", "..", "scripts", "make_sample"), surface], check=True)
        environment = dict(os.environ, HOME=folder, TMPDIR=folder, BLENDER_USER_RESOURCES=folder)
        done = subprocess.run(
            [blender, "--background", "--factory-startup", "--python-exit-code", "1", "--python",
             os.path.join(HERE, "in_blender.py"), "--", os.path.abspath(sys.argv[1]), os.path.abspath(ADDON), surface],
            env=environment, check=False)
        left = [name for name in os.listdir(folder) if name.startswith("overtet-")]
    if left:
        print("Temporary folders were left:", left)
        return 1
    return done.returncode


if __name__ == "__main__":
    sys.exit(main())
