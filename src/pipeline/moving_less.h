// A step of repairs that moved vertices further than is allowed: less far, in rounds.
//
// What a pull leaves away from its place is held by the tets around it. Among others (the mesh improved, or
// the surface meshed anew) it is free again, and is pulled once more: the farthest come nearer at the
// cost of others. Then straight back, vertex by vertex, as far as the diagnosis does not object
// (src/repair/lessening.h).
//
// Work is counted, not timed, except where the run has a time limit: then that is noted.
#pragma once

#include "overtet/result.h"
#include "src/pipeline/repair_job.h"

namespace overtet {

// best: becomes what costs less (repair_job.h), if anything is found. Errors: limit, interrupted.
Status move_less(const RepairJob& job, RepairedMesh& best);

}  // namespace overtet
