#include "src/mesh/topology.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/models.h"

namespace overtet {
namespace {

bool mentions(const TopologyCheck& check, const std::string& text) {
  for (const std::string& problem : check.problems)
    if (problem.find(text) != std::string::npos) return true;
  return false;
}

void drop_face(Surface& s, Index f) {
  const Index last = static_cast<Index>(s.F.rows()) - 1;
  s.F.row(f) = s.F.row(last);
  s.F.conservativeResize(last, 3);
}

Surface tetrahedron() {
  Surface s;
  s.V.resize(4, 3);
  s.V << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  s.F.resize(4, 3);
  s.F << 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3;
  return s;
}

TEST(Topology, CleanModelsHaveTheirGenus) {
  struct Case {
    Surface surface;
    Index genus;
  };
  for (const Case& c : {Case{test::sphere(2), 0}, Case{test::torus(), 1}, Case{test::slab(3), 3},
                        Case{tetrahedron(), 0}, Case{test::curled_worm(), 0}}) {
    const TopologyCheck check = check_topology(c.surface);
    ASSERT_TRUE(check.ok()) << check.problems.front();
    ASSERT_EQ(check.topology.components.size(), 1u);
    EXPECT_EQ(check.topology.components[0].genus, c.genus);
    EXPECT_EQ(check.topology.components[0].faces, c.surface.F.rows());
    EXPECT_EQ(check.topology.components[0].vertices, c.surface.V.rows());
    EXPECT_TRUE(require_topology(c.surface).ok());
  }
}

TEST(Topology, AdjacencyIsConsistent) {
  const Surface s = test::torus(12, 8);
  const TopologyCheck check = check_topology(s);
  ASSERT_TRUE(check.ok());
  const SurfaceTopology& t = check.topology;
  for (Index h = 0; h < 3 * s.F.rows(); ++h) {
    EXPECT_EQ(t.twin[t.twin[h]], h);
    EXPECT_EQ(half_edge_source(s.F, t.twin[h]), half_edge_target(s.F, h));
    EXPECT_EQ(half_edge_target(s.F, next_half_edge(h)), half_edge_opposite(s.F, h));
    EXPECT_EQ(previous_half_edge(next_half_edge(h)), h);
    EXPECT_EQ(find_half_edge(s.F, t, half_edge_source(s.F, h), half_edge_target(s.F, h)), h);
  }
  Index sum = 0;
  for (Index v = 0; v < s.V.rows(); ++v) {
    const auto around = half_edges_around(t, v);
    sum += static_cast<Index>(around.size());
    for (std::size_t i = 0; i < around.size(); ++i) {
      EXPECT_EQ(half_edge_source(s.F, around[i]), v);
      // Counter-clockwise: the next one ends where this face's third corner is.
      EXPECT_EQ(half_edge_target(s.F, around[(i + 1) % around.size()]), half_edge_opposite(s.F, around[i]));
    }
  }
  EXPECT_EQ(sum, 3 * s.F.rows());
  EXPECT_EQ(find_half_edge(s.F, t, 0, 0), -1);
}

TEST(Topology, SeveralComponents) {
  const Surface s = test::joined(test::joined(test::sphere(1), test::torus()), test::slab(2));
  const TopologyCheck check = check_topology(s);
  ASSERT_TRUE(check.ok());
  ASSERT_EQ(check.topology.components.size(), 3u);
  EXPECT_EQ(check.topology.components[1].genus, 1);
  EXPECT_EQ(check.topology.components[2].genus, 2);
}

TEST(Topology, AHoleIsNamed) {
  Surface s = test::sphere(1);
  drop_face(s, 17);
  const TopologyCheck check = check_topology(s);
  EXPECT_FALSE(check.closed);
  EXPECT_TRUE(check.manifold_edges);
  EXPECT_TRUE(mentions(check, "hole"));
  const auto required = require_topology(s);
  ASSERT_FALSE(required.ok());
  EXPECT_EQ(required.error().code, ErrorCode::bad_input);
}

TEST(Topology, AnEdgeWithThreeFaces) {
  Surface s = test::joined(tetrahedron(), tetrahedron());
  for (Index f = 4; f < 8; ++f)  // glue vertices 4, 5 onto 0, 1
    for (int k = 0; k < 3; ++k)
      if (s.F(f, k) < 6) s.F(f, k) -= 4;
  const TopologyCheck check = check_topology(s);
  EXPECT_FALSE(check.manifold_edges);
  EXPECT_TRUE(mentions(check, "shared by 4 faces"));
}

TEST(Topology, ATurnedFace) {
  Surface s = test::sphere(1);
  std::swap(s.F(5, 0), s.F(5, 1));
  const TopologyCheck check = check_topology(s);
  EXPECT_TRUE(check.closed);
  EXPECT_FALSE(check.oriented);
  EXPECT_TRUE(mentions(check, "not oriented consistently"));
}

TEST(Topology, AVertexThatJoinsTwoParts) {
  Surface s = test::joined(tetrahedron(), tetrahedron());
  for (Index f = 4; f < 8; ++f)
    for (int k = 0; k < 3; ++k)
      if (s.F(f, k) == 4) s.F(f, k) = 0;
  TopologyCheck check = check_topology(s);
  EXPECT_FALSE(check.manifold_vertices);
  EXPECT_TRUE(mentions(check, "Vertex 0 joins"));
  EXPECT_TRUE(check.closed && check.oriented && check.manifold_edges);
}

TEST(Topology, AVertexWithoutFaces) {
  Surface s = tetrahedron();
  s.V.conservativeResize(5, 3);
  s.V.row(4) << 9, 9, 9;
  const TopologyCheck check = check_topology(s);
  EXPECT_FALSE(check.ok());
  EXPECT_TRUE(mentions(check, "Vertex 4 belongs to no face"));
}

TEST(Topology, BadIndicesAndNumbers) {
  Surface s = tetrahedron();
  s.F(2, 1) = 4;
  EXPECT_TRUE(mentions(check_topology(s), "Face 2"));
  s.F(2, 1) = -1;
  EXPECT_FALSE(check_topology(s).indices_valid);
  s.F(2, 1) = s.F(2, 0);
  EXPECT_TRUE(mentions(check_topology(s), "the same vertex twice"));
  s = tetrahedron();
  s.V(3, 1) = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(mentions(check_topology(s), "Vertex 3"));
  EXPECT_FALSE(check_topology(Surface{VertexMatrix(0, 3), TriangleMatrix(0, 3)}).ok());
}

TEST(Topology, DuplicateFaces) {
  Surface s = test::sphere(1);
  s.F.conservativeResize(s.F.rows() + 1, 3);
  s.F.row(s.F.rows() - 1) << s.F(3, 1), s.F(3, 2), s.F(3, 0);
  const TopologyCheck check = check_topology(s);
  ASSERT_EQ(check.duplicate_faces.size(), 1u);
  EXPECT_EQ(check.duplicate_faces[0], (std::pair<Index, Index>(3, static_cast<Index>(s.F.rows()) - 1)));
  // Two triangles back to back are closed and oriented, and duplicates all the same.
  Surface pillow;
  pillow.V.resize(3, 3);
  pillow.V << 0, 0, 0, 1, 0, 0, 0, 1, 0;
  pillow.F.resize(2, 3);
  pillow.F << 0, 1, 2, 2, 1, 0;
  EXPECT_EQ(check_topology(pillow).duplicate_faces.size(), 1u);
}

TEST(Topology, FacesWithoutArea) {
  Surface s = test::box(2);
  EXPECT_TRUE(degenerate_faces(s).empty());
  s.V.row(s.F(7, 0)) = s.V.row(s.F(7, 1));
  const auto flat = degenerate_faces(s);
  EXPECT_TRUE(std::find(flat.begin(), flat.end(), 7) != flat.end());
}

}  // namespace
}  // namespace overtet
