// The repair stage: the smallest change of a surface that lets a positive tet mesh of it exist.
//
// What forbids a mesh is looked up exactly (src/certificates/diagnose.h): places of negative winding number,
// vertices with B0 < 0, hinges that no legal edges join, faces without area. Parts that are inside out
// as a whole (a tube, a tip) are turned first; see turning.h. Then the vertices that still forbid a mesh, in
// clusters that have nothing to do with each other, are smoothed a little: first these alone by part of the
// way, then further, then with more and more rings around them, until the diagnosis no longer objects there;
// by no more than about an edge's length, and where that does not do, once more by as much as is allowed.
// Every attempt starts from the same positions, so nothing adds up. Creases in which everything crosses
// everything are smoothed as a whole. At the end each cluster goes back as far as it can, and then vertex by
// vertex.
//
// Guaranteed: connectivity untouched; vertices that are not listed as moved bit-identical; no vertex moved
// by more than max_relative_move; the diagnosis of the result is embedded or feasible. Same bytes on any
// number of threads, and (as long as the deadline is not what ends it) on every run.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/certificates/diagnose.h"

namespace overtet {

struct RepairMemory;  // how far up the ladder each vertex was

struct RepairOptions {
  double max_relative_move = 0.06;  // of the bounding box's diagonal
  // What is tried first everywhere: this much of the diagonal, or the mean edge where that is longer.
  double gentle_relative_move = 0.01;
  bool only_gently = false;    // nothing else, no parts turned: where that does not do, an error
  int max_rounds = 80;         // diagnoses until the surface must be feasible
  double turn_work = 1e5;      // pairs of faces (plus a hundredth of the faces) looked at for turning parts
  int max_shrink_rounds = 60;  // diagnoses spent on moving less
  double shrink_work = 5e4;    // and pairs of faces (plus a hundredth of the faces) looked at for that
  // Of the surface, where it is known: complete, with the whole winding range.
  const Diagnosis* diagnosis = nullptr;
  // To go on from an earlier repair of the same surface, of which no mesh was found although nothing forbids
  // one: `place` names where, and what moves there (hinges next to it, if nothing does) goes further up the
  // ladder of smoothings; without a place everything does.
  std::shared_ptr<const RepairMemory> earlier;
  std::optional<Eigen::Vector3d> place;

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
  double mean_relative = 0;  // of those that moved
  std::vector<RepairRound> rounds;
  Index turned_parts = 0;  // inside-out parts that were turned as a whole
  Index turn_rounds = 0, shrink_rounds = 0;
  std::shared_ptr<const RepairMemory> memory;
  std::string termination;  // "nothing to repair", "feasible"
};

// Errors: bad_input (not closed, oriented, manifold), infeasible (what forbids a mesh could not be smoothed
// away within the allowed move; the message says where), limit, interrupted.
Result<RepairResult> repair(const Surface& surface, const RepairOptions& options, const RunContext& context);

}  // namespace overtet
