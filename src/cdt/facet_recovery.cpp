#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <optional>
#include <random>
#include <utility>

#include "src/cdt/delaunay_first.h"
#include "src/cdt/delaunay_match.h"
#include "src/cdt/split_edges.h"
#include "src/cdt/tetgen.h"

namespace overtet {

namespace {

constexpr int kAttempts = 6;

// So many facets TetGen is given in all attempts at one mesh, times the patience: all attempts there are for
// most, a few for large ones, where each takes long and other orders seldom help.
constexpr double kMostFacets = 3e6;

// Once so many have not come to an end, others seldom do.
constexpr int kMostEndless = 3;

// Part of the patience for the first time round: what leads anywhere takes little.
constexpr double kFirstPatience = 0.35;

// What has been tried to get one mesh.
class Attempts {
 public:
  explicit Attempts(const TetgenOptions& options) : facets_(kMostFacets * options.patience) {}

  bool left() const { return facets_ > 0; }
  bool another_order() const { return left() && endless_ < kMostEndless; }
  bool any_endless() const { return any_endless_; }

  // Of one more attempt, at so many facets.
  Result<TetgenResult> count(Eigen::Index facets, Result<TetgenResult> result) {
    facets_ -= static_cast<double>(facets);
    if (!result && result.error().reason == ErrorReason::endless) ++endless_, any_endless_ = true;
    return result;
  }

  // Edges have been cut: one order at least.
  void other_facets() { endless_ = std::min(endless_, kMostEndless - 1); }

 private:
  double facets_;
  int endless_ = 0;
  bool any_endless_ = false;
};

// So often edges are cut in half where TetGen fails with whole ones: the first time has always been enough.
constexpr int kSplits = 3;

// From so many facets on, Delaunay tets first are faster.
constexpr Eigen::Index kLarge = 10'000;

// From so many on, it pays to begin with those before all points are known: tets in another order are another
// problem for TetGen where it works in parts, and for the quality pass.
constexpr Eigen::Index kWorthAStart = 40'000;

// Sine of the smallest angle of a face that TetGen still refines around in useful time: 0.006 degrees.
constexpr double kNeedle = 1e-4;

// So many tets a vertex without vertices inside: points lie on common spheres, and flat tets fill the gaps.
// Around 4 is usual.
constexpr double kCrowd = 4.5;

// Of tets around an edge: more than TetGen's flips need to take apart in nearly all cases. Among needles they
// take several times as long without a limit.
constexpr Index kLargestStar = 40;

// Axes turned cyclically (which keeps orientations) by `turn`.
VertexMatrix turned(const VertexMatrix& V, int turn) {
  VertexMatrix out(V.rows(), 3);
  for (int k = 0; k < 3; ++k) out.col(k) = V.col((k + turn) % 3);
  return out;
}

Result<TetgenResult> attempt(const Plc& plc, const TetgenOptions& options, const RunContext& context,
                             int number) {
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

}  // namespace

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

Error too_many() { return Error{ErrorCode::unsolved, "TetGen has failed on these facets often enough."}; }

Result<TetgenResult> shuffled(const Plc& plc, const TetgenOptions& options, const RunContext& context,
                              Attempts& attempts) {
  Result<TetgenResult> first = too_many();
  for (int number = 0; number < kAttempts && attempts.another_order(); ++number) {
    Result<TetgenResult> now = attempts.count(plc.F.rows(), attempt(plc, options, context, number));
    if (settled(now)) return now;
    if (number == 0) first = std::move(now);
  }
  return first;
}

// With edges of facets cut in half, again and again.
Result<TetgenResult> tetrahedralize_split(const Plc& plc, const TetgenOptions& options,
                                          const RunContext& context, Attempts& attempts) {
  Plc now = plc;
  std::vector<Index> source(plc.F.rows());
  std::iota(source.begin(), source.end(), 0);
  for (int round = 0; round < kSplits && attempts.left(); ++round) {
    std::optional<SplitPlc> split = split_missing_edges(now, context);
    if (auto stop = context.stop()) return *stop;
    if (!split) break;
    now = std::move(split->plc);
    for (Index& f : split->source) f = source[f];
    source = std::move(split->source);
    attempts.other_facets();
    Result<TetgenResult> result = shuffled(now, options, context, attempts);
    if (result)
      for (Index& f : result.value().facet_sources) f = source[f];
    if (settled(result)) return result;
  }
  return Error{ErrorCode::unsolved, "TetGen failed with edges cut in half as well."};
}

}  // namespace

Result<TetgenResult> tetrahedralize_shuffled(const Plc& plc, const TetgenOptions& options,
                                             const RunContext& context) {
  Attempts attempts(options);
  return shuffled(plc, options, context, attempts);
}

namespace {

Result<TetgenResult> by_all_means(const Plc& plc, const TetgenOptions& options, const RunContext& context,
                                  DelaunayBuilder begun, Attempts& attempts) {
  TetgenOptions plain = options;
  plain.quality = false;
  const bool delaunay =
      plc.holes.rows() == 0 && options.keep_facets && options.accept_split && !options.fill_convex_hull;
  const bool large = delaunay && plc.F.rows() >= kLarge;
  TetgenOptions quick = plain;
  quick.largest_star = kLargestStar;
  const auto quickly = [&] { return attempts.count(plc.F.rows(), tetrahedralize(plc, quick, context)); };
  Result<TetgenResult> first =
      large ? tetrahedralize_delaunay_first(plc, context, {.patience = options.patience}, std::move(begun))
            : quickly();
  if (large && !settled(first)) first = quickly();
  if (settled(first)) {
    const bool crowded = first.ok() && static_cast<double>(first.value().T.rows()) >
                                           kCrowd * static_cast<double>(first.value().V.rows());
    if (!crowded || !options.quality) return first;
    Result<TetgenResult> refined = tetrahedralize(plc, options, context);
    return settled(refined) ? std::move(refined) : std::move(first);
  }
  if (options.quality)
    if (Result<TetgenResult> again = shuffled(plc, options, context, attempts); settled(again)) return again;
  if (Result<TetgenResult> again = shuffled(plc, plain, context, attempts); settled(again)) return again;
  if (delaunay && attempts.left())
    if (Result<TetgenResult> again = tetrahedralize_delaunay_first(
            plc, context, {.most_missing = 1, .most_left = 10, .patience = options.patience});
        settled(again))
      return again;
  if (options.keep_facets && options.accept_split)
    if (Result<TetgenResult> again = tetrahedralize_split(plc, plain, context, attempts); settled(again))
      return again;
  return first;
}

}  // namespace

Result<TetgenResult> tetrahedralize_stubbornly(const Plc& plc, const TetgenOptions& options,
                                               const RunContext& context, DelaunayBuilder begun) {
  TetgenOptions some = options;
  some.patience = std::min(options.patience, kFirstPatience);
  Attempts attempts(options);
  Result<TetgenResult> first = by_all_means(plc, some, context, std::move(begun), attempts);
  if (settled(first) || !attempts.any_endless() || !(some.patience < options.patience)) return first;
  Attempts more(options);
  return by_all_means(plc, options, context, {}, more);
}

DelaunayBuilder begin_delaunay(const VertexMatrix& V, Eigen::Index facets, const RunContext& context) {
  DelaunayBuilder builder;
  const Index n = static_cast<Index>(V.rows());
  if (facets < kWorthAStart || context.no_room_for(static_cast<std::size_t>(n) * kDelaunayBytesPerPoint))
    return builder;
  builder.insert(V.data(), n, [&] { return context.stop().has_value(); });
  return builder;
}

}  // namespace overtet
