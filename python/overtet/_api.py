"""The functions of overtet."""
from __future__ import annotations

import json
import os
from typing import Any, Callable, List, Optional, Union

import numpy as np

from . import _arrays, _core
from ._errors import UsageError
from ._types import (CleanUp, Diagnosis, Embedding, Mesh, Prepared, Repair, Surface, Verification, clean_up_of, mesh_dict,
                     quality_of, surface_dict)

Path = Union[str, bytes, "os.PathLike[Any]"]
Progress = Optional[Callable[[str, float], Any]]
Log = Optional[Callable[[str, str], Any]]

_HERE = os.path.dirname(os.path.abspath(__file__))


def _helper() -> str:
    """overtet-tetgen of this package or of the installation that it is part of; empty: the library looks for it."""
    for path in (os.path.join(_HERE, "overtet-tetgen"),
                 os.path.join(_HERE, "..", "..", "..", "..", "libexec", "overtet", "overtet-tetgen")):
        if os.access(path, os.X_OK):
            return os.path.abspath(path)
    return ""


def _run(threads: int = 0, time_limit: Optional[float] = None, memory_limit: Optional[float] = None,
         progress: Progress = None, log: Log = None) -> dict:
    """How a run is to be: what all functions have in common."""
    if int(threads) != threads or not 0 <= threads <= 1024:
        raise UsageError(f"threads is {threads}; it must be a whole number from 0 (all cores) to 1024.")
    for name, limit in (("time_limit", time_limit), ("memory_limit", memory_limit)):
        if limit is not None and not limit > 0:
            raise UsageError(f"{name} is {limit}; it must be positive, or None.")
    for name, function in (("progress", progress), ("log", log)):
        if function is not None and not callable(function):
            raise UsageError(f"{name} must be a function, or None.")
    if memory_limit is None:  # the rest is for others
        most = int(.9 * _core.usable_memory_bytes())
    else:
        most = int(memory_limit * 2**20) if memory_limit < 2**43 else 0
    # More than a century is no limit; it would overflow the clock.
    seconds = None if time_limit is None or time_limit > 4e9 else float(time_limit)
    return {"threads": int(threads) or _core.usable_cores(), "time_limit": seconds, "memory_limit": most,
            "tetgen_helper": _helper(), "progress": progress, "log": log}


def _surface(V: Any, F: Any) -> Surface:
    if isinstance(V, (CleanUp, Mesh)) and F is None:
        V = V.surface
    if isinstance(V, Surface):
        if F is not None:
            raise UsageError("Give a Surface, or V and F; not both.")
        return V
    if F is None:
        raise UsageError("F is missing: give V and F, or a Surface.")
    return Surface(V, F)


def _choice(name: str, value: str, choices: List[str]) -> str:
    if value not in choices:
        raise UsageError(f"{name} is {value!r}; it must be one of {', '.join(map(repr, choices))}.")
    return value


def tetrahedralize(V: Any, F: Any = None, *, labels: Any = None, on_infeasible: str = "reject",
                   preset: str = "default", max_move: float = .06, improve: float = 17, max_edge: float = 0,
                   max_volume: float = 0, sizes: Any = None, coarse: bool = False, layers: bool = True,
                   threads: int = 0, time_limit: Optional[float] = None, memory_limit: Optional[float] = None,
                   progress: Progress = None, log: Log = None) -> Mesh:
    """The tet mesh of a closed surface that may pass through itself: ``tetrahedralize(V, F)`` or
    ``tetrahedralize(surface)``.

    V: #V x 3 coordinates (float64; float32 and integers are converted). F: #F x 3 vertices, counted from 0,
    counter-clockwise seen from outside. The mesh has the vertices first, unmoved to the bit, every face as a boundary
    face, and positive tets only; where the surface overlaps itself, so do they. All of that is checked exactly.

    labels: #F whole numbers that the boundary faces keep. on_infeasible: what to do where there is no such mesh:
    "reject" raises Infeasible, "repair" moves a few vertices, each by `max_move` (relative to the diagonal) at most,
    "refine" subdivides a few faces, "branch" allows two turns of tets around some inner edges. preset: "default" or
    "flow". improve: the smallest dihedral angle that is aimed at, in degrees, 0 (off) to 40. max_edge, max_volume: of
    inner edges and of tets, 0: any. sizes: #V, the longest edge at each vertex, 0: any. coarse: as few inner vertices
    as possible. layers: count the layers at each tet (a twentieth of the time, where the surface overlaps itself).

    threads: 0: all cores; the mesh is the same on any number. time_limit: seconds. memory_limit: MiB, of this process
    and its children together; None: nine tenths of what is free. progress(stage, fraction), log(level, message): are
    called in this thread, now and then; what they raise ends the run and comes out of this function, as Ctrl-C does.

    Raises BadInput, Infeasible, Unsolved, Limit, UsageError, FileError, InternalError, KeyboardInterrupt.
    """
    surface = surface_dict(_surface(V, F))
    n = len(surface["V"])
    if labels is not None:
        surface["labels"] = _arrays.integers(labels, "labels", len(surface["F"]), "face")
    _choice("on_infeasible", on_infeasible, ["reject", "repair", "refine", "branch"])
    _choice("preset", preset, ["default", "flow"])
    told = {"preset": preset, "on_infeasible": on_infeasible, "improve": float(improve), "threads": int(threads)}
    told.update({key: float(value) for key, value in (("max_edge", max_edge), ("max_volume", max_volume),
                                                      ("time_limit", time_limit), ("memory_limit", memory_limit))
                 if value})
    if coarse:
        told["coarse"] = True
    wanted = _arrays.numbers(sizes, "sizes", n, "vertex")
    if wanted is not None:
        wanted = np.where(wanted == 0, np.inf, wanted.astype(np.float64))
    made = _core.tetrahedralize(
        surface.pop("V"), surface.pop("F"), surface,
        {"preset": preset, "on_infeasible": on_infeasible, "max_move": float(max_move), "improve": float(improve),
         "max_edge": float(max_edge), "max_volume": float(max_volume), "sizes": wanted, "coarse": bool(coarse),
         "layers": bool(layers), "told": told},
        _run(threads, time_limit, memory_limit, progress, log))
    return _mesh(made)


def _mesh(made: dict) -> Mesh:
    if "report" in made:
        made["report"] = json.loads(made["report"])
        made["quality"] = quality_of(made["quality"])
    return Mesh(**made)


def inspect(V: Any, F: Any = None, *, threads: int = 0, time_limit: Optional[float] = None,
            memory_limit: Optional[float] = None, progress: Progress = None, log: Log = None) -> Diagnosis:
    """What can be said about a surface (V: #V x 3, F: #F x 3, or a Surface) before any mesh is made: whether there can
    be one, if not, why not, and where it passes through itself. What is wrong with it is in the diagnosis; bool() of
    it says whether a mesh is not ruled out.

    Raises Limit, UsageError, InternalError, KeyboardInterrupt; BadInput only for numbers that do not fit into 32 bits.
    """
    surface = surface_dict(_surface(V, F))
    found = _core.inspect(surface["V"], surface["F"], _run(threads, time_limit, memory_limit, progress, log))
    found["certificate"] = None if found["certificate"] is None else json.loads(found["certificate"])
    return Diagnosis(**found)


def verify(V: Any, F: Any = None, V2: Any = None, T: Any = None, *, max_move: float = 0,
           allow_branches: bool = False, geometry_only: Optional[bool] = None, threads: int = 0,
           time_limit: Optional[float] = None, memory_limit: Optional[float] = None) -> Verification:
    """Whether a tet mesh (V2: #V2 x 3, T: #T x 4) is what Overtet promises for a surface (V: #V x 3, F: #F x 3):
    ``verify(V, F, V2, T)``, ``verify(V, F, mesh)`` or ``verify(surface, mesh)``, which checks the mesh's boundary
    triangles and labels, too. Decided exactly, whoever made the mesh. bool() of the answer is the verdict.

    max_move: how far vertices may have moved, relative to the diagonal. allow_branches: for meshes of
    on_infeasible="branch". geometry_only: compare coordinates, not numbers, of vertices; None: as the Surface says.

    Raises Limit, UsageError, KeyboardInterrupt.
    """
    if isinstance(V, (Surface, CleanUp)):
        surface, V2, T = _surface(V, None), F, V2
    else:
        surface = _surface(V, F)
    if isinstance(V2, Mesh):
        if T is not None:
            raise UsageError("Give a Mesh, or V2 and T; not both.")
        mesh = V2 if isinstance(V, (Surface, CleanUp)) else Mesh(V2.V, V2.T)
    elif T is None:
        raise UsageError("T is missing: give V2 and T, or a Mesh.")
    else:
        mesh = Mesh(V2, T)
    if geometry_only is None:
        geometry_only = not surface.has_vertex_order
    if not 0 <= max_move <= 1:
        raise UsageError(f"max_move is {max_move}; it must be from 0 to 1.")
    found = _core.verify(surface_dict(surface), mesh_dict(mesh, strict=False),
                         {"max_move": float(max_move), "allow_branches": bool(allow_branches),
                          "geometry_only": bool(geometry_only)}, _run(threads, time_limit, memory_limit))
    found["quality"] = quality_of(found["quality"])
    return Verification(**found)


def repair(V: Any, F: Any = None, max_move: float = .06, *, threads: int = 0, time_limit: Optional[float] = None,
           memory_limit: Optional[float] = None, progress: Progress = None, log: Log = None) -> Repair:
    """A surface that has a tet mesh, near one that has none: a few vertices of V (#V x 3) moved a little, each by
    `max_move` at most, relative to the diagonal of the bounding box. F (#F x 3) stays. A surface that has a mesh comes
    back as it is. (``tetrahedralize(V, F, on_infeasible="repair")`` keeps the mesh, too.)

    Raises as tetrahedralize does.
    """
    surface = surface_dict(_surface(V, F))
    if not 0 <= max_move <= 1:
        raise UsageError(f"max_move is {max_move}; it must be from 0 to 1.")
    made = _core.repair(surface["V"], surface["F"], float(max_move),
                        _run(threads, time_limit, memory_limit, progress, log))
    made["report"] = json.loads(made["report"])
    return Repair(**made)


def embed(V: Any, F: Any = None, *, threads: int = 0, time_limit: Optional[float] = None,
          memory_limit: Optional[float] = None, progress: Progress = None, log: Log = None) -> Embedding:
    """The surface (V: #V x 3, F: #F x 3, or a Surface) without crossings: the same triangles with nearly the same lengths
    and areas, intersecting nowhere, which is checked exactly. Works for any genus, and where there is no tet mesh.
    Components that cross each other are laid side by side first.

    Raises BadInput, Unsolved, Limit, UsageError, KeyboardInterrupt.
    """
    surface = surface_dict(_surface(V, F))
    made = _core.embed(surface["V"], surface["F"], _run(threads, time_limit, memory_limit, progress, log))
    made["report"] = json.loads(made["report"])
    return Embedding(**made)


def clean_up(V: Any, F: Any = None, *, strict: bool = False, allow_open: bool = False, places: int = 10,
             threads: int = 0, time_limit: Optional[float] = None,
             memory_limit: Optional[float] = None) -> CleanUp:
    """A raw surface (V: #V x 3, F: #F x 3, or a Surface) made closed, oriented and manifold, where that changes no
    shape; the program `overtet` does so with every file. A surface that needs no clean-up comes back as it was, to
    the bit. docs/raw-surfaces.md says what each step guarantees.

    strict: what would be mended raises, too. allow_open: holes and the like are left. places: how many of each kind of
    defect are listed.

    Raises BadInput for what cannot be mended, Limit, UsageError, KeyboardInterrupt.
    """
    given = _surface(V, F)
    surface = surface_dict(given)
    made = _core.clean_up(surface.pop("V"), surface.pop("F"), surface,
                          {"strict": bool(strict), "allow_open": bool(allow_open), "places": int(places)},
                          _run(threads, time_limit, memory_limit))
    return clean_up_of(CleanUp, given, made)


def prepare(V: Any, F: Any = None, *, all: bool = False, weld: Optional[float] = None,
            close_cracks: Optional[bool] = None, remove_small: Optional[int] = None, largest: Optional[bool] = None,
            fill_holes: Optional[int] = None, collapse_needles: Optional[bool] = None,
            tolerance: Optional[float] = None, needle_degrees: Optional[float] = None,
            allow_crossings: Optional[bool] = None, places: Optional[int] = None, threads: int = 0,
            time_limit: Optional[float] = None, memory_limit: Optional[float] = None,
            progress: Progress = None, log: Log = None) -> Prepared:
    """A raw surface (V: #V x 3, F: #F x 3, or a Surface) after steps that change its shape, each asked for, in this
    order: weld (vertices of borders that are no farther apart become one), close_cracks, remove_small (components of
    fewer faces), largest (keep that component only), fill_holes (of at most so many edges), collapse_needles. all: all
    that suit any surface; what is given besides counts more. Lengths are relative to the diagonal.
    docs/raw-surfaces.md says what each step guarantees.

    What is wrong still is in `remaining`. Raises BadInput, Limit, UsageError, KeyboardInterrupt.
    """
    given = _surface(V, F)
    surface = surface_dict(given)
    steps = {"all": bool(all), "weld": weld, "close_cracks": close_cracks, "remove_small": remove_small,
             "largest": largest, "fill_holes": fill_holes, "collapse_needles": collapse_needles,
             "tolerance": tolerance, "needle_degrees": needle_degrees, "allow_crossings": allow_crossings,
             "places": places}
    made = _core.prepare(surface.pop("V"), surface.pop("F"), surface, steps,
                         _run(threads, time_limit, memory_limit, progress, log))
    more = {key: made.pop(key) for key in ("steps", "moved", "remaining")}
    return clean_up_of(Prepared, given, made, **more)


def read(path: Path) -> Surface:
    """The surface in a file: OBJ, OFF, PLY, STL, glTF, VTP, VTU, VTK, MEDIT or Gmsh. As the file has it: give it to
    `clean_up` before `tetrahedralize`, as the program does. "-": standard input.

    Raises BadInput (the message names the line), FileError.
    """
    return Surface(**_core.read_surface(os.fsencode(path), _run()))


def read_mesh(path: Path, format: str = "") -> Mesh:
    """The tet mesh in a file, with all that the file says besides. format: "medit", "msh22", "msh41", "vtu",
    "tetgen", "abaqus" or "vtk"; empty: as the name ends.

    Raises BadInput, FileError, UsageError.
    """
    return _mesh(_core.read_mesh(os.fsencode(path), format, _run()))


def write(path: Path, what: Union[Surface, CleanUp, Repair, Mesh], format: str = "", order: int = 1) -> None:
    """Writes a Mesh or a surface. The name says how: .mesh, .msh, .vtu, .node, .inp, .vtk for meshes, also with .gz;
    .off, .obj, .ply for surfaces. format: as `read_mesh`, of meshes. order: 2: tets with ten vertices.

    The file appears whole or not at all, and is the one that the program would write. Raises FileError, UsageError,
    BadInput (numbers of vertices out of range).
    """
    if isinstance(what, Mesh):
        mesh = mesh_dict(what)
        _core.write_mesh(os.fsencode(path), format, int(order), mesh, _run())
        return
    if isinstance(what, Repair):
        what = Surface(what.V, what.F)
    if isinstance(what, CleanUp):
        what = what.surface
    if not isinstance(what, Surface):
        raise UsageError(f"write takes a Mesh or a Surface, not a {type(what).__name__}; overtet.Surface(V, F) makes "
                         "one.")
    if format or order != 1:
        raise UsageError("format and order are for tet meshes; the name says how a surface is written.")
    surface = surface_dict(what)
    _arrays.check_range(surface["F"], len(surface["V"]), "F")
    _core.write_surface(os.fsencode(path), surface.pop("V"), surface.pop("F"), surface, _run())


def version() -> str:
    """Of the library, for instance "0.2.0"."""
    return _core.version()


__all__ = ["tetrahedralize", "inspect", "verify", "repair", "clean_up", "prepare", "read", "read_mesh", "write",
           "version"]
