// Everything that can be said about a surface before any mesh is made: what `overtet inspect` prints and what
// a run decides its way by. All decisions are exact.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/pipeline/unit_box.h"
#include "src/report/report.h"
#include "src/surface/hinges.h"
#include "src/surface/topology.h"
#include "src/surface/witness.h"
#include "src/surface/wound_edges.h"

namespace overtet {

struct Inspection {
  TopologyCheck topology;
  std::vector<Index> faces_without_area;  // up to the rounding of their coordinates
  std::vector<bool> inward;               // of each component: encloses a negative volume
  std::vector<FacePair> pairs;            // sorted; what follows is filled only when nothing above is wrong
  std::vector<Hinge> hinges;
  WindingRange winding;
  WoundEdges wound;  // edges that a mesh must wind around once more, because of the hinges
  std::optional<UnitBox> box;

  std::optional<Error> problem;          // why no mesh can be made: bad_input or infeasible
  std::optional<WitnessRecord> witness;  // where the problem is that no mesh exists
};

// Errors: limit, interrupted. What is wrong with the surface is a finding, not an error.
Result<Inspection> inspect(const Surface& surface, const RunContext& context);

InputRecord input_record(const Surface& surface, const Inspection& inspection);

// One sentence about what to expect or do.
std::string advice(const Inspection& inspection);

}  // namespace overtet
