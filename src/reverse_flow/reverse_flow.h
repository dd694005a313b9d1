// Reverse flow: gives the surface back its shape, from V_t* on, without ever passing through itself
// (paper, sections 3 and 4).
//
// Rest shapes W: the stored states of the forward flow backwards and V0 last (staged, as in the paper), or
// V0 alone (direct). For each W, with E the spokes-and-rims ARAP energy of W, iterate from U:
//
//   rotations    best fit of every vertex's one-ring (kernels/arap), in parallel;
//   contacts     every vertex-triangle and edge-edge pair *without a common vertex* that is closer than
//                dhat (kernels/contact);
//   energy       E(U) + sum kappa h^2 b(d / dhat) + |U - U_before|^2_M / (2 eps^2), M relative to the area;
//   step         P = -Q^-1 gradient, Q = L_W + M / eps^2 + sum kappa h^2 / dhat^2 b'' w w'. The contact part
//                is a *scalar* positive matrix, the same for x, y and z: measured, it beats the
//                true one (which is stiff along the normal only) in time and in quality;
//   line search  where the step would hit something, halve it on a ramp of six rings around; then
//                everywhere; at last hold the vertices concerned back (a roll-back).
//
// A step is accepted only when every primitive pair without a common vertex keeps a tenth of its distance on
// the whole straight way (conservative continuous check: nothing tunnels, no knot changes) *and* the exact
// test at the end finds no intersecting faces. Where the two could disagree, by rounding, exactness wins.
//
// Differences from the paper, because they measure better: pins and repulsion lock (a finger stays
// collapsed; 9-29 s at 9.6k faces) where the barrier recovers within 1 % to 10 % of the area in a few
// seconds; the direct way works on most models in a fraction of the staged time. The paper's parts are
// there, each on its own: ContactResponse::pins, inertia, repulsion, staged rest shapes, a rigid motion after
// each stage. Pins are the paper's to the letter: after each step all pairs of faces are tested exactly, the
// vertices of those that intersect are put back and held, and the step is solved again, until none do;
// between two states faces may pass through each other.
//
// Outcomes are chaotic: a small change of settings turns a good result bad. So: cheap first (direct), detect
// locking early, fall back to the next elements of the two ladders (see forward_flow.h), keep the U0 with
// the best `quality.area_p01`.
//
// Guaranteed when it returns a value:
//  - U0 is finite and exactly free of self-intersections, and with the barrier it is connected to the start
//  by
//    a motion that is free of them (up to the rounding of the continuous check), unless `aligned` moved it
//    rigidly.
//  - Vertices that were not free have their rest positions, bit for bit.
//  - The same bytes on any number of threads.
// Errors: bad_input (start not finite, or not free of intersections), limit, interrupted, internal. When
// the time limit strikes, nothing is returned: a caller that prefers a worse U0 sets `max_seconds`.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

// More than 12 members: flat options, which callers set by name.
struct ReverseFlowOptions {
  enum class ContactResponse { barrier, pins };
  ContactResponse response = ContactResponse::barrier;

  bool staged = false;         // through the stored states, backwards; else straight to V0
  int stage_iterations = 12;   // per stored state
  int max_stages = 24;         // stored states used at most, evenly chosen
  int final_iterations = 100;  // at V0
  double eps = 0.5;            // simulation time step; the mass of the whole surface is 1
  bool inertia = false;        // (U - 2 U' + U'') / eps^2 as in the paper; else drag only

  double kappa = 1;         // barrier stiffness
  double reach = 0.4;       // dhat in local mean edges of W,
  double growth = 4;        // but of at most so many present ones: collapsed parts unfold faster, lock less
  double ring_reach = 0.5;  // one-ring neighbours: at most this part of their distance at rest,
  double ring_floor = 0.1;  // at least so many mean edges

  // Of pins: the weight of the difference of the barycentres of faces that would meet, which pushes their
  // vertices apart in the next step; the paper: 1 to 1000. Times the masses; and as the paper says nothing of
  // its units, a force moves a free vertex at most so many mean edges.
  double repulsion = 0, repulsion_cap = 1;

  int ramp_rings = 6;  // the local halving fades out over so many rings
  int ramp_halvings = 6;
  int global_halvings = 4;
  // Stop a stage when no vertex moves further than this part of its mean edge. Small on purpose: ARAP
  // creeps, and stopping early was measured to be worse than iterating on.
  double still = 1e-5;
  double stage_still = 0;     // the same for stages but the last, held vertices or not
  bool align = true;          // if everything was free: the rigid motion that fits U0 to V0 best
  bool align_stages = false;  // and after each stage the one that fits U_t to V_t
  // Stop iterating then and return what there is. Work: free faces and contacts, summed over iterations and
  // attempts of their line searches; the same on every machine.
  double max_work = 1e18;
  double max_seconds = 1e9;  // for runs with a time limit

  // A healthy flow shortens steps now and then; one that does it so often in one iteration for so many
  // iterations in a row has locked: it ends, and the caller should try another way.
  int lock_halvings = 3;
  int lock_iterations = 12;
  // Also called locked: more vertices held back than this (summed over all steps), or a smallest percentile
  // of the area below this.
  int locked_rollbacks = 0;
  double locked_area_p01 = 0.1;

  // Called with every accepted state, for tests and pictures.
  std::function<void(const VertexMatrix&)> on_state;

  Status validate() const;
};

// Everything as in the paper: staged, pins, dynamics, repulsion.
ReverseFlowOptions paper_reverse_flow();
// What to try in turn, element i after element i of forward_flow_ladder().
std::vector<ReverseFlowOptions> reverse_flow_ladder();

struct ReverseFlowStep {
  int stage = 0;      // 0: the first rest shape
  int iteration = 0;  // from 1
  Index contacts = 0;
  double energy = 0;   // ARAP, before the step, relative to the area
  double move = 0;     // largest step of a vertex in mean edges, after the line search
  int halvings = 0;    // of the line search, local and global; of pins: solves after the first
  Index held = 0;      // vertices held back at last; of pins: all that were put back
  double seconds = 0;  // since the start of the flow, wall clock
};

// Ratios U0 / V0.
struct FlowQuality {
  double area_p01 = 1, area_p50 = 1, area_p99 = 1;  // of faces
  double edge_p01 = 1, edge_p50 = 1, edge_p99 = 1;
  double area_within_20 = 1;  // part of the faces whose ratio is in [0.8, 1.2]
};
FlowQuality measure_quality(const VertexMatrix& U, const VertexMatrix& V0, const TriangleMatrix& F);

struct ReverseFlowResult {
  enum class Termination { nothing_to_do, finished, locked, work, time };
  Termination termination = Termination::finished;
  VertexMatrix U0;  // #V x 3, for the faces of the input
  FlowQuality quality;
  std::vector<ReverseFlowStep> steps;
  int iterations = 0;
  double work = 0;      // as in the options
  Index rollbacks = 0;  // sum of held
  bool locked = false;  // try another way, if there is one
  bool aligned = false;
  double worst_face = 1;  // smallest area ratio of all faces
};

// surface: the input V0, F. start: V_t*, free of intersections. stages: the states V_t between V0 and
// V_t*, in the order of the forward flow (used when options.staged). free: by vertex, who may move;
// others are at V0 in start and in every stage.
Result<ReverseFlowResult> reverse_flow(const Surface& surface, const VertexMatrix& start,
                                       std::span<const VertexMatrix> stages, const std::vector<char>& free,
                                       const ReverseFlowOptions& options, const RunContext& context);

// What a caller may rely on, checked from scratch (one full exact intersection test).
Status check_postconditions(const Surface& surface, const std::vector<char>& free,
                            const ReverseFlowResult& result);

}  // namespace overtet
