#include "src/improve/improve.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <random>
#include <vector>

#include "kernels/parallel/parallel.h"
#include "kernels/tet_energy/tet_quality.h"
#include "src/cdt/tetgen.h"
#include "src/improve/passes.h"
#include "src/improve/refine.h"
#include "src/improve/worst_places.h"
#include "src/mesh/local_operations.h"
#include "tests/support/flow_surfaces.h"
#include "tests/support/tet_checks/tet_checks.h"
#include "tests/support/tet_shapes.h"

namespace overtet {
namespace {

TetMesh filled(const Surface& s, bool quality = false) {
  TetgenOptions options;
  options.quality = quality;
  const auto r = tetrahedralize({s.V, s.F, {}, {}}, options, {});
  EXPECT_TRUE(r.ok());
  return {r.value().V, r.value().T, static_cast<Index>(s.V.rows())};
}

test::FaceSet boundary_of(const TetMesh& mesh) { return test::boundary_faces(TetComplex(mesh.V, mesh.T)); }

// Puts vertices at a tiny height above about half of the boundary faces, several levels deep.
int squeeze(TetMesh& mesh, double height, int levels, unsigned seed) {
  TetComplex c(mesh.V, mesh.T);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0.1, 1);
  LocalOperations work(c);
  int made = 0;
  for (int level = 0; level < levels; ++level)
    for (Index t = 0, n = c.tet_capacity(); t < n; ++t) {
      if (!c.alive(t)) continue;
      for (int k = 0; k < 4; ++k) {
        if (c.neighbour(t, k) >= 0 || random() % 2) continue;
        const auto v = c.tet(t);
        Eigen::Vector3d p(0, 0, 0);
        double sum = 0;
        for (int i = 0; i < 4; ++i)
          if (i != k) {
            const double w = uniform(random);
            p += w * c.position(v[i]);
            sum += w;
          }
        p /= sum;
        made += work.split_tet(t, p + height * (c.position(v[k]) - p));
        break;
      }
    }
  mesh = c.to_mesh(mesh.surface_vertices);
  return made;
}

void expect_valid(const TetMesh& mesh) { test::expect_valid(TetComplex(mesh.V, mesh.T)); }

// Of the tets: how many have a smaller dihedral angle, or one that is as near to 180 degrees.
double share_below(const TetMesh& mesh, double degrees) {
  double below = 0;
  for (Index t = 0; t < mesh.T.rows(); ++t)
    below += min_dihedral_sine(mesh.V.row(mesh.T(t, 0)), mesh.V.row(mesh.T(t, 1)), mesh.V.row(mesh.T(t, 2)),
                               mesh.V.row(mesh.T(t, 3))) < std::sin(degrees * M_PI / 180);
  return below / static_cast<double>(mesh.T.rows());
}

TEST(Improve, RaisesTheSmallestAngleAndLeavesTheBoundary) {
  for (const Surface& s : {test::torus_surface(30, 12, 2, .7), test::sphere_surface(2)}) {
    TetMesh mesh = filled(s);
    const auto boundary = boundary_of(mesh);
    const auto r = improve(mesh, {}, {});
    ASSERT_TRUE(r.ok()) << r.error().message;
    expect_valid(mesh);
    EXPECT_EQ(boundary, boundary_of(mesh));
    EXPECT_EQ(s.V, mesh.V.topRows(s.V.rows()));
    EXPECT_GE(r.value().after.min, r.value().before.min);
    EXPECT_GT(r.value().after.min, 5);
    EXPECT_GT(r.value().after.p05, 8);
    EXPECT_EQ(mesh.T.rows(), r.value().after.tets);
  }
}

TEST(Improve, MeshThatPassesThroughItself) {
  for (const std::int64_t tets_per_part : {100000, 200}) {
    TetMesh mesh = test::bent_grid(6, 600, 0.2, 4);
    mesh.surface_vertices = static_cast<Index>(mesh.V.rows());  // all keep their numbers
    const auto boundary = boundary_of(mesh);
    ImproveOptions options;
    options.tets_per_part = tets_per_part;
    const auto r = improve(mesh, options, {});
    ASSERT_TRUE(r.ok());
    expect_valid(mesh);
    EXPECT_EQ(boundary, boundary_of(mesh));
    EXPECT_GT(r.value().after.min, r.value().before.min);
  }
}

TEST(Improve, ThinLayersUnderTheBoundaryGrow) {
  for (const double height : {1e-4, 1e-9}) {
    TetMesh mesh = filled(test::torus_surface(24, 12, 2, .7));
    ASSERT_GT(squeeze(mesh, height, 2, 9), 300);
    const auto boundary = boundary_of(mesh);
    const auto r = improve(mesh, {}, {});
    ASSERT_TRUE(r.ok());
    expect_valid(mesh);
    EXPECT_EQ(boundary, boundary_of(mesh));
    EXPECT_LT(r.value().before.min, 1e-2);
    EXPECT_GT(r.value().after.min, 5);
    EXPECT_GT(r.value().after.p05, 8);
  }
}

// What the passes leave as their worst gets better, also when the mesh passes through itself.
TEST(Lift, TheWorstTetsGetBetter) {
  int lifts = 0;
  for (const unsigned seed : {1u, 2u}) {
    SCOPED_TRACE(seed);
    TetMesh mesh = test::bent_grid(4, 300, 0.2, seed);
    const Index boundary_vertices = static_cast<Index>(mesh.V.rows());
    mesh.surface_vertices = boundary_vertices;  // all keep their numbers
    const VertexMatrix V = mesh.V;
    const auto boundary = boundary_of(mesh);
    const double before = dihedral_statistics(mesh.V, mesh.T).min;
    const TetMesh again = mesh;
    const int here = lift_worst(mesh, 0.5, {});
    lifts += here;
    expect_valid(mesh);
    EXPECT_EQ(boundary, boundary_of(mesh));
    for (const auto& f : boundary)
      for (const Index v : f) EXPECT_EQ(V.row(v), mesh.V.row(v));
    if (here > 0) {
      EXPECT_GT(dihedral_statistics(mesh.V, mesh.T).min, before);
    }
    for (const int threads : {1, 3}) {
      const ScopedThreads scope(threads);
      TetMesh copy = again;
      EXPECT_EQ(here, lift_worst(copy, 0.5, {}));
      EXPECT_EQ(copy.T, mesh.T);
      EXPECT_EQ(copy.V, mesh.V);
    }
    EXPECT_EQ(0, lift_worst(mesh, 1e-9, {}));  // nothing is that bad
  }
  EXPECT_GT(lifts, 4);
}

// More bad places than are taken at once, most of them tets that no single operation improves any more.
TEST(Lift, ManyPlacesOneAfterTheOther) {
  TetMesh mesh = filled(test::torus_surface(60, 24, 2, .7));
  ASSERT_GT(squeeze(mesh, 1e-2, 1, 3), 100);
  const auto boundary = boundary_of(mesh);
  {
    TetComplex c(mesh.V, mesh.T);
    LocalOperations work(c);
    improve_passes(work, {}, {}, Care::usual, 1e9, {});
    c.compact(mesh.surface_vertices);
    mesh = c.to_mesh(mesh.surface_vertices);
  }
  const double before = dihedral_statistics(mesh.V, mesh.T).min;
  // In single degrees, the n-th worst tet.
  const auto nth = [&](std::size_t n) {
    std::vector<double> q;
    for (Index t = 0; t < mesh.T.rows(); ++t)
      q.push_back(min_dihedral_sine(mesh.V.row(mesh.T(t, 0)), mesh.V.row(mesh.T(t, 1)),
                                    mesh.V.row(mesh.T(t, 2)), mesh.V.row(mesh.T(t, 3))));
    std::nth_element(q.begin(), q.begin() + static_cast<std::ptrdiff_t>(n), q.end());
    return q[n];
  };
  const double target = nth(40);  // so that 40 are worse
  const int lifts = lift_worst(mesh, target, {});
  expect_valid(mesh);
  EXPECT_EQ(boundary, boundary_of(mesh));
  EXPECT_GT(lifts, 12);
  EXPECT_GT(dihedral_statistics(mesh.V, mesh.T).min, before);
  EXPECT_GT(nth(12), 0.99 * target);
}

// A triangular tube with faces so long that no mesh has good tets only.
Surface thin_tube() {
  return test::tube([](double t) { return Eigen::Vector3d(t, 0, 0); }, 0.004, 20, 3);
}

TEST(Improve, FewerBadTetsWhereTooManyAre) {
  const TetMesh start = filled(thin_tube());
  ImproveOptions options;
  options.bad_share = 1;
  TetMesh alike = start;
  const auto all_alike = improve(alike, options, {});
  ASSERT_TRUE(all_alike.ok());
  EXPECT_EQ(0, all_alike.value().traded);
  const double share = share_below(alike, 10);
  ASSERT_GT(share, 0.1) << "not thin enough";

  options.bad_share = 0.8 * share;
  TetMesh first;
  for (const int threads : {1, 2}) {
    const ScopedThreads scope(threads);
    TetMesh mesh = start;
    const auto r = improve(mesh, options, {});
    ASSERT_TRUE(r.ok());
    EXPECT_GT(r.value().traded, 0);
    EXPECT_LE(share_below(mesh, 10), options.bad_share);
    EXPECT_GT(r.value().after.min, std::min(4.69, 0.999 * all_alike.value().after.min));
    expect_valid(mesh);
    EXPECT_EQ(boundary_of(start), boundary_of(mesh));
    if (threads == 1) first = mesh;
    EXPECT_EQ(first.T, mesh.T);
    EXPECT_EQ(first.V, mesh.V);
  }

  // Where what is wanted is out of reach none is given up.
  options.bad_share = share / 2.4;
  TetMesh mesh = start;
  const auto in_vain = improve(mesh, options, {});
  ASSERT_TRUE(in_vain.ok());
  EXPECT_EQ(0, in_vain.value().traded);
  EXPECT_EQ(alike.T, mesh.T);
  EXPECT_EQ(alike.V, mesh.V);
}

TEST(Improve, WhereFewAreBadNoneIsGivenUp) {
  TetMesh mesh = filled(test::torus_surface(30, 12, 2, .7));
  const auto r = improve(mesh, {}, {});
  ASSERT_TRUE(r.ok());
  ASSERT_LT(share_below(mesh, 10), 0.05);
  EXPECT_EQ(0, r.value().traded);
}

TEST(Refine, BadRadiiBecomeFewAndTheMeshStaysValid) {
  for (const TetMesh& mesh : {filled(test::torus_surface(40, 16, 2, .7)), test::bent_grid(4, 600, 0.2, 3)}) {
    TetComplex c(mesh.V, mesh.T);
    const auto boundary = test::boundary_faces(c);
    LocalOperations work(c);
    // What touches the boundary can have its circumcentre outside.
    const auto bad = [&] {
      std::int64_t count = 0;
      for (Index t = 0; t < c.tet_capacity(); ++t)
        count += c.alive(t) && work.squared_radius_edge(t) > 1.5 * 1.5;
      return static_cast<double>(count) / static_cast<double>(c.tet_count());
    };
    const double before = bad();
    const std::int64_t inserted = refine(work, 1.5, {}, 1000000, {});
    test::expect_valid(c);
    EXPECT_EQ(boundary, test::boundary_faces(c));
    EXPECT_LE(bad(), before);
    if (before > 0.5) {
      EXPECT_GT(inserted, 20);
      EXPECT_LT(bad(), 0.8 * before);
    }
    const Index vertices = c.vertex_count();
    EXPECT_LE(refine(work, 1.5, {}, 0, {}), 0);  // no more tets allowed
    EXPECT_EQ(vertices, c.vertex_count());
  }
}

TEST(Passes, TetsKnownToHaveResistedAreLeftAlone) {
  TetMesh mesh = filled(test::torus_surface(40, 16, 2, .7), true);
  ASSERT_GT(squeeze(mesh, 1e-3, 1, 7), 100);
  const ImproveOptions options;
  const auto changes = [&](const std::vector<char>& fresh) {
    TetComplex c(mesh.V, mesh.T);
    LocalOperations work(c);
    const PassesResult r = improve_passes(work, fresh, options, Care::usual, 1e9, {});
    std::int64_t n = 0;
    for (const ImprovePass& p : r.passes)
      n += p.removed_edges + p.flips + p.smoothed + p.collapsed + p.inserted;
    if (n > 0) test::expect_valid(c);
    return n;
  };
  std::vector<char> fresh(static_cast<std::size_t>(mesh.V.rows()), 0);
  EXPECT_EQ(0, changes(fresh));
  const std::int64_t all = changes({});
  EXPECT_GT(all, 0);
  std::fill(fresh.begin(), fresh.end(), 1);
  EXPECT_EQ(all, changes(fresh));
}

TEST(Improve, InPartsAsGoodAsInOnePiece) {
  const TetMesh start = filled(test::torus_surface(60, 24, 2, .7), true);
  TetMesh whole = start, cut = start;
  ASSERT_GT(squeeze(whole, 1e-4, 1, 5), 300);
  cut = whole;
  const auto boundary = boundary_of(whole);
  ImproveOptions options;
  const auto one = improve(whole, options, {});
  options.tets_per_part = 300;
  const auto many = improve(cut, options, {});
  ASSERT_TRUE(one.ok() && many.ok());
  EXPECT_EQ(1, one.value().rounds.front());
  EXPECT_GE(*std::max_element(many.value().rounds.begin(), many.value().rounds.end()), 8);
  expect_valid(cut);
  EXPECT_EQ(boundary, boundary_of(cut));
  EXPECT_GT(many.value().after.min, 0.7 * one.value().after.min);
  EXPECT_GT(many.value().after.p01, 0.8 * one.value().after.p01);
}

TEST(Improve, SameBytesOnAnyNumberOfThreads) {
  const TetMesh start = filled(test::torus_surface(60, 24, 2, .7));
  ImproveOptions options;
  options.tets_per_part = 500;
  TetMesh first;
  for (const int threads : {1, 2, 3}) {
    const ScopedThreads scope(threads);
    TetMesh mesh = start;
    ASSERT_TRUE(improve(mesh, options, {}).ok());
    if (threads == 1) first = mesh;
    EXPECT_EQ(first.T, mesh.T);
    EXPECT_EQ(first.V, mesh.V);
  }
}

// A fan of tets at one vertex inside: what cutting has left is no place to refine at, a vertex that was
// placed is.
TEST(Improve, RefinesAtPlacedVertices) {
  const Surface s = test::sphere_surface(3);
  TetMesh fan{VertexMatrix(s.V.rows() + 1, 3), TetMatrix(s.F.rows(), 4), static_cast<Index>(s.V.rows())};
  fan.V << s.V, Eigen::RowVector3d(0, 0, 0);
  for (Eigen::Index f = 0; f < s.F.rows(); ++f)
    fan.T.row(f) << s.F(f, 0), s.F(f, 2), s.F(f, 1), fan.surface_vertices;
  for (const Index placed : {0, 1}) {
    TetMesh mesh = fan;
    ImproveOptions options;
    options.placed = placed;
    const auto r = improve(mesh, options, {});
    ASSERT_TRUE(r.ok()) << r.error().message;
    EXPECT_EQ(r.value().refined > 0, placed > 0);
    EXPECT_EQ(boundary_of(fan), boundary_of(mesh));
  }
}

TEST(Improve, OptionsCancelAndTime) {
  TetMesh mesh = filled(test::sphere_surface(2));
  ImproveOptions options;
  options.target_degrees = 60;
  EXPECT_EQ(ErrorCode::usage, improve(mesh, options, {}).error().code);
  options = {};
  options.placed = -1;
  EXPECT_EQ(ErrorCode::usage, improve(mesh, options, {}).error().code);
  options = {};
  options.bad_share = 1.5;
  EXPECT_EQ(ErrorCode::usage, improve(mesh, options, {}).error().code);
  options = {};
  options.seconds = 0;
  const auto r = improve(mesh, options, {});
  ASSERT_TRUE(r.ok());
  expect_valid(mesh);
  std::atomic<bool> cancel = true;
  RunContext context;
  context.cancel = &cancel;
  EXPECT_EQ(ErrorCode::interrupted, improve(mesh, {}, context).error().code);
}

}  // namespace
}  // namespace overtet
