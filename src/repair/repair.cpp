#include "src/repair/repair.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "src/repair/smoothing.h"
#include "src/surface/winding.h"

namespace overtet {

namespace {

// One attempt for a cluster: its vertices with so many rings around them, moved so much of the way.
struct Step {
  int rings;
  double part;
  Smoothing kind;
};

constexpr Step kLadder[] = {
    {0, 0.1, Smoothing::membrane},    {0, 0.3, Smoothing::membrane},    {0, 1.0, Smoothing::membrane},
    {1, 0.3, Smoothing::membrane},    {1, 1.0, Smoothing::membrane},    {1, 1.0, Smoothing::thin_plate},
    {2, 0.5, Smoothing::membrane},    {2, 1.0, Smoothing::thin_plate},  {2, 1.0, Smoothing::membrane},
    {3, 1.0, Smoothing::thin_plate},  {3, 1.0, Smoothing::membrane},    {5, 1.0, Smoothing::thin_plate},
    {5, 1.0, Smoothing::membrane},    {8, 1.0, Smoothing::thin_plate},  {8, 1.0, Smoothing::membrane},
    {12, 1.0, Smoothing::thin_plate}, {12, 1.0, Smoothing::membrane},   {18, 1.0, Smoothing::thin_plate},
    {18, 1.0, Smoothing::membrane},   {27, 1.0, Smoothing::thin_plate}, {27, 1.0, Smoothing::membrane}};
constexpr int kLevels = static_cast<int>(std::size(kLadder));

constexpr double kFlatFace = 1e-14;  // height over reach below which a face counts as one without area
constexpr std::size_t kFlood = 200000;

// Vertices that forbid a mesh together.
using Offence = std::vector<Index>;

struct Cluster {
  std::vector<Index> seeds;  // sorted
  int level = 0;
  double part = 1;             // of the level's move: what the end's shrinking leaves
  std::vector<Index> held;     // of the region: back at their places for good, sorted
  std::vector<Index> region;   // sorted; what the level moves
  VertexMatrix to;             // the region's positions
  bool fresh = true;           // region and positions must be computed
};

class Repair {
 public:
  Repair(const Surface& surface, const RepairOptions& options, const RunContext& context)
      : input_(surface), options_(options), context_(context), scratch_(surface.V.rows(), 0) {}

  Result<RepairResult> run();

 private:
  Status look(bool floods);
  Offence flooded(const Offence& seed) const;
  void assign();
  void merge_overlapping();
  void place(Cluster& c);
  void compose();
  Status shrink();
  bool within(const Cluster& c, const Offence& o, int rings);
  void record();

  const Surface& input_;
  const RepairOptions& options_;
  const RunContext& context_;
  std::vector<char> scratch_;
  std::optional<VertexRings> rings_;
  double diagonal_ = 0;

  Surface now_;
  Diagnosis diagnosis_;
  std::vector<Offence> offences_;
  bool hopeless_ = false;  // a component that faces inwards with nothing around it
  std::vector<Cluster> clusters_;
  RepairResult out_;
};

std::vector<Index> flat_faces(const Surface& s) {
  std::vector<Index> flat;
  const Eigen::RowVector3d centre = (s.V.colwise().minCoeff() + s.V.colwise().maxCoeff()) / 2;
  const double offset = centre.cwiseAbs().maxCoeff();
  for (Index f = 0; f < s.F.rows(); ++f) {
    const Eigen::Vector3d a = s.V.row(s.F(f, 0)), b = s.V.row(s.F(f, 1)), c = s.V.row(s.F(f, 2));
    const double longest =
        std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
    const double reach = std::max(
        {a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff(), c.cwiseAbs().maxCoeff(), offset});
    if ((b - a).cross(c - a).norm() <= kFlatFace * reach * longest) flat.push_back(f);
  }
  return flat;
}

// All vertices around `seed` in front of which the winding number is negative: the part that pokes out.
Offence Repair::flooded(const Offence& seed) const {
  const WindingNumber winding(now_, *diagnosis_.bvh);
  std::vector<char> seen(now_.V.rows(), 0);
  Offence all = seed, queue = seed;
  for (const Index v : seed) seen[v] = 1;
  const double ahead = 1e-9 * diagonal_;
  while (!queue.empty() && all.size() < kFlood) {
    Offence next;
    for (const Index v : queue)
      for (const Index u : (*rings_)(v)) {
        if (seen[u]) continue;
        seen[u] = 1;
        Eigen::Vector3d normal = Eigen::Vector3d::Zero();
        for (const Index h : half_edges_around(diagnosis_.topology.topology, u)) {
          const Index f = half_edge_face(h);
          const Eigen::Vector3d a = now_.V.row(now_.F(f, 0)), b = now_.V.row(now_.F(f, 1)),
                                c = now_.V.row(now_.F(f, 2));
          normal += (b - a).cross(c - a);
        }
        const double length = normal.norm();
        if (!(length > 0)) continue;
        const Eigen::Vector3d p = now_.V.row(u).transpose() + ahead / length * normal;
        const auto w = winding.at(p.data());
        if (w && *w < 0) next.push_back(u);
      }
    all.insert(all.end(), next.begin(), next.end());
    queue = std::move(next);
  }
  return all;
}

// The diagnosis of the surface as it is now, and what it objects to.
Status Repair::look(bool floods) {
  if (auto stop = context_.stop()) return *stop;
  offences_.clear();
  const auto corners = [&](Index f) {
    return Offence{now_.F(f, 0), now_.F(f, 1), now_.F(f, 2)};
  };
  for (const Index f : flat_faces(now_)) offences_.push_back(corners(f));
  DiagnoseOptions options;
  RunContext silent = context_;
  silent.progress = nullptr;
  Result<Diagnosis> d = diagnose(now_, options, silent);
  if (!d) return d.error();
  diagnosis_ = std::move(d).value();
  if (!diagnosis_.topology.ok()) return Error{ErrorCode::bad_input, diagnosis_.message};
  for (const Index f : diagnosis_.degenerate_faces) offences_.push_back(corners(f));
  for (const auto& [f, g] : diagnosis_.winding.negative_at) {
    if (f < 0) {
      hopeless_ = hopeless_ || diagnosis_.winding.negative_pairs == 0;
      continue;
    }
    Offence o = corners(f), more = corners(g);
    o.insert(o.end(), more.begin(), more.end());
    offences_.push_back(o);
  }
  if (floods && diagnosis_.winding.negative_pairs > 0) {
    Offence all;
    for (const auto& [f, g] : diagnosis_.winding.negative_at)
      if (f >= 0) {
        const Offence a = corners(f), b = corners(g);
        all.insert(all.end(), a.begin(), a.end());
        all.insert(all.end(), b.begin(), b.end());
      }
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    const std::size_t known = all.size();
    all = flooded(all);
    for (std::size_t i = known; i < all.size(); ++i) offences_.push_back({all[i]});
  }
  for (const Hinge& h : diagnosis_.hinges)
    if (h.B0 && *h.B0 < 0) offences_.push_back({h.vertex});
  for (const auto& group : diagnosis_.wound.odd_groups)
    for (const Index v : group) offences_.push_back({v});
  for (Offence& o : offences_) {
    std::sort(o.begin(), o.end());
    o.erase(std::unique(o.begin(), o.end()), o.end());
  }
  return success();
}

bool sorted_share(const std::vector<Index>& a, const std::vector<Index>& b) {
  auto i = a.begin();
  auto j = b.begin();
  while (i != a.end() && j != b.end()) {
    if (*i == *j) return true;
    *i < *j ? ++i : ++j;
  }
  return false;
}

bool Repair::within(const Cluster& c, const Offence& o, int rings) {
  return sorted_share(rings_->grown(c.region, rings, scratch_), o);
}

// Offences next to a cluster send it up the ladder; the others make new clusters.
void Repair::assign() {
  // Offences that share a vertex or an edge belong together.
  const std::size_t n = offences_.size();
  std::vector<std::size_t> parent(n);
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](std::size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  std::vector<std::int64_t> first_at(now_.V.rows(), -1);
  for (std::size_t i = 0; i < n; ++i)
    for (const Index v : offences_[i]) {
      if (first_at[v] < 0) first_at[v] = static_cast<std::int64_t>(i);
      parent[root(i)] = root(static_cast<std::size_t>(first_at[v]));
    }
  for (std::size_t i = 0; i < n; ++i)
    for (const Index v : offences_[i])
      for (const Index u : (*rings_)(v))
        if (first_at[u] >= 0) parent[root(i)] = root(static_cast<std::size_t>(first_at[u]));
  std::vector<Offence> groups(n);
  for (std::size_t i = 0; i < n; ++i) {
    Offence& g = groups[root(i)];
    g.insert(g.end(), offences_[i].begin(), offences_[i].end());
  }
  std::vector<std::vector<Index>> reach;
  for (const Cluster& c : clusters_) reach.push_back(rings_->grown(c.region, 1, scratch_));
  std::vector<char> hit(clusters_.size(), 0);
  std::vector<Cluster> fresh;
  for (Offence& g : groups) {
    if (g.empty()) continue;
    std::sort(g.begin(), g.end());
    g.erase(std::unique(g.begin(), g.end()), g.end());
    bool known = false;
    for (std::size_t c = 0; c < clusters_.size(); ++c)
      if (sorted_share(reach[c], g)) {
        known = true;
        hit[c] = 1;
        std::vector<Index> all;
        std::set_union(clusters_[c].seeds.begin(), clusters_[c].seeds.end(), g.begin(), g.end(),
                       std::back_inserter(all));
        clusters_[c].seeds = std::move(all);
      }
    if (!known) {
      fresh.emplace_back();
      fresh.back().seeds = std::move(g);
    }
  }
  for (std::size_t c = 0; c < clusters_.size(); ++c)
    if (hit[c]) {
      ++clusters_[c].level;
      clusters_[c].fresh = true;
    }
  for (Cluster& c : fresh) clusters_.push_back(std::move(c));
}

// The region and the positions of a cluster's level.
void Repair::place(Cluster& c) {
  if (!c.fresh) return;
  c.fresh = false;
  const Step& step = kLadder[std::min(c.level, kLevels - 1)];
  c.region = rings_->grown(c.seeds, step.rings, scratch_);
  c.to = smoothed(input_.V, *rings_, c.region, step.kind);
  if (c.to.rows() == 0) {
    c.region.clear();
    return;
  }
  const double limit = options_.max_relative_move * diagonal_ * (1 - 1e-9);
  for (std::size_t i = 0; i < c.region.size(); ++i) {
    const Eigen::RowVector3d from = input_.V.row(c.region[i]);
    const auto k = static_cast<Eigen::Index>(i);
    Eigen::RowVector3d move = step.part * (c.to.row(k) - from);
    if (const double length = move.norm(); length > limit) move *= limit / length;
    c.to.row(k) = from + move;
  }
}

// Clusters whose regions meet become one.
void Repair::merge_overlapping() {
  for (Cluster& c : clusters_) place(c);
  for (bool again = true; again;) {
    again = false;
    for (std::size_t a = 0; a < clusters_.size(); ++a)
      for (std::size_t b = a + 1; b < clusters_.size();) {
        if (!sorted_share(clusters_[a].region, clusters_[b].region)) {
          ++b;
          continue;
        }
        std::vector<Index> all;
        std::set_union(clusters_[a].seeds.begin(), clusters_[a].seeds.end(), clusters_[b].seeds.begin(),
                       clusters_[b].seeds.end(), std::back_inserter(all));
        clusters_[a].seeds = std::move(all);
        clusters_[a].level = std::max(clusters_[a].level, clusters_[b].level);
        clusters_[a].fresh = true;
        clusters_.erase(clusters_.begin() + static_cast<std::ptrdiff_t>(b));
        place(clusters_[a]);
        again = true;
      }
  }
}

// The surface with all clusters' moves.
void Repair::compose() {
  now_.V = input_.V;
  for (const Cluster& c : clusters_)
    for (std::size_t i = 0; i < c.region.size(); ++i) {
      const Index v = c.region[i];
      if (std::binary_search(c.held.begin(), c.held.end(), v)) continue;
      if (c.part == 1)
        now_.V.row(v) = c.to.row(static_cast<Eigen::Index>(i));
      else
        now_.V.row(v) += c.part * (c.to.row(static_cast<Eigen::Index>(i)) - input_.V.row(v));
    }
}

void Repair::record() {
  out_.moved.clear();
  out_.max_relative = 0;
  for (Index v = 0; v < now_.V.rows(); ++v) {
    if (now_.V.row(v) == input_.V.row(v)) continue;
    out_.moved.push_back(v);
    out_.max_relative = std::max(out_.max_relative, (now_.V.row(v) - input_.V.row(v)).norm() / diagonal_);
  }
}

// Moves less, as long as nothing objects: first every cluster less far, then fewer vertices. What is tried
// at the same time in different clusters is judged cluster by cluster.
Status Repair::shrink() {
  // Counted, not timed: the same result on every machine.
  double work = 0;
  const auto work_left = [&] {
    return out_.shrink_rounds < options_.max_shrink_rounds && work < options_.shrink_work;
  };
  // Judges what compose() makes; returns the clusters that must go back.
  const auto judge = [&](std::vector<char>& bad) -> Status {
    compose();
    ++out_.shrink_rounds;
    if (Status s = look(false); !s) return s;
    work += static_cast<double>(diagnosis_.pairs.size()) + 0.01 * static_cast<double>(now_.F.rows());
    bad.assign(clusters_.size(), 0);
    for (const Offence& o : offences_) {
      bool known = false;
      for (std::size_t c = 0; c < clusters_.size(); ++c)
        if (within(clusters_[c], o, 1)) bad[c] = 1, known = true;
      if (!known) bad.assign(clusters_.size(), 1);
    }
    return success();
  };
  std::vector<Cluster> good = clusters_;
  std::vector<char> bad;
  std::vector<double> low(clusters_.size(), 0), high(clusters_.size(), 1);
  for (int i = 0; i < 4 && work_left(); ++i) {
    for (std::size_t c = 0; c < clusters_.size(); ++c) clusters_[c].part = (low[c] + high[c]) / 2;
    if (Status s = judge(bad); !s) return s;
    const bool clean = offences_.empty();
    for (std::size_t c = 0; c < clusters_.size(); ++c) (bad[c] ? low : high)[c] = clusters_[c].part;
    if (clean) good = clusters_;
    // Together they must still be fine: kept only when a later judgement of `high` says so.
    for (std::size_t c = 0; c < clusters_.size(); ++c) clusters_[c].part = high[c];
    if (!clean) {
      if (Status s = judge(bad); !s) return s;
      if (offences_.empty()) good = clusters_;
    }
  }
  clusters_ = good;
  // Vertices: batches of each cluster that halve when refused, smallest moves first.
  struct Trial {
    std::vector<Index> order;
    std::size_t at = 0, size = 1;
  };
  std::vector<Trial> trials(clusters_.size());
  for (std::size_t c = 0; c < clusters_.size(); ++c) {
    const Cluster& x = clusters_[c];
    std::vector<std::pair<double, Index>> order;
    for (std::size_t i = 0; i < x.region.size(); ++i)
      order.emplace_back((x.to.row(static_cast<Eigen::Index>(i)) - input_.V.row(x.region[i])).norm(),
                         x.region[i]);
    std::sort(order.begin(), order.end());
    for (const auto& [length, v] : order) trials[c].order.push_back(v);
    trials[c].size = std::max<std::size_t>(1, order.size() / 2);
  }
  while (work_left()) {
    bool any = false;
    for (std::size_t c = 0; c < clusters_.size(); ++c) {
      Trial& t = trials[c];
      const std::size_t last = std::min(t.at + t.size, t.order.size());
      std::vector<Index>& held = clusters_[c].held;
      for (std::size_t i = t.at; i < last; ++i) held.push_back(t.order[i]), any = true;
      std::sort(held.begin(), held.end());
    }
    if (!any) break;
    if (Status s = judge(bad); !s) return s;
    const bool clean = offences_.empty();
    for (std::size_t c = 0; c < clusters_.size(); ++c) {
      Trial& t = trials[c];
      if (!bad[c]) {
        t.at = std::min(t.at + t.size, t.order.size());
        continue;
      }
      clusters_[c].held = good[c].held;
      if (t.size > 1)
        t.size = (t.size + 1) / 2;
      else
        t.at = std::min(t.at + 1, t.order.size());
    }
    if (!clean) {
      if (Status s = judge(bad); !s) return s;
      if (!offences_.empty()) {
        clusters_ = good;  // accepted one by one, refused together
        for (Trial& t : trials) t.size = std::max<std::size_t>(1, t.size / 2), t.at = 0;
        continue;
      }
    }
    good = clusters_;
  }
  clusters_ = good;
  compose();
  return look(false);
}

Result<RepairResult> Repair::run() {
  now_ = input_;
  if (Result<SurfaceTopology> t = require_topology(input_); !t) return t.error();
  rings_.emplace(static_cast<Index>(input_.V.rows()), input_.F);
  diagonal_ = (input_.V.colwise().maxCoeff() - input_.V.colwise().minCoeff()).norm();
  if (Status s = look(true); !s) return s.error();
  const auto add_round = [&] {
    record();
    RepairRound r;
    r.offences = static_cast<Index>(offences_.size());
    r.clusters = static_cast<Index>(clusters_.size());
    for (const Cluster& c : clusters_)
      r.open_clusters += std::any_of(offences_.begin(), offences_.end(),
                                     [&](const Offence& o) { return sorted_share(c.region, o); });
    r.moved = static_cast<Index>(out_.moved.size());
    r.max_relative = out_.max_relative;
    r.verdict = verdict_name(diagnosis_.verdict);
    context_.report("repair", static_cast<double>(out_.rounds.size()) / options_.max_rounds,
                    std::to_string(r.offences) + " left, " + std::to_string(r.moved) + " vertices moved");
    out_.rounds.push_back(std::move(r));
  };
  add_round();
  if (!options_.places.empty() && diagnosis_.topology.ok()) {
    // The hinges nearest to each place, else the nearest vertex.
    for (const Eigen::Vector3d& p : options_.places) {
      std::vector<std::pair<double, Index>> near;
      for (const Hinge& h : diagnosis_.hinges)
        near.emplace_back((input_.V.row(h.vertex).transpose() - p).norm(), h.vertex);
      std::sort(near.begin(), near.end());
      Offence seeds;
      for (const auto& [d, v] : near)
        if (d <= 2 * near[0].first + 1e-12 * diagonal_ && d < 0.05 * diagonal_) seeds.push_back(v);
      if (seeds.empty()) {
        Index nearest = 0;
        (input_.V.rowwise() - p.transpose()).rowwise().squaredNorm().minCoeff(&nearest);
        seeds.push_back(nearest);
      }
      std::sort(seeds.begin(), seeds.end());
      bool known = false;
      for (Cluster& c : clusters_)
        if (sorted_share(c.seeds, seeds)) {
          std::vector<Index> all;
          std::set_union(c.seeds.begin(), c.seeds.end(), seeds.begin(), seeds.end(), std::back_inserter(all));
          c.seeds = std::move(all);
          ++c.level;
          known = true;
        }
      if (known) continue;
      clusters_.emplace_back();
      clusters_.back().seeds = std::move(seeds);
      clusters_.back().level = 1;
    }
  }
  if (clusters_.empty() && offences_.empty()) {
    out_.surface = now_;
    out_.diagnosis = std::move(diagnosis_);
    out_.termination = "nothing to repair";
    return std::move(out_);
  }
  const bool asked = !clusters_.empty();
  while (!offences_.empty() || (asked && out_.rounds.size() == 1)) {
    if (hopeless_)
      return Error{ErrorCode::infeasible,
                   diagnosis_.message + " Moving vertices a little does not help: a component faces inwards."};
    if (static_cast<int>(out_.rounds.size()) > options_.max_rounds) break;
    assign();
    if (std::any_of(clusters_.begin(), clusters_.end(),
                    [](const Cluster& c) { return c.level >= kLevels; }))
      break;
    merge_overlapping();
    compose();
    if (Status s = look(out_.rounds.size() % 4 == 0); !s) return s.error();
    add_round();
  }
  if (!offences_.empty()) {
    const Index v = offences_[0][0];
    return Error{ErrorCode::infeasible,
                 "The surface could not be repaired by moving vertices by at most " +
                     std::to_string(options_.max_relative_move) + " of its diagonal; the first of " +
                     std::to_string(offences_.size()) + " places left is at vertex " + std::to_string(v) +
                     ". " + diagnosis_.message};
  }
  if (!asked)
    if (Status s = shrink(); !s) return s.error();
  record();
  out_.surface = now_;
  out_.diagnosis = std::move(diagnosis_);
  out_.termination = "feasible";
  return std::move(out_);
}

}  // namespace

Status RepairOptions::validate() const {
  if (!(max_relative_move > 0 && max_relative_move <= 1))
    return Error{ErrorCode::usage, "The largest move must be a part of the diagonal between 0 and 1."};
  if (max_rounds < 1 || max_shrink_rounds < 0 || !(shrink_work >= 0))
    return Error{ErrorCode::usage, "The numbers of rounds of a repair must be positive."};
  return success();
}

Result<RepairResult> repair(const Surface& surface, const RepairOptions& options, const RunContext& context) {
  if (Status valid = options.validate(); !valid) return valid.error();
  return Repair(surface, options, context).run();
}

}  // namespace overtet
