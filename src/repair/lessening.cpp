#include "src/repair/lessening.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "kernels/core/box.h"

#include "src/repair/offences.h"
#include "src/repair/smoothing.h"
#include "src/repair/tuning.h"

namespace overtet {

namespace {

// New places for a group's vertices.
struct Trial {
  std::size_t group = 0;
  std::vector<std::pair<Index, Eigen::RowVector3d>> to;
};

class Lessening {
 public:
  Lessening(const Surface& input, const VertexMatrix& moved, const LessenOptions& options,
            const RunContext& context)
      : input_(input),
        options_(options),
        context_(context),
        rings_(static_cast<Index>(input.V.rows()), input.F),
        diagonal_(diagonal_of(input.V)),
        now_{moved, input.F},
        scratch_(static_cast<std::size_t>(input.V.rows()), 0),
        owner_(static_cast<std::size_t>(input.V.rows()), -1) {}

  Result<LessenResult> run();

 private:
  using Order = std::vector<std::vector<Index>>;  // of each group's vertices

  double move(Index v) const { return (now_.V.row(v) - input_.V.row(v)).norm(); }
  double total() const { return (now_.V - input_.V).rowwise().norm().sum(); }
  bool left() const { return work_ < options_.work; }
  void gather();
  Order by_move(bool largest_first) const;
  double thinness(const VertexMatrix& V, Index f) const;
  Status look(const VertexMatrix& V, std::vector<Offence>& offences);
  Status judge(const std::vector<Trial>& trials, std::vector<char>& accepted);
  Status all_home();
  Status bisect(const std::function<Trial(std::size_t group, double part)>& trial);
  Status batches(const Order& order, double part);
  Status go();

  const Surface& input_;
  const LessenOptions& options_;
  const RunContext& context_;
  const VertexRings rings_;
  const double diagonal_;
  Surface now_;
  std::vector<char> scratch_;
  std::vector<std::vector<Index>> groups_;
  std::vector<Index> owner_;  // of each vertex in a group or next to one: the group
  double work_ = 0;
  LessenResult out_;
};

// The groups: vertices that are not at their places, joined by edges.
void Lessening::gather() {
  groups_.clear();
  std::fill(owner_.begin(), owner_.end(), -1);
  const Index n = static_cast<Index>(now_.V.rows());
  for (Index first = 0; first < n; ++first) {
    if (owner_[first] >= 0 || now_.V.row(first) == input_.V.row(first)) continue;
    const auto id = static_cast<Index>(groups_.size());
    std::vector<Index> group = {first};
    owner_[first] = id;
    for (std::size_t i = 0; i < group.size(); ++i)
      for (const Index u : rings_(group[i]))
        if (owner_[u] < 0 && now_.V.row(u) != input_.V.row(u)) owner_[u] = id, group.push_back(u);
    std::sort(group.begin(), group.end());
    groups_.push_back(std::move(group));
  }
  for (std::size_t g = 0; g < groups_.size(); ++g)
    for (const Index v : rings_.grown(groups_[g], 1, scratch_))
      if (owner_[v] < 0) owner_[v] = static_cast<Index>(g);
}

Lessening::Order Lessening::by_move(bool largest_first) const {
  Order order = groups_;
  for (std::vector<Index>& list : order)
    std::stable_sort(list.begin(), list.end(),
                     [&](Index a, Index b) { return largest_first ? move(a) > move(b) : move(a) < move(b); });
  return order;
}

double Lessening::thinness(const VertexMatrix& V, Index f) const {
  const Eigen::Vector3d a = V.row(input_.F(f, 0)), b = V.row(input_.F(f, 1)), c = V.row(input_.F(f, 2));
  const double longest = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  return longest > 0 ? (b - a).cross(c - a).norm() / longest : 0;
}

Status Lessening::look(const VertexMatrix& V, std::vector<Offence>& offences) {
  offences.clear();
  for (Index f = 0; f < input_.F.rows(); ++f) {
    bool changed = false;
    for (int k = 0; k < 3; ++k) changed = changed || V.row(input_.F(f, k)) != now_.V.row(input_.F(f, k));
    if (changed && thinness(V, f) < std::min(kThinnestFace, thinness(now_.V, f)))
      offences.push_back({input_.F(f, 0), input_.F(f, 1), input_.F(f, 2)});
  }
  if (!offences.empty()) return success();  // cheaper than a diagnosis
  ++out_.looks;
  Result<Findings> found = find_offences({V, input_.F}, rings_, diagonal_, PokingOut::pairs, context_);
  if (!found) return found.error();
  offences = std::move(found.value().offences);
  work_ +=
      static_cast<double>(found.value().diagnosis.pairs.size()) + 0.01 * static_cast<double>(input_.F.rows());
  context_.report("repair", std::min(1.0, work_ / options_.work), "moving less");
  return success();
}

// Carries out those trials to which nothing objects. accepted: of each trial.
Status Lessening::judge(const std::vector<Trial>& trials, std::vector<char>& accepted) {
  accepted.assign(trials.size(), 0);
  std::vector<std::vector<std::size_t>> open(1);
  for (std::size_t i = 0; i < trials.size(); ++i)
    if (!trials[i].to.empty()) open[0].push_back(i);
  std::vector<Offence> offences;
  while (!open.empty()) {
    const std::vector<std::size_t> set = std::move(open.back());
    open.pop_back();
    if (set.empty()) continue;
    if (!left()) return success();
    VertexMatrix V = now_.V;
    for (const std::size_t i : set)
      for (const auto& [v, p] : trials[i].to) V.row(v) = p;
    if (Status s = look(V, offences); !s) return s;
    if (offences.empty()) {
      now_.V = std::move(V);
      for (const std::size_t i : set) accepted[i] = 1;
      continue;
    }
    if (set.size() == 1) continue;
    std::vector<char> bad(groups_.size(), 0);
    bool known = true;
    for (const Offence& o : offences) {
      bool here = false;
      for (const Index v : o)
        if (owner_[v] >= 0) bad[owner_[v]] = 1, here = true;
      known = known && here;
    }
    std::vector<std::size_t> fine;
    for (const std::size_t i : set)
      if (known && !bad[trials[i].group]) fine.push_back(i);
    if (!fine.empty())
      open.push_back(std::move(fine));
    else if (set.size() <= kMostTried)
      for (auto i = set.rbegin(); i != set.rend(); ++i) open.push_back({*i});
  }
  return success();
}

Status Lessening::all_home() {
  gather();
  std::vector<Trial> trials(groups_.size());
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    trials[g].group = g;
    for (const Index v : groups_[g]) trials[g].to.emplace_back(v, input_.V.row(v));
  }
  std::vector<char> accepted;
  return judge(trials, accepted);
}

// The least part, per group, to which nothing objects; 1 is where things are.
Status Lessening::bisect(const std::function<Trial(std::size_t group, double part)>& trial) {
  gather();
  std::vector<double> low(groups_.size(), 0), high(groups_.size(), 1);
  std::vector<Trial> trials(groups_.size());
  std::vector<char> accepted;
  for (int i = 0; i < kBisections && left(); ++i) {
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      trials[g] = trial(g, (low[g] + high[g]) / 2);
      trials[g].group = g;
    }
    if (Status s = judge(trials, accepted); !s) return s;
    for (std::size_t g = 0; g < groups_.size(); ++g) (accepted[g] ? high : low)[g] = (low[g] + high[g]) / 2;
  }
  return success();
}

// Moves shortened to `part` of what they are, vertex by vertex in each group's order.
Status Lessening::batches(const Order& order, double part) {
  struct Walk {
    std::size_t at = 0, size = 1;
  };
  std::vector<Walk> walks(order.size());
  for (std::size_t g = 0; g < order.size(); ++g)
    walks[g].size = std::max<std::size_t>(1, (order[g].size() + 1) / 2);
  std::vector<Trial> trials(order.size());
  std::vector<char> accepted;
  while (left()) {
    bool any = false;
    for (std::size_t g = 0; g < order.size(); ++g) {
      trials[g] = {g, {}};
      const std::size_t last = std::min(walks[g].at + walks[g].size, order[g].size());
      for (std::size_t i = walks[g].at; i < last; ++i) {
        const Index v = order[g][i];
        const Eigen::RowVector3d home = input_.V.row(v);
        trials[g].to.emplace_back(v, part > 0 ? (home + part * (now_.V.row(v) - home)).eval() : home);
        any = true;
      }
    }
    if (!any) return success();
    if (Status s = judge(trials, accepted); !s) return s;
    for (std::size_t g = 0; g < order.size(); ++g) {
      Walk& w = walks[g];
      const std::size_t tried = trials[g].to.size();
      if (accepted[g]) {
        w.at += tried;
        w.size *= 2;
      } else if (tried > 1) {
        w.size = tried / 2;
      } else {
        w.at += tried;
      }
    }
  }
  return success();
}

Status Lessening::go() {
  if (Status s = all_home(); !s) return s;
  VertexMatrix from;
  std::vector<double> most;
  const auto start = [&] {
    from = now_.V;
    gather();
    most.assign(groups_.size(), 0);
    for (std::size_t g = 0; g < groups_.size(); ++g)
      for (const Index v : groups_[g]) most[g] = std::max(most[g], move(v));
  };
  const auto cut = [&](std::size_t g, double part) {
    Trial t;
    for (const Index v : groups_[g]) {
      const Eigen::RowVector3d home = input_.V.row(v), way = from.row(v) - home;
      if (const double length = way.norm(); length > part * most[g])
        t.to.emplace_back(v, home + part * most[g] / length * way);
    }
    return t;
  };
  const auto shorten = [&](std::size_t g, double part) {
    Trial t;
    for (const Index v : groups_[g]) {
      const Eigen::RowVector3d home = input_.V.row(v);
      t.to.emplace_back(v, home + part * (from.row(v) - home));
    }
    return t;
  };
  double before = total();
  for (int pass = 0; pass < kLessenPasses && left(); ++pass) {
    start();
    if (Status s = bisect(cut); !s) return s;
    start();
    if (Status s = bisect(shorten); !s) return s;
    gather();
    if (Status s = batches(by_move(false), 0); !s) return s;
    gather();
    if (Status s = batches(by_move(true), 0.5); !s) return s;
    const double now = total();
    if (now > kGains * before) break;
    before = now;
  }
  return success();
}

Result<LessenResult> Lessening::run() {
  const VertexMatrix start = now_.V;
  std::vector<Offence> offences;
  Status done = look(now_.V, offences);
  if (done && offences.empty() && work_ <= options_.work) done = go();
  if (!done && done.error().code != ErrorCode::limit) return done.error();
  out_.cut_by_time = !done;
  out_.lessened = now_.V != start;
  out_.V = std::move(now_.V);
  return std::move(out_);
}

}  // namespace

Status LessenOptions::validate() const {
  if (!(work >= 0)) return Error{ErrorCode::usage, "The work of moving less must not be negative."};
  return success();
}

Result<LessenResult> lessen(const Surface& input, const VertexMatrix& moved, const LessenOptions& options,
                            const RunContext& context) {
  if (Status valid = options.validate(); !valid) return valid.error();
  if (moved.rows() != input.V.rows())
    return Error{ErrorCode::usage, "The moved vertices are those of another surface."};
  if (Result<SurfaceTopology> t = require_topology(input); !t) return t.error();
  return Lessening(input, moved, options, context).run();
}

}  // namespace overtet
