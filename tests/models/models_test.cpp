#include "tests/support/models.h"

#include <gtest/gtest.h>

namespace overtet::test {
namespace {

int euler(const Surface& s) { return static_cast<int>(s.V.rows() - s.F.rows() / 2); }

TEST(Models, AreClosedOrientedOutward) {
  const std::pair<const char*, Surface> all[] = {{"sphere", sphere()},
                                                 {"torus", torus()},
                                                 {"capsule", capsule()},
                                                 {"box", box()},
                                                 {"slab", slab()},
                                                 {"curled_worm", curled_worm()},
                                                 {"bent_slab", bent_slab()},
                                                 {"two_spheres", two_spheres()},
                                                 {"elbow", elbow()},
                                                 {"elbow 240", elbow(240)},
                                                 {"saucer", saucer()},
                                                 {"cavity", sphere_with_cavity()},
                                                 {"permuted", permuted(torus(), 3)}};
  for (const auto& [name, s] : all) {
    EXPECT_TRUE(is_closed_oriented(s)) << name;
    if (std::string(name) != "saucer") {
      EXPECT_GT(signed_volume(s), 0) << name;
    }
  }
}

TEST(Models, HaveTheGenusTheyPromise) {
  EXPECT_EQ(euler(sphere()), 2);
  EXPECT_EQ(euler(torus()), 0);
  EXPECT_EQ(euler(curled_worm()), 2);
  EXPECT_EQ(euler(slab(2)), 2 - 2 * 2);
  EXPECT_EQ(euler(bent_slab(4)), 2 - 2 * 4);
  EXPECT_EQ(euler(two_spheres()), 4);
}

}  // namespace
}  // namespace overtet::test
