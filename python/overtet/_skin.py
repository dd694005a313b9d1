"""Skinning weights on tet meshes that overlap themselves."""
from __future__ import annotations

import dataclasses
import json
import os
from typing import Any, Dict, Optional, Tuple, Union

import numpy as np

from . import _core
from ._api import Log, Progress, _run
from ._errors import UsageError
from ._types import Mesh, Skinned, SkinningWeights, mesh_dict

HandlesGiven = Union[str, os.PathLike, Dict[str, Any]]


def _plain(value: Any) -> Any:
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    raise TypeError


def _json(given: Any, name: str) -> str:
    try:
        return json.dumps(given, default=_plain)
    except (TypeError, ValueError):
        raise UsageError(f"{name} takes dictionaries, lists, names, numbers and arrays only.") from None


def _handles(given: Any) -> Tuple[bytes, bytes]:
    """The path, or JSON."""
    if isinstance(given, (str, os.PathLike)):
        return os.fsencode(given), b""
    return b"", _json(given, "handles").encode()


def skinning_weights(mesh: Mesh, handles: HandlesGiven, *, cut_bones: bool = False, threads: int = 0,
                     time_limit: Optional[float] = None, memory_limit: Optional[float] = None, progress: Progress = None,
                     log: Log = None) -> SkinningWeights:
    """Bounded biharmonic weights [Jacobson, Baran, Popovic, Sorkine 2011] of points and bones: between 0 and 1, their sum is
    1 at each vertex. Where two layers of the mesh lie in one place, a handle in one of them has no part in the other.

    handles: what docs/handles.md describes, as a dictionary, or a file of it or of TGF (.tgf). cut_bones: cut off bones
    that leave the solid, instead of raising UsageError.

    Raises UsageError, BadInput, FileError, Unsolved, Limit, KeyboardInterrupt.
    """
    path, text = _handles(handles)
    given = mesh_dict(mesh)
    made = _core.skinning_weights(given["V"], given["T"], path, text, bool(cut_bones),
                                  _run(threads, time_limit, memory_limit, progress, log))
    for name in ("energy", "residual", "held", "cut_at"):
        made[name] = np.asarray(made[name])
    return SkinningWeights(handles=handles, **made)


def skinned(mesh: Mesh, weights: SkinningWeights, pose: Dict[str, Any], *, threads: int = 0,
            time_limit: Optional[float] = None, memory_limit: Optional[float] = None) -> Skinned:
    """The mesh in a pose, by linear blend skinning. pose: of each handle that moves, by its name, its motion: "axis" and
    "degrees", or "quaternion" (x, y, z, w), about its head, and "translation"; or "matrix" (3 x 4). Children move with their
    parents (docs/handles.md).

    Raises UsageError, BadInput, FileError, KeyboardInterrupt.
    """
    path, text = _handles(weights.handles)
    given = mesh_dict(mesh)
    numbers = np.ascontiguousarray(weights.weights, dtype=np.float64)
    if numbers.shape != (len(mesh.V), len(weights.names)):
        raise UsageError(f"The weights have the shape {numbers.shape}; it must be {(len(mesh.V), len(weights.names))}.")
    made = _core.skinned(given["V"], given["T"], path, text, numbers.ravel(), _json(pose, "pose").encode(),
                         _run(threads, time_limit, memory_limit))
    return Skinned(mesh=dataclasses.replace(mesh, V=made.pop("V")), **made)
