#include "src/forward_flow/forward_flow.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <queue>
#include <set>

#include "kernels/bvh/self_intersections.h"
#include "kernels/contact/contact.h"
#include "kernels/core/assertions.h"
#include "kernels/core/indices.h"
#include "kernels/core/tuning.h"
#include "kernels/core/union_find.h"
#include "kernels/laplacian/laplacian.h"
#include "kernels/laplacian/tuning.h"
#include "kernels/parallel/parallel.h"
#include "kernels/predicates/predicates.h"
#include "kernels/sparse/cholesky.h"
#include "src/mesh/topology.h"

namespace overtet {

namespace {

using Pairs = std::vector<IndexPair>;

SymmetricMatrix laplacian(const Surface& s, FlowWeights weights, double smallest) {
  switch (weights) {
    case FlowWeights::cotangent:
      return cotangent_laplacian(s.V, s.F);
    case FlowWeights::clamped:
      return cotangent_laplacian(s.V, s.F, smallest);
    case FlowWeights::uniform:
      return uniform_laplacian(static_cast<Index>(s.V.rows()), s.F);
    case FlowWeights::intrinsic_delaunay:
      return intrinsic_delaunay_laplacian(s.V, s.F);
  }
  return {};
}

Eigen::RowVector3d centroid(const VertexMatrix& V, const TriangleMatrix& F) {
  const Eigen::VectorXd mass = lumped_mass(V, F);
  const double total = mass.sum();
  return (mass.transpose() * V) / (total > 0 ? total : 1);
}

// Implicit steps of the vertices in `active`; the others are boundary values.
class FlowSystem {
 public:
  // delta: by vertex, relative to the area.
  FlowSystem(const Surface& s, const SymmetricMatrix& L, const std::vector<Index>& active,
             const Eigen::VectorXd& delta, double area)
      : F_(s.F), active_(active), delta_(delta), area_(area) {
    const Index n = static_cast<Index>(s.V.rows());
    local_.assign(n, -1);
    for (std::size_t i = 0; i < active.size(); ++i) local_[active[i]] = static_cast<Index>(i);
    std::vector<Eigen::Triplet<double>> entries;
    for (int c = 0; c < L.outerSize(); ++c) {
      for (SymmetricMatrix::InnerIterator it(L, c); it; ++it) {
        const Index a = local_[it.row()], b = local_[c];
        if (a >= 0 && b >= 0)
          entries.emplace_back(std::max(a, b), std::min(a, b), it.value());
        else if (a >= 0)
          border_.push_back({a, static_cast<Index>(c), it.value()});
        else if (b >= 0)
          border_.push_back({b, static_cast<Index>(it.row()), it.value()});
      }
    }
    const Index m = static_cast<Index>(active.size());
    L_.resize(m, m);
    L_.setFromTriplets(entries.begin(), entries.end());
    L_.makeCompressed();
    Q_ = L_;
    for (Eigen::Index f = 0; f < F_.rows(); ++f)
      if (local_[F_(f, 0)] >= 0 || local_[F_(f, 1)] >= 0 || local_[F_(f, 2)] >= 0) faces_.push_back(f);
  }

  bool analyze() { return factor_.analyze(Q_); }

  // One step from X, in place; false: no factor or not finite (X is then unchanged).
  bool step(VertexMatrix& X) {
    const Index m = static_cast<Index>(active_.size());
    Eigen::VectorXd mass = Eigen::VectorXd::Zero(m);
    for (Eigen::Index f : faces_) {
      const Eigen::RowVector3d a = X.row(F_(f, 0)), b = X.row(F_(f, 1)), c = X.row(F_(f, 2));
      const double third = (b - a).cross(c - a).norm() / 6;
      for (int k = 0; k < 3; ++k)
        if (local_[F_(f, k)] >= 0) mass[local_[F_(f, k)]] += third;
    }
    mass = (mass / area_).cwiseMax(kAreaFloor / X.rows());
    VertexMatrix b(m, 3), y;
    std::copy(L_.valuePtr(), L_.valuePtr() + L_.nonZeros(), Q_.valuePtr());
    for (Index i = 0; i < m; ++i) {
      const double pull = mass[i] / delta_[active_[i]];
      // The diagonal is the first entry of its column in a lower triangle.
      Q_.valuePtr()[Q_.outerIndexPtr()[i]] += pull;
      b.row(i) = pull * X.row(active_[i]);
    }
    for (const Border& e : border_) b.row(e.row) -= e.value * X.row(e.frozen);
    if (!factor_.factor(Q_) || !factor_.solve(b, y) || !y.allFinite()) return false;
    for (Index i = 0; i < m; ++i) X.row(active_[i]) = y.row(i);
    return true;
  }

 private:
  struct Border {
    Index row, frozen;
    double value;
  };
  const TriangleMatrix& F_;
  std::vector<Index> active_, local_;
  std::vector<Eigen::Index> faces_;
  Eigen::VectorXd delta_;
  double area_;
  SymmetricMatrix L_, Q_;
  std::vector<Border> border_;
  SparseCholesky factor_;
};

// Ends a try that no longer gets better: `patience` tests without the relative drop.
class Stagnation {
 public:
  Stagnation(int patience, double drop) : patience_(patience), drop_(drop) {}
  bool stalled(Index pairs) {
    if (best_ < 0 || pairs < best_ * (1 - drop_)) {
      best_ = pairs;
      waited_ = 0;
      return false;
    }
    return ++waited_ >= patience_;
  }

 private:
  int patience_;
  double drop_, best_ = -1;
  int waited_ = 0;
};

struct Cluster {
  std::vector<Index> seeds;  // vertices, ascending
  double radius = 0;
};

struct Edges {
  std::vector<Index> begin, to;
  std::vector<double> length;
};

Edges edge_lengths(const Surface& s) {
  std::vector<std::pair<Index, Index>> list;
  list.reserve(6 * static_cast<std::size_t>(s.F.rows()));
  for (Eigen::Index f = 0; f < s.F.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      list.emplace_back(s.F(f, k), s.F(f, (k + 1) % 3));
      list.emplace_back(s.F(f, (k + 1) % 3), s.F(f, k));
    }
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
  Edges e;
  e.begin.assign(static_cast<std::size_t>(s.V.rows()) + 1, 0);
  for (const auto& [a, b] : list) {
    ++e.begin[a + 1];
    e.to.push_back(b);
    e.length.push_back((s.V.row(a) - s.V.row(b)).norm());
  }
  std::partial_sum(e.begin.begin(), e.begin.end(), e.begin.begin());
  return e;
}

// Vertices within `radius` of the seeds along edges. distance: infinity everywhere, and again on return.
std::vector<Index> ball(const Edges& edges, const std::vector<Index>& seeds, double radius,
                        std::vector<double>& distance) {
  std::vector<Index> touched;
  std::priority_queue<std::pair<double, Index>, std::vector<std::pair<double, Index>>, std::greater<>> queue;
  for (Index v : seeds) {
    distance[v] = 0;
    touched.push_back(v);
    queue.push({0, v});
  }
  while (!queue.empty()) {
    const auto [d, v] = queue.top();
    queue.pop();
    if (d > distance[v]) continue;
    for (Index e = edges.begin[v]; e < edges.begin[v + 1]; ++e) {
      const double next = d + edges.length[e];
      const Index w = edges.to[e];
      if (next > radius || next >= distance[w]) continue;
      if (std::isinf(distance[w])) touched.push_back(w);
      distance[w] = next;
      queue.push({next, w});
    }
  }
  for (Index v : touched) distance[v] = std::numeric_limits<double>::infinity();
  std::sort(touched.begin(), touched.end());
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  return touched;
}

void merge_into(Cluster& a, Cluster& b) {
  std::vector<Index> all;
  std::merge(a.seeds.begin(), a.seeds.end(), b.seeds.begin(), b.seeds.end(), std::back_inserter(all));
  all.erase(std::unique(all.begin(), all.end()), all.end());
  a.seeds = std::move(all);
  a.radius = std::max(a.radius, b.radius);
  b.seeds.clear();
}

// Clusters of vertices that are joined by pairs of faces or by a shared vertex.
std::vector<Cluster> cluster_pairs(const Surface& s, const Pairs& pairs, double radius) {
  UnionFind joined(static_cast<std::size_t>(s.V.rows()));
  std::set<Index> seeds;
  for (const IndexPair& p : pairs)
    for (Index f : {p.a, p.b})
      for (int k = 0; k < 3; ++k) {
        seeds.insert(s.F(f, k));
        joined.join(s.F(f, k), s.F(p.a, 0));
      }
  std::map<Index, Cluster> by_root;
  for (const Index v : seeds) by_root[joined.root(v)].seeds.push_back(v);
  std::vector<Cluster> clusters;
  for (auto& [root, cluster] : by_root) {
    cluster.radius = radius;
    clusters.push_back(std::move(cluster));
  }
  return clusters;
}

struct Regions {
  std::vector<Cluster> clusters;
  std::vector<Index> owner;   // by vertex: its cluster, -1: frozen
  std::vector<Index> active;  // ascending
};

// Grows every cluster to its radius; clusters whose regions touch become one, until none do.
Regions grow_regions(const Edges& edges, std::vector<Cluster> clusters, Index vertices) {
  std::vector<double> distance(vertices, std::numeric_limits<double>::infinity());
  Regions r;
  for (bool merged = true; merged;) {
    merged = false;
    r.owner.assign(vertices, -1);
    for (std::size_t c = 0; c < clusters.size(); ++c) {
      if (clusters[c].seeds.empty()) continue;
      for (Index v : ball(edges, clusters[c].seeds, clusters[c].radius, distance)) {
        if (r.owner[v] < 0) {
          r.owner[v] = static_cast<Index>(c);
        } else if (r.owner[v] != static_cast<Index>(c) && !clusters[r.owner[v]].seeds.empty()) {
          merge_into(clusters[c], clusters[r.owner[v]]);
          merged = true;
        }
      }
    }
    std::erase_if(clusters, [](const Cluster& c) { return c.seeds.empty(); });
  }
  for (Index v = 0; v < vertices; ++v)
    if (r.owner[v] >= 0) r.active.push_back(v);
  r.clusters = std::move(clusters);
  return r;
}

class Flow {
 public:
  Flow(const Surface& s, const ForwardFlowOptions& options, const RunContext& context, const Pairs& pairs)
      : s_(s),
        options_(options),
        context_(context),
        pairs_(pairs),
        vertices_(static_cast<Index>(s.V.rows())) {
    area_ = surface_area(s.V, s.F);
  }

  Result<ForwardFlowResult> run() {
    if (pairs_.empty()) {
      result_.V = s_.V;
      result_.active.assign(vertices_, 0);
      result_.reverse_free.assign(vertices_, 0);
      return std::move(result_);
    }
    if (options_.regional) {
      const auto done = regional();
      if (!done) return done.error();
      if (done.value()) return std::move(result_);
    }
    for (const GlobalFlow& way : options_.global) {
      const auto done = global(way);
      if (!done) return done.error();
      if (done.value()) return std::move(result_);
    }
    return Error{ErrorCode::unsolved, "The flow could not remove all crossings: in the input " +
                                          std::to_string(pairs_.size()) +
                                          " pairs of faces intersect, and no later state has fewer than " +
                                          std::to_string(fewest_) + "."};
  }

 private:
  void report(Index pairs, const std::string& how) const {
    context_.report("forward_flow", 1 - static_cast<double>(pairs) / static_cast<double>(pairs_.size()),
                    std::to_string(pairs) + " pairs" + how);
  }

  // Needles flow through each other by the hundred; no later step brings that back.
  bool exploded(Index pairs) const { return pairs > 10 * static_cast<double>(pairs_.size()) + 100; }

  bool still_meets(const VertexMatrix& X, const IndexPair& p) const {
    return faces_intersect(X.data(), s_.F.row(p.a).data(), s_.F.row(p.b).data());
  }

  Pairs still_meeting(const VertexMatrix& X, const Pairs& pairs) const {
    return parallel_collect<IndexPair>(static_cast<std::int64_t>(pairs.size()), 256,
                                       [&](std::int64_t begin, std::int64_t end, Pairs& out) {
                                         for (std::int64_t i = begin; i < end; ++i)
                                           if (still_meets(X, pairs[i])) out.push_back(pairs[i]);
                                       });
  }

  void finish(const VertexMatrix& X, ForwardFlowResult::Termination how, FlowWeights weights,
              const std::vector<Index>& active) {
    result_.termination = how;
    result_.weights = weights;
    result_.V = X;
    result_.active_vertices = active;
    result_.active.assign(vertices_, 0);
    for (Index v : active) result_.active[v] = 1;
    double frozen = 0;
    for (Eigen::Index f = 0; f < s_.F.rows(); ++f) {
      if (result_.active[s_.F(f, 0)] || result_.active[s_.F(f, 1)] || result_.active[s_.F(f, 2)]) continue;
      const Eigen::RowVector3d a = s_.V.row(s_.F(f, 0));
      frozen += (s_.V.row(s_.F(f, 1)) - a).cross(s_.V.row(s_.F(f, 2)) - a).norm() / 2;
    }
    result_.frozen_area = frozen / area_;
    if (options_.keep_states && !result_.states.empty()) result_.states.pop_back();  // that is V_t* itself
  }

  void keep_state(const VertexMatrix& X, const std::vector<Index>& active) {
    if (!options_.keep_states || no_room_) return;
    if (context_.no_room_for(3 * sizeof(double) * active.size())) {
      // The states only help a staged reverse flow; without them the direct one still works.
      no_room_ = true;
      result_.states.clear();
      context_.note(LogLevel::warning,
                    "The forward flow has too little memory to keep its states, so the reverse flow "
                    "starts without them.");
      return;
    }
    VertexMatrix rows(static_cast<Eigen::Index>(active.size()), 3);
    for (std::size_t i = 0; i < active.size(); ++i) rows.row(i) = X.row(active[i]);
    result_.states.push_back(std::move(rows));
  }

  // Moves every cluster back towards its state before the last step, as far as it stays clean: the less
  // a surface has shrunk, the less the reverse flow has to win back.
  void back_up(ContactMesh& mesh, const Regions& regions, const VertexMatrix& before, VertexMatrix& X) {
    const std::size_t count = regions.clusters.size();
    std::vector<double> crossing(count, 0), clean(count, 1);
    const auto blend = [&](const std::vector<double>& part) {
      VertexMatrix Y = X;
      for (Index v : regions.active) {
        const double t = part[regions.owner[v]];
        if (t < 1) Y.row(v) = (1 - t) * before.row(v) + t * X.row(v);
      }
      return Y;
    };
    for (int i = 0; i < options_.bisections; ++i) {
      std::vector<double> middle(count);
      for (std::size_t c = 0; c < count; ++c) middle[c] = 0.5 * (crossing[c] + clean[c]);
      std::vector<char> crosses(count, 0);
      for (const IndexPair& p : mesh.intersections(blend(middle)))
        for (Index f : {p.a, p.b})
          for (int k = 0; k < 3; ++k)
            if (const Index c = regions.owner[s_.F(f, k)]; c >= 0) crosses[c] = 1;
      for (std::size_t c = 0; c < count; ++c) (crosses[c] ? crossing : clean)[c] = middle[c];
    }
    // Each cluster was clean among the others as they were then; together they are tested once more.
    VertexMatrix Y = blend(clean);
    if (Y.allFinite() && mesh.intersections(Y).empty()) X = std::move(Y);
  }

  // True: done. False: give up on regional work.
  Result<bool> regional() {
    const Edges edges = edge_lengths(s_);
    const double root = std::sqrt(area_);
    double mean = 0;
    for (double l : edges.length) mean += l;
    mean /= static_cast<double>(edges.length.size());
    std::vector<Cluster> clusters =
        cluster_pairs(s_, pairs_, std::max(options_.radius * root, options_.radius_edges * mean));
    const SymmetricMatrix L = laplacian(s_, FlowWeights::clamped, options_.smallest_weight);
    for (int attempt = 0; attempt < options_.regional_attempts; ++attempt) {
      if (const auto stop = context_.stop()) return *stop;
      Regions regions = grow_regions(edges, std::move(clusters), vertices_);
      if (static_cast<double>(regions.active.size()) > options_.max_active * vertices_) return false;
      ++result_.attempts;
      auto outcome = attempt_regional(regions, L, root);
      if (!outcome) return outcome.error();
      if (outcome.value()) {
        result_.clusters = static_cast<Index>(regions.clusters.size());
        std::vector<double> distance(vertices_, std::numeric_limits<double>::infinity());
        result_.reverse_free = result_.active;
        for (const Cluster& c : regions.clusters)
          for (Index v : ball(edges, c.seeds, options_.reverse_radius * c.radius, distance))
            result_.reverse_free[v] = 1;
        return true;
      }
      clusters = std::move(regions.clusters);
    }
    return false;
  }

  // What a cluster does in a regional attempt.
  enum class State { running, clean, stalled };

  std::vector<Index> clusters_of(const Regions& regions, const IndexPair& p) const {
    std::vector<Index> list;
    for (Index f : {p.a, p.b})
      for (int k = 0; k < 3; ++k)
        if (const Index c = regions.owner[s_.F(f, k)]; c >= 0 && std::ranges::find(list, c) == list.end())
          list.push_back(c);
    return list;
  }

  std::vector<Index> count_by_cluster(const Regions& regions, const Pairs& pairs) const {
    std::vector<Index> n(regions.clusters.size(), 0);
    for (const IndexPair& p : pairs)
      for (Index c : clusters_of(regions, p)) ++n[c];
    return n;
  }

  // Time steps, by vertex.
  Eigen::VectorXd time_steps(const Regions& regions, double root) const {
    Eigen::VectorXd delta = Eigen::VectorXd::Ones(vertices_);
    for (Index v : regions.active) {
      const double r = regions.clusters[regions.owner[v]].radius / root;
      delta[v] = std::min(options_.regional_delta, options_.regional_delta_radius * r * r);
    }
    return delta;
  }

  // One step of the clusters that run; of all of them where all are clean. before: every cluster as it was
  // before its last step. False: the system cannot be solved.
  static bool step_clusters(FlowSystem& system, const Regions& regions, const std::vector<State>& state,
                            bool all_clean, VertexMatrix& X, VertexMatrix& before) {
    VertexMatrix next = X;
    for (Index v : regions.active)
      if (state[regions.owner[v]] == State::running) before.row(v) = X.row(v);
    if (!system.step(next)) return false;
    // The systems of different clusters do not see each other: who does not run, stays.
    if (!all_clean)
      for (Index v : regions.active)
        if (state[regions.owner[v]] != State::running) next.row(v) = X.row(v);
    X = std::move(next);
    return true;
  }

  // What is left, exactly, decides who grows; frozen faces that were hit become seeds.
  void grow_clusters(Regions& regions, const Pairs& left) const {
    const std::size_t count = regions.clusters.size();
    std::vector<char> grows(count, left.empty() ? 1 : 0);
    for (const IndexPair& p : left) {
      const std::vector<Index> touched = clusters_of(regions, p);
      for (Index c : touched) {
        grows[c] = 1;
        for (Index f : {p.a, p.b})
          for (int k = 0; k < 3; ++k) regions.clusters[c].seeds.push_back(s_.F(f, k));
      }
    }
    for (std::size_t c = 0; c < count; ++c) {
      if (!grows[c]) continue;
      Cluster& cluster = regions.clusters[c];
      cluster.radius *= options_.radius_growth;
      std::sort(cluster.seeds.begin(), cluster.seeds.end());
      cluster.seeds.erase(std::unique(cluster.seeds.begin(), cluster.seeds.end()), cluster.seeds.end());
    }
  }

  void keep_fewest(Index pairs) {
    if (fewest_ < 0 || pairs < fewest_) fewest_ = pairs;
  }

  void record(const ForwardFlowStep& step, const std::string& detail) {
    result_.steps.push_back(step);
    if (step.all_pairs) keep_fewest(step.pairs);
    context_.report("forward_flow", 1 - static_cast<double>(step.pairs) / static_cast<double>(pairs_.size()),
                    std::to_string(step.pairs) + detail);
  }

  // True: clean. False: the clusters that did not become clean have grown.
  Result<bool> attempt_regional(Regions& regions, const SymmetricMatrix& L, double root) {
    const std::size_t count = regions.clusters.size();
    const Eigen::VectorXd delta = time_steps(regions, root);
    double largest_delta = 0;
    for (Index v : regions.active) largest_delta = std::max(largest_delta, delta[v]);
    FlowSystem system(s_, L, regions.active, delta, area_);
    if (!system.analyze())
      return Error{ErrorCode::limit, "There is not enough memory for a factorisation of the forward flow."};
    std::vector<char> free(vertices_, 0);
    for (Index v : regions.active) free[v] = 1;
    ContactMesh mesh(s_.V, s_.F, free);
    std::vector<State> state(count, State::running);
    std::vector<Stagnation> stagnation(count, Stagnation(options_.stall_tests, options_.stall_drop));

    result_.states.clear();
    VertexMatrix X = s_.V, before = X;
    Pairs hits = pairs_;
    int extra = options_.extra_steps, since_full = 0;
    bool clean = false;
    for (int step = 1; step <= options_.regional_steps + options_.extra_steps; ++step) {
      if (const auto stop = context_.stop()) return *stop;
      if (!step_clusters(system, regions, state, clean, X, before)) break;
      keep_state(X, regions.active);

      // Most steps leave some old pair in every running cluster; then nothing else has to be tested.
      Pairs known = still_meeting(X, hits);
      std::vector<Index> n = count_by_cluster(regions, known);
      bool full = ++since_full >= kFullLookEvery;
      for (std::size_t c = 0; c < count; ++c) full = full || (state[c] == State::running && n[c] == 0);
      if (full) {
        known = mesh.intersections(X);
        n = count_by_cluster(regions, known);
        since_full = 0;
      }
      hits = std::move(known);
      const Index pairs = static_cast<Index>(hits.size());
      record({result_.attempts, step, FlowWeights::clamped, largest_delta,
              static_cast<Index>(regions.active.size()), pairs, full},
             " pairs");
      clean = full && pairs == 0;
      if (clean && extra-- <= 0) {
        back_up(mesh, regions, before, X);
        finish(X, ForwardFlowResult::Termination::regional, FlowWeights::clamped, regions.active);
        return true;
      }
      if (clean) continue;
      bool any_running = false;
      for (std::size_t c = 0; c < count; ++c) {
        if (state[c] == State::stalled) continue;
        state[c] = n[c] == 0 ? State::clean : State::running;
        // Its own count may rest while others still move into it, so a clean spell does not reset it.
        // Only full counts are compared with full counts.
        if (full && n[c] > 0 && (stagnation[c].stalled(n[c]) || exploded(n[c]))) state[c] = State::stalled;
        any_running = any_running || state[c] == State::running;
      }
      if (!any_running) break;
    }
    const Pairs left = mesh.intersections(X);
    keep_fewest(static_cast<Index>(left.size()));
    grow_clusters(regions, left);
    return false;
  }

  Result<bool> global(const GlobalFlow& way) {
    ++result_.attempts;
    std::vector<Index> all(vertices_);
    std::iota(all.begin(), all.end(), 0);
    const SymmetricMatrix L = laplacian(s_, way.weights, options_.smallest_weight);
    FlowSystem system(s_, L, all, Eigen::VectorXd::Constant(vertices_, way.delta), area_);
    if (!system.analyze())
      return Error{ErrorCode::limit, "There is not enough memory for a factorisation of the forward flow."};
    ContactMesh mesh(s_.V, s_.F, std::vector<char>(vertices_, 1));
    const Eigen::RowVector3d centre = centroid(s_.V, s_.F);
    Stagnation stagnation(options_.global_stall_tests, options_.stall_drop);
    result_.states.clear();
    VertexMatrix X = s_.V;
    Pairs hits = pairs_;
    int extra = options_.extra_steps, since_full = 0;
    for (int step = 1; step <= way.max_steps + options_.extra_steps; ++step) {
      if (const auto stop = context_.stop()) return *stop;
      if (!system.step(X)) return false;
      const double area = surface_area(X, s_.F);
      if (!(area > 0) || !std::isfinite(area)) return false;
      const Eigen::RowVector3d now = centroid(X, s_.F);
      X = ((X.rowwise() - now) * std::sqrt(area_ / area)).rowwise() + centre;
      if (!X.allFinite()) return false;
      keep_state(X, all);
      Pairs known;
      if (!options_.test_all_pairs) known = still_meeting(X, hits);
      const bool full = known.empty() || ++since_full >= kFullLookEvery;
      if (full) {
        known = mesh.intersections(X);
        since_full = 0;
      }
      hits = std::move(known);
      const Index pairs = static_cast<Index>(hits.size());
      record({result_.attempts, step, way.weights, way.delta, vertices_, pairs, full},
             std::string(" pairs, ") + to_string(way.weights));
      if (full && pairs == 0) {
        if (extra-- > 0) continue;
        finish(X, ForwardFlowResult::Termination::global, way.weights, all);
        result_.clusters = 1;
        result_.reverse_free.assign(vertices_, 1);
        return true;
      }
      if (full && (stagnation.stalled(pairs) || (!options_.patient && exploded(pairs)))) return false;
    }
    return false;
  }

  const Surface& s_;
  const ForwardFlowOptions& options_;
  const RunContext& context_;
  Pairs pairs_;
  Index vertices_;
  double area_ = 0;
  Index fewest_ = -1;
  bool no_room_ = false;
  ForwardFlowResult result_;
};

}  // namespace

const char* to_string(FlowWeights weights) {
  switch (weights) {
    case FlowWeights::cotangent:
      return "cotangent";
    case FlowWeights::clamped:
      return "clamped cotangent";
    case FlowWeights::uniform:
      return "uniform";
    case FlowWeights::intrinsic_delaunay:
      return "intrinsic Delaunay";
  }
  return "";
}

std::vector<GlobalFlow> default_global_flows() {
  return {{FlowWeights::clamped, 1e-4, 120},
          {FlowWeights::uniform, 1e-4, 120},
          {FlowWeights::intrinsic_delaunay, 1e-4, 120},
          {FlowWeights::uniform, 1e-3, 60},
          {FlowWeights::clamped, 2e-5, 200}};
}

Status ForwardFlowOptions::validate() const {
  const auto positive = [](double x) { return std::isfinite(x) && x > 0; };
  const auto bad = [](const std::string& what) { return Error{ErrorCode::usage, "Forward flow: " + what}; };
  if (!positive(radius) || !(radius_edges >= 0) || !(reverse_radius >= 1) || !std::isfinite(reverse_radius))
    return bad("radii must be positive, reverse_radius at least 1.");
  if (!(radius_growth > 1) || !std::isfinite(radius_growth)) return bad("radius_growth must be above 1.");
  if (!positive(regional_delta) || !positive(regional_delta_radius))
    return bad("time steps must be positive.");
  if (regional_steps < 1 || regional_attempts < 1 || stall_tests < 1 || global_stall_tests < 1 ||
      extra_steps < 0 || bisections < 0)
    return bad("counts must be positive.");
  if (!(stall_drop >= 0 && stall_drop < 1)) return bad("stall_drop must be in [0, 1).");
  if (std::isnan(smallest_weight)) return bad("smallest_weight is not a number.");
  if (global.empty() && !regional) return bad("neither regional nor global flow is allowed.");
  for (const GlobalFlow& way : global)
    if (!positive(way.delta) || way.max_steps < 1) return bad("global steps must be positive.");
  return success();
}

ForwardFlowOptions paper_forward_flow() {
  ForwardFlowOptions o;
  o.regional = false;
  o.global = {{FlowWeights::cotangent, 1e-4, 600}, {FlowWeights::intrinsic_delaunay, 1e-4, 600}};
  o.test_all_pairs = o.patient = true;
  o.global_stall_tests = 200;
  return o;
}

std::vector<ForwardFlowOptions> forward_flow_ladder() {
  ForwardFlowOptions first, small, everything, global;
  everything.regional = false;
  small.regional_delta = 1e-4;
  small.regional_delta_radius = 0.025;
  small.regional_steps = 60;
  small.stall_tests = 8;
  small.extra_steps = 2;
  global.regional = false;
  global.global = {{FlowWeights::clamped, 2e-5, 200}, {FlowWeights::uniform, 2e-5, 300}};
  return {first, small, everything, global};
}

VertexMatrix ForwardFlowResult::state(const VertexMatrix& V0, std::size_t i) const {
  VertexMatrix X = V0;
  for (std::size_t k = 0; k < active_vertices.size(); ++k) X.row(active_vertices[k]) = states[i].row(k);
  return X;
}

Result<ForwardFlowResult> forward_flow(const Surface& surface, std::span<const std::array<Index, 2>> pairs,
                                       const ForwardFlowOptions& options, const RunContext& context) {
  if (const Status valid = options.validate(); !valid) return valid.error();
  const Index faces = static_cast<Index>(surface.F.rows());
  if (faces == 0 || !all_below(surface.F, surface.V.rows()))
    return Error{ErrorCode::bad_input,
                 "The surface has no faces, or a face names a vertex that does not exist."};
  if (!surface.V.allFinite())
    return Error{ErrorCode::bad_input, "The surface has a coordinate that is not finite."};
  if (const auto topology = require_topology(surface); !topology) return topology.error();
  const ScopedThreads threads(context.threads);
  const double area = surface_area(surface.V, surface.F);
  if (!(area > 0) || !std::isfinite(area)) return Error{ErrorCode::bad_input, "The surface has no area."};
  Pairs list;
  for (const auto& [f, g] : pairs) {
    if (f < 0 || g < 0 || f >= faces || g >= faces || f == g)
      return Error{ErrorCode::internal, "An intersecting pair names a face that does not exist."};
    list.push_back({std::min(f, g), std::max(f, g)});
  }
  std::sort(list.begin(), list.end());
  Result<ForwardFlowResult> result = Flow(surface, options, context, list).run();
  OVERTET_ENSURES(!result ? success() : check_postconditions(surface, result.value()));
  return result;
}

Status check_postconditions(const Surface& surface, const ForwardFlowResult& result) {
  const auto bad = [](const std::string& what) {
    return Error{ErrorCode::internal, "Forward flow: " + what};
  };
  const std::size_t n = static_cast<std::size_t>(surface.V.rows());
  if (result.V.rows() != surface.V.rows() || result.active.size() != n || result.reverse_free.size() != n)
    return bad("the result has another number of vertices.");
  if (!result.V.allFinite()) return bad("a coordinate is not finite.");
  for (std::size_t v = 0; v < n; ++v) {
    if (!result.active[v] && result.V.row(v) != surface.V.row(v)) return bad("a frozen vertex moved.");
    if (result.active[v] && !result.reverse_free[v])
      return bad("an active vertex is frozen in the reverse flow.");
  }
  for (const VertexMatrix& state : result.states)
    if (state.rows() != static_cast<Eigen::Index>(result.active_vertices.size()) || !state.allFinite())
      return bad("a stored state is broken.");
  const auto left = find_self_intersections(result.V, surface.F);  // not the code that made it
  if (!left.empty()) return bad(std::to_string(left.size()) + " pairs still intersect.");
  return success();
}

}  // namespace overtet
