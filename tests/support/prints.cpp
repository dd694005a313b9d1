#include "tests/support/prints.h"

#include <array>
#include <cmath>
#include <numeric>
#include <vector>

namespace overtet::test {

namespace {

using OutlinePoint = Eigen::Vector2d;
using Corners = std::array<Index, 3>;

std::vector<Corners> fan(Index n) {
  std::vector<Corners> out;
  for (Index i = 1; i + 1 < n; ++i) out.push_back({0, i, i + 1});
  return out;
}

std::vector<Corners> strip(Index n) {
  std::vector<Corners> out;
  bool low = true;
  for (Index i = 0, j = n - 1; j - i > 1; low = !low) {
    out.push_back(low ? Corners{i, i + 1, j} : Corners{i, j - 1, j});
    low ? ++i : --j;
  }
  return out;
}

std::vector<Corners> ears(const std::vector<OutlinePoint>& p) {
  std::vector<Index> left(p.size());
  std::iota(left.begin(), left.end(), 0);
  const auto turn = [&](Index a, Index b, Index c) {
    const OutlinePoint u = p[b] - p[a], w = p[c] - p[a];
    return u.x() * w.y() - u.y() * w.x();
  };
  std::vector<Corners> out;
  for (std::size_t i = 0; left.size() > 3; ++i) {
    const std::size_t n = left.size();
    const Index a = left[i % n], b = left[(i + 1) % n], c = left[(i + 2) % n];
    bool ear = turn(a, b, c) > 0;
    for (std::size_t k = 0; ear && k < n; ++k) {
      const Index v = left[k];
      ear = v == a || v == b || v == c || turn(a, b, v) < 0 || turn(b, c, v) < 0 || turn(c, a, v) < 0;
    }
    if (!ear) continue;
    out.push_back({a, b, c});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>((i + 1) % n));
  }
  out.push_back({left[0], left[1], left[2]});
  return out;
}

std::vector<Corners> cap(const std::vector<OutlinePoint>& p, Caps caps) {
  const auto n = static_cast<Index>(p.size());
  return caps == Caps::fan ? fan(n) : caps == Caps::strip ? strip(n) : ears(p);
}

// loops: the solid on their left; their points follow each other.
Surface extruded(const std::vector<OutlinePoint>& p, const std::vector<Index>& loops,
                 const std::vector<Corners>& cap, double height) {
  const auto n = static_cast<Index>(p.size());
  Surface s;
  s.V.resize(2 * n, 3);
  for (Index v = 0; v < n; ++v) {
    s.V.row(v) << p[v].x(), p[v].y(), 0;
    s.V.row(n + v) << p[v].x(), p[v].y(), height;
  }
  std::vector<Corners> faces;
  for (const Corners& t : cap) {
    faces.push_back({t[0], t[2], t[1]});
    faces.push_back({n + t[0], n + t[1], n + t[2]});
  }
  Index first = 0;
  for (const Index count : loops) {
    for (Index k = 0; k < count; ++k) {
      const Index a = first + k, b = first + (k + 1) % count;
      faces.push_back({a, b, n + b});
      faces.push_back({a, n + b, n + a});
    }
    first += count;
  }
  s.F.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t f = 0; f < faces.size(); ++f)
    s.F.row(static_cast<Eigen::Index>(f)) << faces[f][0], faces[f][1], faces[f][2];
  return s;
}

}  // namespace

Surface rounded_plate(int points_a_corner, Caps caps, double height) {
  const double r = 0.5;
  const OutlinePoint centres[] = {{100 - r, 60 - r}, {r, 60 - r}, {r, r}, {100 - r, r}};
  std::vector<OutlinePoint> p;
  for (int corner = 0; corner < 4; ++corner)
    for (int i = 0; i < points_a_corner; ++i) {
      const double t = M_PI / 2 * (corner + static_cast<double>(i) / (points_a_corner - 1));
      p.emplace_back(centres[corner] + r * OutlinePoint(std::cos(t), std::sin(t)));
    }
  return extruded(p, {static_cast<Index>(p.size())}, cap(p, caps), height);
}

Surface ring_plate(int points_a_circle, double height) {
  const Index n = points_a_circle;
  std::vector<OutlinePoint> p;
  for (const double r : {50.0, -20.0})
    for (Index i = 0; i < n; ++i) {
      const double t = 2 * M_PI * i / n;
      p.emplace_back(std::abs(r) * std::cos(t), r * std::sin(t));  // the inner one runs the other way
    }
  std::vector<Corners> strip;
  for (Index i = 0; i < n; ++i) {
    const Index j = (i + 1) % n, a = n + (n - i) % n, b = n + (n - j) % n;
    strip.push_back({i, j, a});
    strip.push_back({j, b, a});
  }
  return extruded(p, {n, n}, strip, height);
}

Surface gear_plate(int points, Caps caps, double height) {
  std::vector<OutlinePoint> p;
  for (int i = 0; i < points; ++i) {
    const double t = 2 * M_PI * i / points, wave = std::sin(20 * t);
    const double r = (wave > 0 ? 50 : 45) + 0.1 * wave;
    p.emplace_back(r * std::cos(t), r * std::sin(t));
  }
  return extruded(p, {static_cast<Index>(p.size())}, cap(p, caps), height);
}

}  // namespace overtet::test
