#include "src/repair/clusters.h"

#include <algorithm>
#include "kernels/core/union_find.h"

#include "src/repair/tuning.h"

namespace overtet {

namespace {

using Reach = SmoothingStep::Reach;

// How many steps of the ladder come before those of this reach.
constexpr int first_of(Reach reach) {
  int level = 0;
  while (kLadder[level].reach != reach) ++level;
  return level;
}

}  // namespace

Clusters::Clusters(const Surface& input, const VertexRings& rings, const RepairOptions& options,
                   double diagonal, double gentle)
    : input_(input),
      rings_(rings),
      options_(options),
      diagonal_(diagonal),
      gentle_(gentle),
      scratch_(static_cast<std::size_t>(input.V.rows()), 0) {
  clear();
}

void Clusters::clear() {
  all_.clear();
  state_.level.assign(static_cast<std::size_t>(input_.V.rows()), -1);
  state_.pinned.assign(static_cast<std::size_t>(input_.V.rows()), 0);
}

bool Clusters::within(const Cluster& c, const Offence& o, int rings) {
  return sorted_share(rings_.grown(c.region, rings, scratch_), o);
}

// The crease that the seeds are in: all faces joined to them that cross several others of the same crease.
Offence Clusters::crease_around(const Surface& now, const Diagnosis& diagnosis, const Offence& seed) const {
  const Index n = static_cast<Index>(now.F.rows());
  // Faces that cross others, joined where they share an edge: along a plain curve such a strip crosses
  // another strip, in a crease it crosses itself.
  std::vector<char> crosses(static_cast<std::size_t>(n), 0);
  for (const auto& [f, g] : diagnosis.pairs) crosses[f] = crosses[g] = 1;
  UnionFind strips(static_cast<std::size_t>(n));
  const std::vector<Index>& twin = diagnosis.topology.topology.twin;
  for (Index h = 0; h < 3 * n; ++h) {
    const Index f = half_edge_face(h), g = half_edge_face(twin[h]);
    if (crosses[f] && crosses[g]) strips.join(f, g);
  }
  std::vector<int> partners(static_cast<std::size_t>(n), 0);
  for (const auto& [f, g] : diagnosis.pairs)
    if (strips.same(f, g)) ++partners[f], ++partners[g];
  std::vector<char> wanted(static_cast<std::size_t>(n), 0);
  std::vector<char> here(static_cast<std::size_t>(now.V.rows()), 0);
  for (const Index v : seed) here[v] = 1;
  for (Index f = 0; f < n; ++f)
    if (crosses[f] && (here[now.F(f, 0)] || here[now.F(f, 1)] || here[now.F(f, 2)]))
      wanted[strips.root(f)] = 1;
  Offence all = seed;
  for (Index f = 0; f < n; ++f)
    if (partners[f] >= kCreasePartners && wanted[strips.root(f)])
      for (int k = 0; k < 3; ++k) all.push_back(now.F(f, k));
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

// Up the ladder that the vertex is on.
void Clusters::rise(Index v, int steps) {
  const int last =
      (state_.level[v] < first_of(Reach::crease) ? first_of(Reach::crease) : std::ssize(kLadder)) - 1;
  if (state_.level[v] + steps > last) exhausted_ = true;
  state_.level[v] = std::min(state_.level[v] + steps, last);
}

bool Clusters::assign(const Surface& now, const Findings& found, const std::vector<char>& turned_near) {
  exhausted_ = false;
  const std::vector<Offence>& offences = found.offences;
  // Offences that share a vertex or an edge belong together.
  const std::size_t n = offences.size();
  UnionFind sets(n);
  std::vector<Index> first_at(now.V.rows(), -1);
  for (std::size_t i = 0; i < n; ++i)
    for (const Index v : offences[i]) {
      if (first_at[v] < 0) first_at[v] = static_cast<Index>(i);
      sets.join(static_cast<Index>(i), first_at[v]);
    }
  for (std::size_t i = 0; i < n; ++i)
    for (const Index v : offences[i])
      for (const Index u : rings_(v))
        if (first_at[u] >= 0) sets.join(static_cast<Index>(i), first_at[u]);
  std::vector<Offence> groups(n);
  std::vector<std::size_t> members(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const Index root = sets.root(static_cast<Index>(i));
    Offence& g = groups[root];
    ++members[root];
    g.insert(g.end(), offences[i].begin(), offences[i].end());
  }
  const std::vector<int> before = state_.level;
  for (std::size_t group = 0; group < n; ++group) {
    Offence& g = groups[group];
    if (g.empty()) continue;
    std::sort(g.begin(), g.end());
    g.erase(std::unique(g.begin(), g.end()), g.end());
    int level = -1;
    for (const Index v : rings_.grown(g, 1, scratch_)) {
      if (before[v] < 0) continue;
      state_.level[v] = before[v];
      rise(v, 1);
      level = std::max(level, state_.level[v]);
    }
    // None next to it: whatever moved it there goes on.
    if (level < 0)
      for (const Cluster& c : all_)
        if (sorted_share(c.region, g)) {
          if (c.level + 1 == first_of(Reach::crease) || c.level + 1 == std::ssize(kLadder)) exhausted_ = true;
          level = std::max(level, exhausted_ ? c.level : c.level + 1);
        }
    if (level < 0 && static_cast<double>(members[group]) > kDense * static_cast<double>(g.size())) {
      level = first_of(Reach::crease);
      g = crease_around(now, found.diagnosis, g);
    }
    for (const Index v : g) state_.level[v] = std::max({state_.level[v], level, 0});
  }
  for (std::size_t v = 0; v < state_.level.size(); ++v)
    if ((turned_near[v] || (options_.only_gently && state_.level[v] < first_of(Reach::crease))) &&
        state_.level[v] >= first_of(Reach::far))
      exhausted_ = true;
  return !exhausted_;
}

void Clusters::go_on(const VertexMatrix& base, const VertexMatrix& now, const std::vector<Index>& hinges,
                     const std::optional<Eigen::Vector3d>& at) {
  place(base);
  if (!at) {
    for (Index v = 0; v < static_cast<Index>(state_.level.size()); ++v)
      if (state_.level[v] >= 0) rise(v, 1), state_.pinned[v] = 1;
    return;
  }
  // The hinges nearest to the place, else the nearest vertex.
  const Eigen::RowVector3d p = at->transpose();
  std::vector<std::pair<double, Index>> near;
  for (const Index v : hinges) near.emplace_back((now.row(v) - p).norm(), v);
  std::sort(near.begin(), near.end());
  Offence seeds;
  for (const auto& [d, v] : near)
    if (d <= 2 * near[0].first + 1e-12 * diagonal_ && d < 0.05 * diagonal_) seeds.push_back(v);
  if (seeds.empty()) {
    Index nearest = 0;
    (now.rowwise() - p).rowwise().squaredNorm().minCoeff(&nearest);
    seeds.push_back(nearest);
  }
  std::sort(seeds.begin(), seeds.end());
  const std::vector<Index> around = rings_.grown(seeds, 1, scratch_);
  // A crease goes as a whole.
  for (const Cluster& c : all_)
    if (c.level >= first_of(Reach::crease) && sorted_share(c.region, around)) {
      for (const Index v : c.region)
        if (state_.level[v] >= first_of(Reach::crease)) rise(v, 1), state_.pinned[v] = 1;
      return;
    }
  int level = -1;
  for (const Index v : around)
    if (state_.level[v] >= 0) {
      rise(v, 2), state_.pinned[v] = 1;
      level = std::max(level, state_.level[v]);
    }
  for (const Index v : seeds) state_.level[v] = std::max({state_.level[v], level, 1}), state_.pinned[v] = 1;
}

bool Clusters::pinned(const Cluster& c) const {
  return c.level >= first_of(Reach::crease) ||
         std::any_of(c.region.begin(), c.region.end(), [&](Index v) { return state_.pinned[v] != 0; });
}

void Clusters::place(const VertexMatrix& base) {
  const auto n = static_cast<std::size_t>(input_.V.rows());
  std::vector<float> part(n, 0);
  std::vector<int> level(n, -1);
  for (int l = 0; l < std::ssize(kLadder); ++l) {
    std::vector<Index> seeds;
    for (std::size_t v = 0; v < n; ++v)
      if (state_.level[v] == l) seeds.push_back(static_cast<Index>(v));
    if (seeds.empty()) continue;
    for (const Index v : rings_.grown(seeds, kLadder[l].rings, scratch_)) {
      part[v] = std::max(part[v], static_cast<float>(kLadder[l].part));
      level[v] = l;
    }
  }
  all_.clear();
  std::vector<char> seen(n, 0);
  const double limit = options_.max_relative_move * diagonal_ * (1 - 1e-9);
  for (std::size_t first = 0; first < n; ++first) {
    if (level[first] < 0 || seen[first]) continue;
    Cluster c;
    c.region.push_back(static_cast<Index>(first));
    seen[first] = 1;
    for (std::size_t i = 0; i < c.region.size(); ++i)
      for (const Index u : rings_(c.region[i]))
        if (level[u] >= 0 && !seen[u]) seen[u] = 1, c.region.push_back(u);
    std::sort(c.region.begin(), c.region.end());
    for (const Index v : c.region) c.level = std::max(c.level, level[v]);
    const SmoothingStep& step = kLadder[c.level];
    std::vector<float> parts;
    for (const Index v : c.region) parts.push_back(part[v]);
    c.to = smoothed(base, base, rings_, c.region, step.kind, parts);
    if (c.to.rows() == 0) continue;
    for (std::size_t i = 0; i < c.region.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      const Index v = c.region[i];
      const Eigen::RowVector3d from = input_.V.row(v), move = c.to.row(k) - from;
      const double most = step.reach != Reach::gentle
                              ? limit
                              : std::min(limit, std::max(gentle_, (base.row(v) - from).norm()));
      if (const double length = move.norm(); length > most) c.to.row(k) = from + most / length * move;
    }
    all_.push_back(std::move(c));
  }
}

VertexMatrix Clusters::compose(const VertexMatrix& base) const {
  VertexMatrix V = base;
  for (const Cluster& c : all_)
    for (std::size_t i = 0; i < c.region.size(); ++i) {
      const Index v = c.region[i];
      if (std::binary_search(c.held.begin(), c.held.end(), v)) continue;
      if (c.part == 1)
        V.row(v) = c.to.row(static_cast<Eigen::Index>(i));
      else
        V.row(v) += c.part * (c.to.row(static_cast<Eigen::Index>(i)) - base.row(v));
    }
  return V;
}

}  // namespace overtet
