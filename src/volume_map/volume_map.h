// The volume map (Sacht et al. 2013, section 3, step 4): from the tet mesh of the embedding U0 to one whose
// boundary is the input V0, every tet exactly positive, one turn around every interior edge.
//
// How, and why not as in the paper: the paper deforms with the boundary fixed and hopes that no tet is
// inverted; untangling afterwards finds nothing at hinges (see hinges.md of the design notes). Here the mesh
// starts as it is, on U0, where every tet is positive and every interior edge makes one turn, and both stay
// so at every moment:
//   1. branch: where edges must be wound (hinges), the boundary is pulled to V0 weakly while the interior
//      dihedral angles of the boundary edges around, summed over their tets and so unwrapped, are driven to
//      theta_e + 2 pi k_e;
//   2. pull: the boundary vertices that are not at their places are pulled with growing force, by barrier
//      Newton steps on the patches around them; between the steps the mesh is improved locally (edge removal,
//      flips, collapses), vertices that can go home in one move do, and the stars of those that resist are
//      refined.
// All moves are straight ones on which every tet is positive all the way, one vertex at a time or a patch
// together, so no edge can gain a turn. Measured: with the wound edges known, starting from U0 solves models
// on which starting from V0 with inverted tets and untangling them does not come to a positive state.
//
// Where no mesh of V0 exists, the same finds one near it (largest_move): what is locked ends as near to its
// place as it gets. src/pipeline repairs surfaces that way.
//
// What it cannot do: reach V0 when U0 is far away and the way is blocked (thin parts between others), or
// when a dihedral angle at V0 is nearly 0 or 2 pi. The answer is then an error that says how many vertices
// did not reach their places, and where.
//
// Patches are moved at the same time, the rest is one thread's. Deterministic: same bytes on any number.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/covering/wound_edges.h"

namespace overtet {

// More than 12 members: flat options, which callers set by name.
struct VolumeMapOptions {
  int interior_rings = 4;  // free around vertices that are not at their places
  double first_pull = 0.03, pull_growth = 2.5, largest_pull = 1e5;  // relative to the shape energy of a tet
  double branch_pull = 0.01;
  double angle_weight = 10;  // of squared radians, branch stage
  int branch_rounds = 25;
  int rounds = 80;
  int refinements = 5;  // of all stars that resist
  // The most that Newton steps may cost: entries of their factors, and 100 a tet; one to two minutes on one
  // thread. Counted, not timed: the same result on every machine.
  double work = 2e9;
  double seconds =
      1e9;  // of wall time: for runs with a time limit; what there is by then is taken as the end
  // > 0: places that cannot be reached are no error. The boundary ends near them, with few vertices away from
  // their places, and none further away than this, if that can be; infinite: as few as can be.
  double largest_move = 0;
  // What is further away than largest_move is brought nearer, at the cost of others, before anything is
  // pulled home; where that does, nothing is pulled.
  bool spread_first = false;
  // Called when the map locks, before the error is returned: the mesh as it is, every tet positive, and the
  // boundary vertices that did not reach their places.
  std::function<void(const TetMesh& mesh, const std::vector<Index>& away)> on_locked;
  int spread_rounds = 60;  // to bring those that are further away nearer, at the cost of others

  Status validate() const;
};

struct VolumeMapRound {
  Index away = 0;       // boundary vertices not at their places
  double farthest = 0;  // the largest distance of one, relative to the edges around it
  double pull = 0;
  double angle_error = 0;  // largest, radians; 0 when no angle is driven
  Index tets = 0;
  double seconds = 0;
};

struct VolumeMapResult {
  TetMesh mesh;             // the first rows are V0, bit for bit (all but `away`)
  Index away_at_start = 0;  // boundary vertices whose places in U0 and V0 differ
  std::vector<Index> away;  // at the end, sorted; empty without largest_move
  double farthest = 0;      // the largest distance of one from its place
  Index refinements = 0;    // vertices added
  std::int64_t newton_steps = 0;
  double work = 0;           // as in the options
  bool cut_by_time = false;  // by `seconds`: on another machine it may end elsewhere
  std::vector<VolumeMapRound> rounds;
  double seconds = 0;
};

// mesh: of stage tet_mesh, boundary U0. target: V0, as many rows as mesh.surface_vertices.
// wound: the edges with more than the angle that V0 shows; empty when not known.
// Errors: unsolved (names how many vertices or tets are left and where), limit, interrupted, usage.
Result<VolumeMapResult> volume_map(const TetMesh& mesh, const VertexMatrix& target,
                                   std::span<const WoundEdge> wound, const VolumeMapOptions& options,
                                   const RunContext& context);

// Boundary at V0 (all but `away`), exactly positive, one turn around every interior edge. Where assertions
// are on, volume_map() checks it itself.
Status check_postconditions(const VolumeMapResult& result, const VertexMatrix& target);

}  // namespace overtet
