#include "src/solve/field.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

#include "kernels/fem/elements.h"
#include "kernels/sparse/rows.h"
#include "src/solve/linear_system.h"
#include "src/solve/parts.h"

namespace overtet {

namespace {

using namespace solve_detail;
using Clock = std::chrono::steady_clock;

double since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

// The equations of one field, from the options to the solution.
class FieldSystem {
 public:
  FieldSystem(const LabelledTetMesh& mesh, const FieldOptions& options, const RunContext& context)
      : mesh_(mesh),
        options_(options),
        context_(context),
        elements_(mesh.mesh.V, mesh.mesh.T, options.order) {}

  // begin: when the work on the elements began.
  Result<Field> solve(Clock::time_point begin) {
    if (Status s = give_values(); !s) return s.error();
    if (Status s = every_component_has_one(); !s) return s.error();
    load_ = Eigen::VectorXd::Zero(elements_.nodes());
    if (Status s = add_source(); !s) return s.error();
    find_free_nodes();
    Result<LinearSystem> system =
        options_.equation == FieldEquation::biharmonic ? fourth_order() : second_order();
    if (!system) return system.error();
    Field field;
    field.seconds_assembly = since(begin);
    Result<LinearSolution> solution = solved(
        system.value(),
        options_.equation == FieldEquation::biharmonic ? LinearSolver::direct : options_.solver, context_);
    if (!solution) return solution.error();
    LinearSolution& found = solution.value();
    field.values = values_;
    for (std::size_t v = 0; v < number_.size(); ++v)
      if (number_[v] >= 0) field.values[static_cast<Eigen::Index>(v)] = found.x[number_[v]];
    field.solver = found.solver;
    field.iterations = found.iterations;
    field.residual = found.residual;
    field.factor_entries = found.factor_entries;
    field.seconds_factor = found.seconds_factor;
    field.seconds_solve = found.seconds_solve;
    field.nodes = elements_.places();
    field.energy = elements_.energy(field.values).sum();
    return field;
  }

 private:
  // The nodes of triangle f: corners, then the middles of edges 01, 02, 12.
  std::vector<Index> nodes_of(Eigen::Index f) const {
    const TriangleMatrix& F = mesh_.attributes.triangles;
    std::vector<Index> nodes{F(f, 0), F(f, 1), F(f, 2)};
    if (options_.order == 2)
      for (const auto& [i, j] : {std::pair{0, 1}, {0, 2}, {1, 2}})
        nodes.push_back(elements_.middle(F(f, i), F(f, j)));
    return nodes;
  }

  // Calls f(triangle) for those that a condition is given for.
  template <class F>
  Status each_triangle(const BoundaryValue& given, F&& f) const {
    const Result<std::vector<Index>> triangles = triangles_with(mesh_, given.label);
    if (!triangles) return triangles.error();
    for (const Index i : triangles.value())
      if (Status s = f(i); !s) return s;
    return success();
  }

  Status give_values() {
    given_.assign(static_cast<std::size_t>(elements_.nodes()), 0);
    values_ = Eigen::VectorXd::Zero(elements_.nodes());
    for (const BoundaryValue& b : options_.values) {
      const auto give = [&](Index node) -> Status {
        const Eigen::Vector3d p = elements_.places().row(node);
        values_[node] = b.function(p);
        given_[static_cast<std::size_t>(node)] = 1;
        return std::isfinite(values_[node]) ? success() : Status(not_finite("given value", p));
      };
      for (const Index v : b.vertices) {
        if (v < 0 || v >= mesh_.mesh.V.rows())
          return Error{ErrorCode::usage, "Vertex " + std::to_string(v) + " (counted from 0) does not exist."};
        if (Status s = give(v); !s) return s;
      }
      if (!b.vertices.empty() && !b.label) continue;
      const Status s = each_triangle(b, [&](Eigen::Index f) -> Status {
        for (const Index node : nodes_of(f))
          if (Status given = give(node); !given) return given;
        return success();
      });
      if (!s) return s;
    }
    return success();
  }

  Status every_component_has_one() const {
    const Components components = components_of(mesh_.mesh.V, mesh_.mesh.T);
    std::vector<char> has(components.first_tet.size(), 0);
    for (std::size_t v = 0; v < components.of_vertex.size(); ++v)
      if (given_[v] && components.of_vertex[v] >= 0)
        has[static_cast<std::size_t>(components.of_vertex[v])] = 1;
    const auto bare = std::find(has.begin(), has.end(), 0);
    if (bare == has.end()) return success();
    return Error{ErrorCode::usage,
                 "No value is given in the component of tet " +
                     std::to_string(components.first_tet[static_cast<std::size_t>(bare - has.begin())]) +
                     " (counted from 0), so that the field there is not determined."};
  }

  Status add_source() {
    if (!options_.source) return success();
    Eigen::VectorXd f(elements_.nodes());
    for (Index v = 0; v < elements_.nodes(); ++v) {
      const Eigen::Vector3d p = elements_.places().row(v);
      f[v] = options_.source(p);
      if (!std::isfinite(f[v])) return not_finite("source", p);
    }
    load_ = elements_.mass_times(f);
    return success();
  }

  // The integrals of the fluxes with the shape functions.
  Status add_fluxes(Eigen::VectorXd& to) const {
    const Eigen::MatrixXd reference = reference_mass(2, options_.order);
    const VertexMatrix& V = mesh_.mesh.V;
    const TriangleMatrix& F = mesh_.attributes.triangles;
    for (const BoundaryValue& b : options_.fluxes) {
      const Status s = each_triangle(b, [&](Eigen::Index f) -> Status {
        const Eigen::Vector3d p = V.row(F(f, 0)), q = V.row(F(f, 1)), r = V.row(F(f, 2));
        const double area = (q - p).cross(r - p).norm() / 2;
        const std::vector<Index> nodes = nodes_of(f);
        Eigen::VectorXd flux(std::ssize(nodes));
        for (std::size_t k = 0; k < nodes.size(); ++k) {
          const Eigen::Vector3d place = elements_.places().row(nodes[k]);
          flux[static_cast<Eigen::Index>(k)] = b.function(place);
          if (!std::isfinite(flux[static_cast<Eigen::Index>(k)])) return not_finite("given flux", place);
        }
        const Eigen::VectorXd part = area * (reference * flux);
        for (std::size_t k = 0; k < nodes.size(); ++k) to[nodes[k]] += part[static_cast<Eigen::Index>(k)];
        return success();
      });
      if (!s) return s;
    }
    return success();
  }

  // Numbers of the nodes that are to be found, in the order of the tets; those of no tet are none.
  void find_free_nodes() {
    number_.assign(static_cast<std::size_t>(elements_.nodes()), -1);
    for (Index k = 0; k < elements_.used(); ++k)
      if (const auto v = static_cast<std::size_t>(elements_.sequence()[static_cast<std::size_t>(k)]);
          !given_[v])
        number_[v] = count_++;
  }

  Eigen::VectorXd of_free(const Eigen::VectorXd& all) const {
    Eigen::VectorXd out(count_);
    for (std::size_t v = 0; v < number_.size(); ++v)
      if (number_[v] >= 0) out[number_[v]] = all[static_cast<Eigen::Index>(v)];
    return out;
  }

  // Of the free nodes: K u = (source and fluxes).
  Result<LinearSystem> second_order() {
    if (Status s = add_fluxes(load_); !s) return s.error();
    LinearSystem out;
    out.A = elements_.stiffness(number_, count_);
    out.b = of_free(load_ - elements_.stiffness_times(values_));
    if (options_.order == 2) out.coarser = linear_elements();
    return out;
  }

  // A linear function is a quadratic one with the mean of its ends in the middle of an edge.
  LinearSystem::Coarser linear_elements() const {
    const auto vertices = static_cast<std::size_t>(mesh_.mesh.V.rows());
    std::vector<Index> number(vertices, -1), node_of(static_cast<std::size_t>(count_));
    Index count = 0;
    for (const Index v : elements_.sequence()) {
      if (number_[static_cast<std::size_t>(v)] < 0) continue;
      node_of[static_cast<std::size_t>(number_[static_cast<std::size_t>(v)])] = v;
      if (static_cast<std::size_t>(v) < vertices) number[static_cast<std::size_t>(v)] = count++;
    }
    LinearSystem::Coarser out;
    out.A = elements_.linear_stiffness(number, count);
    out.prolongation = matrix_of_rows<RowMatrix>(count_, count, [&](Index row, RowSums& sums) {
      const auto v = static_cast<std::size_t>(node_of[static_cast<std::size_t>(row)]);
      if (v < vertices) {
        sums.add(number[v], 1);
        return;
      }
      for (const Index end : elements_.ends(static_cast<Index>(v)))
        if (const Index n = number[static_cast<std::size_t>(end)]; n >= 0) sums.add(n, 0.5);
    });
    return out;
  }

  // M v = K u - (fluxes), K v = M f where u is free [for instance Ciarlet and Raviart 1974], v eliminated.
  Result<LinearSystem> fourth_order() const {
    Eigen::VectorXd fluxes = Eigen::VectorXd::Zero(elements_.nodes());
    if (Status s = add_fluxes(fluxes); !s) return s.error();
    Eigen::VectorXd inverse = elements_.lumped_mass();
    for (double& m : inverse) m = m > 0 ? 1 / m : 0;
    using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;
    const SymmetricMatrix stiffness = elements_.stiffness();
    const Matrix K = stiffness.selfadjointView<Eigen::Lower>();
    Matrix columns(K.rows(), count_);  // of the free nodes
    columns.reserve(K.nonZeros());
    for (const Index j : elements_.sequence()) {
      const Index column = number_[static_cast<std::size_t>(j)];
      if (column < 0) continue;
      columns.startVec(column);
      for (Matrix::InnerIterator it(K, j); it; ++it) columns.insertBack(it.row(), column) = it.value();
    }
    columns.finalize();
    const Matrix product = columns.transpose() * inverse.asDiagonal() * columns;
    const Eigen::VectorXd known = elements_.stiffness_times(values_) - fluxes;
    LinearSystem out;
    out.A = product.triangularView<Eigen::Lower>();
    out.b = of_free(load_) - columns.transpose() * (inverse.asDiagonal() * known);
    return out;
  }

  const LabelledTetMesh& mesh_;
  const FieldOptions& options_;
  const RunContext& context_;
  const TetElements elements_;
  std::vector<char> given_;  // by node
  Eigen::VectorXd values_;   // 0 where none is given
  Eigen::VectorXd load_;
  std::vector<Index> number_;  // of the free nodes, -1: of others
  Index count_ = 0;            // of free nodes
};

}  // namespace

Status FieldOptions::validate() const {
  const auto wrong = [](const char* what) { return Error{ErrorCode::usage, what}; };
  if (order != 1 && order != 2) return wrong("Elements are of order 1 or 2.");
  if (equation == FieldEquation::biharmonic && order == 2)
    return wrong("The biharmonic equation is solved with elements of order 1.");
  if (equation == FieldEquation::biharmonic && solver == LinearSolver::iterative)
    return wrong("The biharmonic equation is solved directly.");
  if (equation == FieldEquation::laplace && source)
    return wrong("Laplace's equation has no source; with one it is Poisson's.");
  if (values.empty()) return wrong("No value is given anywhere, so that the field is not determined.");
  for (const auto* list : {&values, &fluxes})
    for (const BoundaryValue& b : *list)
      if (!b.function) return wrong("A boundary value has no function.");
  for (const BoundaryValue& b : fluxes)
    if (!b.vertices.empty()) return wrong("Fluxes are given on triangles, not at vertices.");
  return success();
}

namespace solve_detail {

Result<Field> field(const LabelledTetMesh& mesh, const FieldOptions& options, const RunContext& context) {
  const auto begin = Clock::now();
  if (Status s = check(mesh.mesh); !s) return s.error();
  return FieldSystem(mesh, options, context).solve(begin);
}

}  // namespace solve_detail

}  // namespace overtet
