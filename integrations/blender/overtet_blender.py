# This file is part of Overtet, AGPL-3.0-or-later.
"""Overtet in Blender: what is wrong with the selected object, and its tet mesh.

One file: Edit > Preferences > Add-ons > Install. In the 3D view's sidebar (N) there is then a tab "Overtet".
It writes the object to a temporary file, runs the program `overtet`, and shows what that finds as objects in a
collection "Overtet NAME": empties and edges, named by kind and number. It never changes the object itself.
"""
import fractions
import json
import os
import re
import shutil
import signal
import subprocess
import tempfile

import bpy
import mathutils

bl_info = {
    "name": "Overtet",
    "author": "Overtet maintainers",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D view > Sidebar > Overtet",
    "description": "Tet meshes of surfaces that pass through themselves: hinges, intersections, witnesses",
    "category": "Mesh",
}

MOST_MARKERS = 200  # of a kind: Blender gets slow with thousands of empties
OURS = "overtet"    # a custom property of what the add-on has made


class Failure(Exception):
    """What is told to the user: one plain sentence."""


# ---- the program


def find_program(path):
    """The program as the preferences name it, else on the PATH."""
    if path:
        full = os.path.expanduser(bpy.path.abspath(path))
        if os.path.isfile(full) and os.access(full, os.X_OK):
            return full
        raise Failure(f"There is no program {full}; name that of Overtet in the add-on's preferences")
    found = shutil.which("overtet")
    if not found:
        raise Failure("The program overtet was not found: install the package overtet, or name its path in the add-on's preferences")
    return found


class Run:
    """The program at work in a folder of its own, on one object."""

    def __init__(self, obj, settings, context):
        self.program = find_program(settings.program)
        self.name, self.matrix = obj.name, obj.matrix_world.copy()
        self.folder = tempfile.TemporaryDirectory(prefix="overtet-")
        self.process = None
        try:
            self.polygon_of = write_surface(obj, context, self.file("surface.off"))
        except BaseException:
            self.end()
            raise

    def file(self, name):
        return os.path.join(self.folder.name, name)

    def start(self, words, settings):
        limit = ["--time-limit", str(settings.time_limit)] if settings.time_limit > 0 else []
        with open(self.file("out"), "wb") as out, open(self.file("err"), "wb") as err:
            try:
                self.process = subprocess.Popen([self.program, *words, *limit], stdout=out, stderr=err,
                                                stdin=subprocess.DEVNULL, cwd=self.folder.name)
            except OSError as error:
                raise Failure(f"Cannot run {self.program}: {error.strerror}") from error

    def text(self, name):
        with open(self.file(name), encoding="utf-8", errors="replace") as file:
            return file.read()

    def json(self, name):
        try:
            return json.loads(self.text(name))
        except (OSError, ValueError):
            return None

    def complaint(self):
        """The last line that the program has said, without its name; the folder is of no interest."""
        lines = [line for line in self.text("err").splitlines() if line.strip()]
        line = lines[-1].removeprefix("overtet: ") if lines else ""
        return self.plain(line) or f"Overtet ended with {self.process.returncode} and said nothing."

    def plain(self, message):
        """A message of the program as it is true here: with Blender's faces, without lines of a temporary file and options
        of a command line."""
        def polygons(found):
            return re.sub(r"\d+", lambda n: str(self.polygon_of[int(n[0])] if int(n[0]) < len(self.polygon_of) else n[0]), found[0])
        message = re.sub(r" \(lines? [\d, .]+\)", "", message.replace(self.folder.name + os.sep, ""))
        message = re.sub(r"\bfaces? \d+(?:(?:,| and) \d+)*", polygons, message)
        message = message.replace("allow more with --time-limit", "allow more in the add-on's preferences")
        return message.replace("--on-infeasible ", "The choice ")

    def end(self):
        if self.process and self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)  # it ends in under two seconds
            try:
                self.process.wait(5)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        self.folder.cleanup()


# ---- files


def write_surface(obj, context, path):
    """The object as it is seen (modifiers applied) in its own coordinates; of each triangle its polygon's number."""
    if obj.mode == "EDIT":
        obj.update_from_editmode()  # else what is being edited is not seen yet
    evaluated = obj.evaluated_get(context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    try:
        mesh.calc_loop_triangles()
        if len(mesh.loop_triangles) == 0:
            raise Failure(f"{obj.name} has no faces")
        with open(path, "w", encoding="ascii") as out:
            out.write(f"OFF\n{len(mesh.vertices)} {len(mesh.loop_triangles)} 0\n")
            for vertex in mesh.vertices:
                x, y, z = vertex.co
                out.write(f"{x!r} {y!r} {z!r}\n")
            for triangle in mesh.loop_triangles:
                a, b, c = triangle.vertices
                out.write(f"3 {a} {b} {c}\n")
        return [triangle.polygon_index for triangle in mesh.loop_triangles]
    finally:
        evaluated.to_mesh_clear()


def read_medit(path):
    """Vertices, boundary triangles and the number of tets of a MEDIT file, as Overtet writes them."""
    vertices, triangles, tets = [], [], 0
    with open(path, encoding="ascii") as file:
        lines = iter(file)
        for line in lines:
            word = line.strip()
            if word == "Vertices":
                vertices = [tuple(float(x) for x in next(lines).split()[:3]) for _ in range(int(next(lines)))]
            elif word == "Triangles":
                triangles = [tuple(int(x) - 1 for x in next(lines).split()[:3]) for _ in range(int(next(lines)))]
            elif word == "Tetrahedra":
                tets = int(next(lines))
    return vertices, triangles, tets


# ---- what a report says, as markers: (kind, label, points, edges); points without edges are places


def number(x):
    return float(fractions.Fraction(x)) if isinstance(x, str) else float(x)


def points_in(value):
    """All points in a JSON value: lists of three numbers, however deep."""
    if not isinstance(value, list):
        return []
    if len(value) == 3 and all(isinstance(x, (int, float, str)) for x in value):
        return [tuple(number(x) for x in value)]
    return [point for item in value for point in points_in(item)]


def chain(count, closed):
    edges = [(i, i + 1) for i in range(count - 1)]
    return edges + [(count - 1, 0)] if closed and count > 2 else edges


def names_of(run):
    """Numbers of the cleaned surface as those of Blender: functions of a vertex and of a face."""
    changes = run.json("map.json") or {}
    vertices, faces = changes.get("vertices") or [], changes.get("faces") or []

    def vertex(n):
        return vertices[n] if 0 <= n < len(vertices) else n

    def face(n):
        n = faces[n] if 0 <= n < len(faces) else n
        return run.polygon_of[n] if 0 <= n < len(run.polygon_of) else n
    return vertex, face


def markers_of_inspection(report, run):
    vertex, face = names_of(run)
    for hinge in report.get("hinges", []):
        yield "hinge", f"{vertex(hinge['vertex'])} (B0 {hinge['B0']})", [tuple(hinge["position"])], []
    for i, curve in enumerate(report.get("curves", [])):
        points = [tuple(p["position"]) for p in curve.get("points", [])]
        winding = f"{curve['winding_min']} to {curve['winding_max']}"
        yield "intersection", f"{i} (winding {winding})", points, chain(len(points), curve["closed"])
    for edge in report.get("wound_edges", []):
        yield "wound edge", f"{vertex(edge['a'])}-{vertex(edge['b'])} (k {edge['k']})", points_in(edge["positions"]), [(0, 1)]
    for defect in report.get("defects", []):
        for i, place in enumerate(defect.get("places", [])):
            where = ""
            if place.get("faces"):
                where = f" at face {run.polygon_of[place['faces'][0]]}"
            elif place.get("vertices"):
                where = f" at vertex {place['vertices'][0]}"
            yield defect["kind"].replace("-", " "), f"{i}{where}", points_in(place.get("position")), []
    yield from markers_of_witness(report.get("witness"), vertex, face)


def markers_of_witness(witness, vertex, face):
    if not witness:
        return
    rule = witness["rule"]
    points = points_in([witness["point"]]) if "point" in witness else points_in(witness.get("positions", []))
    if rule in ("area", "stack") and "face" in witness:
        closed = len(points) == 3 and rule == "area"
        yield "witness", f"{rule} (face {face(witness['face'])})", points, chain(len(points), closed) if closed else []
        return
    numbers = witness.get("vertices", [witness["vertex"]] if "vertex" in witness else [])
    for i, point in enumerate(points):
        which = f"vertex {vertex(numbers[i])}" if len(numbers) == len(points) else i
        if rule == "winding":
            which = f"number {witness['winding']}"
        yield "witness", f"{rule} ({which})", [point], []


# ---- objects in Blender


def fresh_collection(scene, name):
    """An empty collection of this name: what an earlier run has left in it goes, nothing else."""
    title = f"Overtet {name}"
    collection = bpy.data.collections.get(title)
    if collection is None:
        collection = bpy.data.collections.new(title)
    if collection.name not in scene.collection.children:
        scene.collection.children.link(collection)
    for obj in list(collection.objects):
        if OURS not in obj:
            continue
        mesh = obj.data
        bpy.data.objects.remove(obj)
        if mesh is not None and mesh.users == 0:
            bpy.data.meshes.remove(mesh)
    return collection


def add_object(collection, name, data, matrix):
    obj = bpy.data.objects.new(name, data)
    obj[OURS] = True
    obj.matrix_world = matrix
    collection.objects.link(obj)
    return obj


def add_mesh(collection, name, points, edges, faces, matrix):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points, edges, faces)
    return add_object(collection, name, mesh, matrix)


def add_markers(collection, markers, run, size):
    """Returns how many there are of each kind, and how many of them were left out."""
    counts, left_out = {}, 0
    for kind, label, points, edges in markers:
        if not points:
            continue
        name = f"{kind} {label}"
        counts[kind] = counts.get(kind, 0) + 1
        if counts[kind] > MOST_MARKERS:
            left_out += 1
        elif edges:
            add_mesh(collection, name, points, edges, [], run.matrix).show_in_front = True
        else:
            for point in points:
                marker = add_object(collection, name, None, run.matrix)
                marker.matrix_world.translation = run.matrix @ mathutils.Vector(point)
                marker.empty_display_type = "SPHERE"
                marker.empty_display_size = size
                marker.show_in_front = True
    return counts, left_out


def marker_size(obj):
    """A fiftieth of the object's box, in its own units, as the markers have its scale."""
    return max(1e-6, max((max(c[k] for c in obj.bound_box) - min(c[k] for c in obj.bound_box)) for k in range(3)) / 50)


def in_words(counts):
    return ", ".join(f"{n} {kind if n == 1 else kind + ('es' if kind.endswith(('s', 'x')) else 's')}" for kind, n in sorted(counts.items()))


# ---- operators


class OvertetPreferences(bpy.types.AddonPreferences):
    bl_idname = __name__
    program: bpy.props.StringProperty(
        name="Program", subtype="FILE_PATH", description="Path of overtet; empty: as the shell finds it")
    time_limit: bpy.props.FloatProperty(
        name="Time limit", default=300, min=0, description="Seconds after which a run gives up; 0: never")

    def draw(self, _context):
        self.layout.prop(self, "program")
        self.layout.prop(self, "time_limit")


class Default:
    program, time_limit = "", 300.0


def settings_of(context):
    addon = context.preferences.addons.get(__name__)
    return addon.preferences if addon and addon.preferences else Default


class Runner:
    """Runs the program beside Blender, which stays usable; waits for it where a script calls the operator."""

    @classmethod
    def poll(cls, context):
        return context.active_object is not None and context.active_object.type == "MESH"

    def begin(self, context):
        obj = context.active_object
        settings = settings_of(context)
        self.run = Run(obj, settings, context)
        self.size = marker_size(obj)
        try:
            self.run.start(self.words(), settings)
        except BaseException:
            self.run.end()
            raise

    def conclude(self, context):
        try:
            level, message = self.show(context)
        finally:
            self.run.end()
        return self.tell(context, level, message)

    def tell(self, context, level, message):
        context.window_manager.overtet_message = message
        self.report({level}, message)
        return {"CANCELLED"} if level == "ERROR" else {"FINISHED"}

    def execute(self, context):
        try:
            self.begin(context)
            self.run.process.wait()
            return self.conclude(context)
        except Failure as failure:
            return self.tell(context, "ERROR", str(failure) + ".")

    def invoke(self, context, _event):
        if bpy.app.background:
            return self.execute(context)
        try:
            self.begin(context)
        except Failure as failure:
            return self.tell(context, "ERROR", str(failure) + ".")
        self.timer = context.window_manager.event_timer_add(.1, window=context.window)
        context.window_manager.modal_handler_add(self)
        context.workspace.status_text_set("Overtet works; Esc ends it")
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        stopped = event.type == "ESC"
        if not stopped and self.run.process.poll() is None:
            return {"PASS_THROUGH"}
        context.window_manager.event_timer_remove(self.timer)
        context.workspace.status_text_set(None)
        if stopped:
            self.run.end()
            return self.tell(context, "WARNING", "Overtet was interrupted.")
        try:
            return self.conclude(context)
        except Failure as failure:
            return self.tell(context, "ERROR", str(failure) + ".")


class OVERTET_OT_inspect(Runner, bpy.types.Operator):
    """Show hinges, intersections and what keeps the object from having a tet mesh"""
    bl_idname = "overtet.inspect"
    bl_label = "Inspect"
    bl_options = {"REGISTER", "UNDO"}

    def words(self):
        return ["inspect", "surface.off", "--json", "--curves", "--save-map", "map.json"]

    def show(self, context):
        report = self.run.json("out")
        if report is None:
            return "ERROR", self.run.complaint()
        collection = fresh_collection(context.scene, self.run.name)
        counts, left_out = add_markers(collection, markers_of_inspection(report, self.run), self.run, self.size)
        message = f"{report['verdict']}: {self.run.plain(report['message'])}"
        if counts:
            message += f" Shown: {in_words(counts)}" + (f" ({left_out} more are not)" if left_out else "") + "."
        return ("INFO" if report["verdict"] in ("embedded", "feasible") else "WARNING"), message


class OVERTET_OT_mesh(Runner, bpy.types.Operator):
    """Make a tet mesh of the object, and show its boundary, or why there is none"""
    bl_idname = "overtet.mesh"
    bl_label = "Make tet mesh"
    bl_options = {"REGISTER", "UNDO"}

    filepath: bpy.props.StringProperty(
        name="Tet mesh", subtype="FILE_PATH",
        description="Where to leave the tet mesh (.mesh, .msh, .vtu, .inp, .vtk, .node); empty: nowhere")
    on_infeasible: bpy.props.EnumProperty(
        name="If there is no mesh", default="reject", items=[
            ("reject", "Say why", "Show the witness"),
            ("repair", "Repair", "Move a few vertices of the copy that is meshed"),
            ("refine", "Refine", "Subdivide a few faces of the copy that is meshed"),
            ("branch", "Branch", "Let tets make two turns around some edges inside")])
    boundary: bpy.props.BoolProperty(
        name="Boundary", default=True, description="Add the boundary of the tet mesh as an object")

    def words(self):
        return ["mesh", "surface.off", "-o", "tets.mesh", "--report", "report.json", "--save-map", "map.json",
                "--on-infeasible", self.on_infeasible]

    def show(self, context):
        report = self.run.json("report.json") or {}
        collection = fresh_collection(context.scene, self.run.name)
        if self.run.process.returncode != 0:
            add_markers(collection, markers_of_witness(report.get("witness"), *names_of(self.run)), self.run, self.size)
            return "ERROR", self.run.plain(report.get("message") or "") or self.run.complaint()
        vertices, triangles, tets = read_medit(self.run.file("tets.mesh"))
        if self.boundary:
            used = sorted({v for t in triangles for v in t})
            place = {v: i for i, v in enumerate(used)}
            add_mesh(collection, f"boundary {self.run.name}", [vertices[v] for v in used], [],
                     [tuple(place[v] for v in t) for t in triangles], self.run.matrix)
        message = f"{report.get('status', 'exact')}: {tets} tets"
        quality = report.get("quality") or {}
        if "dihedral_min" in quality:
            message += f", smallest dihedral angle {quality['dihedral_min']:.1f} degrees"
        moved = (report.get("moved") or {}).get("vertices", 0)
        if moved:
            message += f", {moved} vertices moved"
        if self.filepath:
            message += ", " + self.leave(bpy.path.abspath(self.filepath))
        return "INFO", message + "."

    def leave(self, path):
        done = subprocess.run([self.run.program, "convert", self.run.file("tets.mesh"), path, "--quiet"],
                              stderr=subprocess.PIPE, text=True, check=False)
        if done.returncode != 0:
            raise Failure(done.stderr.strip().removeprefix("overtet: ").rstrip("."))
        return f"in {path}"


class OVERTET_PT_panel(bpy.types.Panel):
    bl_label = "Overtet"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Overtet"

    def draw(self, context):
        column = self.layout.column()
        column.operator(OVERTET_OT_inspect.bl_idname)
        column.operator(OVERTET_OT_mesh.bl_idname)
        words = context.window_manager.overtet_message.split()
        most = max(16, int(context.region.width / (7.5 * context.preferences.system.ui_scale)))  # letters a line, about
        line = ""
        for word in words + [""]:
            if line and (not word or len(line) + len(word) >= most):
                column.label(text=line)
                line = ""
            line = f"{line} {word}".strip()


CLASSES = (OvertetPreferences, OVERTET_OT_inspect, OVERTET_OT_mesh, OVERTET_PT_panel)


def register():
    bpy.types.WindowManager.overtet_message = bpy.props.StringProperty()
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
    del bpy.types.WindowManager.overtet_message


if __name__ == "__main__":
    register()
