#include "tests/support/stairs.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "kernels/core/tet_tables.h"

namespace overtet::test {

namespace {

using Point = Eigen::Vector3d;

double volume(const TetMesh& m, Index t) {
  const Point a = m.V.row(m.T(t, 0)), b = m.V.row(m.T(t, 1)), c = m.V.row(m.T(t, 2)), d = m.V.row(m.T(t, 3));
  return (b - a).cross(c - a).dot(d - a) / 6;
}

// The faces that belong to one tet only, outward.
TriangleMatrix boundary_of(const TetMesh& m) {
  std::map<std::array<Index, 3>, std::array<Index, 3>> once;
  for (Index t = 0; t < m.T.rows(); ++t)
    for (int k = 0; k < 4; ++k) {
      const std::array<Index, 3> f = tet_face(m.T.row(t), k);
      auto key = f;
      std::sort(key.begin(), key.end());
      if (const auto [at, added] = once.try_emplace(key, f); !added) once.erase(at);
    }
  TriangleMatrix F(static_cast<Eigen::Index>(once.size()), 3);
  Eigen::Index row = 0;
  for (const auto& [key, f] : once) F.row(row++) << f[0], f[1], f[2];
  return F;
}

}  // namespace

Stairs spiral_stairs(const StairsOptions& options) {
  constexpr double kRise = 0.02, kGrowth = 0.03;  // a radian
  const int steps = std::max(3, static_cast<int>(std::ceil(options.turns * options.per_turn)));
  const int levels = options.edges + 1;
  const double sector = 2 * std::numbers::pi * options.turns / steps;
  const int more = static_cast<int>(std::ceil(2 * std::numbers::pi * options.longer / sector));
  Stairs out;
  out.wound = static_cast<int>(options.turns);
  out.wound_last = static_cast<int>((steps + more) * sector / (2 * std::numbers::pi));
  TetMesh& m = out.mesh;
  const auto axis = [&](int level) { return static_cast<Index>(level); };
  // Beyond the common steps only the last two levels have columns.
  const auto column = [&](int i, int level) {
    const int common = levels + (steps + 1) * levels;
    return static_cast<Index>(i <= steps ? levels + i * levels + level
                                         : common + 2 * (i - steps - 1) + level - (levels - 2));
  };
  m.V.resize(levels * (steps + 2) + 2 * more, 3);
  // Levels follow the axis; each is the one before, moved along it and turned.
  Eigen::Affine3d frame = Eigen::Affine3d::Identity();
  for (int j = 0; j < levels; ++j) {
    m.V.row(axis(j)) = frame.translation().transpose();
    for (int i = 0; i <= steps + (j + 2 >= levels ? more : 0); ++i) {
      const double angle = sector * i, radius = 1 + kGrowth * angle;
      m.V.row(column(i, j)) =
          (frame * Point(radius * std::cos(angle), radius * std::sin(angle), kRise * angle)).transpose();
    }
    frame = frame * Eigen::Translation3d(0, 0, 1) * Eigen::AngleAxisd(options.bend, Point::UnitX());
    out.axis.push_back(axis(j));
  }
  m.T.resize(3 * (steps * options.edges + more), 4);
  Index t = 0;
  for (int i = 0; i < steps + more; ++i)
    for (int j = i < steps ? 0 : levels - 2; j + 1 < levels; ++j) {
      const Index a0 = axis(j), b0 = column(i, j), c0 = column(i + 1, j);
      const Index a1 = axis(j + 1), b1 = column(i, j + 1), c1 = column(i + 1, j + 1);
      m.T.row(t++) << a0, b0, c0, c1;
      m.T.row(t++) << a0, b1, c1, a1;
      m.T.row(t++) << a0, c1, b1, b0;
    }
  m.surface_vertices = static_cast<Index>(m.V.rows());
  if (options.noise > 0) {
    std::mt19937_64 random(options.seed);
    for (Index v = 0; v < m.V.rows(); ++v) {
      const Point before = m.V.row(v);
      for (int k = 0; k < 3; ++k)
        m.V(v, k) += options.noise * (static_cast<double>(random() >> 11) * 0x1p-53 - 0.5);
      for (Index u = 0; u < m.T.rows(); ++u)
        if (volume(m, u) < 1e-3) m.V.row(v) = before.transpose();
    }
  }
  out.surface = {m.V, boundary_of(m)};
  return out;
}

}  // namespace overtet::test
