#include "kernels/tet_energy/tet_fan.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <random>
#include <vector>

#include "kernels/tet_energy/tet_quality.h"

namespace overtet {
namespace {

using Eigen::Vector3d;

struct Base {
  Vector3d a, b, c;
  double weight;
};

// Faces of all shapes and sizes, in any position: flat tets and inverted ones among them.
struct RandomFan {
  explicit RandomFan(unsigned seed) : random(seed) {
    const double scale = std::pow(10, number() * 20);
    const auto point = [&] { return Vector3d(scale * Vector3d(number(), number(), number())); };
    for (int n = 1 + static_cast<int>(random() % 40); n > 0; --n) {
      Base f{point(), point(), point(), random() % 3 == 0 ? 1.5 : 1};
      if (random() % 5 == 0) f.c[2] = f.b[2] = f.a[2];         // in one plane with some places of the apex
      if (random() % 7 == 0) f.c = f.a + 1e-12 * (f.b - f.a);  // a needle
      bases.push_back(f);
    }
    apex = point();
    if (random() % 4 == 0) apex[2] = bases[0].a[2];
  }
  double number() { return std::uniform_real_distribution<double>(-1, 1)(random); }

  std::mt19937 random;
  std::vector<Base> bases;
  Vector3d apex;
};

// The brute-force counterpart: tet by tet, to the last bit.
TEST(TetFan, QualitiesAreThoseOfSingleTets) {
  for (unsigned seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE(seed);
    const RandomFan fan(seed);
    TetFan four;
    std::vector<double> want;
    for (const Base& f : fan.bases) {
      four.add(f.a, f.b, f.c, f.weight);
      want.push_back(f.weight * min_dihedral_sine(f.a, f.b, f.c, fan.apex));
    }
    const std::vector<double> got = four.qualities_at(fan.apex);
    ASSERT_EQ(want.size(), got.size());
    for (std::size_t i = 0; i < want.size(); ++i)
      EXPECT_EQ(want[i], got[i]) << std::hexfloat << want[i] << " " << got[i];
    const double worst = *std::min_element(want.begin(), want.end());
    EXPECT_EQ(worst, four.worst_at(fan.apex, -1));
    EXPECT_EQ(worst, four.worst_at(fan.apex, -1));  // in another order
    EXPECT_LE(four.worst_at(fan.apex, worst), worst);
    EXPECT_LE(four.worst_at(fan.apex, worst * 1.5), worst * 1.5);
    four.clear();
    four.add(fan.bases[0].a, fan.bases[0].b, fan.bases[0].c);
    EXPECT_EQ(1u, four.qualities_at(fan.apex).size());
  }
}

TEST(TetFan, SinesAndGradientsAreThoseOfSingleTets) {
  int compared = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const auto point = [&] { return Vector3d(uniform(random), uniform(random), uniform(random)); };
    const Vector3d apex = point();
    TetFan four;
    std::vector<Base> bases;
    while (bases.size() < 9) {
      Base f{point(), point(), point(), 1 + (bases.size() % 2) * .5};
      if (min_dihedral_sine(f.a, f.b, f.c, apex) <= 0) std::swap(f.a, f.b);
      bases.push_back(f);
      four.add(f.a, f.b, f.c, f.weight);
    }
    double worst = 1e9;
    for (const Base& f : bases) worst = std::min(worst, f.weight * min_dihedral_sine(f.a, f.b, f.c, apex));
    std::vector<TetFan::Sine> got;
    four.sines_near_worst(apex, 3, got);
    std::size_t at = 0;
    for (const Base& f : bases) {
      DihedralSines one;
      dihedral_sines(f.a, f.b, f.c, apex, one);
      for (int e = 0; e < 6; ++e) {
        if (f.weight * one.sine[e] > 3 * worst) continue;
        ASSERT_LT(at, got.size());
        EXPECT_NEAR(f.weight * one.sine[e], got[at].sine, 1e-12);
        EXPECT_LT((one.log_gradient[e] - got[at].log_gradient).norm(),
                  1e-9 * (1 + one.log_gradient[e].norm()));
        ++at, ++compared;
      }
    }
    EXPECT_EQ(at, got.size());
  }
  EXPECT_GT(compared, 300);
}

}  // namespace
}  // namespace overtet
