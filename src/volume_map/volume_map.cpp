#include "src/volume_map/volume_map.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

#include "kernels/core/assertions.h"
#include "kernels/core/tet_tables.h"
#include "kernels/parallel/parallel.h"
#include "kernels/predicates/predicates.h"
#include "kernels/tet_energy/tet_energy.h"
#include "kernels/tet_energy/tet_quality.h"
#include "src/mesh/local_operations.h"
#include "src/mesh/tuning.h"
#include "src/volume_map/patch.h"
#include "src/volume_map/tuning.h"

namespace overtet {

namespace {

using Eigen::Vector3d;
using namespace volume_map_detail;

double seconds_since(RunContext::Clock::time_point t) {
  return std::chrono::duration<double>(RunContext::Clock::now() - t).count();
}

// The dihedral angle inside the surface at an edge, in (0, 2 pi): faces (a, b, c) and (b, a, d), outward.
double surface_angle(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  const Vector3d e = (b - a).normalized();
  const Vector3d u = (c - a) - e * e.dot(c - a), w = (d - a) - e * e.dot(d - a);
  // Around e, the inside begins at face (a, b, c), whose outward normal is e x u, and turns to w.
  const double angle = std::atan2(-e.cross(u).dot(w), u.dot(w));
  return angle > 0 ? angle : angle + 2 * M_PI;
}

// One map on its way.
class Mapper {
 public:
  Mapper(const TetMesh& mesh, const VertexMatrix& target, std::span<const WoundEdge> wound,
         const VolumeMapOptions& options, const RunContext& context)
      : target_(target),
        options_(options),
        context_(context),
        nb_(mesh.surface_vertices),
        begin_(RunContext::Clock::now()),
        mesh_(mesh.V, mesh.T) {
    length_.assign(mesh.V.rows(), 0);
    std::vector<int> count(mesh.V.rows(), 0);
    for (Index t = 0; t < mesh_.tet_capacity(); ++t) {
      const auto& c = mesh_.tet(t);
      for (int i = 0; i < 4; ++i)
        for (int j = i + 1; j < 4; ++j) {
          const double l = (mesh_.position(c[i]) - mesh_.position(c[j])).norm();
          length_[c[i]] += l;
          length_[c[j]] += l;
          ++count[c[i]];
          ++count[c[j]];
        }
    }
    for (std::size_t v = 0; v < length_.size(); ++v) length_[v] /= std::max(count[v], 1);
    surface_ = mesh_.boundary();
    if (options.largest_move > 0) lengthen();
    std::map<std::array<Index, 2>, Index> opposite;
    for (const auto& f : surface_)
      for (int k = 0; k < 3; ++k) opposite[{f[k], f[(k + 1) % 3]}] = f[(k + 2) % 3];
    std::map<std::array<Index, 2>, int> turns;
    for (const WoundEdge& w : wound) turns[{std::min(w.a, w.b), std::max(w.a, w.b)}] = w.k;
    for (const auto& [edge, c] : opposite) {
      const auto [a, b] = edge;
      if (a > b) continue;
      const auto other = opposite.find({b, a});
      if (other == opposite.end()) continue;
      const auto k = turns.find({a, b});
      const auto at = [&](Index v) { return Vector3d(target_.row(v)); };
      branch_.goals.push_back({a,
                               b,
                               surface_angle(at(a), at(b), at(c), at(other->second)) +
                                   2 * M_PI * (k == turns.end() ? 0 : k->second),
                               {}});
    }
    branch_.wound = !wound.empty();
    // Rings on the surface around the wound edges.
    branch_.rings.assign(nb_, kBranchRings + 1);
    for (const WoundEdge& w : wound) branch_.rings[w.a] = branch_.rings[w.b] = 0;
    for (int ring = 0; ring < kBranchRings; ++ring)
      for (const auto& f : surface_)
        for (int k = 0; k < 3; ++k)
          if (branch_.rings[f[k]] == ring)
            for (const Index v : f) branch_.rings[v] = std::min(branch_.rings[v], ring + 1);
  }

  Result<VolumeMapResult> run() {
    Status pulled = spread_at_once();
    if (!pulled) return pulled.error();
    if (!near_enough_) pulled = pull();
    if (!pulled && pulled.error().code == ErrorCode::unsolved && options_.largest_move > 0)
      pulled = make_do();
    if (!pulled) {
      if (pulled.error().code == ErrorCode::unsolved && options_.on_locked) {
        mesh_.compact(nb_);
        options_.on_locked(mesh_.to_mesh(nb_), away());
      }
      return pulled.error();
    }
    result_.away = away();
    result_.farthest = farthest_move();
    mesh_.compact(nb_);
    result_.mesh = mesh_.to_mesh(nb_);
    result_.seconds = seconds_since(begin_);
    return std::move(result_);
  }

 private:
  bool home(Index v) const { return mesh_.position(v) == Vector3d(target_.row(v)); }

  std::vector<Index> away() const {
    std::vector<Index> list;
    for (Index v = 0; v < nb_; ++v)
      if (!home(v)) list.push_back(v);
    return list;
  }

  double distance(Index v) const {
    return (mesh_.position(v) - Vector3d(target_.row(v))).norm() / length_[v];
  }

  // Where the surface has been smoothed to a point, its edges there are no measure of how far things are.
  void lengthen() {
    std::vector<double> sum(static_cast<std::size_t>(nb_), 0);
    std::vector<int> count(static_cast<std::size_t>(nb_), 0);
    for (const auto& f : surface_)
      for (int k = 0; k < 3; ++k) {
        sum[f[k]] += (target_.row(f[k]) - target_.row(f[(k + 1) % 3])).norm();
        ++count[f[k]];
      }
    for (Index v = 0; v < nb_; ++v) length_[v] = std::max(length_[v], sum[v] / std::max(count[v], 1));
  }

  void remesh(LocalOperations& work, const Patch& patch) {
    struct Bad {
      double quality;
      Index tet;
      TetComplex::Tet corners;
    };
    std::vector<Bad> bad;
    for (const Index t : patch.tets)
      if (mesh_.alive(t) && work.quality(t) < kRemeshBelow) bad.push_back({work.quality(t), t, mesh_.tet(t)});
    std::sort(bad.begin(), bad.end(), [](const Bad& x, const Bad& y) {
      return x.quality != y.quality ? x.quality < y.quality : x.tet < y.tet;
    });
    for (const Bad& b : bad) {
      if (!mesh_.alive(b.tet) || mesh_.tet(b.tet) != b.corners) continue;
      bool done = false;
      for (const auto& e : kTetEdge)
        if (!done) done = work.remove_edge(b.tet, b.corners[e[0]], b.corners[e[1]]);
      for (int k = 0; k < 4 && !done; ++k) done = work.flip_23(b.tet, k);
      for (const auto& e : kTetEdge)
        if (!done)
          done = work.collapse(b.corners[e[0]], b.corners[e[1]]) ||
                 work.collapse(b.corners[e[1]], b.corners[e[0]]);
    }
    length_.resize(mesh_.vertex_count(), 0);
  }

  // Splits the star of a vertex that resists: edges opposite to it, or edges at it.
  enum class Edges { opposite, radial };
  Index refine(LocalOperations& work, Index v, Edges which) {
    std::vector<Index> star;
    mesh_.star(v, star);
    std::vector<std::array<Index, 2>> edges;
    for (const Index t : star) {
      const auto& c = mesh_.tet(t);
      for (int i = 0; i < 4; ++i)
        for (int j = i + 1; j < 4; ++j)
          if ((c[i] == v || c[j] == v) == (which == Edges::radial))
            edges.push_back({std::min(c[i], c[j]), std::max(c[i], c[j])});
    }
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    Index made = 0;
    for (const auto& [a, b] : edges) {
      const double l = 0.5 * (length_[a] + length_[b]);
      if (!work.split_edge(a, b, (mesh_.position(a) + mesh_.position(b)) / 2)) continue;
      length_.push_back(l);
      ++made;
    }
    return made;
  }

  // Home in one move, for those that are near: a vertex that jumps ahead of its neighbours locks them.
  Index snap(LocalOperations& work, std::vector<Index>& list, double reach) {
    std::sort(list.begin(), list.end(), [&](Index a, Index b) {
      const double da = distance(a), db = distance(b);
      return da != db ? da < db : a < b;
    });
    // Nor may a vertex go while a neighbour is far.
    std::vector<char> held(nb_, 0);
    if (reach < HUGE_VAL)
      for (const auto& f : surface_)
        for (const Index v : f)
          if (distance(v) > kHeldBack)
            for (const Index w : f) held[w] = 1;
    Index count = 0;
    for (const Index v : list)
      if (!held[v] && distance(v) <= reach) count += work.place(v, target_.row(v));
    list = away();
    return count;
  }

  double angle_error(const std::vector<AngleGoal>& goals) const {
    double most = 0;
    for (const AngleGoal& g : goals)
      most = std::max(most, std::fabs(interior_angle(mesh_, g.a, g.b) - g.angle));
    return most;
  }

  Status locked(const std::vector<Index>& list) const {
    const Index v = farthest(list);
    return Error{ErrorCode::unsolved,
                 std::to_string(list.size()) +
                     " boundary vertices are locked; the farthest from its place is vertex " +
                     std::to_string(v) + ".",
                 std::array<double, 3>{target_(v, 0), target_(v, 1), target_(v, 2)}};
  }

  bool spent() {
    if (seconds_since(begin_) > options_.seconds) result_.cut_by_time = true;
    return result_.work > options_.work || result_.cut_by_time;
  }

  // A few Newton steps on every patch, all patches at the same time. False: none moves.
  bool move(LocalOperations& work, const std::vector<Patch>& patches, const PatchForces& forces) {
    struct Moved {
      std::vector<Vector3d> to;
      double work = 0;
      int steps = 0;
    };
    std::vector<Moved> moved(patches.size());
    parallel_for(static_cast<std::int64_t>(patches.size()), 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) {
        Moved& m = moved[i];
        PatchNewton newton(mesh_, patches[i], target_, length_);
        while (m.steps < kNewtonSteps && !context_.stop() && newton.step(forces)) ++m.steps;
        m.work = newton.work();
        if (m.steps > 0) m.to = newton.positions();
      }
    });
    bool any = false;
    for (std::size_t i = 0; i < patches.size(); ++i) {
      result_.work += moved[i].work;
      result_.newton_steps += moved[i].steps;
      if (moved[i].steps > 0) any = work.place_all(patches[i].free, moved[i].to, patches[i].tets) || any;
    }
    return any;
  }

  // The pull on its way: first for the branch of the angles, then for the distance.
  enum class PullStage { branch, distance };
  struct Pull {
    std::vector<Index> list;  // vertices that are not at their places
    PullStage stage;
    double force;
    int branch_rounds = 0, stalled = 0, refinements = 0;
    double last_distances = HUGE_VAL;
  };

  // Around all that is to move, as wide as they may be.
  Result<std::vector<Patch>> patches_of(const Pull& pull, const std::vector<char>& may_move) const {
    std::vector<Index> seeds = pull.list;
    if (pull.stage == PullStage::branch)
      seeds.erase(std::remove_if(seeds.begin(), seeds.end(),
                                 [&](Index v) { return branch_.rings[v] > kBranchRings; }),
                  seeds.end());
    std::vector<Patch> patches;
    for (int rings = options_.interior_rings; rings > 0; --rings) {
      patches = grow_patches(mesh_, nb_, seeds, rings, 0, may_move);
      if (std::none_of(patches.begin(), patches.end(),
                       [](const Patch& patch) { return patch.free.size() > kLargestPatch; }))
        break;
      if (rings == 1)
        return Error{ErrorCode::unsolved,
                     std::to_string(pull.list.size()) +
                         " boundary vertices would have to move at once, too many for the volume map."};
    }
    return patches;
  }

  // Goals at boundary edges with an end that is away; for the branch those around wound edges count. Returns
  // the largest error of one.
  double set_angle_goals(std::vector<Patch>& patches, const std::vector<char>& may_move,
                         PullStage stage) const {
    double error = 0;
    for (Patch& patch : patches) {
      for (const AngleGoal& g : branch_.goals) {
        if (stage == PullStage::branch && std::min(branch_.rings[g.a], branch_.rings[g.b]) > kGoalRings)
          continue;
        if ((may_move[g.a] && std::binary_search(patch.free.begin(), patch.free.end(), g.a)) ||
            (may_move[g.b] && std::binary_search(patch.free.begin(), patch.free.end(), g.b)))
          patch.goals.push_back({g.a, g.b, g.angle, edge_ring(mesh_, g.a, g.b)});
      }
      error = std::max(error, angle_error(patch.goals));
    }
    return error;
  }

  void add_round(const VolumeMapRound& record, int round, std::size_t patches) {
    result_.rounds.push_back(record);
    context_.report("volume_map", double(round) / options_.rounds,
                    std::to_string(record.away) + " vertices to pull");
    context_.note(LogLevel::debug,
                  "volume map: " + std::to_string(record.away) + " away by " +
                      std::to_string(record.farthest) + ", pull " + std::to_string(record.pull) + ", angle " +
                      std::to_string(record.angle_error) + ", patches " + std::to_string(patches) + ", " +
                      std::to_string(record.seconds) + " s");
  }

  // After a round for the branch: whether that was the last one, and refinement now and then where angles are
  // not driven to the right one.
  void after_branch_round(LocalOperations& work, Pull& pull, const std::vector<char>& may_move,
                          double error) {
    ++pull.branch_rounds;
    if (error < kBranchReached || pull.branch_rounds >= options_.branch_rounds)
      pull.stage = PullStage::distance;
    if (pull.branch_rounds % 4 != 0 || pull.branch_rounds > kBranchRefinements * 4) return;
    for (const AngleGoal& g : branch_.goals)
      if ((may_move[g.a] || may_move[g.b]) &&
          std::min(branch_.rings[g.a], branch_.rings[g.b]) <= kGoalRings &&
          std::fabs(interior_angle(mesh_, g.a, g.b) - g.angle) > kBranchReached) {
        const Edges which = pull.branch_rounds % 8 == 0 ? Edges::radial : Edges::opposite;
        result_.refinements += refine(work, g.a, which);
        result_.refinements += refine(work, g.b, which);
      }
  }

  // After a round for the distance: the force of the next one. False: the pull is locked.
  bool choose_force(LocalOperations& work, Pull& pull) {
    double distances = 0;
    for (const Index v : pull.list) distances += distance(v);
    const bool fast = distances < 0.85 * pull.last_distances,
               progress = distances < 0.98 * pull.last_distances;
    pull.last_distances = distances;
    pull.stalled = progress ? 0 : pull.stalled + 1;
    // The force grows when what it can do is done.
    if (!fast && pull.force < options_.largest_pull) pull.force *= options_.pull_growth;
    if (pull.stalled < 4) return true;
    if (pull.refinements >= options_.refinements)
      return options_.largest_move > 0 && pull.force < options_.largest_pull;
    for (const Index v : pull.list)
      result_.refinements += refine(work, v, pull.refinements % 2 == 1 ? Edges::radial : Edges::opposite);
    ++pull.refinements;
    pull.stalled = 0;
    pull.force = std::max(options_.first_pull, pull.force / 200);
    return true;
  }

  Status pull() {
    Pull pull{away(), branch_.wound ? PullStage::branch : PullStage::distance, options_.first_pull};
    result_.away_at_start = static_cast<Index>(pull.list.size());
    LocalOperations work(mesh_);
    work.forbid_fixed_chords();
    for (int round = 0; !pull.list.empty(); ++round) {
      if (auto error = context_.stop()) return *error;
      if (round >= options_.rounds || spent()) return locked(pull.list);
      const auto round_begin = RunContext::Clock::now();
      std::vector<char> may_move(nb_, 0);
      for (const Index v : pull.list) may_move[v] = 1;
      Result<std::vector<Patch>> grown = patches_of(pull, may_move);
      if (!grown) return grown.error();
      std::vector<Patch>& patches = grown.value();
      if (options_.largest_move > 0 && kept_.before_locking.vertex_count() == 0 && pull.force > kSpreadPull)
        kept_.before_locking = mesh_;
      const bool for_branch = pull.stage == PullStage::branch;
      VolumeMapRound record;
      if (branch_.wound) record.angle_error = set_angle_goals(patches, may_move, pull.stage);
      record.pull = for_branch ? options_.branch_pull : pull.force;
      PatchForces forces;
      forces.pull = record.pull;
      forces.angle_weight = !branch_.wound ? 0
                            : for_branch   ? options_.angle_weight
                                           : std::max(1.0, pull.force);
      move(work, patches, forces);
      if (auto stop = context_.stop()) return *stop;
      for (const Patch& patch : patches) remesh(work, patch);
      if (!for_branch) snap(work, pull.list, pull.refinements > 0 ? HUGE_VAL : kSnapReach);
      record.away = static_cast<Index>(pull.list.size());
      record.farthest = pull.list.empty() ? 0 : distance(farthest(pull.list));
      record.tets = mesh_.tet_count();
      record.seconds = seconds_since(round_begin);
      add_round(record, round, patches.size());
      if (for_branch)
        after_branch_round(work, pull, may_move, record.angle_error);
      else if (!choose_force(work, pull))
        return locked(pull.list);
    }
    return success();
  }

  double move_of(Index v) const { return (mesh_.position(v) - Vector3d(target_.row(v))).norm(); }

  double farthest_move() const {
    double most = 0;
    for (Index v = 0; v < nb_; ++v) most = std::max(most, move_of(v));
    return most;
  }

  // Whether the mesh as it is is better than one with so many away, and so far.
  bool better_than(std::size_t count, double far) const {
    const double now = farthest_move();
    const bool fine = now <= options_.largest_move, other = far <= options_.largest_move;
    if (fine != other) return fine;
    return fine ? away().size() < count : now < far;
  }

  void bring_home() {
    LocalOperations work(mesh_);
    for (int pass = 0; pass < 3; ++pass) {
      std::vector<Index> list = away();
      if (snap(work, list, HUGE_VAL) == 0) break;
    }
  }

  // The pull is locked: takes its end, or where that is too far, the best of it and of what spreading makes
  // of a state before it and of it.
  Status make_do() {
    bring_home();
    TetComplex best = mesh_;
    std::size_t count = away().size();
    double far = farthest_move();
    for (const bool early : {true, false}) {
      if (far <= options_.largest_move) break;
      if (early && kept_.before_locking.vertex_count() == 0) continue;
      mesh_ = early ? kept_.before_locking : best;
      bool hopeless = false;
      if (Status s = spread(hopeless); !s) return s;
      bring_home();
      if (better_than(count, far)) {
        best = mesh_;
        count = away().size();
        far = farthest_move();
      }
      if (hopeless) break;
    }
    if (kept_.nearest.vertex_count() > 0 && far > options_.largest_move) {
      mesh_ = std::move(kept_.nearest);
      if (better_than(count, far)) return success();
    }
    mesh_ = std::move(best);
    return success();
  }

  // The way home and back may be lost: what is a little too far is brought nearer from where it is.
  Status spread_at_once() {
    if (!(options_.spread_first && farthest_move() > options_.largest_move)) return success();
    const TetComplex start = mesh_;
    bool hopeless = false;
    if (Status s = spread(hopeless); !s) return s;
    near_enough_ = farthest_move() <= options_.largest_move;
    if (near_enough_)
      bring_home();
    else
      kept_.nearest = std::move(mesh_), mesh_ = start;
    return success();
  }

  // What cannot reach its place is held back by its neighbours, which have reached theirs. They give way to
  // those that are too far from theirs: around them everything moves again, pulled the more the farther.
  Status spread(bool& hopeless) {
    const double limit = kWithin * options_.largest_move;
    LocalOperations work(mesh_);
    work.forbid_fixed_chords();
    TetComplex best = mesh_;
    double best_move = farthest_move(), last = best_move, force = kSpreadPull;
    PatchForces forces;
    forces.reach = limit;
    std::vector<double> course;  // of best_move
    int stalled = 0, rings = kSpreadRings;
    for (int round = 0; round < options_.spread_rounds && best_move > options_.largest_move; ++round) {
      if (spent() || force > options_.largest_pull || rings == 0) break;
      std::vector<char> may_move(nb_, 0);
      for (Index v = 0; v < nb_; ++v) may_move[v] = move_of(v) > 0.5 * limit;
      for (int ring = 0; ring < rings; ++ring) {
        const std::vector<char> before = may_move;
        for (const auto& f : surface_)
          if (before[f[0]] || before[f[1]] || before[f[2]])
            for (const Index v : f) may_move[v] = 1;
      }
      std::vector<Index> all;
      for (Index v = 0; v < nb_; ++v)
        if (may_move[v]) all.push_back(v);
      forces.pull = force;
      std::vector<Patch> patches = grow_patches(mesh_, nb_, all, options_.interior_rings, 0, may_move);
      std::erase_if(patches, [](const Patch& patch) { return patch.free.size() > kLargestPatch; });
      const bool moved = move(work, patches, forces);
      if (auto stop = context_.stop()) return *stop;
      for (const Patch& patch : patches) remesh(work, patch);
      if (!moved) {
        rings /= 2;
        continue;
      }
      const double now = farthest_move();
      context_.report("volume_map", double(round) / options_.spread_rounds,
                      std::to_string(all.size()) + " vertices to spread");
      context_.note(LogLevel::debug, "volume map: spread, farthest " + std::to_string(now / limit) +
                                         " of what is allowed, pull " + std::to_string(force));
      if (now < best_move) best = mesh_, best_move = now;
      course.push_back(best_move);
      if (course.size() > kSpreadCourse) {
        const double gained = course[course.size() - 1 - kSpreadCourse] - best_move;
        hopeless =
            best_move - gained * (options_.spread_rounds - round) / kSpreadCourse > options_.largest_move;
        if (hopeless) break;
      }
      stalled = now > 0.98 * last ? stalled + 1 : 0;
      last = now;
      if (stalled >= 3) force *= options_.pull_growth, stalled = 0;
    }
    mesh_ = std::move(best);
    return success();
  }

  Index farthest(const std::vector<Index>& list) const {
    Index best = list.front();
    for (const Index v : list)
      if (distance(v) > distance(best)) best = v;
    return best;
  }

  // Edges that must be wound, and the angles of all that says so.
  struct Branch {
    bool wound = false;
    std::vector<AngleGoal> goals;
    std::vector<int> rings;  // per surface vertex: from a wound edge, kBranchRings + 1 beyond
  };
  // States that may be the better end.
  struct Kept {
    TetComplex before_locking;  // of the pull, with healthy tets
    TetComplex nearest;         // what spreading has made of the start, where that is still too far
  };

  const VertexMatrix& target_;
  const VolumeMapOptions& options_;
  const RunContext& context_;
  const Index nb_;
  const RunContext::Clock::time_point begin_;
  TetComplex mesh_;
  std::vector<double> length_;  // per vertex: mean edge length of the embedding
  std::vector<std::array<Index, 3>> surface_;
  Branch branch_;
  VolumeMapResult result_;
  Kept kept_;
  bool near_enough_ = false;  // spreading alone has done it
};

}  // namespace

Status VolumeMapOptions::validate() const {
  if (interior_rings < 1 || rounds < 1 || branch_rounds < 0 || refinements < 0)
    return Error{ErrorCode::usage, "The volume map's counts must not be negative."};
  if (!(work > 0 && seconds > 0))
    return Error{ErrorCode::usage, "The volume map's work and time must be positive."};
  if (!(first_pull > 0 && pull_growth > 1 && largest_pull >= first_pull && branch_pull >= 0 &&
        angle_weight > 0 && largest_move >= 0 && spread_rounds >= 0))
    return Error{ErrorCode::usage, "The volume map's forces must be positive and grow."};
  return success();
}

Result<VolumeMapResult> volume_map(const TetMesh& mesh, const VertexMatrix& target,
                                   std::span<const WoundEdge> wound, const VolumeMapOptions& options,
                                   const RunContext& context) {
  if (auto status = options.validate(); !status.ok()) return status.error();
  if (target.rows() != mesh.surface_vertices)
    return Error{ErrorCode::usage, "The volume map needs one target for each vertex of the surface."};
  Result<VolumeMapResult> result = Mapper(mesh, target, wound, options, context).run();
  OVERTET_ENSURES(!result ? success() : check_postconditions(result.value(), target));
  return result;
}

Status check_postconditions(const VolumeMapResult& result, const VertexMatrix& target) {
  const auto broken = [](const std::string& what) {
    return Error{ErrorCode::internal, "The volume map's result is wrong: " + what + "."};
  };
  const TetMesh& m = result.mesh;
  if (m.V.rows() < target.rows()) return broken("boundary vertices are missing");
  for (Index v = 0; v < target.rows(); ++v)
    if (std::memcmp(m.V.row(v).data(), target.row(v).data(), 3 * sizeof(double)) != 0 &&
        !std::binary_search(result.away.begin(), result.away.end(), v))
      return broken("a boundary vertex is not at its place");
  if (const Index t = first_not_positive(m); t >= 0)
    return broken("tet " + std::to_string(t) + " is not positive");
  const TetComplex mesh(m.V, m.T);
  std::map<std::array<Index, 2>, double> turn;
  for (Index t = 0; t < mesh.tet_capacity(); ++t) {
    const auto& c = mesh.tet(t);
    const auto angle =
        dihedral_angles(mesh.position(c[0]), mesh.position(c[1]), mesh.position(c[2]), mesh.position(c[3]));
    for (int e = 0; e < 6; ++e)
      turn[{std::min(c[kTetEdge[e][0]], c[kTetEdge[e][1]]),
            std::max(c[kTetEdge[e][0]], c[kTetEdge[e][1]])}] += angle[e];
  }
  for (const auto& f : mesh.boundary())
    for (int k = 0; k < 3; ++k) turn.erase({std::min(f[k], f[(k + 1) % 3]), std::max(f[k], f[(k + 1) % 3])});
  for (const auto& [edge, sum] : turn)
    if (std::fabs(sum - 2 * M_PI) > kTurnTolerance)
      return broken("edge " + std::to_string(edge[0]) + "-" + std::to_string(edge[1]) +
                    " does not make one turn");
  return success();
}

}  // namespace overtet
