// Forward flow: smooths the surface until it no longer passes through itself (paper, sections 3 and 4).
//
// The paper flows the whole surface (conformalized mean-curvature flow [Kazhdan, Solomon, Ben-Chen 2012]):
// with L the Laplacian of the input, fixed, and M_t the lumped masses of the present surface,
//
//     (M_t + delta L) V_{t+delta} = M_t V_t,
//
// one symbolic analysis for all steps, one numeric factorisation a step. That shrinks limbs that have
// nothing to do with any intersection, and the reverse flow must then win all of it back. Measured on 27
// models, it is enough to flow only the surroundings of what crosses (40 to 99 % of the area stays at the
// input) and the reverse flow becomes 3 to 40 times faster. So:
//
//  1. Regional: intersecting faces are clustered; everything within an edge-path distance r of a cluster
//     flows, the rest stays at V0 (Dirichlet). A cluster stops as soon as it is clean and goes on when it
//     is hit. A cluster that stalls gets a larger r, and all start again from V0. Summed edge weights are
//     clamped from below, because with plain cotangents 7 of 27 models stall.
//  2. Global, when nearly everything is active or regional attempts fail: clamped, then uniform, then
//     intrinsic Delaunay weights, then small and large steps, each from V0, the surface rescaled to its
//     first area and recentred at every step. Stagnation ends a try.
//
// How the stages chain: give `V`, `states` and `reverse_free` to reverse_flow. When that reports a
// locked result, call forward_flow again with the next element of forward_flow_ladder() and
// reverse_flow with the element of the same index of reverse_flow_ladder(); keep the better U0.
//
// Guaranteed when it returns a value:
//  - V is finite and has exactly no intersecting pair of faces; frozen vertices are V0's, bit for bit.
//  - The same bytes on any number of threads.
// Errors: bad_input (not finite, no area, indices out of range, not closed and oriented), unsolved (no
// weights and no step size removed the intersections; the message has the smallest number of pairs), limit,
// interrupted.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

enum class FlowWeights { cotangent, clamped, uniform, intrinsic_delaunay };
const char* to_string(FlowWeights weights);

// One way of flowing everything.
struct GlobalFlow {
  FlowWeights weights = FlowWeights::clamped;
  double delta = 1e-4;  // time step at unit area
  int max_steps = 120;
};

// Clamped, uniform, intrinsic Delaunay weights, then uniform with large and clamped with small steps.
std::vector<GlobalFlow> default_global_flows();

// More than 12 members: flat options, which callers set by name.
struct ForwardFlowOptions {
  bool regional = true;  // false: the paper's flow of everything

  // Lengths are relative to the square root of the area, times to the area.
  double radius = 0.02;                // first r of a cluster
  double radius_edges = 3;             // but at least so many mean edges
  double radius_growth = 1.5;          // of clusters that did not become clean
  double reverse_radius = 2;           // reverse_free reaches so many r
  double max_active = 0.97;            // part of the vertices from which on the flow goes global
  double regional_delta = 4e-4;        // largest time step
  double regional_delta_radius = 0.1;  // and at most this times r^2: a step must not skip the region
  int regional_steps = 24;             // per attempt
  int regional_attempts = 14;

  double smallest_weight = 0.05;  // clamp of summed edge weights (FlowWeights::clamped)
  int stall_tests = 3;            // this many tests without
  double stall_drop = 0.05;       // such a relative drop of the number of pairs: stalled
  int global_stall_tests = 10;    // the global flow first lets limbs grow through each other
  bool test_all_pairs = false;    // global: at every step, not only those that met before until none does
  bool patient = false;           // global: it goes on however many pairs there are

  std::vector<GlobalFlow> global = default_global_flows();  // tried in this order
  int extra_steps = 0;                                      // past t*, before turning back
  int bisections = 4;       // between the last state that crosses and the first that does not, per cluster
  bool keep_states = true;  // V_t of every step, for a staged reverse flow

  Status validate() const;
};

// The paper's choice: everything, plain cotangents, delta 1e-4, all pairs tested at each step, until the
// first clean one or the last of the steps (the paper needs 10 to 20).
ForwardFlowOptions paper_forward_flow();
// What to try in turn when the reverse flow locks: the default, small regional steps, everything, everything
// in small steps.
std::vector<ForwardFlowOptions> forward_flow_ladder();

struct ForwardFlowStep {
  int attempt = 0;
  int step = 0;  // from 1
  FlowWeights weights = FlowWeights::clamped;
  double delta = 0;       // the largest of any vertex
  Index active = 0;       // vertices that could move
  Index pairs = 0;        // intersecting face pairs after the step;
  bool all_pairs = true;  // false: only those known from the step before were tested again
};

struct ForwardFlowResult {
  enum class Termination { clean_input, regional, global };
  Termination termination = Termination::clean_input;

  VertexMatrix V;  // V_t*, #V x 3, in the input's coordinates
  // The flow between V0 and V_t* (both left out), rows of the active vertices only. Empty without
  // keep_states, or when the memory limit left no room for them.
  std::vector<VertexMatrix> states;
  std::vector<Index> active_vertices;  // ascending
  std::vector<char> active;            // by vertex: was free to move
  std::vector<char> reverse_free;      // by vertex: should be free in the reverse flow; contains `active`

  FlowWeights weights = FlowWeights::clamped;  // the Laplacian that ran last
  std::vector<ForwardFlowStep> steps;          // of all attempts
  int attempts = 0;
  Index clusters = 0;
  double frozen_area = 1;  // part of the input's area whose faces did not move

  // V_t for states[i], all vertices.
  VertexMatrix state(const VertexMatrix& V0, std::size_t i) const;
};

// pairs: the intersecting face pairs of the surface, all of them, each once.
Result<ForwardFlowResult> forward_flow(const Surface& surface, std::span<const std::array<Index, 2>> pairs,
                                       const ForwardFlowOptions& options, const RunContext& context);

// What a caller may rely on, checked from scratch (one full exact intersection test). Where assertions are
// on, forward_flow() does so itself.
Status check_postconditions(const Surface& surface, const ForwardFlowResult& result);

}  // namespace overtet
