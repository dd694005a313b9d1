#include "src/cdt/delaunay_match.h"

#include <algorithm>
#include <functional>
#include <string>

#include "kernels/core/assertions.h"
#include "kernels/core/tet_tables.h"
#include "kernels/delaunay/cavity.h"
#include "kernels/parallel/grouping.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"

namespace overtet {

bool same_turn(const Triple& a, const Triple& b) {
  OVERTET_EXPECTS(sorted(a) == sorted(b));
  const int at = b[0] == a[0] ? 0 : b[1] == a[0] ? 1 : 2;
  return b[(at + 1) % 3] == a[1];
}

TriangleTable::TriangleTable(Index vertices, const std::vector<Triple>& triangles) : triangles_(triangles) {
  group_items(vertices, start_, items_, [&](auto&& visit) {
    for (Index f = 0; f < static_cast<Index>(triangles.size()); ++f)
      visit(std::min({triangles[f][0], triangles[f][1], triangles[f][2]}), f);
  });
}

Index TriangleTable::find(const Triple& f) const {
  const Index least = std::min({f[0], f[1], f[2]});
  const std::int64_t sum = std::int64_t{f[0]} + f[1] + f[2];
  for (Index i = start_[least]; i < start_[least + 1]; ++i) {
    const Triple& t = triangles_[items_[i]];
    if (std::int64_t{t[0]} + t[1] + t[2] == sum &&
        std::max({t[0], t[1], t[2]}) == std::max({f[0], f[1], f[2]}))
      return items_[i];
  }
  return -1;
}

std::optional<Error> DelaunayMatch::run(const RunContext& context, DelaunayBuilder begun, Index free) {
  const Index n = static_cast<Index>(plc.V.rows()), before = begun.points();
  OVERTET_EXPECTS(before == 0 || before >= free);
  const Index first = before == 0 ? 0 : before - free, late = n - before;
  if (auto error = context.no_room_for(static_cast<std::size_t>(late) * kDelaunayBytesPerPoint)) return error;
  begun.insert(plc.V.data() + 3 * static_cast<std::ptrdiff_t>(first), late,
               [&] { return context.stop().has_value(); });
  if (auto stop = context.stop()) return stop;
  TetArrays all = begun.tets();
  begun = {};
  if (all.tet.empty()) return Error{ErrorCode::unsolved, "All points lie in a plane."};
  tet = std::move(all.tet);
  next = std::move(all.next);
  if (before > 0 && free > 0)  // numbered in another order than the complex's
    parallel_for(static_cast<std::int64_t>(tet.size()), kLightGrain,
                 [&](std::int64_t begin, std::int64_t end) {
                   for (std::int64_t t = begin; t < end; ++t)
                     for (Index& v : tet[t]) v = v < first ? v : v < before ? v + late : v - free;
                 });
  facets.resize(plc.F.rows());
  for (std::size_t f = 0; f < facets.size(); ++f) facets[f] = {plc.F(f, 0), plc.F(f, 1), plc.F(f, 2)};
  replaced.assign(tet.size(), 0);
  facet_on.resize(tet.size());
  std::vector<char> found(2 * facets.size(), 0);  // by facet and side
  const TriangleTable table(n, facets);
  parallel_for(static_cast<std::int64_t>(tet.size()), kLightGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t t = begin; t < end; ++t)
      for (int k = 0; k < 4; ++k) {
        const Triple face = tet_face(tet[t], k);
        const Index f = facet_on[t][k] = table.find(face);
        // One tet on either side: nobody else writes here.
        if (f >= 0) found[2 * static_cast<std::size_t>(f) + same_turn(facets[f], face)] = 1;
      }
  });
  for (std::size_t f = 0; f < facets.size(); ++f)
    if (!found[2 * f] && !found[2 * f + 1]) missing.push_back(static_cast<Index>(f));
  return std::nullopt;
}

namespace {

// Finds the tets that have a point of a facet's inside: they are connected by faces, and some of them are at
// its corners.
class Crossing {
 public:
  explicit Crossing(const DelaunayMatch& match) : match_(match), tet_at_(match.plc.V.rows(), -1) {
    for (Index t = 0; t < static_cast<Index>(match.tet.size()); ++t)
      for (int k = 0; !match.replaced[t] && k < 4; ++k) tet_at_[match.tet[t][k]] = t;
  }

  struct Lists {
    std::vector<Index> star, seen;
  };
  // Fills lists.seen; with so many it ends early.
  void find(Index f, std::size_t most, Lists& lists) const {
    const auto &tet = match_.tet, &next = match_.next;
    const Triple& facet = match_.facets[f];
    auto& [star, seen] = lists;
    const auto crosses = [&](Index t) { return !apart(match_.plc.V.data(), tet[t], facet); };
    seen.clear();
    star.assign(1, tet_at_[facet[0]]);
    for (std::size_t head = 0; head < star.size(); ++head)
      for (int k = 0; k < 4; ++k) {
        const Index other = next[star[head]][k];
        if (other < 0 || tet[star[head]][k] == facet[0]) continue;
        if (std::find(star.begin(), star.end(), other) == star.end()) star.push_back(other);
      }
    for (const Index t : star)
      if (crosses(t)) seen.push_back(t);
    for (std::size_t head = 0; head < seen.size() && seen.size() < most; ++head)
      for (const Index other : next[seen[head]])
        if (other >= 0 && std::find(seen.begin(), seen.end(), other) == seen.end() && crosses(other))
          seen.push_back(other);
  }

 private:
  const DelaunayMatch& match_;
  std::vector<Index> tet_at_;  // one at each point
};

}  // namespace

void DelaunayMatch::find_crossed_tets() {
  const Crossing crossing(*this);
  crossed = parallel_collect<std::pair<Index, Index>>(
      static_cast<std::int64_t>(missing.size()), 256,
      [&](std::int64_t begin, std::int64_t end, std::vector<std::pair<Index, Index>>& out) {
        Crossing::Lists lists;
        for (std::int64_t i = begin; i < end; ++i) {
          crossing.find(missing[i], tet.size(), lists);
          for (const Index t : lists.seen) out.emplace_back(t, missing[i]);
        }
      });
}

bool DelaunayMatch::crosses_many() const {
  const Crossing crossing(*this);
  const std::int64_t n = static_cast<std::int64_t>(missing.size()), step = n / kSampledFacets + 1;
  const std::int64_t samples = (n + step - 1) / step;
  const std::int64_t tets = parallel_reduce(
      samples, kHeavyGrain, std::int64_t{0},
      [&](std::int64_t begin, std::int64_t end) {
        std::int64_t sum = 0;
        Crossing::Lists lists;
        for (std::int64_t i = begin; i < end; ++i) {
          crossing.find(missing[step * i], 4 * kMostCrossed, lists);
          sum += static_cast<std::int64_t>(lists.seen.size());
        }
        return sum;
      },
      std::plus<>());
  return tets > static_cast<std::int64_t>(kMostCrossed) * samples;
}

namespace {

// Fills out.V and numbers the corners of out.T anew: without free points outside, and those that TetGen has
// added there. The new number of each point, or -1; those that are needed keep theirs.
std::vector<Index> number_points(const Plc& plc, const Filling& filling, TetgenResult& out) {
  const Eigen::Index given = plc.V.rows(), all = given + static_cast<Eigen::Index>(filling.added.size());
  std::vector<Index> place(static_cast<std::size_t>(all), -1);
  for (Eigen::Index i = 0; i < out.T.size(); ++i) place[out.T.data()[i]] = 0;
  out.V.resize(all, 3);
  Index last = 0;
  for (Eigen::Index v = 0; v < all; ++v) {
    if (place[v] < 0 && v >= filling.needed) continue;
    out.V.row(last) = v < given ? Eigen::RowVector3d(plc.V.row(v)) : filling.added[v - given].transpose();
    if (v >= filling.needed && v < given) ++out.free_points;
    if (place[v] >= 0) place[v] = last;
    ++last;
  }
  if (last == all) return place;
  out.V.conservativeResize(last, 3);
  for (Eigen::Index i = 0; i < out.T.size(); ++i) out.T.data()[i] = place[out.T.data()[i]];
  return place;
}

}  // namespace

Result<TetgenResult> without_outside(const Plc& plc, const Filling& filling,
                                     const std::vector<char>& replaced) {
  const auto& [tet, next, facet_on, facets, source, added, needed] = filling;
  const std::int64_t n = static_cast<std::int64_t>(tet.size());
  const Index count = static_cast<Index>(facets.size());
  std::vector<char> gone(n, 0);
  std::vector<Index> stack;
  for (std::int64_t t = 0; t < n; ++t) {
    if (replaced[t]) {
      gone[t] = 1;
      continue;
    }
    for (int k = 0; k < 4; ++k)
      if (next[t][k] < 0 && facet_on[t][k] < 0 && !gone[t]) {
        gone[t] = 1;
        stack.push_back(static_cast<Index>(t));
      }
  }
  while (!stack.empty()) {
    const Index t = stack.back();
    stack.pop_back();
    for (int k = 0; k < 4; ++k)
      if (const Index other = next[t][k]; other >= 0 && facet_on[t][k] < 0 && !gone[other]) {
        gone[other] = 1;
        stack.push_back(other);
      }
  }
  std::vector<Index> number(n, -1);
  Index kept = 0;
  for (std::int64_t t = 0; t < n; ++t)
    if (!gone[t]) number[t] = kept++;
  if (kept == 0) return Error{ErrorCode::unsolved, "There is no volume inside the facets; are they closed?"};

  TetgenResult out;
  out.T.resize(kept, 4);
  out.neighbours.resize(kept, 4);
  out.facet_on.resize(kept);
  parallel_for(n, kLightGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t t = begin; t < end; ++t) {
      if (number[t] < 0) continue;
      out.facet_on[number[t]] = facet_on[t];
      for (int k = 0; k < 4; ++k) {
        out.T(number[t], k) = tet[t][k];
        out.neighbours(number[t], k) = next[t][k] < 0 ? -1 : number[next[t][k]];
      }
    }
  });
  const std::vector<Index> place = number_points(plc, filling, out);
  for (Index v = 0; v < needed; ++v)
    if (place[v] < 0)
      return Error{ErrorCode::unsolved, "Vertex " + std::to_string(v) + " lies outside the facets."};
  out.facets.resize(count, 3);
  out.facet_sources = source;
  out.facet_markers.resize(count);
  for (Index f = 0; f < count; ++f) {
    out.facets.row(f) << place[facets[f][0]], place[facets[f][1]], place[facets[f][2]];
    out.facet_markers[f] = plc.markers.empty() ? 1 : plc.markers[source[f]];
  }
  return out;
}

}  // namespace overtet
