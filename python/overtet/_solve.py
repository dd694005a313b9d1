"""What meshes are for: fields and distances on them, and the mesh to compare with."""
from __future__ import annotations

from typing import Any, Callable, List, Optional, Tuple, Union

import numpy as np

from . import _arrays, _core
from ._api import Log, Progress, _choice, _mesh, _run, _surface
from ._errors import UsageError
from ._types import Field, Fused, Mesh, mesh_dict, surface_dict

Where = Union[str, int, np.ndarray]
Function = Union[float, Callable[[float, float, float], float]]


def _label(mesh: Mesh, name: str) -> int:
    for number, known in mesh.label_names.items():
        if known == name:
            return int(number)
    raise UsageError(f"The mesh has no label named {name!r}.")


def _place(where: Any, mesh: Mesh) -> Any:
    """None (all of the boundary), a label's number, or an array of vertices."""
    if isinstance(where, str):
        return None if where == "all" else _label(mesh, where)
    if isinstance(where, (int, np.integer)) and not isinstance(where, bool):
        return int(where)
    vertices = np.atleast_1d(np.asarray(where))
    if vertices.ndim != 1 or vertices.dtype.kind not in "iu" or not vertices.size:
        raise UsageError(f"{where!r} is no place: give 'all', the number or name of a label, or an array of vertices.")
    return vertices.astype(np.int64)


def _conditions(given: Any, name: str, mesh: Mesh, read: Callable[[Any, str], Any]) -> List[Tuple[Any, Any]]:
    """Pairs (where, function), what stands for a function read by `read`."""
    out = []
    for pair in given or ():
        try:
            where, function = pair
        except (TypeError, ValueError):
            raise UsageError(f"{name} takes pairs (where, function), not {pair!r}.") from None
        out.append((_place(where, mesh), read(function, name)))
    return out


def _function(given: Any, name: str) -> Any:
    if callable(given):
        return given
    try:
        return float(given)
    except (TypeError, ValueError):
        raise UsageError(f"{name} takes numbers and functions of x, y and z, not {given!r}.") from None


def solve(mesh: Mesh, equation: str = "laplace", *, values: Any, fluxes: Any = (), source: Optional[Function] = None,
          order: int = 1, threads: int = 0, time_limit: Optional[float] = None, memory_limit: Optional[float] = None,
          progress: Progress = None, log: Log = None) -> Field:
    """A field on a tet mesh, by finite elements: "laplace", "poisson" (-Laplace(u) = source) or "biharmonic"
    (Laplace(Laplace(u)) = source). Where the mesh overlaps itself, the field has a value in each layer.

    values: pairs (where, function): u there; later ones count where they meet. fluxes: pairs (where, function): the
    derivative along the outer normal, 0 elsewhere; they add up. where: "all" (of the boundary), a label's number or name,
    or, of values, an array of vertices. function: a number, or a function of x, y and z. order: 1, or 2 with nodes in the
    middle of edges. Values are needed somewhere in every component.

    Raises UsageError, BadInput, Unsolved, Limit, KeyboardInterrupt, and what the functions raise.
    """
    _choice("equation", equation, ["laplace", "poisson", "biharmonic"])
    if order not in (1, 2):
        raise UsageError(f"order is {order}; it must be 1 or 2.")
    options = {"equation": equation, "order": int(order), "values": _conditions(values, "values", mesh, _function),
               "fluxes": _conditions(fluxes, "fluxes", mesh, _function),
               "source": None if source is None else _function(source, "source")}
    return Field(**_core.solve(mesh_dict(mesh), options, _run(threads, time_limit, memory_limit, progress, log)))


class Distances:
    """Geodesic distances inside a solid, which overlaps do not shorten, by the heat method [Crane, Weischedel, Wardetzky
    2013]. Made once for a mesh, for any number of sources:

        distances = overtet.Distances(mesh)
        distances.distances_from([0])          # #V; infinity where no way leads

    smoothing: of the heat's time, in squares of the mean edge length, from .5 on.
    Raises UsageError, BadInput, Unsolved, Limit, KeyboardInterrupt.
    """

    def __init__(self, mesh: Mesh, *, smoothing: float = 1, threads: int = 0, time_limit: Optional[float] = None,
                 memory_limit: Optional[float] = None, progress: Progress = None, log: Log = None) -> None:
        given = mesh_dict(mesh)
        self._mesh = mesh
        self._solver = _core.Distances(given["V"], given["T"], float(smoothing),
                                       _run(threads, time_limit, memory_limit, progress, log))

    def distances_from(self, where: Where, *, threads: int = 0, time_limit: Optional[float] = None,
                       memory_limit: Optional[float] = None) -> np.ndarray:
        """By vertex, the distance from the nearest vertex of a place: "all" (the boundary), a label's number or name, or
        an array of vertices; a list, so that the number of a vertex is not that of a label."""
        place = _place(where, self._mesh)
        if place is None or isinstance(place, int):
            if self._mesh.boundary is None:
                raise UsageError("This mesh has no boundary triangles; give vertices.")
            boundary = self._mesh.boundary
            if place is not None:
                if self._mesh.labels is None or not (self._mesh.labels == place).any():
                    raise UsageError(f"No triangle of the mesh has the label {place}.")
                boundary = boundary[self._mesh.labels == place]
            place = np.unique(boundary)
        return self._solver.distances_from(place, _run(threads, time_limit, memory_limit))


def fused(V: Any, F: Any = None, *, improve: float = 17, threads: int = 0, time_limit: Optional[float] = None,
          memory_limit: Optional[float] = None, progress: Progress = None, log: Log = None) -> Fused:
    """The mesh that others make of a surface (V: #V x 3, F: #F x 3, or a Surface) that passes through itself, to compare
    with: of all places that it winds around a positive number of times; what overlaps is glued. improve: as
    `tetrahedralize`.

    Raises BadInput, Unsolved, Limit, UsageError, KeyboardInterrupt.
    """
    surface = surface_dict(_surface(V, F))
    made = _core.fused(surface.pop("V"), surface.pop("F"), surface, float(improve),
                       _run(threads, time_limit, memory_limit, progress, log))
    made["mesh"] = _mesh(made["mesh"])
    return Fused(**made)
