#include "src/pipeline/moving_less.h"

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

#include "src/pipeline/stage_clock.h"
#include "src/pipeline/tuning.h"
#include "src/repair/lessening.h"
#include "src/repair/repair.h"
#include "src/repair/tuning.h"
#include "src/volume_map/tuning.h"

namespace overtet {

namespace {

using State = RepairedMesh::State;
using Clock = RunContext::Clock;

enum class OtherTets { improved, made_anew };

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

void say_more_time_would_help(const RepairJob& job) {
  job.context.note(LogLevel::warning,
                   "Repair: the time limit leaves too little time; with more, vertices may move less.");
}

// The time that the rounds may take, where the run has a limit.
class RoundTimer {
 public:
  explicit RoundTimer(const RepairJob& job)
      : job_(job), start_(Clock::now()), seconds_(kHalfTime * job.context.seconds_left()) {}

  // Whether there is time for another round; noted where there is not.
  bool time_left() const {
    if (seconds_since(start_) + 2 * longest_ <= seconds_) return true;
    say_more_time_would_help(job_);
    return false;
  }
  template <class F>
  auto timed(F&& round) {
    const auto begin = Clock::now();
    auto result = round();
    longest_ = std::max(longest_, seconds_since(begin));
    return result;
  }

 private:
  const RepairJob& job_;
  const Clock::time_point start_;
  const double seconds_;
  double longest_ = 0;  // round
};

class MovingLess {
 public:
  MovingLess(const RepairJob& job, RepairedMesh& best) : job_(job), timer_(job), best_(best) {}

  Status run() {
    for (int time = 0; time < kStraightBack; ++time) {
      Result<bool> in_time = rounds();
      if (!in_time) return in_time.error();
      if (!in_time.value() || !too_far()) return success();
      const double before = cost_of(best_);
      // Pulling does not help what was not pulled.
      const bool last = round_ >= kRounds || work_ >= kRoundsWork || best_.state == State::finished;
      if (Status s = straight_back(last ? kStraightBack - time : 1); !s) return s;
      if (last || !too_far() || cost_of(best_) > kGains * before) break;
    }
    return success();
  }

 private:
  double cost_of(const RepairedMesh& r) const { return cost(job_, r.moves); }
  bool too_far() const { return best_.moves.max_relative > job_.allowed(); }

  // Until nothing is too far, or rounds gain nothing any more. False: there is no time for another one.
  Result<bool> rounds() {
    RepairedMesh now = best_;
    bool as_made = false;  // what the last round went on from
    for (int idle = 0; too_far() && idle < kIdleTooFar && round_ < kRounds && work_ < kRoundsWork; ++round_) {
      const bool finished = now.state == State::finished;
      if (finished && as_made && idle % 2 == 1) {  // there are no other tets of it: the same again
        ++idle;
        continue;
      }
      as_made = finished;
      if (!timer_.time_left()) return false;
      Result<std::optional<RepairedMesh>> back = timer_.timed([&] { return pulled_again(now, idle); });
      if (!back) return back.error();
      const double before = cost_of(best_);
      if (back.value() && cost_of(*back.value()) < before) best_ = *back.value();
      idle = cost_of(best_) > kGains * before ? idle + 1 : 0;
      // A little worse is another way to go on.
      const bool on = back.value() && cost_of(*back.value()) < kWorse * cost_of(best_);
      now = on ? std::move(*back.value()) : best_;
    }
    return timer_.time_left();
  }

  // One round: other tets, and another pull, which brings the farthest nearer at the cost of others. The same
  // again would come to the same, so after rounds without gain there are other tets again, and then slower
  // pulls.
  Result<std::optional<RepairedMesh>> pulled_again(const RepairedMesh& from, int idle) {
    Result<std::optional<RepairedMesh>> fresh =
        refreshed(from, idle % 2 == 1 ? OtherTets::made_anew : OtherTets::improved);
    if (!fresh || !fresh.value()) return fresh;
    const Pull::Pace pace = idle >= 2 ? Pull::Pace::slow : Pull::Pace::quick;
    const double most = best_.moves.max_relative;
    const Pull pull{pace, std::max(kNearer * most, kWithin * job_.allowed()), Pull::Aim::nearer};
    Result<std::optional<RepairedMesh>> nearer = pull_of(*fresh.value(), pull);
    if (!nearer || from.state != State::brought_nearer) return nearer;
    // What was only brought nearer has not tried to go home from there yet.
    Result<std::optional<RepairedMesh>> home = pull_of(*fresh.value(), {pace, most, Pull::Aim::home});
    if (!home) return home;
    return home.value() && (!nearer.value() || cost_of(*home.value()) < cost_of(*nearer.value())) ? home
                                                                                                  : nearer;
  }

  Result<std::optional<RepairedMesh>> pull_of(const RepairedMesh& from, const Pull& pull) {
    Result<std::optional<RepairedMesh>> back = pulled(job_, from, pull);
    if (back && back.value()) work_ += back.value()->work;
    return back;
  }

  // The surface with other tets. None: there is no mesh with others.
  Result<std::optional<RepairedMesh>> refreshed(const RepairedMesh& mesh, OtherTets how) {
    if (mesh.state == State::finished) return std::optional(mesh);
    std::optional<TetMesh> other;
    if (how == OtherTets::made_anew) {
      Result<TetMesh> made = mesh_moved(job_, mesh.surface, Need::luxury).mesh;
      if (!made && !repairable(made.error())) return made.error();
      if (made) other = std::move(made).value();
    }
    if (!other) {
      Result<TetMesh> improved = finish_moved(job_, mesh.surface, mesh.mesh);
      if (!improved && !repairable(improved.error())) return improved.error();
      if (improved) other = std::move(improved).value();
    }
    if (!other) return std::optional<RepairedMesh>();
    work_ += kTetWork * static_cast<double>(other->T.rows());
    return std::optional(measured(job_, std::move(*other)));
  }

  Result<LessenResult> lessened(const RepairedMesh& from) const {
    RunContext context = job_.context;
    if (context.deadline != Clock::time_point::max())
      context.deadline =
          Clock::now() + std::chrono::duration_cast<Clock::duration>(
                             std::chrono::duration<double>(kHalfTime * context.seconds_left()));
    return timed_stage("lessen", job_.records, job_.context,
                       [&](StageRecord& record) -> Result<LessenResult> {
                         Result<LessenResult> r = lessen(job_.surface, from.surface.V, {}, context);
                         if (!r) return r;
                         record.iterations = r.value().looks;
                         if (r.value().cut_by_time) say_more_time_would_help(job_);
                         return r;
                       });
  }

  // What the diagnosis alone lets go home, straight, so many times; where that has a mesh.
  Status straight_back(int times) {
    std::vector<RepairedMesh> nearer;  // surfaces
    for (int time = 0; time < times; ++time) {
      const RepairedMesh& from = nearer.empty() ? best_ : nearer.back();
      Result<LessenResult> less = lessened(from);
      if (!less) return less.error();
      if (!less.value().lessened) break;
      RepairedMesh to = moved_to(job_, less.value().V);
      const bool worthwhile = cost_of(to) <= kGains * cost_of(from);
      nearer.push_back(std::move(to));
      if (!worthwhile) break;
    }
    // The nearest is meshed; those before it only where it has no mesh.
    for (auto to = nearer.rbegin(); to != nearer.rend(); ++to) {
      if (!(cost_of(*to) < cost_of(best_))) continue;
      Result<TetMesh> mesh = mesh_moved(job_, to->surface, Need::luxury).mesh;
      if (mesh) {
        best_ = measured(job_, std::move(mesh).value());
        return success();
      }
      if (!repairable(mesh.error())) return mesh.error();
    }
    return success();
  }

  const RepairJob& job_;
  RoundTimer timer_;
  RepairedMesh& best_;
  int round_ = 0;
  double work_ = 0;  // of all rounds; VolumeMapResult::work
};

}  // namespace

Status move_less(const RepairJob& job, RepairedMesh& best) { return MovingLess(job, best).run(); }

}  // namespace overtet
