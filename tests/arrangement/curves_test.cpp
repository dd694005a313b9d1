#include "src/arrangement/curves.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "kernels/parallel/parallel.h"
#include "src/certificates/winding_range.h"
#include "src/covering/hinges.h"
#include "src/exact/winding.h"
#include "tests/arrangement/studied.h"
#include "tests/support/noise.h"

namespace overtet {
namespace {

using test::shifted;
using test::three_spheres;

struct Traced : test::Studied {
  Curves curves;
  explicit Traced(Surface s) : Studied(std::move(s)), curves(trace_curves(surface, bvh, graph, {}).value()) {}
};

// A thin tube that passes through a thick one: in and out.
Surface crossing_tubes() {
  const Surface tube = test::capsule(4, 0.5, 14);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(1.3, Eigen::Vector3d(0.2, 1, 0.1).normalized()).toRotationMatrix();
  Surface other = test::transformed(test::capsule(4, 0.3, 12), turn, Eigen::Vector3d::Zero());
  const Eigen::RowVector3d shift = tube.V.colwise().mean() - other.V.colwise().mean();
  other.V.rowwise() += shift + Eigen::RowVector3d(0.013, 0.027, 0.011);
  return test::joined(tube, other);
}

Eigen::Vector3d vec(const std::array<double, 3>& p) { return {p[0], p[1], p[2]}; }

Eigen::Vector3d where(const Surface& s, const SurfacePoint& p) {
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) x += p.barycentric[k] * s.V.row(s.F(p.face, k)).transpose();
  return x;
}

bool share_vertex(const Surface& s, Index f, Index g) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (s.F(f, i) == s.F(g, j)) return true;
  return false;
}

// Everything that curves.h promises, on whatever surface.
void check(const Traced& x) {
  const Surface& s = x.surface;
  const double size = s.V.cwiseAbs().maxCoeff();
  std::set<Index> hinges;
  for (const Hinge& h : find_hinges(s, x.topology, x.bvh, x.pairs)) hinges.insert(h.vertex);
  std::set<std::array<Index, 2>> crossing, all;
  int low = 0, high = 0;
  for (const Curve& c : x.curves.curves) {
    ASSERT_FALSE(c.segments.empty());
    ASSERT_EQ(c.nodes.size(), c.segments.size() + (c.closed ? 0 : 1));
    EXPECT_EQ(c.closed, c.ends[0] == Curve::End::none);
    EXPECT_EQ(c.closed, c.ends[1] == Curve::End::none);
    if (!c.closed) {
      for (const int end : {0, 1}) {
        const CurveNode& node = end == 0 ? c.nodes.front() : c.nodes.back();
        EXPECT_EQ(c.ends[end] == Curve::End::hinge, node.kind == CurveNode::Kind::hinge);
        if (node.kind == CurveNode::Kind::hinge) {
          EXPECT_EQ(hinges.count(node.vertex), 1u);
        }
      }
    }
    double length = 0;
    for (std::size_t i = 0; i < c.segments.size(); ++i) {
      const CurveSegment& segment = c.segments[i];
      const CurveNode &a = c.nodes[i], &b = c.nodes[(i + 1) % c.nodes.size()];
      length += (vec(a.position) - vec(b.position)).norm();
      std::array<Index, 2> pair = segment.faces;
      if (pair[0] > pair[1]) std::swap(pair[0], pair[1]);
      EXPECT_TRUE(std::binary_search(x.pairs.begin(), x.pairs.end(), FacePair(pair[0], pair[1])));
      // A pair has one segment, cut where other faces pass.
      if (!all.insert(pair).second) {
        EXPECT_EQ(a.kind, CurveNode::Kind::triple);
      }
      if (segment.crossing) crossing.insert(pair);
      for (int k = 0; k < 2; ++k) {
        for (const double part : a.on[k].barycentric) {
          EXPECT_GE(part, -1e-9);
          EXPECT_LE(part, 1 + 1e-9);
        }
        EXPECT_EQ(a.on[k].face, segment.faces[k]);
        EXPECT_LT((where(s, a.on[k]) - vec(a.position)).norm(), 1e-9 * size);
        // Sheets go on over an edge or a vertex of the surface.
        if (i > 0) {
          const Index before = c.segments[i - 1].faces[k];
          EXPECT_TRUE(before == segment.faces[k] || share_vertex(s, before, segment.faces[k]));
        }
      }
      EXPECT_TRUE(segment.winding_known);
      if (segment.crossing && !segment.winding_known) continue;
      low = std::min(low, segment.winding_min);
      high = std::max(high, segment.winding_max);
    }
    EXPECT_NEAR(c.length, length, 1e-9 * (1 + length));
  }
  // Every pair that has a segment is in a curve; those along edges stand for several.
  EXPECT_LE(all.size(), x.pairs.size());
  IntersectionGraph graph(s, x.topology, x.bvh, x.pairs);
  const WindingRange range = find_winding_range(s, x.topology, x.bvh, graph, {}).value();
  // Pairs without a piece of curve touch in a point or lie on each other.
  EXPECT_GE(x.curves.touching_pairs + x.curves.coplanar_pairs, range.touching_pairs);
  if (x.topology.components.size() == 1 && !x.pairs.empty() && x.curves.coplanar_pairs == 0) {
    EXPECT_EQ(low, range.min);
    EXPECT_EQ(high, std::max(range.max, 0));
  }
  for (std::size_t j = 0; j < x.curves.junctions.size(); ++j) {
    const Junction& junction = x.curves.junctions[j];
    EXPECT_GE(junction.strands.size(), 2u);
    for (const auto& [c, i] : junction.strands) {
      const CurveNode& node = x.curves.curves[c].nodes[i];
      EXPECT_EQ(node.junction, static_cast<Index>(j));
      EXPECT_EQ(node.position, junction.position);
    }
  }
}

// The winding numbers around every segment, from points next to its middle. The points are far away compared
// with rounding, and near compared with the faces.
void check_windings(const Traced& x) {
  const WindingNumber winding(x.surface, x.bvh);
  int looked = 0;
  for (const Curve& c : x.curves.curves)
    for (std::size_t i = 0; i < c.segments.size(); ++i) {
      const CurveSegment& segment = c.segments[i];
      const Eigen::Vector3d a = vec(c.nodes[i].position), b = vec(c.nodes[(i + 1) % c.nodes.size()].position);
      if ((b - a).norm() < 1e-4) continue;
      Eigen::Vector3d n[2];
      for (int k = 0; k < 2; ++k) {
        const auto corner = [&](int j) -> Eigen::Vector3d {
          return x.surface.V.row(x.surface.F(segment.faces[k], j));
        };
        n[k] = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
      }
      if (n[0].cross(n[1]).norm() < 0.02) continue;
      ++looked;
      for (const int p : {1, -1})
        for (const int q : {1, -1}) {
          const Eigen::Vector3d m = (a + b) / 2 + 1e-8 * (p * n[0] + q * n[1]);
          const auto w = winding.at(m.data());
          ASSERT_TRUE(w.has_value());
          EXPECT_EQ(*w, segment.winding_min + (p < 0) + (q < 0));
        }
    }
  EXPECT_GT(looked, 10);
}

TEST(Curves, NoneOnAnEmbeddedSurface) {
  const Traced x(test::torus(16, 8));
  EXPECT_TRUE(x.curves.curves.empty());
  EXPECT_EQ(x.curves.length, 0);
}

TEST(Curves, CrossingTubesHaveTwoClosedCurves) {
  const Traced x(crossing_tubes());
  check(x);
  check_windings(x);
  EXPECT_EQ(x.curves.curves.size(), 2u);
  EXPECT_EQ(x.curves.closed(), 2);
  EXPECT_TRUE(x.curves.junctions.empty());
  for (const Curve& c : x.curves.curves) {
    EXPECT_FALSE(c.sheets_swap);
    EXPECT_EQ(c.winding_min, 0);
    EXPECT_EQ(c.winding_max, 2);
    // One sheet on each tube.
    for (const CurveSegment& segment : c.segments)
      EXPECT_NE(x.topology.component_of_face[segment.faces[0]],
                x.topology.component_of_face[segment.faces[1]]);
    for (const int k : {0, 1}) {
      std::set<Index> components;
      for (const CurveSegment& segment : c.segments)
        components.insert(x.topology.component_of_face[segment.faces[k]]);
      EXPECT_EQ(components.size(), 1u);
    }
  }
}

TEST(Curves, TwoSpheresCrossInACircle) {
  const Traced x(
      test::transformed(test::two_spheres(3, 1.1), test::some_rotation(3), Eigen::Vector3d(1, 2, 3)));
  check(x);
  check_windings(x);
  ASSERT_EQ(x.curves.curves.size(), 1u);
  EXPECT_TRUE(x.curves.curves[0].closed);
  const double circle = 2 * std::acos(-1.0) * std::sqrt(1 - 0.55 * 0.55);
  EXPECT_NEAR(x.curves.length, circle, 0.02 * circle);
}

TEST(Curves, ElbowsGoFromHingeToHinge) {
  int hinge_to_hinge = 0;
  for (const double degrees : {110.0, 130.0, 150.0}) {
    const Traced x(test::noisy(test::elbow(degrees, 14), 7, 1e-3));
    check(x);
    check_windings(x);
    hinge_to_hinge += x.curves.hinge_to_hinge();
    // Every hinge has as many ends as its link crosses itself.
    std::map<Index, std::size_t> ends;
    for (const Curve& c : x.curves.curves) {
      if (c.ends[0] == Curve::End::hinge) ++ends[c.nodes.front().vertex];
      if (c.ends[1] == Curve::End::hinge) ++ends[c.nodes.back().vertex];
    }
    for (const Hinge& h : find_hinges(x.surface, x.topology, x.bvh, x.pairs))
      EXPECT_EQ(ends[h.vertex], h.crossings.size()) << h.vertex;
  }
  EXPECT_GT(hinge_to_hinge, 0);
}

TEST(Curves, ThreeSpheresMeetInTriplePoints) {
  const Traced x(three_spheres(2));
  check(x);
  check_windings(x);
  EXPECT_EQ(x.curves.curves.size(), 3u);
  EXPECT_EQ(x.curves.closed(), 3);
  EXPECT_EQ(x.curves.triple_points(), 2);
  for (const Junction& j : x.curves.junctions) {
    ASSERT_EQ(j.strands.size(), 3u);
    std::set<Index> curves;
    for (const auto& [c, i] : j.strands) {
      curves.insert(c);
      EXPECT_EQ(x.curves.curves[c].nodes[i].kind, CurveNode::Kind::triple);
    }
    EXPECT_EQ(curves.size(), 3u);
  }
}

// Special position: corners on faces, edges on edges, faces on faces. Nothing is lost, nothing crashes.
TEST(Curves, SpecialPositions) {
  const Surface cube = test::box(2);
  const std::pair<const char*, Surface> models[] = {
      {"crossing cubes on a grid", test::joined(cube, shifted(cube, 0.5, 0.5, 0.5))},
      {"cubes that cross along edges", test::joined(cube, shifted(cube, 0.25, 0.5, 0.125))},
      {"cubes with a face in common", test::joined(cube, shifted(cube, 1, 0, 0))},
      {"cubes that touch in part", test::joined(cube, shifted(cube, 1, 0.25, 0.125))},
      {"cubes that touch in an edge", test::joined(cube, shifted(cube, 1, 1, 0.25))},
      {"cubes that touch in a corner", test::joined(cube, shifted(cube, 1, 1, 1))},
      {"cubes with sides in one plane", test::joined(cube, shifted(cube, 0.5, 0.25, 0))},
      {"equal cubes", test::joined(cube, cube)},
      {"elbow", test::elbow(150, 12)},
      {"spheres on a grid", test::two_spheres(2, 1)}};
  for (const auto& [name, s] : models) {
    SCOPED_TRACE(name);
    check(Traced(s));
  }
}

TEST(Curves, RandomNoise) {
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6}) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const Traced x(test::noisy(test::sphere(1), seed, 0.3 + 0.2 * static_cast<double>(seed)));
    check(x);
    if (!x.pairs.empty()) check_windings(x);
  }
}

TEST(Curves, DoNotDependOnTheOrderOfVertices) {
  const Surface s = test::noisy(test::elbow(150, 14), 3, 0.05);
  const Traced x(s), y(test::permuted(s, 9));
  EXPECT_EQ(x.curves.curves.size(), y.curves.curves.size());
  EXPECT_EQ(x.curves.closed(), y.curves.closed());
  EXPECT_EQ(x.curves.hinge_to_hinge(), y.curves.hinge_to_hinge());
  EXPECT_EQ(x.curves.junctions.size(), y.curves.junctions.size());
  EXPECT_NEAR(x.curves.length, y.curves.length, 1e-9);
}

TEST(Curves, SameOnAnyNumberOfThreads) {
  const Surface s = test::noisy(test::elbow(150, 14), 3, 0.05);
  std::set<std::vector<double>> seen;
  for (const int threads : {1, 2, 8}) {
    const ScopedThreads cap(threads);
    const Traced x(s);
    std::vector<double> numbers;
    for (const Curve& c : x.curves.curves)
      for (std::size_t i = 0; i < c.segments.size(); ++i) {
        numbers.insert(numbers.end(), c.nodes[i].position.begin(), c.nodes[i].position.end());
        numbers.push_back(c.segments[i].winding_min);
        numbers.push_back(c.segments[i].faces[0]);
      }
    seen.insert(numbers);
  }
  EXPECT_EQ(seen.size(), 1u);
}

}  // namespace
}  // namespace overtet
