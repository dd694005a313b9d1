#include "tests/support/models.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <random>
#include <vector>

namespace overtet::test {

namespace {

constexpr double kPi = std::numbers::pi;
using Point = Eigen::Vector3d;
using Triangle = std::array<Index, 3>;

Surface surface_of(const std::vector<Point>& points, const std::vector<Triangle>& triangles) {
  Surface s;
  s.V.resize(static_cast<Eigen::Index>(points.size()), 3);
  s.F.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t v = 0; v < points.size(); ++v)
    s.V.row(static_cast<Eigen::Index>(v)) = points[v].transpose();
  for (std::size_t f = 0; f < triangles.size(); ++f)
    for (int k = 0; k < 3; ++k)
      s.F(static_cast<Eigen::Index>(f), k) = triangles[f][static_cast<std::size_t>(k)];
  return s;
}

Surface mapped(Surface s, const std::function<Point(const Point&)>& f) {
  for (Eigen::Index v = 0; v < s.V.rows(); ++v) s.V.row(v) = f(s.V.row(v).transpose()).transpose();
  return s;
}

// The boundary of a set of cells of a grid nx x ny x nz, each square cut into two triangles; points in
// grid units. pre: cells that touch do so in whole faces.
Surface grid_boundary(int nx, int ny, int nz, const std::function<bool(int, int, int)>& inside) {
  std::map<std::array<int, 3>, Index> number;
  std::vector<Point> points;
  std::vector<Triangle> triangles;
  const auto vertex = [&](const std::array<int, 3>& p) {
    const auto [it, added] = number.try_emplace(p, static_cast<Index>(points.size()));
    if (added) points.emplace_back(p[0], p[1], p[2]);
    return it->second;
  };
  const auto solid = [&](int x, int y, int z) {
    return x >= 0 && y >= 0 && z >= 0 && x < nx && y < ny && z < nz && inside(x, y, z);
  };
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) {
        if (!solid(x, y, z)) continue;
        for (int axis = 0; axis < 3; ++axis)
          for (int side = 0; side < 2; ++side) {
            std::array<int, 3> beyond = {x, y, z};
            beyond[static_cast<std::size_t>(axis)] += side ? 1 : -1;
            if (solid(beyond[0], beyond[1], beyond[2])) continue;
            const auto u = static_cast<std::size_t>((axis + 1) % 3),
                       w = static_cast<std::size_t>((axis + 2) % 3);
            std::array<int, 3> a = {x, y, z};
            a[static_cast<std::size_t>(axis)] += side;
            std::array<int, 3> b = a, c = a, d = a;
            b[u] += 1, c[u] += 1, c[w] += 1, d[w] += 1;
            std::array<Index, 4> q = {vertex(a), vertex(b), vertex(c), vertex(d)};
            if (side == 0) std::swap(q[1], q[3]);
            // Alternating diagonals keep the triangulation free of a preferred direction.
            if ((x + y + z) % 2 == 0) {
              triangles.push_back({q[0], q[1], q[2]});
              triangles.push_back({q[0], q[2], q[3]});
            } else {
              triangles.push_back({q[1], q[2], q[3]});
              triangles.push_back({q[1], q[3], q[0]});
            }
          }
      }
  return surface_of(points, triangles);
}

// Rolls the x axis up around the z axis, one radian per unit of the middle line, and shifts it along z
// while it turns, so that the second turn crosses the first one without falling onto it.
Surface rolled(const Surface& straight, double radius, double pitch) {
  return mapped(straight, [&](const Point& p) {
    const double a = p.x() / radius;
    // The roll also tightens a little: exact symmetry would put vertices onto faces.
    const double r = radius * (1 - 0.011 * a) - p.y();
    return Point(r * std::sin(a), -r * std::cos(a), p.z() + pitch * a / (2 * kPi));
  });
}

}  // namespace

Surface sphere(int subdivisions, double radius, const Point& centre) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  std::vector<Point> points = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                               {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  std::vector<Triangle> triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                     {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                     {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                     {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (Point& p : points) p.normalize();
  for (int s = 0; s < subdivisions; ++s) {
    std::map<std::pair<Index, Index>, Index> middle;
    std::vector<Triangle> finer;
    const auto half = [&](Index a, Index b) {
      const auto [it, added] = middle.try_emplace(std::minmax(a, b), static_cast<Index>(points.size()));
      if (added)
        points.push_back(
            (points[static_cast<std::size_t>(a)] + points[static_cast<std::size_t>(b)]).normalized());
      return it->second;
    };
    for (const auto& [a, b, c] : triangles) {
      const Index ab = half(a, b), bc = half(b, c), ca = half(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    triangles = std::move(finer);
  }
  for (Point& p : points) p = centre + radius * p;
  return surface_of(points, triangles);
}

Surface torus(int around, int across, double major, double minor) {
  std::vector<Point> points;
  std::vector<Triangle> triangles;
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double a = 2 * kPi * i / around, b = 2 * kPi * j / across;
      const double r = major + minor * std::cos(b);
      points.emplace_back(r * std::cos(a), r * std::sin(a), minor * std::sin(b));
    }
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const auto at = [&](int x, int y) { return static_cast<Index>(x % around * across + y % across); };
      triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return surface_of(points, triangles);
}

Surface capsule(double length, double radius, int around) {
  std::vector<Point> points;
  std::vector<Triangle> triangles;
  const int cap = std::max(2, around / 4);
  const int body = std::max(2, static_cast<int>(std::lround(length / (2 * kPi * radius / around))));
  std::vector<std::pair<double, double>> rings;  // x, radius
  for (int i = 1; i < cap; ++i) {
    const double a = kPi / 2 * i / cap;
    rings.emplace_back(-radius * std::cos(a), radius * std::sin(a));
  }
  for (int i = 0; i <= body; ++i) rings.emplace_back(length * i / body, radius);
  for (int i = cap - 1; i >= 1; --i) {
    const double a = kPi / 2 * i / cap;
    rings.emplace_back(length + radius * std::cos(a), radius * std::sin(a));
  }
  points.emplace_back(-radius, 0, 0);
  for (std::size_t i = 0; i < rings.size(); ++i)
    for (int j = 0; j < around; ++j) {
      const double b = 2 * kPi * (j + 0.5 * static_cast<double>(i % 2)) / around;
      points.emplace_back(rings[i].first, rings[i].second * std::cos(b), rings[i].second * std::sin(b));
    }
  points.emplace_back(length + radius, 0, 0);
  const auto last = static_cast<Index>(points.size()) - 1;
  const auto at = [&](std::size_t i, int j) {
    return static_cast<Index>(1 + i * static_cast<std::size_t>(around) +
                              static_cast<std::size_t>(j % around));
  };
  for (int j = 0; j < around; ++j) {
    triangles.push_back({0, at(0, j + 1), at(0, j)});
    triangles.push_back({last, at(rings.size() - 1, j), at(rings.size() - 1, j + 1)});
  }
  for (std::size_t i = 0; i + 1 < rings.size(); ++i)
    for (int j = 0; j < around; ++j) {
      // The rings are turned against each other by half a step: i is ahead of i + 1 when i is odd.
      if (i % 2 == 0) {
        triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
        triangles.push_back({at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)});
      } else {
        triangles.push_back({at(i, j), at(i + 1, j + 1), at(i + 1, j)});
        triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});
      }
    }
  return surface_of(points, triangles);
}

Surface box(int cells) {
  const double h = 1.0 / cells;
  return mapped(grid_boundary(cells, cells, cells, [](int, int, int) { return true; }),
                [&](const Point& p) { return Point(p * h); });
}

Surface slab(int holes, int cells_per_hole) {
  const int k = cells_per_hole;
  const int nx = 2 * k * holes + k, ny = 3 * k, nz = std::max(1, k / 2);
  return mapped(grid_boundary(nx, ny, nz, [&](int x, int y, int) { return !(x / k % 2 == 1 && y / k == 1); }),
                [&](const Point& p) { return Point((p - Point(0, ny, nz) / 2) / k); });
}

Surface curled_worm(double degrees, int around, double radius) {
  const double roll = 1;
  // Half a diameter of pitch a turn: the second turn lies half inside the first.
  return rolled(capsule(degrees / 180 * kPi * roll, radius, around), roll, radius * 1.05);
}

Surface bent_slab(int holes, double degrees, int cells_per_hole) {
  Surface s = slab(holes, cells_per_hole);
  const double length = s.V.col(0).maxCoeff();
  // Thickness along y (the radius), width along z (the axis).
  s = mapped(s, [](const Point& p) { return Point(p.x(), -p.z(), p.y()); });
  const double radius = length / (degrees / 180 * kPi);
  return rolled(s, radius, 0.37);
}

Surface two_spheres(int subdivisions, double distance) {
  const Surface other = transformed(sphere(subdivisions), some_rotation(7), Point(distance, 0.013, 0.027));
  return joined(sphere(subdivisions), other);
}

Surface elbow(double degrees, int around, double blend) {
  const double half = 2.5, radius = 0.5;
  const Surface straight = capsule(2 * half, radius, around);
  const Eigen::AngleAxisd bend(degrees / 180 * kPi, Point::UnitZ());
  return mapped(straight, [&](const Point& q) {
    const Point p(q.x() - half, q.y() + 1e-3 * q.z(), q.z());
    const double t = std::clamp(p.x() / (blend * radius) + 0.5, 0.0, 1.0);
    const double w = t * t * (3 - 2 * t);
    return Point((1 - w) * p + w * (bend * p));  // linear blend skinning
  });
}

Surface saucer(int subdivisions, double depth) {
  return mapped(sphere(subdivisions), [&](const Point& p) {
    const double r2 = p.x() * p.x() + p.y() * p.y();
    const double dent = p.z() > 0 ? depth * std::exp(-6 * r2) : 0;
    return Point(p.x(), p.y() + 1e-3 * p.x(), 0.25 * p.z() - dent);
  });
}

Surface pressed_fold(int subdivisions) {
  Surface s = sphere(subdivisions);
  for (Index v = 0; v < s.V.rows(); ++v) {
    const double z = s.V(v, 2), wider = 1 + 0.8 * std::exp(-40 * (z - 0.75) * (z - 0.75));
    s.V(v, 0) *= wider;
    s.V(v, 1) *= wider;
    s.V(v, 2) = std::min(z, 0.3);
  }
  return s;
}

Surface mirrored_folds(int subdivisions) {
  const Surface s = pressed_fold(subdivisions);
  Surface other = flipped(s);
  for (Index v = 0; v < s.V.rows(); ++v) other.V(v, 2) = std::max(0.3, 0.6 - s.V(v, 2));
  return joined(s, other);
}

Surface sphere_with_cavity(int subdivisions, double inner_radius) {
  return joined(sphere(subdivisions), flipped(sphere(subdivisions, inner_radius, Point(0.11, 0.07, -0.05))));
}

Surface joined(const Surface& a, const Surface& b) {
  Surface s;
  s.V.resize(a.V.rows() + b.V.rows(), 3);
  s.V << a.V, b.V;
  s.F.resize(a.F.rows() + b.F.rows(), 3);
  s.F << a.F, (b.F.array() + static_cast<Index>(a.V.rows())).matrix();
  return s;
}

Surface flipped(const Surface& s) {
  Surface r = s;
  r.F.col(1) = s.F.col(2);
  r.F.col(2) = s.F.col(1);
  return r;
}

Surface shifted(Surface s, double x, double y, double z) {
  s.V.rowwise() += Eigen::RowVector3d(x, y, z);
  return s;
}

Surface transformed(const Surface& s, const Eigen::Matrix3d& A, const Point& t) {
  return mapped(s, [&](const Point& p) { return Point(A * p + t); });
}

Eigen::Matrix3d some_rotation(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53 * 2 - 1; };
  Eigen::Quaterniond q(unit(), unit(), unit(), unit());
  return q.normalized().toRotationMatrix();
}

Surface permuted(const Surface& s, std::uint64_t seed, Eigen::VectorXi* new_of_old) {
  std::mt19937_64 random(seed);
  const auto shuffled = [&](Eigen::Index n) {
    std::vector<Index> order(static_cast<std::size_t>(n));
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<Index>(i);
    for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
    return order;
  };
  const std::vector<Index> v = shuffled(s.V.rows()), f = shuffled(s.F.rows());
  Surface r = s;
  for (Eigen::Index i = 0; i < s.V.rows(); ++i) r.V.row(v[static_cast<std::size_t>(i)]) = s.V.row(i);
  for (Eigen::Index i = 0; i < s.F.rows(); ++i) {
    const int turn = static_cast<int>(random() % 3);
    for (int k = 0; k < 3; ++k)
      r.F(f[static_cast<std::size_t>(i)], k) = v[static_cast<std::size_t>(s.F(i, (k + turn) % 3))];
  }
  if (new_of_old)
    *new_of_old = Eigen::Map<const Eigen::VectorXi>(v.data(), static_cast<Eigen::Index>(v.size()));
  return r;
}

double signed_volume(const Surface& s) {
  double sum = 0;
  const Point o = s.V.row(0);
  for (Eigen::Index f = 0; f < s.F.rows(); ++f) {
    const Point a = s.V.row(s.F(f, 0)).transpose() - o, b = s.V.row(s.F(f, 1)).transpose() - o,
                c = s.V.row(s.F(f, 2)).transpose() - o;
    sum += a.dot(b.cross(c));
  }
  return sum / 6;
}

bool is_closed_oriented(const Surface& s) {
  std::map<std::pair<Index, Index>, int> uses;
  for (Eigen::Index f = 0; f < s.F.rows(); ++f)
    for (int k = 0; k < 3; ++k) ++uses[{s.F(f, k), s.F(f, (k + 1) % 3)}];
  return std::all_of(uses.begin(), uses.end(), [&](const auto& u) {
    const auto back = uses.find({u.first.second, u.first.first});
    return u.second == 1 && back != uses.end();
  });
}

}  // namespace overtet::test
