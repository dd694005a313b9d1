#include "src/improve/worst_places.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <random>
#include <utility>
#include <vector>

#include "kernels/core/tet_tables.h"
#include "kernels/core/tuning.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "kernels/tet_energy/tet_quality.h"
#include "src/improve/bad_tets.h"
#include "src/improve/tuning.h"
#include "src/mesh/local_operations.h"
#include "src/mesh/partition.h"

namespace overtet {

namespace {

using Eigen::Vector3d;

using Corners = std::array<Index, 4>;

Corners corners_of(const TetMesh& mesh, Index t) {
  return {mesh.T(t, 0), mesh.T(t, 1), mesh.T(t, 2), mesh.T(t, 3)};
}

// 0 for the tets within some layers around the vertices, -1 for others.
std::vector<int> layers_around(const TetMesh& mesh, std::vector<char> near, int layers) {
  std::vector<int> star(near.size(), 0), part_of(static_cast<std::size_t>(mesh.T.rows()), -1);
  for (Index t = 0; t < mesh.T.rows(); ++t)
    for (const Index v : corners_of(mesh, t)) ++star[v];
  for (int layer = 0; layer < layers; ++layer) {
    for (Index t = 0; t < mesh.T.rows(); ++t)
      for (const Index v : corners_of(mesh, t))
        if (near[v]) part_of[t] = 0;
    if (layer + 1 == layers) break;
    for (Index t = 0; t < mesh.T.rows(); ++t)
      if (part_of[t] == 0)
        for (const Index v : corners_of(mesh, t))
          if (star[v] <= kLargestStar) near[v] = 1;
  }
  return part_of;
}

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

// One tet of a part of the mesh. kind: of the part's first vertices, 1: shared with other parts, 2: pinched
// (src/mesh/partition.h).
bool lift(TetMesh& region, std::span<const char> kind, Index t, double target, int layers, Effort& left) {
  const double worst = quality(region, t), goal = std::min(target, kGoal * worst);
  const Corners corners = corners_of(region, t);
  std::vector<char> near(static_cast<std::size_t>(region.V.rows()), 0);
  for (const Index v : corners) near[v] = 1;
  const std::vector<int> part_of = layers_around(region, near, layers);
  std::vector<MeshPart> patch = take_parts(region, part_of, 1);
  MeshPart& start = patch[0];
  for (Index v = 0; v < static_cast<Index>(start.vertex.size()); ++v) {
    const Index in_region = start.vertex[v];
    if (in_region >= static_cast<Index>(kind.size()) || kind[in_region] == 0) continue;
    start.shared.push_back(v);
    if (kind[in_region] > 1) start.pinched.push_back(v);
  }
  Index at = 0;
  const auto is_it = [&](Index s) {
    for (int k = 0; k < 4; ++k)
      if (std::find(corners.begin(), corners.end(), start.vertex[start.complex.tet(s)[k]]) == corners.end())
        return false;
    return true;
  };
  while (!is_it(at)) ++at;

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
      mend(work, kBetter * worst, std::min(target, kNearWorst * worst), kInVain, {false, i % 3 == 2});
      const std::vector<double> low = low_qualities(work, goal);
      trial.better = better(low, before);
      if (!low.empty() && low.front() < kChangeMayFallTo * worst) return;
    }
  };
  if (!first_that_helps(start, static_cast<std::int64_t>(changes.size()), left.dear, one_change) &&
      !first_that_helps(start, kTries, left.steps, walk))
    return false;
  put_parts(region, part_of, patch);
  return true;
}

// The worst tet below `below` again and again, until one resists: others that get better do not lift the
// least angle then. See lift() for kind; resisted: becomes the quality of that tet, where that is less.
int lift_region(TetMesh& region, std::span<const char> kind, double below, double target, int layers,
                Effort& left, double& resisted, const RunContext& context) {
  const auto at_rim = [&](const Corners& c) {
    return std::any_of(c.begin(), c.end(),
                       [&](Index v) { return v < static_cast<Index>(kind.size()) && kind[v] != 0; });
  };
  int lifts = 0;
  while (left.lifts > 0 && left.steps > 0 && !context.stop()) {
    Index worst = -1;
    double least = below;
    for (Index t = 0; t < region.T.rows(); ++t)
      if (const double q = quality(region, t); q < least && !at_rim(corners_of(region, t))) {
        least = q;
        worst = t;
      }
    if (worst < 0) break;
    if (!lift(region, kind, worst, target, layers, left)) {
      resisted = std::min(resisted, least);
      break;
    }
    ++lifts;
    --left.lifts;
  }
  return lifts;
}

// The worst tets' places. Returns how many times one got better; resisted: the quality of the worst tet that
// did not, 1 where there is none.
int lift_places(TetMesh& mesh, double target, Effort& left, double& resisted, const RunContext& context) {
  using Rated = std::pair<double, Index>;
  std::vector<Rated> bad = parallel_reduce(
      mesh.T.rows(), kLightGrain, std::vector<Rated>{},
      [&](std::int64_t begin, std::int64_t end) {
        std::vector<Rated> here;
        for (Index t = static_cast<Index>(begin); t < end; ++t)
          if (const double q = quality(mesh, t); q < target) here.emplace_back(q, t);
        return here;
      },
      [](std::vector<Rated> x, const std::vector<Rated>& y) {
        x.insert(x.end(), y.begin(), y.end());
        return x;
      });
  if (bad.empty()) return 0;
  const std::size_t places = std::min(static_cast<std::size_t>(kMostPlaces), bad.size());
  std::partial_sort(bad.begin(), bad.begin() + static_cast<std::ptrdiff_t>(places), bad.end());
  if (bad.front().first > kSameQuality * resisted) return 0;
  const double below = std::min(target, kNearWorst * bad.front().first);
  std::vector<char> near(static_cast<std::size_t>(mesh.V.rows()), 0);
  for (std::size_t i = 0; i < places && bad[i].first < below; ++i)
    for (const Index v : corners_of(mesh, bad[i].second)) near[v] = 1;
  const std::vector<int> part_of = layers_around(mesh, near, kRegionLayers);
  std::vector<MeshPart> parts = take_parts(mesh, part_of, 1);
  std::vector<char> kind(parts[0].vertex.size(), 0);
  for (const Index v : parts[0].shared) kind[v] = 1;
  for (const Index v : parts[0].pinched) kind[v] = 2;
  // All vertices that it has now keep their numbers.
  const TetMesh region = parts[0].complex.to_mesh(static_cast<Index>(kind.size()));
  const auto low = [&](const TetMesh& m) {
    std::vector<double> qualities;
    for (Index t = 0; t < m.T.rows(); ++t)
      if (const double q = quality(m, t); q < below) qualities.push_back(q);
    std::sort(qualities.begin(), qualities.end());
    return qualities;
  };

  struct Way {
    TetMesh region;
    Effort left;
    double resisted;
    int lifts = 0;
    std::vector<double> low;
  };
  std::array<Way, std::size(kPatchLayers)> ways;
  parallel_tasks(std::ssize(kPatchLayers), [&](std::int64_t i) {
    Way& way = ways[i];
    way.region = region;
    way.left = left;
    way.resisted = resisted;
    way.lifts =
        lift_region(way.region, kind, below, target, kPatchLayers[i], way.left, way.resisted, context);
    way.low = low(way.region);
  });
  const Way& best = better(ways[1].low, ways[0].low, 1) ? ways[1] : ways[0];
  left = best.left;
  resisted = best.resisted;
  if (best.lifts == 0) return 0;
  parts[0].complex = TetComplex(best.region.V, best.region.T);
  put_parts(mesh, part_of, parts);
  return best.lifts;
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
