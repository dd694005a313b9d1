#include "src/cdt/facet_recovery.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numeric>
#include <optional>
#include <random>
#include <utility>

#include "kernels/core/tuning.h"
#include "kernels/delaunay/tuning.h"
#include "src/cdt/delaunay_first.h"
#include "src/cdt/delaunay_match.h"
#include "src/cdt/free_points.h"
#include "src/cdt/split_edges.h"
#include "src/cdt/tuning.h"

namespace overtet {

Attempts::Attempts(const TetgenOptions& options) : facets_(kMostFacets * options.patience) {}

bool Attempts::another_order() const { return left() && endless_ < kInVain; }

Result<TetgenResult> Attempts::count(Eigen::Index facets, Result<TetgenResult> result) {
  facets_ -= static_cast<double>(facets);
  if (!result && result.error().reason == ErrorReason::endless) ++endless_, any_endless_ = true;
  return result;
}

void Attempts::other_facets() { endless_ = std::min(endless_, kInVain - 1); }

namespace {

// Axes turned cyclically (which keeps orientations) by `turn`.
VertexMatrix turned(const VertexMatrix& V, int turn) {
  VertexMatrix out(V.rows(), 3);
  for (int k = 0; k < 3; ++k) out.col(k) = V.col((k + turn) % 3);
  return out;
}

}  // namespace

Result<TetgenResult> tetrahedralize_in_order(const Plc& plc, const TetgenOptions& options,
                                             const RunContext& context, int number) {
  const Index n = static_cast<Index>(plc.V.rows());
  const int turn = number % 3;
  std::vector<Index> place(n);  // where each point goes
  std::iota(place.begin(), place.end(), 0);
  if (number >= 3) {
    std::mt19937 random(number);  // its sequence is fixed by the standard; std::shuffle's use of it is not
    for (Index i = n - 1; i > 0; --i) std::swap(place[i], place[random() % (i + 1)]);
  }
  Plc moved = plc;
  moved.holes = turned(plc.holes, turn);
  const VertexMatrix V = turned(plc.V, turn);
  for (Index i = 0; i < n; ++i) moved.V.row(place[i]) = V.row(i);
  for (Index f = 0; f < moved.F.rows(); ++f)
    for (int k = 0; k < 3; ++k) moved.F(f, k) = place[plc.F(f, k)];

  Result<TetgenResult> result = tetrahedralize(moved, options, context);
  if (!result) return result;
  TetgenResult& out = result.value();
  out.V = turned(out.V, (3 - turn) % 3);
  const VertexMatrix sorted = out.V.topRows(n);
  std::vector<Index> back(out.V.rows());
  std::iota(back.begin(), back.end(), 0);
  for (Index i = 0; i < n; ++i) {
    out.V.row(i) = sorted.row(place[i]);
    back[place[i]] = i;
  }
  for (Index t = 0; t < out.T.rows(); ++t)
    for (int k = 0; k < 4; ++k) out.T(t, k) = back[out.T(t, k)];
  for (Index f = 0; f < out.facets.rows(); ++f)
    for (int k = 0; k < 3; ++k) out.facets(f, k) = back[out.facets(f, k)];
  return result;
}

bool worth_refining(const VertexMatrix& V, const TriangleMatrix& F) {
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    const Eigen::Vector3d a = V.row(F(f, 0)), b = V.row(F(f, 1)), c = V.row(F(f, 2));
    // The smallest angle lies between the two longer sides.
    double side[3] = {(b - a).norm(), (c - b).norm(), (a - c).norm()};
    std::sort(side, side + 3);
    if ((b - a).cross(c - a).norm() < kNeedle * side[1] * side[2]) return false;
  }
  return true;
}

namespace {

bool settled(const Result<TetgenResult>& r) { return r.ok() || r.error().code != ErrorCode::unsolved; }

Error too_many() { return Error{ErrorCode::unsolved, "TetGen failed on these facets too many times."}; }

Result<TetgenResult> shuffled(const Plc& plc, const TetgenOptions& options, const RunContext& context,
                              Attempts& attempts) {
  Result<TetgenResult> first = too_many();
  for (int number = 0; number < kOrders && attempts.another_order(); ++number) {
    Result<TetgenResult> now =
        attempts.count(plc.F.rows(), tetrahedralize_in_order(plc, options, context, number));
    if (settled(now)) return now;
    if (number == 0) first = std::move(now);
  }
  return first;
}

}  // namespace

Result<TetgenResult> tetrahedralize_split(const Plc& plc, const TetgenOptions& options,
                                          const RunContext& context, Attempts& attempts) {
  if (attempts.left()) {
    const std::optional<SplitPlc> split = split_missing_edges(plc, context);
    if (auto stop = context.stop()) return *stop;
    if (split) {
      attempts.other_facets();
      Result<TetgenResult> result = shuffled(split->plc, options, context, attempts);
      if (result)
        for (Index& f : result.value().facet_sources) f = split->source[f];
      if (settled(result)) return result;
    }
  }
  return Error{ErrorCode::unsolved, "TetGen also failed with edges cut in half."};
}

Result<TetgenResult> tetrahedralize_shuffled(const Plc& plc, const TetgenOptions& options,
                                             const RunContext& context) {
  Attempts attempts(options);
  return shuffled(plc, options, context, attempts);
}

namespace {

// One mesh, to be got by several means.
struct Recovery {
  const Plc& plc;
  const TetgenOptions& options;
  const RunContext& context;
  Attempts& attempts;
  DelaunayStart begun;

  TetgenOptions without_points() const {
    TetgenOptions plain = options;
    plain.quality = false;
    return plain;
  }
  bool may_split() const { return options.keep_facets && options.accept_split; }
  bool may_be_delaunay() const {
    return plc.holes.rows() == 0 && options.keep_facets && !options.fill_convex_hull;
  }
  bool is_large() const { return plc.F.rows() >= kLarge; }
  PartsOptions parts() const { return {.patience = options.patience, .accept_split = options.accept_split}; }
};

// Points inside, where they are allowed and the mesh without them is crowded: flat tets fill gaps.
Result<TetgenResult> refined(const Recovery& r, Result<TetgenResult> mesh) {
  if (!mesh || !r.options.quality) return mesh;
  const TetgenResult& x = mesh.value();
  if (static_cast<double>(x.T.rows()) <= kCrowd * static_cast<double>(x.V.rows())) return mesh;
  Result<TetgenResult> better = tetrahedralize(r.plc, r.options, r.context);
  return settled(better) ? std::move(better) : std::move(mesh);
}

VertexMatrix joined(const VertexMatrix& a, const VertexMatrix& b) {
  VertexMatrix all(a.rows() + b.rows(), 3);
  all << a, b;
  return all;
}

Result<TetgenResult> with_free_points(Recovery& r) {
  DelaunayStart begun = std::exchange(r.begun, {});
  const VertexMatrix free =
      begun.builder.points() > 0 ? std::move(begun.free_points) : free_points(r.plc.V, r.plc.F, r.context);
  if (auto stop = r.context.stop()) return *stop;
  Plc more = r.plc;
  more.V = joined(r.plc.V, free);
  return tetrahedralize_delaunay_first(
      more, r.context,
      {.in_parts = false, .free_points = static_cast<Index>(free.rows()), .parts = r.parts()},
      std::move(begun.builder));
}

Result<TetgenResult> delaunay_first(Recovery& r) {
  return refined(r, tetrahedralize_delaunay_first(r.plc, r.context, {.parts = r.parts()}));
}

Result<TetgenResult> in_the_given_order(Recovery& r) {
  TetgenOptions quick = r.without_points();
  quick.largest_star = kMostTetsFilled;  // more than flips need to take apart in nearly all cases
  return refined(r, r.attempts.count(r.plc.F.rows(), tetrahedralize(r.plc, quick, r.context)));
}

Result<TetgenResult> in_other_orders(Recovery& r) {
  return shuffled(r.plc, r.options, r.context, r.attempts);
}

Result<TetgenResult> in_other_orders_without_points(Recovery& r) {
  return shuffled(r.plc, r.without_points(), r.context, r.attempts);
}

// However many facets are missing, and however many of them TetGen is left with.
Result<TetgenResult> delaunay_at_any_price(Recovery& r) {
  return tetrahedralize_delaunay_first(r.plc, r.context,
                                       {.most_missing = 1, .most_left = 10, .parts = r.parts()});
}

Result<TetgenResult> with_edges_cut(Recovery& r) {
  return tetrahedralize_split(r.plc, r.without_points(), r.context, r.attempts);
}

struct Means {
  bool (*applies)(const Recovery& recovery);
  Result<TetgenResult> (*run)(Recovery& recovery);
};
// In the order in which they are tried, until one settles it. The one that always applies says why not.
const std::array all_means = {
    Means{[](const Recovery& r) {
            return r.may_be_delaunay() && r.options.free_points && (!r.may_split() || r.is_large());
          },
          with_free_points},
    Means{[](const Recovery& r) { return r.may_be_delaunay() && r.may_split() && r.is_large(); },
          delaunay_first},
    Means{nullptr, in_the_given_order},
    Means{[](const Recovery& r) { return r.options.quality; }, in_other_orders},
    Means{[](const Recovery&) { return true; }, in_other_orders_without_points},
    Means{[](const Recovery& r) { return r.may_be_delaunay() && r.attempts.left(); }, delaunay_at_any_price},
    Means{[](const Recovery& r) { return r.may_split(); }, with_edges_cut}};

Result<TetgenResult> by_all_means(Recovery recovery) {
  Result<TetgenResult> failure = too_many();
  for (const Means& means : all_means) {
    const bool always = means.applies == nullptr;
    if (!always && !means.applies(recovery)) continue;
    Result<TetgenResult> now = means.run(recovery);
    if (settled(now)) return now;
    if (always) failure = std::move(now);
  }
  return failure;
}

}  // namespace

Result<TetgenResult> tetrahedralize_stubbornly(const Plc& plc, const TetgenOptions& options,
                                               const RunContext& context, DelaunayStart begun) {
  TetgenOptions some = options;
  some.patience = std::min(options.patience, kShortPatience);
  Attempts attempts(options);
  Result<TetgenResult> first = by_all_means({plc, some, context, attempts, std::move(begun)});
  if (settled(first) || !attempts.any_endless() || !(some.patience < options.patience)) return first;
  Attempts more(options);
  return by_all_means({plc, options, context, more, {}});
}

DelaunayStart begin_delaunay(const VertexMatrix& V, const TriangleMatrix& F, const RunContext& context) {
  DelaunayStart start;
  if (F.rows() < kWorthAStart) return start;
  VertexMatrix free = free_points(V, F, context);
  const VertexMatrix all = joined(V, free);
  const Index n = static_cast<Index>(all.rows());
  if (context.no_room_for(static_cast<std::size_t>(n) * kDelaunayBytesPerPoint)) return start;
  if (start.builder.insert(all.data(), n, [&] { return context.stop().has_value(); }))
    start.free_points = std::move(free);
  return start;
}

}  // namespace overtet
