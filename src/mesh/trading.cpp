// LocalOperations: fewer bad tets at the cost of others that are bad anyway.
#include <algorithm>
#include <cmath>

#include "kernels/tet_energy/tet_quality.h"
#include "src/mesh/local_operations.h"
#include "src/mesh/tuning.h"

namespace overtet {

namespace {

using Eigen::Vector3d;

}  // namespace

double LocalOperations::cheapest(Vector3d& x, const Price& price) {
  const auto quality_of_base = [](const Base& b, const Vector3d& at) {
    return min_dihedral_sine(b.a, b.b, b.c, at);
  };
  const auto price_at = [&](const Vector3d& at) {
    double sum = 0;
    for (const Base& b : bases_) sum += price(quality_of_base(b, at));
    return sum;
  };
  const Vector3d from = x;
  double least = price_at(from);
  for (const bool next_first : {false, true}) {
    Vector3d at = from;
    for (Base& b : bases_) b.weight = 1;
    for (int given_up = 0; given_up < kMostGivenUp; ++given_up) {
      // The worst that is not given up yet; the first time the next one after it.
      Base *worst = nullptr, *next = nullptr;
      double q = HUGE_VAL, q_next = HUGE_VAL;
      int bad = 0;
      for (Base& b : bases_) {
        const double here = quality_of_base(b, at);
        if (here >= price.goal || b.weight != 1) continue;
        ++bad;
        if (here < q) {
          q_next = q;
          next = worst;
          q = here;
          worst = &b;
        } else if (here < q_next) {
          q_next = here;
          next = &b;
        }
      }
      if (given_up == 0 && next_first) worst = next;
      if (worst == nullptr) break;
      worst->weight = price.goal / worst->floor;
      optimise(at, quality_at(at, 0), 6);
      if (const double here = price_at(at); here < least) {
        least = here;
        x = at;
      }
      if (bad == 1) break;
    }
  }
  for (Base& b : bases_) b.weight = 1;
  return least;
}

bool LocalOperations::smooth_cheaper(Index v, const Price& price) {
  if (!star_of_free(v)) return false;
  double before = 0;
  for (std::size_t i = 0; i < star_.size(); ++i) {
    before += price(quality_[star_[i]]);
    bases_[i].floor = std::min(price.low, quality_[star_[i]]);
  }
  if (!(before > 0)) return false;
  Vector3d x = mesh_.position(v);
  if (!(cheapest(x, price) < before - kLeastSaving)) return false;
  for (const Base& b : bases_)
    if (min_dihedral_sine(b.a, b.b, b.c, x) < kSameQuality * b.floor) return false;
  if (!may_move(v, x)) return false;
  mesh_.move(v, x);
  refresh(star_);
  changed_ = star_;
  return true;
}

bool LocalOperations::collapse_cheaper(Index v, Index w, const Price& price) {
  if (fixed_[v]) return false;
  mesh_.star(v, star_);
  if (star_.empty()) return false;
  const double floor = std::min(price.low, worst(star_));
  double left = -kLeastSaving;
  for (const Index t : star_) left += price(quality_[t]);
  for (const Index t : star_) {
    if (!(left > 0)) return false;
    auto c = mesh_.tet(t);
    if (std::find(c.begin(), c.end(), w) != c.end()) continue;
    c[mesh_.corner(t, v)] = w;
    left -= price(quality_of(c[0], c[1], c[2], c[3]));
  }
  return left > 0 && collapse(v, w, kSameQuality * floor);
}

bool LocalOperations::insert_cheaper_near(Index t, const Vector3d& start, const Price& price) {
  Vector3d x = start;
  for (const double part : kPartsOfAim) {
    const double q = grow_cavity(t, x, part * price.goal, kLargestTradeCavity, Judged::inside);
    if (!(q > 0)) return false;
    optimise(x, q, 4);
  }
  double before = 0;
  for (const Index u : cavity_) before += price(quality_[u]);
  const double floor = std::min(price.low, worst(cavity_));
  double now = 0;
  for (Base& b : bases_) {
    b.floor = floor;
    now += price(min_dihedral_sine(b.a, b.b, b.c, x));
  }
  if (now > before) return false;  // giving up some seldom makes up for it
  return cheapest(x, price) < before - kLeastSavingOfVertex && quality_at(x, 0) >= kSameQuality * floor &&
         fill(cavity_, x);
}

bool LocalOperations::insert_cheaper(Index t, const Price& price) {
  const std::vector<Vector3d> starts = places_around(t);
  return std::any_of(starts.begin(), starts.end(),
                     [&](const Vector3d& x) { return insert_cheaper_near(t, x, price); });
}

}  // namespace overtet
