#include "tests/support/flow_surfaces.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <vector>

namespace overtet::test {

namespace {

Surface assemble(const std::vector<Eigen::Vector3d>& points, const std::vector<std::array<Index, 3>>& faces) {
  Surface s;
  s.V.resize(static_cast<Eigen::Index>(points.size()), 3);
  s.F.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i) s.V.row(i) = points[i].transpose();
  for (std::size_t i = 0; i < faces.size(); ++i) s.F.row(i) << faces[i][0], faces[i][1], faces[i][2];
  return s;
}

}  // namespace

Surface icosphere(int levels) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  std::vector<Eigen::Vector3d> p = {{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0},
                                    {0, -1, g}, {0, 1, g}, {0, -1, -g}, {0, 1, -g},
                                    {g, 0, -1}, {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
  for (auto& v : p) v.normalize();
  std::vector<std::array<Index, 3>> f = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                         {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                         {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                         {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<Index, Index>, Index> middle;
    const auto mid = [&](Index a, Index b) {
      const auto key = std::minmax(a, b);
      const auto [it, added] = middle.try_emplace({key.first, key.second}, static_cast<Index>(p.size()));
      if (added) p.push_back((p[a] + p[b]).normalized());
      return it->second;
    };
    std::vector<std::array<Index, 3>> finer;
    for (const auto& [a, b, c] : f) {
      const Index ab = mid(a, b), bc = mid(b, c), ca = mid(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    f = std::move(finer);
  }
  return assemble(p, f);
}

Surface tube(const std::function<Eigen::Vector3d(double)>& centre, double radius, int rings, int sides) {
  std::vector<Eigen::Vector3d> p;
  std::vector<std::array<Index, 3>> f;
  // A frame carried along the curve without twist.
  Eigen::Vector3d tangent = (centre(1e-4) - centre(0)).normalized();
  Eigen::Vector3d normal = tangent.unitOrthogonal();
  p.push_back(centre(0) - radius * tangent);
  for (int i = 0; i < rings; ++i) {
    // The first and last quarter-circles are caps: several rings on a half sphere.
    const int cap = std::max(2, sides / 5);
    double t = 0, r = radius, shift = 0;
    if (i < cap) {
      const double a = 0.5 * std::numbers::pi * (i + 1) / (cap + 1);
      r = radius * std::sin(a), shift = -radius * std::cos(a);
    } else if (i >= rings - cap) {
      const double a = 0.5 * std::numbers::pi * (rings - i) / (cap + 1);
      t = 1, r = radius * std::sin(a), shift = radius * std::cos(a);
    } else {
      t = static_cast<double>(i - cap) / (rings - 2 * cap - 1);
    }
    const double h = 1e-4;
    const double t0 = std::max(0.0, t - h), t1 = std::min(1.0, t + h);
    const Eigen::Vector3d next = (centre(t1) - centre(t0)).normalized();
    normal = Eigen::Quaterniond::FromTwoVectors(tangent, next) * normal;
    tangent = next;
    const Eigen::Vector3d binormal = tangent.cross(normal);
    for (int k = 0; k < sides; ++k) {
      const double a = 2 * std::numbers::pi * (k + 0.5 * (i % 2)) / sides;
      p.push_back(centre(t) + shift * tangent + r * (std::cos(a) * normal + std::sin(a) * binormal));
    }
  }
  p.push_back(centre(1) + radius * tangent);
  const auto at = [&](int ring, int k) { return static_cast<Index>(1 + ring * sides + k % sides); };
  for (int k = 0; k < sides; ++k) f.push_back({0, at(0, k + 1), at(0, k)});
  for (int i = 0; i + 1 < rings; ++i) {
    for (int k = 0; k < sides; ++k) {
      if (i % 2 == 0) {
        f.push_back({at(i, k), at(i, k + 1), at(i + 1, k)});
        f.push_back({at(i, k + 1), at(i + 1, k + 1), at(i + 1, k)});
      } else {
        f.push_back({at(i, k), at(i + 1, k + 1), at(i + 1, k)});
        f.push_back({at(i, k), at(i, k + 1), at(i + 1, k + 1)});
      }
    }
  }
  for (int k = 0; k < sides; ++k)
    f.push_back({static_cast<Index>(p.size() - 1), at(rings - 1, k), at(rings - 1, k + 1)});
  return assemble(p, f);
}

Surface bent_capsule(double degrees, double bend, double radius, int rings, int sides) {
  const double angle = degrees * std::numbers::pi / 180;
  return tube(
      [=](double t) { return Eigen::Vector3d(bend * std::cos(angle * t), bend * std::sin(angle * t), 0); },
      radius, rings, sides);
}

Surface bumpy_capsule(double amplitude, std::uint32_t seed) {
  Surface s = tube([](double t) { return Eigen::Vector3d(3 * t, 0, 0); }, 0.5, 30, 14);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-amplitude, amplitude);
  for (Eigen::Index i = 0; i < s.V.rows(); ++i)
    for (int k = 0; k < 3; ++k) s.V(i, k) += uniform(random);
  return s;
}

}  // namespace overtet::test
