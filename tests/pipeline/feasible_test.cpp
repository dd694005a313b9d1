// Surfaces that have a mesh by construction and were not meshed once, from files beside this one.
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "overtet/io.h"
#include "overtet/verification.h"
#include "src/pipeline/pipeline.h"

namespace overtet {
namespace {

std::set<std::string> meshed(const char* name) {
  const Result<Surface> read =
      read_surface(std::string(OVERTET_SOURCE_DIR) + "/tests/pipeline/cases/" + name);
  if (!read) {
    ADD_FAILURE() << read.error().message;
    return {};
  }
  const Surface& s = read.value();
  const PipelineResult one = run_pipeline(s, {}, {}), many = run_pipeline(s, {}, [] {
                                                        RunContext context;
                                                        context.threads = 4;
                                                        return context;
                                                      }());
  EXPECT_TRUE(one.ok()) << name << ": " << one.report.message;
  EXPECT_EQ(one.report.result_hash, many.report.result_hash);
  const VerifyResult v = verify(s, one.mesh);
  EXPECT_TRUE(v.ok()) << name << ": " << v.summary();
  std::set<std::string> stages;
  for (const StageRecord& r : one.report.stages) stages.insert(r.name);
  return stages;
}

// An edge that has to be wound lies in another face, or on another edge: how much covers it is different on
// its two sides, and the immersion does not wind it.
TEST(Feasible, EdgesThatCoincideWithSomethingWereNeverWound) {
  EXPECT_FALSE(meshed("wound_edges_in_faces.off").count("nearby_surface"));
  EXPECT_FALSE(meshed("wound_edges_on_edges.off").count("nearby_surface"));
}

// The layers around such an edge were glued to a cover of another boundary, which the check refused.
TEST(Feasible, TheCoverWasWrongWhereAnEdgeLiesInAFace) { meshed("wrong_cover.off"); }

// A few units in the last place of room, in kernels as thin as that.
TEST(Feasible, PointsCouldNotBeMovedIntoThinKernels) {
  EXPECT_FALSE(meshed("thin_kernel.off").count("forward_flow"));
  EXPECT_FALSE(meshed("needle_kernel.off").count("forward_flow"));
  meshed("sharp_crossings.off");
  meshed("growing.off");
}

// Parts with edges that coincide with something: no part but one had a mesh by itself, so all were immersed
// together, and there was no answer in a minute.
TEST(Feasible, PartsThatNeedANearbySurfaceWereImmersedTogether) {
  const Result<Surface> read =
      read_surface(std::string(OVERTET_SOURCE_DIR) + "/tests/pipeline/cases/parts_that_coincide.off");
  ASSERT_TRUE(read) << read.error().message;
  MeshingOptions options;
  options.improve_degrees = 0;
  const PipelineResult r = run_pipeline(read.value(), options, {});
  ASSERT_TRUE(r.ok()) << r.report.message;
  EXPECT_TRUE(verify(read.value(), r.mesh).ok());
  for (const StageRecord& record : r.report.stages) EXPECT_NE(record.name, "immersion");
}

}  // namespace
}  // namespace overtet
