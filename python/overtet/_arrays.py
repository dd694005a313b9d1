"""What users give, as arrays that _core takes: checked, and copied only where it must be."""
from __future__ import annotations

from typing import Any, Optional

import numpy as np

from ._errors import BadInput, UsageError

# _core copies these into the library's matrices itself, from any memory order.
_TAKEN = {np.dtype(t) for t in (np.float64, np.float32, np.int32, np.int64, np.uint64)}


def _as_array(given: Any, name: str) -> np.ndarray:
    try:
        array = np.asarray(given)
    except (ValueError, TypeError) as error:
        raise UsageError(f"{name} is no array of numbers: {error}.") from None
    if array.dtype.kind not in "fiu" or array.dtype.itemsize > 8:
        raise UsageError(f"{name} has the type {array.dtype}, which is not taken: give float64 or float32 for "
                         "coordinates, integers for numbers of vertices and labels.")
    if array.dtype not in _TAKEN or not array.flags.aligned:
        array = array.astype(np.float64 if array.dtype.kind == "f" else np.int64)
    return array


def _rows(given: Any, name: str, columns: int, what: str) -> np.ndarray:
    array = _as_array(given, name)
    if array.size == 0 and array.ndim < 2:
        return np.empty((0, columns), np.int32)
    if array.ndim != 2 or array.shape[1] != columns:
        raise UsageError(f"{name} has the shape {array.shape}; it must be {what} x {columns}.")
    if array.shape[0] > 2**31 - 1:
        raise BadInput(f"{name} has {array.shape[0]} rows; numbers of 32 bits do not reach so far.")
    return array


def points(given: Any, name: str = "V") -> np.ndarray:
    """#V x 3."""
    return _rows(given, name, 3, "#V")


def elements(given: Any, name: str, columns: int) -> np.ndarray:
    """#F x 3 or #T x 4: numbers of vertices."""
    what = "#T" if columns == 4 else "#F"
    array = _rows(given, name, columns, what)
    if array.dtype.kind == "f":
        raise UsageError(f"{name} has the type {array.dtype}; it must have integers, the numbers of vertices.")
    return array


def integers(given: Any, name: str, count: int, of: str) -> Optional[np.ndarray]:
    """A whole number for each of `count` ones, or None."""
    if given is None:
        return None
    array = _as_array(given, name)
    if array.size == 0 and count == 0:
        return np.empty(0, np.int32)
    if array.dtype.kind == "f":
        raise UsageError(f"{name} has the type {array.dtype}; it must have integers.")
    return _one_each(array, name, count, of)


def numbers(given: Any, name: str, count: int, of: str) -> Optional[np.ndarray]:
    """A number for each of `count` ones, or None."""
    return None if given is None else _one_each(_as_array(given, name), name, count, of)


def _one_each(array: np.ndarray, name: str, count: int, of: str) -> np.ndarray:
    if array.shape != (count,):
        raise UsageError(f"{name} has the shape {array.shape}; it must be ({count},), one for each {of}.")
    return array


def data(given: Any, name: str, count: int, of: str) -> dict:
    """Name -> an array of `count` rows."""
    out = {}
    for key, values in (given or {}).items():
        array = _as_array(values, f"{name}[{key!r}]")
        if array.ndim not in (1, 2) or array.shape[0] != count or (array.ndim == 2 and array.shape[1] == 0):
            raise UsageError(f"{name}[{key!r}] has the shape {array.shape}; it must have {count} rows, one for each "
                             f"{of}.")
        out[str(key)] = array if np.asarray(values).dtype != np.uint8 else np.asarray(values)
    return out


def check_range(array: np.ndarray, count: int, name: str) -> None:
    """That what is in `array` are numbers of `count` vertices."""
    if array.size and (array.min() < 0 or array.max() >= count):
        row = int(np.argmax(((array < 0) | (array >= count)).any(axis=1)))
        raise BadInput(f"{name}[{row}] is {array[row].tolist()}, but vertices count from 0 to {count - 1}.")
