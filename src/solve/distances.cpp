#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "kernels/core/tet_tables.h"
#include "kernels/fem/elements.h"
#include "src/solve/distances.h"

namespace overtet {

using namespace solve_detail;

namespace {

double mean_edge(const TetMesh& mesh) {
  double sum = 0;
  for (Eigen::Index t = 0; t < mesh.T.rows(); ++t)
    for (const auto& [i, j] : kTetEdge) sum += (mesh.V.row(mesh.T(t, i)) - mesh.V.row(mesh.T(t, j))).norm();
  return mesh.T.rows() > 0 ? sum / (6 * static_cast<double>(mesh.T.rows())) : 0;
}

}  // namespace

Status DistanceOptions::validate() const {
  if (!(smoothing > 0 && smoothing <= 1e6))
    return Error{ErrorCode::usage, "The smoothing of distances must lie between 0 and 1e6."};
  return success();
}

namespace solve_detail {

HeatMethod::HeatMethod(const TetMesh& mesh)
    : elements_(mesh.V, mesh.T, 1), components_(components_of(mesh.V, mesh.T)) {}

Result<HeatMethod> HeatMethod::prepare(const TetMesh& mesh, const DistanceOptions& options,
                                       const RunContext& context) {
  if (Status s = check(mesh); !s) return s.error();
  HeatMethod x(mesh);
  x.number_.assign(static_cast<std::size_t>(mesh.V.rows()), -1);
  x.held_ = x.number_;
  std::vector<char> begun(x.components_.first_tet.size(), 0);
  for (std::size_t v = 0; v < x.number_.size(); ++v) {
    const Index component = x.components_.of_vertex[v];
    if (component < 0) continue;
    x.number_[v] = x.used_++;
    if (std::exchange(begun[static_cast<std::size_t>(component)], 1)) x.held_[v] = x.free_++;
  }
  const SymmetricMatrix K = x.elements_.stiffness();
  const double h = mean_edge(mesh);
  SymmetricMatrix heat = options.smoothing * h * h * K;
  const Eigen::VectorXd mass = x.elements_.lumped_mass();
  for (Eigen::Index v = 0; v < heat.cols(); ++v) heat.coeffRef(v, v) += mass[v];
  Result<SparseCholesky> heat_factor = factored(kept_part(heat, x.number_, x.used_), context);
  if (!heat_factor) return heat_factor.error();
  Result<SparseCholesky> potential = factored(kept_part(K, x.held_, x.free_), context);
  if (!potential) return potential.error();
  x.heat_ = std::move(heat_factor).value();
  x.potential_ = std::move(potential).value();
  return x;
}

Result<Eigen::VectorXd> HeatMethod::from(std::span<const Index> sources, const RunContext& context) const {
  const auto vertices = static_cast<Index>(number_.size());
  if (sources.empty()) return Error{ErrorCode::usage, "Distances need a source."};
  Eigen::VectorXd start = Eigen::VectorXd::Zero(used_);
  std::vector<char> reached(components_.first_tet.size(), 0);
  for (const Index v : sources) {
    if (v < 0 || v >= vertices || number_[static_cast<std::size_t>(v)] < 0)
      return Error{ErrorCode::usage, "Vertex " + std::to_string(v) + " (counted from 0) is none of a tet."};
    start[number_[static_cast<std::size_t>(v)]] = 1;
    reached[static_cast<std::size_t>(components_.of_vertex[static_cast<std::size_t>(v)])] = 1;
  }
  if (auto stop = context.stop()) return *stop;
  Result<Eigen::VectorXd> heat = solved_by(heat_, start);
  if (!heat) return heat;
  Eigen::VectorXd u = Eigen::VectorXd::Zero(vertices);
  for (Index v = 0; v < vertices; ++v)
    if (const Index n = number_[static_cast<std::size_t>(v)]; n >= 0) u[v] = heat.value()[n];
  VertexMatrix X = elements_.gradient(u);
  for (Eigen::Index t = 0; t < X.rows(); ++t) {
    const double length = X.row(t).norm();
    X.row(t) *= length > 0 ? -1 / length : 0;
  }
  if (auto stop = context.stop()) return *stop;
  const Eigen::VectorXd divergence = elements_.divergence(X);
  Eigen::VectorXd right(free_);
  for (Index v = 0; v < vertices; ++v)
    if (const Index n = held_[static_cast<std::size_t>(v)]; n >= 0) right[n] = divergence[v];
  Result<Eigen::VectorXd> potential = solved_by(potential_, right);
  if (!potential) return potential;
  Eigen::VectorXd distance = Eigen::VectorXd::Constant(vertices, std::numeric_limits<double>::infinity());
  for (Index v = 0; v < vertices; ++v) {
    const Index component = components_.of_vertex[static_cast<std::size_t>(v)];
    if (component < 0 || !reached[static_cast<std::size_t>(component)]) continue;
    const Index n = held_[static_cast<std::size_t>(v)];
    distance[v] = n >= 0 ? potential.value()[n] : 0;
  }
  // 0 at the sources: on the average, as each of them is only nearly as far from the others as the method
  // says.
  std::vector<double> offset(components_.first_tet.size(), 0), count(offset.size(), 0);
  for (const Index v : sources) {
    const auto c = static_cast<std::size_t>(components_.of_vertex[static_cast<std::size_t>(v)]);
    offset[c] += distance[v], ++count[c];
  }
  for (Index v = 0; v < vertices; ++v)
    if (std::isfinite(distance[v])) {
      const auto c = static_cast<std::size_t>(components_.of_vertex[static_cast<std::size_t>(v)]);
      distance[v] = std::max(distance[v] - offset[c] / count[c], 0.0);
    }
  for (const Index v : sources) distance[v] = 0;
  return distance;
}

}  // namespace solve_detail

}  // namespace overtet
