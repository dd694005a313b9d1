"""A skin that overtet solve weights wrote, as Blender reads it: the skeleton, the weights, and a bone that is turned."""
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile

PROGRAM, SOURCE = sys.argv[1:3]
SCRIPT = """
import bpy, json, math, numpy
numpy.bool = bool  # Debian 12 has a numpy that is too new for its importer
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=%r)
skin = next(o for o in bpy.data.objects if o.type == 'MESH' and o.vertex_groups)
armature = next(o for o in bpy.data.objects if o.type == 'ARMATURE')

def places():
    evaluated = skin.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return numpy.array([evaluated.matrix_world @ v.co for v in evaluated.data.vertices])

before = places()
bone = armature.pose.bones['bone 15']
bone.location = (0, 0, 1)
bpy.context.view_layer.update()
moved = numpy.linalg.norm(places() - before, axis=1)
print('FOUND ' + json.dumps([sorted(g.name for g in skin.vertex_groups), sorted(b.name for b in armature.data.bones), moved.tolist()]))
"""


def axis(degrees):
    """The middle of the worm of scripts/make_sample."""
    a = math.radians(degrees)
    r = 1 - 0.011 * a
    return [r * math.sin(a), -r * math.cos(a), 0.315 * a / (2 * math.pi)]


def main():
    if shutil.which("blender") is None:
        print("SKIPPED: Blender is not installed (scripts/setup --examples), so that it does not read the skin.", file=sys.stderr)
        sys.exit(77)
    with tempfile.TemporaryDirectory() as folder:
        def file(name):
            return os.path.join(folder, name)
        subprocess.run([sys.executable, "-B", os.path.join(SOURCE, "scripts", "make_sample"), file("worm.off"), "390", "16"],
                       check=True, stdout=subprocess.DEVNULL)
        subprocess.run([PROGRAM, "mesh", file("worm.off"), "-o", file("worm.vtu"), "--quiet"], check=True)
        bones = [{"name": f"bone {k}", "head": axis(5 + 20 * k), "tail": axis(25 + 20 * k)} for k in range(19)]
        for k in range(1, 19):
            bones[k]["parent"] = f"bone {k - 1}"
        with open(file("h.json"), "w", encoding="ascii") as out:
            json.dump({"handles": bones}, out)
        subprocess.run([PROGRAM, "solve", "weights", file("worm.vtu"), "--handles", file("h.json"), "-o", file("skin.glb"), "--quiet"],
                       check=True)
        with open(file("look.py"), "w", encoding="utf-8") as out:
            out.write(SCRIPT % file("skin.glb"))
        done = subprocess.run(["blender", "--background", "--factory-startup", "--python-exit-code", "1", "--python", file("look.py")],
                              capture_output=True, text=True, check=False, env=dict(os.environ, HOME=folder))
        found = [line for line in done.stdout.splitlines() if line.startswith("FOUND ")]
        assert done.returncode == 0 and found, done.stdout[-3000:] + done.stderr[-3000:]
        groups, known, moved = json.loads(found[0][6:])
        names = [b["name"] for b in bones]
        assert groups == sorted(names) and set(names) <= set(known), (groups, known)
        # The head moved with its bone; the tail, in the same place, did not. The surface's vertices go from tail to head.
        assert abs(moved[-1] - 1) < 1e-3 and moved[0] < 1e-3, (moved[0], moved[-1])


main()
