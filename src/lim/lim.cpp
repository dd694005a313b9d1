#include "src/lim/lim.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>

#include "kernels/core/box.h"
#include "kernels/core/indices.h"
#include "kernels/core/tuning.h"
#include "kernels/parallel/parallel.h"
#include "src/cdt/tetgen.h"
#include "src/lim/newton.h"
#include "src/mesh/local_operations.h"
#include "src/mesh/tet_complex.h"

namespace overtet {

namespace {

using lim_detail::Newton;

// One map on its way.
class Mapper {
 public:
  Mapper(const TetMesh& mesh, const VertexMatrix& target, const LimOptions& options,
         const RunContext& context)
      : target_(target),
        options_(options),
        context_(context),
        begin_(RunContext::Clock::now()),
        unit_(diagonal_of(target)) {
    result_.mesh = mesh;
  }

  Result<LimResult> run() {
    if (jump()) return finished(LimResult::End::reached);
    restart();
    for (;;) {
      if (const auto stop = context_.stop()) return *stop;
      if (seconds() > options_.seconds) return finished(LimResult::End::time);
      if (static_cast<int>(result_.iterations.size()) >= options_.iterations)
        return finished(LimResult::End::iterations);
      bool ok = true;
      const double made = iterate(ok);
      if (!ok)
        return Error{ErrorCode::limit,
                     "There is not enough memory for a factorisation of the volumetric map."};
      result_.mesh.V = newton_->positions();
      if (jump()) return finished(LimResult::End::reached);
      if (made > 0 && gets_on() && !remesh_due()) continue;
      const Result<bool> remeshed = remesh();
      if (!remeshed) return remeshed.error();
      if (!remeshed.value()) return finished(LimResult::End::stalled);
    }
  }

 private:
  double seconds() const { return std::chrono::duration<double>(RunContext::Clock::now() - begin_).count(); }

  // The present state is the rest state from now on.
  void restart() {
    newton_ = std::make_unique<Newton>(result_.mesh, target_, options_.barrier, unit_);
    alpha_ = 1;
    since_restart_ = waited_ = 0;
    nearest_ = HUGE_VAL;
  }

  // One Newton step; the part of it that was made.
  double iterate(bool& ok) {
    const Newton::Energies e = newton_->energies();
    // As heavy as the rest is, times the ratio; never lighter than before.
    if (e.distance > 0)
      alpha_ = std::min(std::max(alpha_, options_.alpha_ratio * (e.strain + e.barrier) / e.distance),
                        options_.largest_alpha);
    const double made = newton_->step(alpha_, ok);
    const Newton::Energies after = newton_->energies();
    distance_ = std::sqrt(after.distance / static_cast<double>(target_.rows()));
    result_.iterations.push_back({after.all(alpha_), alpha_, distance_, made});
    ++since_restart_;
    char text[96];
    std::snprintf(text, sizeof text,
                  "%.3g of the diagonal from home, alpha %.3g, step %.3g, energy %.4g + %.4g", distance_,
                  alpha_, made, after.strain, after.barrier);
    context_.report("lim", static_cast<double>(result_.iterations.size()) / options_.iterations, text);
    context_.note(LogLevel::debug, std::string("lim: ") + text);
    return made;
  }

  bool gets_on() {
    if (distance_ < (1 - options_.progress) * nearest_) {
      nearest_ = distance_;
      waited_ = 0;
      return true;
    }
    return ++waited_ < options_.patience;
  }

  bool remesh_due() const { return options_.remesh_every > 0 && since_restart_ >= options_.remesh_every; }

  // False: not any more, or it cannot be done.
  Result<bool> remesh() {
    if (options_.remesh_every == 0 || static_cast<int>(result_.remeshes.size()) >= options_.remeshes)
      return false;
    Result<TetMesh> made = coarsen_and_refine(result_.mesh, options_.radius_edge, context_);
    if (!made) {
      if (made.error().code != ErrorCode::unsolved) return made.error();
      context_.note(LogLevel::warning,
                    "The tets could not be coarsened and refined: " + made.error().message);
      return false;
    }
    result_.remeshes.push_back({static_cast<int>(result_.iterations.size()),
                                static_cast<Index>(result_.mesh.T.rows()),
                                static_cast<Index>(made.value().T.rows())});
    result_.mesh = std::move(made).value();
    restart();
    return true;
  }

  // Home, if every tet is positive then.
  bool jump() {
    VertexMatrix X = result_.mesh.V;
    X.topRows(target_.rows()) = target_;
    std::swap(X, result_.mesh.V);
    const bool fine = first_not_positive(result_.mesh) < 0;
    std::swap(X, result_.mesh.V);
    if (!fine) return false;
    // Vertex by vertex no edge gains a turn. Where one is in another's way, all go at once.
    const std::vector<Index> left = go_home_one_by_one();
    result_.jumped = !left.empty();
    if (result_.jumped) result_.mesh.V.topRows(target_.rows()) = target_;
    return true;
  }

  // Returns who cannot.
  std::vector<Index> go_home_one_by_one() {
    TetComplex mesh(result_.mesh.V, result_.mesh.T);
    LocalOperations work(mesh);
    std::vector<Index> left;
    for (Index v = 0; v < target_.rows(); ++v)
      if (mesh.position(v) != Eigen::Vector3d(target_.row(v))) left.push_back(v);
    for (bool any = true; any && !left.empty();) {
      const auto gone = [&](Index v) { return work.place(v, target_.row(v)); };
      any = std::erase_if(left, gone) > 0;
    }
    for (Index v = 0; v < target_.rows(); ++v) result_.mesh.V.row(v) = mesh.position(v);
    return left;
  }

  Result<LimResult> finished(LimResult::End end) {
    result_.end = end;
    if (end != LimResult::End::reached) result_.away = go_home_one_by_one();
    return std::move(result_);
  }

  const VertexMatrix& target_;
  const LimOptions& options_;
  const RunContext& context_;
  RunContext::Clock::time_point begin_;
  double unit_;
  LimResult result_;
  std::unique_ptr<Newton> newton_;
  double alpha_ = 1, distance_ = 0, nearest_ = HUGE_VAL;
  int since_restart_ = 0, waited_ = 0;
};

}  // namespace

Status LimOptions::validate() const {
  const auto positive = [](double x) { return std::isfinite(x) && x > 0; };
  const auto bad = [](const char* what) {
    return Error{ErrorCode::usage, std::string("Locally injective mapping: ") + what};
  };
  if (!positive(alpha_ratio) || !positive(largest_alpha) || !positive(barrier))
    return bad("the weights must be positive.");
  if (iterations < 1 || remesh_every < 0 || remeshes < 0 || patience < 1)
    return bad("counts must not be negative.");
  if (!(progress >= 0 && progress < 1) || !(seconds > 0) || !(radius_edge >= 1.1))
    return bad("progress must be in [0, 1), seconds positive, radius_edge at least 1.1.");
  return success();
}

Result<LimResult> lim(const TetMesh& mesh, const VertexMatrix& target, const LimOptions& options,
                      const RunContext& context) {
  if (const Status valid = options.validate(); !valid) return valid.error();
  if (target.rows() != mesh.surface_vertices || mesh.V.rows() < target.rows() || !target.allFinite() ||
      !mesh.V.allFinite() || !all_below(mesh.T, mesh.V.rows()) || first_not_positive(mesh) >= 0)
    return Error{ErrorCode::bad_input,
                 "Locally injective mapping: the tet mesh is not positive or does not fit the surface."};
  const ScopedThreads threads(context.threads);
  return Mapper(mesh, target, options, context).run();
}

}  // namespace overtet
