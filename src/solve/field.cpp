#include "src/solve/field.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

#include "kernels/fem/elements.h"
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

  Result<Field> solve() {
    const auto begin = Clock::now();
    if (Status s = give_values(); !s) return s.error();
    if (Status s = every_component_has_one(); !s) return s.error();
    load_ = Eigen::VectorXd::Zero(elements_.nodes());
    if (Status s = add_source(); !s) return s.error();
    stiffness_ = elements_.stiffness();
    Field field;
    field.seconds_assembly = since(begin);
    Status done = options_.equation == FieldEquation::biharmonic ? solve_fourth_order(field)
                                                                 : solve_second_order(field);
    if (!done) return done.error();
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
    load_ = times(elements_.mass(), f);
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

  // Numbers of the nodes that are to be found; those of no tet are none.
  std::vector<Index> free_nodes(Index& count) const {
    std::vector<char> used(static_cast<std::size_t>(elements_.nodes()), 0);
    for (Index t = 0; t < elements_.tets(); ++t)
      for (int k = 0; k < elements_.nodes_each(); ++k)
        used[static_cast<std::size_t>(elements_.node(t, k))] = 1;
    std::vector<Index> number(used.size(), -1);
    count = 0;
    for (std::size_t v = 0; v < number.size(); ++v)
      if (used[v] && !given_[v]) number[v] = count++;
    return number;
  }

  // Solves A x = b for the free nodes; the others have their values. b: of the free nodes, those moved over
  // already.
  Status solve_free(const SymmetricMatrix& A, const Eigen::VectorXd& b, const std::vector<Index>& number,
                    Field& field) {
    auto begin = Clock::now();
    Result<SparseCholesky> factor = factored(A, context_);
    if (!factor) return factor.error();
    field.factor_entries = factor.value().factor_entries();
    field.seconds_factor = since(begin);
    begin = Clock::now();
    VertexMatrix right = VertexMatrix::Zero(b.size(), 3), left;
    right.col(0) = b;
    if (b.size() > 0 && !factor.value().solve(right, left))
      return Error{ErrorCode::limit, "There is not enough memory to solve this system."};
    field.values = values_;
    if (b.size() > 0) {
      const Eigen::VectorXd x = left.col(0);
      for (std::size_t v = 0; v < number.size(); ++v)
        if (number[v] >= 0) field.values[static_cast<Eigen::Index>(v)] = x[number[v]];
      const double size = b.norm();
      field.residual = (times(A, x) - b).norm() / (size > 0 ? size : 1);
    }
    field.seconds_solve = since(begin);
    return success();
  }

  Eigen::VectorXd of_free(const Eigen::VectorXd& all, const std::vector<Index>& number, Index count) const {
    Eigen::VectorXd out(count);
    for (std::size_t v = 0; v < number.size(); ++v)
      if (number[v] >= 0) out[number[v]] = all[static_cast<Eigen::Index>(v)];
    return out;
  }

  Status solve_second_order(Field& field) {
    if (Status s = add_fluxes(load_); !s) return s;
    Index count = 0;
    const std::vector<Index> number = free_nodes(count);
    const Eigen::VectorXd right = load_ - times(stiffness_, values_);
    return solve_free(kept_part(stiffness_, number, count), of_free(right, number, count), number, field);
  }

  // M v = K u - (fluxes), K v = M f where u is free [for instance Ciarlet and Raviart 1974], v eliminated.
  Status solve_fourth_order(Field& field) {
    Eigen::VectorXd fluxes = Eigen::VectorXd::Zero(elements_.nodes());
    if (Status s = add_fluxes(fluxes); !s) return s;
    Index count = 0;
    const std::vector<Index> number = free_nodes(count);
    Eigen::VectorXd inverse = elements_.lumped_mass();
    for (double& m : inverse) m = m > 0 ? 1 / m : 0;
    using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;
    const Matrix K = stiffness_.selfadjointView<Eigen::Lower>();
    Matrix columns(K.rows(), count);  // of the free nodes
    columns.reserve(K.nonZeros());
    for (Eigen::Index j = 0; j < K.outerSize(); ++j) {
      const Index column = number[static_cast<std::size_t>(j)];
      if (column < 0) continue;
      columns.startVec(column);
      for (Matrix::InnerIterator it(K, j); it; ++it) columns.insertBack(it.row(), column) = it.value();
    }
    columns.finalize();
    const Matrix product = columns.transpose() * inverse.asDiagonal() * columns;
    const SymmetricMatrix A = product.triangularView<Eigen::Lower>();
    const Eigen::VectorXd known = times(stiffness_, values_) - fluxes;
    const Eigen::VectorXd right =
        of_free(load_, number, count) - columns.transpose() * (inverse.asDiagonal() * known);
    return solve_free(A, right, number, field);
  }

  const LabelledTetMesh& mesh_;
  const FieldOptions& options_;
  const RunContext& context_;
  const TetElements elements_;
  SymmetricMatrix stiffness_;
  std::vector<char> given_;  // by node
  Eigen::VectorXd values_;   // 0 where none is given
  Eigen::VectorXd load_;
};

}  // namespace

Status FieldOptions::validate() const {
  const auto wrong = [](const char* what) { return Error{ErrorCode::usage, what}; };
  if (order != 1 && order != 2) return wrong("Elements are of order 1 or 2.");
  if (equation == FieldEquation::biharmonic && order == 2)
    return wrong("The biharmonic equation is solved with elements of order 1.");
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
  if (Status s = check(mesh.mesh); !s) return s.error();
  return FieldSystem(mesh, options, context).solve();
}

}  // namespace solve_detail

}  // namespace overtet
