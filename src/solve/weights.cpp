#include "src/solve/weights.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <set>

#include "kernels/fem/elements.h"
#include "kernels/parallel/parallel.h"
#include "kernels/predicates/predicates.h"
#include "src/run/stopwatch.h"
#include "src/solve/bounded_qp.h"
#include "src/solve/handle_pins.h"
#include "src/solve/parts.h"

namespace overtet::solve_detail {

namespace {

Error wrong(const std::string& what) { return {ErrorCode::usage, what}; }

// The weights of all handles of one mesh.
class WeightSystem {
 public:
  WeightSystem(const TetMesh& mesh, const RunContext& context) : mesh_(mesh), context_(context) {}

  Result<SkinningWeights> solve(const HandlePins& pins) {
    SkinningWeights out;
    out.weights.setZero(mesh_.V.rows(), std::ssize(pins.cut_at));
    out.handles.resize(pins.cut_at.size());
    for (std::size_t h = 0; h < out.handles.size(); ++h) out.handles[h].cut_at = pins.cut_at[h];
    if (Status s = give(pins, out); !s) return s.error();
    {
      Stopwatch watch(out.seconds_prepare);
      if (Status s = prepare(); !s) return s.error();
      out.factor_entries = qp_->factor_entries();
    }
    {
      Stopwatch watch(out.seconds_solve);
      if (Status s = solve_all(out); !s) return s.error();
    }
    if (Status s = divide_by_sums(out); !s) return s.error();
    return out;
  }

 private:
  // What is held: the pins, and all of a component that holds one handle only.
  Status give(const HandlePins& pins, SkinningWeights& out) {
    number_.assign(static_cast<std::size_t>(mesh_.V.rows()), -1);
    const Components components = components_of(mesh_.V, mesh_.T);
    std::vector<std::set<int>> of_component(components.first_tet.size());
    std::vector<char> held(number_.size(), 0);
    for (const Pin& pin : pins.pins) {
      held[static_cast<std::size_t>(pin.vertex)] = 1;
      out.shared += pin.shared;
      for (const auto& [h, w] : pin.weights) {
        out.weights(pin.vertex, h) = w;
        ++out.handles[static_cast<std::size_t>(h)].held;
        of_component[static_cast<std::size_t>(components.of_vertex[static_cast<std::size_t>(pin.vertex)])]
            .insert(h);
      }
    }
    for (std::size_t c = 0; c < of_component.size(); ++c)
      if (of_component[c].empty())
        return wrong("No handle is in the component of tet " + std::to_string(components.first_tet[c]) +
                     " (counted from 0), so that its weights are not determined.");
    for (std::size_t v = 0; v < number_.size(); ++v) {
      const Index c = components.of_vertex[v];
      if (c < 0 || held[v]) continue;
      const std::set<int>& there = of_component[static_cast<std::size_t>(c)];
      if (there.size() == 1)
        out.weights(static_cast<Index>(v), *there.begin()) = 1;
      else
        number_[v] = free_++;
    }
    return success();
  }

  Status prepare() {
    const TetElements elements(mesh_.V, mesh_.T, 1);
    inverse_mass_ = elements.lumped_mass();
    for (double& m : inverse_mass_) m = m > 0 ? 1 / m : 0;
    using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;
    stiffness_ = elements.stiffness();
    const Matrix K = stiffness_.selfadjointView<Eigen::Lower>();
    Matrix columns(K.rows(), free_);
    columns.reserve(K.nonZeros());
    for (Eigen::Index j = 0; j < K.outerSize(); ++j) {
      const Index column = number_[static_cast<std::size_t>(j)];
      if (column < 0) continue;
      columns.startVec(column);
      for (Matrix::InnerIterator it(K, j); it; ++it) columns.insertBack(it.row(), column) = it.value();
    }
    columns.finalize();
    const Matrix product = columns.transpose() * inverse_mass_.asDiagonal() * columns;
    Result<BoundedQp> qp =
        BoundedQp::prepare(SymmetricMatrix(product.triangularView<Eigen::Lower>()), context_);
    if (!qp) return qp.error();
    qp_ = std::move(qp).value();
    return success();
  }

  // M^-1 K w.
  Eigen::VectorXd laplacian(const Eigen::VectorXd& w) const {
    return inverse_mass_.cwiseProduct(times(stiffness_, w));
  }

  Status solve_all(SkinningWeights& out) {
    const std::int64_t count = out.weights.cols();
    std::mutex mutex;
    std::vector<std::optional<Error>> errors(static_cast<std::size_t>(count));
    std::int64_t done = 0;
    parallel_tasks(count, [&](std::int64_t h) {
      if (Status s = solve_one(h, out); !s) errors[static_cast<std::size_t>(h)] = s.error();
      const std::lock_guard lock(mutex);
      ++done;
      context_.report("solve", static_cast<double>(done) / static_cast<double>(count));
    });
    for (const auto& e : errors)
      if (e) return *e;
    return success();
  }

  Status solve_one(Eigen::Index h, SkinningWeights& out) {
    Eigen::VectorXd w = out.weights.col(h);
    const Eigen::VectorXd L = laplacian(w);
    const double constant = w.dot(times(stiffness_, L)) / 2;
    const Eigen::VectorXd all = times(stiffness_, L);
    Eigen::VectorXd c(free_);
    for (std::size_t v = 0; v < number_.size(); ++v)
      if (number_[v] >= 0) c[number_[v]] = all[static_cast<Eigen::Index>(v)];
    HandleWeights& figures = out.handles[static_cast<std::size_t>(h)];
    if ((c.array() == 0).all()) return success();  // alone in its components
    Result<BoundedSolution> solved = qp_->solve(c, constant, context_);
    if (!solved) return solved.error();
    const BoundedSolution& s = solved.value();
    for (std::size_t v = 0; v < number_.size(); ++v)
      if (number_[v] >= 0) w[static_cast<Eigen::Index>(v)] = s.x[number_[v]];
    out.weights.col(h) = w;
    figures.energy = w.dot(times(stiffness_, laplacian(w))) / 2;
    figures.residual = s.residual;
    figures.interior_steps = s.interior_steps;
    figures.active_set_steps = s.active_set_steps;
    figures.end = s.end == BoundedSolution::End::exact ? WeightsEnd::exact
                  : s.end == BoundedSolution::End::gap ? WeightsEnd::gap
                                                       : WeightsEnd::stalled;
    return success();
  }

  Status divide_by_sums(SkinningWeights& out) const {
    for (Eigen::Index v = 0; v < out.weights.rows(); ++v) {
      if (number_[static_cast<std::size_t>(v)] < 0) continue;
      const double sum = out.weights.row(v).sum();
      if (!(sum > 0))
        return Error{ErrorCode::unsolved, "All weights of vertex " + std::to_string(v) +
                                              " (counted from 0) are 0; give a handle nearer to it."};
      out.least_sum = std::min(out.least_sum, sum);
      out.most_sum = std::max(out.most_sum, sum);
      out.weights.row(v) /= sum;
    }
    return success();
  }

  const TetMesh& mesh_;
  const RunContext& context_;
  std::vector<Index> number_;  // of each free vertex
  Index free_ = 0;
  SymmetricMatrix stiffness_;
  Eigen::VectorXd inverse_mass_;
  std::optional<BoundedQp> qp_;
};

}  // namespace

Result<SkinningWeights> weights(const TetMesh& mesh, const Handles& handles, const WeightOptions& options,
                                const RunContext& context) {
  if (mesh.T.rows() == 0) return Error{ErrorCode::bad_input, "The mesh has no tets."};
  if (Status s = check(mesh); !s) return s.error();
  const Result<HandlePins> pins = handle_pins(mesh, handles, options);
  if (!pins) return pins.error();
  if (auto stop = context.stop()) return *stop;
  return WeightSystem(mesh, context).solve(pins.value());
}

Result<SkinnedMesh> skinned(const TetMesh& mesh, const Eigen::MatrixXd& weights,
                            const std::vector<AffineMatrix>& transforms) {
  if (weights.rows() != mesh.V.rows() || weights.cols() != std::ssize(transforms))
    return wrong("There are weights for " + std::to_string(weights.rows()) + " vertices and " +
                 std::to_string(weights.cols()) + " handles, but " + std::to_string(mesh.V.rows()) +
                 " vertices and " + std::to_string(transforms.size()) + " transforms.");
  SkinnedMesh out;
  out.mesh = mesh;
  const auto& V = mesh.V;
  // What a map adds: exactly 0 of the identity.
  std::vector<AffineMatrix> added = transforms;
  for (AffineMatrix& a : added)
    for (int k = 0; k < 3; ++k) a(k, k) -= 1;
  for (Eigen::Index v = 0; v < V.rows(); ++v) {
    Eigen::Vector3d move = Eigen::Vector3d::Zero();
    for (std::size_t h = 0; h < added.size(); ++h)
      if (const double w = weights(v, static_cast<Eigen::Index>(h)); w != 0)
        move += w * (added[h] * V.row(v).transpose().homogeneous());
    if (!(move.array() == 0).all()) out.mesh.V.row(v) += move.transpose();
    if (!out.mesh.V.row(v).allFinite())
      return wrong("Vertex " + std::to_string(v) + " (counted from 0) would not be at a finite place.");
  }
  for (Index t = 0; t < mesh.T.rows(); ++t) {
    const auto at = [&](int k) { return out.mesh.V.row(mesh.T(t, k)).data(); };
    if (orient3d(at(0), at(1), at(2), at(3)) > 0) continue;
    if (out.flipped++ == 0) out.first_flipped = t;
  }
  return out;
}

}  // namespace overtet::solve_detail
