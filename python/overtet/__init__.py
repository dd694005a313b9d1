"""Tet meshes of closed triangle surfaces that pass through themselves.

    import overtet

    surface = overtet.clean_up(overtet.read("hand.obj"))
    mesh = overtet.tetrahedralize(surface)        # or tetrahedralize(V, F)
    mesh.V, mesh.T                                # float64 #V x 3, int32 #T x 4
    overtet.write("hand.vtu", mesh)

Arrays are numpy's; anything that numpy makes an array of is taken. Functions may be called from several threads at
once, and print nothing. docs/python.md says more.
"""
from ._api import clean_up, embed, inspect, prepare, read, read_mesh, repair, tetrahedralize, verify, version, write
from ._errors import (BadInput, Error, FileError, Infeasible, InternalError, Limit, MemoryLimit, Unsolved,
                      UsageError)
from ._elastic import Elastic, elastic
from ._skin import skinned, skinning_weights
from ._solve import Distances, fused, solve
from ._types import (CleanUp, Diagnosis, ElasticResult, ElasticStep, Embedding, Field, Fused, Mesh, Prepared, Quality, Repair,
                     Skinned, SkinningWeights, Surface, Verification)

__version__ = version()

__all__ = ["tetrahedralize", "inspect", "verify", "repair", "embed", "solve", "Distances", "fused", "skinning_weights", "skinned", "elastic", "Elastic", "clean_up", "prepare", "read", "read_mesh", "write",
           "version", "Surface", "Mesh", "Quality", "Diagnosis", "Verification", "Repair", "Embedding", "CleanUp", "Prepared",
           "Field", "ElasticResult", "ElasticStep", "Fused", "SkinningWeights", "Skinned",
           "Error", "UsageError", "BadInput", "Unsolved", "Infeasible", "Limit", "MemoryLimit", "FileError",
           "InternalError"]

for _error in (Error, UsageError, BadInput, Unsolved, Infeasible, Limit, MemoryLimit, FileError, InternalError):
    _error.__module__ = "overtet"  # what tracebacks call them
del _error
