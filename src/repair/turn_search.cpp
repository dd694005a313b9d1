#include "src/repair/turn_search.h"

#include <algorithm>
#include <iterator>

#include "kernels/core/tuning.h"
#include "src/repair/tuning.h"

namespace overtet {

namespace {

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

// A surface with one more part turned.
struct TurnTrial {
  std::size_t left;  // offences
  double farthest;
  const InsideOutPart* part;
  Eigen::Vector3d along;
  VertexMatrix V;
};

// More than 12 members: half of them are its arguments.
class TurnSearch {
 public:
  TurnSearch(const Surface& input, const Findings& found, const VertexRings& rings, double diagonal,
             double thin, const RepairOptions& options, const RunContext& context)
      : input_(input),
        rings_(rings),
        diagonal_(diagonal),
        thin_(thin),
        options_(options),
        context_(context),
        now_(input),
        objections_(found.offences.size()),
        diagnosis_(found.diagnosis) {}

  Result<TurnedSurfaces> run() {
    for (std::size_t turns = 0; turns < kMostTried && diagnosis_.winding.negative_pairs > 0; ++turns) {
      const std::vector<InsideOutPart> parts = inside_out_parts(now_, diagnosis_, context_);
      if (auto stop = context_.stop()) return *stop;
      before_ = now_.V;
      enough_ = objections_ / 2;
      trials_.clear();
      if (Status s = try_parts(parts); !s) return s.error();
      now_.V = before_;
      if (trials_.empty()) break;
      out_.V.clear();
      for (TurnTrial& t : trials_) out_.V.push_back(std::move(t.V));
      now_.V = out_.V[0];
      ++out_.parts;
      if (Status s = look(); !s) return s.error();
    }
    return std::move(out_);
  }

 private:
  Status look() {
    Result<Findings> f = find_offences(now_, rings_, diagonal_, PokingOut::pairs, context_);
    if (!f) return f.error();
    objections_ = f.value().offences.size();
    diagnosis_ = std::move(f.value().diagnosis);
    return success();
  }

  // Every part in every direction, and then what looks best in other ways. The best trials are left, in
  // order.
  Status try_parts(const std::vector<InsideOutPart>& parts) {
    for (const InsideOutPart& part : parts)
      for (const Eigen::Vector3d& along : part.directions)
        if (Status s = attempt(part, along, kThickness[0], 0); !s) return s;
    sort_trials();
    const std::size_t promising = std::min(std::size_t{kInVain}, trials_.size());
    for (std::size_t i = 0; i < promising; ++i) {
      if (trials_[i].left == 0) continue;
      const InsideOutPart& part = *trials_[i].part;
      const Eigen::Vector3d along = trials_[i].along;
      for (const int follow : kFollowers)
        for (const double thickness : kThickness)
          if (follow > 0 || thickness != kThickness[0])
            if (Status s = attempt(part, along, thickness, follow); !s) return s;
    }
    sort_trials();
    return success();
  }

  // Turns one part, and looks at the result: a trial if that leaves little enough to object to.
  Status attempt(const InsideOutPart& part, const Eigen::Vector3d& along, double thickness, int follow) {
    if (work_ > options_.turn_work) return success();
    now_.V = before_;
    Turn turn = turned(now_, part, along, thickness, thin_);
    if (turn.vertices.empty()) return success();
    if (follow > 0) let_follow(now_.V, rings_, follow, turn);
    double far = 0;
    for (std::size_t i = 0; i < turn.vertices.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      far = std::max(far, (turn.to.row(k) - input_.V.row(turn.vertices[i])).norm());
      now_.V.row(turn.vertices[i]) = turn.to.row(k);
    }
    if (far > options_.max_relative_move * diagonal_ * (1 - 1e-9)) return success();
    ++out_.looks;
    if (Status s = look(); !s) return s;
    work_ += static_cast<double>(diagnosis_.pairs.size()) + 0.01 * static_cast<double>(now_.F.rows());
    if (objections_ <= enough_) trials_.push_back({objections_, far, &part, along, now_.V});
    return success();
  }

  void sort_trials() {
    std::stable_sort(trials_.begin(), trials_.end(), [](const TurnTrial& x, const TurnTrial& y) {
      return x.left != y.left ? x.left < y.left : x.farthest < y.farthest;
    });
    if (trials_.size() > kMostTried) trials_.resize(kMostTried);
  }

  const Surface& input_;
  const VertexRings& rings_;
  const double diagonal_, thin_;
  const RepairOptions& options_;
  const RunContext& context_;

  TurnedSurfaces out_;
  Surface now_;
  std::size_t objections_;  // to `now_`
  Diagnosis diagnosis_;     // of it
  VertexMatrix before_;     // this turn
  std::size_t enough_ = 0;  // objections that a trial may leave
  std::vector<TurnTrial> trials_;
  double work_ = 0;
};

}  // namespace

Result<TurnedSurfaces> turn_parts(const Surface& input, const Findings& found, const VertexRings& rings,
                                  double diagonal, double thin, const RepairOptions& options,
                                  const RunContext& context) {
  return TurnSearch(input, found, rings, diagonal, thin, options, context).run();
}

}  // namespace overtet
