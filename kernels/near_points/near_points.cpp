#include "kernels/near_points/near_points.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "kernels/near_points/tuning.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"

namespace overtet {

namespace {

using Eigen::Vector3d;

// Squares underflow before differences do: only equal points are at no distance.
double squared_distance(const Vector3d& p, const Vector3d& q) {
  const double d = (p - q).squaredNorm();
  return d > 0 || p == q ? d : std::numeric_limits<double>::min();
}

}  // namespace

NearPoints::NearPoints(const VertexMatrix& points)
    : points_(static_cast<std::size_t>(points.rows())), axis_(points_.size(), 0) {
  const double size = points.rows() > 0 ? points.cwiseAbs().maxCoeff() : 0;
  if (size > 0) exponent_ = -std::ilogb(size);
  for (Index i = 0; i < points.rows(); ++i)
    points_[i] = {points.row(i).unaryExpr([&](double x) { return std::ldexp(x, exponent_); }).transpose(), i};
  build(0, static_cast<std::int64_t>(points_.size()));
}

void NearPoints::build(std::int64_t begin, std::int64_t end) {
  if (end - begin <= kPointsPerLeaf) return;
  Vector3d low = points_[begin].at, high = low;
  for (std::int64_t i = begin + 1; i < end; ++i) {
    low = low.cwiseMin(points_[i].at);
    high = high.cwiseMax(points_[i].at);
  }
  int axis = 0;
  (high - low).maxCoeff(&axis);
  const std::int64_t middle = begin + (end - begin) / 2;
  std::nth_element(points_.begin() + begin, points_.begin() + middle, points_.begin() + end,
                   [axis](const Point& x, const Point& y) {
                     return x.at[axis] != y.at[axis] ? x.at[axis] < y.at[axis] : x.number < y.number;
                   });
  axis_[middle] = static_cast<signed char>(axis);
  if (end - begin <= kLightGrain) {
    build(begin, middle);
    build(middle + 1, end);
  } else {
    parallel_invoke([&] { build(begin, middle); }, [&] { build(middle + 1, end); });
  }
}

void NearPoints::visit_within(std::int64_t begin, std::int64_t end, const Vector3d& p, double squared,
                              std::vector<Index>& found) const {
  const auto take = [&](const Point& q) {
    if (squared > 0 ? squared_distance(p, q.at) <= squared : p == q.at) found.push_back(q.number);
  };
  if (end - begin <= kPointsPerLeaf) {
    std::for_each(points_.begin() + begin, points_.begin() + end, take);
    return;
  }
  const std::int64_t middle = begin + (end - begin) / 2;
  const double off = p[axis_[middle]] - points_[middle].at[axis_[middle]];
  const bool both = off * off <= squared;
  take(points_[middle]);
  if (off <= 0 || both) visit_within(begin, middle, p, squared, found);
  if (off >= 0 || both) visit_within(middle + 1, end, p, squared, found);
}

void NearPoints::within(const Vector3d& p, double distance, std::vector<Index>& found) const {
  found.clear();
  const Vector3d scaled = p.unaryExpr([&](double x) { return std::ldexp(x, exponent_); });
  const double reach = std::ldexp(distance, exponent_);
  visit_within(0, static_cast<std::int64_t>(points_.size()), scaled, reach * reach, found);
  std::sort(found.begin(), found.end());
}

struct NearPoints::Best {
  double squared = std::numeric_limits<double>::infinity();
  Index a = -1, b = -1;
  bool twin = false;  // of the point that is looked at

  void take(double d, Index x, Index y) {
    const auto [i, j] = std::minmax(x, y);
    if (std::tie(d, i, j) < std::tie(squared, a, b)) squared = d, a = i, b = j;
  }
};

void NearPoints::look(std::int64_t begin, std::int64_t end, const Point& p, Best& best) const {
  const auto take = [&](const Point& q) {
    if (q.number == p.number) return;
    const double d = squared_distance(p.at, q.at);
    if (d == 0) best.twin = true;
    if (d <= best.squared) best.take(d, p.number, q.number);
  };
  if (end - begin <= kPointsPerLeaf) {
    std::for_each(points_.begin() + begin, points_.begin() + end, take);
    return;
  }
  const std::int64_t middle = begin + (end - begin) / 2;
  const double off = p.at[axis_[middle]] - points_[middle].at[axis_[middle]];
  take(points_[middle]);
  // The nearer side first. The other one where it may be as near, unless a twin has been found: more of them
  // say nothing.
  const auto other = [&] { return off * off <= best.squared && !(best.squared == 0 && best.twin); };
  if (off <= 0) {
    look(begin, middle, p, best);
    if (other()) look(middle + 1, end, p, best);
  } else {
    look(middle + 1, end, p, best);
    if (other()) look(begin, middle, p, best);
  }
}

NearPoints::Closest NearPoints::closest() const {
  const auto count = static_cast<std::int64_t>(points_.size());
  struct Sum {
    std::int64_t coincident = 0;
    Best best;
  };
  const Sum sum = parallel_reduce(
      count, kLightGrain, Sum{},
      [&](std::int64_t begin, std::int64_t end) {
        Sum here;
        for (std::int64_t i = begin; i < end; ++i) {
          here.best.twin = false;
          look(0, count, points_[i], here.best);
          here.coincident += here.best.twin;
        }
        return here;
      },
      [](Sum x, const Sum& y) {
        x.coincident += y.coincident;
        if (y.best.b >= 0) x.best.take(y.best.squared, y.best.a, y.best.b);
        return x;
      });
  Closest closest;
  closest.coincident = sum.coincident;
  if (sum.best.b < 0) return closest;
  closest.a = sum.best.a;
  closest.b = sum.best.b;
  closest.distance = std::ldexp(std::sqrt(sum.best.squared), -exponent_);
  return closest;
}

}  // namespace overtet
