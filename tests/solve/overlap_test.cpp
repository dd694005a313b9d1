// Meshes that overlap themselves: linear fields are exact, and a finger that is sunk into its own palm is as
// far from it, and as cold for it, as the way through the finger says.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <queue>
#include <utility>

#include "kernels/core/tet_tables.h"
#include "kernels/parallel/parallel.h"
#include "tests/solve/conditions.h"
#include "tests/support/tet_shapes.h"

namespace overtet {
namespace {

using Point = Eigen::Vector3d;

TEST(Overlap, LinearFieldsAreExactWithEitherSolver) {
  const LabelledTetMesh m = test::with_boundary(test::bent_grid(6, 400, 0.15, 1));
  const ScalarFunction u = [](const Point& p) { return 1 - p[0] + 0.5 * p[1] + 2 * p[2]; };
  for (const int order : {1, 2})
    for (const LinearSolver solver : {LinearSolver::direct, LinearSolver::iterative}) {
      FieldOptions o;
      o.order = order;
      o.solver = solver;
      o.values = {test::everywhere(u)};
      const Result<Field> f = solve_field(m, o);
      ASSERT_TRUE(f.ok()) << f.error().message;
      EXPECT_EQ(f.value().solver, solver);
      EXPECT_EQ(f.value().iterations > 0, solver == LinearSolver::iterative);
      for (Eigen::Index v = 0; v < f.value().nodes.rows(); ++v)
        ASSERT_NEAR(f.value().values[v], u(f.value().nodes.row(v).transpose()), 1e-12);
    }
}

TEST(Overlap, BothSolversAgreeAndThreadsDoNotMatter) {
  const LabelledTetMesh m = test::with_boundary(test::bent_grid(7, 400, 0.15, 2));
  FieldOptions o;
  o.equation = FieldEquation::poisson;
  o.values = {{.label = std::nullopt, .vertices = {0, 5}, .function = [](const Point&) { return 1.0; }}};
  o.source = [](const Point& p) { return p[0]; };
  for (o.order = 1; o.order <= 2; ++o.order) {
    o.solver = LinearSolver::direct;
    const Result<Field> direct = solve_field(m, o);
    ASSERT_TRUE(direct.ok()) << direct.error().message;
    o.solver = LinearSolver::iterative;
    std::vector<Eigen::VectorXd> found;
    for (const int threads : {1, 2, 3}) {
      const ScopedThreads scope(threads);
      const Result<Field> f = solve_field(m, o);
      ASSERT_TRUE(f.ok()) << f.error().message;
      EXPECT_EQ(f.value().solver, LinearSolver::iterative);
      // Two values given: a factor comes no nearer, either.
      EXPECT_LE(f.value().residual, std::max(1e-12, 4 * direct.value().residual));
      found.push_back(f.value().values);
      EXPECT_NEAR(f.value().energy, direct.value().energy, 1e-10 * direct.value().energy);
    }
    for (const Eigen::VectorXd& u : found) EXPECT_TRUE((u.array() == found[0].array()).all());
    EXPECT_LT((found[0] - direct.value().values).norm(), 1e-9 * direct.value().values.norm());
  }
}

// Tets so flat that conjugate gradients get nowhere near: the answer is a factor's, and says so.
TEST(Overlap, TheDirectSolverTakesOverWhereTetsAreFlat) {
  TetMesh flat = test::grid_tets(8, 0.2, 2);
  flat.V.col(2) *= 1e-7;
  FieldOptions o;
  o.solver = LinearSolver::iterative;
  o.equation = FieldEquation::poisson;
  o.source = [](const Point& p) { return p[0]; };
  o.values = {{.label = std::nullopt, .vertices = {0}, .function = [](const Point&) { return 1.0; }}};
  const Result<Field> f = solve_field(test::with_boundary(flat), o);
  ASSERT_TRUE(f.ok()) << f.error().message;
  EXPECT_EQ(f.value().solver, LinearSolver::direct);
  EXPECT_GT(f.value().factor_entries, 0);
}

// A palm of 4 x 4 x 1, and a finger 1 wide that leaves it at x = 4 and, if it is curled, bends upwards and
// back until its tip is inside the palm.
struct Hand {
  static constexpr int kCells = 6;                      // in a unit of length
  static constexpr double kBend = 0.75, kDepth = 0.86;  // the inner radius; how deep the tip is sunk in
  static double length() { return (kBend + 0.5) * 1.5 * M_PI + kBend + kDepth; }

  TetMesh mesh;
  std::vector<Index> palm, far_end, tip;  // vertices
};

Point curled_place(const Point& p) {
  const double s = p[0] - 4, radius = 1 + Hand::kBend - p[2], middle = Hand::kBend + 0.5;
  if (s <= 0) return p;
  const double angle = std::min(s / middle, 1.5 * M_PI), beyond = s - angle * middle;
  return {4 + radius * std::sin(angle), p[1], 1 + Hand::kBend - radius * std::cos(angle) - beyond};
}

Hand make_hand(bool curled) {
  constexpr int n = Hand::kCells;
  const int cells = static_cast<int>(std::round(Hand::length() * n));
  Hand hand;
  std::map<std::array<int, 3>, Index> number;
  std::vector<Point> places;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const auto [it, is_new] = number.emplace(at, static_cast<Index>(places.size()));
    if (!is_new) return it->second;
    const double x = at[0] <= 4 * n ? at[0] / double{n} : 4 + Hand::length() * (at[0] - 4 * n) / cells;
    const Point p(x, at[1] / double{n}, at[2] / double{n});
    places.push_back(curled ? curled_place(p) : p);
    if (at[0] <= 4 * n) hand.palm.push_back(it->second);
    if (at[0] == 0) hand.far_end.push_back(it->second);
    if (at[0] == 4 * n + cells) hand.tip.push_back(it->second);
    return it->second;
  };
  // Six tets a cube, as in grid_tets().
  std::vector<std::array<Index, 4>> tets;
  const TetMesh cube = test::grid_tets(1, 0, 1);
  for (int x = 0; x < 4 * n + cells; ++x)
    for (int y = 0; y < 4 * n; ++y)
      for (int z = 0; z < n; ++z) {
        if (x >= 4 * n && (2 * y < 3 * n || 2 * y >= 5 * n)) continue;
        for (Eigen::Index t = 0; t < cube.T.rows(); ++t) {
          std::array<Index, 4> tet;
          for (std::size_t k = 0; k < 4; ++k) {
            const Point p = cube.V.row(cube.T(t, static_cast<Eigen::Index>(k)));
            tet[k] =
                vertex({x + static_cast<int>(p[0]), y + static_cast<int>(p[1]), z + static_cast<int>(p[2])});
          }
          tets.push_back(tet);
        }
      }
  hand.mesh.V.resize(std::ssize(places), 3);
  for (std::size_t v = 0; v < places.size(); ++v) hand.mesh.V.row(static_cast<Eigen::Index>(v)) = places[v];
  hand.mesh.T.resize(std::ssize(tets), 4);
  for (std::size_t t = 0; t < tets.size(); ++t)
    for (int k = 0; k < 4; ++k)
      hand.mesh.T(static_cast<Eigen::Index>(t), k) = tets[t][static_cast<std::size_t>(k)];
  return hand;
}

// Along edges: never less than the distance.
std::vector<double> along_edges(const TetMesh& mesh, Index source) {
  std::vector<std::vector<std::pair<Index, double>>> ways(static_cast<std::size_t>(mesh.V.rows()));
  for (Eigen::Index t = 0; t < mesh.T.rows(); ++t)
    for (const auto& [i, j] : kTetEdge) {
      const Index a = mesh.T(t, i), b = mesh.T(t, j);
      const double length = (mesh.V.row(a) - mesh.V.row(b)).norm();
      ways[static_cast<std::size_t>(a)].push_back({b, length});
      ways[static_cast<std::size_t>(b)].push_back({a, length});
    }
  std::vector<double> distance(ways.size(), std::numeric_limits<double>::infinity());
  std::priority_queue<std::pair<double, Index>, std::vector<std::pair<double, Index>>, std::greater<>> queue;
  queue.push({distance[static_cast<std::size_t>(source)] = 0, source});
  while (!queue.empty()) {
    const auto [d, v] = queue.top();
    queue.pop();
    if (d > distance[static_cast<std::size_t>(v)]) continue;
    for (const auto& [w, length] : ways[static_cast<std::size_t>(v)])
      if (d + length < distance[static_cast<std::size_t>(w)])
        queue.push({distance[static_cast<std::size_t>(w)] = d + length, w});
  }
  return distance;
}

// Of the palm, in space.
Index nearest_of_palm(const Hand& hand, Index v) {
  Index best = hand.palm.front();
  const auto away = [&](Index w) { return (hand.mesh.V.row(w) - hand.mesh.V.row(v)).norm(); };
  for (const Index w : hand.palm)
    if (away(w) < away(best)) best = w;
  return best;
}

TEST(Overlap, DistancesFromASunkenFingerGoThroughIt) {
  const Hand hand = make_hand(true);
  const VertexMatrix& V = hand.mesh.V;
  const Result<Distances> prepared = Distances::prepare(hand.mesh);
  ASSERT_TRUE(prepared.ok()) << prepared.error().message;
  for (const Index tip : hand.tip) {
    const Index palm = nearest_of_palm(hand, tip);
    ASSERT_LT((V.row(palm) - V.row(tip)).norm(), 0.2);  // what is wrong
    const Result<Eigen::VectorXd> found = prepared.value().from(std::array{tip});
    ASSERT_TRUE(found.ok());
    // Every way passes along the straight part of the finger, around the bend, and from x = 4 through the
    // palm.
    const double least = 1 + Hand::kBend - V(tip, 2) + Hand::kBend * 1.5 * M_PI + 4 - V(palm, 0);
    const double most = along_edges(hand.mesh, tip)[static_cast<std::size_t>(palm)];
    EXPECT_GT(least, 5);
    EXPECT_GT(found.value()[palm], 0.95 * least);
    // With six cells across the finger, the way around the bend comes out longer, by less than .15 of it.
    EXPECT_LT(found.value()[palm], 1.15 * most);
  }
}

// One at the fingertip, nothing at the far end of the palm: what reaches the palm is the same, whether the
// finger is straight or sunk into it (a bent bar conducts some hundredths better).
TEST(Overlap, ASunkenFingerDoesNotWarmThePalm) {
  std::vector<Eigen::VectorXd> found;
  for (const bool curled : {false, true}) {
    const Hand hand = make_hand(curled);
    FieldOptions o;
    o.values = {
        {.label = std::nullopt, .vertices = hand.tip, .function = [](const Point&) { return 1.0; }},
        {.label = std::nullopt, .vertices = hand.far_end, .function = [](const Point&) { return 0.0; }}};
    const Result<Field> f = solve_field(test::with_boundary(hand.mesh), o);
    ASSERT_TRUE(f.ok()) << f.error().message;
    found.push_back(f.value().values);
  }
  const Hand hand = make_hand(true);
  for (const Index tip : hand.tip) {
    EXPECT_EQ(found[1][tip], 1);
    const Index palm = nearest_of_palm(hand, tip);
    EXPECT_LT(found[1][palm], 0.2);
  }
  double most = 0;
  for (const Index v : hand.palm) most = std::max(most, found[0][v]);
  for (const Index v : hand.palm) EXPECT_NEAR(found[1][v], found[0][v], 0.15 * most) << v;
}

}  // namespace
}  // namespace overtet
