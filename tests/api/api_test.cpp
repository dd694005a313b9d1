// The public functions, with nothing but the public headers.
#include <gtest/gtest.h>

#include <atomic>
#include <mutex>
#include <set>
#include <string>

#include "overtet/overtet.h"
#include "tests/support/files.h"
#include "tests/support/models.h"

namespace overtet {
namespace {

std::vector<Index> vertices_that_differ(const VertexMatrix& a, const VertexMatrix& b) {
  std::vector<Index> differ;
  for (Index v = 0; v < a.rows(); ++v)
    if (a.row(v) != b.row(v)) differ.push_back(v);
  return differ;
}

TEST(Api, MeshesASurfaceThatPassesThroughItself) {
  const Surface s = test::curled_worm();
  Report report;
  const Result<Meshing> r = tetrahedralize(s, {}, {}, &report);
  ASSERT_TRUE(r.ok()) << r.error().message;
  const Meshing& m = r.value();
  EXPECT_TRUE(verify(s, m.mesh).ok()) << verify(s, m.mesh).summary();
  EXPECT_EQ(m.mesh.surface_vertices, s.V.rows());
  EXPECT_EQ(m.quality.tets, m.mesh.T.rows());
  EXPECT_DOUBLE_EQ(m.quality.dihedral_min, tet_quality(m.mesh).dihedral_min);
  EXPECT_TRUE(m.moved.empty());
  EXPECT_EQ(report.status, RunStatus::exact);
  EXPECT_EQ(report.result_hash, m.hash);
  EXPECT_NE(to_json(report).find(m.hash), std::string::npos);
}

TEST(Api, EmbedsASurfaceThatPassesThroughItself) {
  const Surface s = test::curled_worm();
  Report report;
  const Result<Embedding> r = embed(s, {}, {}, &report);
  ASSERT_TRUE(r.ok()) << r.error().message;
  const Embedding& e = r.value();
  EXPECT_EQ(e.surface.F, s.F);
  EXPECT_EQ(vertices_that_differ(e.surface.V, s.V), e.moved);
  EXPECT_EQ(diagnose(e.surface).value().verdict, Verdict::embedded);
  EXPECT_GT(e.quality.area.p01, 0.5);
  EXPECT_NE(to_json(report).find("\"embedded\""), std::string::npos);
}

TEST(Api, VerticesOfDifferentLayersAreNotInOnePlace) {
  const Surface s = test::curled_worm();
  for (const double degrees : {17.0, 0.0}) {
    MeshingOptions options;
    options.improve_degrees = degrees;
    const Result<Meshing> r = tetrahedralize(s, options);
    ASSERT_TRUE(r.ok()) << r.error().message;
    EXPECT_EQ(r.value().quality.coincident_vertices, 0);
    EXPECT_GT(r.value().quality.closest_pair, 1e-9);
  }
}

TEST(Api, SizesAreCheckedAndKept) {
  const Surface s = test::curled_worm();
  MeshingOptions options;
  options.sizes.max_edge = -1;
  EXPECT_EQ(options.validate().error().code, ErrorCode::usage);
  options.sizes = {};
  options.sizes.at_vertex = {1, 2};
  EXPECT_EQ(tetrahedralize(s, options).error().code, ErrorCode::usage);
  const double size = (s.V.colwise().maxCoeff() - s.V.colwise().minCoeff()).norm() / 20;
  options.sizes.at_vertex.assign(static_cast<std::size_t>(s.V.rows()), size);
  const Result<Meshing> r = tetrahedralize(s, options), plain = tetrahedralize(s);
  ASSERT_TRUE(r.ok() && plain.ok());
  EXPECT_TRUE(verify(s, r.value().mesh).ok());
  EXPECT_GE(r.value().mesh.T.rows(), plain.value().mesh.T.rows());
}

TEST(Api, ThreadsDoNotChangeTheResult) {
  const Surface s = test::two_spheres();
  RunContext one, three;
  one.threads = 1;
  three.threads = 3;
  const Result<Meshing> a = tetrahedralize(s, {}, one), b = tetrahedralize(s, {}, three);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a.value().mesh.V, b.value().mesh.V);
  EXPECT_EQ(a.value().mesh.T, b.value().mesh.T);
  EXPECT_EQ(a.value().hash, b.value().hash);
}

TEST(Api, InfeasibleComesWithItsCertificate) {
  const Surface s = test::saucer();
  Report report;
  const Result<Meshing> r = tetrahedralize(s, {}, {}, &report);
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(r.error().code, ErrorCode::infeasible);
  ASSERT_TRUE(r.error().certificate);
  EXPECT_EQ(report.status, RunStatus::infeasible);
  EXPECT_EQ(status_of(r.error().code), report.status);
  const std::string json = to_json(*r.error().certificate);
  EXPECT_NE(json.find(rule_name(*r.error().certificate)), std::string::npos);
  EXPECT_FALSE(explain(*r.error().certificate).empty());

  const Result<SurfaceDiagnosis> d = diagnose(s);
  ASSERT_TRUE(d.ok());
  EXPECT_EQ(d.value().verdict, Verdict::infeasible);
  ASSERT_TRUE(d.value().certificate);
  EXPECT_EQ(to_json(*d.value().certificate), json);
  EXPECT_LT(d.value().winding_min.value_or(0), 0);
}

TEST(Api, RepairMovesOnlyWhatItSays) {
  const Surface s = test::saucer(2);
  SurfaceRepairOptions options;
  options.max_relative_move = 1;
  const Result<SurfaceRepair> r = repair_surface(s, options);
  ASSERT_TRUE(r.ok()) << r.error().message;
  const SurfaceRepair& repaired = r.value();
  EXPECT_EQ(repaired.surface.F, s.F);
  EXPECT_EQ(vertices_that_differ(s.V, repaired.surface.V), repaired.moved);
  EXPECT_FALSE(repaired.moved.empty());
  EXPECT_LE(repaired.max_relative_move, options.max_relative_move);
  EXPECT_LE(repaired.mean_relative_move, repaired.max_relative_move);
  const Result<SurfaceDiagnosis> d = diagnose(repaired.surface);
  ASSERT_TRUE(d.ok());
  EXPECT_TRUE(d.value().verdict == Verdict::feasible || d.value().verdict == Verdict::embedded);
}

TEST(Api, DiagnosisSaysWhereTheSurfaceCrossesItself) {
  const Surface s = test::elbow();
  const Result<SurfaceDiagnosis> r = diagnose(s);
  ASSERT_TRUE(r.ok());
  const SurfaceDiagnosis& d = r.value();
  EXPECT_EQ(d.verdict, Verdict::feasible);
  EXPECT_TRUE(d.closed && d.manifold && d.oriented && d.problems.empty());
  ASSERT_EQ(d.components.size(), 1u);
  EXPECT_NEAR(d.components[0].signed_volume.value_or(0), test::signed_volume(s), 1e-9);
  EXPECT_FALSE(d.pairs.empty());
  std::set<Index> hinges;
  for (const HingeDiagnosis& h : d.hinges) {
    hinges.insert(h.vertex);
    EXPECT_GE(h.edges.size(), 3u);
  }
  EXPECT_FALSE(hinges.empty());
  for (const Curve& curve : d.curves.curves)
    for (const CurveNode& node : curve.nodes)
      EXPECT_TRUE(node.kind != CurveNode::Kind::hinge || hinges.contains(node.vertex)) << node.vertex;

  const Result<Curves> curves = intersection_curves(s);
  ASSERT_TRUE(curves.ok());
  EXPECT_EQ(curves.value().curves.size(), d.curves.curves.size());
  EXPECT_EQ(curves.value().length, d.curves.length);
}

TEST(Api, BadInputIsNamed) {
  Surface open = test::sphere();
  open.F.conservativeResize(open.F.rows() - 1, 3);
  for (const Error& e :
       {tetrahedralize(open).error(), intersection_curves(open).error(), repair_surface(open).error()}) {
    EXPECT_EQ(e.code, ErrorCode::bad_input);
    EXPECT_FALSE(e.message.empty());
  }
  const Result<SurfaceDiagnosis> d = diagnose(open);
  ASSERT_TRUE(d.ok());
  EXPECT_EQ(d.value().verdict, Verdict::bad_input);
  EXPECT_FALSE(d.value().closed);
  MeshingOptions options;
  options.improve_degrees = 60;
  EXPECT_EQ(tetrahedralize(test::sphere(), options).error().code, ErrorCode::usage);
}

TEST(Api, TheContextEndsARun) {
  const Surface s = test::curled_worm();  // TetGen is needed
  const std::atomic<bool> cancel{true};
  RunContext cancelled, late, small, no_helper;
  cancelled.cancel = &cancel;
  late.deadline = RunContext::Clock::time_point::min();
  small.memory_limit_bytes = 1;
  no_helper.tetgen_helper = "/nowhere/overtet-tetgen";
  const auto error_with = [&](const RunContext& context) { return tetrahedralize(s, {}, context).error(); };
  EXPECT_EQ(error_with(cancelled).code, ErrorCode::interrupted);
  EXPECT_EQ(error_with(late).code, ErrorCode::limit);
  EXPECT_EQ(error_with(late).reason, ErrorReason::time_limit);
  EXPECT_EQ(error_with(small).code, ErrorCode::limit);
  EXPECT_EQ(error_with(small).reason, ErrorReason::memory_limit);
  EXPECT_EQ(error_with(no_helper).code, ErrorCode::io);
  EXPECT_NE(error_with(no_helper).message.find(no_helper.tetgen_helper), std::string::npos);
  EXPECT_EQ(diagnose(s, cancelled).error().code, ErrorCode::interrupted);
  EXPECT_EQ(diagnose(s, late).error().code, ErrorCode::limit);
}

TEST(Api, TheContextIsTold) {
  std::mutex mutex;
  std::set<std::string> stages;
  RunContext context;
  context.progress = [&](std::string_view stage, double fraction, std::string_view) {
    const std::lock_guard lock(mutex);
    EXPECT_TRUE(fraction >= 0 && fraction <= 1) << stage;
    stages.insert(std::string(stage));
  };
  ASSERT_TRUE(tetrahedralize(test::sphere(), {}, context).ok());
  EXPECT_TRUE(stages.contains("diagnose") && stages.contains("improve")) << stages.size();
}

TEST(Api, FilesReadBackAsTheyWere) {
  const test::TemporaryFolder folder;
  const Surface s = test::two_spheres();
  const Result<Meshing> r = tetrahedralize(s);
  ASSERT_TRUE(r.ok());
  ASSERT_TRUE(write_surface(folder.file("s.ply"), s, SurfaceFormat::ply).ok());
  ASSERT_TRUE(write_tets(folder.file("m.msh"), r.value().mesh, TetFormat::gmsh41).ok());
  ASSERT_TRUE(write_curves(folder.file("c.vtp"), intersection_curves(s).value(), CurveFormat::vtp).ok());
  SurfaceReadInfo info;
  const Result<Surface> surface = read_surface(folder.file("s.ply"), &info);
  ASSERT_TRUE(surface.ok());
  EXPECT_EQ(surface.value().V, s.V);
  EXPECT_EQ(surface.value().F, s.F);
  EXPECT_TRUE(info.has_vertex_order);
  const Result<TetMesh> mesh = read_tets(folder.file("m.msh"));
  ASSERT_TRUE(mesh.ok());
  EXPECT_EQ(mesh.value().V, r.value().mesh.V);
  EXPECT_EQ(mesh.value().T, r.value().mesh.T);
  EXPECT_EQ(read_surface(folder.file("none.off")).error().code, ErrorCode::io);
  EXPECT_EQ(OutputProbe().open(folder.file("no/folder.mesh")).error().code, ErrorCode::io);
  EXPECT_TRUE(OutputProbe().open(folder.file("new.mesh")).ok());
  EXPECT_EQ(folder.entries(), 3);
}

TEST(Api, HeadersAndLibraryAreOfOneVersion) {
  EXPECT_EQ(version(), std::to_string(OVERTET_VERSION_MAJOR) + "." + std::to_string(OVERTET_VERSION_MINOR) +
                           "." + std::to_string(OVERTET_VERSION_PATCH));
}

Surface squashed(Surface s, double by) {
  s.V.col(2) *= by;
  return s;
}

TEST(Diagnose, ThinSpots) {
  for (const Surface& s : {test::sphere(3), test::torus(), test::box(4), test::curled_worm(),
                           test::two_spheres(), test::sphere_with_cavity(3, 0.7)})
    EXPECT_TRUE(diagnose(s).value().thin_spots.empty());
  // A plate is thin nearly everywhere; what is near its edge is thinner still.
  const Surface plate = squashed(test::box(6), 5e-4);
  const SurfaceDiagnosis d = diagnose(plate).value();
  ASSERT_EQ(d.thin_spots.size(), 1u);
  EXPECT_NEAR(d.thin_limit, 1e-3 * std::sqrt(2), 1e-6);
  EXPECT_NEAR(d.thin_spots[0].thickness, 5e-4, 1e-12);
  EXPECT_GE(d.thin_spots[0].faces, 2 * 2 * 6 * 6);
  EXPECT_TRUE(diagnose(squashed(test::box(6), 2e-3)).value().thin_spots.empty());
  // Two plates: two spots. Between them is no solid.
  EXPECT_EQ(diagnose(test::joined(plate, test::shifted(plate, 0, 0, 6e-4))).value().thin_spots.size(), 2u);
}

// Also of what cannot be meshed: what hangs together.
TEST(Diagnose, ComponentsOfOpenSurfaces) {
  Surface s = test::joined(test::sphere(2), test::shifted(test::box(1), 3, 0, 0));
  s.F.conservativeResize(s.F.rows() - 1, 3);
  const SurfaceDiagnosis d = diagnose(s).value();
  EXPECT_EQ(d.verdict, Verdict::bad_input);
  ASSERT_EQ(d.components.size(), 2u);
  EXPECT_EQ(d.components[1].faces, 11);
  EXPECT_EQ(d.components[1].vertices, 8);
  EXPECT_EQ(d.components[1].genus, -1);
  EXPECT_FALSE(d.components[0].signed_volume);
}

}  // namespace
}  // namespace overtet
