"""The energies of bounded biharmonic weights, beside Ipopt's, on meshes that overlap themselves: within 1e-6."""
import json
import os
import subprocess
import sys
import tempfile

import numpy

PROGRAM, SOURCE, REFERENCE = sys.argv[1:4]
sys.path.insert(0, os.path.join(SOURCE, "examples", "skinning"))

import hand  # noqa: E402


def main():
    if not REFERENCE:
        print("SKIPPED: Ipopt is not installed (coinor-libipopt-dev, by scripts/setup --examples), so that weights are not compared "
              "with its.", file=sys.stderr)
        sys.exit(77)
    with tempfile.TemporaryDirectory() as folder:
        def file(name):
            return os.path.join(folder, name)

        def mesh(surface, name, vertices):
            subprocess.run([PROGRAM, "mesh", surface, "-o", file(name + ".mesh"), "--quiet"], check=True)
            handles = [{"name": f"v{v}", "vertex": v} for v in vertices]
            with open(file(name + ".json"), "w", encoding="ascii") as out:
                json.dump({"handles": handles}, out)
            return [file(name + ".mesh"), file(name + ".json")]
        subprocess.run([sys.executable, "-B", os.path.join(SOURCE, "scripts", "make_sample"), file("worm.off"), "390", "16"],
                       check=True, stdout=subprocess.DEVNULL)
        words = mesh(file("worm.off"), "worm", [0, 200, 500, 700, 1000])
        points, faces, groups = hand.hand("fist")
        hand.write(file("fist.obj"), points, faces, groups)
        # The ends of the fingers and the wrist.
        rest = hand.rest()[0]
        ends = [int(numpy.argmin(numpy.linalg.norm(rest - [n * (hand.WIDTH + hand.GAP) + hand.WIDTH / 2,
                                                           hand.KNUCKLES + 0.9 * hand.LENGTH[f], 0], axis=1)))
                for n, f in enumerate(hand.FINGERS)] + [int(numpy.argmin(rest[:, 1]))]
        words += mesh(file("fist.obj"), "fist", ends)
        # Bones, too.
        with open(file("bones.json"), "w", encoding="ascii") as out:
            palm = {"name": "palm", "head": [2.7, hand.WRIST + 0.4, 0], "tail": [2.7, 2, 0]}
            json.dump({"handles": [palm] + [{"name": f"v{v}", "vertex": v} for v in ends[:2]]}, out)
        words += [file("fist.mesh"), file("bones.json")]
        done = subprocess.run([REFERENCE, *words], check=False)
        sys.exit(done.returncode)


main()
