"""What overtet raises."""
from __future__ import annotations

import json
from typing import Any, Optional, Tuple


class Error(Exception):
    """What every exception of overtet is.

    ``code`` is the exit code that the program ``overtet`` has for it; ``message`` one sentence: what is wrong, where,
    and what to do about it; ``place`` where, as (x, y, z), if it is in one place; ``reason`` what more is known
    ("exhausted", "endless", "time_limit", "memory_limit" or ""); ``face`` the face at fault, a row of F, or -1;
    ``report`` what the run did, a dict, or None.
    """

    code = 70
    message: str = ""
    place: Optional[Tuple[float, float, float]] = None
    reason: str = ""
    face: int = -1
    report: Optional[dict] = None

    def __init__(self, message: str = "") -> None:
        super().__init__(message)
        self.message = message

    def __str__(self) -> str:
        return self.message

    def __reduce__(self) -> Any:
        return type(self), (self.message,), self.__dict__


class UsageError(Error, ValueError):
    """Arguments contradict each other, are out of range, or arrays have a wrong shape or type."""
    code = 2


class BadInput(Error, ValueError):
    """No surface that can be meshed: not closed, not oriented, an index out of range, a coordinate that is not finite.
    The message names the element. ``overtet.clean_up`` and ``overtet.prepare`` mend much of it."""
    code = 3


class Unsolved(Error):
    """No mesh was found, and nothing proves that there is none."""
    code = 4


class Infeasible(Error):
    """No such mesh exists.

    ``certificate`` is the proof, a dict with the keys that README ("The report") explains, or None where only a part
    of the surface is known to have no mesh; ``explanation`` says it in a sentence. ``on_infeasible="repair"`` moves a
    few vertices a little, so that there is one.
    """
    code = 5
    certificate: Optional[dict] = None
    explanation: str = ""


class Limit(Error):
    """The time limit was reached, or there is not enough memory (then it is a MemoryLimit)."""
    code = 6


class MemoryLimit(Limit, MemoryError):
    """The memory limit was reached, or there is no more memory."""


class FileError(Error, OSError):
    """A file could not be read or written, or the program overtet-tetgen not be run."""
    code = 7


class InternalError(Error, RuntimeError):
    """A bug of overtet. Please report it."""
    code = 70


_CLASSES = {2: UsageError, 3: BadInput, 4: Unsolved, 5: Infeasible, 6: Limit, 7: FileError}


def of(code: int, message: str, place: Any, reason: str, face: int, certificate: Optional[str], explanation: str,
       report: Optional[str]) -> BaseException:
    """The exception for an error of the library: called by _core."""
    if code == 130:
        return KeyboardInterrupt(message)
    kind = _CLASSES.get(code, InternalError)
    if code == 6 and reason != "time_limit":
        kind = MemoryLimit
    error = kind(message)
    error.place, error.reason, error.face = place, reason, face
    error.report = json.loads(report) if report is not None else None
    if isinstance(error, Infeasible):
        error.certificate = json.loads(certificate) if certificate is not None else None
        error.explanation = explanation
    return error
