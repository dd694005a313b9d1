#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <utility>

#include "kernels/core/tet_tables.h"
#include "kernels/fem/elements.h"
#include "src/mesh/tet_complex.h"
#include "src/solve/distances.h"
#include "src/solve/tuning.h"

namespace overtet {

using namespace solve_detail;

namespace {

// By volume: of a mesh that is fine at its surface, edges inside are what heat has to get along.
double mean_edge(const TetElements& elements, const TetMesh& mesh) {
  double sum = 0, volume = 0;
  for (Index t = 0; t < elements.tets(); ++t) {
    const double part = elements.shape(t).volume;
    volume += part;
    for (const auto& [i, j] : kTetEdge)
      sum += part / 6 * (mesh.V.row(mesh.T(t, i)) - mesh.V.row(mesh.T(t, j))).norm();
  }
  return volume > 0 ? sum / volume : 0;
}

// Heat falls by exp(-distance / sqrt(time)), so that on the boundary its derivative is -cos/sqrt(time) of it,
// with the angle between the way and the normal, which nobody knows: 1 where ways end head-on, 0 where they
// run along. Between no flux (for which ways run along) and no heat (head-on), which [Crane, Weischedel,
// Wardetzky 2013, section 3.4] average, this is a half: by vertex half the area that it has on the boundary.
Eigen::VectorXd lost_heat(const TetMesh& mesh) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(mesh.V.rows());
  for (const auto& [a, b, c] : TetComplex(mesh.V, mesh.T).boundary()) {
    const Eigen::Vector3d p = mesh.V.row(a), q = mesh.V.row(b), r = mesh.V.row(c);
    const double area = (q - p).cross(r - p).norm() / 2;
    for (const Index v : {a, b, c}) out[v] += area / 6;
  }
  return out;
}

}  // namespace

Status DistanceOptions::validate() const {
  if (!(smoothing >= kLeastSmoothing && smoothing <= 1e6))
    return Error{ErrorCode::usage, "The smoothing of distances must lie between 0.5 and 1e6."};
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
  const double h = mean_edge(x.elements_, mesh);
  SymmetricMatrix heat = options.smoothing * h * h * K;
  const Eigen::VectorXd mass = x.elements_.lumped_mass() + std::sqrt(options.smoothing) * h * lost_heat(mesh);
  for (Eigen::Index v = 0; v < heat.cols(); ++v) heat.coeffRef(v, v) += mass[v];
  Result<SparseCholesky> heat_factor = factored(kept_part(heat, x.number_, x.used_), context);
  if (!heat_factor) return heat_factor.error();
  Result<SparseCholesky> potential = factored(kept_part(K, x.held_, x.free_), context);
  if (!potential) return potential.error();
  x.heat_ = std::move(heat_factor).value();
  x.potential_ = std::move(potential).value();
  return x;
}

// The potential whose gradient points where that of u does and has length 1: by vertex; 0 where it is held.
Result<Eigen::VectorXd> HeatMethod::with_directions_of(const Eigen::VectorXd& u) const {
  VertexMatrix X = elements_.gradient(u);
  for (Eigen::Index t = 0; t < X.rows(); ++t) {
    const double length = X.row(t).norm();
    X.row(t) *= length > 0 ? 1 / length : 0;
  }
  const Eigen::VectorXd divergence = elements_.divergence(X);
  Eigen::VectorXd right(free_);
  for (std::size_t v = 0; v < held_.size(); ++v)
    if (held_[v] >= 0) right[held_[v]] = divergence[static_cast<Eigen::Index>(v)];
  const Result<Eigen::VectorXd> potential = solved_by(potential_, right);
  if (!potential) return potential;
  Eigen::VectorXd out = Eigen::VectorXd::Zero(std::ssize(held_));
  for (std::size_t v = 0; v < held_.size(); ++v)
    if (held_[v] >= 0) out[static_cast<Eigen::Index>(v)] = potential.value()[held_[v]];
  return out;
}

// 0 at the sources, at their neighbours the length of the shortest edge to one, infinity elsewhere.
Eigen::VectorXd HeatMethod::along_first_edges(std::span<const Index> sources) const {
  const std::set<Index> from(sources.begin(), sources.end());
  Eigen::VectorXd out =
      Eigen::VectorXd::Constant(std::ssize(number_), std::numeric_limits<double>::infinity());
  for (const Index v : from) out[v] = 0;
  for (Index t = 0; t < elements_.tets(); ++t)
    for (int i = 0; i < 4; ++i) {
      const Index v = elements_.node(t, i);
      if (out[v] != 0 || !from.contains(v)) continue;
      for (int j = 0; j < 4; ++j) {
        const Index w = elements_.node(t, j);
        out[w] = std::min(out[w], (elements_.places().row(v) - elements_.places().row(w)).norm());
      }
    }
  return out;
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
  // Twice: the potential's gradient has smoother directions than the heat's, whose noise makes lengths too
  // small.
  u = -u;
  for (int round = 0; round < 2; ++round) {
    if (auto stop = context.stop()) return *stop;
    const Result<Eigen::VectorXd> potential = with_directions_of(u);
    if (!potential) return potential.error();
    u = potential.value();
  }
  Eigen::VectorXd distance = Eigen::VectorXd::Constant(vertices, std::numeric_limits<double>::infinity());
  for (Index v = 0; v < vertices; ++v) {
    const Index component = components_.of_vertex[static_cast<std::size_t>(v)];
    if (component < 0 || !reached[static_cast<std::size_t>(component)]) continue;
    distance[v] = u[v];
  }
  // Right at the sources' neighbours, whose distances are known, on the average: where all ways end in one
  // vertex the potential is blunt. Where there are none, at the sources.
  const Eigen::VectorXd near = along_first_edges(sources);
  std::vector<double> offset(components_.first_tet.size(), 0), count(offset.size(), 0);
  for (const bool neighbours : {true, false})
    for (Index v = 0; v < vertices; ++v) {
      if (!std::isfinite(near[v]) || (near[v] > 0) != neighbours) continue;
      const auto c = static_cast<std::size_t>(components_.of_vertex[static_cast<std::size_t>(v)]);
      if (!neighbours && count[c] > 0) continue;
      offset[c] += distance[v] - near[v], ++count[c];
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
