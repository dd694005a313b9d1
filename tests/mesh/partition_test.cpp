#include "src/mesh/partition.h"
#include "kernels/core/tet_tables.h"

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
  for (const int count : {1, 2, 5, 8}) {
    const std::vector<int> part_of = cut_apart(mesh, all_tets(mesh), count, 0.1);
    const auto parts = take_parts(mesh, part_of, count);
    put_parts(mesh, part_of, parts);
    const TetMesh after = sorted_tets(mesh);
    EXPECT_EQ(before.V, after.V);
    EXPECT_EQ(before.T, after.T);
  }
}

TEST(Parts, CutsLeaveTheWeightThatIsAskedForOnBothSides) {
  const TetMesh mesh = test::bent_grid(12, 0, 0.2, 3);
  const std::vector<Index> chosen = all_tets(mesh);
  for (const unsigned seed : {1u, 2u, 3u}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    std::vector<int> weight;
    for (const Index t : chosen) weight.push_back(mesh.V(mesh.T(t, 0), 0) > 0.5 ? 1 + random() % 20 : 1);
    for (const int count : {2, 3}) {
      const std::vector<int> part_of = cut_apart(mesh, chosen, count, 0.1, weight);
      std::vector<double> load(count, 0);
      for (std::size_t i = 0; i < chosen.size(); ++i) load.at(part_of[i]) += weight[i];
      const double all = std::accumulate(load.begin(), load.end(), 0.0);
      for (const double l : load) EXPECT_NEAR(1.0 / count, l / all, 0.15);
    }
  }
}

TEST(Parts, CutsMeetLittleWeight) {
  // Two balls of tets, joined by a neck of one layer: the plane goes through the neck.
  const TetMesh grid = test::bent_grid(12, 0, 0, 1);
  const Eigen::RowVector3d low = grid.V.colwise().minCoeff(), size = grid.V.colwise().maxCoeff() - low;
  std::vector<Index> chosen;
  for (Index t = 0; t < grid.T.rows(); ++t) {
    Eigen::RowVector3d at = Eigen::RowVector3d::Zero();
    for (int k = 0; k < 4; ++k) at += (grid.V.row(grid.T(t, k)) - low).cwiseQuotient(size) / 4;
    const bool neck = at[1] < 0.2 && at[2] < 0.2;
    if (neck || at[0] < 0.45 || at[0] > 0.6) chosen.push_back(t);
  }
  const auto shared = [&](const std::vector<Index>& tets) {
    const std::vector<int> part_of = cut_apart(grid, tets, 2, 0.15);
    std::vector<int> seen(static_cast<std::size_t>(grid.V.rows()), 0);
    for (const Index t : tets)
      for (int k = 0; k < 4; ++k) seen[grid.T(t, k)] |= 1 << part_of[t];
    return std::count(seen.begin(), seen.end(), 3);
  };
  EXPECT_GT(shared(chosen), 0);
  EXPECT_LT(shared(chosen), shared(all_tets(grid)) / 2);
}

TEST(Parts, PiecesAreNotCutAndDealtOutByWeight) {
  const TetMesh mesh = test::bent_grid(12, 0, 0.2, 3);
  std::mt19937 random(5);
  std::vector<Index> chosen;
  std::vector<int> weight;
  for (Index t = 0; t < mesh.T.rows(); ++t)
    if (random() % 40 == 0) {
      chosen.push_back(t);
      weight.push_back(1 + random() % 9);
    }
  const Pieces pieces = in_pieces(mesh, chosen, 4, weight);
  std::vector<int> part_at(static_cast<std::size_t>(mesh.V.rows()), -1);
  std::vector<double> load(4, 0);
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const int part = pieces.part_of[chosen[i]];
    load.at(part) += weight[i];
    for (int k = 0; k < 4; ++k) {
      int& here = part_at[mesh.T(chosen[i], k)];
      EXPECT_TRUE(here < 0 || here == part);
      here = part;
    }
  }
  const double all = std::accumulate(load.begin(), load.end(), 0.0);
  EXPECT_NEAR(pieces.uneven, 4 * *std::max_element(load.begin(), load.end()) / all, 1e-12);
  EXPECT_LT(pieces.uneven, 1.2);
  EXPECT_EQ(static_cast<std::ptrdiff_t>(chosen.size()),
            std::count_if(pieces.part_of.begin(), pieces.part_of.end(), [](int p) { return p >= 0; }));
}

TEST(Parts, TetsThatAreNotChosenStay) {
  TetMesh mesh = test::bent_grid(4, 400, 0.2, 2);
  std::vector<Index> some;
  for (Index t = 0; t < mesh.T.rows(); t += 3) some.push_back(t);
  const std::vector<int> part_of = cut_apart(mesh, some, 2, 0.1);
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
      std::vector<int> part_of = cut_apart(mesh, all_tets(mesh), 4, 0.1);
      if (round % 2 == 1)
        for (int& p : part_of)
          if (random() % 4 == 0) p = static_cast<int>(random() % 4);
      auto parts = take_parts(mesh, part_of, 4);
      for (MeshPart& part : parts) {
        LocalOperations work(part.complex);
        part.mark_shared(work);
        for (Index t = 0; t < part.complex.tet_capacity(); ++t) {
          const auto& e = kTetEdge[random() % 6];
          const auto c = part.complex.tet(t);
          if (part.complex.alive(t)) changes += work.flip_23(t, static_cast<int>(random() % 4));
          if (part.complex.alive(t) && part.complex.tet(t) == c)
            changes += work.remove_edge(t, c[e[0]], c[e[1]]);
          if (part.complex.alive(t) && part.complex.tet(t) == c) changes += work.collapse(c[e[0]], c[e[1]]);
          if (part.complex.alive(t) && part.complex.tet(t) == c)
            changes += work.insert_at_edge(t, c[e[0]], c[e[1]]);
          if (part.complex.alive(t) && part.complex.tet(t) == c) changes += work.smooth(c[e[0]]);
          if (random() % 8 == 0 && part.complex.alive(t)) changes += work.reconnect(t);
          if (random() % 8 == 0 && part.complex.alive(t) && part.complex.tet(t) == c)
            changes += work.remove_vertex(c[e[1]], 0);
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

// One part of a complex after the other, changed and put back in its place: what is around it stays as it is.
TEST(Parts, OfAComplexAreChangedAndPutBack) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const TetMesh mesh = test::bent_grid(4, 300, 0.2, seed);
    TetComplex whole(mesh.V, mesh.T);
    const auto boundary = test::boundary_faces(whole);
    int changes = 0;
    std::vector<Index> tets, star, created;
    for (int n = 0; n < 60; ++n) {
      Index t = static_cast<Index>(random() % whole.tet_capacity());
      if (!whole.alive(t)) continue;
      tets.clear();
      for (const Index v : whole.tet(t)) {
        whole.star(v, star);
        tets.insert(tets.end(), star.begin(), star.end());
      }
      std::sort(tets.begin(), tets.end());
      tets.erase(std::unique(tets.begin(), tets.end()), tets.end());
      std::vector<TetComplex::Tet> others;
      for (Index u = 0; u < whole.tet_capacity(); ++u)
        if (whole.alive(u) && !std::binary_search(tets.begin(), tets.end(), u))
          others.push_back(whole.tet(u));
      MeshPart part = take_part(whole, tets);
      EXPECT_EQ(static_cast<Index>(tets.size()), part.complex.tet_count());
      LocalOperations work(part.complex);
      part.mark_shared(work);
      for (Index u = 0, end = part.complex.tet_capacity(); u < end; ++u) {
        const auto& e = kTetEdge[random() % 6];
        const auto c = part.complex.tet(u);
        if (part.complex.alive(u) && random() % 4 == 0)
          changes += work.split_tet(u, (part.complex.position(c[0]) + part.complex.position(c[1]) +
                                        part.complex.position(c[2]) + part.complex.position(c[3])) /
                                           4);
        if (part.complex.alive(u) && part.complex.tet(u) == c) changes += work.collapse(c[e[0]], c[e[1]]);
        if (part.complex.alive(u) && part.complex.tet(u) == c) changes += work.smooth(c[e[1]]);
      }
      put_part(whole, tets, part, created);
      EXPECT_EQ(part.complex.tet_count(), static_cast<Index>(created.size()));
      test::expect_valid(whole);
      EXPECT_EQ(boundary, test::boundary_faces(whole));
      std::size_t kept = 0;
      for (const auto& c : others) {
        const Index u = whole.tet_with_face(c[0], c[1], c[2]);
        kept += u >= 0;
      }
      EXPECT_EQ(others.size(), kept);
    }
    EXPECT_GT(changes, 100);
  }
}

}  // namespace
}  // namespace overtet
