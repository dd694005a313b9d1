#include "src/pipeline/flow_route.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kernels/core/tuning.h"
#include "src/pipeline/flow_stages.h"
#include "src/pipeline/patch_meshing.h"

namespace overtet {

namespace {

// A mesh, or an error after which nothing else is tried; none: on to the next way.
using Outcome = std::optional<Result<Draft>>;

class FlowRoute {
 public:
  explicit FlowRoute(const MeshingJob& job) : job_(job) {}

  Result<Draft> run() {
    if (const auto saved = saved_fill(job_)) {
      if (!*saved) return saved->error();
      return home_from_saved(saved->value());
    }
    const std::vector<ForwardFlowOptions> forward_ladder = forward_flow_ladder();
    const std::vector<ReverseFlowOptions> reverse_ladder = reverse_flow_ladder();
    const std::size_t rungs = std::min(forward_ladder.size(), reverse_ladder.size());
    for (std::size_t rung = 0; rung < rungs; ++rung) {
      const bool is_last = rung + 1 == rungs;
      if (Outcome end = embed(forward_ladder[rung], reverse_ladder[rung])) return *std::move(end);
      if (!best_ || best_is_pulled_ || (best_->locked && !is_last)) continue;
      if (Outcome end = pull_best()) return *std::move(end);
    }
    // Only one embedding was worth pulling, and it locked before the ladder's end.
    if (locked_once_.T.rows() > 0)
      if (Outcome end = outcome(without_placed(map(job_, locked_once_, MapCare::careful)), "Volume map"))
        return *std::move(end);
    return last_;
  }

 private:
  bool by_patch() const { return job_.flow_map == FlowMap::patch; }

  Outcome outcome(Result<Draft> result, const char* stage) {
    if (result || ends_run(result.error())) return result;
    note(stage, result.error());
    return std::nullopt;
  }

  void note(const char* stage, const Error& e) {
    last_ = {ErrorCode::unsolved, std::string(stage) + ": " + e.message, e.place};
  }

  // By the patch where that is asked for, then by the pull, and where that locks, by it in another way.
  Result<Draft> home_from_saved(const TetMesh& mesh) {
    if (by_patch())
      if (Outcome end = outcome(mesh_by_patch(job_, mesh), "Patch")) return *std::move(end);
    Result<TetMesh> mapped = map(job_, mesh, MapCare::usual);
    if (!mapped && mapped.error().code == ErrorCode::unsolved) {
      Result<TetMesh> again = map(job_, mesh, MapCare::careful);
      if (again || again.error().code != ErrorCode::unsolved) mapped = std::move(again);
    }
    return without_placed(std::move(mapped));
  }

  // The mesh of an embedding brought home by the patch; an error is noted.
  Outcome patch(const MeshingJob& job, const VertexMatrix& U, const TetMeshOptions& options,
                std::optional<TetMesh>& filled) {
    Result<TetMesh> mesh = fill(job, U, options);
    if (!mesh) return outcome(mesh.error(), "Tet mesh");
    filled = std::move(mesh).value();
    return outcome(mesh_by_patch(job_, *filled), "Patch");
  }

  // Both flows, and the patch of what each ends with: it needs an embedding that is V0 nearly everywhere, no
  // good one. Keeps the better U0.
  Outcome embed(const ForwardFlowOptions& there, const ReverseFlowOptions& back) {
    Result<ForwardFlowResult> forward = flow_forward(job_, there);
    if (!forward) return outcome(forward.error(), "Forward flow");
    const auto saved = [&](const char* name, const VertexMatrix& V) {
      return keep(job_, name, Surface{V, job_.surface.F});
    };
    if (Status s = saved("flow_end", forward.value().V); !s) return Result<Draft>(s.error());
    if (by_patch()) {
      // Not saved: the pull, which needs a good U0, could not go on from there.
      MeshingJob unsaved = job_;
      unsaved.save = nullptr;
      // Where a hundredth of the faces has shrunk to nothing, TetGen may take minutes for quality tets
      // (measured: 50 times longer), which are a luxury here; without them meshes are twice as large.
      TetMeshOptions options;
      options.quality =
          measure_quality(forward.value().V, job_.surface.V, job_.surface.F).area_p01 >= kPrecise;
      std::optional<TetMesh> filled;
      if (Outcome end = patch(unsaved, forward.value().V, options, filled)) return end;
    }
    Result<ReverseFlowResult> returned = flow_back(job_, forward.value(), back);
    if (!returned) return outcome(returned.error(), "Reverse flow");
    ReverseFlowResult& x = returned.value();
    if (best_ && x.quality.area_p01 <= best_->quality.area_p01) return std::nullopt;
    best_ = std::move(x);
    filled_.reset();
    if (Status s = saved("embedded", best_->U0); !s) return Result<Draft>(s.error());
    best_is_pulled_ = false;
    return by_patch() ? patch(job_, best_->U0, {}, filled_) : std::nullopt;
  }

  Outcome pull_best() {
    best_is_pulled_ = true;
    if (!filled_) {
      Result<TetMesh> mesh = fill(job_, best_->U0);
      if (!mesh) return outcome(mesh.error(), "Tet mesh");
      filled_ = std::move(mesh).value();
    }
    ++maps_;
    if (Outcome end = outcome(without_placed(map(job_, *filled_, MapCare::usual)), "Volume map")) return end;
    locked_once_ = maps_ == 1 ? *std::move(filled_) : TetMesh();
    return std::nullopt;
  }

  const MeshingJob& job_;
  std::optional<ReverseFlowResult> best_;
  std::optional<TetMesh> filled_;  // of best_
  bool best_is_pulled_ = false;
  Error last_{ErrorCode::unsolved, "No flow was tried."};
  int maps_ = 0;
  TetMesh locked_once_;  // what was mapped in vain, in one way only
};

}  // namespace

Result<Draft> mesh_by_flow(const MeshingJob& job) { return FlowRoute(job).run(); }

}  // namespace overtet
