#include "src/repair/repair.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "src/repair/smoothing.h"
#include "src/surface/winding.h"

namespace overtet {

namespace {

// How a vertex that forbids a mesh is moved: with so many rings around it, so much of the way.
enum class Kind { membrane, plate, mirror };
struct Step {
  int rings;
  double part;
  Kind kind;
};

// mirror: what pokes out, inside out, is turned right side out by reflecting it at its own middle plane
// across its thinnest direction; `part` is how thick it is afterwards, 1 being as thick as before.
constexpr Step kLadder[] = {
    {0, 0.1, Kind::membrane}, {0, 0.3, Kind::membrane}, {0, 0.6, Kind::membrane},  {1, 0.3, Kind::membrane},
    {0, 0.9, Kind::membrane}, {1, 0.6, Kind::membrane}, {2, 0.6, Kind::membrane},  {1, 0.9, Kind::membrane},
    {2, 0.9, Kind::membrane}, {1, 1.0, Kind::plate},    {1, 1.0, Kind::membrane},  {2, 1.0, Kind::plate},
    {2, 0.2, Kind::mirror},   {3, 0.7, Kind::mirror},   {3, 0.95, Kind::membrane}, {3, 1.0, Kind::plate},
    {3, 1.0, Kind::membrane}, {5, 0.7, Kind::mirror},   {5, 0.95, Kind::membrane}, {5, 1.0, Kind::plate},
    {5, 1.0, Kind::membrane}, {8, 0.7, Kind::mirror},   {8, 1.0, Kind::plate},     {8, 1.0, Kind::membrane},
    {12, 1.0, Kind::plate},   {12, 1.0, Kind::membrane}, {18, 1.0, Kind::plate},   {18, 1.0, Kind::membrane},
    {27, 1.0, Kind::membrane}};
constexpr int kLevels = static_cast<int>(std::size(kLadder));
constexpr std::size_t kWorthMirroring = 6;  // vertices

// Where nearly everything crosses nearly everything (offences per vertex) the crease is smoothed out at once:
// a little less of it would still be out of reach for a mesh.
constexpr double kDense = 8;
constexpr int kDenseLevel = 18;

constexpr double kFlatFace = 1e-14;  // height over reach below which a face counts as one without area
constexpr std::size_t kFlood = 200000;

// Vertices that forbid a mesh together.
using Offence = std::vector<Index>;

// A connected set of vertices that move, which no other set touches.
struct Cluster {
  std::vector<Index> region;  // sorted
  int level = 0;              // the highest of its vertices'
  VertexMatrix to;            // the region's positions
  double part = 1;            // how much of the way: what the end's shrinking leaves
  std::vector<Index> held;    // of the region: back at their places for good, sorted
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
  void place();
  bool mirror(Cluster& c, const Step& step) const;
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
  std::vector<int> level_;  // of each vertex that forbids a mesh; -1 for the others
  std::vector<char> poking_;  // vertices of the input in front of which the winding number is negative
  bool exhausted_ = false;
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
  hopeless_ = false;
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
    if (poking_.empty()) {
      poking_.assign(now_.V.rows(), 0);
      for (std::size_t i = known; i < all.size(); ++i) poking_[all[i]] = 1;
    }
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

// The vertices of every group of offences, and those of earlier ones next to it, go one step up the ladder.
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
  std::vector<std::size_t> members(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    Offence& g = groups[root(i)];
    ++members[root(i)];
    g.insert(g.end(), offences_[i].begin(), offences_[i].end());
  }
  const std::vector<int> before = level_;
  for (std::size_t group = 0; group < n; ++group) {
    Offence& g = groups[group];
    if (g.empty()) continue;
    std::sort(g.begin(), g.end());
    g.erase(std::unique(g.begin(), g.end()), g.end());
    int level = -1;
    for (const Index v : rings_->grown(g, 1, scratch_)) {
      if (before[v] < 0) continue;
      level_[v] = before[v] + 1;
      level = std::max(level, level_[v]);
    }
    // None next to it: whatever moved it there goes on.
    if (level < 0)
      for (const Cluster& c : clusters_)
        if (sorted_share(c.region, g)) level = std::max(level, c.level + 1);
    const bool dense = level < 0 && static_cast<double>(members[group]) > kDense * static_cast<double>(g.size());
    for (const Index v : g) level_[v] = std::max({level_[v], level, dense ? kDenseLevel : 0});
  }
  for (int& l : level_)
    if (l >= kLevels) {
      exhausted_ = true;
      l = kLevels - 1;
    }
}

// What moves, and where to.
void Repair::place() {
  const auto n = static_cast<std::size_t>(input_.V.rows());
  std::vector<float> part(n, 0);
  std::vector<int> level(n, -1);
  for (int l = 0; l < kLevels; ++l) {
    std::vector<Index> seeds;
    for (std::size_t v = 0; v < n; ++v)
      if (level_[v] == l) seeds.push_back(static_cast<Index>(v));
    if (seeds.empty()) continue;
    for (const Index v : rings_->grown(seeds, kLadder[l].rings, scratch_)) {
      const float p = kLadder[l].kind == Kind::mirror ? 1 : static_cast<float>(kLadder[l].part);
      part[v] = std::max(part[v], p);
      level[v] = l;
    }
  }
  clusters_.clear();
  std::vector<char> seen(n, 0);
  const double limit = options_.max_relative_move * diagonal_ * (1 - 1e-9);
  for (std::size_t first = 0; first < n; ++first) {
    if (level[first] < 0 || seen[first]) continue;
    Cluster c;
    c.region.push_back(static_cast<Index>(first));
    seen[first] = 1;
    for (std::size_t i = 0; i < c.region.size(); ++i)
      for (const Index u : (*rings_)(c.region[i]))
        if (level[u] >= 0 && !seen[u]) seen[u] = 1, c.region.push_back(u);
    std::sort(c.region.begin(), c.region.end());
    for (const Index v : c.region) c.level = std::max(c.level, level[v]);
    const Step& step = kLadder[c.level];
    if (step.kind != Kind::mirror || !mirror(c, step)) {
      std::vector<float> parts;
      for (const Index v : c.region) parts.push_back(part[v]);
      c.to = smoothed(input_.V, input_.V, *rings_, c.region,
                      step.kind == Kind::membrane ? Smoothing::membrane : Smoothing::thin_plate, parts);
      if (c.to.rows() == 0) continue;
    }
    for (std::size_t i = 0; i < c.region.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      const Eigen::RowVector3d from = input_.V.row(c.region[i]), move = c.to.row(k) - from;
      if (const double length = move.norm(); length > limit) c.to.row(k) = from + limit / length * move;
    }
    clusters_.push_back(std::move(c));
  }
}

// Reflects what pokes out in a cluster; the rest of the cluster follows smoothly.
bool Repair::mirror(Cluster& c, const Step& step) const {
  std::vector<Index> out;
  if (poking_.empty()) return false;
  for (const Index v : c.region)
    if (poking_[v]) out.push_back(v);
  if (out.size() < kWorthMirroring) return false;
  Eigen::RowVector3d centre = Eigen::RowVector3d::Zero();
  for (const Index v : out) centre += input_.V.row(v) / static_cast<double>(out.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Index v : out)
    spread += (input_.V.row(v) - centre).transpose() * (input_.V.row(v) - centre);
  // Of the two thinner directions the one that the surface faces: a flat patch is not turned over in its plane.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  const Eigen::RowVector3d across = axes.eigenvectors().col(0).transpose();
  double low = 1e300, high = -1e300;
  for (const Index v : out) {
    const double x = (input_.V.row(v) - centre).dot(across);
    low = std::min(low, x), high = std::max(high, x);
  }
  const double middle = (low + high) / 2;
  // As thick as the allowed move permits.
  const double room = 0.98 * options_.max_relative_move * diagonal_ / std::max((high - low) / 2, 1e-300);
  const double part = std::min(step.part, room - 1);
  if (!(part > 0.02)) return false;
  VertexMatrix moves = VertexMatrix::Zero(input_.V.rows(), 3);
  for (const Index v : out)
    moves.row(v) = -(1 + part) * ((input_.V.row(v) - centre).dot(across) - middle) * across;
  std::vector<Index> rest;
  std::set_difference(c.region.begin(), c.region.end(), out.begin(), out.end(), std::back_inserter(rest));
  if (!rest.empty()) {
    const VertexMatrix follow = smoothed(input_.V, moves, *rings_, rest, Smoothing::membrane);
    if (follow.rows() == 0) return false;
    for (std::size_t i = 0; i < rest.size(); ++i) moves.row(rest[i]) = follow.row(static_cast<Eigen::Index>(i));
  }
  c.to.resize(static_cast<Eigen::Index>(c.region.size()), 3);
  for (std::size_t i = 0; i < c.region.size(); ++i)
    c.to.row(static_cast<Eigen::Index>(i)) = input_.V.row(c.region[i]) + moves.row(c.region[i]);
  return true;
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
  for (std::size_t c = 0; c < clusters_.size(); ++c)
    if (clusters_[c].level >= kDenseLevel) low[c] = 1;  // feasible is not enough there; see kDense
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
  level_.assign(input_.V.rows(), -1);
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
  if (!options_.places.empty()) {
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
      int level = 0;
      for (const Index v : rings_->grown(seeds, 1, scratch_)) level = std::max(level, level_[v] + 2);
      for (const Index v : seeds) level_[v] = std::max(level, 1);
    }
  }
  const auto inside_out = [&] {
    return Error{ErrorCode::infeasible,
                 diagnosis_.message + " Moving vertices a little does not help: a component faces inwards."};
  };
  if (hopeless_) return inside_out();
  const bool asked = !options_.places.empty();
  if (!asked && offences_.empty()) {
    out_.surface = now_;
    out_.diagnosis = std::move(diagnosis_);
    out_.termination = "nothing to repair";
    return std::move(out_);
  }
  while (!offences_.empty() || (asked && out_.rounds.size() == 1)) {
    if (static_cast<int>(out_.rounds.size()) > options_.max_rounds) break;
    assign();
    if (exhausted_) break;
    place();
    compose();
    if (Status s = look(out_.rounds.size() % 4 == 0); !s) return s.error();
    add_round();
  }
  if (hopeless_) return inside_out();
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
