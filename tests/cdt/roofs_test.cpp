#include "src/cdt/roofs.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "kernels/bvh/self_intersections.h"
#include "kernels/predicates/predicates.h"
#include "src/cdt/star_areas.h"
#include "tests/support/models.h"
#include "tests/support/prints.h"

namespace overtet {
namespace {

std::vector<StarArea> areas_of(const Surface& s) {
  Result<std::vector<StarArea>> areas = find_star_areas(s, {});
  EXPECT_TRUE(areas.ok());
  return std::move(areas).value();
}

std::vector<Surface> prints() {
  std::vector<Surface> out;
  for (const test::Caps caps : {test::Caps::fan, test::Caps::strip, test::Caps::ears})
    out.push_back(test::rounded_plate(60, caps));
  out.push_back(test::rounded_plate(60, test::Caps::fan, 0.01));
  out.push_back(test::ring_plate(1500));
  out.push_back(test::gear_plate(1000));
  // Rotated, and rounded to single precision: flat no more, but nearly.
  for (std::size_t i : {0, 4, 5}) {
    out.push_back(test::transformed(out[i], test::some_rotation(i), {3, 5, 7}));
    out.push_back(out.back());
    out.back().V = out.back().V.cast<float>().cast<double>();
  }
  return out;
}

TEST(Roofs, EveryAreaIsSeenFromItsCentre) {
  int number = 0;
  for (const Surface& s : prints()) {
    SCOPED_TRACE(number++);
    const std::vector<StarArea> areas = areas_of(s);
    EXPECT_GE(areas.size(), 2u);
    std::vector<char> taken(static_cast<std::size_t>(s.F.rows()), 0);
    for (const StarArea& area : areas) {
      for (const Index f : area.faces) {
        EXPECT_FALSE(taken[f]);
        taken[f] = 1;
      }
      const std::size_t n = area.outline.size();
      EXPECT_LE(n, area.faces.size() + 2);
      for (std::size_t i = 0; i < n; ++i) {
        const Eigen::Vector3d a = s.V.row(area.outline[i]), b = s.V.row(area.outline[(i + 1) % n]);
        EXPECT_LT((b - a).cross(area.centre - a).dot(area.inwards), 0);
      }
    }
  }
}

// The slabs and what is left fill the solid, and nothing twice.
TEST(Roofs, SlabsAndTheRoofedSurfaceMakeUpTheSolid) {
  int number = 0;
  for (const Surface& s : prints()) {
    SCOPED_TRACE(number++);
    const auto raised = raise_roofs(s, areas_of(s), {});
    ASSERT_TRUE(raised.ok());
    const RoofedSurface& r = raised.value();
    EXPECT_GE(r.hubs.rows(), 2);
    EXPECT_TRUE(test::is_closed_oriented(r.surface));
    EXPECT_TRUE(find_self_intersections(r.surface.V, r.surface.F).empty());
    VertexMatrix V(s.V.rows() + r.roof_vertices + r.hubs.rows(), 3);
    V << s.V, r.surface.V.bottomRows(r.roof_vertices), r.hubs;
    double volume = test::signed_volume(r.surface);
    for (Eigen::Index t = 0; t < r.slabs.rows(); ++t) {
      const auto p = [&](int k) { return V.data() + 3 * std::int64_t{r.slabs(t, k)}; };
      ASSERT_GT(orient3d(p(0), p(1), p(2), p(3)), 0);
      const Eigen::RowVector3d a = V.row(r.slabs(t, 0));
      volume += (V.row(r.slabs(t, 1)) - a).cross(V.row(r.slabs(t, 2)) - a).dot(V.row(r.slabs(t, 3)) - a) / 6;
    }
    EXPECT_NEAR(volume, test::signed_volume(s), 1e-6 * volume);
  }
}

// What is thin because the surface is round, or has no needles, is none of this.
TEST(Roofs, NothingIsRoofedWithoutFlatNeedles) {
  EXPECT_TRUE(areas_of(test::sphere(3)).empty());
  EXPECT_TRUE(areas_of(test::box(6)).empty());
  EXPECT_TRUE(areas_of(test::slab()).empty());
  EXPECT_TRUE(areas_of(test::torus(12, 3000, 100, 0.5)).empty());
}

}  // namespace
}  // namespace overtet
