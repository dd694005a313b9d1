#include "tests/support/immersed/shapes.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "kernels/bvh/self_intersections.h"

namespace overtet::test {

namespace {

constexpr double kPi = std::numbers::pi;
using Point = Eigen::Vector3d;

}  // namespace

Surface thick_knot(int along, int across) {
  constexpr double kCore = 1, kOffset = 0.25, kTube = 0.36;
  const auto centre = [](double t) {
    const double r = kCore + kOffset * std::cos(1.5 * t);
    // A little off the symmetric place, so that no vertex lies on a face.
    return Point(r * std::cos(t), r * std::sin(t), kOffset * std::sin(1.5 * t) + 0.011 * std::cos(t / 2));
  };
  Surface s;
  s.V.resize(along * across, 3);
  s.F.resize(2 * along * across, 3);
  for (int i = 0; i < along; ++i) {
    const double t = 4 * kPi * i / along;
    const Point tangent = (centre(t + 1e-4) - centre(t - 1e-4)).normalized();
    const Point from_core = centre(t) - kCore * Point(std::cos(t), std::sin(t), 0);
    const Point u = (from_core - tangent * tangent.dot(from_core)).normalized(), w = tangent.cross(u);
    for (int j = 0; j < across; ++j) {
      const double b = 2 * kPi * (j + 0.31) / across;
      s.V.row(i * across + j) = (centre(t) + kTube * (std::cos(b) * u + std::sin(b) * w)).transpose();
    }
  }
  const auto at = [&](int i, int j) { return static_cast<Index>(i % along * across + j % across); };
  for (int i = 0; i < along; ++i)
    for (int j = 0; j < across; ++j) {
      const Index f = 2 * (i * across + j);
      s.F.row(f) << at(i, j), at(i + 1, j + 1), at(i + 1, j);
      s.F.row(f + 1) << at(i, j), at(i, j + 1), at(i + 1, j + 1);
    }
  return signed_volume(s) < 0 ? flipped(s) : s;
}

Surface random_worm(std::uint64_t seed, int around) {
  std::mt19937_64 random(seed);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  const double length = 6 + 3 * unit(), radius = 0.35;
  const Surface straight = capsule(length, radius, around);
  // A frame carried along a curve with slowly changing bends.
  const double bend = 0.9 + 0.7 * unit(), sway = 0.6 * unit(), phase = 6 * unit(), twist = 0.5 * unit();
  constexpr int kSteps = 4000;
  const double first = -radius, step = (length + 2 * radius) / kSteps;
  std::vector<Eigen::Matrix3d> frame(kSteps + 1);
  std::vector<Point> place(kSteps + 1);
  frame[0] = some_rotation(seed + 1);
  place[0] = Point::Zero();
  for (int i = 0; i < kSteps; ++i) {
    const double x = first + step * i;
    const Point turn(twist, sway * std::sin(x + phase), bend + 0.3 * std::sin(0.7 * x + 2 * phase));
    frame[i + 1] = frame[i] * Eigen::AngleAxisd(turn.norm() * step, turn.normalized()).toRotationMatrix();
    place[i + 1] = place[i] + step * frame[i].col(0);
  }
  Surface s = straight;
  for (Index v = 0; v < s.V.rows(); ++v) {
    const int i = std::clamp(static_cast<int>(std::lround((s.V(v, 0) - first) / step)), 0, kSteps);
    s.V.row(v) = (place[i] + frame[i].col(1) * s.V(v, 1) + frame[i].col(2) * s.V(v, 2)).transpose();
  }
  return s;
}

Surface pierced_elbow() {
  const Surface s = elbow(150, 16);
  const Diagnosis d = diagnosed(s);
  // The wound edges are between the hinges; the middle of all of them separates their ends.
  EXPECT_FALSE(d.wound.edges.empty());
  if (d.hinges.empty()) return s;
  const Point a = s.V.row(d.hinges.front().vertex);
  double farthest = 0;
  for (const Hinge& h : d.hinges) farthest = std::max(farthest, (Point(s.V.row(h.vertex)) - a).norm());
  const Surface ball =
      transformed(sphere(1), 0.53 * farthest * some_rotation(11), a + Point(0.0123, 0.0071, -0.0057));
  return joined(s, ball);
}

Diagnosis diagnosed(const Surface& s) {
  Result<Diagnosis> d = diagnose(s, {}, {});
  EXPECT_TRUE(d.ok());
  return std::move(d).value();
}

Prepared prepared(const Surface& s) {
  Prepared p;
  p.surface = s;
  p.diagnosis = diagnosed(s);
  Result<Arrangement> a = arrange(s, p.diagnosis.pairs, {});
  EXPECT_TRUE(a.ok()) << (a.ok() ? "" : a.error().message);
  if (!a.ok()) return p;
  p.arrangement = std::move(a).value();
  Plc plc;
  plc.V = p.arrangement.V;
  plc.F = p.arrangement.F;
  for (Index g = 0; g < plc.F.rows(); ++g) plc.markers.push_back(g + 1);
  TetgenOptions options;
  options.quality = false;
  options.accept_split = true;
  Result<TetgenResult> t = tetrahedralize_stubbornly(plc, options, {});
  EXPECT_TRUE(t.ok()) << (t.ok() ? "" : t.error().message);
  if (t.ok()) p.tets = std::move(t).value();
  return p;
}

std::string check(const Surface& s, const TetMesh& mesh) {
  const VerifyResult v = verify(s, mesh);
  return v.ok() ? "" : "the exact check: " + v.summary();
}

std::string failure_of(const Surface& s, ImmersionResult* out, double radius_edge) {
  const Diagnosis d = diagnosed(s);
  ImmersionOptions options;
  options.radius_edge = radius_edge;
  Result<ImmersionResult> r = immerse(s, d.pairs, d.wound.edges, options, {});
  if (!r) return r.error().message;
  const std::string wrong = check(s, r.value().mesh);
  if (out) *out = std::move(r).value();
  return wrong;
}

}  // namespace overtet::test
