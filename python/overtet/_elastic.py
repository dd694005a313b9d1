"""Elastic bodies on tet meshes, all frames at once or one by one."""
from __future__ import annotations

import time
from typing import Any, Callable, List, Optional, Sequence, Tuple

import numpy as np

from . import _arrays, _core
from ._api import Log, Progress, _choice, _run
from ._errors import Limit, UsageError
from ._solve import _conditions
from ._types import ElasticResult, ElasticStep, Mesh, mesh_dict

_MATERIALS = ["neo-hookean", "corotated", "st-venant-kirchhoff"]


def _numbers(given: Any, name: str, count: int) -> List[float]:
    try:
        numbers = [float(x) for x in given]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) != count:
        raise UsageError(f"{name} is {given!r}; it must be {count} numbers.")
    return numbers


def _vectors(given: Any, name: str, mesh: Mesh, optional: bool = False) -> List[Tuple[Any, Any]]:
    def read(function: Any, name: str) -> Any:
        if callable(function) or (optional and function is None):
            return function
        return _numbers(function, f"A vector of {name}", 3)
    return _conditions(given, name, mesh, read)


class Elastic:
    """An elastic body on a tet mesh, moved frame by frame. Where the mesh overlaps itself, layers move by themselves; they
    do not collide. No tet is ever flat or flipped.

        body = overtet.Elastic(mesh, held=[("tail", None)], gravity=(0, 0, -9.81), young=1e5, density=1000, dynamic=True)
        step = body.step()
        body.places                                # #V x 3

    material: "neo-hookean" (the stable law of Smith, de Goes, Kim 2018), "corotated" or "st-venant-kirchhoff". young, poisson
    (0 to .499), density, gravity, time: in any units that go together. damping: Rayleigh's factors of mass and stiffness.

    held: pairs (where, displacement): None (fixed), three numbers, or a function of x, y, z (at the start) and t that gives
    three; later ones count where they meet. tractions: pairs (where, force per area at rest). forces: pairs (vertices, force
    at each). where: "all" (of the boundary), a label's number or name, or an array of vertices. rest: #V x 3, another shape
    of the same tets, without stress.

    dynamic: motion, from rest or from `velocities` (#V x 3), by implicit steps in time ("euler", or "bdf2", which damps
    less); otherwise each step finds an equilibrium, at the times 1/frames to 1. method: "newton" (the default), or
    "quasi-newton", which factors one matrix only: quick frames, for instance with tolerance=1e-3. tolerance: of the forces
    left over, relative to those in the tets. iterations: the most a frame may have; motion goes on after them.

    Raises UsageError, BadInput, Unsolved, Limit, KeyboardInterrupt, and what the functions raise.
    """

    def __init__(self, mesh: Mesh, *, material: str = "neo-hookean", young: float = 1, poisson: float = .3, density: float = 1,
                 gravity: Sequence[float] = (0, 0, 0), damping: Sequence[float] = (0, 0), held: Any = (), tractions: Any = (),
                 forces: Any = (), rest: Any = None, dynamic: bool = False, integrator: str = "euler", velocities: Any = None,
                 step: float = .01, frames: int = 1, method: Optional[str] = None, tolerance: float = 1e-8,
                 iterations: int = 200, threads: int = 0, time_limit: Optional[float] = None,
                 memory_limit: Optional[float] = None) -> None:
        if method is not None:
            _choice("method", method, ["newton", "quasi-newton"])
        for name, number in (("frames", frames), ("iterations", iterations)):
            if int(number) != number or not 1 <= number < 2**31:
                raise UsageError(f"{name} is {number}; it must be a whole number from 1 on.")
        options = {
            "material": _choice("material", material, _MATERIALS), "young": float(young), "poisson": float(poisson),
            "density": float(density), "gravity": _numbers(gravity, "gravity", 3), "damping": _numbers(damping, "damping", 2),
            "held": _vectors(held, "held", mesh, optional=True), "tractions": _vectors(tractions, "tractions", mesh),
            "forces": _vectors(forces, "forces", mesh), "rest": None if rest is None else _arrays.points(rest, "rest"),
            "velocities": None if velocities is None else _arrays.points(velocities, "velocities"), "dynamic": bool(dynamic),
            "integrator": _choice("integrator", integrator, ["euler", "bdf2"]), "method": method, "step": float(step),
            "frames": int(frames), "tolerance": float(tolerance), "iterations": int(iterations)}
        self._threads, self._memory_limit = threads, memory_limit
        self._body = _core.Elastic(mesh_dict(mesh), options, _run(threads, time_limit, memory_limit))

    def step(self, *, time_limit: Optional[float] = None) -> ElasticStep:
        """The next frame. After an error everything is as before."""
        return ElasticStep(**self._body.step(_run(self._threads, time_limit, self._memory_limit)))

    def move_held(self, vertices: Any, places: Any) -> None:
        """From now on these vertices, which are held, go to these places (a row each) by the next frame and stay there,
        whatever their displacement was to be."""
        given = np.atleast_1d(np.asarray(vertices))
        if given.ndim != 1 or given.dtype.kind not in "iu":
            raise UsageError("vertices must be an array of vertices.")
        self._body.move_held(given.astype(np.int64), np.ascontiguousarray(_arrays.points(places, "places"), np.float64))

    @property
    def places(self) -> np.ndarray:
        """#V x 3."""
        return self._body.places()

    @property
    def velocities(self) -> np.ndarray:
        """#V x 3."""
        return self._body.velocities()

    @property
    def time(self) -> float:
        return self._body.time()

    def von_mises(self) -> np.ndarray:
        """Of Cauchy's stress: #T."""
        return self._body.von_mises()

    def von_mises_at_vertices(self) -> np.ndarray:
        """The mean of the tets around each vertex, by volume: #V."""
        return self._body.von_mises_at_vertices()


def elastic(mesh: Mesh, *, frames: int = 1, each_frame: Optional[Callable[[Elastic, ElasticStep], None]] = None,
            time_limit: Optional[float] = None, progress: Progress = None, log: Log = None, **options: Any) -> ElasticResult:
    """All frames of an elastic body: `Elastic` says what the options are. each_frame: is called with the body and the step
    after each."""
    _run(0, time_limit, None, progress, log)
    end = None if time_limit is None else time.monotonic() + time_limit
    body = Elastic(mesh, frames=frames, time_limit=time_limit, **options)
    steps: List[ElasticStep] = []
    for frame in range(int(frames)):
        if progress is not None:
            progress("elastic", frame / frames)
        left = None if end is None else end - time.monotonic()
        if left is not None and left <= 0:
            raise Limit(f"The time limit of {time_limit:g} s was reached.")
        steps.append(body.step(time_limit=left))
        if each_frame is not None:
            each_frame(body, steps[-1])
    return ElasticResult(V=body.places, velocities=body.velocities, von_mises=body.von_mises(), steps=steps)
