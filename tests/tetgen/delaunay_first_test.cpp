#include "src/tetgen/delaunay_first.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstring>
#include <map>
#include <set>

#include "kernels/parallel/parallel.h"
#include "kernels/predicates/predicates.h"
#include "tests/support/models.h"
#include "tests/support/noise.h"

namespace overtet {
namespace {

using Triple = std::array<Index, 3>;

Triple key(Index a, Index b, Index c) {
  Triple t{a, b, c};
  std::sort(t.begin(), t.end());
  return t;
}

void expect_sound(const TetgenResult& r, const Plc& plc, double volume) {
  ASSERT_GE(r.V.rows(), plc.V.rows());
  EXPECT_EQ(0, std::memcmp(r.V.data(), plc.V.data(), sizeof(double) * plc.V.size()));
  std::map<Triple, std::vector<Index>> faces;
  double sum = 0;
  for (Index t = 0; t < r.T.rows(); ++t) {
    const auto p = [&](int k) { return r.V.data() + 3 * r.T(t, k); };
    ASSERT_GT(orient3d(p(0), p(1), p(2), p(3)), 0);
    const Eigen::RowVector3d a = r.V.row(r.T(t, 0));
    sum += (r.V.row(r.T(t, 1)) - a).cross(r.V.row(r.T(t, 2)) - a).dot(r.V.row(r.T(t, 3)) - a) / 6;
    for (int k = 0; k < 4; ++k) {
      const Triple f = key(r.T(t, (k + 1) % 4), r.T(t, (k + 2) % 4), r.T(t, (k + 3) % 4));
      faces[f].push_back(t);
    }
  }
  EXPECT_NEAR(sum, volume, 1e-9 * std::abs(volume));
  for (Index t = 0; t < r.T.rows(); ++t)
    for (int k = 0; k < 4; ++k) {
      const auto& owners = faces[key(r.T(t, (k + 1) % 4), r.T(t, (k + 2) % 4), r.T(t, (k + 3) % 4))];
      ASSERT_LE(owners.size(), 2u);
      ASSERT_EQ(r.neighbours(t, k), owners.size() == 1 ? -1 : owners[0] == t ? owners[1] : owners[0]);
    }
  // Facets are faces; those of the input are there, or in parts.
  std::set<Index> sources;
  for (Index f = 0; f < r.facets.rows(); ++f) {
    EXPECT_TRUE(faces.count(key(r.facets(f, 0), r.facets(f, 1), r.facets(f, 2))));
    const Index source = r.facet_sources[f];
    sources.insert(source);
    EXPECT_EQ(r.facet_markers[f], plc.markers[source]);
  }
  EXPECT_EQ(sources.size(), static_cast<std::size_t>(plc.F.rows()));
}

constexpr DelaunayFirstOptions kAll{1, 10};  // whatever is missing

Plc plc_of(const Surface& s) {
  Plc plc;
  plc.V = s.V;
  plc.F = s.F;
  for (Index f = 0; f < s.F.rows(); ++f) plc.markers.push_back(f + 1);
  return plc;
}

// Stretched, so that many facets are no faces of Delaunay tets; with a wall between two parts, and a cavity.
TEST(DelaunayFirst, StretchedSurfaces) {
  Eigen::Matrix3d stretch = Eigen::Vector3d(1, 0.35, 0.55).asDiagonal();
  const Surface ball = test::transformed(test::sphere_with_cavity(3, 0.4), test::some_rotation(3) * stretch,
                                         Eigen::Vector3d(0.1, 0.2, 0.3));
  const Surface ring =
      test::transformed(test::torus(48, 20), stretch * test::some_rotation(4), Eigen::Vector3d(7, 0, 0));
  const Plc plc = plc_of(test::joined(ball, ring));
  Result<TetgenResult> first = Error{ErrorCode::internal, "not run"};
  for (const int threads : {1, 2, 3}) {
    const ScopedThreads scope(threads);
    Result<TetgenResult> r = tetrahedralize_delaunay_first(plc, {}, kAll);
    ASSERT_TRUE(r.ok()) << r.error().message;
    if (threads == 1) {
      // TetGen fills the cavity as well: nothing says that it is one.
      const double volume = test::signed_volume(ring) + test::signed_volume(ball) * 1 / (1 - 0.064);
      expect_sound(r.value(), plc, volume);
      first = std::move(r);
      continue;
    }
    EXPECT_EQ(first.value().V, r.value().V);
    EXPECT_EQ(first.value().T, r.value().T);
    EXPECT_EQ(first.value().neighbours, r.value().neighbours);
    EXPECT_EQ(first.value().facets, r.value().facets);
    EXPECT_EQ(first.value().facet_sources, r.value().facet_sources);
  }
}

// Half the facets are missing, since points lie on common spheres and in common planes.
TEST(DelaunayFirst, GridsAreSoundOrRefused) {
  const Plc plc = plc_of(test::box(6));
  const auto r = tetrahedralize_delaunay_first(plc, {}, kAll);
  if (r.ok())
    expect_sound(r.value(), plc, 1);
  else
    EXPECT_EQ(r.error().code, ErrorCode::unsolved);
  TetgenOptions options;
  options.accept_split = true;
  const auto stubborn = tetrahedralize_stubbornly(plc, options, {});
  ASSERT_TRUE(stubborn.ok()) << stubborn.error().message;
  expect_sound(stubborn.value(), plc, 1);
}

TEST(DelaunayFirst, StopsWhenAsked) {
  const Plc plc = plc_of(test::sphere(4));
  std::atomic<bool> cancel = true;
  RunContext context;
  context.cancel = &cancel;
  const auto r = tetrahedralize_delaunay_first(plc, context);
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(r.error().code, ErrorCode::interrupted);
}

}  // namespace
}  // namespace overtet
