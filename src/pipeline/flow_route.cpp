#include "src/pipeline/flow_route.h"

#include <algorithm>
#include <array>
#include <optional>

#include "src/pipeline/flow_stages.h"

namespace overtet {

namespace {

// A map that locks is tried once more in another way.
Result<TetMesh> map_twice(const MeshingJob& r, const TetMesh& mesh) {
  Result<TetMesh> mapped = map(r, mesh, MapCare::usual);
  if (mapped || mapped.error().code != ErrorCode::unsolved) return mapped;
  Result<TetMesh> again = map(r, mesh, MapCare::careful);
  if (again || again.error().code != ErrorCode::unsolved) return again;
  return mapped;
}

}  // namespace

Result<TetMesh> mesh_by_flow(const MeshingJob& r) {
  if (const auto saved = saved_fill(r)) return *saved ? map_twice(r, saved->value()) : *saved;

  const std::vector<ForwardFlowOptions> forward_ladder = forward_flow_ladder();
  const std::vector<ReverseFlowOptions> reverse_ladder = reverse_flow_ladder();
  const std::size_t rungs = std::min(forward_ladder.size(), reverse_ladder.size());
  std::optional<ReverseFlowResult> best;
  Error last{ErrorCode::unsolved, "No flow was tried."};
  int maps = 0;
  TetMesh locked_once;  // what was mapped in vain, in one way only
  for (std::size_t rung = 0; rung < rungs; ++rung) {
    const bool is_last = rung + 1 == rungs;
    Result<ForwardFlowResult> forward = flow_forward(r, forward_ladder[rung]);
    if (!forward) {
      if (ends_run(forward.error())) return forward.error();
      last = {ErrorCode::unsolved, "Forward flow: " + forward.error().message};
    } else {
      if (Status s = keep(r, "flow_end", Surface{forward.value().V, r.surface.F}); !s) return s.error();
      Result<ReverseFlowResult> back = flow_back(r, forward.value(), reverse_ladder[rung]);
      if (!back) {
        if (ends_run(back.error())) return back.error();
        last = {ErrorCode::unsolved, "Reverse flow: " + back.error().message};
      } else if (!best || back.value().quality.area_p01 > best->quality.area_p01) {
        best = std::move(back).value();
      } else {
        continue;  // worse than what did not map before
      }
    }
    if (!best || (best->locked && !is_last)) continue;
    if (Status s = keep(r, "embedded", Surface{best->U0, r.surface.F}); !s) return s.error();
    Result<TetMesh> filled = fill(r, best->U0);
    if (filled) {
      ++maps;
      Result<TetMesh> mapped = map(r, filled.value(), MapCare::usual);
      if (mapped || ends_run(mapped.error())) return mapped;
      last = {ErrorCode::unsolved, "Volume map: " + mapped.error().message, mapped.error().place};
      locked_once = maps == 1 ? std::move(filled).value() : TetMesh();
    } else {
      if (ends_run(filled.error())) return filled;
      last = {ErrorCode::unsolved, "Tet mesh: " + filled.error().message};
    }
  }
  // Only one embedding was worth mapping, and it locked before the ladder's end.
  if (locked_once.T.rows() > 0) {
    Result<TetMesh> mapped = map(r, locked_once, MapCare::careful);
    if (mapped || ends_run(mapped.error())) return mapped;
  }
  return last;
}

}  // namespace overtet
