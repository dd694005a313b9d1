#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "kernels/core/assertions.h"
#include "kernels/core/box.h"
#include "kernels/core/indices.h"
#include "kernels/near_points/near_points.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "overtet/verification.h"
#include "src/exact/ordinary_size.h"
#include "src/verify/tuning.h"

namespace overtet {

namespace {

// The value at place `nth` of the sorted list, all values in [-1, 1]: counted by all threads into bins, and
// only the bin that holds it is looked through.
float nth_smallest(const std::vector<float>& values, std::size_t nth) {
  using Counts = std::array<std::int64_t, kBins>;
  const auto bin = [](float x) { return std::clamp(static_cast<int>((x + 1) * (kBins / 2)), 0, kBins - 1); };
  const std::int64_t n = static_cast<std::int64_t>(values.size());
  const Counts counts = parallel_reduce(
      n, 32 * kLightGrain, Counts{},
      [&](std::int64_t begin, std::int64_t end) {
        Counts c{};
        for (std::int64_t i = begin; i < end; ++i) ++c[static_cast<std::size_t>(bin(values[i]))];
        return c;
      },
      [](Counts a, const Counts& b) {
        for (std::size_t i = 0; i < kBins; ++i) a[i] += b[i];
        return a;
      });
  int at = 0;
  std::int64_t before = 0;
  while (before + counts[static_cast<std::size_t>(at)] <= static_cast<std::int64_t>(nth))
    before += counts[static_cast<std::size_t>(at++)];
  std::vector<float> inside = parallel_collect<float>(
      n, 32 * kLightGrain, [&](std::int64_t begin, std::int64_t end, std::vector<float>& out) {
        for (std::int64_t i = begin; i < end; ++i)
          if (bin(values[i]) == at) out.push_back(values[i]);
      });
  const auto wanted = inside.begin() + (static_cast<std::int64_t>(nth) - before);
  std::nth_element(inside.begin(), wanted, inside.end());
  return *wanted;
}

}  // namespace

TetQuality tet_quality(const TetMesh& mesh, const RunContext& context) {
  OVERTET_EXPECTS(all_below(mesh.T, mesh.V.rows()));
  const ScopedThreads threads(context.threads > 0 ? context.threads : thread_cap());
  TetQuality q;
  q.tets = mesh.T.rows();
  if (q.tets == 0) return q;
  // What is computed here must not leave the range of doubles.
  const int exponent = to_ordinary_size(mesh.V);
  std::optional<VertexMatrix> scaled;
  if (exponent != 0) scaled = times_power(mesh.V, exponent);
  const VertexMatrix& V = scaled ? *scaled : mesh.V;
  // Cosines of the angles: they sort like the angles (backwards) and cost no trigonometry.
  std::vector<float> cosines(6 * static_cast<std::size_t>(q.tets));
  struct Extremes {
    double low = 1, high = -1, volume = 0;
  };
  const auto block = [&](std::int64_t begin, std::int64_t end) {
    Extremes x;
    for (std::int64_t t = begin; t < end; ++t) {
      Eigen::Vector3d p[4], n[4];
      for (int k = 0; k < 4; ++k) p[k] = V.row(mesh.T(t, k));
      n[0] = (p[3] - p[1]).cross(p[2] - p[1]);
      n[1] = (p[2] - p[0]).cross(p[3] - p[0]);
      n[2] = (p[3] - p[0]).cross(p[1] - p[0]);
      n[3] = (p[1] - p[0]).cross(p[2] - p[0]);
      x.volume += (p[3] - p[0]).dot(n[3]) / 6;
      for (Eigen::Vector3d& m : n) m /= m.norm();
      std::size_t at = 6 * static_cast<std::size_t>(t);
      for (int i = 0; i < 4; ++i)
        for (int j = i + 1; j < 4; ++j) {
          const double c = std::clamp(-n[i].dot(n[j]), -1.0, 1.0);
          cosines[at++] = std::isfinite(c) ? static_cast<float>(c) : 1.0F;
          if (!std::isfinite(c)) continue;
          x.low = std::min(x.low, c);
          x.high = std::max(x.high, c);
        }
    }
    return x;
  };
  const Extremes all =
      parallel_reduce(q.tets, 4 * kLightGrain, Extremes{}, block, [](Extremes a, const Extremes& b) {
        return Extremes{std::min(a.low, b.low), std::max(a.high, b.high), a.volume + b.volume};
      });
  const auto degrees = [](double cosine) { return std::acos(cosine) * 180 / std::numbers::pi; };
  q.dihedral_p01 = degrees(nth_smallest(cosines, cosines.size() - 1 - cosines.size() / 100));
  q.dihedral_min = degrees(all.high);
  q.dihedral_max = degrees(all.low);
  q.volume = from_ordinary_size(all.volume, exponent, 3);
  const NearPoints::Closest closest = NearPoints(V).closest();
  const double diagonal = diagonal_of(V);
  q.coincident_vertices = closest.coincident;
  q.closest_pair = closest.distance / diagonal;
  q.closest = {closest.a, closest.b};
  return q;
}

}  // namespace overtet
