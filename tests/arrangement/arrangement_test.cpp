#include "src/arrangement/arrangement.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cstring>
#include <map>
#include <set>

#include "kernels/bvh/self_intersections.h"
#include "tests/support/immersed/shapes.h"

namespace overtet {
namespace {

using Eigen::Vector3d;

struct Named {
  const char* name;
  Surface surface;
  double rounding;  // how far pieces may be off their face, relative to the model's size
};

using test::shifted;

std::vector<Named> named_models() {
  const Surface tube = test::capsule(2, 0.5, 12), cube = test::box(2);
  return {
      {"sphere", test::sphere(1), 0},
      {"curled worm", test::curled_worm(410, 10), 1e-14},
      {"elbow", test::elbow(150, 14), 1e-14},
      {"knot", test::thick_knot(), 1e-14},
      {"slab", test::bent_slab(2, 390, 3), 1e-14},
      {"two spheres", test::two_spheres(2), 1e-14},
      {"equal tubes", test::joined(tube, tube), 0},
      {"tubes 1e-9 apart", test::joined(tube, shifted(tube, 1e-9, 2e-9, -1e-9)), 1e-7},
      {"boxes with a face in common", test::joined(cube, shifted(cube, 1, 0, 0)), 0},
      {"boxes that touch in part", test::joined(cube, shifted(cube, 1, 0.25, 0.125)), 1e-14},
      {"boxes that touch in an edge", test::joined(cube, shifted(cube, 1, 1, 0.25)), 1e-14},
      {"boxes that touch in a corner", test::joined(cube, shifted(cube, 1, 1, 1)), 0},
      {"boxes with sides in one plane", test::joined(cube, shifted(cube, 0.5, 0.25, 0)), 1e-14},
      {"saucer", test::saucer(2), 1e-14},
  };
}

Arrangement arranged(const Surface& s) {
  Result<Arrangement> a = arrange(s, find_self_intersections(s.V, s.F), {});
  EXPECT_TRUE(a.ok()) << (a.ok() ? "" : a.error().message);
  return a.ok() ? std::move(a).value() : Arrangement{};
}

double size_of(const Surface& s) { return (s.V.colwise().maxCoeff() - s.V.colwise().minCoeff()).maxCoeff(); }

Vector3d twice_area(const VertexMatrix& V, const TriangleMatrix& F, Index f) {
  const Vector3d a = V.row(F(f, 0)), b = V.row(F(f, 1)), c = V.row(F(f, 2));
  return (b - a).cross(c - a);
}

template <class Matrix>
bool same_bytes(const Matrix& a, const Matrix& b) {
  return a.rows() == b.rows() &&
         std::memcmp(a.data(), b.data(), sizeof(*a.data()) * static_cast<std::size_t>(a.size())) == 0;
}

TEST(Arrangement, HasNoIntersectionsAndNoTwoTrianglesAlike) {
  for (const Named& m : named_models()) {
    SCOPED_TRACE(m.name);
    const Arrangement a = arranged(m.surface);
    EXPECT_TRUE(find_self_intersections(a.V, a.F).empty());
    std::set<std::array<Index, 3>> seen;
    for (Index g = 0; g < a.F.rows(); ++g) {
      std::array<Index, 3> key{a.F(g, 0), a.F(g, 1), a.F(g, 2)};
      std::sort(key.begin(), key.end());
      EXPECT_TRUE(key[0] != key[1] && key[1] != key[2]);
      EXPECT_TRUE(seen.insert(key).second);
    }
    std::set<std::array<double, 3>> places;
    for (Index v = 0; v < a.V.rows(); ++v)
      EXPECT_TRUE(places.insert({a.V(v, 0), a.V(v, 1), a.V(v, 2)}).second) << "two vertices in one place";
  }
}

TEST(Arrangement, KeepsInputPositionsFirstAndToTheLastBit) {
  for (const Named& m : named_models()) {
    SCOPED_TRACE(m.name);
    const Arrangement a = arranged(m.surface);
    const Surface& s = m.surface;
    ASSERT_EQ(static_cast<Index>(a.vertex_of_input.size()), s.V.rows());
    std::vector<char> used(a.input_positions, 0);
    Index distinct = 0;
    for (Index v = 0; v < s.V.rows(); ++v) {
      const Index at = a.vertex_of_input[v];
      ASSERT_TRUE(at >= 0 && at < a.input_positions);
      EXPECT_EQ(0, std::memcmp(a.V.data() + 3 * at, s.V.data() + 3 * v, 3 * sizeof(double)));
      if (used[at]) continue;
      used[at] = 1;
      EXPECT_EQ(at, distinct++) << "not in order of appearance";
    }
    EXPECT_EQ(distinct, a.input_positions);
  }
}

TEST(Arrangement, PiecesLieInTheirFacesAndCoverThem) {
  for (const Named& m : named_models()) {
    SCOPED_TRACE(m.name);
    const Arrangement a = arranged(m.surface);
    const Surface& s = m.surface;
    const double size = size_of(s), off = std::max(m.rounding, 1e-15) * size;
    std::vector<Vector3d> sum(s.F.rows(), Vector3d::Zero());
    ASSERT_EQ(static_cast<Index>(a.sheet_begin.size()), a.F.rows() + 1);
    for (Index g = 0; g < a.F.rows(); ++g)
      for (Index i = a.sheet_begin[g]; i < a.sheet_begin[g + 1]; ++i) {
        const auto [face, sign] = a.sheets[i];
        ASSERT_TRUE(sign == 1 || sign == -1);
        sum[face] += sign * twice_area(a.V, a.F, g);
        const Vector3d n = twice_area(s.V, s.F, face).normalized(), o = s.V.row(s.F(face, 0));
        for (int k = 0; k < 3; ++k) {
          const Vector3d p = a.V.row(a.F(g, k));
          EXPECT_LE(std::abs(n.dot(p - o)), 4 * off);
          for (int e = 0; e < 3; ++e) {  // not beyond the face's edges
            const Vector3d b = s.V.row(s.F(face, e)), c = s.V.row(s.F(face, (e + 1) % 3));
            EXPECT_GE(n.cross(c - b).normalized().dot(p - b), -4 * off);
          }
        }
      }
    for (Index f = 0; f < s.F.rows(); ++f)
      EXPECT_LE((sum[f] - twice_area(s.V, s.F, f)).norm(), 64 * off * size) << "face " << f;
  }
}

// Along every edge as many sheets come as go: the winding number is the same on every way around it.
TEST(Arrangement, SheetsCloseAroundEveryEdge) {
  for (const Named& m : named_models()) {
    SCOPED_TRACE(m.name);
    const Arrangement a = arranged(m.surface);
    std::map<std::pair<Index, Index>, int> along;
    for (Index g = 0; g < a.F.rows(); ++g) {
      int layers = 0;
      for (Index i = a.sheet_begin[g]; i < a.sheet_begin[g + 1]; ++i) layers += a.sheets[i].sign;
      for (int k = 0; k < 3; ++k) {
        const Index u = a.F(g, k), v = a.F(g, (k + 1) % 3);
        along[std::minmax(u, v)] += u < v ? layers : -layers;
      }
    }
    for (const auto& [edge, layers] : along)
      EXPECT_EQ(layers, 0) << "edge " << edge.first << "-" << edge.second;
  }
}

TEST(Arrangement, IsTheSameEveryTime) {
  for (const Named& m : named_models()) {
    SCOPED_TRACE(m.name);
    const Arrangement a = arranged(m.surface), b = arranged(m.surface);
    EXPECT_TRUE(same_bytes(a.V, b.V));
    EXPECT_TRUE(same_bytes(a.F, b.F));
    EXPECT_EQ(a.sheet_begin, b.sheet_begin);
    ASSERT_EQ(a.sheets.size(), b.sheets.size());
    for (std::size_t i = 0; i < a.sheets.size(); ++i)
      EXPECT_TRUE(a.sheets[i].face == b.sheets[i].face && a.sheets[i].sign == b.sheets[i].sign);
  }
}

TEST(Arrangement, ScalingByPowersOfTwoScalesIt) {
  for (const Named& m : named_models()) {
    SCOPED_TRACE(m.name);
    const Arrangement a = arranged(m.surface);
    for (const double scale : {0x1p-40, 0x1p13}) {
      Surface s = m.surface;
      s.V *= scale;
      const Arrangement b = arranged(s);
      ASSERT_EQ(a.V.rows(), b.V.rows());
      EXPECT_TRUE(same_bytes(a.F, b.F));
      EXPECT_LE((a.V * scale - b.V).cwiseAbs().maxCoeff(), 1e-15 * scale * size_of(m.surface));
    }
  }
}

// Turning the axes is exact too. Where cuts end up within rounding of each other the numbers may differ, so
// only models whose arrangement needs one round are compared.
TEST(Arrangement, TurningTheAxesTurnsIt) {
  for (const Named& m : named_models()) {
    SCOPED_TRACE(m.name);
    const Arrangement a = arranged(m.surface);
    Surface s = m.surface;
    for (int k = 0; k < 3; ++k) s.V.col(k) = m.surface.V.col((k + 1) % 3);
    const Arrangement b = arranged(s);
    EXPECT_EQ(a.cut_faces, b.cut_faces);
    if (a.rounds > 1 || b.rounds > 1) continue;
    EXPECT_EQ(a.V.rows(), b.V.rows());
    EXPECT_EQ(a.F.rows(), b.F.rows());
    EXPECT_EQ(a.sheets.size(), b.sheets.size());
  }
}

TEST(Arrangement, OfAnEmbeddedSurfaceIsTheSurface) {
  const Surface s = test::torus(12, 8);
  const Arrangement a = arranged(s);
  EXPECT_TRUE(same_bytes(a.V, s.V));
  EXPECT_EQ(a.F.rows(), s.F.rows());
  EXPECT_EQ(a.cut_faces, 0);
}

TEST(Arrangement, StopsWhenAsked) {
  const Surface s = test::curled_worm(410, 10);
  RunContext context;
  context.deadline = RunContext::Clock::now();
  const auto a = arrange(s, find_self_intersections(s.V, s.F), context);
  ASSERT_FALSE(a.ok());
  EXPECT_EQ(a.error().code, ErrorCode::limit);
}

}  // namespace
}  // namespace overtet
