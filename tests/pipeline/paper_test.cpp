// Preset::paper: what it makes is exact or counted.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <set>
#include <string>
#include <vector>

#include "kernels/predicates/predicates.h"
#include "overtet/io.h"
#include "overtet/verification.h"
#include "src/pipeline/pipeline.h"
#include "src/pipeline/result_hash.h"
#include "src/pipeline/stage_files.h"
#include "tests/support/files.h"
#include "tests/support/models.h"
#include "tests/support/noise.h"

namespace overtet {
namespace {

MeshingOptions recipe(PaperRecipe::Map map) {
  MeshingOptions o;
  o.preset = Preset::paper;
  o.improve_degrees = 0;
  o.recipe.map = map;
  return o;
}

const StageRecord* stage(const PipelineResult& r, const std::string& name) {
  const auto& all = r.report.stages;
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const StageRecord& s) { return s.name == name; });
  return found == all.end() ? nullptr : &*found;
}

std::int64_t figure(const StageRecord* record, const std::string& name) {
  if (record)
    for (const Figure& f : record->figures)
      if (f.first == name)
        if (const auto* n = std::get_if<std::int64_t>(&f.second)) return *n;
  return -1;
}

// Exact, or unsolved with a message that counts what is wrong.
void expect_exact_or_counted(const Surface& s, const PipelineResult& r) {
  if (r.report.status == RunStatus::exact) {
    EXPECT_TRUE(verify(s, r.mesh).ok()) << verify(s, r.mesh).summary();
    return;
  }
  EXPECT_EQ(r.report.status, RunStatus::unsolved) << r.report.message;
  EXPECT_EQ(r.mesh.T.rows(), 0);
  const std::string& text = r.report.message;
  const auto says = [&](const char* words) { return text.find(words) != std::string::npos; };
  EXPECT_TRUE(says("away from home") || says("flipped") || says("two turns or more")) << text;
}

// Stand-ins of the paper's Cheese (holes, no hinges) and of a limb that bends through itself.
TEST(PresetPaper, IsExactWhereNothingHinges) {
  for (const Surface& s : {test::bent_slab(3), test::curled_worm(390, 12)}) {
    const PipelineResult r = run_pipeline(s, recipe(PaperRecipe::Map::lim), {});
    EXPECT_EQ(r.report.status, RunStatus::exact) << r.report.message;
    EXPECT_TRUE(verify(s, r.mesh).ok());
    for (const char* name : {"forward_flow", "reverse_flow", "tet_mesh", "lim", "turns"})
      EXPECT_NE(stage(r, name), nullptr) << name;
    EXPECT_EQ(stage(r, "improve"), nullptr);
    EXPECT_EQ(figure(stage(r, "turns"), "branch_edges"), 0);
  }
}

// V_0 first, a frame a step, and last the U_0 that the tet mesh is of.
TEST(PresetPaper, FilmOfTheFlowGoesFromTheSurfaceToItsEmbedding) {
  const TemporaryFolder folder;
  const Surface s = test::curled_worm(390, 12);
  MeshingOptions o = recipe(PaperRecipe::Map::lim);
  o.save_flow = folder.file("film");
  o.save_stages = folder.file("stages");
  const PipelineResult r = run_pipeline(s, o, {});
  ASSERT_EQ(r.report.status, RunStatus::exact) << r.report.message;
  const std::string list = test::read_text(folder.file("film/flow.pvd"));
  std::vector<Surface> frames;
  for (char name[32]; std::snprintf(name, sizeof name, "flow_%04zu.vtp", frames.size()) > 0;) {
    if (list.find(std::string("\"") + name + "\"") == std::string::npos) break;
    const Result<Surface> frame = read_surface(folder.file(std::string("film/") + name));
    ASSERT_TRUE(frame.ok()) << frame.error().message;
    ASSERT_EQ(frame.value().F, s.F);
    frames.push_back(frame.value());
  }
  const auto steps = [&](const char* name) { return static_cast<std::size_t>(stage(r, name)->iterations); };
  EXPECT_GE(frames.size(), 3 + steps("reverse_flow"));
  EXPECT_LE(frames.size(), 3 + steps("forward_flow") + steps("reverse_flow"));
  ASSERT_FALSE(frames.empty());
  EXPECT_EQ(frames.front().V, s.V);
  const Result<Surface> embedded = read_surface(folder.file("stages/embedded.ply"));
  ASSERT_TRUE(embedded.ok());
  EXPECT_EQ(frames.back().V, embedded.value().V);
}

TEST(PresetPaper, OfAHingedLimbItSaysWhatItGot) {
  const Surface s = test::elbow(150, 16);
  for (const auto map : {PaperRecipe::Map::lim, PaperRecipe::Map::arap})
    expect_exact_or_counted(s, run_pipeline(s, recipe(map), {}));
}

TEST(PresetPaper, PieceByPiece) {
  const Surface s = test::curled_worm(390, 12);
  MeshingOptions o = recipe(PaperRecipe::Map::pull);
  o.recipe.forward = PaperRecipe::Forward::regional;
  o.recipe.reverse = PaperRecipe::Reverse::barrier;
  PipelineResult r = run_pipeline(s, o, {});
  EXPECT_EQ(r.report.status, RunStatus::exact) << r.report.message;
  EXPECT_NE(stage(r, "volume_map"), nullptr);
  o.recipe.map = PaperRecipe::Map::arap;
  r = run_pipeline(s, o, {});
  expect_exact_or_counted(s, r);
  EXPECT_EQ(stage(r, "volume_map"), nullptr);
  EXPECT_NE(stage(r, "volume_arap"), nullptr);
}

// Whatever is flipped, all else is as promised, and the tets in the list are exactly those.
TEST(PresetPaper, FlippedTetsAreListed) {
  const Surface s = test::elbow(150, 16);
  MeshingOptions o = recipe(PaperRecipe::Map::arap);
  const PipelineResult strict = run_pipeline(s, o, {});
  o.allow_flips = true;
  const PipelineResult lax = run_pipeline(s, o, {});
  ASSERT_TRUE(lax.ok()) << lax.report.message;
  ASSERT_EQ(lax.report.status, RunStatus::flipped);
  EXPECT_EQ(strict.report.status, RunStatus::unsolved);
  EXPECT_EQ(std::ssize(lax.report.flipped_tets), figure(stage(strict, "volume_arap"), "flipped"));
  EXPECT_TRUE(lax.report.branch_edges.empty());
  std::set<Index> listed(lax.report.flipped_tets.begin(), lax.report.flipped_tets.end());
  for (Index t = 0; t < lax.mesh.T.rows(); ++t) {
    const auto at = [&](int k) {
      return lax.mesh.V.data() + 3 * static_cast<std::ptrdiff_t>(lax.mesh.T(t, k));
    };
    EXPECT_EQ(orient3d(at(0), at(1), at(2), at(3)) <= 0, listed.contains(t)) << t;
  }
  const VerifyResult v = verify(s, lax.mesh);
  EXPECT_TRUE(v.fails(Rule::R4));
  for (const Rule rule : {Rule::R1, Rule::R2, Rule::R3, Rule::R5}) EXPECT_FALSE(v.fails(rule));
}

// No mesh exists; the paper reports one with flipped tets for such a model (its Dog).
TEST(PresetPaper, WhatIsInfeasibleIsTriedOnlyWhereFlipsAreAllowed) {
  const Surface s = test::obstructed_elbow(0);
  MeshingOptions o = recipe(PaperRecipe::Map::arap);
  EXPECT_EQ(run_pipeline(s, o, {}).report.status, RunStatus::infeasible);
  o.allow_flips = true;
  const PipelineResult r = run_pipeline(s, o, {});
  EXPECT_TRUE(r.report.status == RunStatus::flipped || r.report.status == RunStatus::branched ||
              r.report.status == RunStatus::unsolved)
      << r.report.message;
  EXPECT_TRUE(r.report.certificate.has_value());
}

// Two solids that pass through each other: no flow can pull them apart, and none has to.
TEST(PresetPaper, PartsAreMeshedOneByOne) {
  for (const Surface& s :
       {test::two_spheres(), test::joined(test::curled_worm(390, 10), test::sphere(2, 1, {0.5, 0, 0}))}) {
    const PipelineResult r = run_pipeline(s, recipe(PaperRecipe::Map::lim), {});
    EXPECT_EQ(r.report.status, RunStatus::exact) << r.report.message;
    EXPECT_TRUE(verify(s, r.mesh).ok());
  }
}

// Surfaces of which every mesh has edges of two turns: what the recipe makes of them is counted, and finished
// and written only with leave.
TEST(PresetPaper, EdgesOfTwoTurnsAreListed) {
  const Surface s = test::obstructed_elbow(0);
  MeshingOptions branch;
  branch.on_infeasible = OnInfeasible::branch;
  const PipelineResult known = run_pipeline(s, branch, {});
  ASSERT_EQ(known.report.status, RunStatus::branched);
  const TemporaryFolder folder;
  VertexMatrix V = s.V;
  const Result<UnitBox> box = into_unit_box(V);
  ASSERT_TRUE(box.ok());
  Result<StageFiles> files = StageFiles::create(folder.file("stages"), hash_of(s), box.value());
  ASSERT_TRUE(files.ok());
  TetMesh mesh = known.mesh;
  back_into_unit_box(mesh.V, box.value());
  ASSERT_TRUE(files.value().save("mapped", Draft{mesh, 0}).ok());

  MeshingOptions lax = recipe(PaperRecipe::Map::lim);
  lax.resume = folder.file("stages");
  lax.allow_branches = true;
  const PipelineResult r = run_pipeline(s, lax, {});
  ASSERT_EQ(r.report.status, RunStatus::branched) << r.report.message;
  EXPECT_EQ(r.report.branch_edges, known.report.branch_edges);
  VerifyOptions options;
  options.allow_branches = true;
  EXPECT_TRUE(verify(s, r.mesh, options).ok());
  lax.allow_branches = false;
  EXPECT_EQ(run_pipeline(s, lax, {}).report.status, RunStatus::infeasible);

  // By itself the recipe makes such a mesh, or counts what is wrong.
  lax.allow_branches = true;
  lax.resume.clear();
  for (int i = 0; i < 4; ++i) {
    const Surface elbow = test::obstructed_elbow(i);
    const PipelineResult own = run_pipeline(elbow, lax, {});
    if (own.report.status != RunStatus::branched) {
      expect_exact_or_counted(elbow, own);
      continue;
    }
    const VerifyResult v = verify(elbow, own.mesh, options);
    EXPECT_TRUE(v.ok()) << v.summary();
    EXPECT_EQ(v.branch_edges, own.report.branch_edges);
    EXPECT_FALSE(v.branch_edges.empty());
  }
}

TEST(PresetPaper, CavitiesStayEmpty) {
  const Surface s = test::sphere_with_cavity();
  for (const PaperRecipe::Map map : {PaperRecipe::Map::lim, PaperRecipe::Map::arap, PaperRecipe::Map::pull}) {
    const PipelineResult r = run_pipeline(s, recipe(map), {});
    EXPECT_EQ(r.report.status, RunStatus::exact) << r.report.message;
    EXPECT_TRUE(verify(s, r.mesh).ok());
  }
}

TEST(PresetPaper, SameBytesOnAnyNumberOfThreads) {
  const Surface s = test::curled_worm(390, 10);
  std::set<std::string> hashes;
  for (const int threads : {1, 3}) {
    RunContext context;
    context.threads = threads;
    hashes.insert(run_pipeline(s, recipe(PaperRecipe::Map::lim), context).report.result_hash);
  }
  EXPECT_EQ(hashes.size(), 1u);
  EXPECT_NE(*hashes.begin(), "");
}

TEST(PresetPaper, OptionsThatMeanNothingAreRefused) {
  MeshingOptions o = recipe(PaperRecipe::Map::lim);
  EXPECT_TRUE(o.validate().ok());
  o.recipe.delta = 0;
  EXPECT_EQ(o.validate().error().code, ErrorCode::usage);
  o = recipe(PaperRecipe::Map::lim);
  o.recipe.radius_edge = 1;
  EXPECT_EQ(o.validate().error().code, ErrorCode::usage);
  o = MeshingOptions();
  o.allow_flips = true;
  EXPECT_EQ(o.validate().error().code, ErrorCode::usage);
}

}  // namespace
}  // namespace overtet
