// Regions, layers and labels of real meshes, against brute force; and what verify_attributes() finds.
#include <gtest/gtest.h>

#include <algorithm>

#include "kernels/predicates/predicates.h"
#include "overtet/attributes.h"
#include "overtet/meshing.h"
#include "tests/support/models.h"

namespace overtet {
namespace {

using List = std::vector<Index>;

TetMesh meshed(const Surface& s) {
  const Result<Meshing> made = tetrahedralize(s);
  EXPECT_TRUE(made.ok()) << (made.ok() ? "" : made.error().message);
  return made.ok() ? made.value().mesh : TetMesh{};
}

MeshAttributes attributes(const Surface& s, const TetMesh& m, const SurfaceAttributes& a = {}) {
  const Result<MeshAttributes> r = mesh_attributes(s, a, m);
  EXPECT_TRUE(r.ok());
  return r.ok() ? r.value() : MeshAttributes{};
}

// How many tets have the centroid of t inside; -1: it is on the border of one.
int tets_around_centroid(const TetMesh& m, Eigen::Index t) {
  double p[3] = {0, 0, 0};
  for (int k = 0; k < 3; ++k)
    for (int c = 0; c < 4; ++c) p[k] += .25 * m.V(m.T(t, c), k);
  int count = 0;
  for (Eigen::Index u = 0; u < m.T.rows(); ++u) {
    const auto corner = [&](int c) { return &m.V(m.T(u, c), 0); };
    const int s[4] = {
        orient3d(corner(1), corner(3), corner(2), p), orient3d(corner(0), corner(2), corner(3), p),
        orient3d(corner(0), corner(3), corner(1), p), orient3d(corner(0), corner(1), corner(2), p)};
    const int low = *std::min_element(s, s + 4);
    if (low > 0) ++count;
    if (low == 0) return -1;
  }
  return count;
}

TEST(MeshAttributes, LayersAreTheTetsThatCoverThePoint) {
  const Surface hollow = test::sphere_with_cavity();
  for (const Surface& s : {test::curled_worm(), test::two_spheres(), hollow}) {
    const TetMesh m = meshed(s);
    const MeshAttributes a = attributes(s, m);
    ASSERT_EQ(a.layers.size(), static_cast<std::size_t>(m.T.rows()));
    int overlapping = 0;
    for (Eigen::Index t = 0; t < m.T.rows(); t += 7) {
      const int covered = tets_around_centroid(m, t);
      if (covered >= 0) {
        EXPECT_EQ(a.layers[static_cast<std::size_t>(t)], covered) << t;
      }
      overlapping += covered > 1;
    }
    EXPECT_EQ(overlapping > 0, s.V != hollow.V);
  }
}

TEST(MeshAttributes, KnownWindingNumbersChangeNothing) {
  for (const Surface& s : {test::curled_worm(), test::two_spheres(), test::sphere_with_cavity()}) {
    Report report;
    const Result<Meshing> made = tetrahedralize(s, {}, {}, &report);
    ASSERT_TRUE(made.ok() && report.input.winding_max);
    const TetMesh& m = made.value().mesh;
    EXPECT_EQ(mesh_attributes(s, {}, m, {true, report.input.winding_max}, {}).value().layers,
              attributes(s, m).layers);
  }
}

TEST(MeshAttributes, TheNumberOfThreadsChangesNothing) {
  const Surface s = test::curled_worm();
  const TetMesh m = meshed(s);
  RunContext one;
  one.threads = 1;
  const MeshAttributes a = attributes(s, m), b = mesh_attributes(s, {}, m, {}, one).value();
  EXPECT_EQ(a.layers, b.layers);
  EXPECT_EQ(a.regions.of, b.regions.of);
}

TEST(MeshAttributes, RegionsAreComponentsOfTheSolid) {
  const Surface two = test::two_spheres();
  const TetMesh m = meshed(two);
  const MeshAttributes a = attributes(two, m);
  EXPECT_EQ(*std::min_element(a.regions.of.begin(), a.regions.of.end()), 1);
  EXPECT_EQ(*std::max_element(a.regions.of.begin(), a.regions.of.end()), 2);
  const Index half = static_cast<Index>(two.V.rows() / 2);
  for (Eigen::Index t = 0; t < m.T.rows(); ++t)
    for (int k = 0; k < 4; ++k)
      if (m.T(t, k) < two.V.rows()) {
        EXPECT_EQ(a.regions.of[static_cast<std::size_t>(t)], m.T(t, k) < half ? 1 : 2);
      }
  EXPECT_EQ(a.labels.of.front(), 1);
  EXPECT_EQ(a.labels.of.back(), 2);

  // A cavity has a label of its own and is in the same solid.
  const Surface hollow = test::sphere_with_cavity();
  const MeshAttributes b = attributes(hollow, meshed(hollow));
  EXPECT_EQ(*std::max_element(b.regions.of.begin(), b.regions.of.end()), 1);
  EXPECT_EQ(b.labels.of.back(), 2);
}

TEST(MeshAttributes, RegionsHaveTheNumbersAndNamesOfSolids) {
  const Surface two = test::two_spheres();
  SurfaceAttributes in;
  in.solids.of.assign(static_cast<std::size_t>(two.F.rows()), 8);
  std::fill(in.solids.of.begin() + two.F.rows() / 2, in.solids.of.end(), 5);
  in.solids.names = {{8, "left"}, {5, "right"}};
  const TetMesh m = meshed(two);
  MeshAttributes a = attributes(two, m, in);
  EXPECT_EQ(List({*std::min_element(a.regions.of.begin(), a.regions.of.end()),
                  *std::max_element(a.regions.of.begin(), a.regions.of.end())}),
            (List{5, 8}));
  EXPECT_EQ(a.regions.names, in.solids.names);
  // One that is of two solids gets a number after theirs.
  in.solids.of[0] = 5;
  a = attributes(two, m, in);
  EXPECT_EQ(*std::max_element(a.regions.of.begin(), a.regions.of.end()), 9);
  EXPECT_FALSE(a.regions.names.contains(9));
}

TEST(MeshAttributes, DataOfInnerVerticesAreNone) {
  const Surface s = test::sphere(2);
  SurfaceAttributes in;
  const auto vertices = static_cast<std::size_t>(s.V.rows());
  in.vertex_data = {{"heat", NumberType::float32, 1, std::vector<double>(vertices, 3)},
                    {"id", NumberType::int32, 1, std::vector<double>(vertices, 4)}};
  const TetMesh m = meshed(s);
  ASSERT_GT(m.V.rows(), s.V.rows());
  const MeshAttributes a = attributes(s, m, in);
  EXPECT_EQ(a.vertex_data[0].values[vertices - 1], 3);
  EXPECT_TRUE(std::isnan(a.vertex_data[0].values[vertices]));
  EXPECT_EQ(a.vertex_data[1].values[vertices], 0);
  EXPECT_EQ(a.input_vertex[vertices - 1], static_cast<Index>(vertices - 1));
  EXPECT_EQ(a.input_vertex[vertices], -1);
}

TEST(MeshAttributes, AreCarriedWhereVerticesAndFacesAreLeftOut) {
  SurfaceAttributes in;
  in.faces = {{5, 6, 7}, {{6, "x"}}};
  in.vertex_data = {{"uv", NumberType::float64, 2, {0, 1, 2, 3, 4, 5}}};
  const SurfaceAttributes once = carried(in, {2, 0}, {1, 2});
  EXPECT_EQ(once.faces.of, (List{6, 7}));
  EXPECT_EQ(once.vertex_data[0].values, (std::vector<double>{4, 5, 0, 1}));
  EXPECT_EQ(once.input_vertex, (List{2, 0}));
  EXPECT_EQ(once.input_face, (List{1, 2}));
  const SurfaceAttributes twice = carried(once, {1}, {1});
  EXPECT_EQ(twice.input_vertex, List{});  // vertex 0 again, under its own number
  EXPECT_EQ(twice.input_face, List{2});
  EXPECT_EQ(carried(in, {}, {2}).vertex_data[0].values, in.vertex_data[0].values);
}

struct Wrong {
  const char* what;
  void (*change)(MeshAttributes&);
  const char* said;
};

TEST(VerifyAttributes, FindsWhatIsNotTheSurfaces) {
  const Surface s = test::sphere(1);
  const TetMesh m = meshed(s);
  SurfaceAttributes in;
  in.faces.of.assign(static_cast<std::size_t>(s.F.rows()), 4);
  const MeshAttributes good = attributes(s, m, in);
  for (const bool by_place : {false, true}) {
    EXPECT_TRUE(verify_attributes(s, in, {m, good}, by_place).empty());
    EXPECT_TRUE(verify_attributes(s, in, {m, {}}, by_place).empty());  // nothing to check
    for (const Wrong& w :
         {Wrong{"turned over", [](MeshAttributes& a) { std::swap(a.triangles(3, 0), a.triangles(3, 1)); },
                "lack"},
          Wrong{"one left out",
                [](MeshAttributes& a) {
                  a.triangles = a.triangles.bottomRows(79).eval(), a.labels.of.pop_back();
                },
                "lack"},
          Wrong{"another one", [](MeshAttributes& a) { a.triangles(3, 0) = a.triangles(70, 0); },
                "not faces"},
          Wrong{"another label", [](MeshAttributes& a) { a.labels.of[7] = 3; }, "other labels"},
          Wrong{"no vertex", [](MeshAttributes& a) { a.triangles(0, 0) = 1 << 20; }, "do not exist"}}) {
      MeshAttributes bad = good;
      w.change(bad);
      const std::vector<VerifyFailure> failures = verify_attributes(s, in, {m, bad}, by_place);
      ASSERT_FALSE(failures.empty()) << w.what;
      EXPECT_NE(failures.back().message.find(w.said) != std::string::npos ||
                    failures.front().message.find(w.said) != std::string::npos,
                false)
          << w.what << ": " << failures.back().message;
      EXPECT_EQ(failures[0].rule, Rule::R7);
    }
    // Turned, not turned over: the same face.
    MeshAttributes turned = good;
    turned.triangles.row(3) << good.triangles(3, 1), good.triangles(3, 2), good.triangles(3, 0);
    EXPECT_TRUE(verify_attributes(s, in, {m, turned}, by_place).empty());
  }
}

}  // namespace
}  // namespace overtet
