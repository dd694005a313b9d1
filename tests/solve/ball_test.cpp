// Convergence on a ball that Overtet meshes, at three sizes, against smooth exact solutions. They are given
// on the boundary of the polyhedron, so that its distance from the sphere is no error.
#include <gtest/gtest.h>

#include <cmath>

#include "kernels/fem/elements.h"
#include "overtet/meshing.h"
#include "tests/solve/conditions.h"
#include "tests/support/tet_shapes.h"

namespace overtet {
namespace {

using Point = Eigen::Vector3d;
using Slope = std::function<Point(const Point&)>;

struct Ball {
  LabelledTetMesh mesh;
  double h = 0;  // the edge of a cube with as many tets
};

// Each one's edges half as long.
const std::vector<Ball>& balls() {
  static const std::vector<Ball> all = [] {
    std::vector<Ball> list;
    for (const int subdivisions : {1, 2, 3}) {
      MeshingOptions options;
      options.sizes.max_edge = 1.1 / (1 << subdivisions);
      const Result<Meshing> meshing = tetrahedralize(test::sphere_surface(subdivisions), options);
      EXPECT_TRUE(meshing.ok());
      list.push_back({test::with_boundary(meshing.value().mesh),
                      std::cbrt(1 / static_cast<double>(meshing.value().mesh.T.rows()))});
    }
    return list;
  }();
  return all;
}

double exact(const Point& p) { return std::sin(2 * p[0]) * std::exp(p[1]) * std::cos(p[2]); }
Point exact_slope(const Point& p) {
  const double e = std::exp(p[1]);
  return {2 * std::cos(2 * p[0]) * e * std::cos(p[2]), exact(p), -std::sin(2 * p[0]) * e * std::sin(p[2])};
}
double harmonic(const Point& p) { return std::sin(p[0]) * std::exp(p[1]); }
Point harmonic_slope(const Point& p) {
  return {std::cos(p[0]) * std::exp(p[1]), std::sin(p[0]) * std::exp(p[1]), 0};
}

struct Errors {
  double value = 0, slope = 0;  // L2 norms of u - u_h, and of its gradient
};

// With three Gauss points in each direction of a cube that is folded into the tet: exact up to degree 3 and
// better.
Errors errors_of(const LabelledTetMesh& m, const Field& field, int order, const ScalarFunction& u,
                 const Slope& slope) {
  const TetElements elements(m.mesh.V, m.mesh.T, order);
  const double at[3] = {0.5 - std::sqrt(0.15), 0.5, 0.5 + std::sqrt(0.15)},
               weight[3] = {5 / 18., 8 / 18., 5 / 18.};
  Errors sum;
  for (Index t = 0; t < elements.tets(); ++t) {
    const TetShape& s = elements.shape(t);
    for (int point = 0; point < 27; ++point) {
      const int i = point % 3, j = point / 3 % 3, k = point / 9;
      const double a = at[i], b = (1 - a) * at[j], c = (1 - a - b) * at[k];
      const double part = 6 * s.volume * weight[i] * weight[j] * weight[k] * (1 - a) * (1 - a - b);
      const double bary[4] = {1 - a - b - c, a, b, c};
      Point p = Point::Zero(), gradient = Point::Zero();
      double value = 0;
      const auto add = [&](int node, double shape, const Point& derivative) {
        value += shape * field.values[elements.node(t, node)];
        gradient += derivative * field.values[elements.node(t, node)];
      };
      for (int n = 0; n < 4; ++n) {
        p += bary[n] * m.mesh.V.row(m.mesh.T(t, n)).transpose();
        const Point d = s.gradient.row(n);
        if (order == 1)
          add(n, bary[n], d);
        else
          add(n, bary[n] * (2 * bary[n] - 1), (4 * bary[n] - 1) * d);
      }
      if (order == 2) {
        int node = 4;
        for (int n = 0; n < 4; ++n)
          for (int o = n + 1; o < 4; ++o, ++node)
            add(node, 4 * bary[n] * bary[o],
                4 * (bary[n] * s.gradient.row(o) + bary[o] * s.gradient.row(n)).transpose());
      }
      sum.value += part * std::pow(value - u(p), 2);
      sum.slope += part * (gradient - slope(p)).squaredNorm();
    }
  }
  return {std::sqrt(sum.value), std::sqrt(sum.slope)};
}

// The order of convergence between the last two balls; what all three gave is shown.
Errors rates(const char* what, const std::vector<Errors>& e) {
  const auto ratio = [&](std::size_t i) { return std::log(balls()[i].h / balls()[i + 1].h); };
  for (std::size_t i = 0; i < e.size(); ++i) {
    std::printf("%s: L2 %.3g, H1 %.3g", what, e[i].value, e[i].slope);
    if (i > 0)
      std::printf(", orders %.2f, %.2f", std::log(e[i - 1].value / e[i].value) / ratio(i - 1),
                  std::log(e[i - 1].slope / e[i].slope) / ratio(i - 1));
    std::printf("\n");
  }
  return {std::log(e[1].value / e[2].value) / ratio(1), std::log(e[1].slope / e[2].slope) / ratio(1)};
}

TEST(Ball, PoissonConvergesWithTheOrderOfTheElements) {
  for (const int order : {1, 2}) {
    std::vector<Errors> errors;
    for (const Ball& ball : balls()) {
      FieldOptions o;
      o.equation = FieldEquation::poisson;
      o.order = order;
      o.values = {test::everywhere(exact)};
      o.source = [](const Point& p) { return 4 * exact(p); };
      const Result<Field> f = solve_field(ball.mesh, o);
      ASSERT_TRUE(f.ok()) << f.error().message;
      errors.push_back(errors_of(ball.mesh, f.value(), order, exact, exact_slope));
    }
    const Errors found = rates(order == 1 ? "Poisson, linear" : "Poisson, quadratic", errors);
    EXPECT_GE(found.value, order == 1 ? 1.8 : 2.7);
    EXPECT_GE(found.slope, order == 1 ? 0.9 : 1.8);
  }
}

// Values in one half, fluxes in the other.
TEST(Ball, LaplaceWithFluxesConverges) {
  for (const int order : {1, 2}) {
    std::vector<Errors> errors;
    for (const Ball& ball : balls()) {
      const LabelledTetMesh& m = ball.mesh;
      FieldOptions o;
      o.order = order;
      for (Index f = 0; f < m.attributes.triangles.rows(); ++f) {
        const Point normal = test::outer_normal(m, f);
        if (normal[2] > 0)
          o.values.push_back(test::on_triangle(f, harmonic));
        else
          o.fluxes.push_back(
              test::on_triangle(f, [normal](const Point& p) { return normal.dot(harmonic_slope(p)); }));
      }
      const Result<Field> f = solve_field(m, o);
      ASSERT_TRUE(f.ok()) << f.error().message;
      errors.push_back(errors_of(m, f.value(), order, harmonic, harmonic_slope));
    }
    const Errors found = rates(order == 1 ? "Fluxes, linear" : "Fluxes, quadratic", errors);
    EXPECT_GE(found.value, order == 1 ? 1.8 : 2.7);
    EXPECT_GE(found.slope, order == 1 ? 0.9 : 1.8);
  }
}

TEST(Ball, BiharmonicConverges) {
  std::vector<Errors> errors;
  for (const Ball& ball : balls()) {
    const LabelledTetMesh& m = ball.mesh;
    FieldOptions o;
    o.equation = FieldEquation::biharmonic;
    o.values = {test::everywhere(exact)};
    for (Index f = 0; f < m.attributes.triangles.rows(); ++f)
      o.fluxes.push_back(test::on_triangle(
          f, [normal = test::outer_normal(m, f)](const Point& p) { return normal.dot(exact_slope(p)); }));
    o.source = [](const Point& p) { return 16 * exact(p); };
    const Result<Field> f = solve_field(m, o);
    ASSERT_TRUE(f.ok()) << f.error().message;
    errors.push_back(errors_of(m, f.value(), 1, exact, exact_slope));
  }
  const Errors found = rates("Biharmonic, linear", errors);
  EXPECT_GE(found.value, 1);
  EXPECT_GE(found.slope, 0.5);
}

// In a ball the shortest way is straight: from the centre, and from a vertex of the boundary.
TEST(Ball, GeodesicsConverge) {
  for (const bool centre : {true, false}) {
    std::vector<Errors> errors;
    for (const Ball& ball : balls()) {
      const VertexMatrix& V = ball.mesh.mesh.V;
      Index source = 0;
      if (centre)
        V.rowwise().squaredNorm().minCoeff(&source);
      else
        V.col(0).maxCoeff(&source);
      const Result<Distances> d = Distances::prepare(ball.mesh.mesh);
      ASSERT_TRUE(d.ok()) << d.error().message;
      const Result<Eigen::VectorXd> found = d.value().from(std::array{source});
      ASSERT_TRUE(found.ok());
      const Eigen::VectorXd away = (V.rowwise() - V.row(source)).rowwise().norm();
      const Eigen::VectorXd error = (found.value() - away).cwiseAbs();
      errors.push_back({error.mean(), error.maxCoeff()});
    }
    const Errors found = rates(
        centre ? "Distances from the centre (mean, largest)" : "Distances from the boundary (mean, largest)",
        errors);
    EXPECT_GE(found.value, 0.9);
  }
}

}  // namespace
}  // namespace overtet
