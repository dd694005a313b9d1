// The same shapes at all sizes.
#include <gtest/gtest.h>

#include <gmpxx.h>
#include <cmath>

#include "src/arrangement/curves.h"
#include "src/arrangement/intersection_graph.h"
#include "src/certificates/diagnose.h"
#include "src/certificates/separated.h"
#include "src/certificates/stacks.h"
#include "src/covering/gluing.h"
#include "src/exact/ordinary_size.h"
#include "src/exact/rays.h"
#include "src/exact/winding.h"
#include "tests/support/models.h"

namespace overtet {
namespace {

Surface times(const Surface& s, double factor) { return {s.V * factor, s.F}; }

// Flat pyramids, the top of one through the bottom of the other: the wedge in front of both faces is so
// narrow that what spans it are products of six coordinates.
Surface sharp_crossing() {
  const auto needle = [](double y) {
    Surface s;
    s.V.resize(4, 3);
    s.V << 0, 0, 0, 1, 0, 0, 0.25, 1, 0, 0.25, 0.25, 0x1p-8;
    s.V.col(1).array() += y;
    s.F.resize(4, 3);
    s.F << 0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3;
    return s;
  };
  Surface over = needle(0.0625);
  over.V.col(2).array() += 0x1p-10;
  return test::joined(needle(0), over);
}

const std::pair<const char*, Surface> kShapes[] = {
    {"sphere", test::sphere(0)},         {"two spheres", test::two_spheres(1)},
    {"worm", test::curled_worm(420, 8)}, {"elbow", test::elbow(150, 10)},
    {"saucer", test::saucer(1)},         {"inward", test::flipped(test::sphere(0))},
    {"folds", test::mirrored_folds(1)},  {"sharp", sharp_crossing()}};

// A point that is named is the same one, times the factor: exactly.
void expect_times(const std::array<std::string, 3>& got, const std::array<std::string, 3>& want,
                  double factor) {
  for (int k = 0; k < 3; ++k) {
    mpq_class x(got[k], 10), y(want[k], 10);
    x.canonicalize();
    y.canonicalize();
    EXPECT_EQ(x, y * mpq_class(factor)) << got[k] << " " << want[k];
  }
}

TEST(Scale, SharpCrossingsCrashedAtLargeCoordinates) {
  for (const auto& [name, shape] : kShapes) {
    const Diagnosis one = diagnose(shape, {}, {}).value();
    const GluingAnswer glued = check_gluing(shape, one.topology.topology, *one.bvh, *one.graph, {}).value();
    const Curves traced = trace_curves(shape, *one.bvh, *one.graph, {}).value();
    for (const double factor : {0x1p-300, 0x1p-100, 0x1p-70, 0x1p70, 0x1p100, 0x1p170, 0x1p200, 0x1p300}) {
      SCOPED_TRACE(std::string(name) + " times " + std::to_string(std::ilogb(factor)));
      const Surface s = times(shape, factor);
      const Diagnosis d = diagnose(s, {}, {}).value();
      EXPECT_EQ(d.verdict, one.verdict) << d.message;
      EXPECT_EQ(d.pairs, one.pairs);
      EXPECT_EQ(d.hinges.size(), one.hinges.size());
      EXPECT_EQ(d.winding.min, one.winding.min);
      EXPECT_EQ(d.winding.max, one.winding.max);
      EXPECT_EQ(d.component_volume.size(), one.component_volume.size());
      for (std::size_t c = 0; c < d.component_volume.size(); ++c)
        EXPECT_EQ(d.component_volume[c] > 0, one.component_volume[c] > 0);
      ASSERT_EQ(d.winding.witness.has_value(), one.winding.witness.has_value());
      if (d.winding.witness) {
        const WindingCertificate &a = *d.winding.witness, &b = *one.winding.witness;
        expect_times(a.exact, b.exact, factor);
        EXPECT_EQ(a.doubles_suffice, b.doubles_suffice);
        EXPECT_EQ(WindingNumber(s).at(a.exact), a.winding);
      }
      ASSERT_EQ(d.certificate.has_value(), one.certificate.has_value());
      if (one.certificate) {
        ASSERT_EQ(d.certificate->index(), one.certificate->index());
        if (const auto* stack = std::get_if<StackCertificate>(&*one.certificate))
          expect_times(std::get<StackCertificate>(*d.certificate).exact, stack->exact, factor);
      }
      const GluingAnswer g = check_gluing(s, d.topology.topology, *d.bvh, *d.graph, {}).value();
      EXPECT_EQ(g.verdict, glued.verdict);
      EXPECT_EQ(g.conditions, glued.conditions);
      const Curves curves = trace_curves(s, *d.bvh, *d.graph, {}).value();
      ASSERT_EQ(curves.curves.size(), traced.curves.size());
      EXPECT_DOUBLE_EQ(curves.length, traced.length * factor);
    }
    for (const double factor : {1e-100, 1e-60, 1e60, 1e100}) {  // what is rounded differs
      SCOPED_TRACE(std::string(name) + " times " + std::to_string(factor));
      const Diagnosis d = diagnose(times(shape, factor), {}, {}).value();
      EXPECT_FALSE(d.message.empty());
    }
  }
}

// What is called by itself, on the surface as it is.
TEST(Scale, EveryPartOfTheRoomDecidesAlikeAtAnySize) {
  for (const auto& [name, shape] : kShapes) {
    const Diagnosis one = diagnose(shape, {}, {}).value();
    for (const double factor : {0x1p-300, 0x1p-170, 0x1p-100, 0x1p100, 0x1p170, 0x1p200, 0x1p300}) {
      SCOPED_TRACE(std::string(name) + " times " + std::to_string(std::ilogb(factor)));
      const Surface s = times(shape, factor);
      const SurfaceTopology& topology = one.topology.topology;
      const TriangleBvh bvh(s.V, s.F);
      const std::vector<Hinge> hinges = find_hinges(s, topology, bvh, one.pairs);
      ASSERT_EQ(hinges.size(), one.hinges.size());
      for (std::size_t i = 0; i < hinges.size(); ++i) {
        EXPECT_EQ(hinges[i].B0, one.hinges[i].B0);
        EXPECT_EQ(hinges[i].covering, one.hinges[i].covering);
      }
      IntersectionGraph graph(s, topology, bvh, one.pairs);
      const WindingRange range = find_winding_range(s, topology, bvh, graph, {}).value();
      EXPECT_EQ(range.min, one.winding.min);
      EXPECT_EQ(range.max, one.winding.max);
      EXPECT_EQ(range.negative_at, one.winding.negative_at);
      if (range.witness) {
        EXPECT_EQ(WindingNumber(s).at(range.witness->exact), range.witness->winding);
      }
      const auto stack = find_stack_certificate(s, bvh, one.pairs, {}).value();
      if (one.certificate && std::holds_alternative<StackCertificate>(*one.certificate)) {
        EXPECT_TRUE(stack);
      }
      const WoundEdges wound = assign_wound_edges(s, topology, bvh, hinges, one.pierced_edges, {}).value(),
                       expected =
                           assign_wound_edges(shape, topology, *one.bvh, one.hinges, one.pierced_edges, {})
                               .value();
      EXPECT_EQ(wound.odd_groups, expected.odd_groups);
      EXPECT_EQ(wound.crowded, expected.crowded);
      EXPECT_TRUE(find_separated_part(s, topology, hinges, {}).ok());
    }
  }
}

// A surface of ordinary size with a small part, whose numbers are as small as those of a small surface.
TEST(Scale, SmallPartsOfLargeSurfaces) {
  for (const double factor : {0x1p-60, 0x1p-100, 0x1p-200, 0x1p-300}) {
    SCOPED_TRACE(std::ilogb(factor));
    for (const bool worm : {false, true}) {
      const Surface part = times(worm ? test::curled_worm(420, 8) : sharp_crossing(), factor);
      const Diagnosis alone = diagnose(part, {}, {}).value();
      const Surface s = test::joined(part, test::sphere(1, 1, {1.5, 0, 0}));
      const Diagnosis d = diagnose(s, {}, {}).value();
      EXPECT_EQ(d.verdict, Verdict::feasible) << d.message;
      EXPECT_EQ(d.pairs, alone.pairs);
      EXPECT_EQ(d.winding.max, alone.winding.max);
      EXPECT_EQ(trace_curves(s, *d.bvh, *d.graph, {}).value().curves.size(),
                trace_curves(part, *alone.bvh, *alone.graph, {}).value().curves.size());
    }
  }
}

TEST(Scale, OrdinarySizeIsExactOrLeavesTheSurfaceAlone) {
  const Surface ball = test::sphere(1);
  for (const double factor : {1.0, 0x1p-60, 0x1p60}) {
    const Surface s = times(ball, factor);
    EXPECT_FALSE(OrdinarySize(s).scaled());
    EXPECT_EQ(&OrdinarySize(s).surface(), &s);
  }
  for (const double factor : {0x1p-300, 1e-40, 1e40, 0x1p300, 0x1p1000}) {
    const Surface s = times(ball, factor);
    const OrdinarySize sized(s);
    ASSERT_TRUE(sized.scaled());
    EXPECT_LT(sized.surface().V.cwiseAbs().maxCoeff(), 1);
    EXPECT_GE(sized.surface().V.cwiseAbs().maxCoeff(), 0.5);
    for (Index v = 0; v < s.V.rows(); ++v)
      for (int k = 0; k < 3; ++k) EXPECT_EQ(sized.back(sized.surface().V(v, k)), s.V(v, k));
    EXPECT_NE(sized.back(1e-9, 3), 0);
    EXPECT_TRUE(std::isfinite(sized.back(1, 3)));
    expect_times(sized.back({"1/3", "-5", "0"}), {"1/3", "-5", "0"},
                 s.V.cwiseAbs().maxCoeff() / sized.surface().V.cwiseAbs().maxCoeff());
  }
  Surface mixed = times(ball, 0x1p200);
  mixed.V(0, 0) = 0x1.fffffffffffffp-1000;  // would lose bits
  EXPECT_FALSE(OrdinarySize(mixed).scaled());
}

TEST(Scale, DirectionsMayHaveAnyLength) {
  const Surface s = test::sphere(1);
  const TriangleBvh bvh(s.V, s.F);
  const exact::Rays rays(s.V, s.F, bvh);
  const double m[3] = {0.1, 0.05, 0.02}, d[3] = {0.3, -0.7, 0.2};
  const exact::Point start(m);
  const exact::Vec direction = exact::vec(d);
  const exact::RayCount want =
      rays.count(start, exact::Point(direction), nullptr, {}, exact::RayQuestion::winding_and_nearest);
  ASSERT_EQ(want.winding, 1);
  for (const int power : {-5000, -1100, -1000, -500, 500, 1000, 1100, 5000}) {
    exact::Rational factor = 1;
    if (power > 0)
      mpq_mul_2exp(factor.get_mpq_t(), factor.get_mpq_t(), static_cast<mp_bitcnt_t>(power));
    else
      mpq_div_2exp(factor.get_mpq_t(), factor.get_mpq_t(), static_cast<mp_bitcnt_t>(-power));
    const exact::Point far(factor * direction);
    for (const double x : far.near) EXPECT_TRUE(std::isfinite(x));
    const exact::RayCount got = rays.count(start, far, nullptr, {}, exact::RayQuestion::winding_and_nearest);
    EXPECT_EQ(got.winding, want.winding);
    EXPECT_EQ(*got.nearest * factor, *want.nearest);
    for (Index f = 0; f < s.F.rows(); ++f)
      EXPECT_EQ(rays.passes(start, far, f), rays.passes(start, exact::Point(direction), f));
  }
}

}  // namespace
}  // namespace overtet
