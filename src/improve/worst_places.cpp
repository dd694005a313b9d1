#include "src/improve/worst_places.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <functional>
#include <queue>
#include <random>
#include <utility>
#include <vector>

#include "kernels/core/tet_tables.h"
#include "kernels/core/tuning.h"
#include "kernels/parallel/counts.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "kernels/tet_energy/tet_quality.h"
#include "src/improve/bad_tets.h"
#include "src/improve/layers.h"
#include "src/improve/tuning.h"
#include "src/mesh/local_operations.h"
#include "src/mesh/partition.h"

namespace overtet {

namespace {

using Eigen::Vector3d;

// The qualities below the goal, the worst first.
std::vector<double> low_qualities(const LocalOperations& work, double goal) {
  std::vector<double> low;
  for (Index t = 0; t < work.mesh().tet_capacity(); ++t)
    if (work.mesh().alive(t) && work.quality(t) < goal) low.push_back(work.quality(t));
  std::sort(low.begin(), low.end());
  return low;
}

// The first that differs is better by this factor.
bool better(const std::vector<double>& now, const std::vector<double>& before, double factor = kBetter) {
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (i == now.size() || now[i] > before[i] * factor) return true;
    if (now[i] < before[i]) return false;
  }
  return false;
}

// What may make things worse at first. i, j, n: corners of the tet, or the number of a place.
struct Change {
  enum class Kind { none, split_edge, split_face, split_tet, remove_edge, rebuild_star, remove_vertex };
  Kind kind;
  int i = 0, j = 0, n = 0;
};

std::vector<Change> changes_for(const LocalOperations& work, Index t) {
  using Kind = Change::Kind;
  std::vector<Change> changes{{Kind::none}};
  for (const auto& e : kTetEdge) changes.push_back({Kind::split_edge, e[0], e[1]});
  for (int i = 0; i < 4; ++i) changes.push_back({Kind::split_face, i});
  changes.push_back({Kind::split_tet});
  for (const auto& e : kTetEdge) changes.push_back({Kind::remove_edge, e[0], e[1]});
  for (int i = 0; i < 4; ++i) {
    if (work.fixed(work.mesh().tet(t)[i])) continue;
    for (int j = 0; j < 4; ++j)
      for (int n = 0; n < 4 && j != i; ++n) changes.push_back({Kind::rebuild_star, i, j, n});
    changes.push_back({Kind::remove_vertex, i});
  }
  return changes;
}

bool apply(LocalOperations& work, Index t, const Change& change, double enough) {
  const TetComplex& mesh = work.mesh();
  const auto c = mesh.tet(t);
  const auto at = [&](int k) -> const Vector3d& { return mesh.position(c[k]); };
  const int i = change.i, j = change.j;
  switch (change.kind) {
    case Change::Kind::none:
      return true;
    case Change::Kind::split_edge:
      return work.split_edge(c[i], c[j], (at(i) + at(j)) / 2);
    case Change::Kind::split_face:
      return work.split_face(t, i, (at((i + 1) % 4) + at((i + 2) % 4) + at((i + 3) % 4)) / 3);
    case Change::Kind::split_tet:
      return work.split_tet(t, (at(0) + at(1) + at(2) + at(3)) / 4);
    case Change::Kind::remove_edge:
      return work.remove_edge(t, c[i], c[j], enough);
    case Change::Kind::remove_vertex:
      return work.remove_vertex(c[i], enough);
    case Change::Kind::rebuild_star: {
      std::vector<Index> star;
      mesh.star(c[i], star);
      Vector3d sum = Vector3d::Zero();
      for (const Index s : star)
        for (const Index v : mesh.tet(s)) sum += mesh.position(v) - at(i);
      std::array<Index, 3> face{c[i], -1, -1};
      for (int k = 0, n = 1; k < 4; ++k)
        if (k != i && k != j) face[n++] = c[k];
      const Vector3d to = at(i) + kTowardsMiddle[change.n] / (3.0 * static_cast<double>(star.size())) * sum;
      return work.rebuild_star(c[i], face, to, enough);
    }
  }
  return false;
}

// Makes the tets below the goal better, the worst first; those below `need` by dear means, too, which is
// given up after a few in vain. Returns how many these were, at most most_dear.
struct Measures {
  bool refill, insert_around;  // the dearest ones are among them
};
int mend(LocalOperations& work, double need, double goal, int most_dear, const Measures& measures) {
  const TetComplex& mesh = work.mesh();
  std::vector<char> stuck(mesh.tet_capacity(), 0);
  work.be_thorough();
  const auto changed = [&] {
    stuck.resize(mesh.tet_capacity(), 0);
    for (const Index t : work.changed()) {
      stuck[t] = 0;
      for (int k = 0; k < 4; ++k)
        if (const Index u = mesh.neighbour(t, k); u >= 0) stuck[u] = 0;
    }
    return true;
  };
  int dear = 0;
  for (int mended = 0; mended < kTries; ++mended) {
    Index t = -1;
    double least = goal;
    for (Index s = 0; s < mesh.tet_capacity(); ++s) {
      if (!mesh.alive(s) || stuck[s] || !(work.quality(s) < least)) continue;
      const auto& c = mesh.tet(s);
      if (std::any_of(c.begin(), c.end(), [&](Index v) { return work.shared(v); })) continue;
      least = work.quality(s);
      t = s;
    }
    if (t < 0) break;
    const auto c = mesh.tet(t);
    bool done = false;
    for (const auto& [i, j] : kTetEdge)
      if (!done && work.remove_edge(t, c[i], c[j])) done = changed();
    for (int k = 0; k < 4 && !done; ++k)
      if (work.flip_23(t, k)) done = changed();
    if (done) continue;
    bool moved = false;
    for (const Index v : c)
      if (work.quality(t) < goal && work.smooth(v)) moved = changed();
    if (!(work.quality(t) < goal)) continue;
    for (const auto& [i, j] : kTetEdge)
      if (!done && (work.collapse(c[i], c[j]) || work.collapse(c[j], c[i]))) done = changed();
    if (!done && work.quality(t) < need) {
      if (dear == most_dear) break;
      if (measures.refill && work.reconnect(t)) done = changed();
      for (const auto& [i, j] : kTetEdge)
        if (!done && work.insert_at_edge(t, c[i], c[j])) done = changed();
      if (!done && work.insert_at_tet(t)) done = changed();
      if (!done && measures.insert_around && work.insert_around(t)) done = changed();
      if (!done) ++dear;
    }
    if (!done && !moved) stuck[t] = 1;
  }
  return dear;
}

struct Trial {
  MeshPart part;
  bool better = false;
  int spent = 0;
};

// All threads try trials; what counts is the first one that helps, as if they were tried one by one: start
// becomes its part then. False where none helps or no effort is left.
template <class Try>
bool first_that_helps(MeshPart& start, std::int64_t count, std::int64_t& effort_left, Try&& attempt) {
  for (std::int64_t first = 0; first < count && effort_left > 0; first += kTrials) {
    std::array<Trial, kTrials> trials;
    std::atomic<std::int64_t> helps = kTrials;
    const std::int64_t here = std::min(kTrials, count - first);
    parallel_tasks(here, [&](std::int64_t i) {
      if (helps < i) return;
      trials[i].part = start;
      attempt(first + i, trials[i]);
      if (!trials[i].better) return;
      for (std::int64_t known = helps; i < known && !helps.compare_exchange_weak(known, i);) {
      }
    });
    for (std::int64_t i = 0; i < here && effort_left > 0; ++i) {
      effort_left -= trials[i].spent;
      if (!trials[i].better) continue;
      start = std::move(trials[i].part);
      return true;
    }
  }
  return false;
}

// What is left of the attempts that may be made.
struct Effort {
  std::int64_t dear;   // by dear means
  std::int64_t steps;  // of walks
  std::int64_t lifts;
};

// The worst tet, or any other one below the goal, or a neighbour; -1 where there is none.
Index some_bad(const LocalOperations& work, double goal, std::mt19937& random) {
  const TetComplex& mesh = work.mesh();
  std::vector<std::pair<double, Index>> low;
  for (Index t = 0; t < mesh.tet_capacity(); ++t) {
    if (!mesh.alive(t) || !(work.quality(t) < goal)) continue;
    const auto& c = mesh.tet(t);
    if (std::none_of(c.begin(), c.end(), [&](Index v) { return work.shared(v); }))
      low.emplace_back(work.quality(t), t);
  }
  if (low.empty()) return -1;
  const auto worst = std::min_element(low.begin(), low.end());
  const Index t = random() % 2 ? worst->second : low[random() % low.size()].second;
  const Index u = mesh.neighbour(t, static_cast<int>(random() % 4));
  return u >= 0 && random() % 3 == 0 ? u : t;
}

// A part of the mesh with some of the worst tets, and what is known of its tets. More than 12 members: some
// are room that is kept from one tet to the next.
class Place {
 public:
  Place(MeshPart part, double target) : part_(std::move(part)), target_(target) {
    kind_.assign(part_.vertex.size(), 0);
    for (const Index v : part_.shared) kind_[v] = 1;
    for (const Index v : part_.pinched) kind_[v] = 2;
    const TetComplex& complex = part_.complex;
    count(Count::touched_tets, complex.tet_count());
    for (Index t = 0; t < complex.tet_capacity(); ++t)
      if (complex.alive(t)) rate(t);
  }

  // What came of one run.
  struct Outcome {
    Effort left;
    double resisted = 1;  // the quality of the tet that did not get better
    int lifts = 0;
  };

  // The worst tet below `below` again and again, until one resists: others that get better do not lift the
  // least angle then.
  Outcome run(double below, const Effort& left, const RunContext& context) {
    Outcome out{left};
    while (out.left.lifts > 0 && out.left.steps > 0 && !context.stop()) {
      const Index worst = worst_tet(below);
      if (worst < 0) break;
      if (!lift(worst, out.left)) {
        out.resisted = quality_[worst];
        break;
      }
      ++out.lifts;
      --out.left.lifts;
    }
    changed_ = changed_ || out.lifts > 0;
    return out;
  }

  // Of the tets that do not touch the rim; the target where none is below it.
  double worst_quality() {
    const Index t = worst_tet(target_);
    return t < 0 ? target_ : quality_[t];
  }
  bool changed() const { return changed_; }
  MeshPart take() { return std::move(part_); }

 private:
  // The worst tet that does not touch the rim, -1 where none is below.
  Index worst_tet(double below) {
    const TetComplex& complex = part_.complex;
    for (; !worst_.empty() && worst_.top().first < below; worst_.pop()) {
      const auto [q, t] = worst_.top();
      if (complex.alive(t) && quality_[t] == q) return t;
    }
    return -1;
  }

  int kind_of(Index v) const { return v < static_cast<Index>(kind_.size()) ? kind_[v] : 0; }

  void rate(Index t) {
    const TetComplex& complex = part_.complex;
    const auto& c = complex.tet(t);
    quality_.resize(complex.tet_capacity());
    quality_[t] = min_dihedral_sine(complex.position(c[0]), complex.position(c[1]), complex.position(c[2]),
                                    complex.position(c[3]));
    if (quality_[t] < target_ && std::none_of(c.begin(), c.end(), [&](Index v) { return kind_of(v) != 0; }))
      worst_.emplace(quality_[t], t);
  }

  // The tets within some layers around t, t first.
  std::vector<Index> patch_around(Index t, int layers) {
    const TetComplex& complex = part_.complex;
    std::vector<Index> patch{t}, star;
    seen_.resize(complex.tet_capacity(), 0);
    spread_.resize(complex.vertex_count(), 0);
    seen_[t] = 1;
    std::vector<Index> begun;
    for (std::size_t layer = 0, first = 0; layer < static_cast<std::size_t>(layers); ++layer) {
      const std::size_t end = patch.size();
      for (; first < end; ++first)
        for (const Index v : complex.tet(patch[first])) {
          if (std::exchange(spread_[v], 1)) continue;
          begun.push_back(v);
          complex.star(v, star);
          if (layer > 0 && star.size() > static_cast<std::size_t>(kLargestStar)) continue;
          for (const Index s : star)
            if (!std::exchange(seen_[s], 1)) patch.push_back(s);
        }
    }
    for (const Index s : patch) seen_[s] = 0;
    for (const Index v : begun) spread_[v] = 0;
    return patch;
  }

  // With few layers around it, or else with more.
  bool lift(Index t, Effort& left) {
    return std::any_of(std::begin(kPatchLayers), std::end(kPatchLayers),
                       [&](int layers) { return lift(t, layers, left); });
  }
  bool lift(Index t, int layers, Effort& left);

  MeshPart part_;
  const double target_;
  std::vector<char> kind_;  // of the part's first vertices, 1: shared with other parts, 2: pinched
  bool changed_ = false;
  std::vector<double> quality_;
  using Rated = std::pair<double, Index>;
  std::priority_queue<Rated, std::vector<Rated>, std::greater<>> worst_;  // below the target; stale ones, too
  std::vector<char> seen_, spread_;
};

bool Place::lift(Index t, int layers, Effort& left) {
  TetComplex& complex = part_.complex;
  const double worst = quality_[t], goal = std::min(target_, kGoal * worst);
  const std::vector<Index> tets = patch_around(t, layers);
  MeshPart start = take_part(complex, tets);
  for (Index v = 0; v < static_cast<Index>(start.vertex.size()); ++v) {
    const int kind = kind_of(start.vertex[v]);
    if (kind > 0) start.shared.push_back(v);
    if (kind > 1) start.pinched.push_back(v);
  }
  constexpr Index at = 0;  // t in the patch
  std::vector<double> before;
  std::vector<Change> changes;
  {
    const LocalOperations work(start.complex);
    before = low_qualities(work, goal);
    changes = changes_for(work, at);
  }
  const auto one_change = [&](std::int64_t i, Trial& trial) {
    LocalOperations work(trial.part.complex);
    trial.part.mark_shared(work);
    if (!apply(work, at, changes[i], kChangeMayFallTo * worst)) return;
    trial.spent = mend(work, kBetter * worst, goal, kInVain, {true, true});
    trial.better = better(low_qualities(work, goal), before);
  };
  const auto walk = [&](std::int64_t i, Trial& trial) {
    LocalOperations work(trial.part.complex);
    trial.part.mark_shared(work);
    std::mt19937 random(static_cast<unsigned>(i));
    for (int step = 0; step < kWalkLength && !trial.better; ++step) {
      ++trial.spent;
      const Index s = some_bad(work, goal, random);
      if (s < 0) return;
      const std::vector<Change> all = changes_for(work, s);
      int draws = 0;
      while (!apply(work, s, all[1 + random() % (all.size() - 1)], kChangeMayFallTo * worst))
        if (++draws == kDraws) break;
      if (draws == kDraws) continue;
      mend(work, kBetter * worst, std::min(target_, kNearWorst * worst), kInVain, {false, i % 3 == 2});
      const std::vector<double> now = low_qualities(work, goal);
      trial.better = better(now, before);
      if (!now.empty() && now.front() < kChangeMayFallTo * worst) return;
    }
  };
  if (!first_that_helps(start, static_cast<std::int64_t>(changes.size()), left.dear, one_change) &&
      !first_that_helps(start, kTries, left.steps, walk))
    return false;
  std::vector<Index> created;
  put_part(complex, tets, start, created);
  for (const Index s : created) rate(s);
  return true;
}

// Lifts the worst tets of places of which none shares a vertex with another one, until one resists, or all
// are at `limit`. Each time those within a factor of the very worst, more places at the same time the longer
// that goes well: what is done beside a tet that resists is in vain. The order of the places counts, not who
// was done first.
int lift(std::vector<Place>& places, double limit, Effort& left, double& resisted,
         const RunContext& context) {
  std::priority_queue<std::pair<double, std::size_t>, std::vector<std::pair<double, std::size_t>>,
                      std::greater<>>
      worst;
  for (std::size_t p = 0; p < places.size(); ++p) worst.emplace(places[p].worst_quality(), p);
  int lifts = 0;
  for (std::size_t at_once = 1; left.lifts > 0 && left.steps > 0 && !context.stop();) {
    const double least = worst.top().first;
    if (!(least < limit) || least > kSameQuality * resisted) break;
    const double below = std::min(limit, kNearWorst * least);
    std::vector<std::size_t> these;
    for (; !worst.empty() && worst.top().first < below && these.size() < at_once; worst.pop())
      these.push_back(worst.top().second);
    std::vector<Place::Outcome> outcomes(these.size());
    parallel_tasks(std::ssize(these),
                   [&](std::int64_t i) { outcomes[i] = places[these[i]].run(below, left, context); });
    const Effort before = left;
    int here = 0;
    for (std::size_t i = 0; i < these.size(); ++i) {
      const Place::Outcome& o = outcomes[i];
      left.dear -= before.dear - o.left.dear;
      left.steps -= before.steps - o.left.steps;
      left.lifts -= before.lifts - o.left.lifts;
      resisted = std::min(resisted, o.resisted);
      here += o.lifts;
      worst.emplace(places[these[i]].worst_quality(), these[i]);
    }
    if (here == 0) break;
    lifts += here;
    at_once = std::min<std::size_t>(2 * at_once, kTrials);
  }
  return lifts;
}

// The worst tets of a mesh, the worst one first; at most so many.
struct WorstTets {
  std::vector<std::pair<double, Index>> tets;
  double next;  // the quality of the first that is left out, or the target
};

WorstTets worst_tets(const TetMesh& mesh, double target, std::int64_t most) {
  WorstTets worst;
  count(Count::touched_tets, mesh.T.rows());
  worst.tets = parallel_collect<std::pair<double, Index>>(
      mesh.T.rows(), kLightGrain, [&](std::int64_t begin, std::int64_t end, auto& out) {
        for (Index t = static_cast<Index>(begin); t < end; ++t)
          if (const double q = quality(mesh, t); q < target) out.emplace_back(q, t);
      });
  worst.next = target;
  if (std::ssize(worst.tets) > most) {
    const auto end = worst.tets.begin() + static_cast<std::ptrdiff_t>(most);
    std::nth_element(worst.tets.begin(), end, worst.tets.end());
    worst.next = end->first;
    worst.tets.erase(end, worst.tets.end());
  }
  std::sort(worst.tets.begin(), worst.tets.end());
  return worst;
}

// Takes the worst tets' places out of the mesh, lifts them, and puts those that have changed back: a few
// passes over the mesh, however many places there are. Returns how many times one got better; resisted: the
// quality of the worst tet that did not, 1 where there is none.
int lift_places(TetMesh& mesh, double target, Effort& left, double& resisted, const RunContext& context) {
  const WorstTets worst = worst_tets(mesh, target, kTaken.of(mesh.T.rows()));
  if (worst.tets.empty() || worst.tets.front().first > kSameQuality * resisted) return 0;
  std::vector<char> near(static_cast<std::size_t>(mesh.V.rows()), 0);
  for (const auto& [q, t] : worst.tets)
    for (int k = 0; k < 4; ++k) near[mesh.T(t, k)] = 1;
  const std::vector<char> chosen = within_layers(mesh, star_sizes(mesh), std::move(near), kRegionLayers);
  int count = 0;
  std::vector<int> part_of = connected_pieces(mesh, chosen, count);
  std::vector<MeshPart> parts = take_parts(mesh, part_of, count);
  std::vector<Place> places;
  for (MeshPart& part : parts) places.emplace_back(std::move(part), target);
  // Not beyond the first tet that stayed behind, but beyond the last that did not.
  const double limit = std::min(target, std::max(worst.next, kBetter * worst.tets.back().first));
  const int lifts = lift(places, limit, left, resisted, context);
  if (lifts == 0) return 0;
  std::vector<MeshPart> changed;
  std::vector<int> number(places.size(), -1);
  for (std::size_t p = 0; p < places.size(); ++p) {
    if (!places[p].changed()) continue;
    number[p] = static_cast<int>(changed.size());
    changed.push_back(places[p].take());
  }
  for (int& p : part_of)
    if (p >= 0) p = number[p];
  put_parts(mesh, part_of, changed);
  return lifts;
}

}  // namespace

int lift_worst(TetMesh& mesh, double target, const RunContext& context) {
  const std::int64_t tets = mesh.T.rows();
  Effort left{kDear.of(tets), kSteps.of(tets), kLifts.of(tets)};
  int lifts = 0;
  double resisted = 1;
  for (int here = 1; here > 0 && left.lifts > 0 && left.steps > 0 && !context.stop(); lifts += here)
    here = lift_places(mesh, target, left, resisted, context);
  return lifts;
}

}  // namespace overtet
