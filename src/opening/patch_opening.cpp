#include "src/opening/patch_opening.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <set>
#include <utility>

#include "kernels/core/tet_tables.h"
#include "kernels/tet_energy/tet_energy.h"
#include "kernels/tet_energy/tet_quality.h"
#include "src/mesh/local_operations.h"
#include "src/mesh/tuning.h"
#include "src/opening/tuning.h"

namespace overtet {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

double degrees_of(double sine) { return std::asin(std::min(1.0, sine)) * 180 / std::numbers::pi; }

// The sum over a star and its derivatives by the place of its vertex.
struct StarEnergy {
  double value = 0;
  Vector3d gradient = Vector3d::Zero();
  Matrix3d hessian = Matrix3d::Zero();
};

class PlaceOpening {
 public:
  PlaceOpening(MeshPart& part, const std::vector<HomeOfMoved>& moved, const OpeningOptions& options,
               const RunContext& context)
      : part_(part), moved_(moved), options_(options), context_(context), mesh_(part.complex) {
    most_tries_ = std::max<std::int64_t>(options.least_tries, mesh_.tet_count() / 2);
    most_tets_ = static_cast<Index>(options.most_tets * static_cast<double>(mesh_.tet_count()));
    target_ = std::sin(options.target_degrees * std::numbers::pi / 180);
    usable_ = std::sin(options.usable_degrees * std::numbers::pi / 180);
    wanted_ = target_;
  }

  OpenedPlace run() {
    OpenedPlace out;
    out.vertices = static_cast<Index>(moved_.size());
    const TetComplex start = mesh_;
    const Room before = room(operations());
    if (options_.moves == OpeningOptions::Moves::inside) {
      LocalOperations work = operations();
      better_tets(work);
      const Room after = room(work);
      out.opened = after.least > before.least;
      if (!out.opened) mesh_ = start;
      out.degrees_before = degrees_of(before.least);
      out.degrees_after = degrees_of(std::max(before.least, after.least));
      out.farthest = farthest();
      out.away = out.vertices;
      return out;
    }
    const double most = std::min(options_.largest_move,
                                 std::max(options_.edges * mean_edge(), options_.further * farthest()));
    Room best = open(most, out);
    for (int i = 0; i < options_.most_helps && best.least < usable_ && !context_.stop(); ++i) {
      const TetComplex alone = mesh_;
      const std::vector<HomeOfMoved> known = moved_;
      if (!ask_neighbours()) break;
      wanted_ = usable_;  // others have been as far as they get
      const Room helped = open(most, out);
      if (!(helped.least > options_.gain * best.least)) {
        mesh_ = alone;
        moved_ = known;
        break;
      }
      best = helped;
    }
    wanted_ = target_;
    out.opened = best.sum > before.sum + std::log(options_.worthwhile) ||
                 best.least > options_.worthwhile * before.least;
    if (!out.opened) mesh_ = start;
    if (options_.home_sweeps > 0) {
      come_nearer();
      LocalOperations last = operations();
      for (int sweep = 0; sweep < options_.home_sweeps && !context_.stop() && go_home(last); ++sweep)
        out.opened = true;
    }
    out.degrees_before = degrees_of(before.least);
    std::erase_if(moved_, [&](const HomeOfMoved& m) { return mesh_.position(m.vertex) == m.home; });
    out.degrees_after = moved_.empty() ? 90 : degrees_of(room(operations()).least);
    out.farthest = farthest();
    out.away = static_cast<Index>(moved_.size());
    return out;
  }

 private:
  enum class Means { flips, fewer, all };  // fewer: what needs no new vertex

  // How good the tets at moved vertices are: the least quality, and the logarithms of each vertex's least one
  // over the target, where it is less, in one sum. The least alone does not see what is gained at other
  // vertices.
  struct Room {
    double least = std::numeric_limits<double>::infinity(), sum = 0;
  };
  Room room(const LocalOperations& work) {
    Room out;
    for (const HomeOfMoved& m : moved_) {
      const double q = worst_of_star(work, m.vertex);
      out.least = std::min(out.least, q);
      out.sum += std::min(0.0, std::log(q / target_));
    }
    return out;
  }
  // Tets that are so good need not get better, but leave others room.
  bool good_around(const LocalOperations& work, Index v) {
    return worst_of_star(work, v) >= kRoomAbove * wanted_;
  }

  // Rounds in growing balls, of radius `most` in the end; ends with the best mesh of them.
  Room open(double most, OpenedPlace& out) {
    tries_ = 0;
    LocalOperations work = operations();
    better_tets(work);
    Room best = room(work);
    double mark = best.sum;  // of the last gain
    double reach = farthest();
    TetComplex best_mesh = mesh_;
    for (int idle = 0; idle < options_.idle_rounds && best.sum < 0 && !context_.stop();) {
      if (reach >= most && idle > 0) break;
      reach = std::min(most, options_.growth * reach);
      round(work, reach);
      ++out.rounds;
      const Room now = room(work);
      if (now.sum > best.sum && now.least >= best.least) best = now, best_mesh = mesh_;
      // So much of one vertex, or of all.
      if (best.sum > std::min(mark + std::log(options_.gain), mark / options_.gain)) {
        mark = best.sum;
        idle = 0;
      } else {
        ++idle;
      }
    }
    mesh_ = std::move(best_mesh);
    return best;
  }

  // From now on the surface's vertices at the worst tets move as well. False: there are no others.
  bool ask_neighbours() {
    const LocalOperations work = operations();
    std::set<Index> others;
    std::vector<Index> star;
    for (const HomeOfMoved& m : moved_) {
      mesh_.star(m.vertex, star);
      for (const Index t : star)
        if (work.quality(t) < usable_)
          for (const Index v : mesh_.tet(t))
            if (work.fixed(v) && !work.shared(v)) others.insert(v);
    }
    for (const HomeOfMoved& m : moved_) others.erase(m.vertex);
    for (const Index v : others) moved_.push_back({v, mesh_.position(v)});
    std::sort(moved_.begin(), moved_.end(),
              [](const HomeOfMoved& a, const HomeOfMoved& b) { return a.vertex < b.vertex; });
    return !others.empty();
  }

  LocalOperations operations() {
    LocalOperations work(mesh_);
    part_.mark_shared(work);
    work.be_thorough();
    return work;
  }

  // The surface's edges at moved vertices.
  double mean_edge() const {
    double sum = 0;
    int count = 0;
    std::vector<Index> star;
    for (const HomeOfMoved& m : moved_) {
      mesh_.star(m.vertex, star);
      for (const Index t : star)
        for (int k = 0; k < 4; ++k) {
          if (mesh_.neighbour(t, k) >= 0 || mesh_.tet(t)[k] == m.vertex) continue;
          for (int i = 0; i < 4; ++i) {
            const Index v = mesh_.tet(t)[i];
            if (i == k || v == m.vertex) continue;
            sum += (mesh_.position(v) - mesh_.position(m.vertex)).norm();
            ++count;
          }
        }
    }
    return count == 0 ? 0 : sum / count;
  }

  double farthest() const {
    double most = 0;
    for (const HomeOfMoved& m : moved_) most = std::max(most, (mesh_.position(m.vertex) - m.home).norm());
    return most;
  }

  // Free vertices with an edge to a moved one.
  std::vector<Index> followers(const LocalOperations& work) const {
    std::set<Index> near;
    std::vector<Index> star;
    for (const HomeOfMoved& m : moved_) {
      mesh_.star(m.vertex, star);
      for (const Index t : star)
        for (const Index v : mesh_.tet(t))
          if (!work.fixed(v)) near.insert(v);
    }
    return {near.begin(), near.end()};
  }

  // Other tets, and other places for free vertices, as long as that helps.
  void better_tets(LocalOperations& work) {
    for (const Means means : {Means::fewer, Means::all})
      for (int sweep = 0; sweep < options_.worst_sweeps && !context_.stop(); ++sweep) {
        const Room before = room(work);
        if (before.sum == 0) return;
        for (const Index v : followers(work))
          if (!good_around(work, v)) work.smooth(v);
        reconnect(work, means, wanted_);
        if (!(room(work).sum > before.sum / options_.gain)) break;
      }
  }

  // All moves cut back to one length, the least that is found that leaves as much room.
  void come_nearer() {
    const Room floor = room(operations());
    for (double part = options_.first_cut; part * options_.gain < 1 && !context_.stop();) {
      const TetComplex before = mesh_;
      const double reach = part * farthest();
      LocalOperations work = operations();
      if (cut_back(work, reach)) {
        sweeps(work, reach);
        const Room now = room(work);
        if (now.sum >= floor.sum && now.least >= std::min(floor.least, target_)) continue;
      }
      mesh_ = before;
      part = std::sqrt(part);
    }
  }

  bool cut_back(LocalOperations& work, double reach) {
    for (int pass = 0; pass < 2; ++pass)
      for (const HomeOfMoved& m : moved_)
        if (away(m) > reach) work.place(m.vertex, inside(mesh_.position(m.vertex), m.home, reach));
    return farthest() <= reach;
  }

  // Moved vertices go nearer to their homes, those that are nearest first, where no tet there gets worse than
  // the target, or than the worst that there is. False: that gained next to nothing.
  bool go_home(LocalOperations& work) {
    std::vector<std::pair<double, std::size_t>> order;
    double before = 0, now = 0;
    for (std::size_t i = 0; i < moved_.size(); ++i)
      if (const double d = away(moved_[i]); d > 0) order.emplace_back(d, i), before += d;
    std::sort(order.begin(), order.end());
    for (const auto& [d, i] : order) {
      step_home(work, moved_[i]);
      now += away(moved_[i]);
    }
    if (!(options_.gain * now < before)) return false;
    // Room for the next ones.
    for (const HomeOfMoved& m : moved_)
      if (away(m) > 0 && !good_around(work, m.vertex)) work.smooth_within(m.vertex, m.home, away(m));
    for (const Index v : followers(work))
      if (!good_around(work, v)) work.smooth(v);
    reconnect(work, Means::flips, kRoomAbove * target_);
    return true;
  }

  void step_home(LocalOperations& work, const HomeOfMoved& m) {
    const Vector3d from = mesh_.position(m.vertex);
    const double floor = std::min(target_, worst_of_star(work, m.vertex)),
                 lack = lack_of_star(work, m.vertex);
    double part = 1;
    for (int halving = 0; halving < options_.home_halvings; ++halving, part *= 0.5) {
      if (!work.place(m.vertex, part == 1 ? m.home : Vector3d(from + part * (m.home - from)))) continue;
      if (worst_of_star(work, m.vertex) >= floor && lack_of_star(work, m.vertex) >= lack) return;
      work.place(m.vertex, from);
    }
  }

  double away(const HomeOfMoved& m) const { return (mesh_.position(m.vertex) - m.home).norm(); }

  // As Room::sum, of the tets of a star.
  double lack_of_star(const LocalOperations& work, Index v) {
    mesh_.star(v, star_);
    double sum = 0;
    for (const Index t : star_) sum += std::min(0.0, std::log(work.quality(t) / target_));
    return sum;
  }

  double worst_of_star(const LocalOperations& work, Index v) {
    mesh_.star(v, star_);
    double q = std::numeric_limits<double>::infinity();
    for (const Index t : star_) q = std::min(q, work.quality(t));
    return q;
  }

  void round(LocalOperations& work, double reach) {
    scale(work, reach);
    sweeps(work, reach);
  }

  void sweeps(LocalOperations& work, double reach) {
    std::vector<Index> near = followers(work);
    for (int sweep = 0; sweep < options_.energy_sweeps; ++sweep) {
      bool lower = false;
      for (const HomeOfMoved& m : moved_)
        if (!good_around(work, m.vertex)) lower |= descend(work, m.vertex, &m, reach);
      for (const Index v : near)
        if (!good_around(work, v)) lower |= descend(work, v, nullptr, reach);
      if (!lower) break;
    }
    for (int sweep = 0; sweep < options_.energy_sweeps; ++sweep) {
      bool lower = false;
      for (const HomeOfMoved& m : moved_)
        if (!good_around(work, m.vertex)) lower |= soften(work, m.vertex, &m, reach);
      for (const Index v : near)
        if (!good_around(work, v)) lower |= soften(work, v, nullptr, reach);
      if (!lower) break;
    }
    for (int sweep = 0; sweep < options_.worst_sweeps; ++sweep) {
      bool better = false;
      for (const HomeOfMoved& m : moved_)
        if (!good_around(work, m.vertex)) better |= work.smooth_within(m.vertex, m.home, reach);
      for (const Index v : near)
        if (!good_around(work, v)) better |= work.smooth(v);
      better |= reconnect(work, Means::all, wanted_);
      near = followers(work);
      if (!better) break;
    }
  }

  // All moves by one factor, the largest that the tets allow.
  void scale(LocalOperations& work, double reach) {
    std::set<Index> tets;
    std::vector<Index> star, vertices;
    for (const HomeOfMoved& m : moved_) {
      mesh_.star(m.vertex, star);
      tets.insert(star.begin(), star.end());
      vertices.push_back(m.vertex);
    }
    const std::vector<Index> list(tets.begin(), tets.end());
    for (const double factor : {2.0, 1.5, 1.25, 1.1, 1.03}) {
      std::vector<Vector3d> to, from;
      for (const HomeOfMoved& m : moved_) {
        from.push_back(mesh_.position(m.vertex));
        to.push_back(inside(m.home + factor * (from.back() - m.home), m.home, reach));
      }
      const double before = sum_of(list);
      if (!all_positive_on_the_way(list, vertices, to) || !work.place_all(vertices, to, list)) continue;
      if (sum_of(list) < before) return;
      work.place_all(vertices, from, list);
    }
  }

  // vertices: sorted.
  bool all_positive_on_the_way(const std::vector<Index>& tets, const std::vector<Index>& vertices,
                               const std::vector<Vector3d>& to) const {
    for (const Index t : tets) {
      Vector3d old_corners[4], new_corners[4];
      for (int k = 0; k < 4; ++k) {
        const Index v = mesh_.tet(t)[k];
        old_corners[k] = new_corners[k] = mesh_.position(v);
        if (const auto at = std::lower_bound(vertices.begin(), vertices.end(), v);
            at != vertices.end() && *at == v)
          new_corners[k] = to[static_cast<std::size_t>(at - vertices.begin())];
      }
      if (!positive_on_the_way(old_corners, new_corners)) return false;
    }
    return true;
  }

  double sum_of(const std::vector<Index>& tets) const {
    double sum = 0;
    for (const Index t : tets) {
      const auto& c = mesh_.tet(t);
      const double e = shape_energy(mesh_.position(c[0]), mesh_.position(c[1]), mesh_.position(c[2]),
                                    mesh_.position(c[3]), 1, 0);
      sum += e * std::sqrt(e);
    }
    return sum;
  }

  static Vector3d inside(const Vector3d& x, const Vector3d& centre, double radius) {
    const Vector3d d = x - centre;
    const double far = d.norm();
    // A little inside, so that rounding does not lead out.
    return far <= radius ? x : Vector3d(centre + (radius * (1 - 1e-12) / far) * d);
  }

  // Of the star of v, were v at x.
  double star_sum(Index v, const Vector3d& x) const {
    double sum = 0;
    for (const Index t : star_) {
      Vector3d p[4];
      for (int k = 0; k < 4; ++k) p[k] = mesh_.tet(t)[k] == v ? x : mesh_.position(mesh_.tet(t)[k]);
      const double e = shape_energy(p[0], p[1], p[2], p[3], 1, 0);
      if (!std::isfinite(e)) return std::numeric_limits<double>::infinity();
      sum += e * std::sqrt(e);
    }
    return sum;
  }

  StarEnergy star_energy(Index v) const {
    StarEnergy out;
    TetEnergy e;
    for (const Index t : star_) {
      const auto& c = mesh_.tet(t);
      const double value = shape_energy(mesh_.position(c[0]), mesh_.position(c[1]), mesh_.position(c[2]),
                                        mesh_.position(c[3]), 1, 0, e);
      if (!std::isfinite(value)) return {std::numeric_limits<double>::infinity(), out.gradient, out.hessian};
      const int row = 3 * mesh_.corner(t, v);
      const Vector3d g = e.gradient.segment<3>(row);
      const double root = std::sqrt(value);
      out.value += value * root;
      out.gradient += 1.5 * root * g;
      out.hessian += 1.5 * root * e.hessian.block<3, 3>(row, row) + (0.75 / root) * g * g.transpose();
    }
    return out;
  }

  // A Newton step of one vertex, halved until it helps.
  bool descend(LocalOperations& work, Index v, const HomeOfMoved* held, double reach) {
    mesh_.star(v, star_);
    const StarEnergy e = star_energy(v);
    if (!std::isfinite(e.value)) return false;
    Vector3d step = -e.hessian.ldlt().solve(e.gradient);
    if (!step.allFinite() || !(step.dot(e.gradient) < 0))
      step = -e.gradient * (e.value / e.gradient.squaredNorm());
    if (!step.allFinite()) return false;
    const Vector3d from = mesh_.position(v);
    double length = 1;
    for (int halving = 0; halving < kMostHalvings; ++halving, length *= 0.5) {
      Vector3d to = from + length * step;
      if (held) to = inside(to, held->home, reach);
      if (star_sum(v, to) < e.value && work.place(v, to)) return true;
    }
    return false;
  }

  // A step towards a lower sum of powers of one over the sines, nearly a smallest sine: where several
  // vertices hold the worst tet together, none can better it alone, but one after the other lowers the sum.
  bool soften(LocalOperations& work, Index v, const HomeOfMoved* held, double reach) {
    mesh_.star(v, star_);
    const Vector3d from = mesh_.position(v);
    StarEnergy sum;
    if (!std::isfinite(sum_of_sines(v, from, &sum))) return false;
    const Vector3d step = -sum.hessian.ldlt().solve(sum.gradient);
    if (!step.allFinite()) return false;
    double length = 1;
    for (int halving = 0; halving < kMostHalvings; ++halving, length *= 0.5) {
      Vector3d to = from + length * step;
      if (held) to = inside(to, held->home, reach);
      if (kAnyGain * sum_of_sines(v, to, nullptr) < sum.value && work.place(v, to)) return true;
    }
    return false;
  }

  // Over the star of v, were v at x; infinite where a tet is not positive.
  double sum_of_sines(Index v, const Vector3d& x, StarEnergy* derivatives) const {
    DihedralSines sines;
    double sum = 0;
    for (const Index t : star_) {
      const auto face = tet_inner_face(mesh_.tet(t), mesh_.corner(t, v));
      const Vector3d a = mesh_.position(face[0]), b = mesh_.position(face[1]), c = mesh_.position(face[2]);
      if (!((b - a).cross(c - a).dot(x - a) > 0)) return std::numeric_limits<double>::infinity();
      dihedral_sines(a, b, c, x, sines);
      for (std::size_t e = 0; e < 6; ++e) {
        const double one = std::pow(sines.sine[e] / target_, -options_.power);
        sum += one;
        if (!derivatives) continue;
        const Vector3d& g = sines.log_gradient[e];
        derivatives->gradient -= options_.power * one * g;
        derivatives->hessian += options_.power * options_.power * one * g * g.transpose();
      }
    }
    if (derivatives) derivatives->value = sum;
    return sum;
  }

  // Other tets for those at moved vertices that are worse than that.
  bool reconnect(LocalOperations& work, Means means, double below) {
    std::set<std::pair<double, Index>> bad;
    std::vector<Index> star;
    for (const HomeOfMoved& m : moved_) {
      mesh_.star(m.vertex, star);
      for (const Index t : star)
        if (work.quality(t) < below) bad.insert({work.quality(t), t});
    }
    bool any = false;
    for (const auto& [quality, t] : bad)
      if (mesh_.alive(t) && work.quality(t) == quality && replace(work, t, means)) any = true;
    return any;
  }

  bool replace(LocalOperations& work, Index t, Means means) {
    const auto c = mesh_.tet(t);
    for (const auto& [i, j] : kTetEdge)
      if (work.remove_edge(t, c[i], c[j])) return true;
    for (int k = 0; k < 4; ++k)
      if (work.flip_23(t, k)) return true;
    if (means == Means::flips || tries_ >= most_tries_) return false;
    ++tries_;
    for (const auto& [i, j] : kTetEdge)
      if (work.collapse(c[i], c[j]) || work.collapse(c[j], c[i])) return true;
    if (work.reconnect(t)) return true;
    if (means == Means::fewer || mesh_.tet_count() > most_tets_) return false;
    for (const auto& [i, j] : kTetEdge)
      if (work.insert_at_edge(t, c[i], c[j])) return true;
    return work.insert_around(t);
  }

  MeshPart& part_;
  std::vector<HomeOfMoved> moved_;  // by vertex
  const OpeningOptions& options_;
  const RunContext& context_;
  TetComplex& mesh_;
  double target_ = 0, usable_ = 0, wanted_ = 0;  // sines; wanted: below it tets are worked on
  Index most_tets_ = 0;
  std::int64_t most_tries_ = 0, tries_ = 0;  // of changes that are dear
  std::vector<Index> star_;
};

}  // namespace

OpenedPlace open_place(MeshPart& part, const std::vector<HomeOfMoved>& moved, const OpeningOptions& options,
                       const RunContext& context) {
  return PlaceOpening(part, moved, options, context).run();
}

}  // namespace overtet
