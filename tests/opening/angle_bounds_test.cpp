#include "src/opening/angle_bounds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "kernels/core/tet_tables.h"
#include "kernels/tet_energy/tet_quality.h"
#include "src/opening/opening.h"

namespace overtet {
namespace {

// A tet, and its surface.
struct One {
  TetMesh mesh;
  TriangleMatrix F;
};

One one_tet(const VertexMatrix& V) {
  One out;
  out.mesh.V = V;
  out.mesh.T.resize(1, 4);
  out.mesh.T << 0, 1, 2, 3;
  out.mesh.surface_vertices = 4;
  out.F.resize(4, 3);
  for (int k = 0; k < 4; ++k) out.F.row(k) << kTetFace[k][0], kTetFace[k][1], kTetFace[k][2];
  return out;
}

VertexMatrix corners(double height) {
  VertexMatrix V(4, 3);
  V << 0, 0, 0, 1, 0, 0, 0.4, 1, 0, 0.4, 0.3, height;
  return V;
}

double angle(const VertexMatrix& V, int edge) {
  return dihedral_angles(V.row(0), V.row(1), V.row(2), V.row(3))[static_cast<std::size_t>(edge)] * 180 /
         EIGEN_PI;
}

TEST(AngleBounds, UntouchedEdgesBoundWhatIsElsewhere) {
  const VertexMatrix V = corners(0.1);
  const One one = one_tet(V);
  const AngleBounds b = angle_bounds(one.mesh, one.F, V, 1);
  double least = 90;
  for (int e = 0; e < 6; ++e) least = std::min(least, angle(V, e));
  EXPECT_NEAR(b.elsewhere, least, 1e-9);
  EXPECT_EQ(b.as_moved, kRegularAngle);
  EXPECT_EQ(b.at_moved, kRegularAngle);
}

TEST(AngleBounds, NoPlaceWithinReachHasMore) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-1, 1);
  const VertexMatrix home = corners(0.3);
  for (const double reach : {0.01, 0.1, 0.2}) {
    const auto moved = [&] {
      VertexMatrix V = home;
      Eigen::RowVector3d d;
      do d << number(random), number(random), number(random);
      while (d.norm() > 1);
      V.row(3) += reach * d;
      return V;
    };
    for (int i = 0; i < 200; ++i) {
      SCOPED_TRACE(i);
      const One here = one_tet(moved());
      const AngleBounds b = angle_bounds(here.mesh, here.F, home, reach);
      EXPECT_EQ(b.elsewhere, kRegularAngle);  // the vertex is in three faces, and every edge at one of them
      double all = 90;
      for (int e = 0; e < 6; ++e) all = std::min(all, angle(here.mesh.V, e));
      EXPECT_NEAR(b.as_moved, all, 1e-9);
      EXPECT_LE(least_angle_at_moved(here.mesh, home), b.as_moved + 1e-9);
      // Edges 0, 1 and 3 have not moved.
      const VertexMatrix there = moved();
      EXPECT_LE(std::min({angle(there, 0), angle(there, 1), angle(there, 3)}), b.at_moved + 1e-9);
    }
  }
}

}  // namespace
}  // namespace overtet
