#include "src/improve/improve.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "kernels/parallel/parallel.h"
#include "src/improve/passes.h"
#include "src/improve/refine.h"
#include "src/tet_complex/local_operations.h"
#include "src/tet_complex/parts.h"

namespace overtet {

namespace {

constexpr int kMostParts = 64;  // enough for many threads; every cut costs a little
// What lies around a cut: so many layers of tets.
constexpr int kLayers = 2;
// Part of the target angle below which tets are looked at once more, after the parts, all together.
constexpr double kSecondLook = 0.4;
// Refinement may at most multiply the tets by this.
constexpr std::int64_t kRefinedGrowth = 5;
// Circumradii over the diagonal divided by this and by the cube root of the number of parts are large.
constexpr double kLargeTets = 80;
// Below this smallest dihedral sine (3 degrees) vertices inside are taken out where that helps.
constexpr double kLooseQuality = 0.05;

int parts_for(std::size_t tets, const ImproveOptions& options) {
  int parts = 1;
  while (parts < kMostParts && static_cast<std::int64_t>(tets) / (2 * parts) >= options.tets_per_part)
    parts *= 2;
  return parts;
}

struct PartResult {
  std::int64_t refined = 0;
  PassesResult passes;
};

// loose: of the whole mesh's vertices, see refine().
PartResult improve_part(MeshPart& part, std::span<const char> loose, const ImproveOptions& options,
                        double seconds, const RunContext& context) {
  PartResult result;
  LocalOperations work(part.complex);
  part.mark_shared(work);
  if (options.radius_edge > 0) {
    std::vector<char> here;
    for (const Index v : part.vertex) here.push_back(loose[v]);
    contract_loose(work, here, kLooseQuality, context);
    result.refined =
        refine(work, options.radius_edge, 0, here, kRefinedGrowth * part.complex.tet_count() + 1000, context);
  }
  result.passes = improve_passes(work, options, seconds, context);
  return result;
}

// Where nothing is inside yet, tets reach from one side to the other, and every cut is long. So large tets
// are refined before the mesh is cut; a few vertices are enough.
std::int64_t refine_large(TetMesh& mesh, std::vector<char>& loose, const ImproveOptions& options, int parts,
                          const RunContext& context) {
  const double diagonal = (mesh.V.colwise().maxCoeff() - mesh.V.colwise().minCoeff()).norm();
  TetComplex complex(mesh.V, mesh.T);
  LocalOperations work(complex);
  const std::int64_t inserted = refine(work, options.radius_edge, diagonal / (kLargeTets * std::cbrt(parts)),
                                       loose, kRefinedGrowth * complex.tet_count(), context);
  mesh = complex.to_mesh(mesh.surface_vertices);
  loose.resize(static_cast<std::size_t>(mesh.V.rows()), 0);
  return inserted;
}

// The tets within kLayers layers around some vertices.
std::vector<Index> around(const TetMesh& mesh, std::vector<char> near) {
  std::vector<char> chosen(static_cast<std::size_t>(mesh.T.rows()), 0);
  for (int layer = 0; layer < kLayers; ++layer) {
    for (Index t = 0; t < mesh.T.rows(); ++t)
      for (int k = 0; k < 4; ++k)
        if (near[mesh.T(t, k)]) chosen[t] = 1;
    for (Index t = 0; t < mesh.T.rows(); ++t)
      if (chosen[t])
        for (int k = 0; k < 4; ++k) near[mesh.T(t, k)] = 1;
  }
  std::vector<Index> tets;
  for (Index t = 0; t < mesh.T.rows(); ++t)
    if (chosen[t]) tets.push_back(t);
  return tets;
}

// Marks the corners of tets with a dihedral sine below that of `degrees`.
std::vector<char> corners_of_worst(const TetMesh& mesh, double degrees) {
  const double sine = std::sin(degrees * M_PI / 180);
  std::vector<char> marked(static_cast<std::size_t>(mesh.V.rows()), 0);
  for (Index t = 0; t < mesh.T.rows(); ++t) {
    const auto p = [&](int k) { return Eigen::Vector3d(mesh.V.row(mesh.T(t, k))); };
    if (min_dihedral_sine(p(0), p(1), p(2), p(3)) < sine)
      for (int k = 0; k < 4; ++k) marked[mesh.T(t, k)] = 1;
  }
  return marked;
}

void add(ImproveResult& sum, const PartResult& part, std::size_t first_pass) {
  sum.end = std::max(sum.end, part.passes.end);
  sum.refined += part.refined;
  const auto& passes = part.passes.passes;
  if (sum.passes.size() < first_pass + passes.size()) sum.passes.resize(first_pass + passes.size());
  for (std::size_t i = 0; i < passes.size(); ++i) {
    ImprovePass& to = sum.passes[first_pass + i];
    to.worst_sine = to.bad == 0 ? passes[i].worst_sine : std::min(to.worst_sine, passes[i].worst_sine);
    to.bad += passes[i].bad;
    to.removed_edges += passes[i].removed_edges;
    to.flips += passes[i].flips;
    to.smoothed += passes[i].smoothed;
    to.collapsed += passes[i].collapsed;
    to.inserted += passes[i].inserted;
    to.seconds += passes[i].seconds;
  }
}

}  // namespace

Status ImproveOptions::validate() const {
  if (radius_edge != 0 && !(radius_edge >= 1.2 && radius_edge <= 100))
    return Error{ErrorCode::usage, "The radius-edge bound must lie between 1.2 and 100, or be 0 for none."};
  if (!(target_degrees > 0 && target_degrees <= 40))
    return Error{ErrorCode::usage, "The target angle must lie between 0 and 40 degrees."};
  if (!(insert_below_degrees >= 0 && insert_below_degrees <= 40))
    return Error{ErrorCode::usage,
                 "The angle below which vertices are inserted must lie between 0 and 40 degrees."};
  if (!(growth >= 1)) return Error{ErrorCode::usage, "The allowed growth of the mesh must be at least 1."};
  if (passes < 0) return Error{ErrorCode::usage, "The number of passes must not be negative."};
  if (!(effort >= 0)) return Error{ErrorCode::usage, "The effort of the quality pass must not be negative."};
  if (tets_per_part < 1) return Error{ErrorCode::usage, "A part of the mesh must have a tet at least."};
  if (!(seconds >= 0)) return Error{ErrorCode::usage, "The time for the quality pass must not be negative."};
  return success();
}

Result<ImproveResult> improve(TetMesh& mesh, const ImproveOptions& options, const RunContext& context) {
  if (auto status = options.validate(); !status.ok()) return status.error();
  if (auto error = context.stop()) return *error;
  const auto begin = RunContext::Clock::now();
  const auto since_begin = [&] {
    return std::chrono::duration<double>(RunContext::Clock::now() - begin).count();
  };
  const double budget = std::min(options.seconds, 0.5 * context.seconds_left());
  RunContext silent = context;
  silent.progress = nullptr;

  ImproveResult result;
  result.before = dihedral_statistics(mesh.V, mesh.T);
  std::vector<char> loose(static_cast<std::size_t>(mesh.V.rows()), 1);  // the inside's, as given
  std::fill(loose.begin(), loose.begin() + mesh.surface_vertices, 0);
  if (const int parts = parts_for(static_cast<std::size_t>(mesh.T.rows()), options);
      parts > 1 && options.radius_edge > 0)
    result.refined = refine_large(mesh, loose, options, parts, silent);
  std::vector<Index> chosen(static_cast<std::size_t>(mesh.T.rows()));
  std::iota(chosen.begin(), chosen.end(), 0);
  std::size_t before = 2 * chosen.size();
  bool second_look = false;
  while (!chosen.empty()) {
    // Where parts are so small that the cuts are everywhere, the second round is in one piece.
    const int count = !second_look && chosen.size() <= before / 2 ? parts_for(chosen.size(), options) : 1;
    before = chosen.size();
    const std::size_t first_pass = result.passes.size();
    const std::vector<int> part_of = halve(mesh, chosen, count);
    std::vector<MeshPart> parts = take_parts(mesh, part_of, count);
    std::vector<PartResult> results(parts.size());
    context.report("improve", result.rounds.empty() ? 0 : 0.8,
                   std::to_string(chosen.size()) + " tets in " + std::to_string(count) + " parts");
    const double seconds = std::max(0.0, budget - since_begin());
    parallel_for(count, 1, [&](std::int64_t first, std::int64_t last) {
      for (std::int64_t p = first; p < last; ++p)
        results[p] = improve_part(parts[p], loose, options, seconds, silent);
    });
    if (context.cancel && context.stop()) return *context.stop();
    for (const PartResult& part : results) add(result, part, first_pass);
    result.rounds.push_back(count);
    std::vector<char> times_shared(static_cast<std::size_t>(mesh.V.rows()), 0);
    for (const MeshPart& part : parts)
      for (const Index v : part.shared)
        if (char& times = times_shared[part.vertex[v]]; times < 2) ++times;
    const std::vector<Index> number = put_parts(mesh, part_of, parts);
    std::vector<char> near(static_cast<std::size_t>(mesh.V.rows()), 0), still_loose(near.size(), 0);
    for (std::size_t v = 0; v < number.size(); ++v) {
      if (number[v] < 0) continue;
      near[number[v]] = times_shared[v] > 1;
      still_loose[number[v]] = loose[v];
    }
    loose = std::move(still_loose);
    if (count == 1) {
      if (result.rounds.front() == 1 || second_look) break;
      // What cuts left unfinished, once more with all that is around it.
      second_look = true;
      near = corners_of_worst(mesh, kSecondLook * options.target_degrees);
    }
    chosen = around(mesh, std::move(near));
  }
  result.after = dihedral_statistics(mesh.V, mesh.T);
  result.seconds = since_begin();
  return result;
}

}  // namespace overtet
