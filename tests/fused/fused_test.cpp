// The fused mesh: every place that the surface winds around is there once.
#include "overtet/fused.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <map>

#include "kernels/predicates/predicates.h"
#include "tests/support/flow_surfaces.h"

namespace overtet {
namespace {

double volume(const TetMesh& m, Eigen::Index t) {
  const Eigen::Vector3d a = m.V.row(m.T(t, 0)), b = m.V.row(m.T(t, 1)), c = m.V.row(m.T(t, 2)),
                        d = m.V.row(m.T(t, 3));
  return (b - a).cross(c - a).dot(d - a) / 6;
}

// Two spheres of one surface, the second moved along x.
Surface two_spheres(double by) {
  const Surface one = test::icosphere(2);
  const Eigen::Index n = one.V.rows(), f = one.F.rows();
  Surface s{VertexMatrix(2 * n, 3), TriangleMatrix(2 * f, 3)};
  s.V << one.V, one.V.rowwise() + Eigen::RowVector3d(by, 0.013, -0.021);
  s.F << one.F, one.F.array() + static_cast<Index>(n);
  return s;
}

// The boundary's triangles are those faces of tets that only one has, outwards; every tet is positive.
void expect_sound(const LabelledTetMesh& mesh) {
  const TetMesh& m = mesh.mesh;
  std::map<std::array<Index, 3>, std::pair<int, std::array<Index, 3>>> faces;
  const int of_tet[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  for (Eigen::Index t = 0; t < m.T.rows(); ++t) {
    const auto at = [&](int k) { return m.V.data() + 3 * static_cast<std::ptrdiff_t>(m.T(t, k)); };
    ASSERT_NE(orient3d(at(0), at(1), at(2), at(3)), 0);
    ASSERT_GT(volume(m, t), 0) << "tet " << t;
    for (const auto& [i, j, k] : of_tet) {
      const std::array<Index, 3> face{m.T(t, i), m.T(t, j), m.T(t, k)};
      std::array<Index, 3> key = face;
      std::sort(key.begin(), key.end());
      auto& [count, as_seen] = faces[key];
      ++count;
      as_seen = face;
    }
  }
  const TriangleMatrix& F = mesh.attributes.triangles;
  Eigen::Index boundary = 0;
  for (const auto& [key, value] : faces) {
    ASSERT_LE(value.first, 2);
    boundary += value.first == 1;
  }
  ASSERT_EQ(boundary, F.rows());
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    std::array<Index, 3> key{F(f, 0), F(f, 1), F(f, 2)};
    std::sort(key.begin(), key.end());
    ASSERT_TRUE(faces.count(key));
    const auto& [count, face] = faces[key];
    ASSERT_EQ(count, 1);
    int at = 0;
    while (face[static_cast<std::size_t>(at)] != F(f, 0)) ++at;
    EXPECT_EQ(face[static_cast<std::size_t>((at + 1) % 3)], F(f, 1));
  }
}

TEST(FusedMesh, TwoSpheresBecomeOne) {
  const Surface s = two_spheres(1.3);
  for (const double degrees : {0.0, 17.0}) {
    const Result<FusedMesh> made = fused_mesh(s, {}, {degrees});
    ASSERT_TRUE(made.ok()) << made.error().message;
    const FusedMesh& m = made.value();
    expect_sound(m.mesh);
    EXPECT_EQ(m.surface_components, 2);
    EXPECT_EQ(m.components, 1);
    EXPECT_GT(m.cut_faces, 0);
    EXPECT_GT(m.inner_vertices, 0);
    double sum = 0, in_layers = 0;
    for (Eigen::Index t = 0; t < m.mesh.mesh.T.rows(); ++t) {
      sum += volume(m.mesh.mesh, t);
      in_layers += volume(m.mesh.mesh, t) * m.mesh.attributes.layers[static_cast<std::size_t>(t)];
    }
    EXPECT_NEAR(sum, m.volume, 1e-12 * sum);
    EXPECT_LT(m.volume, 0.95 * m.solid_volume);
    // No tet crosses the surface before the quality pass: the layers add up to the solid.
    if (degrees == 0) {
      EXPECT_NEAR(in_layers, m.solid_volume, 1e-10 * sum);
    }
    // Vertices and labels are where the surface has them.
    const MeshAttributes& told = m.mesh.attributes;
    Index known = 0;
    for (std::size_t v = 0; v < told.input_vertex.size(); ++v) {
      if (told.input_vertex[v] < 0) continue;
      ++known;
      EXPECT_EQ(m.mesh.mesh.V.row(static_cast<Eigen::Index>(v)), s.V.row(told.input_vertex[v]));
    }
    EXPECT_GT(known, degrees == 0 ? s.V.rows() - 1 : s.V.rows() / 2);
    for (std::size_t f = 0; f < told.labels.of.size(); ++f)
      EXPECT_EQ(told.labels.of[f], told.input_face[f] < s.F.rows() / 2 ? 1 : 2);
  }
}

TEST(FusedMesh, ASurfaceWithoutCrossingsKeepsItsSolid) {
  const Result<FusedMesh> made = fused_mesh(two_spheres(2.5));
  ASSERT_TRUE(made.ok()) << made.error().message;
  expect_sound(made.value().mesh);
  EXPECT_EQ(made.value().components, 2);
  EXPECT_EQ(made.value().cut_faces, 0);
  EXPECT_EQ(made.value().inner_vertices, 0);
  EXPECT_NEAR(made.value().volume, made.value().solid_volume, 1e-12 * made.value().volume);
}

TEST(FusedMesh, TheSameOnAnyNumberOfThreads) {
  const Surface s = two_spheres(1.1);
  RunContext one, three;
  one.threads = 1;
  three.threads = 3;
  const Result<FusedMesh> a = fused_mesh(s, {}, {}, one), b = fused_mesh(s, {}, {}, three);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a.value().mesh.mesh.V, b.value().mesh.mesh.V);
  EXPECT_EQ(a.value().mesh.mesh.T, b.value().mesh.mesh.T);
  EXPECT_EQ(a.value().mesh.attributes.layers, b.value().mesh.attributes.layers);
}

TEST(FusedMesh, SaysWhatIsWrong) {
  Surface s = test::icosphere(1);
  Surface turned = s;
  turned.F.col(1).swap(turned.F.col(2));
  EXPECT_EQ(fused_mesh(turned).error().code, ErrorCode::bad_input);
  EXPECT_EQ(fused_mesh(s, {}, {60}).error().code, ErrorCode::usage);
  s.F.conservativeResize(s.F.rows() - 1, 3);
  EXPECT_EQ(fused_mesh(s).error().code, ErrorCode::bad_input);
}

}  // namespace
}  // namespace overtet
