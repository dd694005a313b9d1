#include "src/repair/repair.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/box.h"
#include "kernels/core/tuning.h"
#include "src/repair/clusters.h"
#include "src/repair/offences.h"
#include "src/repair/shrinking.h"
#include "src/repair/tuning.h"
#include "src/repair/turn_search.h"

namespace overtet {

struct RepairMemory {
  VertexMatrix base;
  LadderState ladder;
  std::vector<Index> hinges;         // of the surface that was handed out
  std::vector<VertexMatrix> others;  // other ways of turning its parts, not tried yet
};

namespace {

class Repair {
 public:
  Repair(const Surface& surface, const RepairOptions& options, const RunContext& context)
      : input_(surface),
        options_(options),
        context_(context),
        rings_(static_cast<Index>(surface.V.rows()), surface.F),
        diagonal_(diagonal_of(surface.V)),
        gentle_(gentle_move()),
        base_(surface.V),
        now_(surface),
        clusters_(surface, rings_, options, diagonal_, gentle_) {}

  Result<RepairResult> run();

 private:
  double gentle_move() const;
  Status look(PokingOut poking_out);
  Status begin_asked();
  Status start_from(const VertexMatrix& base);
  Status climb();
  Error inside_out() const;
  Error left() const;
  void record();
  void add_round();
  RepairResult handed_out(std::shared_ptr<const RepairMemory> memory, const char* termination);

  const Surface& input_;
  const RepairOptions& options_;
  const RunContext& context_;
  const VertexRings rings_;
  const double diagonal_, gentle_;

  VertexMatrix base_;  // the input with its inside-out parts turned: what smoothing starts from
  Surface now_;
  Findings found_;  // of now_
  Clusters clusters_;
  RepairResult out_;
};

double Repair::gentle_move() const {
  double edges = 0;
  for (Index f = 0; f < input_.F.rows(); ++f)
    edges += (input_.V.row(input_.F(f, 0)) - input_.V.row(input_.F(f, 1))).norm();
  return std::min(options_.max_relative_move * diagonal_ * (1 - 1e-9),
                  std::max(options_.gentle_relative_move * diagonal_ * (1 - 1e-9),
                           edges / static_cast<double>(input_.F.rows())));
}

Status Repair::look(PokingOut poking_out) {
  const bool known = options_.diagnosis && options_.diagnosis->complete() && now_.V == input_.V;
  Result<Findings> found = known ? offences_of(now_, *options_.diagnosis, rings_, diagonal_, poking_out)
                                 : find_offences(now_, rings_, diagonal_, poking_out, context_);
  if (!found) return found.error();
  found_ = std::move(found).value();
  return success();
}

// Where an earlier repair ended, and further where it was asked to.
Status Repair::begin_asked() {
  std::vector<Index> hinges;
  if (options_.earlier) {
    const RepairMemory& earlier = *options_.earlier;
    if (earlier.base.rows() != input_.V.rows())
      return Error{ErrorCode::usage, "The earlier repair was one of another surface."};
    base_ = earlier.base;
    clusters_.restore(earlier.ladder);
    hinges = earlier.hinges;
    now_.V = base_;
  } else {
    if (Status s = look(PokingOut::pairs); !s) return s;
    for (const Hinge& h : found_.diagnosis.hinges) hinges.push_back(h.vertex);
  }
  clusters_.go_on(base_, now_.V, hinges, options_.place);
  clusters_.place(base_);
  now_.V = clusters_.compose(base_);
  return success();
}

Status Repair::start_from(const VertexMatrix& base) {
  base_ = base;
  clusters_.clear();
  now_.V = base_;
  return look(PokingOut::pairs);
}

// Moves more and more until nothing objects, or the ladder ends.
Status Repair::climb() {
  std::vector<Index> turned;
  for (Index v = 0; v < static_cast<Index>(input_.V.rows()); ++v)
    if (base_.row(v) != input_.V.row(v)) turned.push_back(v);
  std::vector<char> scratch(static_cast<std::size_t>(input_.V.rows()), 0), turned_near = scratch;
  for (const Index v : rings_.grown(turned, kRings, scratch)) turned_near[v] = 1;
  for (int round = 0; !found_.offences.empty() && round < options_.max_rounds; ++round) {
    if (!clusters_.assign(now_, found_, turned_near)) break;
    clusters_.place(base_);
    now_.V = clusters_.compose(base_);
    if (Status s = look(out_.rounds.size() % kFullLookEvery == 0 ? PokingOut::all : PokingOut::pairs); !s)
      return s;
    add_round();
  }
  return success();
}

Error Repair::inside_out() const {
  return {
      ErrorCode::infeasible,
      found_.diagnosis.message +
          " Moving vertices a little does not help, because a component faces inwards: reverse its faces."};
}

Error Repair::left() const {
  return {ErrorCode::infeasible,
          "The surface could not be repaired by moving vertices by at most " +
              std::to_string(options_.max_relative_move) + " times its diagonal; the first of " +
              std::to_string(found_.offences.size()) + " places that still forbid a mesh is at vertex " +
              std::to_string(found_.offences[0][0]) + ". " + found_.diagnosis.message};
}

void Repair::record() {
  out_.moved.clear();
  out_.max_relative = out_.mean_relative = 0;
  for (Index v = 0; v < now_.V.rows(); ++v) {
    if (now_.V.row(v) == input_.V.row(v)) continue;
    out_.moved.push_back(v);
    const double move = (now_.V.row(v) - input_.V.row(v)).norm() / diagonal_;
    out_.max_relative = std::max(out_.max_relative, move);
    out_.mean_relative += move;
  }
  if (!out_.moved.empty()) out_.mean_relative /= static_cast<double>(out_.moved.size());
}

void Repair::add_round() {
  record();
  RepairRound r;
  r.offences = static_cast<Index>(found_.offences.size());
  r.clusters = static_cast<Index>(clusters_.all().size());
  for (const Cluster& c : clusters_.all())
    r.open_clusters += std::any_of(found_.offences.begin(), found_.offences.end(),
                                   [&](const Offence& o) { return sorted_share(c.region, o); });
  r.moved = static_cast<Index>(out_.moved.size());
  r.max_relative = out_.max_relative;
  r.verdict = verdict_name(found_.diagnosis.verdict);
  context_.report("repair", static_cast<double>(out_.rounds.size()) / options_.max_rounds,
                  std::to_string(r.offences) + " left, " + std::to_string(r.moved) + " vertices moved");
  out_.rounds.push_back(std::move(r));
}

RepairResult Repair::handed_out(std::shared_ptr<const RepairMemory> memory, const char* termination) {
  out_.memory = std::move(memory);
  out_.surface = std::move(now_);
  out_.diagnosis = std::move(found_.diagnosis);
  out_.termination = termination;
  return std::move(out_);
}

Result<RepairResult> Repair::run() {
  const bool asked = options_.earlier || options_.place;
  if (asked)
    if (Status s = begin_asked(); !s) return s.error();
  if (Status s = look(asked ? PokingOut::pairs : PokingOut::all); !s) return s.error();
  add_round();
  if (found_.hopeless) return inside_out();
  if (!asked && found_.offences.empty()) return handed_out(nullptr, "nothing to repair");
  if (Status s = climb(); !s) return s.error();
  std::vector<VertexMatrix> bases;  // ways of turning parts, the best first
  if (!found_.offences.empty() && !found_.hopeless && !asked && !options_.only_gently) {
    // Smoothing does not do it: there may be parts to turn over.
    if (Status s = start_from(input_.V); !s) return s.error();
    Result<TurnedSurfaces> turned =
        turn_parts(input_, found_, rings_, diagonal_, gentle_, options_, context_);
    if (!turned) return turned.error();
    bases = std::move(turned.value().V);
    out_.turned_parts = turned.value().parts;
    out_.turn_rounds = turned.value().looks;
    add_round();
  } else if (options_.earlier) {
    bases = options_.earlier->others;
  }
  std::size_t tried = 0;
  for (; tried < bases.size() && !found_.offences.empty(); ++tried) {
    if (Status s = start_from(bases[tried]); !s) return s.error();
    if (Status s = climb(); !s) return s.error();
  }
  bases.erase(bases.begin(), bases.begin() + static_cast<std::ptrdiff_t>(tried));
  if (found_.hopeless) return inside_out();
  if (!found_.offences.empty()) return left();
  Result<Index> looks = shrink(clusters_, input_, base_, rings_, diagonal_, options_, context_);
  if (!looks) return looks.error();
  out_.shrink_rounds = looks.value();
  now_.V = clusters_.compose(base_);
  if (Status s = look(PokingOut::pairs); !s) return s.error();
  record();
  auto memory = std::make_shared<RepairMemory>();
  memory->base = base_;
  memory->ladder = clusters_.state();
  memory->others = std::move(bases);
  for (const Hinge& h : found_.diagnosis.hinges) memory->hinges.push_back(h.vertex);
  return handed_out(std::move(memory), "feasible");
}

}  // namespace

Status RepairOptions::validate() const {
  if (!(max_relative_move > 0 && max_relative_move <= 1))
    return Error{ErrorCode::usage, "The largest move must be a part of the diagonal between 0 and 1."};
  if (!(gentle_relative_move > 0))
    return Error{ErrorCode::usage, "The gentle move must be a positive part of the diagonal."};
  if (max_rounds < 1 || max_shrink_rounds < 0 || !(shrink_work >= 0) || !(turn_work >= 0))
    return Error{ErrorCode::usage, "The numbers of rounds of a repair must be positive."};
  return success();
}

Result<RepairResult> repair(const Surface& surface, const RepairOptions& options, const RunContext& context) {
  if (Status valid = options.validate(); !valid) return valid.error();
  if (Result<SurfaceTopology> t = require_topology(surface); !t) return t.error();
  return Repair(surface, options, context).run();
}

}  // namespace overtet
