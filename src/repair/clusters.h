// The sets of vertices that a repair moves by smoothing, and how far up the ladder of smoothings each is:
// from these vertices alone by a tenth of the way to many rings around them all the way. Internal to
// src/repair.
#pragma once

#include <optional>
#include <vector>

#include "overtet/types.h"
#include "src/repair/offences.h"
#include "src/repair/repair.h"
#include "src/repair/smoothing.h"

namespace overtet {

// A connected set of vertices that move, which no other set touches.
struct Cluster {
  std::vector<Index> region;  // sorted
  int level = 0;              // the highest of its vertices'
  VertexMatrix to;            // the region's positions
  double part = 1;            // how much of the way: what the end's shrinking leaves
  std::vector<Index> held;    // of the region: back at their places for good, sorted
};

// Where vertices are on the ladder: what a later repair goes on from.
struct LadderState {
  std::vector<int> level;    // of each vertex that forbids a mesh; -1 for the others
  std::vector<char> pinned;  // vertices whose clusters are not to be moved less
};

class Clusters {
 public:
  // gentle: how far a vertex moves on the gentle steps. All arguments must outlive it.
  Clusters(const Surface& input, const VertexRings& rings, const RepairOptions& options, double diagonal,
           double gentle);

  void clear();  // no vertex forbids a mesh
  void restore(const LadderState& state) { state_ = state; }
  const LadderState& state() const { return state_; }
  std::vector<Cluster>& all() { return all_; }
  const std::vector<Cluster>& all() const { return all_; }

  // The vertices of every group of offences, and those of earlier ones next to it, go one step up the ladder.
  // False: one is at the ladder's end, or at the end of the gentle steps where it may not go further: those
  // with only_gently everywhere, those near parts that were turned always (what smooths more turns them
  // back).
  bool assign(const Surface& now, const Findings& found, const std::vector<char>& turned_near);
  // After a surface of which no mesh was found: what moves at the place (the hinges near it, if nothing does)
  // goes further up; without a place everything does.
  void go_on(const VertexMatrix& base, const VertexMatrix& now, const std::vector<Index>& hinges,
             const std::optional<Eigen::Vector3d>& place);
  // Makes the clusters: what moves, and where to, starting from `base`.
  void place(const VertexMatrix& base);
  // base with all clusters' moves.
  VertexMatrix compose(const VertexMatrix& base) const;

  bool pinned(const Cluster& c) const;
  // Whether the offence touches the cluster or the rings around it.
  bool within(const Cluster& c, const Offence& o, int rings);

 private:
  void rise(Index v, int steps);
  Offence crease_around(const Surface& now, const Diagnosis& diagnosis, const Offence& seed) const;

  const Surface& input_;
  const VertexRings& rings_;
  const RepairOptions& options_;
  const double diagonal_, gentle_;
  std::vector<char> scratch_;
  LadderState state_;
  bool exhausted_ = false;
  std::vector<Cluster> all_;
};

}  // namespace overtet
