#include "src/immersion/boundary_recovery.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cstring>
#include <set>

#include "kernels/predicates/predicates.h"
#include "src/immersion/covering_complex.h"
#include "src/immersion/sheets.h"
#include "tests/support/immersed/shapes.h"

namespace overtet {
namespace {

Result<Cover> cover_of(const test::Prepared& p) {
  const Result<Sheets> sheets =
      assign_sheets(p.surface, p.arrangement, p.tets, p.diagnosis.wound.edges, 0, {});
  if (!sheets) return sheets.error();
  return build_cover(p.surface, p.arrangement, p.tets, sheets.value(), {});
}

// The cover is right by itself: it is a mesh of its own boundary, which is the surface cut up.
TEST(Cover, IsAMeshOfTheSurfaceCutUp) {
  for (const Surface& s : {test::curled_worm(410, 10), test::elbow(150, 14), test::thick_knot(),
                           test::two_spheres(1), test::bent_slab(2, 390, 3)}) {
    const test::Prepared p = test::prepared(s);
    const Result<Cover> cover = cover_of(p);
    ASSERT_TRUE(cover.ok()) << cover.error().message;
    const Cover& c = cover.value();
    ASSERT_EQ(c.mesh.surface_vertices, s.V.rows());
    EXPECT_EQ(0, std::memcmp(c.mesh.V.data(), s.V.data(), sizeof(double) * s.V.size()));
    ASSERT_EQ(c.boundary.size(), c.face.size());
    // Faces cut into pieces keep their area.
    std::vector<Eigen::Vector3d> area(s.F.rows(), Eigen::Vector3d::Zero());
    const auto twice = [](const VertexMatrix& V, Index a, Index b, Index d) {
      const Eigen::Vector3d p0 = V.row(a), p1 = V.row(b), p2 = V.row(d);
      return Eigen::Vector3d((p1 - p0).cross(p2 - p0));
    };
    for (std::size_t i = 0; i < c.boundary.size(); ++i)
      area[c.face[i]] += twice(c.mesh.V, c.boundary[i][0], c.boundary[i][1], c.boundary[i][2]);
    for (Index f = 0; f < s.F.rows(); ++f)
      EXPECT_LT((area[f] - twice(s.V, s.F(f, 0), s.F(f, 1), s.F(f, 2))).norm(), 1e-12);
    // As a mesh of its boundary it passes the exact check; points that only the boundary uses come first.
    std::vector<Index> number(c.mesh.V.rows(), -1);
    Index n = 0;
    for (Index v = 0; v < s.V.rows(); ++v) number[v] = n++;
    for (const auto& t : c.boundary)
      for (const Index v : t)
        if (number[v] < 0) number[v] = n++;
    Surface cut;
    cut.F.resize(static_cast<Index>(c.boundary.size()), 3);
    for (std::size_t i = 0; i < c.boundary.size(); ++i)
      for (int k = 0; k < 3; ++k) cut.F(static_cast<Index>(i), k) = number[c.boundary[i][k]];
    const Index on_boundary = n;
    for (Index& v : number)
      if (v < 0) v = n++;
    TetMesh mesh;
    mesh.V.resize(c.mesh.V.rows(), 3);
    for (Index v = 0; v < c.mesh.V.rows(); ++v) mesh.V.row(number[v]) = c.mesh.V.row(v);
    mesh.T = c.mesh.T;
    for (Index t = 0; t < mesh.T.rows(); ++t)
      for (int k = 0; k < 4; ++k) mesh.T(t, k) = number[mesh.T(t, k)];
    mesh.surface_vertices = on_boundary;
    cut.V = mesh.V.topRows(on_boundary);
    EXPECT_EQ(test::check(cut, mesh), "");
  }
}

TEST(BoundaryPoints, LeaveTheInputAsBoundary) {
  for (const Surface& s : {test::curled_worm(410, 10), test::elbow(150, 14), test::two_spheres(1)}) {
    const test::Prepared p = test::prepared(s);
    const Result<Cover> cover = cover_of(p);
    ASSERT_TRUE(cover.ok()) << cover.error().message;
    const Cover& c = cover.value();
    std::set<Index> added;
    for (const auto& t : c.boundary)
      for (const Index v : t)
        if (v >= s.V.rows()) added.insert(v);
    ASSERT_FALSE(added.empty());
    TetComplex complex(c.mesh.V, c.mesh.T);
    const BoundaryPointsResult r = clear_boundary_points(s, complex, c.boundary, c.face, {});
    EXPECT_TRUE(r.left.empty());
    EXPECT_GE(r.removed, static_cast<Index>(added.size()));  // halving an edge can add more
    EXPECT_GT(r.smallest_clearance, 0);
    complex.compact(static_cast<Index>(s.V.rows()));
    EXPECT_EQ(test::check(s, complex.to_mesh(static_cast<Index>(s.V.rows()))), "");
  }
}

// A point on an edge of the surface under a tet that is as good as flat, so far from the origin that doubles
// are whole numbers: between the point and the face above it there is none. Only when the edge above it has
// gone can it move.
TEST(BoundaryPoints, WhatAFlatTetHoldsIsSetFree) {
  constexpr double kWide = 1 << 24, kFar = 0x1p52;
  const auto place = [&](int x, int y, double z) {
    return Eigen::RowVector3d(kWide * (kFar + x), kWide * (kFar + y), kFar + z);
  };
  enum : Index { d, e, a, b, top, point };
  VertexMatrix V(6, 3);
  V.row(d) = place(0, 1, 0);
  V.row(e) = place(0, -1, 0);
  V.row(a) = place(-1, 0, 1);
  V.row(b) = place(1, 1, 0);
  V.row(top) = place(0, 0, 4 * kWide);
  V.row(point) = place(0, 0, 0);
  Surface s;
  s.V = V.topRows(5);
  s.F.resize(6, 3);
  s.F << e, a, d, e, d, b, a, e, top, d, a, top, b, d, top, e, b, top;
  TetMatrix T(5, 4);
  T << point, a, b, d, point, b, a, top, point, a, e, top, point, e, b, top, a, b, d, top;
  for (Index t = 0; t < T.rows(); ++t)
    if (orient3d(V.row(T(t, 0)).data(), V.row(T(t, 1)).data(), V.row(T(t, 2)).data(), V.row(T(t, 3)).data()) <
        0)
      std::swap(T(t, 2), T(t, 3));
  const std::vector<std::array<Index, 3>> boundary{{e, a, point}, {point, a, d}, {e, point, b}, {point, d, b},
                                                   {a, e, top},   {d, a, top},   {b, d, top},   {e, b, top}};
  TetComplex complex(V, T);
  const BoundaryPointsResult r = clear_boundary_points(s, complex, boundary, {0, 0, 1, 1, 2, 3, 4, 5}, {});
  EXPECT_TRUE(r.left.empty());
  EXPECT_EQ(r.removed, 1);
  EXPECT_FALSE(complex.has_edge(a, b));
  complex.compact(5);
  EXPECT_EQ(test::check(s, complex.to_mesh(5)), "");
}

TEST(BoundaryPoints, NothingToDoChangesNothing) {
  const Surface s = test::sphere(1);
  const test::Prepared p = test::prepared(s);
  const Result<Cover> cover = cover_of(p);
  ASSERT_TRUE(cover.ok()) << cover.error().message;
  TetComplex complex(cover.value().mesh.V, cover.value().mesh.T);
  const BoundaryPointsResult r =
      clear_boundary_points(s, complex, cover.value().boundary, cover.value().face, {});
  EXPECT_EQ(r.removed, 0);
  EXPECT_EQ(r.refined_edges, 0);
  EXPECT_TRUE(r.left.empty());
  EXPECT_EQ(complex.tet_count(), cover.value().mesh.T.rows());
}

}  // namespace
}  // namespace overtet
