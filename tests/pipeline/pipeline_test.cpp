#include "src/pipeline/pipeline.h"
#include "src/opening/opening.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>
#include <string>
#include <tuple>

#include "overtet/io.h"
#include "overtet/verification.h"
#include "src/mesh/topology.h"
#include "src/pipeline/inspection.h"
#include "src/pipeline/locked_patch.h"
#include "src/pipeline/solid_patch.h"
#include "src/pipeline/stage_files.h"
#include "tests/support/files.h"
#include "tests/support/models.h"
#include "tests/support/noise.h"

namespace overtet {
namespace {

using test::TemporaryFolder;

PipelineResult run(const Surface& s, const MeshingOptions& options = {}, int threads = 0) {
  RunContext context;
  context.threads = threads;
  PipelineResult r = run_pipeline(s, options, context);
  if (!r.ok()) {  // then nothing is handed out, not even of a mesh that was made on the way
    EXPECT_EQ(r.mesh.T.rows(), 0);
    EXPECT_TRUE(r.report.result_hash.empty() && !r.report.quality);
    EXPECT_TRUE(r.report.moved_vertices == 0 && r.report.moved_ids.empty());
  }
  return r;
}

// Everything a user may rely on after success, checked again from outside.
void expect_mesh(const Surface& s, const PipelineResult& r) {
  ASSERT_TRUE(r.ok()) << r.report.message;
  EXPECT_EQ(r.exit_code(), 0);
  EXPECT_EQ(r.report.status, RunStatus::exact);
  EXPECT_EQ(r.mesh.surface_vertices, s.V.rows());
  const VerifyResult v = verify(s, r.mesh);
  EXPECT_TRUE(v.ok()) << v.summary();
  EXPECT_EQ(r.report.result_hash, hash_of(r.mesh));
  ASSERT_TRUE(r.report.quality.has_value());
  EXPECT_EQ(r.report.quality->tets, r.mesh.T.rows());
  EXPECT_EQ(r.report.stages.front().name, "diagnose");
  EXPECT_EQ(r.report.stages.back().name, "measure");
}

std::set<std::string> stages(const PipelineResult& r) {
  std::set<std::string> names;
  for (const StageRecord& s : r.report.stages) names.insert(s.name);
  return names;
}

TEST(Pipeline, SaysThatASurfaceHasMoreFacesThanCanBeNumbered) {
  Surface s;
  s.F.resize(100'000'001, 3);  // never read, so that it takes no memory
  const PipelineResult r = run_pipeline(s, {}, {});
  EXPECT_EQ(r.report.status, RunStatus::limit);
  EXPECT_NE(std::string::npos, r.report.message.find("100000001 faces")) << r.report.message;
}

TEST(Pipeline, MeshesWhatDoesNotCrossItself) {
  for (const Surface& s : {test::sphere(1), test::torus(), test::slab(2), test::box(3), test::capsule(),
                           test::joined(test::sphere(1), test::sphere(1, 0.5, Eigen::Vector3d(3, 0, 0)))}) {
    const PipelineResult r = run(s);
    expect_mesh(s, r);
    EXPECT_FALSE(stages(r).contains("immersion"));
  }
}

std::int64_t figure(const PipelineResult& r, const std::string& stage, const std::string& name) {
  for (const StageRecord& record : r.report.stages)
    for (const auto& [key, value] : record.figures)
      if (record.name == stage && key == name) return std::get<std::int64_t>(value);
  ADD_FAILURE() << "no figure " << stage << " " << name;
  return -1;
}

// The tets of clean components start from free points, which refinement works with.
TEST(Pipeline, CleanComponentsHaveFreePoints) {
  const std::uint64_t seed = 5;
  SCOPED_TRACE("seed " + std::to_string(seed));
  const Surface ball = test::noisy(test::sphere(4), seed, 0.02);
  const Surface around = test::joined(ball, test::noisy(test::torus(60, 30, 1.1, 0.4), seed, 0.02));
  for (const auto& [s, stage] : {std::pair{ball, "tet_mesh"}, std::pair{around, "parts"}}) {
    SCOPED_TRACE(stage);
    const TemporaryFolder folder;
    MeshingOptions options;
    options.save_stages = folder.file("stages");
    const PipelineResult one = run(s, options, 1), two = run(s, {}, 2);
    expect_mesh(s, one);
    EXPECT_GT(figure(one, stage, "free_points"), 0);
    EXPECT_EQ(one.report.result_hash, two.report.result_hash);
    // Which vertices they are is saved, too.
    MeshingOptions resume;
    resume.resume = options.save_stages;
    EXPECT_EQ(run(s, resume).report.result_hash, one.report.result_hash);
    // Without the quality pass all are there.
    MeshingOptions plain;
    plain.improve_degrees = 0;
    const PipelineResult draft = run(s, plain);
    expect_mesh(s, draft);
    EXPECT_GE(draft.mesh.V.rows() - s.V.rows(), figure(one, stage, "free_points"));
  }
}

TEST(Pipeline, MeshesCavitiesAndNestedComponents) {
  const Surface cavity = test::sphere_with_cavity();
  const PipelineResult r = run(cavity);
  expect_mesh(cavity, r);
  EXPECT_NEAR(r.report.quality->volume, test::signed_volume(cavity), 1e-12);
  // A solid inside another one overlaps it; both are meshed.
  const Surface nested = test::joined(test::sphere(2), test::sphere(1, 0.5));
  const PipelineResult both = run(nested);
  expect_mesh(nested, both);
  EXPECT_EQ(both.report.input.winding_max, 2);
}

TEST(Pipeline, MeshesWhatCrossesItself) {
  const std::pair<const char*, Surface> models[] = {{"worm", test::curled_worm()},
                                                    {"slab", test::bent_slab()},
                                                    {"spheres", test::two_spheres()},
                                                    {"long worm", test::curled_worm(800, 12, 0.2)},
                                                    {"elbow", test::elbow(150)}};
  for (const auto& [name, s] : models) {
    SCOPED_TRACE(name);
    const PipelineResult r = run(s);
    EXPECT_GT(r.report.input.pairs, 0);
    EXPECT_GE(r.report.input.winding_max.value_or(0), 2);
    expect_mesh(s, r);
    EXPECT_NEAR(r.report.quality ? r.report.quality->volume : 0, test::signed_volume(s), 1e-9);
  }
}

// Components are solids of their own, whatever they pass through, touch or coincide with.
TEST(Pipeline, ComponentsAreMeshedOneByOne) {
  const Surface elbow = test::elbow(150, 10), ball = test::sphere(1);
  const auto moved = [](const Surface& s, double x) {
    return test::transformed(s, Eigen::Matrix3d::Identity(), {x, 0, 0});
  };
  Surface nine = ball;  // balls around each other
  for (int i = 1; i < 9; ++i) nine = test::joined(nine, test::sphere(1, 1 - 0.05 * i));
  // A shell around a ball, and through both another ball: the cavity belongs to the shell.
  const Surface shell =
      test::joined(test::joined(test::sphere_with_cavity(1, 0.7), test::sphere(1, 0.5)), moved(ball, 0.8));
  const std::tuple<const char*, Surface, int> models[] = {
      {"twice", test::joined(elbow, elbow), 2},
      {"twice and a ball", test::joined(test::joined(elbow, elbow), ball), 3},
      {"a hair beside itself", test::joined(ball, moved(ball, 1e-13)), 2},
      {"touching in one point", test::joined(ball, moved(ball, 2 * ball.V.col(0).maxCoeff())), 2},
      {"nine layers", nine, 9},
      {"shell", shell, 3}};
  for (const auto& [name, s, parts] : models) {
    SCOPED_TRACE(name);
    const PipelineResult r = run(s);
    expect_mesh(s, r);
    ASSERT_TRUE(stages(r).contains("parts"));
    EXPECT_FALSE(stages(r).contains("immersion"));
    for (const StageRecord& stage : r.report.stages)
      for (const auto& [key, value] : stage.figures)
        if (stage.name == "parts" && key == "parts") {
          EXPECT_EQ(std::get<std::int64_t>(value), parts);
        }
  }
}

// What has no mesh by itself may have one with others: a saucer's negative side inside a ball.
TEST(Pipeline, ComponentsThatNeedEachOtherAreMeshedTogether) {
  const Surface saucer = test::saucer(2);
  ASSERT_EQ(run(saucer).report.status, RunStatus::infeasible);
  const Surface s = test::joined(saucer, test::sphere(2, 3));
  const PipelineResult r = run(s);
  expect_mesh(s, r);
  // A third one stays by itself.
  const Surface three = test::joined(s, test::sphere(2, 1, {3.5, 0, 0}));
  expect_mesh(three, run(three));
}

TEST(Pipeline, TheFlowRouteMeshesToo) {
  MeshingOptions options;
  options.preset = Preset::flow;
  const Surface s = test::curled_worm(390, 12);
  const PipelineResult r = run(s, options);
  expect_mesh(s, r);
  for (const char* name : {"forward_flow", "tet_mesh", "patch"}) EXPECT_TRUE(stages(r).contains(name));
  EXPECT_FALSE(stages(r).contains("volume_map"));

  options.flow_map = FlowMap::pull;
  const PipelineResult pulled = run(s, options);
  expect_mesh(s, pulled);
  for (const char* name : {"forward_flow", "reverse_flow", "tet_mesh", "volume_map"})
    EXPECT_TRUE(stages(pulled).contains(name));
  EXPECT_FALSE(stages(pulled).contains("patch"));
}

// What moves is most of it, and has hinges: no edge inside makes two turns.
TEST(Pipeline, TheFlowRoutePatchesHinges) {
  MeshingOptions options;
  options.preset = Preset::flow;
  for (const double degrees : {140.0, 150.0}) {
    SCOPED_TRACE(degrees);
    const Surface s = test::elbow(degrees, 16);
    expect_mesh(s, run(s, options));
  }
}

// An odd number of odd hinges that covered edges join: known before anything is cut or moved.
TEST(Pipeline, UnpairedHingesAreInfeasible) {
  const Surface s = test::obstructed_elbow(0);
  for (const Preset preset : {Preset::standard, Preset::flow}) {
    MeshingOptions options;
    options.preset = preset;
    const PipelineResult r = run(s, options);
    EXPECT_EQ(r.exit_code(), 5);
    ASSERT_TRUE(r.report.certificate.has_value());
    ASSERT_TRUE(std::holds_alternative<UnpairedCertificate>(*r.report.certificate));
    const auto& w = std::get<UnpairedCertificate>(*r.report.certificate);
    EXPECT_EQ(w.vertices.size() % 2, 1u);
    ASSERT_EQ(w.vertices.size(), w.B0.size());
    ASSERT_EQ(w.vertices.size(), w.positions.size());
    for (std::size_t i = 0; i < w.vertices.size(); ++i) {
      EXPECT_EQ(std::abs(w.B0[i]) % 2, 1);
      for (int k = 0; k < 3; ++k) EXPECT_EQ(w.positions[i][k], s.V(w.vertices[i], k));
    }
    EXPECT_EQ(stages(r).size(), 1u);
  }
  MeshingOptions options;
  options.on_infeasible = OnInfeasible::repair;
  EXPECT_TRUE(stages(run(s, options)).contains("repair"));
}

// Hinges for which all integers fit, and yet no gluing exists: the curves that contradict each other are the
// witness, and the flows are not tried.
TEST(Pipeline, SaysWhereCurvesContradictEachOther) {
  const std::uint64_t seed = 139;
  Surface s = test::noisy(test::elbow(170, 9), seed, 0.02 + 0.03 * 6);
  const auto hinges = diagnose(s, {}, {}).value().hinges;
  ASSERT_FALSE(hinges.empty());
  const Eigen::Vector3d at = s.V.row(hinges[seed % hinges.size()].vertex);
  s = test::joined(s, test::sphere(1, 0.5, at + 0.05 * Eigen::Vector3d(0.3, 0.5, 0.7)));
  const Result<Diagnosis> d = diagnose(s, {}, {});
  ASSERT_TRUE(d.ok());
  ASSERT_EQ(d.value().verdict, Verdict::feasible);
  const PipelineResult r = run(s);
  EXPECT_EQ(r.exit_code(), 5);
  ASSERT_TRUE(r.report.certificate.has_value());
  ASSERT_TRUE(std::holds_alternative<GluingCertificate>(*r.report.certificate));
  const auto& w = std::get<GluingCertificate>(*r.report.certificate);
  EXPECT_FALSE(w.crossings.empty());
  EXPECT_NE(to_json(r.report).find("\"layers\""), std::string::npos);
  EXPECT_FALSE(stages(r).contains("forward_flow"));
}

TEST(Pipeline, SaysWhyThereIsNoMesh) {
  const PipelineResult saucer = run(test::saucer());
  EXPECT_EQ(saucer.exit_code(), 5);
  ASSERT_TRUE(saucer.error.certificate);
  ASSERT_TRUE(std::holds_alternative<WindingCertificate>(*saucer.error.certificate));
  EXPECT_LT(std::get<WindingCertificate>(*saucer.error.certificate).winding, 0);
  EXPECT_EQ(saucer.mesh.T.rows(), 0);
  EXPECT_EQ(run(test::flipped(test::sphere())).exit_code(), 5);

  Surface open = test::sphere();
  open.F.conservativeResize(open.F.rows() - 1, 3);
  EXPECT_EQ(run(open).exit_code(), 3);
  Surface needle = test::sphere();
  needle.V.row(needle.F(0, 0)) = (needle.V.row(needle.F(0, 1)) + needle.V.row(needle.F(0, 2))) / 2;
  EXPECT_EQ(run(needle).exit_code(), 4);  // its area is lost in rounding
  EXPECT_EQ(run(Surface{}).exit_code(), 3);
  Surface out_of_range = test::sphere();
  out_of_range.F(3, 1) = 100000;
  EXPECT_EQ(run(out_of_range).exit_code(), 3);
  MeshingOptions options;
  options.improve_degrees = -1;
  EXPECT_EQ(run(test::sphere(), options).exit_code(), 2);
}

TEST(Pipeline, RepairsWhenAsked) {
  MeshingOptions options;
  options.on_infeasible = OnInfeasible::repair;
  const Surface s = test::saucer(3, 0.54);
  const PipelineResult r = run(s, options);
  ASSERT_TRUE(r.ok()) << r.report.message;
  EXPECT_EQ(r.report.status, RunStatus::repaired);
  EXPECT_GT(r.report.moved_vertices, 0);
  VerifyOptions moved;
  moved.max_move = 1.0001 * r.report.max_relative_move;
  const VerifyResult v = verify(s, r.mesh, moved);
  EXPECT_TRUE(v.ok()) << v.summary();
  EXPECT_EQ(v.moved_vertices, r.report.moved_vertices);
  // Meshes are made on the way, but none that moves as little as this, and none that is worth rounds of
  // moving less.
  options.max_repair_move = 0.05 * r.report.max_relative_move;
  const PipelineResult refused = run(s, options);
  EXPECT_EQ(refused.exit_code(), 5) << refused.report.message;
  EXPECT_TRUE(refused.report.certificate.has_value());
  options.max_repair_move = MeshingOptions().max_repair_move;
  // What needs no repair is left alone.
  const Surface fine = test::curled_worm(400, 10);
  const PipelineResult untouched = run(fine, options);
  expect_mesh(fine, untouched);
  EXPECT_EQ(untouched.report.moved_vertices, 0);
}

// A sphere with one vertex pulled past a neighbour: the tets at what moved had .07 degrees.
TEST(Pipeline, RepairLeftSliversAtWhatItMoved) {
  const Result<Surface> read =
      read_surface(std::string(OVERTET_SOURCE_DIR) + "/tests/pipeline/cases/repair_sliver.off");
  ASSERT_TRUE(read) << read.error().message;
  const Surface& s = read.value();
  MeshingOptions options;
  options.on_infeasible = OnInfeasible::repair;
  const PipelineResult r = run(s, options);
  ASSERT_TRUE(r.ok()) << r.report.message;
  EXPECT_EQ(r.report.status, RunStatus::repaired);
  VerifyOptions moved;
  moved.max_move = 1.0001 * r.report.max_relative_move;
  EXPECT_TRUE(verify(s, r.mesh, moved).ok());
  EXPECT_LE(r.report.max_relative_move, options.max_repair_move);
  EXPECT_GT(least_angle_at_moved(r.mesh, s.V), 5);
  ASSERT_TRUE(r.report.moved_angles.has_value());
  const MovedAngles& angles = *r.report.moved_angles;
  EXPECT_EQ(angles.least, least_angle_at_moved(r.mesh, s.V));
  EXPECT_LE(angles.least, angles.bound_as_moved + 1e-9);
  EXPECT_LE(angles.least, angles.bound + 1e-9);
  EXPECT_LE(r.report.quality->dihedral_min, angles.bound_elsewhere + 1e-9);
}

// The stages of parts that needed no repair were left out, and so was looking how far vertices must move.
TEST(Pipeline, RepairsSayWhereTheTimeWent) {
  MeshingOptions options;
  options.on_infeasible = OnInfeasible::repair;
  const Surface bad = test::obstructed_elbow(0), worm = test::curled_worm(2000, 10);
  const Surface far = test::transformed(worm, Eigen::Matrix3d::Identity(), {50, 0, 0});
  for (const Surface& s : {bad, test::joined(bad, far)}) {
    // The processor may be taken away between two stages: the best of some runs counts.
    double best = 0;
    for (int i = 0; i < 3 && best < 0.95; ++i) {
      const PipelineResult r = run(s, options);
      ASSERT_TRUE(r.ok()) << r.report.message;
      EXPECT_EQ(r.report.status, RunStatus::repaired);
      double sum = 0;
      for (const StageRecord& stage : r.report.stages) sum += stage.seconds;
      EXPECT_LE(sum, 1.0001 * r.report.seconds);
      best = std::max(best, sum / r.report.seconds);
    }
    EXPECT_GT(best, 0.9);
  }
}

// A face without area ends the diagnosis before the components are measured, by which they are told apart.
TEST(Pipeline, RepairCrashedOnSeveralComponentsWithAFaceWithoutArea) {
  MeshingOptions options;
  options.on_infeasible = OnInfeasible::repair;
  Surface flat = test::box(2);  // one corner of a face on the opposite edge of another
  const Eigen::RowVector3i f = flat.F.row(4);
  flat.V.row(f[0]) = 0.5 * (flat.V.row(f[1]) + flat.V.row(f[2]));
  const Surface far = test::transformed(flat, Eigen::Matrix3d::Identity(), {10, 0, 0}),
                ball = test::sphere(1, 0.5, {5, 0, 0}), around = test::sphere(1, 3, {0.5, 0.5, 0.5});
  for (const Surface& s : {test::joined(flat, far), test::joined(flat, ball), test::joined(around, flat),
                           test::joined(flat, test::flipped(ball))}) {
    const PipelineResult r = run(s, options);
    if (!r.ok()) {
      EXPECT_TRUE(r.exit_code() == 3 || r.exit_code() == 5) << r.exit_code();
      EXPECT_FALSE(r.report.message.empty());
      continue;
    }
    EXPECT_EQ(r.report.status, RunStatus::repaired);
    VerifyOptions moved;
    moved.max_move = 1.0001 * r.report.max_relative_move;
    const VerifyResult v = verify(s, r.mesh, moved);
    EXPECT_TRUE(v.ok()) << v.summary();
  }
}

// Two flat pyramids, the top of one through the bottom of the other: what spans the narrow wedge between
// their faces are products of six coordinates, which ended the program where they left the range of doubles.
TEST(Pipeline, SharpCrossingsCrashedAtLargeCoordinates) {
  Surface pyramid;
  pyramid.V.resize(4, 3);
  pyramid.V << 0, 0, 0, 1, 0, 0, 0.25, 1, 0, 0.25, 0.25, 0x1p-8;
  pyramid.F.resize(4, 3);
  pyramid.F << 0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3;
  const Surface sharp =
      test::joined(pyramid, test::transformed(pyramid, Eigen::Matrix3d::Identity(), {0, 0.0625, 0x1p-10}));
  for (const Surface& shape :
       {sharp, test::two_spheres(1), test::curled_worm(420, 8), test::elbow(150, 10), test::saucer(1)}) {
    const PipelineResult one = run(shape);
    for (const double factor :
         {0x1p-900, 0x1p-300, 0x1p-100, 0x1p100, 0x1p170, 0x1p200, 0x1p300, 0x1p900, 1e-60, 1e60, 1e100}) {
      SCOPED_TRACE(std::log2(factor));
      const Surface s{shape.V * factor, shape.F};
      const PipelineResult r = run(s);
      EXPECT_EQ(r.report.status, one.report.status) << r.report.message;
      EXPECT_EQ(r.report.certificate.has_value(), one.report.certificate.has_value());
      int power = 0;
      if (std::frexp(factor, &power) != 0.5) continue;  // else nothing but the scale differs
      EXPECT_EQ(r.mesh.V, one.mesh.V * factor);
      EXPECT_EQ(r.mesh.T, one.mesh.T);
    }
  }
}

// Copies next to each other, each covering what is around the other one, and a part that needs no repair.
TEST(Pipeline, RepairsPartsByThemselves) {
  MeshingOptions options;
  options.on_infeasible = OnInfeasible::repair;
  const Surface elbow = test::obstructed_elbow(0), worm = test::curled_worm(400, 10);
  const auto n = static_cast<std::int64_t>(elbow.V.rows());
  const Surface copy =
      test::transformed(elbow, Eigen::Matrix3d::Identity(), Eigen::Vector3d(3e-4, 2e-4, -1e-4));
  for (const bool twice : {true, false}) {
    const Surface s = test::joined(twice ? test::joined(elbow, copy) : elbow, worm);
    const PipelineResult r = run(s, options);
    ASSERT_TRUE(r.ok()) << r.report.message;
    EXPECT_EQ(r.report.status, RunStatus::repaired);
    VerifyOptions moved;
    moved.max_move = 1.0001 * r.report.max_relative_move;
    const VerifyResult v = verify(s, r.mesh, moved);
    EXPECT_TRUE(v.ok()) << v.summary();
    const std::vector<std::int64_t>& ids = r.report.moved_ids;
    EXPECT_EQ(v.moved_vertices, static_cast<std::int64_t>(ids.size()));
    EXPECT_EQ(r.report.moved_vertices, static_cast<std::int64_t>(ids.size()));
    ASSERT_FALSE(ids.empty());
    EXPECT_LT(ids.front(), n);
    EXPECT_LT(ids.back(), twice ? 2 * n : n);
    EXPECT_EQ(ids.back() >= n, twice);
    EXPECT_TRUE(std::is_sorted(ids.begin(), ids.end()));
  }
}

// What flows apart is filled one by one, so that it cannot help where a part has no mesh by itself. (Two
// balls around this one leave more gluings than the immersion route tries.)
// With two spheres around it, gluings in which a hinge had a handle were found; with more, none was.
TEST(Pipeline, PartsWithoutAMeshAreCarriedByWhatSurroundsThem) {
  for (int number = 0; number < 4; ++number) {
    Surface s = test::obstructed_elbow(number);
    const PipelineResult alone = run(s);
    ASSERT_EQ(alone.report.status, RunStatus::infeasible);
    ASSERT_TRUE(alone.error.certificate);
    ASSERT_TRUE(std::holds_alternative<UnpairedCertificate>(*alone.error.certificate));
    const auto& [x, y, z] = std::get<UnpairedCertificate>(*alone.error.certificate).positions[0];
    for (const double radius : {3.0, 3.6, 4.2, 4.8}) {
      s = test::joined(s, test::sphere(2, radius, {x, y, z}));
      const PipelineResult r = run(s);
      EXPECT_EQ(r.report.status, RunStatus::exact) << number << ", " << radius << ": " << r.report.message;
      EXPECT_FALSE(stages(r).contains("forward_flow"));
    }
  }
}

TEST(Pipeline, SameBytesOnAnyNumberOfThreads) {
  for (const Preset preset : {Preset::standard, Preset::flow}) {
    MeshingOptions options;
    options.preset = preset;
    const Surface s = test::curled_worm(390, 10);
    for (const FlowMap map : {FlowMap::patch, FlowMap::pull}) {
      options.flow_map = map;
      std::set<std::string> hashes;
      for (const int threads : {1, 2, 3, 8}) hashes.insert(run(s, options, threads).report.result_hash);
      EXPECT_EQ(hashes.size(), 1u);
      EXPECT_NE(*hashes.begin(), "");
    }
  }
}

TEST(Pipeline, ScalingByAPowerOfTwoScalesTheMesh) {
  const Surface s = test::curled_worm(400, 10);
  const PipelineResult a = run(s);
  ASSERT_TRUE(a.ok());
  for (const double factor : {0x1p-900, 0x1p30, 0x1p900}) {
    SCOPED_TRACE(std::ilogb(factor));
    Surface other = s;
    other.V *= factor;
    const PipelineResult b = run(other);
    ASSERT_TRUE(b.ok());
    EXPECT_EQ(a.mesh.T, b.mesh.T);
    EXPECT_EQ(VertexMatrix(a.mesh.V * factor), b.mesh.V);
    EXPECT_EQ(diagnose(other, {}, {}).value().verdict, diagnose(s, {}, {}).value().verdict);
  }
}

TEST(Pipeline, NeitherNumberingNorPlaceMatters) {
  const std::uint64_t seed = 99;
  SCOPED_TRACE("seed " + std::to_string(seed));
  const Surface s = test::curled_worm(400, 10);
  const Surface other = test::permuted(s, seed);
  expect_mesh(other, run(other));
  const Surface moved = test::transformed(s, test::some_rotation(seed), Eigen::Vector3d(100, -20, 3));
  expect_mesh(moved, run(moved));
  // Thin as a sheet of paper.
  Surface thin = s;
  thin.V.col(2) *= 1e-6;
  expect_mesh(thin, run(thin));
}

TEST(Pipeline, StagesAreSavedAndResumed) {
  const TemporaryFolder folder;
  const Surface s = test::curled_worm(390, 12);
  MeshingOptions save;
  save.preset = Preset::flow;
  save.flow_map = FlowMap::pull;
  save.save_stages = folder.file("stages");
  const PipelineResult first = run(s, save);
  ASSERT_TRUE(first.ok()) << first.report.message;
  const auto file = [&](const std::string& name) { return save.save_stages + "/" + name; };
  for (const char* name : {"flow_end.ply", "embedded.ply"}) {
    const Result<Surface> stage = read_surface(file(name));
    ASSERT_TRUE(stage.ok());
    EXPECT_EQ(stage.value().F, s.F);
  }
  for (const char* name : {"tet_mesh.vtu", "mapped.vtu"}) EXPECT_TRUE(read_tets(file(name)).ok());

  MeshingOptions resume;
  resume.preset = Preset::flow;
  resume.flow_map = FlowMap::pull;
  resume.resume = save.save_stages;
  const PipelineResult again = run(s, resume);
  ASSERT_TRUE(again.ok()) << again.report.message;
  EXPECT_EQ(again.report.result_hash, first.report.result_hash);
  EXPECT_FALSE(stages(again).contains("volume_map"));

  // Without the last state the one before is taken.
  const auto without = [&](const std::string& name) {
    std::string index = test::read_text(file("stages.json"));
    const auto at = index.find("\"" + name + "\"");
    ASSERT_NE(at, std::string::npos);
    test::write_text(file("stages.json"), index.replace(at, name.size() + 2, "\"gone\""));
  };
  without("mapped");
  const PipelineResult mapped = run(s, resume);
  EXPECT_EQ(mapped.report.result_hash, first.report.result_hash);
  EXPECT_TRUE(stages(mapped).contains("volume_map"));
  EXPECT_FALSE(stages(mapped).contains("reverse_flow"));

  // Resuming from a folder and saving to it keeps what is in it.
  MeshingOptions both = resume;
  both.save_stages = resume.resume;
  ASSERT_TRUE(run(s, both).ok());
  EXPECT_NE(test::read_text(file("stages.json")).find("embedded"), std::string::npos);

  EXPECT_EQ(run(test::curled_worm(391, 12), resume).exit_code(), 3);
  resume.resume = folder.file("nowhere");
  EXPECT_EQ(run(s, resume).exit_code(), 7);

  // The immersion route leaves its own states.
  save.preset = Preset::standard;
  save.save_stages = folder.file("immersion");
  ASSERT_TRUE(run(s, save).ok());
  EXPECT_TRUE(read_surface(file("arrangement.ply")).ok());
  EXPECT_TRUE(read_tets(file("cover.vtu")).ok());
}

TEST(Pipeline, ThePatchAroundAPlaceIsPartOfTheSurface) {
  const Surface s = test::joined(test::elbow(150, 16), test::sphere(1, 0.2, {9, 0, 0}));
  const Inspection found = inspect(s, InspectionDepth::verdict, {}).value();
  ASSERT_FALSE(found.diagnosis.hinges.empty());
  const Index hinge = found.diagnosis.hinges.front().vertex;
  const SubSurface patch = patch_around(s, found.diagnosis.pairs, s.V.row(hinge));
  ASSERT_EQ(patch.faces.size(), static_cast<std::size_t>(patch.surface.F.rows()));
  const std::set<Index> faces(patch.faces.begin(), patch.faces.end());
  for (Index i = 0; i < patch.surface.F.rows(); ++i)
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(patch.surface.V.row(patch.surface.F(i, k)),
                s.V.row(s.F(patch.faces[static_cast<std::size_t>(i)], k)));
  for (Index f = 0; f < s.F.rows(); ++f) {
    const bool at_hinge = s.F(f, 0) == hinge || s.F(f, 1) == hinge || s.F(f, 2) == hinge;
    EXPECT_TRUE(!at_hinge || faces.count(f)) << f;
  }
  for (const auto& [f, g] : found.diagnosis.pairs) {
    const auto row = s.F.row(f);
    const bool at_hinge = std::find(row.begin(), row.end(), hinge) != row.end();
    EXPECT_TRUE(!at_hinge || faces.count(g)) << g;
  }
  EXPECT_LT(patch.surface.F.rows(), s.F.rows() - 80);  // the ball far away is not in it
}

// Where a volume map locks, what is left to do is cut out as a problem of its own: small, closed, positive,
// and to be resumed by itself.
TEST(Pipeline, LockedMapsAreKeptAsProblems) {
  const Surface s = test::curled_worm(390, 12);
  MeshingOptions plain;
  plain.improve_degrees = 0;
  const PipelineResult made = run(s, plain);
  ASSERT_TRUE(made.ok());
  TetMesh state = made.mesh;
  const std::vector<Index> away = {200, 201};
  for (const Index v : away) {
    Eigen::RowVector3d inwards = Eigen::RowVector3d::Zero();
    int neighbours = 0;
    for (Index f = 0; f < s.F.rows(); ++f)
      for (int k = 0; k < 3; ++k)
        if (s.F(f, k) == v) inwards += s.V.row(s.F(f, (k + 1) % 3)) - s.V.row(v), ++neighbours;
    state.V.row(v) += 0.02 / neighbours * inwards;
  }
  ASSERT_TRUE(verify({state.V.topRows(s.V.rows()), s.F}, state).ok());

  const SolidPatch solid = solid_around(state, s.V, away, 3);
  EXPECT_TRUE(check_topology(solid.target).ok());
  const auto boundary = solid.target.V.rows();
  EXPECT_EQ(solid.start.surface_vertices, boundary);
  EXPECT_TRUE(verify({solid.start.V.topRows(boundary), solid.target.F}, solid.start).ok());
  EXPECT_LT(2 * solid.start.T.rows(), state.T.rows());
  ASSERT_EQ(static_cast<std::size_t>(solid.start.V.rows()), solid.vertices.size());
  int moves = 0;
  for (Index i = 0; i < solid.start.V.rows(); ++i) {
    const Index v = solid.vertices[static_cast<std::size_t>(i)];
    EXPECT_EQ(solid.start.V.row(i), state.V.row(v));
    if (i >= boundary) continue;
    EXPECT_EQ(solid.target.V.row(i), (v < s.V.rows() ? s.V : state.V).row(v));
    moves += solid.target.V.row(i) != solid.start.V.row(i);
  }
  EXPECT_EQ(moves, 2);

  const TemporaryFolder folder;
  Result<StageFiles> files = StageFiles::create(folder.file("stages"), hash_of(s), UnitBox{});
  ASSERT_TRUE(files.ok());
  ASSERT_TRUE(files.value().save_problem("locked", solid.target, solid.start).ok());
  MeshingOptions resume;
  resume.preset = Preset::flow;
  resume.resume = folder.file("stages") + "/locked";
  const Result<Surface> problem = read_surface(resume.resume + "/input.ply");
  ASSERT_TRUE(problem.ok());
  EXPECT_EQ(problem.value().V, solid.target.V);
  const Result<StageFiles> kept = StageFiles::open(resume.resume, hash_of(problem.value()), UnitBox{});
  ASSERT_TRUE(kept.ok());
  EXPECT_EQ(kept.value().load_mesh("tet_mesh", solid.start.surface_vertices).value().V, solid.start.V);
  EXPECT_EQ(kept.value().load_surface("embedded").value().F, solid.target.F);
  const PipelineResult solved = run(problem.value(), resume);
  expect_mesh(problem.value(), solved);
}

TEST(Pipeline, DamagedStagesAreRefused) {
  const TemporaryFolder folder;
  const Surface s = test::curled_worm(390, 12);
  MeshingOptions options;
  options.save_stages = folder.file("stages");
  ASSERT_TRUE(run(s, options).ok());
  TetMesh m = read_tets(options.save_stages + "/mapped.vtu").value();
  m.V.row(m.V.rows() - 1) += Eigen::RowVector3d(10, 0, 0);
  ASSERT_TRUE(write_tets(options.save_stages + "/mapped.vtu", m, TetFormat::vtu).ok());
  MeshingOptions resume;
  resume.resume = options.save_stages;
  EXPECT_EQ(run(s, resume).exit_code(), 3);
}

TEST(Pipeline, StopsWhenItShould) {
  const Surface s = test::curled_worm();
  RunContext context;
  std::atomic<bool> cancel{true};
  context.cancel = &cancel;
  EXPECT_EQ(run_pipeline(s, {}, context).exit_code(), 130);
  context = {};
  context.deadline = RunContext::Clock::now();
  EXPECT_EQ(run_pipeline(s, {}, context).exit_code(), 6);
  context = {};
  context.memory_limit_bytes = 1 << 20;
  const PipelineResult r = run_pipeline(s, {}, context);
  EXPECT_EQ(r.exit_code(), 6);
  EXPECT_NE(r.error.message.find("memory"), std::string::npos);
}

// Cancelled at many different moments: always 130 or done, never something in between.
TEST(Pipeline, CanBeCancelledAtAnyMoment) {
  const Surface s = test::curled_worm(400, 12);
  for (const Preset preset : {Preset::standard, Preset::flow})
    for (int calls = 1; calls < 40; calls += 4) {
      RunContext context;
      std::atomic<bool> cancel{false};
      std::atomic<int> count{0};
      context.cancel = &cancel;
      context.progress = [&](std::string_view, double, std::string_view) {
        if (++count >= calls) cancel = true;
      };
      MeshingOptions options;
      options.preset = preset;
      const PipelineResult r = run_pipeline(s, options, context);
      EXPECT_TRUE(r.exit_code() == 130 || r.ok()) << r.report.message;
      EXPECT_EQ(r.mesh.T.rows() > 0, r.ok());
      if (r.ok()) break;
    }
}

}  // namespace
}  // namespace overtet
