// How the work of the passes over a tet mesh grows with its size, in counts: nothing may cost (whole mesh) x
// (places).
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "kernels/parallel/counts.h"
#include "src/cdt/tetgen.h"
#include "src/improve/bad_tets.h"
#include "src/improve/improve.h"
#include "src/improve/set_apart.h"
#include "src/improve/worst_places.h"
#include "src/mesh/local_operations.h"
#include "src/mesh/partition.h"
#include "tests/support/flow_surfaces.h"

namespace overtet {
namespace {

struct Work {
  double tets, touched, copied;
};

Work work_of(TetMesh& mesh, const std::function<void(TetMesh&)>& pass) {
  Work w{static_cast<double>(mesh.T.rows()), static_cast<double>(-counted(Count::touched_tets)),
         static_cast<double>(-counted(Count::copied_bytes))};
  pass(mesh);
  w.touched += static_cast<double>(counted(Count::touched_tets));
  w.copied += static_cast<double>(counted(Count::copied_bytes));
  return w;
}

// A ring of `times` as many tets, with as many times as many bad places: each side of the ring is like any
// other.
TetMesh ring(int times) {
  const Surface s = test::torus_surface(40 * times, 16, 2.0 * times, .7);
  Plc plc;
  plc.V = s.V;
  plc.F = s.F;
  const auto r = tetrahedralize(plc, {}, {});
  EXPECT_TRUE(r.ok());
  TetMesh mesh{r.value().V, r.value().T, static_cast<Index>(s.V.rows())};
  // Vertices just above some of the boundary faces.
  TetComplex c(mesh.V, mesh.T);
  LocalOperations work(c);
  std::mt19937 random(5);
  for (Index t = 0, n = c.tet_capacity(); t < n; ++t)
    for (int k = 0; k < 4 && c.alive(t); ++k) {
      if (c.neighbour(t, k) >= 0 || random() % 8 != 0) continue;
      const auto v = c.tet(t);
      Eigen::Vector3d middle = -c.position(v[k]);
      for (const Index x : v) middle += c.position(x);
      middle /= 3;
      work.split_tet(t, middle + 1e-2 * (c.position(v[k]) - middle));
      break;
    }
  return c.to_mesh(mesh.surface_vertices);
}

// Linear, but for a logarithm: four times the tets may cost 4^1.15 = 4.9 times as much.
void expect_linear(const std::string& what, const std::function<void(TetMesh&)>& pass) {
  SCOPED_TRACE(what);
  TetMesh small = ring(2), large = ring(8);
  const Work a = work_of(small, pass), b = work_of(large, pass);
  const double size = b.tets / a.tets;
  ASSERT_NEAR(size, 4, 0.2);
  EXPECT_GT(a.touched, 0);
  EXPECT_LT(b.touched / a.touched, std::pow(size, 1.15));
  if (a.copied > 0) {
    EXPECT_LT(b.copied / a.copied, std::pow(size, 1.15));
  }
}

TEST(Work, GrowsWithTheMeshInEveryPass) {
  ImproveOptions usual, parts, refine, coarse, sizes;
  parts.tets_per_part = 2000;
  refine.passes = 0;
  refine.radius_edge = 1.5;
  refine.tets_per_part = 2000;
  coarse.coarse = true;
  sizes.sizes.max_edge = .25;
  sizes.tets_per_part = 5000;  // both are cut: one cut more costs rounds around it, once
  const auto improving = [](const ImproveOptions& options) {
    return [&options](TetMesh& mesh) { ASSERT_TRUE(improve(mesh, options, {}).ok()); };
  };
  expect_linear("the whole quality pass", improving(usual));
  expect_linear("in parts", improving(parts));
  expect_linear("refinement", improving(refine));
  expect_linear("few vertices", improving(coarse));
  expect_linear("small tets", improving(sizes));
  expect_linear("the worst places", [](TetMesh& mesh) {
    // A fixed share of the tets is to get better, so that there are more places in a larger mesh.
    std::vector<double> q;
    for (Index t = 0; t < mesh.T.rows(); ++t) q.push_back(quality(mesh, t));
    std::sort(q.begin(), q.end());
    EXPECT_GT(lift_worst(mesh, q[q.size() / 300], {}), 5);
  });
  expect_linear("parts taken out and put back", [](TetMesh& mesh) {
    std::vector<Index> all(static_cast<std::size_t>(mesh.T.rows()));
    for (Index t = 0; t < mesh.T.rows(); ++t) all[t] = t;
    const int parts = static_cast<int>(mesh.T.rows() / 1000);
    const std::vector<int> part_of = cut_apart(mesh, all, parts, .1);
    put_parts(mesh, part_of, take_parts(mesh, part_of, parts));
  });
}

// One place costs what lies around it, whatever the size of the mesh.
TEST(Work, OneOfManyPlacesCostsWhatLiesAroundIt) {
  double touched[2];
  for (const int k : {0, 1}) {
    TetMesh mesh = ring(k == 0 ? 2 : 8);
    TetComplex c(mesh.V, mesh.T);
    std::vector<Index> patch, created;
    c.star(c.tet(0)[0], patch);
    const std::int64_t before = counted(Count::touched_tets);
    const MeshPart part = take_part(c, patch);
    put_part(c, patch, part, created);
    touched[k] = static_cast<double>(counted(Count::touched_tets) - before);
    EXPECT_EQ(created.size(), patch.size());
  }
  EXPECT_LT(touched[1], 2 * touched[0]);
}

}  // namespace
}  // namespace overtet
