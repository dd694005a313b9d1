// Fields against exact solutions: polynomials to rounding, others with the order of the elements.
#include <gtest/gtest.h>

#include <cmath>

#include "overtet/solve.h"
#include "tests/solve/conditions.h"
#include "tests/support/tet_shapes.h"

namespace overtet {
namespace {

using Point = Eigen::Vector3d;

// With its boundary triangles; the label of a triangle is 1, or 2 where all corners have x near 0.
LabelledTetMesh labelled(const TetMesh& mesh) {
  LabelledTetMesh m = test::with_boundary(mesh);
  for (Index& label : m.attributes.labels.of) {  // so far the triangle's number
    bool left = true;
    for (int k = 0; k < 3; ++k) left = left && mesh.V(m.attributes.triangles(label, k), 0) < 1e-9;
    label = left ? 2 : 1;
  }
  return m;
}

double worst(const Field& f, const ScalarFunction& exact) {
  double most = 0;
  for (Eigen::Index v = 0; v < f.nodes.rows(); ++v)
    most = std::max(most, std::abs(f.values[v] - exact(f.nodes.row(v).transpose())));
  return most;
}

TEST(SolveField, LinearFieldsAreExact) {
  const LabelledTetMesh m = labelled(test::grid_tets(4, 0.2, 5));
  const ScalarFunction u = [](const Point& p) { return 3 - p[0] + 2 * p[1] + 0.25 * p[2]; };
  for (const FieldEquation equation : {FieldEquation::laplace, FieldEquation::poisson}) {
    FieldOptions o;
    o.equation = equation;
    for (o.order = 1; o.order <= 2; ++o.order) {
      o.values = {{.label = std::nullopt, .vertices = {}, .function = u}};
      o.fluxes.clear();
      const Result<Field> f = solve_field(m, o);
      ASSERT_TRUE(f.ok()) << f.error().message;
      EXPECT_LT(worst(f.value(), u), 1e-12);
      // The same with a given slope on all but one side.
      o.values[0].label = 2;
      const Point slope(-1, 2, 0.25);
      const TriangleMatrix& F = m.attributes.triangles;
      LabelledTetMesh sides = m;  // a label a triangle: each has its own normal
      FieldOptions own = o;
      for (Eigen::Index i = 0; i < F.rows(); ++i) {
        if (m.attributes.labels.of[static_cast<std::size_t>(i)] == 2) continue;
        const Point a = m.mesh.V.row(F(i, 0)), b = m.mesh.V.row(F(i, 1)), c = m.mesh.V.row(F(i, 2));
        const double flux = (b - a).cross(c - a).normalized().dot(slope);
        const auto label = static_cast<Index>(10 + i);
        sides.attributes.labels.of[static_cast<std::size_t>(i)] = label;
        own.fluxes.push_back(
            {.label = label, .vertices = {}, .function = [flux](const Point&) { return flux; }});
      }
      const Result<Field> g = solve_field(sides, own);
      ASSERT_TRUE(g.ok()) << g.error().message;
      EXPECT_LT(worst(g.value(), u), 1e-12);
    }
  }
}

TEST(SolveField, QuadraticFieldsAreExactWithQuadraticElements) {
  const LabelledTetMesh m = labelled(test::grid_tets(3, 0.2, 9));
  const ScalarFunction u = [](const Point& p) { return p[0] * p[0] - 2 * p[1] * p[1] + p[0] * p[2] + p[1]; };
  FieldOptions o;
  o.equation = FieldEquation::poisson;
  o.order = 2;
  o.values = {{.label = std::nullopt, .vertices = {}, .function = u}};
  o.source = [](const Point&) { return 2.0; };
  const Result<Field> f = solve_field(m, o);
  ASSERT_TRUE(f.ok()) << f.error().message;
  EXPECT_LT(worst(f.value(), u), 1e-12);
}

TEST(SolveField, ConvergesWithTheOrderOfTheElements) {
  const double pi = 3.14159265358979323846;
  const ScalarFunction u = [=](const Point& p) {
    return std::sin(pi * p[0]) * std::cos(pi * p[1] / 2) * p[2];
  };
  for (const int order : {1, 2}) {
    std::vector<double> error;
    for (const int n : {3, 6, 12}) {
      FieldOptions o;
      o.equation = FieldEquation::poisson;
      o.order = order;
      TetMesh grid = test::grid_tets(n, 0, 1);
      grid.V /= grid.V.maxCoeff();
      o.values = {{.label = std::nullopt, .vertices = {}, .function = u}};
      o.source = [=](const Point& p) { return 1.25 * pi * pi * u(p); };
      const Result<Field> f = solve_field(labelled(grid), o);
      ASSERT_TRUE(f.ok()) << f.error().message;
      double sum = 0;
      for (Eigen::Index v = 0; v < f.value().nodes.rows(); ++v)
        sum += std::pow(f.value().values[v] - u(f.value().nodes.row(v).transpose()), 2);
      error.push_back(std::sqrt(sum / static_cast<double>(f.value().nodes.rows())));
    }
    EXPECT_GT(std::log2(error[1] / error[2]), order + 1 - 0.3)
        << error[0] << ' ' << error[1] << ' ' << error[2];
  }
}

// Of fourth order, with values and slopes given: u = x^2 (1 - x)^2 and the like.
TEST(SolveField, BiharmonicFieldsConverge) {
  const auto q = [](double x) { return x * x * (1 - x) * (1 - x); };
  const auto q2 = [](double x) { return 2 - 12 * x + 12 * x * x; };
  const ScalarFunction u = [=](const Point& p) { return q(p[0]) * q(p[1]) * q(p[2]); };
  std::vector<double> error;
  for (const int n : {6, 12}) {
    FieldOptions o;
    o.equation = FieldEquation::biharmonic;
    TetMesh grid = test::grid_tets(n, 0, 1);
    grid.V /= grid.V.maxCoeff();
    o.values = {{.label = std::nullopt, .vertices = {}, .function = u}};
    o.source = [=](const Point& p) {
      const double x = p[0], y = p[1], z = p[2];
      return 24 * (q(y) * q(z) + q(x) * q(z) + q(x) * q(y)) +
             2 * (q2(x) * q2(y) * q(z) + q2(x) * q(y) * q2(z) + q(x) * q2(y) * q2(z));
    };
    const Result<Field> f = solve_field(labelled(grid), o);
    ASSERT_TRUE(f.ok()) << f.error().message;
    error.push_back(worst(f.value(), u));
  }
  EXPECT_LT(error[1], 0.25 * u({0.5, 0.5, 0.5}));
  EXPECT_LT(error[1], 0.5 * error[0]);
}

TEST(SolveField, WhatIsNotDeterminedIsRefused) {
  LabelledTetMesh m = labelled(test::grid_tets(2, 0, 1));
  const ScalarFunction one = [](const Point&) { return 1.0; };
  const auto code = [&](const FieldOptions& o) {
    const Result<Field> f = solve_field(m, o);
    return f.ok() ? std::optional<ErrorCode>() : f.error().code;
  };
  FieldOptions o;
  EXPECT_EQ(code(o), ErrorCode::usage);  // no values
  o.values = {{.label = 77, .vertices = {}, .function = one}};
  EXPECT_EQ(code(o), ErrorCode::usage);  // no such label
  o.values = {{.label = std::nullopt, .vertices = {static_cast<Index>(m.mesh.V.rows())}, .function = one}};
  EXPECT_EQ(code(o), ErrorCode::usage);
  o.values = {
      {.label = std::nullopt, .vertices = {0}, .function = [](const Point& p) { return 1 / (p[0] - p[0]); }}};
  EXPECT_EQ(code(o), ErrorCode::bad_input);
  o.values = {{.label = std::nullopt, .vertices = {0}, .function = one}};
  EXPECT_EQ(code(o), std::nullopt);
  // A second component, of which nothing is known.
  const TetMesh first = m.mesh;
  m.mesh.V.conservativeResize(2 * first.V.rows(), 3);
  m.mesh.V.bottomRows(first.V.rows()) = first.V.array() + 10;
  m.mesh.T.conservativeResize(2 * first.T.rows(), 4);
  m.mesh.T.bottomRows(first.T.rows()) = first.T.array() + static_cast<Index>(first.V.rows());
  EXPECT_EQ(code(o), ErrorCode::usage);
  o.equation = FieldEquation::biharmonic;
  o.order = 2;
  EXPECT_EQ(code(o), ErrorCode::usage);
}

}  // namespace
}  // namespace overtet
