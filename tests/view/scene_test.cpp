// What pictures show, before anybody draws it: cuts close, colours are those of the elements, nothing is out
// of sight.
#include "src/view/scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "overtet/curves.h"
#include "overtet/diagnosis.h"
#include "overtet/meshing.h"
#include "tests/support/models.h"

namespace overtet::view {
namespace {

// A worm that runs into itself: there are two layers where it does.
const LabelledTetMesh& worm() {
  static const LabelledTetMesh mesh = [] {
    const Surface s = test::curled_worm();
    auto made = tetrahedralize(s);
    EXPECT_TRUE(made.ok());
    LabelledTetMesh m{std::move(made.value().mesh), {}};
    auto attributes = mesh_attributes(s, {}, m.mesh);
    EXPECT_TRUE(attributes.ok());
    m.attributes = std::move(attributes.value());
    return m;
  }();
  return mesh;
}

using Corner = std::array<float, 3>;

Corner corner(const Scene& scene, std::size_t triangle, std::size_t k) {
  const float* p = &scene.triangles.corners[9 * triangle + 3 * k];
  return {p[0], p[1], p[2]};
}

double volume(const Scene& scene) {
  double sum = 0;
  for (std::size_t t = 0; t < scene.triangles.colours.size(); ++t) {
    Eigen::Matrix3d m;
    for (std::size_t k = 0; k < 3; ++k) {
      const Corner c = corner(scene, t, k);
      m.row(static_cast<Eigen::Index>(k)) << c[0], c[1], c[2];
    }
    sum += m.determinant() / 6;
  }
  return sum;
}

// How often each edge is passed in one direction more than in the other; edges without length do not count.
std::size_t open_edges(const Scene& scene) {
  std::map<std::pair<Corner, Corner>, int> passed;
  for (std::size_t t = 0; t < scene.triangles.colours.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const Corner a = corner(scene, t, k), b = corner(scene, t, (k + 1) % 3);
      if (a < b) ++passed[{a, b}];
      if (b < a) --passed[{b, a}];
    }
  return static_cast<std::size_t>(
      std::count_if(passed.begin(), passed.end(), [](const auto& edge) { return edge.second != 0; }));
}

LabelledTetMesh mirrored(LabelledTetMesh m, Eigen::Index axis) {
  m.mesh.V.col(axis) *= -1;
  m.mesh.T.col(0).swap(m.mesh.T.col(1));
  m.attributes.triangles.col(0).swap(m.attributes.triangles.col(1));
  return m;
}

// Some shade of the colour.
bool is_shade_of(const Colour& seen, const Colour& colour) {
  const std::size_t most =
      static_cast<std::size_t>(std::max_element(colour.begin(), colour.end()) - colour.begin());
  const double shade = static_cast<double>(seen[most]) / colour[most];
  for (std::size_t k = 0; k < 3; ++k)
    if (std::abs(shade * colour[k] - seen[k]) > 1.5) return false;
  return shade > .3 && shade < 1.01;
}

TEST(Scene, WithoutACutItIsTheBoundary) {
  const Scene scene = scene_of(worm(), {});
  EXPECT_EQ(scene.triangles.colours.size(), static_cast<std::size_t>(worm().attributes.triangles.rows()));
  EXPECT_EQ(open_edges(scene), 0u);
  EXPECT_GT(volume(scene), 0);
  EXPECT_TRUE(scene.wires.empty());
}

TEST(Scene, CutsAreClosedAndBothSidesMakeTheWhole) {
  const unsigned seed = 11;
  std::mt19937 random(seed);
  const double whole = volume(scene_of(worm(), {}));
  for (int i = 0; i < 12; ++i) {
    const int axis = i % 3;
    const double share = i < 3 ? .5 : std::uniform_real_distribution(0., 1.)(random);
    PictureOptions options;
    options.cut = Cut{axis, share};
    const Scene one = scene_of(worm(), options);
    EXPECT_EQ(open_edges(one), 0u) << "seed " << seed << ", cut " << i;
    options.cut->share = 1 - share;
    const Scene other = scene_of(mirrored(worm(), axis), options);
    EXPECT_EQ(open_edges(other), 0u) << "seed " << seed << ", cut " << i;
    EXPECT_NEAR(volume(one) + volume(other), whole, 1e-4 * whole) << "seed " << seed << ", cut " << i;
    EXPECT_GE(volume(one), 0);
  }
}

TEST(Scene, CutsThroughVerticesAreClosed) {
  // The plane passes through vertices and along faces.
  LabelledTetMesh m;
  m.mesh.V.resize(5, 3);
  m.mesh.V << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1;
  m.mesh.T.resize(2, 4);
  m.mesh.T << 0, 1, 2, 3, 1, 4, 2, 3;
  for (const double share : {0., .25, .5, 1.})
    for (int axis = 0; axis < 3; ++axis) {
      PictureOptions options;
      options.cut = Cut{axis, share};
      const Scene scene = scene_of(m, options);
      EXPECT_EQ(open_edges(scene), 0u) << share << " across " << axis;
      if (share == 1) {
        EXPECT_EQ(scene.triangles.colours.size(), 6u);
      }
    }
}

TEST(Scene, ColoursAreThoseOfTheElements) {
  const LabelledTetMesh& m = worm();
  PictureOptions options;
  options.cut = Cut{2, .45};
  bool overlap = false;
  for (const Colouring by : {Colouring::automatic, Colouring::layers, Colouring::region, Colouring::angle,
                             Colouring::label, Colouring::plain}) {
    options.colouring = by;
    const Scene scene = scene_of(m, options);
    const SceneTriangles& all = scene.triangles;
    ASSERT_EQ(all.element.size(), all.colours.size());
    ASSERT_EQ(all.from.size(), all.colours.size());
    ASSERT_EQ(all.corners.size(), 9 * all.colours.size());
    for (std::size_t t = 0; t < all.colours.size(); ++t) {
      const auto tet = static_cast<std::size_t>(all.element[t]);
      const bool cut = all.from[t] == SceneTriangles::From::cut;
      Colour wanted{};
      if (by == Colouring::automatic || by == Colouring::layers) {
        wanted = layer_colour(m.attributes.layers[tet]);
        overlap = overlap || m.attributes.layers[tet] > 1;
      } else if (by == Colouring::region) {
        wanted = group_colour(m.attributes.regions.of[tet]);
      } else if (by == Colouring::angle) {
        continue;
      } else {
        wanted = cut ? inside_colour() : by == Colouring::plain ? plain_colour() : group_colour(1);
      }
      // A boundary face that is seen from inside has the inner side's colour.
      EXPECT_TRUE(is_shade_of(all.colours[t], wanted) || is_shade_of(all.colours[t], inside_colour())) << t;
      if (cut) {
        EXPECT_TRUE(is_shade_of(all.colours[t], wanted)) << t;
      }
    }
  }
  EXPECT_TRUE(overlap);
}

// Where a point is in the picture: -1 to 1 from side to side and from bottom to top.
Eigen::Vector2d seen_at(const Scene& s, const Corner& c) {
  const Eigen::Vector3d ahead = (s.camera.target - s.camera.eye).normalized();
  const Eigen::Vector3d p = Eigen::Vector3d(c[0], c[1], c[2]) - s.camera.eye;
  const double depth = p.dot(ahead), half = std::tan(s.camera.height_degrees / 360 * std::numbers::pi);
  EXPECT_GT(depth, s.camera.near);
  EXPECT_LT(depth, s.camera.far);
  const double across = p.dot(ahead.cross(s.camera.up)), up = p.dot(s.camera.up);
  return {across / depth / half * s.height / s.width, up / depth / half};
}

TEST(Scene, AllOfTheMeshIsInThePicture) {
  const unsigned seed = 3;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 20; ++i) {
    PictureOptions options;
    options.eye = {normal(random), normal(random), normal(random)};
    if (i < 2) options.eye = {0, i == 0 ? 5. : -5., 0};
    options.width = i % 2 == 0 ? 1600 : 400;
    options.height = 700;
    options.apart = i % 3 == 0 ? .6 : 0;
    const Scene scene = scene_of(worm(), options);
    EXPECT_NEAR(scene.camera.up.norm(), 1, 1e-9);
    EXPECT_NEAR(scene.camera.up.dot(scene.camera.target - scene.camera.eye), 0, 1e-9);
    double most = 0;
    for (std::size_t t = 0; t < scene.triangles.colours.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k)
        most = std::max(most, seen_at(scene, corner(scene, t, k)).cwiseAbs().maxCoeff());
    EXPECT_LT(most, 1) << "seed " << seed << ", " << i;
    EXPECT_GT(most, .6) << "seed " << seed << ", " << i;
  }
}

TEST(Scene, SizeAndPlaceOfTheMeshDoNotMatter) {
  PictureOptions options;
  options.cut = Cut{0, .4};
  const Scene scene = scene_of(worm(), options);
  for (const double factor : {0x1p-600, 0x1p600}) {
    LabelledTetMesh m = worm();
    m.mesh.V *= factor;
    const Scene other = scene_of(m, options);
    EXPECT_EQ(scene.triangles.corners, other.triangles.corners) << factor;
    EXPECT_EQ(scene.triangles.colours, other.triangles.colours) << factor;
  }
}

TEST(Scene, SurfacesHaveCurvesMarksAndAnInnerSide) {
  const Surface s = test::elbow();
  const auto diagnosis = diagnose(s);
  ASSERT_TRUE(diagnosis.ok());
  PictureOptions options;
  options.curves = &diagnosis.value().curves;
  for (const HingeDiagnosis& h : diagnosis.value().hinges)
    options.marks.push_back({s.V(h.vertex, 0), s.V(h.vertex, 1), s.V(h.vertex, 2)});
  const Scene scene = scene_of(s, {}, options);
  std::size_t segments = 0;
  for (const Curve& c : options.curves->curves) segments += c.segments.size();
  EXPECT_EQ(scene.lines.size(), 6 * segments);
  EXPECT_EQ(scene.marks.size(), 3 * diagnosis.value().hinges.size());
  EXPECT_GT(scene.marks.size(), 0u);
  options.cut = Cut{1, .5};
  const Scene open = scene_of(s, {}, options);
  EXPECT_TRUE(std::any_of(open.triangles.colours.begin(), open.triangles.colours.end(),
                          [](const Colour& c) { return is_shade_of(c, inside_colour()); }));
  EXPECT_LE(open.lines.size(), scene.lines.size());
  options.apart = .5;
  EXPECT_TRUE(scene_of(s, {}, options).lines.empty());  // they would lie where nothing is
}

TEST(Scene, WiresAreLeftOutWhereTheyWouldBeAHaze) {
  PictureOptions options;
  options.cut = Cut{2, .5};
  EXPECT_GT(scene_of(worm(), options).wires.size(), 0u);
  options.width = options.height = 16;
  EXPECT_EQ(scene_of(worm(), options).wires.size(), 0u);
}

TEST(Scene, AlongRunsFromEndToEndOfEachComponent) {
  // Two chains of triangles, one far longer; a vertex that nothing uses.
  VertexMatrix V = VertexMatrix::Zero(22, 3);
  std::vector<Index> F;
  for (Index i = 0; i < 20; ++i) {
    V.row(i) << i, i % 2, 0;
    if (i % 10 >= 2) F.insert(F.end(), {i - 2, i - 1, i});
  }
  V.bottomRows(12).topRows(10).col(0) *= 100;
  const std::vector<double> along = along_of(V, F, 3);
  for (const std::size_t first : {std::size_t{0}, std::size_t{10}}) {
    EXPECT_EQ(std::min(along[first], along[first + 9]), 0);
    EXPECT_EQ(std::max(along[first], along[first + 9]), 1);
    const double sign = along[first] < along[first + 9] ? 1 : -1;
    for (std::size_t i = 0; i + 2 < 10; ++i) EXPECT_GT(sign * (along[first + i + 2] - along[first + i]), 0);
  }
  EXPECT_EQ(along[20], 0);
}

TEST(Scene, LayersArePulledApart) {
  // Centres of two tets in one place, in layers far along the worm from each other, are no longer near.
  PictureOptions options;
  const Scene together = scene_of(worm(), options);
  options.apart = .7;
  const Scene apart = scene_of(worm(), options);
  ASSERT_EQ(together.triangles.corners.size(), apart.triangles.corners.size());
  const std::size_t n = together.triangles.colours.size();
  std::size_t pairs = 0, parted = 0;
  const auto centre = [](const Scene& s, std::size_t t) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const Corner c = corner(s, t, k);
      sum += Eigen::Vector3d(c[0], c[1], c[2]) / 3;
    }
    return sum;
  };
  const std::vector<double> along =
      along_of(worm().mesh.V, {worm().mesh.T.data(), worm().mesh.T.data() + worm().mesh.T.size()}, 4);
  const auto along_of_triangle = [&](std::size_t t) {
    return along[static_cast<std::size_t>(worm().mesh.T(together.triangles.element[t], 0))];
  };
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < i; j += 3) {
      if ((centre(together, i) - centre(together, j)).norm() > .05) continue;
      if (std::abs(along_of_triangle(i) - along_of_triangle(j)) < .5) continue;
      ++pairs;
      parted += (centre(apart, i) - centre(apart, j)).norm() > .5;
    }
  EXPECT_GT(pairs, 0u);
  EXPECT_EQ(parted, pairs);
}

TEST(Scene, NothingIsAPicture) {
  PictureOptions options;
  options.cut = Cut{};
  options.apart = 1;
  for (const Scene& scene : {scene_of(LabelledTetMesh{}, options), scene_of(Surface{}, {}, options)}) {
    EXPECT_TRUE(scene.triangles.colours.empty());
    EXPECT_TRUE(scene.camera.eye.allFinite());
    EXPECT_GT(scene.camera.far, scene.camera.near);
  }
}

}  // namespace
}  // namespace overtet::view
