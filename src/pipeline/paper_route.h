// Preset::paper: the recipe of Sacht et al. 2013 to the letter (sections 3 and 4), in one setting, for those
// who want the paper's own way: to compare with, or to see what each piece does. Nothing here unlocks what
// locks; src/pipeline/flow_route.h is the paper's way at its best. docs/paper.md says what is where.
//
// Parts that bound a solid of their own are taken one by one: no flow pulls two parts off each other.
#pragma once

#include "overtet/result.h"
#include "overtet/types.h"
#include "src/pipeline/meshing_job.h"

namespace overtet {

// A tet mesh of the surface, not yet checked: every tet positive without job.allowed.flips, one turn around
// every interior edge without job.allowed.branches (or flips).
// Errors: unsolved; the message says which piece ends where, and counts: vertices that are away, tets that
// are flipped, edges with two turns.
Result<TetMesh> mesh_by_paper(const MeshingJob& job);

}  // namespace overtet
