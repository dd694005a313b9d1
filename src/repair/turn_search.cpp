#include "src/repair/turn_search.h"

#include <algorithm>
#include <iterator>

namespace overtet {

namespace {

// How thick a part is after its turn, the first for choosing directions.
constexpr double kThickness[] = {0.3, 0.2, 0.1, 0.5, 0.05};
constexpr int kFollowers[] = {0, 1, 3, 6};  // rings around it that follow
constexpr int kMostTurns = 6;
constexpr std::size_t kRefined = 3;     // ways of turning a part that are looked at closely
constexpr std::size_t kMostTrials = 8;  // and that are kept

// The rings around a turned part go with it, less and less.
void let_follow(const VertexMatrix& V, const VertexRings& rings, int count, Turn& turn) {
  VertexMatrix moves = VertexMatrix::Zero(V.rows(), 3);
  for (std::size_t i = 0; i < turn.vertices.size(); ++i)
    moves.row(turn.vertices[i]) = turn.to.row(static_cast<Eigen::Index>(i)) - V.row(turn.vertices[i]);
  std::vector<char> scratch(static_cast<std::size_t>(V.rows()), 0);
  const std::vector<Index> all = rings.grown(turn.vertices, count, scratch);
  std::vector<Index> rest;
  std::set_difference(all.begin(), all.end(), turn.vertices.begin(), turn.vertices.end(),
                      std::back_inserter(rest));
  const VertexMatrix follow = smoothed(V, moves, rings, rest, Smoothing::membrane);
  if (follow.rows() == 0) return;
  for (std::size_t i = 0; i < rest.size(); ++i) moves.row(rest[i]) = follow.row(static_cast<Eigen::Index>(i));
  turn.vertices = all;
  turn.to.resize(static_cast<Eigen::Index>(all.size()), 3);
  for (std::size_t i = 0; i < all.size(); ++i)
    turn.to.row(static_cast<Eigen::Index>(i)) = V.row(all[i]) + moves.row(all[i]);
}

}  // namespace

Result<TurnedSurfaces> turn_parts(const Surface& input, const Findings& found, const VertexRings& rings,
                                  double diagonal, double thin, const RepairOptions& options,
                                  const RunContext& context) {
  TurnedSurfaces out;
  Surface now = input;
  std::size_t objections = found.offences.size();
  Diagnosis diagnosis = found.diagnosis;
  const auto look = [&]() -> Status {
    Result<Findings> f = find_offences(now, rings, diagonal, false, context);
    if (!f) return f.error();
    objections = f.value().offences.size();
    diagnosis = std::move(f.value().diagnosis);
    return success();
  };
  struct Trial {
    std::size_t left;  // offences
    double farthest;
    const InsideOutPart* part;
    Eigen::Vector3d along;
    VertexMatrix V;
  };
  double work = 0;
  const double limit = options.max_relative_move * diagonal * (1 - 1e-9);
  for (int turns = 0; turns < kMostTurns && diagnosis.winding.negative_pairs > 0; ++turns) {
    const std::vector<InsideOutPart> parts = inside_out_parts(now, diagnosis, context);
    if (auto stop = context.stop()) return *stop;
    const VertexMatrix before = now.V;
    const std::size_t enough = objections / 2;
    std::vector<Trial> trials;
    const auto sort = [&] {
      std::stable_sort(trials.begin(), trials.end(), [](const Trial& x, const Trial& y) {
        return x.left != y.left ? x.left < y.left : x.farthest < y.farthest;
      });
      if (trials.size() > kMostTrials) trials.resize(kMostTrials);
    };
    const auto attempt = [&](const InsideOutPart& part, const Eigen::Vector3d& along, double thickness,
                             int follow) -> Status {
      if (work > options.turn_work) return success();
      now.V = before;
      Turn turn = turned(now, part, along, thickness, thin);
      if (turn.vertices.empty()) return success();
      if (follow > 0) let_follow(now.V, rings, follow, turn);
      double far = 0;
      for (std::size_t i = 0; i < turn.vertices.size(); ++i) {
        const auto k = static_cast<Eigen::Index>(i);
        far = std::max(far, (turn.to.row(k) - input.V.row(turn.vertices[i])).norm());
        now.V.row(turn.vertices[i]) = turn.to.row(k);
      }
      if (far > limit) return success();
      ++out.looks;
      if (Status s = look(); !s) return s;
      work += static_cast<double>(diagnosis.pairs.size()) + 0.01 * static_cast<double>(now.F.rows());
      if (objections > enough) return success();
      trials.push_back({objections, far, &part, along, now.V});
      return success();
    };
    for (const InsideOutPart& part : parts)
      for (const Eigen::Vector3d& along : part.directions)
        if (Status s = attempt(part, along, kThickness[0], 0); !s) return s.error();
    sort();
    const std::size_t promising = std::min(kRefined, trials.size());
    for (std::size_t i = 0; i < promising; ++i) {
      if (trials[i].left == 0) continue;
      const InsideOutPart& part = *trials[i].part;
      const Eigen::Vector3d along = trials[i].along;
      for (const int follow : kFollowers)
        for (const double thickness : kThickness)
          if (follow > 0 || thickness != kThickness[0])
            if (Status s = attempt(part, along, thickness, follow); !s) return s.error();
    }
    sort();
    now.V = before;
    if (trials.empty()) break;
    out.V.clear();
    for (Trial& t : trials) out.V.push_back(std::move(t.V));
    now.V = out.V[0];
    ++out.parts;
    if (Status s = look(); !s) return s.error();
  }
  return out;
}

}  // namespace overtet
