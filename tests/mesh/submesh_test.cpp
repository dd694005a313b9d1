#include "src/mesh/submesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/support/models.h"

namespace overtet {
namespace {

void expect_part(const Surface& whole, const SubSurface& part) {
  ASSERT_EQ(part.surface.F.rows(), static_cast<Eigen::Index>(part.faces.size()));
  ASSERT_EQ(part.surface.V.rows(), static_cast<Eigen::Index>(part.vertices.size()));
  EXPECT_TRUE(std::is_sorted(part.faces.begin(), part.faces.end()));
  EXPECT_TRUE(std::is_sorted(part.vertices.begin(), part.vertices.end()));
  std::vector<char> used(part.vertices.size(), 0);
  for (std::size_t i = 0; i < part.faces.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const Index v = part.surface.F(static_cast<Eigen::Index>(i), k);
      used[v] = 1;
      ASSERT_EQ(part.vertices[v], whole.F(part.faces[i], k));
      ASSERT_EQ(part.surface.V.row(v), whole.V.row(part.vertices[v]));
    }
  EXPECT_EQ(std::count(used.begin(), used.end(), 0), 0);
}

TEST(Submesh, HasTheFacesAndTheirVertices) {
  const Surface whole = test::sphere(2);
  for (const unsigned seed : {1u, 2u, 3u}) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::vector<Index> faces;
    for (Index f = 0; f < whole.F.rows(); ++f)
      if (random() % 5 == 0) faces.push_back(f);
    const SubSurface part = sub_surface(whole, faces);
    EXPECT_EQ(part.faces, faces);
    expect_part(whole, part);
  }
  EXPECT_EQ(sub_surface(whole, {}).surface.V.rows(), 0);
}

}  // namespace
}  // namespace overtet
