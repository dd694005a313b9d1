// Elastic bodies: patch tests, equilibria, motion, and what is refused.
#include "overtet/elastic.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "kernels/predicates/predicates.h"
#include "src/mesh/tet_complex.h"
#include "tests/support/tet_shapes.h"

namespace overtet {
namespace {

using Place = Eigen::Vector3d;

const ElasticMaterial kMaterials[] = {ElasticMaterial::st_venant_kirchhoff, ElasticMaterial::corotated,
                                      ElasticMaterial::neo_hookean};

// With its boundary triangles: label 1, or 2 at the least x, 3 at the largest.
LabelledTetMesh bar(const TetMesh& mesh) {
  LabelledTetMesh m;
  m.mesh = mesh;
  const auto faces = TetComplex(mesh.V, mesh.T).boundary();
  m.attributes.triangles.resize(std::ssize(faces), 3);
  const double low = mesh.V.col(0).minCoeff(), high = mesh.V.col(0).maxCoeff();
  for (std::size_t f = 0; f < faces.size(); ++f) {
    bool left = true, right = true;
    for (int k = 0; k < 3; ++k) {
      m.attributes.triangles(static_cast<Eigen::Index>(f), k) = faces[f][k];
      left = left && mesh.V(faces[f][k], 0) == low;
      right = right && mesh.V(faces[f][k], 0) == high;
    }
    m.attributes.labels.of.push_back(left ? 2 : right ? 3 : 1);
  }
  return m;
}

ElasticCondition at(Index label, VectorFunction f = {}) {
  return {.label = label, .vertices = {}, .function = std::move(f)};
}
ElasticCondition everywhere(VectorFunction f = {}) {
  return {.label = std::nullopt, .vertices = {}, .function = std::move(f)};
}
VectorFunction constant(double x, double y, double z) {
  return [=](const Place&, double) { return Place(x, y, z); };
}

void expect_positive(const TetMesh& mesh, const VertexMatrix& V) {
  for (Eigen::Index t = 0; t < mesh.T.rows(); ++t)
    ASSERT_GT(orient3d(V.data() + 3 * mesh.T(t, 0), V.data() + 3 * mesh.T(t, 1), V.data() + 3 * mesh.T(t, 2),
                       V.data() + 3 * mesh.T(t, 3)),
              0)
        << t;
}

TEST(SolveElastic, PatchTests) {
  const LabelledTetMesh m = bar(test::grid_tets(4, 0.2, 5));
  Eigen::Matrix3d A;
  A << 0.2, 0.1, -0.05, 0.02, -0.15, 0.1, 0.1, 0.05, 0.12;
  for (const double size : {1.0, 1e-3})
    for (const ElasticMaterial material : kMaterials)
      for (const ElasticMethod method : {ElasticMethod::newton, ElasticMethod::quasi_newton}) {
        ElasticOptions o;
        o.material = material;
        o.method = method;
        o.tolerance = 1e-14;
        o.held = {everywhere([&](const Place& p, double) { return Place(size * (A * p) + Place(1, 2, 3)); })};
        const Result<ElasticResult> r = solve_elastic(m, o);
        ASSERT_TRUE(r.ok()) << r.error().message;
        const VertexMatrix wanted =
            (m.mesh.V + size * m.mesh.V * A.transpose()).rowwise() + Eigen::RowVector3d(1, 2, 3);
        EXPECT_LT((r.value().places - wanted).cwiseAbs().maxCoeff(), 1e-12 * 4)
            << static_cast<int>(material) << ' ' << static_cast<int>(method);
        const Eigen::VectorXd& s = r.value().von_mises;
        EXPECT_LT(s.maxCoeff() - s.minCoeff(), 1e-12 + 1e-12 * s.maxCoeff());
      }
}

// A rotation of the whole boundary by a quarter turn, in frames and all at once, leaves no stress.
TEST(SolveElastic, RotationsLeaveNoStress) {
  const LabelledTetMesh m = bar(test::grid_tets(3, 0.2, 7));
  for (const ElasticMaterial material : kMaterials)
    for (const int frames : {1, 5}) {
      ElasticOptions o;
      o.material = material;
      o.frames = frames;
      o.tolerance = 1e-12;
      o.held = {everywhere([](const Place& p, double t) {
        const Eigen::AngleAxisd turn(t * M_PI / 2, Place(1, 2, -1).normalized());
        return Place(turn * p - p);
      })};
      const Result<ElasticResult> r = solve_elastic(m, o);
      ASSERT_TRUE(r.ok()) << r.error().message;
      EXPECT_LT(r.value().von_mises.maxCoeff(), 1e-11);
    }
}

TEST(SolveElastic, EquilibriaOfSmallLoadsAgreeForAllMaterials) {
  const LabelledTetMesh m = bar(test::grid_tets(6, 2, 2, 0.2, 3));
  VertexMatrix first;
  for (const ElasticMaterial material : kMaterials) {
    ElasticOptions o;
    o.material = material;
    o.young = 1e4;
    o.tolerance = 1e-11;
    o.held = {at(2)};
    o.tractions = {at(3, constant(0, 0, -1e-4))};
    const Result<ElasticResult> r = solve_elastic(m, o);
    ASSERT_TRUE(r.ok()) << r.error().message;
    const VertexMatrix u = r.value().places - m.mesh.V;
    if (first.rows() == 0) first = u;
    EXPECT_LT((u - first).norm(), 1e-5 * first.norm()) << static_cast<int>(material);
  }
  EXPECT_LT(first.col(2).minCoeff(), 0);
}

TEST(SolveElastic, BothMethodsAgree) {
  const LabelledTetMesh m = bar(test::grid_tets(6, 2, 2, 0.2, 3));
  for (const ElasticMaterial material : kMaterials) {
    VertexMatrix found[2];
    for (const bool newton : {false, true}) {
      ElasticOptions o;
      o.material = material;
      o.method = newton ? ElasticMethod::newton : ElasticMethod::quasi_newton;
      o.dynamic = true;
      o.integrator = ElasticIntegrator::bdf2;
      o.young = 10;
      o.frames = 5;
      o.time_step = 0.3;
      o.tolerance = 1e-9;
      o.most_iterations = 1000;
      o.mass_damping = 0.05;
      o.stiffness_damping = 0.02;
      o.held = {at(2)};
      o.tractions = {at(3, constant(0, 0, -0.1))};
      const Result<ElasticResult> r = solve_elastic(m, o);
      ASSERT_TRUE(r.ok()) << r.error().message;
      EXPECT_EQ(r.value().end, ElasticEnd::converged);
      found[newton] = r.value().places;
    }
    EXPECT_LT((found[0] - found[1]).norm(), 1e-6 * (found[1] - m.mesh.V).norm());
  }
}

TEST(SolveElastic, LargeLoadsEndInEquilibriumWithoutFlippedTets) {
  const LabelledTetMesh m = bar(test::grid_tets(8, 2, 2, 0.2, 3));
  for (const ElasticMaterial material : kMaterials) {
    ElasticOptions o;
    o.material = material;
    o.young = 100;
    o.held = {at(2)};
    o.gravity = Place(0, 0, -1);
    const Result<ElasticResult> r = solve_elastic(m, o);
    ASSERT_TRUE(r.ok()) << r.error().message;
    EXPECT_LT(r.value().steps[0].residual, 1e-8);
    expect_positive(m.mesh, r.value().places);
    EXPECT_LT((r.value().places - m.mesh.V).col(2).minCoeff(), -2);
  }
}

// Half a turn of one end, and pressed to a third of its length.
TEST(SolveElastic, WhatIsPulledFarStaysPositive) {
  const LabelledTetMesh m = bar(test::grid_tets(9, 3, 3, 0.2, 3));
  for (const ElasticMaterial material : kMaterials)
    for (const bool turned : {false, true}) {
      ElasticOptions o;
      o.material = material;
      o.frames = turned ? 4 : 1;
      o.held = {at(2), at(3, [=](const Place& p, double t) {
                  if (!turned) return Place(-6, 0, 0);
                  const Place c(p[0], 1.5, 1.5);
                  return Place(Eigen::AngleAxisd(t * M_PI, Place(1, 0, 0)) * (p - c) + c - p);
                })};
      o.poisson = 0.2;
      const Result<ElasticResult> r = solve_elastic(m, o);
      if (!r) {
        EXPECT_EQ(r.error().code, ErrorCode::unsolved) << r.error().message;
        ADD_FAILURE() << static_cast<int>(material) << turned << r.error().message;
        continue;
      }
      expect_positive(m.mesh, r.value().places);
      for (const ElasticStep& s : r.value().steps) EXPECT_GT(s.least_ratio, 0);
    }
}

TEST(SolveElastic, FreeFallIsExact) {
  const LabelledTetMesh m = bar(test::grid_tets(3, 0.2, 3));
  for (const ElasticMethod method : {ElasticMethod::newton, ElasticMethod::quasi_newton})
    for (const ElasticIntegrator integrator : {ElasticIntegrator::implicit_euler, ElasticIntegrator::bdf2}) {
      ElasticOptions o;
      o.method = method;
      o.integrator = integrator;
      o.dynamic = true;
      o.time_step = 0.125;
      o.frames = 6;
      o.tolerance = 1e-13;
      o.gravity = Place(0, 0, -2);
      o.velocities = VertexMatrix::Zero(m.mesh.V.rows(), 3);
      o.velocities.col(0).setConstant(0.5);
      const Result<ElasticResult> r = solve_elastic(m, o);
      ASSERT_TRUE(r.ok()) << r.error().message;
      double z = 0, v = 0, z_before = 0, v_before = 0;  // of the integrator
      for (int k = 0; k < o.frames; ++k) {
        const bool euler = k == 0 || integrator == ElasticIntegrator::implicit_euler;
        const double h = euler ? o.time_step : 2 * o.time_step / 3;
        const double z0 = euler ? z : (4 * z - z_before) / 3, v0 = euler ? v : (4 * v - v_before) / 3;
        z_before = z, v_before = v;
        v = v0 - 2 * h;
        z = z0 + h * v;
      }
      const VertexMatrix u = r.value().places - m.mesh.V;
      EXPECT_LT((u.col(2).array() - z).abs().maxCoeff(), 1e-12);
      EXPECT_LT((u.col(0).array() - 0.375).abs().maxCoeff(), 1e-12);
      EXPECT_LT((r.value().velocities.col(2).array() - v).abs().maxCoeff(), 1e-11);
    }
}

TEST(SolveElastic, MomentumIsKeptAndEnergyDoesNotGrow) {
  const LabelledTetMesh m = bar(test::grid_tets(4, 2, 2, 0.2, 3));
  for (const ElasticMaterial material : kMaterials)
    for (const double damping : {0.0, 0.1}) {
      ElasticOptions o;
      o.material = material;
      o.dynamic = true;
      o.time_step = 0.2;
      o.tolerance = 1e-10;
      o.stiffness_damping = damping;
      o.velocities = VertexMatrix(m.mesh.V.rows(), 3);
      for (Eigen::Index v = 0; v < m.mesh.V.rows(); ++v)
        o.velocities.row(v) << 0.1 * m.mesh.V(v, 1), 0.3 * std::sin(m.mesh.V(v, 0)), 0.1;
      Result<Elastic> body = Elastic::prepare(m, o);
      ASSERT_TRUE(body.ok()) << body.error().message;
      Eigen::VectorXd mass = Eigen::VectorXd::Zero(m.mesh.V.rows());
      for (Eigen::Index t = 0; t < m.mesh.T.rows(); ++t) {
        const auto edge = [&](int k) -> Place {
          return m.mesh.V.row(m.mesh.T(t, k)) - m.mesh.V.row(m.mesh.T(t, 0));
        };
        for (int k = 0; k < 4; ++k) mass[m.mesh.T(t, k)] += edge(1).dot(edge(2).cross(edge(3))) / 24;
      }
      const Eigen::RowVector3d momentum = mass.transpose() * o.velocities;
      double before = 0.5 * (mass.asDiagonal() * o.velocities).cwiseProduct(o.velocities).sum();
      for (int k = 0; k < 30; ++k) {
        const Result<ElasticStep> s = body.value().step();
        ASSERT_TRUE(s.ok()) << s.error().message;
        EXPECT_TRUE(s.value().converged);
        const double energy = s.value().elastic_energy + s.value().kinetic_energy;
        EXPECT_LT(energy, before * (1 + 1e-9));
        before = energy;
        EXPECT_LT((mass.transpose() * body.value().velocities() - momentum).norm(), 1e-7 * momentum.norm());
      }
    }
}

TEST(SolveElastic, IsTheSameOnAnyNumberOfThreads) {
  const LabelledTetMesh m = bar(test::grid_tets(8, 4, 4, 0.2, 3));
  for (const ElasticMethod method : {ElasticMethod::newton, ElasticMethod::quasi_newton}) {
    std::vector<VertexMatrix> found;
    for (const int threads : {1, 3}) {
      ElasticOptions o;
      o.method = method;
      o.dynamic = true;
      o.frames = 3;
      o.time_step = 0.5;
      o.mass_damping = o.stiffness_damping = 0.01;
      o.gravity = Place(0, 0, -0.1);
      o.held = {at(2), at(3, [](const Place&, double t) { return Place(0.1 * t, 0, 0); })};
      RunContext context;
      context.threads = threads;
      const Result<ElasticResult> r = solve_elastic(m, o, context);
      ASSERT_TRUE(r.ok()) << r.error().message;
      found.push_back(r.value().places);
    }
    EXPECT_EQ(found[0], found[1]);
  }
}

// What was bent is let go, and is straight again.
TEST(SolveElastic, AnotherRestShape) {
  LabelledTetMesh m = bar(test::grid_tets(8, 2, 2, 0.2, 3));
  ElasticOptions o;
  o.rest = m.mesh.V;
  for (Eigen::Index v = 0; v < m.mesh.V.rows(); ++v) {
    const double a = m.mesh.V(v, 0) / 4, r = 6 - m.mesh.V(v, 2);
    m.mesh.V.row(v) << r * std::sin(a), m.mesh.V(v, 1), 4 - r * std::cos(a);
  }
  std::vector<Index> left;
  for (Index v = 0; v < o.rest.rows(); ++v)
    if (o.rest(v, 0) == 0) left.push_back(v);
  o.held = {{.label = std::nullopt, .vertices = left, .function = {}}};
  const Result<ElasticResult> r = solve_elastic(m, o);
  ASSERT_TRUE(r.ok()) << r.error().message;
  // But for where it is held: there it keeps the place of the bent one.
  EXPECT_LT(r.value().von_mises.maxCoeff(), 1e-6);
}

TEST(SolveElastic, HeldVerticesAreMovedByHand) {
  const LabelledTetMesh m = bar(test::grid_tets(4, 2, 2, 0, 3));
  ElasticOptions o;
  o.dynamic = true;
  o.held = {at(2), {.label = std::nullopt, .vertices = {4}, .function = {}}};
  Result<Elastic> body = Elastic::prepare(m, o);
  ASSERT_TRUE(body.ok()) << body.error().message;
  const Index four[] = {4}, free[] = {7};
  VertexMatrix place(1, 3);
  place << 4.5, 0.25, 0;
  ASSERT_TRUE(body.value().move_held(four, place).ok());
  EXPECT_EQ(body.value().move_held(free, place).error().code, ErrorCode::usage);
  for (int k = 0; k < 2; ++k) ASSERT_TRUE(body.value().step().ok());
  EXPECT_EQ(body.value().places().row(4), place.row(0));
  EXPECT_GT(body.value().von_mises_at_vertices()[4], 0);
  // Onto the other end: nothing can be done, and nothing changes.
  const VertexMatrix before = body.value().places();
  place << -3, 1, 1;
  ASSERT_TRUE(body.value().move_held(four, place).ok());
  const Result<ElasticStep> s = body.value().step();
  if (!s) {
    EXPECT_EQ(body.value().places(), before);
  }
}

TEST(SolveElastic, WhatCannotBeIsRefused) {
  LabelledTetMesh m = bar(test::grid_tets(2, 0, 1));
  const auto code = [&](const ElasticOptions& o) {
    const Result<ElasticResult> r = solve_elastic(m, o);
    return r.ok() ? std::optional<ErrorCode>() : r.error().code;
  };
  ElasticOptions o;
  EXPECT_EQ(code(o), ErrorCode::usage);  // nothing is held
  o.held = {at(2)};
  EXPECT_EQ(code(o), std::nullopt);
  o.held = {{.label = std::nullopt, .vertices = {0, 1, 2}, .function = {}}};
  EXPECT_EQ(code(o), ErrorCode::usage);  // on a line
  o.held = {at(77)};
  EXPECT_EQ(code(o), ErrorCode::usage);
  o.held = {{.label = std::nullopt, .vertices = {-1}, .function = {}}};
  EXPECT_EQ(code(o), ErrorCode::usage);
  o.held = {at(2, constant(std::nan(""), 0, 0))};
  EXPECT_EQ(code(o), ErrorCode::bad_input);
  o.held = {at(2)};
  o.poisson = 0.5;
  EXPECT_EQ(code(o), ErrorCode::usage);
  o.poisson = 0.3;
  o.rest = m.mesh.V.topRows(3);
  EXPECT_EQ(code(o), ErrorCode::usage);
  o.rest = -m.mesh.V;
  EXPECT_EQ(code(o), ErrorCode::bad_input);
  o.rest.resize(0, 3);
  o.tractions = {{.label = std::nullopt, .vertices = {1}, .function = constant(1, 0, 0)}};
  EXPECT_EQ(code(o), ErrorCode::usage);
  o.tractions = {};
  o.forces = {at(3, constant(1, 0, 0))};
  EXPECT_EQ(code(o), ErrorCode::usage);
  o.forces = {};
  // Held so that a tet must be flat.
  o.held = {everywhere(constant(0, 0, 0)),
            {.label = std::nullopt, .vertices = {0}, .function = constant(2, 2, 2)}};
  EXPECT_EQ(code(o), ErrorCode::unsolved);
  o.held = {at(2)};
  std::atomic<bool> cancel = true;
  RunContext context;
  context.cancel = &cancel;
  EXPECT_EQ(solve_elastic(m, o, context).error().code, ErrorCode::interrupted);
}

}  // namespace
}  // namespace overtet
