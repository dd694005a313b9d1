// Skinning weights, where handles hold a mesh that overlaps itself, and what poses do with it.
#include "overtet/weights.h"

#include <gtest/gtest.h>

#include <cmath>

#include "src/mesh/tet_complex.h"
#include "tests/support/tet_shapes.h"

namespace overtet {
namespace {

using Point = Eigen::Vector3d;

Handle point(const std::string& name, int place) {
  Handle h;
  h.name = name;
  h.place = place;
  return h;
}

Handle bone(const std::string& name, int head, int tail, int parent = -1) {
  Handle h = point(name, head);
  h.tail = tail;
  h.parent = parent;
  return h;
}

HandlePlace at(const Point& p) {
  HandlePlace place;
  place.position = p;
  return place;
}

HandlePlace vertex(Index v) {
  HandlePlace place;
  place.vertex = v;
  return place;
}

SkinningWeights solved(const TetMesh& mesh, const Handles& handles, const WeightOptions& options = {}) {
  const Result<SkinningWeights> w = skinning_weights(mesh, handles, options);
  EXPECT_TRUE(w.ok()) << w.error().message;
  return w.ok() ? w.value() : SkinningWeights();
}

std::string refusal(const TetMesh& mesh, const Handles& handles, const WeightOptions& options = {}) {
  const Result<SkinningWeights> w = skinning_weights(mesh, handles, options);
  EXPECT_FALSE(w.ok());
  if (w.ok()) return {};
  EXPECT_EQ(w.error().code, ErrorCode::usage);
  return w.error().message;
}

void expect_weights(const SkinningWeights& w) {
  ASSERT_GT(w.weights.size(), 0);
  EXPECT_GE(w.weights.minCoeff(), 0);
  EXPECT_LE(w.weights.maxCoeff(), 1);
  EXPECT_LT((w.weights.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-12);
  for (const HandleWeights& h : w.handles) EXPECT_NE(h.end, WeightsEnd::stalled);
}

// A bar of 12 x 3 x 3 cells, and bones along its middle.
TetMesh bar() { return test::grid_tets(12, 3, 3, 0, 1); }
Handles two_bones() {
  Handles h;
  h.places = {at({0.5, 1.5, 1.5}), at({6, 1.5, 1.5}), at({11.5, 1.5, 1.5})};
  h.handles = {bone("upper", 0, 1), bone("lower", 1, 2, 0)};
  return h;
}

// Its two ends overlap.
TetMesh bent() { return test::bent_grid(4, 420, 0, 1); }

// A place in two layers, by trying vertices' neighbourhoods: the centre of a tet that another tet contains.
struct DoublePlace {
  Point p;
  Index first = -1, second = -1;
};
DoublePlace double_place(const TetMesh& m) {
  for (Index t = 0; t < m.T.rows(); ++t) {
    Point p = Point::Zero();
    // Off the centre, so that it lies in no face of another tet by symmetry.
    const double share[] = {0.23, 0.27, 0.31, 0.19};
    for (int k = 0; k < 4; ++k) p += share[k] * m.V.row(m.T(t, k)).transpose();
    for (Index u = t + 1; u < m.T.rows(); ++u) {
      Eigen::Matrix3d E;
      for (int k = 0; k < 3; ++k) E.col(k) = (m.V.row(m.T(u, k + 1)) - m.V.row(m.T(u, 0))).transpose();
      const Eigen::Vector3d b = E.inverse() * (p - m.V.row(m.T(u, 0)).transpose());
      if (b.minCoeff() > 1e-3 && b.sum() < 1 - 1e-3) return {p, t, u};
    }
  }
  return {};
}

TEST(SkinningWeights, AreBoundedAndSumToOneAndHoldAtHandles) {
  const TetMesh mesh = test::grid_tets(6, 0.2, 7);
  Handles h;
  h.places = {vertex(0), at({3.1, 2.9, 3.2}), at({5.5, 5.4, 1.1}), at({5.5, 1.2, 1.1})};
  h.handles = {point("corner", 0), point("middle", 1), bone("bone", 2, 3)};
  const SkinningWeights w = solved(mesh, h);
  expect_weights(w);
  EXPECT_EQ(w.weights(0, 0), 1);
  EXPECT_EQ(w.weights(0, 1), 0);
  EXPECT_EQ(w.handles[0].held, 1);
  EXPECT_EQ(w.handles[1].held, 4);  // the corners of its tet
  EXPECT_GT(w.handles[2].held, 8);
  EXPECT_EQ(w.shared, 0);
  for (const HandleWeights& x : w.handles) EXPECT_LT(x.residual, 1e-8);
}

TEST(SkinningWeights, DoNotDependOnThreads) {
  const TetMesh mesh = test::grid_tets(6, 0.2, 11);
  Handles h;
  for (const Index v : {0, 40, 120, 200, 300}) {
    h.places.push_back(vertex(v));
    h.handles.push_back(point("v" + std::to_string(v), static_cast<int>(h.places.size()) - 1));
  }
  RunContext one, four;
  one.threads = 1, four.threads = 4;
  const auto a = skinning_weights(mesh, h, {}, one), b = skinning_weights(mesh, h, {}, four);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_TRUE((a.value().weights.array() == b.value().weights.array()).all());
}

TEST(SkinningWeights, DoNotDependOnUnits) {
  TetMesh mesh = test::grid_tets(5, 0.2, 5);
  Handles h;
  h.places = {at({0.7, 1.1, 0.6}), at({4.1, 3.9, 4.2}), vertex(30)};
  h.handles = {point("a", 0), point("b", 1), point("c", 2)};
  const SkinningWeights w = solved(mesh, h);
  for (const double unit : {0x1p-20, 0x1p+20}) {
    TetMesh other = mesh;
    other.V *= unit;
    Handles there = h;
    for (HandlePlace& p : there.places) p.position *= unit;
    EXPECT_TRUE((solved(other, there).weights.array() == w.weights.array()).all()) << unit;
  }
}

// The mirror image of the bar has the mirrored weights (the mesh is mirrored, too).
TEST(SkinningWeights, AreSymmetricOnASymmetricBeam) {
  TetMesh mesh = bar();
  TetMesh mirrored = mesh;
  mirrored.V.col(0) = 12 - mesh.V.col(0).array();
  mirrored.T.col(0).swap(mirrored.T.col(1));
  Handles h;
  h.places = {at({1.3, 1.4, 1.7}), at({10.7, 1.4, 1.7})};
  h.handles = {point("left", 0), point("right", 1)};
  const SkinningWeights a = solved(mesh, h), b = solved(mirrored, h);
  expect_weights(a);
  EXPECT_LT((a.weights - b.weights.rowwise().reverse()).cwiseAbs().maxCoeff(), 1e-8);
}

TEST(SkinningWeights, BonesShareTheirJoint) {
  const SkinningWeights w = solved(bar(), two_bones());
  expect_weights(w);
  EXPECT_GT(w.shared, 0);
  EXPECT_EQ(w.handles[0].cut_at, 1);
  const TetMesh mesh = bar();
  for (Eigen::Index v = 0; v < mesh.V.rows(); ++v) {
    if (mesh.V(v, 0) < 3) {
      EXPECT_GT(w.weights(v, 0), 0.9);
    } else if (mesh.V(v, 0) > 9) {
      EXPECT_GT(w.weights(v, 1), 0.9);
    }
  }
}

TEST(SkinningWeights, ABoneAlongEdgesHoldsOnlyTheirVertices) {
  const TetMesh mesh = bar();
  Handles h;
  h.places = {at({2, 1, 1}), at({5, 1, 1}), at({9, 1, 1})};
  h.handles = {bone("bone", 0, 1), point("point", 2)};
  const SkinningWeights w = solved(mesh, h);
  EXPECT_EQ(w.handles[0].held, 4);
  EXPECT_EQ(w.handles[1].held, 1);
}

TEST(SkinningWeights, BonesThatLeaveTheSolid) {
  const TetMesh mesh = bar();
  Handles h = two_bones();
  h.places[2].position = {14.1, 1.5, 1.5};
  const std::string said = refusal(mesh, h);
  EXPECT_NE(said.find("Bone 'lower' leaves the solid at (12, 1.5, 1.5)"), said.npos) << said;
  WeightOptions cut;
  cut.cut_bones = true;
  const SkinningWeights w = solved(mesh, h, cut);
  expect_weights(w);
  EXPECT_NEAR(w.handles[1].cut_at, 6 / 8.1, 1e-7);
  h.places[0].position = {-1, 1, 1};
  EXPECT_NE(refusal(mesh, h, cut).find("outside the solid; the nearest vertex is"), said.npos);
}

TEST(SkinningWeights, LayersAreListedAndChosen) {
  const TetMesh mesh = bent();
  const DoublePlace twice = double_place(mesh);
  ASSERT_GE(twice.first, 0);
  Handles h;
  h.places = {at(twice.p), vertex(0)};
  // In the middle of the bar, between the two: opposite of where they are.
  Index opposite = 0;
  for (Index v = 0; v < mesh.V.rows(); ++v)
    if ((mesh.V.row(v).transpose() - twice.p).norm() > (mesh.V.row(opposite).transpose() - twice.p).norm())
      opposite = v;
  h.places[1] = vertex(opposite);
  h.handles = {point("here", 0), point("there", 1)};
  const std::string said = refusal(mesh, h);
  EXPECT_NE(said.find("2 layers"), said.npos) << said;
  EXPECT_NE(said.find("layer 0: tet " + std::to_string(twice.first)), said.npos) << said;
  EXPECT_NE(said.find("layer 1: tet " + std::to_string(twice.second)), said.npos) << said;
  for (const int layer : {0, 1}) {
    h.places[0].layer = layer;
    const SkinningWeights w = solved(mesh, h);
    expect_weights(w);
    const Index mine = layer == 0 ? twice.first : twice.second,
                other = layer == 0 ? twice.second : twice.first;
    for (int k = 0; k < 4; ++k) {
      EXPECT_EQ(w.weights(mesh.T(mine, k), 0), 1);
      EXPECT_LT(w.weights(mesh.T(other, k), 0), 0.01);
    }
  }
  h.places[0].layer = 2;
  EXPECT_NE(refusal(mesh, h).find("layer 2"), said.npos);
}

// A chain of bones along a bar that is bent by more than a turn: its end is where its beginning is, in
// another layer. Both are found from the bones between them, which are in one layer only.
TEST(SkinningWeights, BonesStayInTheirLayer) {
  const TetMesh mesh = bent();
  Handles h;
  for (int degrees = 5; degrees <= 415; degrees += 10) {
    const double a = degrees * std::acos(-1.0) / 180;
    h.places.push_back(at({2.03 * std::sin(a), 2.03 * std::cos(a), 0.52}));
  }
  const int bones = static_cast<int>(h.places.size()) - 1;
  for (int i = 0; i < bones; ++i) h.handles.push_back(bone("bone " + std::to_string(i), i, i + 1, i - 1));
  const SkinningWeights w = solved(mesh, h);
  expect_weights(w);
  // Grids are numbered along the bar first.
  Index across = 0;
  while (across + 1 < mesh.V.rows() && mesh.V(across + 1, 2) == 0 &&
         std::abs(mesh.V.row(across + 1).head<2>().norm() - 1.5) < 1e-9)
    ++across;
  int looked = 0;
  for (Index v = 0; v < mesh.V.rows(); ++v) {
    const double degrees = 420.0 * (v % (across + 1)) / across;
    // What is held by the bones a turn further has no part here.
    for (int i = 0; i < bones; ++i)
      if (const double middle = 10 + 10 * i; std::abs(middle - degrees) > 180) {
        EXPECT_LT(w.weights(v, i), 1e-3) << degrees << ' ' << middle;
        ++looked;
      }
  }
  EXPECT_GT(looked, 1000);
  // Where nothing is known, all is asked for.
  h.places = {h.places[0], h.places[1], vertex(0)};
  h.handles = {bone("a", 0, 1), point("b", 2)};
  EXPECT_NE(refusal(mesh, h).find("The head of bone 'a' at"), std::string::npos);
  // A tail that is said to be elsewhere.
  h.places[0].layer = 0;
  h.places[1].layer = 1;
  EXPECT_NE(refusal(mesh, h).find("in another layer"), std::string::npos);
}

TEST(SkinningWeights, CagesAreLinear) {
  const TetMesh mesh = test::grid_tets(4, 0, 1);
  Handles h;
  // A triangle of the grid's planes: its vertices are on grid points.
  h.places = {at({1, 1, 2}), at({3, 1, 2}), at({1, 3, 2}), at({1, 1, 0.5})};
  h.handles = {point("a", 0), point("b", 1), point("c", 2), point("d", 3)};
  h.cage_faces = {{0, 1, 2}};
  h.cage_edges = {{0, 3}};
  const SkinningWeights w = solved(mesh, h);
  expect_weights(w);
  for (Eigen::Index v = 0; v < mesh.V.rows(); ++v) {
    const double x = mesh.V(v, 0) - 1, y = mesh.V(v, 1) - 1;
    if (mesh.V(v, 2) != 2 || x < 0 || y < 0 || x + y > 2) continue;
    EXPECT_NEAR(w.weights(v, 1), x / 2, 1e-12);
    EXPECT_NEAR(w.weights(v, 2), y / 2, 1e-12);
    EXPECT_NEAR(w.weights(v, 0), 1 - (x + y) / 2, 1e-12);
  }
  // Beyond the solid.
  h.places[1].position = {3, 1, 3};
  h.places[2] = at({1, 3, 3});
  EXPECT_TRUE(skinning_weights(mesh, h).ok());
  TetMesh hollow = mesh;  // without the tets around the point (2, 2, 2)
  std::vector<Index> kept;
  for (Index t = 0; t < mesh.T.rows(); ++t) {
    const Point centre = (mesh.V.row(mesh.T(t, 0)) + mesh.V.row(mesh.T(t, 1)) + mesh.V.row(mesh.T(t, 2)) +
                          mesh.V.row(mesh.T(t, 3))) /
                         4;
    if ((centre - Point(1.5, 1.5, 2.5)).cwiseAbs().maxCoeff() > 0.5) kept.push_back(t);
  }
  hollow.T = mesh.T(kept, Eigen::all).eval();
  EXPECT_NE(refusal(hollow, h).find("The cage's face of 'a', 'b' and 'c' leaves the solid"),
            std::string::npos);
}

TEST(SkinningWeights, ComponentsOfOneHandleAreItsOwn) {
  const TetMesh one = test::grid_tets(2, 0, 1);
  TetMesh two = one;
  const auto n = static_cast<Index>(one.V.rows());
  two.V.conservativeResize(2 * n, 3);
  two.V.bottomRows(n) = one.V;  // in the same place
  two.T.conservativeResize(2 * one.T.rows(), 4);
  two.T.bottomRows(one.T.rows()) = one.T.array() + n;
  Handles h;
  h.places = {vertex(0), vertex(n - 1), vertex(n)};
  h.handles = {point("a", 0), point("b", 1), point("c", 2)};
  const SkinningWeights w = solved(two, h);
  expect_weights(w);
  EXPECT_TRUE((w.weights.col(2).tail(n).array() == 1).all());
  EXPECT_TRUE((w.weights.col(2).head(n).array() == 0).all());
  EXPECT_TRUE((w.weights.leftCols(2).bottomRows(n).array() == 0).all());
  h.places.pop_back();
  h.handles.pop_back();
  EXPECT_NE(refusal(two, h).find("No handle is in the component of tet " + std::to_string(one.T.rows())),
            std::string::npos);
}

TEST(SkinningWeights, HandlesThatMakeNoSense) {
  const TetMesh mesh = bar();
  Handles h = two_bones();
  h.handles[1].name = "upper";
  EXPECT_NE(refusal(mesh, h).find("Two handles are named 'upper'"), std::string::npos);
  h = two_bones();
  h.handles[0].parent = 1;
  EXPECT_NE(refusal(mesh, h).find("parents"), std::string::npos);
  h = two_bones();
  h.handles[0].place = 9;
  EXPECT_NE(refusal(mesh, h).find("does not exist"), std::string::npos);
  EXPECT_NE(refusal(mesh, {}).find("no handles"), std::string::npos);
  TetMesh flat = mesh;
  flat.V.row(0) = flat.V.row(1);
  const Result<SkinningWeights> w = skinning_weights(flat, two_bones());
  ASSERT_FALSE(w.ok());
  EXPECT_EQ(w.error().code, ErrorCode::bad_input);
}

TEST(Skinned, TheIdentityLeavesEveryBit) {
  const TetMesh mesh = test::grid_tets(4, 0.2, 3);
  const Eigen::MatrixXd weights = Eigen::MatrixXd::Constant(mesh.V.rows(), 3, 1.0 / 3);
  Handles h;
  h.places = {at({0.3, 0.1, 0.7}), at({2, 2, 2.1})};
  h.handles = {point("a", 0), bone("b", 0, 1, 0), bone("c", 1, 0, 1)};
  const auto T = pose_transforms(h, mesh.V, std::vector<HandlePose>(3));
  ASSERT_TRUE(T.ok());
  const auto s = skinned(mesh, weights, T.value());
  ASSERT_TRUE(s.ok());
  EXPECT_TRUE((s.value().mesh.V.array() == mesh.V.array()).all());
  EXPECT_EQ(s.value().flipped, 0);
}

TEST(Skinned, ARigidMotionOfTheRootMovesAllRigidly) {
  const TetMesh mesh = bar();
  const SkinningWeights w = solved(mesh, two_bones());
  std::vector<HandlePose> pose(2);
  pose[0].rotation = Eigen::AngleAxisd(1.1, Point(1, 2, -1).normalized());
  pose[0].translation = {3, -2, 0.5};
  const auto T = pose_transforms(two_bones(), mesh.V, pose);
  ASSERT_TRUE(T.ok());
  const auto s = skinned(mesh, w.weights, T.value());
  ASSERT_TRUE(s.ok());
  const Point head(0.5, 1.5, 1.5);
  double worst = 0;
  for (Eigen::Index v = 0; v < mesh.V.rows(); ++v) {
    const Point expected = pose[0].rotation * (mesh.V.row(v).transpose() - head) + head + pose[0].translation;
    worst = std::max(worst, (s.value().mesh.V.row(v).transpose() - expected).norm());
  }
  EXPECT_LT(worst, 1e-13);
  EXPECT_EQ(s.value().flipped, 0);
}

TEST(Skinned, ChildrenTurnAboutTheirHeadAndFlippedTetsAreCounted) {
  const TetMesh mesh = bar();
  const SkinningWeights w = solved(mesh, two_bones());
  std::vector<HandlePose> pose(2);
  pose[1].rotation = Eigen::AngleAxisd(std::acos(-1.0) / 3, Point::UnitZ());
  auto T = pose_transforms(two_bones(), mesh.V, pose);
  ASSERT_TRUE(T.ok());
  EXPECT_LT((T.value()[1] * Eigen::Vector4d(6, 1.5, 1.5, 1) - Point(6, 1.5, 1.5)).norm(), 1e-14);
  EXPECT_LT((T.value()[1] * Eigen::Vector4d(8, 1.5, 1.5, 1) - Point(7, 1.5 + std::sqrt(3.0), 1.5)).norm(),
            1e-14);
  // A matrix in its place: a mirror flips everything.
  AffineMatrix mirror = AffineMatrix::Zero();
  mirror.leftCols<3>() = Eigen::Vector3d(-1, 1, 1).asDiagonal();
  pose[0].matrix = mirror;
  pose[1] = {};
  T = pose_transforms(two_bones(), mesh.V, pose);
  ASSERT_TRUE(T.ok());
  const auto s = skinned(mesh, w.weights, T.value());
  ASSERT_TRUE(s.ok());
  EXPECT_EQ(s.value().flipped, mesh.T.rows());
  EXPECT_EQ(s.value().first_flipped, 0);
  EXPECT_EQ(skinned(mesh, w.weights.topRows(3), T.value()).error().code, ErrorCode::usage);
}

}  // namespace
}  // namespace overtet
