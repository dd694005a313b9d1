#include "src/mesh/size_limit.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "kernels/core/tet_tables.h"

namespace overtet {

namespace {

// The volume of a regular tet with edges of length 1.
const double kRegular = 1 / (6 * std::numbers::sqrt2);

double cube(double x) { return x * x * x; }

}  // namespace

SizeLimit::SizeLimit(const Eigen::Vector3d& unit, double volume, double edge)
    : unit_(unit), volume_(volume), edge_(edge) {}

void SizeLimit::add_vertex(const Eigen::Vector3d& p, std::span<const Index> near,
                           const std::vector<Eigen::Vector3d>& positions) {
  LocalSize size{edge_, 0};
  for (const Index v : near) size.meet(sizes[v].at(length(p, positions[v])));
  sizes.push_back(size);
}

bool SizeLimit::kept(Index a, Index b) const {
  const std::array<Index, 2> edge{std::min(a, b), std::max(a, b)};
  return std::binary_search(kept_.begin(), kept_.end(), edge);
}

double SizeLimit::volume_at(const TetComplex::Tet& tet) const {
  double least = 0;
  for (const Index v : tet) least = std::max(least, sizes[v].least);
  return std::max(volume_, kRegular * cube(least));
}

double SizeLimit::wanted(const TetComplex::Tet& tet) const {
  double length = std::cbrt(volume_at(tet) / kRegular);
  for (const auto& [i, j] : kTetEdge) length = std::min(length, allowed(tet[i], tet[j]));
  return length;
}

SizeLimit::Excess SizeLimit::excess(const TetComplex::Tet& tet,
                                    const std::array<Eigen::Vector3d, 4>& at) const {
  Excess e;
  double longest = 1;
  for (int k = 0; k < 6; ++k) {
    const auto [i, j] = kTetEdge[k];
    const double ratio = length(at[i], at[j]) / allowed(tet[i], tet[j]);
    if (ratio <= longest && ratio <= e.factor) continue;
    if (ratio > 1 && kept(tet[i], tet[j])) continue;
    e.factor = std::max(e.factor, ratio);
    if (ratio > longest) longest = ratio, e.edge = k;
  }
  if (std::isfinite(volume_)) {
    const auto side = [&](int k) { return (at[k] - at[0]).cwiseProduct(unit_).eval(); };
    const double volume = side(1).cross(side(2)).dot(side(3)) / 6;
    e.factor = std::max(e.factor, std::cbrt(volume / volume_at(tet)));
  }
  return e;
}

}  // namespace overtet
