// Meshes of surfaces with faces subdivided, and meshes with branch lines.
#include "src/pipeline/refinement.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "overtet/verification.h"
#include "src/mesh/topology.h"
#include "src/pipeline/pipeline.h"
#include "tests/support/models.h"
#include "tests/support/noise.h"

namespace overtet {
namespace {

PipelineResult run(const Surface& s, OnInfeasible how) {
  MeshingOptions options;
  options.on_infeasible = how;
  return run_pipeline(s, options, {});
}

// The same shape: each face's pieces lie in its plane, turned as it is, and have its area.
void expect_refines(const Surface& s, const RefinedSurface& r) {
  EXPECT_EQ(r.surface.V.topRows(s.V.rows()), s.V);
  ASSERT_EQ(r.face.size(), static_cast<std::size_t>(r.surface.F.rows()));
  EXPECT_TRUE(check_topology(r.surface).ok());
  EXPECT_TRUE(std::is_sorted(r.face.begin(), r.face.end()));
  const auto corner = [](const Surface& x, Index f, int k) { return Eigen::Vector3d(x.V.row(x.F(f, k))); };
  const auto normal = [&](const Surface& x, Index f) {
    return Eigen::Vector3d((corner(x, f, 1) - corner(x, f, 0)).cross(corner(x, f, 2) - corner(x, f, 0)));
  };
  std::vector<double> area(static_cast<std::size_t>(s.F.rows()), 0);
  std::vector<int> pieces(area.size(), 0);
  for (Index f = 0; f < r.surface.F.rows(); ++f) {
    const Index of = r.face[f];
    const Eigen::Vector3d n = normal(s, of);
    area[of] += normal(r.surface, f).dot(n.normalized());
    ++pieces[of];
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR((corner(r.surface, f, k) - corner(s, of, 0)).dot(n.normalized()), 0, 1e-12);
  }
  for (Index f = 0; f < s.F.rows(); ++f) {
    EXPECT_NEAR(area[f], normal(s, f).norm(), 1e-12);
    EXPECT_EQ(pieces[f] > 1, std::binary_search(r.subdivided.begin(), r.subdivided.end(), f));
  }
}

TEST(Refinement, SubdividesFewFaces) {
  for (int i = 0; i < 4; ++i) {
    const Surface s = test::obstructed_elbow(i);
    EXPECT_EQ(run(s, OnInfeasible::reject).report.status, RunStatus::infeasible);
    const PipelineResult r = run(s, OnInfeasible::refine);
    ASSERT_TRUE(r.ok()) << "elbow " << i << ": " << r.report.message;
    EXPECT_EQ(r.report.status, RunStatus::refined);
    const VerifyResult v = verify(r.refined.surface, r.mesh);
    EXPECT_TRUE(v.ok()) << v.summary();
    expect_refines(s, r.refined);
    EXPECT_LT(4 * std::ssize(r.refined.subdivided), s.F.rows());
    EXPECT_EQ(r.report.subdivided_faces, r.refined.subdivided);
    EXPECT_EQ(r.report.face_of_piece, r.refined.face);
    EXPECT_EQ(r.report.added_vertices, r.refined.surface.V.rows() - s.V.rows());
    EXPECT_TRUE(r.report.branch_edges.empty());
  }
}

TEST(Refinement, MakesBranchLinesInside) {
  for (int i = 0; i < 4; ++i) {
    const Surface s = test::obstructed_elbow(i);
    const PipelineResult r = run(s, OnInfeasible::branch);
    ASSERT_TRUE(r.ok()) << "elbow " << i << ": " << r.report.message;
    EXPECT_EQ(r.report.status, RunStatus::branched);
    EXPECT_TRUE(r.report.certificate.has_value());  // of there being none without
    VerifyOptions options;
    options.allow_branches = true;
    const VerifyResult v = verify(s, r.mesh, options);
    EXPECT_TRUE(v.ok()) << v.summary();
    EXPECT_EQ(v.branch_edges, r.report.branch_edges);
    EXPECT_FALSE(v.branch_edges.empty());
    // Without leave: that rule, and no other.
    const VerifyResult strict = verify(s, r.mesh);
    ASSERT_EQ(strict.failures.size(), 1u) << strict.summary();
    EXPECT_TRUE(strict.fails(Rule::R6));
    EXPECT_EQ(strict.failures[0].count, std::ssize(v.branch_edges));
  }
}

TEST(Refinement, LeavesAloneWhatHasAMesh) {
  const Surface s = test::curled_worm(400, 10);
  for (const OnInfeasible how : {OnInfeasible::refine, OnInfeasible::branch}) {
    const PipelineResult r = run(s, how);
    EXPECT_EQ(r.report.status, RunStatus::exact);
    EXPECT_TRUE(verify(s, r.mesh).ok());
    EXPECT_EQ(r.refined.surface.F.rows(), 0);
  }
}

TEST(Refinement, KnowsWhatItCannotHelp) {
  const Surface s = test::saucer(2);
  for (const OnInfeasible how : {OnInfeasible::refine, OnInfeasible::branch}) {
    const PipelineResult r = run(s, how);
    EXPECT_EQ(r.report.status, RunStatus::infeasible);
    ASSERT_TRUE(r.report.certificate.has_value());
    EXPECT_TRUE(forbids_branch_lines(*r.report.certificate));
    EXPECT_NE(r.report.message.find("Neither subdivided faces nor branch lines"), std::string::npos);
  }
}

// Copies next to each other, each covering what is around the other one, and a part that has a mesh.
TEST(Refinement, TakesPartsOneByOne) {
  const Surface elbow = test::obstructed_elbow(0), worm = test::curled_worm(400, 10);
  const Surface copy =
      test::transformed(elbow, Eigen::Matrix3d::Identity(), Eigen::Vector3d(3e-4, 2e-4, -1e-4));
  const Surface s = test::joined(test::joined(worm, elbow), copy);
  const PipelineResult refined = run(s, OnInfeasible::refine);
  ASSERT_TRUE(refined.ok()) << refined.report.message;
  ASSERT_EQ(refined.report.status, RunStatus::refined);
  const VerifyResult v = verify(refined.refined.surface, refined.mesh);
  EXPECT_TRUE(v.ok()) << v.summary();
  expect_refines(s, refined.refined);
  const Index first = static_cast<Index>(worm.F.rows()), second = first + static_cast<Index>(elbow.F.rows());
  EXPECT_GE(refined.refined.subdivided.front(), first);
  EXPECT_LT(refined.refined.subdivided.front(), second);
  EXPECT_GE(refined.refined.subdivided.back(), second);
  const PipelineResult branched = run(s, OnInfeasible::branch);
  ASSERT_TRUE(branched.ok()) << branched.report.message;
  EXPECT_EQ(branched.report.status, RunStatus::branched);
  VerifyOptions options;
  options.allow_branches = true;
  EXPECT_TRUE(verify(s, branched.mesh, options).ok());
  EXPECT_EQ(verify(s, branched.mesh, options).branch_edges, branched.report.branch_edges);
}

TEST(Refinement, GivesTheSameOnAnyNumberOfThreads) {
  const Surface s = test::obstructed_elbow(1);
  MeshingOptions options;
  options.on_infeasible = OnInfeasible::branch;
  RunContext one, three;
  one.threads = 1, three.threads = 3;
  EXPECT_EQ(run_pipeline(s, options, one).report.result_hash,
            run_pipeline(s, options, three).report.result_hash);
}

TEST(Refinement, SavesNoStages) {
  MeshingOptions options;
  options.on_infeasible = OnInfeasible::refine;
  EXPECT_TRUE(options.validate().ok());
  options.save_stages = "somewhere";
  EXPECT_EQ(options.validate().error().code, ErrorCode::usage);
  options.save_stages.clear();
  options.resume = "somewhere";
  EXPECT_EQ(options.validate().error().code, ErrorCode::usage);
}

TEST(Refinement, CanBeInterrupted) {
  const Surface s = test::obstructed_elbow(0);
  std::atomic<bool> cancel{false};
  RunContext context;
  context.cancel = &cancel;
  context.progress = [&](std::string_view stage, double, std::string_view) {
    if (stage == "subdivision") cancel = true;
  };
  MeshingOptions options;
  options.on_infeasible = OnInfeasible::refine;
  EXPECT_EQ(run_pipeline(s, options, context).report.status, RunStatus::interrupted);
}

}  // namespace
}  // namespace overtet
