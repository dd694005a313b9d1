#include "src/certificates/diagnose.h"

#include <gtest/gtest.h>

#include "src/exact/winding.h"
#include "tests/support/models.h"

namespace overtet {
namespace {

Diagnosis diagnosis_of(const Surface& s, int threads = 0) {
  RunContext context;
  context.threads = threads;
  const auto d = diagnose(s, {}, context);
  EXPECT_TRUE(d.ok());
  return d.value();
}

TEST(Diagnose, Verdicts) {
  EXPECT_EQ(diagnosis_of(test::sphere(1)).verdict, Verdict::embedded);
  EXPECT_EQ(diagnosis_of(test::sphere_with_cavity(1)).verdict, Verdict::embedded);
  EXPECT_EQ(diagnosis_of(test::curled_worm()).verdict, Verdict::feasible);
  EXPECT_EQ(diagnosis_of(test::bent_slab()).verdict, Verdict::feasible);
  EXPECT_EQ(diagnosis_of(test::saucer(2)).verdict, Verdict::infeasible);
  EXPECT_EQ(diagnosis_of(test::flipped(test::sphere(1))).verdict, Verdict::infeasible);
  Surface open = test::sphere(1);
  open.F.conservativeResize(open.F.rows() - 1, 3);
  EXPECT_EQ(diagnosis_of(open).verdict, Verdict::bad_input);
}

TEST(Diagnose, WhatIsReportedAgrees) {
  const Surface s = test::elbow(150, 16);
  const Diagnosis d = diagnosis_of(s);
  EXPECT_EQ(d.vertices, s.V.rows());
  EXPECT_EQ(d.faces, s.F.rows());
  EXPECT_EQ(d.genus(), 0);
  EXPECT_EQ(d.pairs, find_self_intersections(s.V, s.F));
  EXPECT_GT(d.pairs_sharing_vertex, 0);
  EXPECT_FALSE(d.hinges.empty());
  ASSERT_EQ(d.component_volume.size(), 1u);
  EXPECT_NEAR(d.component_volume[0], test::signed_volume(s), 1e-9 * std::abs(d.component_volume[0]));
  EXPECT_FALSE(d.message.empty());
  EXPECT_FALSE(d.advice.empty());
  ASSERT_TRUE(d.bvh);
  EXPECT_EQ(d.bvh->faces(), d.faces);
}

TEST(Diagnose, RefusesWithTheRightCode) {
  EXPECT_FALSE(refuse(diagnosis_of(test::curled_worm())));
  const auto infeasible = refuse(diagnosis_of(test::saucer(2)));
  ASSERT_TRUE(infeasible);
  EXPECT_EQ(infeasible->code, ErrorCode::infeasible);
  EXPECT_NE(infeasible->message.find("winding number"), std::string::npos);
  Surface flat = test::box(2);
  flat.V.row(flat.F(4, 0)) = 0.5 * (flat.V.row(flat.F(4, 1)) + flat.V.row(flat.F(4, 2)));
  const Diagnosis d = diagnosis_of(flat);
  EXPECT_FALSE(d.degenerate_faces.empty());
  const auto bad = refuse(d);
  ASSERT_TRUE(bad);
  EXPECT_EQ(bad->code, ErrorCode::infeasible);
  ASSERT_TRUE(bad->certificate);
  EXPECT_STREQ(rule_name(*bad->certificate), "area");
  EXPECT_NE(bad->message.find("face " + std::to_string(d.degenerate_faces[0])), std::string::npos);
}

TEST(Diagnose, SameOnAnyNumberOfThreads) {
  const Surface s = test::elbow(140, 14);
  const Diagnosis one = diagnosis_of(s, 1);
  for (const int threads : {2, 3, 8}) {
    const Diagnosis d = diagnosis_of(s, threads);
    EXPECT_EQ(d.verdict, one.verdict);
    EXPECT_EQ(d.message, one.message);
    EXPECT_EQ(d.pairs, one.pairs);
    EXPECT_EQ(d.winding.min, one.winding.min);
    EXPECT_EQ(d.winding.max, one.winding.max);
    ASSERT_EQ(d.wound.edges.size(), one.wound.edges.size());
    for (std::size_t i = 0; i < d.wound.edges.size(); ++i) {
      EXPECT_EQ(d.wound.edges[i].a, one.wound.edges[i].a);
      EXPECT_EQ(d.wound.edges[i].b, one.wound.edges[i].b);
      EXPECT_EQ(d.wound.edges[i].k, one.wound.edges[i].k);
    }
  }
}

TEST(Diagnose, AFoldIsAHinge) {
  // A cube with one corner of its top folded flat onto the top: two faces lie on each other.
  Surface s = test::box(2);
  const Diagnosis before = diagnosis_of(s);
  EXPECT_EQ(before.pairs_sharing_edge, 0);
  // Reflect a vertex of the top's inside across an edge of its one-ring, within the plane.
  Index v = -1;
  const double top = s.V.col(2).maxCoeff();
  for (Index i = 0; i < s.V.rows(); ++i)
    if (s.V(i, 2) == top && s.V(i, 0) == 0.5 * (s.V.col(0).minCoeff() + s.V.col(0).maxCoeff()) &&
        s.V(i, 1) == 0.5 * (s.V.col(1).minCoeff() + s.V.col(1).maxCoeff()))
      v = i;
  ASSERT_GE(v, 0);
  s.V(v, 0) += 0.75 * (s.V.col(0).maxCoeff() - s.V.col(0).minCoeff());
  const Diagnosis d = diagnosis_of(s);
  EXPECT_GT(d.pairs_sharing_edge, 0);
  EXPECT_FALSE(d.hinges.empty());
  EXPECT_NE(d.verdict, Verdict::embedded);
}

}  // namespace
}  // namespace overtet
