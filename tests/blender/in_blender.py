"""The tests of the add-on, run by Blender (blender_test.py says how): arguments after -- are the program, the
add-on's file and a surface that passes through itself."""
import math
import os
import stat
import sys
import tempfile
import time
import types
import unittest

import bpy

PROGRAM, ADDON, SURFACE = sys.argv[sys.argv.index("--") + 1:]
MODULE = os.path.splitext(os.path.basename(ADDON))[0]


def read_off(path):
    with open(path, encoding="ascii") as file:
        words = file.read().split()[1:]
    vertices, faces = int(words[0]), int(words[1])
    numbers, corners = words[3:3 + 3 * vertices], words[3 + 3 * vertices:]
    return ([tuple(float(x) for x in numbers[3 * i:3 * i + 3]) for i in range(vertices)],
            [tuple(int(x) for x in corners[4 * i + 1:4 * i + 4]) for i in range(faces)])


def add(name, vertices, faces):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    for other in bpy.context.selected_objects:
        other.select_set(False)
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj
    return obj


CUBE = ([(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)],
        [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)])


def state_of(obj):
    mesh = obj.data
    return ([tuple(v.co) for v in mesh.vertices], [tuple(p.vertices) for p in mesh.polygons], [tuple(e.vertices) for e in mesh.edges],
            obj.matrix_world.copy(), obj.name, mesh.name, list(obj.modifiers), dict(obj.items()), obj.parent)


def markers(name, kind=""):
    collection = bpy.data.collections.get("Overtet " + name)
    return [o for o in collection.objects if o.name.startswith(kind)] if collection else []


def message():
    return bpy.context.window_manager.overtet_message


class Addon(unittest.TestCase):
    def setUp(self):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        bpy.ops.preferences.addon_enable(module=MODULE)
        self.preferences = bpy.context.preferences.addons[MODULE].preferences
        self.preferences.program = PROGRAM
        self.preferences.time_limit = 100

    def fails(self, operator, **words):
        """What the operator says when it fails; it must be a sentence."""
        with self.assertRaises(RuntimeError) as caught:
            operator(**words)
        text = str(caught.exception).removeprefix("Error: ").strip()
        self.assertNotIn("Traceback", text)
        self.assertTrue(text.endswith("."), text)
        self.assertEqual(text, message())
        return text

    def test_intersections_are_marked_where_they_are(self):
        obj = add("worm", *read_off(SURFACE))
        obj.matrix_world = obj.matrix_world @ obj.matrix_world.Translation((5, -2, 1)) @ obj.matrix_world.Scale(2, 4)
        before = state_of(obj)
        self.assertEqual(bpy.ops.overtet.inspect(), {"FINISHED"})
        self.assertEqual(state_of(obj), before)
        self.assertTrue(message().startswith("feasible: 178 pairs of faces intersect"), message())
        curves = markers("worm", "intersection")
        self.assertEqual([c.name for c in curves], ["intersection 0 (winding 0 to 2)"])
        mesh = curves[0].data
        self.assertEqual(len(mesh.edges), len(mesh.vertices))  # a closed curve
        self.assertEqual(curves[0].matrix_world, obj.matrix_world)
        for vertex in mesh.vertices:  # on the surface
            found, place, _, _ = obj.closest_point_on_mesh(vertex.co)
            self.assertTrue(found)
            self.assertLess((place - vertex.co).length, 1e-5)

    def test_running_again_replaces_markers_and_nothing_else(self):
        add("worm", *read_off(SURFACE))
        bpy.ops.overtet.inspect()
        own = bpy.data.objects.new("mine", None)
        bpy.data.collections["Overtet worm"].objects.link(own)
        names = sorted(o.name for o in markers("worm"))
        bpy.ops.overtet.inspect()
        self.assertEqual(sorted(o.name for o in markers("worm")), names)
        self.assertIn("mine", names)

    def test_hinges_and_the_witness(self):
        # A ball whose top is pushed out through its bottom.
        bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12)
        ball = bpy.context.active_object
        for vertex in ball.data.vertices:
            if vertex.co.z > .6:
                vertex.co.z -= 2.2 * (vertex.co.z - .3) + .5
        before = state_of(ball)
        bpy.ops.overtet.inspect()
        self.assertEqual(state_of(ball), before)
        self.assertTrue(message().startswith("infeasible: No mesh exists"), message())
        witness = markers(ball.name, "witness")
        self.assertTrue(witness)
        self.assertTrue(all(o.type == "EMPTY" for o in witness if "area" not in o.name))
        said = self.fails(bpy.ops.overtet.mesh)
        self.assertTrue(said.startswith("No mesh exists"), said)
        self.assertEqual(len(markers(ball.name, "witness")), len(witness))
        self.assertEqual(state_of(ball), before)

    def test_a_sharply_bent_cylinder_has_hinges(self):
        around, along = 24, 24
        vertices, faces = [], []
        for j in range(along + 1):
            s = -2 + 4 * j / along
            bend = math.radians(150) * min(max((s + .25) / .5, 0), 1)  # inside the radius: it folds through itself
            for i in range(around):
                a = 2 * math.pi * i / around
                x, y = .5 * math.cos(a), .5 * math.sin(a)
                c, n = math.cos(bend), math.sin(bend)
                vertices.append((x * c + s * n, y, -x * n + s * c))
        for j in range(along):
            for i in range(around):
                k = (i + 1) % around
                faces.append((j * around + i, j * around + k, (j + 1) * around + k, (j + 1) * around + i))
        faces += [tuple(reversed(range(around))), tuple(range(along * around, (along + 1) * around))]
        obj = add("elbow", vertices, faces)
        before = state_of(obj)
        bpy.ops.overtet.inspect()
        self.assertEqual(state_of(obj), before)
        hinges = markers("elbow", "hinge")
        self.assertTrue(hinges, message())
        for hinge in hinges:
            vertex = obj.data.vertices[int(hinge.name.split()[1])]
            self.assertLess((hinge.matrix_world.translation - obj.matrix_world @ vertex.co).length, 1e-5)

    def test_a_tet_mesh(self):
        worm = read_off(SURFACE)
        obj = add("worm", *worm)
        before = state_of(obj)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "worm.vtu")
            self.assertEqual(bpy.ops.overtet.mesh(filepath=path), {"FINISHED"})
            self.assertGreater(os.path.getsize(path), 1000)
        self.assertEqual(state_of(obj), before)
        self.assertRegex(message(), r"^exact: \d+ tets, smallest dihedral angle [\d.]+ degrees")
        boundary = markers("worm", "boundary")[0].data
        self.assertEqual([tuple(v.co) for v in boundary.vertices], before[0])
        self.assertEqual([tuple(p.vertices) for p in boundary.polygons], before[1])

    def test_polygons_and_modifiers(self):
        cube = add("cube", *CUBE)
        cube.modifiers.new("finer", "SUBSURF").levels = 1
        before = state_of(cube)
        bpy.ops.overtet.mesh()
        self.assertEqual(state_of(cube), before)
        self.assertEqual(len(markers("cube", "boundary")[0].data.polygons), 48)

    def test_a_hole_is_shown_with_its_face(self):
        obj = add("open", CUBE[0], CUBE[1][:-1])
        bpy.ops.overtet.inspect()
        self.assertTrue(message().startswith("bad-input: The surface has a hole"), message())
        self.assertTrue(markers("open", "hole"))
        said = self.fails(bpy.ops.overtet.mesh)
        # In numbers of Blender's polygons, and without lines of a file that nobody sees.
        self.assertRegex(said, r"^The surface has a hole of 4 edges, .* beside face [0-4]; it must be closed\.$")
        self.assertNotIn("line", said)
        self.assertEqual(len(obj.data.polygons), 5)

    def test_in_edit_mode_what_is_seen_counts(self):
        obj = add("cube", *CUBE)
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.transform.translate(value=(1, 0, 0))
        bpy.ops.overtet.mesh()
        self.assertEqual(obj.mode, "EDIT")
        self.assertAlmostEqual(min(v.co.x for v in markers("cube", "boundary")[0].data.vertices), 1)

    def test_what_goes_wrong_is_said(self):
        add("empty", [(0, 0, 0)], [])
        self.assertEqual(self.fails(bpy.ops.overtet.inspect), "empty has no faces.")
        add("cube", *CUBE)
        self.preferences.program = "/no/such/overtet"
        self.assertIn("no program /no/such/overtet", self.fails(bpy.ops.overtet.inspect))
        self.preferences.program = ""
        path, os.environ["PATH"] = os.environ["PATH"], ""
        try:
            self.assertIn("install the package", self.fails(bpy.ops.overtet.inspect))
        finally:
            os.environ["PATH"] = path
        with tempfile.TemporaryDirectory() as folder:
            broken = os.path.join(folder, "overtet")
            with open(broken, "w", encoding="ascii") as file:
                file.write("#!/bin/sh\nexit 3\n")
            os.chmod(broken, stat.S_IRWXU)
            self.preferences.program = broken
            self.assertIn("said nothing", self.fails(bpy.ops.overtet.mesh))
        self.preferences.program = PROGRAM
        self.assertIn("no/such/folder", self.fails(bpy.ops.overtet.mesh, filepath="/no/such/folder/a.vtu"))

    def test_a_time_limit_is_said_with_where_to_raise_it(self):
        add("worm", *read_off(SURFACE))
        self.preferences.time_limit = 1e-3
        self.assertIn("preferences", self.fails(bpy.ops.overtet.mesh))

    def test_blender_stays_usable_meanwhile(self):
        # What `modal` does between two looks at the program, which no window is there to call.
        addon = sys.modules[MODULE]
        obj = add("worm", *read_off(SURFACE))
        said = []

        class Operator(addon.Runner):
            words = addon.OVERTET_OT_mesh.words
            on_infeasible = "reject"

            def show(self, _context):
                return "INFO", f"ended with {self.run.process.returncode}"

            def report(self, level, text):
                said.append((*level, text))

        window = types.SimpleNamespace(event_timer_add=lambda *_, **__: None, event_timer_remove=lambda _: None,
                                       modal_handler_add=lambda _: None, overtet_message="")
        context = types.SimpleNamespace(active_object=obj, preferences=bpy.context.preferences, window=None, window_manager=window,
                                        evaluated_depsgraph_get=bpy.context.evaluated_depsgraph_get,
                                        workspace=types.SimpleNamespace(status_text_set=lambda _: None))
        for event, expected in (("TIMER", ("INFO", "ended with 0")), ("ESC", ("WARNING", "Overtet was interrupted."))):
            operator = Operator()
            operator.timer = None
            operator.begin(context)
            process, folder = operator.run.process, operator.run.folder.name
            while (done := operator.modal(context, types.SimpleNamespace(type=event))) == {"PASS_THROUGH"}:
                time.sleep(.01)
            self.assertEqual(done, {"FINISHED"})
            self.assertEqual(said[-1], expected)
            self.assertIsNotNone(process.poll())
            self.assertFalse(os.path.exists(folder))

    def test_it_can_be_taken_away(self):
        bpy.ops.preferences.addon_disable(module=MODULE)
        self.assertFalse(hasattr(bpy.types.WindowManager, "overtet_message"))
        self.assertFalse(hasattr(bpy.types, "OVERTET_OT_mesh"))
        bpy.ops.preferences.addon_enable(module=MODULE)


def main():
    # As Preferences > Install does it.
    scripts = bpy.utils.user_resource("SCRIPTS", path="addons", create=True)
    bpy.ops.preferences.addon_install(filepath=ADDON, overwrite=True)
    assert os.path.exists(os.path.join(scripts, os.path.basename(ADDON)))
    result = unittest.TextTestRunner(stream=sys.stdout, verbosity=2).run(unittest.defaultTestLoader.loadTestsFromTestCase(Addon))
    if not result.wasSuccessful():
        sys.exit(1)


main()
