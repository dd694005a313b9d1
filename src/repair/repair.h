// The repair stage: the smallest change of a surface that lets a positive tet mesh of it exist.
//
// What forbids a mesh is looked up exactly (src/surface/diagnose.h): places of negative winding number,
// vertices with B0 < 0, hinges that no legal edges join, faces without area. The vertices there, in
// clusters that have nothing to do with each other, are smoothed a little: first these alone by part of the
// way, then further, then with more and more rings around them, until the diagnosis no longer objects
// there. Every attempt starts from the input's positions, so nothing adds up. At the end each cluster goes
// back as far as it can, and then vertex by vertex.
//
// Guaranteed: connectivity untouched; vertices that are not listed as moved bit-identical; no vertex moved
// by more than max_relative_move; the diagnosis of the result is embedded or feasible. Same bytes on any
// number of threads, and (as long as the deadline is not what ends it) on every run.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/surface/diagnose.h"

namespace overtet {

struct RepairOptions {
  double max_relative_move = 0.06;  // of the bounding box's diagonal
  int max_rounds = 80;              // diagnoses until the surface must be feasible
  int max_shrink_rounds = 60;       // diagnoses spent on moving less
  double shrink_work = 5e4;         // and pairs of faces (plus a hundredth of the faces) looked at for that
  // Places where no mesh was found although nothing forbids one: hinges next to them are smoothed until
  // they are none, at the n-th mention of a place n steps further up the ladder.
  std::vector<Eigen::Vector3d> places;

  Status validate() const;
};

struct RepairRound {
  Index offences = 0;  // what forbids a mesh: pairs of negative winding, vertices, faces
  Index clusters = 0, open_clusters = 0;
  Index moved = 0;
  double max_relative = 0;
  std::string verdict;
};

struct RepairResult {
  Surface surface;
  Diagnosis diagnosis;       // of the repaired surface
  std::vector<Index> moved;  // sorted
  double max_relative = 0;   // the largest move over the bounding box's diagonal
  std::vector<RepairRound> rounds;
  Index shrink_rounds = 0;
  std::string termination;  // "nothing to repair", "feasible"
};

// Errors: bad_input (not closed, oriented, manifold), infeasible (what forbids a mesh could not be smoothed
// away within the allowed move; the message says where), limit, interrupted.
Result<RepairResult> repair(const Surface& surface, const RepairOptions& options, const RunContext& context);

}  // namespace overtet
