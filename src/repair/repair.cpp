#include "src/repair/repair.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "src/repair/smoothing.h"
#include "src/repair/turning.h"
#include "src/surface/winding.h"

namespace overtet {

struct RepairMemory {
  VertexMatrix base;
  std::vector<int> level;
  std::vector<char> pinned;          // vertices whose clusters are not to be moved less
  std::vector<Index> hinges;         // of the surface that was handed out
  std::vector<VertexMatrix> others;  // other ways of turning its parts, not tried yet
};

namespace {

// How a vertex that forbids a mesh is moved: with so many rings around it, so much of the way; wide: as far
// as moves are allowed at all.
struct Step {
  int rings;
  double part;
  Smoothing kind;
  bool wide;
};

constexpr Smoothing kMembrane = Smoothing::membrane, kPlate = Smoothing::thin_plate;
constexpr Step kLadder[] = {
    // Gently.
    {0, 0.1, kMembrane, false},
    {0, 0.3, kMembrane, false},
    {0, 0.6, kMembrane, false},
    {1, 0.3, kMembrane, false},
    {0, 0.9, kMembrane, false},
    {1, 0.6, kMembrane, false},
    {2, 0.6, kMembrane, false},
    {1, 0.9, kMembrane, false},
    {2, 0.9, kMembrane, false},
    {1, 1.0, kPlate, false},
    {1, 1.0, kMembrane, false},
    {2, 1.0, kPlate, false},
    {3, 0.95, kMembrane, false},
    {3, 1.0, kPlate, false},
    // As far as it takes.
    {0, 0.6, kMembrane, true},
    {0, 0.9, kMembrane, true},
    {1, 0.6, kMembrane, true},
    {1, 0.9, kMembrane, true},
    {2, 0.9, kMembrane, true},
    {1, 1.0, kPlate, true},
    {1, 1.0, kMembrane, true},
    {2, 1.0, kPlate, true},
    {3, 0.95, kMembrane, true},
    {3, 1.0, kPlate, true},
    {3, 1.0, kMembrane, true},
    {5, 0.95, kMembrane, true},
    {5, 1.0, kPlate, true},
    {5, 1.0, kMembrane, true},
    {8, 1.0, kPlate, true},
    {8, 1.0, kMembrane, true},
    {12, 1.0, kPlate, true},
    {12, 1.0, kMembrane, true},
    {18, 1.0, kPlate, true},
    {18, 1.0, kMembrane, true},
    {27, 1.0, kMembrane, true},
    // Creases: less than two rings leaves needles that no mesh generator takes.
    {2, 1.0, kMembrane, true},
    {3, 1.0, kMembrane, true},
    {4, 1.0, kMembrane, true},
    {6, 1.0, kMembrane, true},
    {9, 1.0, kMembrane, true},
    {14, 1.0, kMembrane, true}};
constexpr int kLevels = static_cast<int>(std::size(kLadder));
constexpr int kCreaseLevel = kLevels - 6;

constexpr int kGentleLevel = 13;  // the last of the gentle ones
constexpr int kTurnedRings = 3;   // around turned parts only these are taken

// Creases in which nearly everything crosses nearly everything (offences per vertex) are smoothed as a
// whole, with all faces that cross so many others of the same crease.
constexpr double kDense = 8;
constexpr int kCreasePartners = 4;

// How thick a part is after its turn, the first for choosing directions.
constexpr double kThickness[] = {0.3, 0.2, 0.1, 0.5, 0.05};
constexpr int kFollowers[] = {0, 1, 3, 6};  // rings around it that follow
constexpr int kMostTurns = 6;
constexpr std::size_t kRefined = 3;     // ways of turning a part that are looked at closely
constexpr std::size_t kMostTrials = 8;  // and that are kept

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
  Status turn_parts();
  void let_follow(Turn& turn, int rings) const;
  Offence crease_around(const Offence& seed) const;
  void assign();
  void go_on();
  void place();
  void compose();
  Status shrink();
  bool within(const Cluster& c, const Offence& o, int rings);
  bool pinned(const Cluster& c) const;
  void rise(Index v, int steps);
  void record();

  const Surface& input_;
  const RepairOptions& options_;
  const RunContext& context_;
  std::vector<char> scratch_;
  std::optional<VertexRings> rings_;
  double diagonal_ = 0, gentle_ = 0;

  std::vector<VertexMatrix> bases_;  // ways of turning parts
  VertexMatrix base_;                // the input with its inside-out parts turned: what smoothing starts from
  Surface now_;
  Diagnosis diagnosis_;
  std::vector<Offence> offences_;
  bool hopeless_ = false;   // a component that faces inwards with nothing around it
  std::vector<int> level_;  // of each vertex that forbids a mesh; -1 for the others
  std::vector<char> pinned_;
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
    const double reach =
        std::max({a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff(), c.cwiseAbs().maxCoeff(), offset});
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
  const auto corners = [&](Index f) { return Offence{now_.F(f, 0), now_.F(f, 1), now_.F(f, 2)}; };
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
  for (const Index v : diagnosis_.wound.crowded) offences_.push_back({v});
  for (const Index v : diagnosis_.wound.unfillable) offences_.push_back({v});
  for (const Index v : diagnosis_.wound.unfillable) offences_.push_back({v});
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

// The rings around a turned part go with it, less and less.
void Repair::let_follow(Turn& turn, int rings) const {
  VertexMatrix moves = VertexMatrix::Zero(now_.V.rows(), 3);
  for (std::size_t i = 0; i < turn.vertices.size(); ++i)
    moves.row(turn.vertices[i]) = turn.to.row(static_cast<Eigen::Index>(i)) - now_.V.row(turn.vertices[i]);
  std::vector<char> scratch(static_cast<std::size_t>(now_.V.rows()), 0);
  const std::vector<Index> all = rings_->grown(turn.vertices, rings, scratch);
  std::vector<Index> rest;
  std::set_difference(all.begin(), all.end(), turn.vertices.begin(), turn.vertices.end(),
                      std::back_inserter(rest));
  const VertexMatrix follow = smoothed(now_.V, moves, *rings_, rest, kMembrane);
  if (follow.rows() == 0) return;
  for (std::size_t i = 0; i < rest.size(); ++i) moves.row(rest[i]) = follow.row(static_cast<Eigen::Index>(i));
  turn.vertices = all;
  turn.to.resize(static_cast<Eigen::Index>(all.size()), 3);
  for (std::size_t i = 0; i < all.size(); ++i)
    turn.to.row(static_cast<Eigen::Index>(i)) = now_.V.row(all[i]) + moves.row(all[i]);
}

// Turns parts that are inside out as a whole, as long as that leaves much less to object to. The last part's
// best ways are kept in bases_, the best first.
Status Repair::turn_parts() {
  struct Trial {
    std::size_t left;  // offences
    double farthest;
    const InsideOutPart* part;
    Eigen::Vector3d along;
    VertexMatrix V;
  };
  double work = 0;
  const double limit = options_.max_relative_move * diagonal_ * (1 - 1e-9);
  for (int turns = 0; turns < kMostTurns && diagnosis_.winding.negative_pairs > 0; ++turns) {
    const std::vector<InsideOutPart> parts = inside_out_parts(now_, diagnosis_, context_);
    if (auto stop = context_.stop()) return *stop;
    const VertexMatrix before = now_.V;
    const std::size_t enough = offences_.size() / 2;
    std::vector<Trial> trials;
    const auto sort = [&] {
      std::stable_sort(trials.begin(), trials.end(), [](const Trial& x, const Trial& y) {
        return x.left != y.left ? x.left < y.left : x.farthest < y.farthest;
      });
      if (trials.size() > kMostTrials) trials.resize(kMostTrials);
    };
    const auto attempt = [&](const InsideOutPart& part, const Eigen::Vector3d& along, double thickness,
                             int follow) -> Status {
      if (work > options_.turn_work) return success();
      now_.V = before;
      Turn turn = turned(now_, part, along, thickness, gentle_);
      if (turn.vertices.empty()) return success();
      if (follow > 0) let_follow(turn, follow);
      double far = 0;
      for (std::size_t i = 0; i < turn.vertices.size(); ++i) {
        const auto k = static_cast<Eigen::Index>(i);
        far = std::max(far, (turn.to.row(k) - input_.V.row(turn.vertices[i])).norm());
        now_.V.row(turn.vertices[i]) = turn.to.row(k);
      }
      if (far > limit) return success();
      ++out_.turn_rounds;
      if (Status s = look(false); !s) return s;
      work += static_cast<double>(diagnosis_.pairs.size()) + 0.01 * static_cast<double>(now_.F.rows());
      if (offences_.size() > enough) return success();
      trials.push_back({offences_.size(), far, &part, along, now_.V});
      return success();
    };
    for (const InsideOutPart& part : parts)
      for (const Eigen::Vector3d& along : part.directions)
        if (Status s = attempt(part, along, kThickness[0], 0); !s) return s;
    sort();
    const std::size_t promising = std::min(kRefined, trials.size());
    for (std::size_t i = 0; i < promising; ++i) {
      if (trials[i].left == 0) continue;
      const InsideOutPart& part = *trials[i].part;
      const Eigen::Vector3d along = trials[i].along;
      for (const int follow : kFollowers)
        for (const double thickness : kThickness)
          if (follow > 0 || thickness != kThickness[0])
            if (Status s = attempt(part, along, thickness, follow); !s) return s;
    }
    sort();
    now_.V = before;
    if (trials.empty()) break;
    bases_.clear();
    for (Trial& t : trials) bases_.push_back(std::move(t.V));
    now_.V = bases_[0];
    ++out_.turned_parts;
    if (Status s = look(false); !s) return s;
  }
  return success();
}

// The crease that the seeds are in: all faces joined to them that cross several others of the same crease.
Offence Repair::crease_around(const Offence& seed) const {
  const Index n = static_cast<Index>(now_.F.rows());
  // Faces that cross others, joined where they share an edge: along a plain curve such a strip crosses
  // another strip, in a crease it crosses itself.
  std::vector<char> crosses(static_cast<std::size_t>(n), 0);
  for (const auto& [f, g] : diagnosis_.pairs) crosses[f] = crosses[g] = 1;
  std::vector<Index> parent(static_cast<std::size_t>(n));
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](Index i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  const std::vector<Index>& twin = diagnosis_.topology.topology.twin;
  for (Index h = 0; h < 3 * n; ++h) {
    const Index f = half_edge_face(h), g = half_edge_face(twin[h]);
    if (crosses[f] && crosses[g]) parent[root(f)] = root(g);
  }
  std::vector<int> partners(static_cast<std::size_t>(n), 0);
  for (const auto& [f, g] : diagnosis_.pairs)
    if (root(f) == root(g)) ++partners[f], ++partners[g];
  std::vector<char> wanted(static_cast<std::size_t>(n), 0);
  std::vector<char> here(static_cast<std::size_t>(now_.V.rows()), 0);
  for (const Index v : seed) here[v] = 1;
  for (Index f = 0; f < n; ++f)
    if (crosses[f] && (here[now_.F(f, 0)] || here[now_.F(f, 1)] || here[now_.F(f, 2)])) wanted[root(f)] = 1;
  Offence all = seed;
  for (Index f = 0; f < n; ++f)
    if (partners[f] >= kCreasePartners && wanted[root(f)])
      for (int k = 0; k < 3; ++k) all.push_back(now_.F(f, k));
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

// Up the ladder that the vertex is on.
void Repair::rise(Index v, int steps) {
  const int last = (level_[v] < kCreaseLevel ? kCreaseLevel : kLevels) - 1;
  if (level_[v] + steps > last) exhausted_ = true;
  level_[v] = std::min(level_[v] + steps, last);
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
      level_[v] = before[v];
      rise(v, 1);
      level = std::max(level, level_[v]);
    }
    // None next to it: whatever moved it there goes on.
    if (level < 0)
      for (const Cluster& c : clusters_)
        if (sorted_share(c.region, g)) {
          if (c.level + 1 == kCreaseLevel || c.level + 1 == kLevels) exhausted_ = true;
          level = std::max(level, exhausted_ ? c.level : c.level + 1);
        }
    if (level < 0 && static_cast<double>(members[group]) > kDense * static_cast<double>(g.size())) {
      level = kCreaseLevel;
      g = crease_around(g);
    }
    for (const Index v : g) level_[v] = std::max({level_[v], level, 0});
  }
}

// After a surface of which no mesh was found.
void Repair::go_on() {
  place();
  if (!options_.place) {
    for (Index v = 0; v < static_cast<Index>(level_.size()); ++v)
      if (level_[v] >= 0) rise(v, 1), pinned_[v] = 1;
    return;
  }
  // The hinges nearest to the place, else the nearest vertex.
  const Eigen::RowVector3d p = options_.place->transpose();
  std::vector<std::pair<double, Index>> near;
  if (options_.earlier)
    for (const Index v : options_.earlier->hinges) near.emplace_back((now_.V.row(v) - p).norm(), v);
  else
    for (const Hinge& h : diagnosis_.hinges) near.emplace_back((now_.V.row(h.vertex) - p).norm(), h.vertex);
  std::sort(near.begin(), near.end());
  Offence seeds;
  for (const auto& [d, v] : near)
    if (d <= 2 * near[0].first + 1e-12 * diagonal_ && d < 0.05 * diagonal_) seeds.push_back(v);
  if (seeds.empty()) {
    Index nearest = 0;
    (now_.V.rowwise() - p).rowwise().squaredNorm().minCoeff(&nearest);
    seeds.push_back(nearest);
  }
  std::sort(seeds.begin(), seeds.end());
  const std::vector<Index> around = rings_->grown(seeds, 1, scratch_);
  // A crease goes as a whole.
  for (const Cluster& c : clusters_)
    if (c.level >= kCreaseLevel && sorted_share(c.region, around)) {
      for (const Index v : c.region)
        if (level_[v] >= kCreaseLevel) rise(v, 1), pinned_[v] = 1;
      return;
    }
  int level = -1;
  for (const Index v : around)
    if (level_[v] >= 0) {
      rise(v, 2), pinned_[v] = 1;
      level = std::max(level, level_[v]);
    }
  for (const Index v : seeds) level_[v] = std::max({level_[v], level, 1}), pinned_[v] = 1;
}

bool Repair::pinned(const Cluster& c) const {
  return c.level >= kCreaseLevel ||
         std::any_of(c.region.begin(), c.region.end(), [&](Index v) { return pinned_[v] != 0; });
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
      part[v] = std::max(part[v], static_cast<float>(kLadder[l].part));
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
    std::vector<float> parts;
    for (const Index v : c.region) parts.push_back(part[v]);
    c.to = smoothed(base_, base_, *rings_, c.region, step.kind, parts);
    if (c.to.rows() == 0) continue;
    for (std::size_t i = 0; i < c.region.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      const Index v = c.region[i];
      const Eigen::RowVector3d from = input_.V.row(v), move = c.to.row(k) - from;
      const double most =
          step.wide ? limit : std::min(limit, std::max(gentle_, (base_.row(v) - from).norm()));
      if (const double length = move.norm(); length > most) c.to.row(k) = from + most / length * move;
    }
    clusters_.push_back(std::move(c));
  }
}

// The surface with all clusters' moves.
void Repair::compose() {
  now_.V = base_;
  for (const Cluster& c : clusters_)
    for (std::size_t i = 0; i < c.region.size(); ++i) {
      const Index v = c.region[i];
      if (std::binary_search(c.held.begin(), c.held.end(), v)) continue;
      if (c.part == 1)
        now_.V.row(v) = c.to.row(static_cast<Eigen::Index>(i));
      else
        now_.V.row(v) += c.part * (c.to.row(static_cast<Eigen::Index>(i)) - base_.row(v));
    }
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
    if (pinned(clusters_[c])) low[c] = 1;  // being feasible is not enough there
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
    if (pinned(x)) continue;
    std::vector<std::pair<double, Index>> order;
    for (std::size_t i = 0; i < x.region.size(); ++i)
      order.emplace_back((x.to.row(static_cast<Eigen::Index>(i)) - base_.row(x.region[i])).norm(),
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
  double edges = 0;
  for (Index f = 0; f < input_.F.rows(); ++f)
    edges += (input_.V.row(input_.F(f, 0)) - input_.V.row(input_.F(f, 1))).norm();
  gentle_ = std::min(options_.max_relative_move * diagonal_ * (1 - 1e-9),
                     std::max(options_.gentle_relative_move * diagonal_ * (1 - 1e-9),
                              edges / static_cast<double>(input_.F.rows())));
  base_ = input_.V;
  level_.assign(input_.V.rows(), -1);
  pinned_.assign(input_.V.rows(), 0);
  const bool asked = options_.earlier || options_.place;
  if (options_.earlier) {
    if (options_.earlier->base.rows() != input_.V.rows())
      return Error{ErrorCode::usage, "The earlier repair was one of another surface."};
    base_ = options_.earlier->base;
    level_ = options_.earlier->level;
    pinned_ = options_.earlier->pinned;
    now_.V = base_;
  } else if (asked) {
    if (Status s = look(false); !s) return s.error();
  }
  if (asked) {
    go_on();
    place();
    compose();
  }
  if (Status s = look(!asked); !s) return s.error();
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
  const auto inside_out = [&] {
    return Error{ErrorCode::infeasible,
                 diagnosis_.message + " Moving vertices a little does not help: a component faces inwards."};
  };
  if (hopeless_) return inside_out();
  if (!asked && offences_.empty()) {
    out_.surface = now_;
    out_.diagnosis = std::move(diagnosis_);
    out_.termination = "nothing to repair";
    return std::move(out_);
  }
  // Until nothing objects; next to parts that were turned only gently: what smooths more turns them back.
  std::vector<char> turned_near(static_cast<std::size_t>(input_.V.rows()), 0);
  const auto climb = [&]() -> Status {
    exhausted_ = false;
    for (int round = 0; !offences_.empty() && round < options_.max_rounds; ++round) {
      assign();
      for (std::size_t v = 0; v < level_.size(); ++v)
        if ((turned_near[v] || (options_.only_gently && level_[v] < kCreaseLevel)) &&
            level_[v] > kGentleLevel)
          exhausted_ = true;
      if (exhausted_) break;
      place();
      compose();
      if (Status s = look(out_.rounds.size() % 4 == 0); !s) return s;
      add_round();
    }
    return success();
  };
  const auto from = [&](const VertexMatrix& base) -> Status {
    base_ = base;
    clusters_.clear();
    level_.assign(input_.V.rows(), -1);
    pinned_.assign(input_.V.rows(), 0);
    compose();
    return look(false);
  };
  const auto look_for_turned = [&] {
    Offence seeds;
    for (Index v = 0; v < static_cast<Index>(input_.V.rows()); ++v)
      if (base_.row(v) != input_.V.row(v)) seeds.push_back(v);
    std::fill(turned_near.begin(), turned_near.end(), 0);
    for (const Index v : rings_->grown(seeds, kTurnedRings, scratch_)) turned_near[v] = 1;
  };
  look_for_turned();
  if (Status s = climb(); !s) return s.error();
  if (!offences_.empty() && !hopeless_ && !asked && !options_.only_gently) {
    // Smoothing does not do it: there may be parts to turn over.
    if (Status s = from(input_.V); !s) return s.error();
    if (Status s = turn_parts(); !s) return s.error();
    add_round();
  } else if (options_.earlier) {
    bases_ = options_.earlier->others;
  }
  std::size_t tried = 0;
  for (; tried < bases_.size() && (!offences_.empty() || (tried == 0 && out_.turned_parts > 0)); ++tried) {
    if (Status s = from(bases_[tried]); !s) return s.error();
    look_for_turned();
    if (Status s = climb(); !s) return s.error();
  }
  bases_.erase(bases_.begin(), bases_.begin() + static_cast<std::ptrdiff_t>(tried));
  if (hopeless_) return inside_out();
  if (!offences_.empty()) {
    const Index v = offences_[0][0];
    return Error{ErrorCode::infeasible, "The surface could not be repaired by moving vertices by at most " +
                                            std::to_string(options_.max_relative_move) +
                                            " of its diagonal; the first of " +
                                            std::to_string(offences_.size()) + " places left is at vertex " +
                                            std::to_string(v) + ". " + diagnosis_.message};
  }
  if (Status s = shrink(); !s) return s.error();
  record();
  auto memory = std::make_shared<RepairMemory>();
  memory->base = base_;
  memory->level = level_;
  memory->pinned = pinned_;
  memory->others = std::move(bases_);
  for (const Hinge& h : diagnosis_.hinges) memory->hinges.push_back(h.vertex);
  out_.memory = std::move(memory);
  out_.surface = now_;
  out_.diagnosis = std::move(diagnosis_);
  out_.termination = "feasible";
  return std::move(out_);
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
  return Repair(surface, options, context).run();
}

}  // namespace overtet
