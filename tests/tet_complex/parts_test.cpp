#include "src/tet_complex/parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "tests/support/tet_checks/tet_checks.h"
#include "tests/support/tet_shapes.h"

namespace overtet {
namespace {

std::vector<Index> all_tets(const TetMesh& mesh) {
  std::vector<Index> tets(mesh.T.rows());
  std::iota(tets.begin(), tets.end(), 0);
  return tets;
}

TetMesh sorted_tets(TetMesh mesh) {
  std::vector<std::array<Index, 4>> rows;
  for (Index t = 0; t < mesh.T.rows(); ++t)
    rows.push_back({mesh.T(t, 0), mesh.T(t, 1), mesh.T(t, 2), mesh.T(t, 3)});
  std::sort(rows.begin(), rows.end());
  for (Index t = 0; t < mesh.T.rows(); ++t)
    for (int k = 0; k < 4; ++k) mesh.T(t, k) = rows[t][k];
  return mesh;
}

TEST(Parts, TakenAndPutBackTheMeshIsTheSame) {
  TetMesh mesh = test::bent_grid(4, 400, 0.2, 2);
  mesh.surface_vertices = 0;
  const TetMesh before = sorted_tets(mesh);
  for (const int count : {1, 2, 8}) {
    const std::vector<int> part_of = halve(mesh, all_tets(mesh), count);
    std::vector<std::int64_t> sizes(count, 0);
    for (const int p : part_of) ++sizes.at(p);
    EXPECT_LE(*std::max_element(sizes.begin(), sizes.end()),
              *std::min_element(sizes.begin(), sizes.end()) + 1);
    const auto parts = take_parts(mesh, part_of, count);
    put_parts(mesh, part_of, parts);
    const TetMesh after = sorted_tets(mesh);
    EXPECT_EQ(before.V, after.V);
    EXPECT_EQ(before.T, after.T);
  }
}

TEST(Parts, TetsThatAreNotChosenStay) {
  TetMesh mesh = test::bent_grid(4, 400, 0.2, 2);
  std::vector<Index> some;
  for (Index t = 0; t < mesh.T.rows(); t += 3) some.push_back(t);
  const std::vector<int> part_of = halve(mesh, some, 2);
  EXPECT_EQ(static_cast<std::ptrdiff_t>(mesh.T.rows()) - static_cast<std::ptrdiff_t>(some.size()),
            std::count(part_of.begin(), part_of.end(), -1));
  auto parts = take_parts(mesh, part_of, 2);
  for (const MeshPart& part : parts)
    for (Index v = 0; v < part.complex.vertex_count(); ++v) {
      bool outside = false;
      for (Index t = 0; t < mesh.T.rows(); ++t)
        outside = outside ||
                  (part_of[t] != (&part - parts.data()) && (mesh.T.row(t).array() == part.vertex[v]).any());
      ASSERT_EQ(outside, std::binary_search(part.shared.begin(), part.shared.end(), v));
    }
}

// Tets dealt out at random make parts that hang together at vertices and edges only.
TEST(Parts, OperationsInRandomPartsKeepTheWholeValid) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    TetMesh mesh = test::bent_grid(4, 200, 0.2, seed);
    const auto boundary = test::boundary_faces(TetComplex(mesh.V, mesh.T));
    std::mt19937 random(seed);
    std::int64_t changes = 0;
    for (int round = 0; round < 4; ++round) {
      std::vector<int> part_of = halve(mesh, all_tets(mesh), 4);
      if (round % 2 == 1)
        for (int& p : part_of)
          if (random() % 4 == 0) p = static_cast<int>(random() % 4);
      auto parts = take_parts(mesh, part_of, 4);
      for (MeshPart& part : parts) {
        LocalOperations work(part.complex);
        part.mark_shared(work);
        for (Index t = 0; t < part.complex.tet_capacity(); ++t) {
          static constexpr int kEdges[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
          const auto& e = kEdges[random() % 6];
          const auto c = part.complex.tet(t);
          if (part.complex.alive(t)) changes += work.flip_23(t, static_cast<int>(random() % 4));
          if (part.complex.alive(t) && part.complex.tet(t) == c)
            changes += work.remove_edge(t, c[e[0]], c[e[1]]);
          if (part.complex.alive(t) && part.complex.tet(t) == c) changes += work.collapse(c[e[0]], c[e[1]]);
          if (part.complex.alive(t) && part.complex.tet(t) == c)
            changes += work.insert_at_edge(t, c[e[0]], c[e[1]]);
          if (part.complex.alive(t) && part.complex.tet(t) == c) changes += work.smooth(c[e[0]]);
        }
      }
      put_parts(mesh, part_of, parts);
      const TetComplex whole(mesh.V, mesh.T);
      test::expect_valid(whole);
      EXPECT_EQ(boundary.size(), test::boundary_faces(whole).size());
    }
    EXPECT_GT(changes, 100);
  }
}

}  // namespace
}  // namespace overtet
