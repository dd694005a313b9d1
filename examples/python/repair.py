#!/usr/bin/python3
"""What to do when there is no mesh: why, the proof, and a repair that moves a few vertices a little."""
import models
import numpy as np
import overtet


def mesh_or_reason(V, F):
    """The mesh as it should be; else a mesh of a surface nearby; else None. Says what happened."""
    try:
        return overtet.tetrahedralize(V, F, time_limit=600)
    except overtet.BadInput as error:  # open, not oriented, ...: clean_up and prepare mend much of it
        print("This is no closed surface:", error)
    except overtet.Infeasible as error:
        print(error.explanation)
        print("The proof, for anyone to check: rule", error.certificate["rule"])
        return repaired(V, F)
    except overtet.Unsolved as error:
        print("No mesh was found, and nothing proves that there is none:", error)
    except overtet.Limit as error:
        print("Not within the limits:", error)
    return None


def repaired(V, F):
    for most in (.01, .06):  # of the diagonal
        try:
            mesh = overtet.tetrahedralize(V, F, on_infeasible="repair", max_move=most)
        except overtet.Infeasible as error:
            print("Not with moves of %g %%: %s" % (100 * most, error))
            continue
        print("Vertices that moved:", mesh.moved.tolist(), "by %.2f %% of the diagonal" % (100 * mesh.max_relative_move))
        return mesh
    return None


V, F = models.dented_ball()
mesh = mesh_or_reason(V, F)
print(mesh)
assert mesh is not None and mesh.status == "repaired"
assert overtet.verify(mesh.surface, mesh)  # of the repaired surface
assert overtet.verify(V, F, mesh, max_move=.06) and not overtet.verify(V, F, mesh)

open_F = np.delete(F, 7, axis=0)  # a hole
assert mesh_or_reason(V, open_F) is None
filled = overtet.prepare(V, open_F, fill_holes=10)
print(filled, [step["message"] for step in filled.steps])
assert not filled.remaining
