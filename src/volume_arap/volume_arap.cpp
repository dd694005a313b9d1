#include "src/volume_arap/volume_arap.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "kernels/arap/volume_arap.h"
#include "kernels/core/indices.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "kernels/predicates/predicates.h"

namespace overtet {

namespace {

double volume_of(const TetMesh& mesh, Eigen::Index t) {
  const auto at = [&](int k) { return Eigen::Vector3d(mesh.V.row(mesh.T(t, k))); };
  return (at(1) - at(0)).dot((at(2) - at(0)).cross(at(3) - at(0))) / 6;
}

std::vector<Index> not_positive(const TetMesh& mesh) {
  return parallel_collect<Index>(mesh.T.rows(), kMediumGrain,
                                 [&](std::int64_t begin, std::int64_t end, std::vector<Index>& out) {
                                   const auto at = [&](std::int64_t t, int k) {
                                     return mesh.V.data() + 3 * static_cast<std::ptrdiff_t>(mesh.T(t, k));
                                   };
                                   for (std::int64_t t = begin; t < end; ++t)
                                     if (orient3d(at(t, 0), at(t, 1), at(t, 2), at(t, 3)) <= 0)
                                       out.push_back(static_cast<Index>(t));
                                 });
}

// The rows and columns of the vertices from `first` on.
SymmetricMatrix inner_block(const SymmetricMatrix& L, Index first) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int c = first; c < L.outerSize(); ++c)
    for (SymmetricMatrix::InnerIterator it(L, c); it; ++it)
      entries.emplace_back(static_cast<int>(it.row()) - first, c - first, it.value());
  SymmetricMatrix block(L.rows() - first, L.rows() - first);
  block.setFromTriplets(entries.begin(), entries.end());
  block.makeCompressed();
  return block;
}

}  // namespace

Status VolumeArapOptions::validate() const {
  if (iterations < 1 || !(still >= 0))
    return Error{ErrorCode::usage, "Volumetric ARAP: iterations must be positive, still not negative."};
  return success();
}

Result<VolumeArapResult> volume_arap(const TetMesh& mesh, const VertexMatrix& target,
                                     const VolumeArapOptions& options, const RunContext& context) {
  if (const Status valid = options.validate(); !valid) return valid.error();
  const Index boundary = mesh.surface_vertices;
  if (target.rows() != boundary || mesh.V.rows() < boundary || !target.allFinite() || !mesh.V.allFinite() ||
      !all_below(mesh.T, mesh.V.rows()))
    return Error{ErrorCode::bad_input, "Volumetric ARAP: the tet mesh does not fit the surface."};
  const ScopedThreads threads(context.threads);
  double volume = 0;
  for (Eigen::Index t = 0; t < mesh.T.rows(); ++t) {
    const double v = volume_of(mesh, t);
    if (!(v > 0))
      return Error{ErrorCode::bad_input,
                   "Volumetric ARAP: tet " + std::to_string(t) + " of the rest state has no volume."};
    volume += v;
  }
  VolumeArapResult result;
  result.mesh = mesh;
  VertexMatrix& X = result.mesh.V;
  X.topRows(boundary) = target;
  const Eigen::Index inside = X.rows() - boundary;
  VolumeArap arap(mesh.V, mesh.T);
  SparseCholesky factor;
  const SymmetricMatrix Q = inner_block(arap.matrix(), boundary);
  if (!factor.analyze(Q) || !factor.factor(Q))
    return Error{ErrorCode::limit, "There is not enough memory for a factorisation of the volumetric map."};
  double before = HUGE_VAL;
  VertexMatrix gradient, step;
  while (inside > 0 && result.iterations < options.iterations) {
    if (const auto stop = context.stop()) return *stop;
    // The first rotations are those of the rest state: none.
    if (result.iterations > 0) arap.fit_rotations(X);
    arap.gradient(X, gradient);
    step = gradient.bottomRows(inside);
    if (!factor.solve(step, step) || !step.allFinite())
      return Error{ErrorCode::unsolved, "Volumetric ARAP: the linear system could not be solved."};
    X.bottomRows(inside) -= step;
    ++result.iterations;
    const double energy = arap.energy(X);
    context.report("volume_arap", static_cast<double>(result.iterations) / options.iterations);
    if (before - energy <= options.still * energy && result.iterations > 1) break;
    before = energy;
  }
  arap.fit_rotations(X);
  result.energy = arap.energy(X) / volume;
  result.flipped = not_positive(result.mesh);
  return result;
}

}  // namespace overtet
