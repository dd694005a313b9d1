#include "src/cleanup/inward.h"

#include <algorithm>
#include <climits>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>

#include "kernels/bvh/self_intersections.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "src/arrangement/intersection_graph.h"
#include "src/certificates/winding_range.h"
#include "src/exact/ordinary_size.h"
#include "src/exact/rays.h"
#include "src/mesh/submesh.h"
#include "src/mesh/topology.h"

namespace overtet {

namespace {

using exact::Rational;

// The sign of the volume that the faces enclose, as they turn.
int volume_sign(const Surface& s, std::span<const Index> faces) {
  const auto corner = [&](Index f, int k) { return s.V.data() + 3 * std::int64_t{s.F(f, k)}; };
  const double* o = corner(faces[0], 0);
  double sum = 0, size = 0;
  for (const Index f : faces) {
    double p[3][3];
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i) p[k][i] = corner(f, k)[i] - o[i];
    for (int i = 0; i < 3; ++i) {
      const double y = p[1][(i + 1) % 3] * p[2][(i + 2) % 3], z = p[1][(i + 2) % 3] * p[2][(i + 1) % 3];
      sum += p[0][i] * (y - z);
      size += std::fabs(p[0][i]) * (std::fabs(y) + std::fabs(z));
    }
  }
  // Every term has at most eight roundings of half an ulp, every sum one more for each face.
  const double error = size * (static_cast<double>(faces.size()) + 16) * 0x1p-50;
  if (std::isfinite(size) && size > 1e-200 && std::fabs(sum) > error) return sum > 0 ? 1 : -1;
  const exact::Vec origin = exact::vec(o);
  Rational volume = 0;
  for (const Index f : faces)
    volume += exact::det(exact::vec(corner(f, 0)) - origin, exact::vec(corner(f, 1)) - origin,
                         exact::vec(corner(f, 2)) - origin);
  return exact::sign(volume);
}

struct Component {
  std::vector<Index> faces;  // ascending
  Box box;
  int sign = 0;  // of its volume, as in the file
  bool meets_others = false, crosses_itself = false;

  double size() const {
    double sum = 0;
    for (int k = 0; k < 3; ++k) sum += box.high[k] - box.low[k];
    return sum;
  }
};

// The winding number of the faces that are not in `skip`; none on the surface.
std::optional<int> winding_of_rest(const exact::Rays& rays, const double* point,
                                   const std::vector<Index>& skip) {
  const exact::Point m(point);
  for (int attempt = 0;; ++attempt) {
    const double d[3] = {1, 0x1p-8 * exact::scatter(2 * attempt), 0x1p-8 * exact::scatter(2 * attempt + 1)};
    const double t[3] = {0, 0.5 + 0.4 * exact::scatter(attempt + 7), 1};
    const exact::Point direction(d), tilt(t);
    const exact::RayCount got = rays.count(m, direction, &tilt, skip);
    if (got.status == exact::RayStatus::counted) return got.winding;
    if (got.status == exact::RayStatus::starts_on_surface) return std::nullopt;
    if (attempt % 8 < 7) continue;
    const std::vector<Index> at = rays.faces_at(m);
    if (!std::includes(skip.begin(), skip.end(), at.begin(), at.end())) return std::nullopt;
  }
}

class Turning {
 public:
  Turning(const Surface& s, const std::vector<Index>& component_of, Index count)
      : surface_(s), component_of_(component_of), components_(count) {
    for (Index f = 0; f < s.F.rows(); ++f) components_[component_of[f]].faces.push_back(f);
    for (Component& c : components_) {
      c.box = {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
      for (const Index f : c.faces)
        for (int k = 0; k < 3; ++k) {
          const double* p = s.V.data() + 3 * std::int64_t{s.F(f, k)};
          c.box.include({{p[0], p[1], p[2]}, {p[0], p[1], p[2]}});
        }
    }
    parallel_tasks(count,
                   [&](std::int64_t c) { components_[c].sign = volume_sign(s, components_[c].faces); });
  }

  Result<std::vector<Index>> run(const RunContext& context) {
    std::vector<Index> turned;
    if (std::none_of(components_.begin(), components_.end(), [](const Component& c) { return c.sign < 0; }))
      return turned;
    if (auto stop = context.stop()) return *stop;
    TriangleBvh bvh(surface_.V, surface_.F);
    for (const auto& [f, g] : find_self_intersections(surface_.V, surface_.F, bvh)) {
      Component &a = components_[component_of_[f]], &b = components_[component_of_[g]];
      if (&a == &b)
        a.crosses_itself = true;
      else
        a.meets_others = b.meets_others = true;
    }
    if (Status s = decide(bvh, context, turned); !s) return s.error();
    return turned;
  }

 private:
  Status decide(const TriangleBvh& bvh, const RunContext& context, std::vector<Index>& turned) {
    TriangleMatrix F = surface_.F;
    const exact::Rays before(surface_.V, surface_.F, bvh), now(surface_.V, F, bvh);
    std::vector<Index> order(components_.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](Index a, Index b) { return components_[a].size() > components_[b].size(); });
    Box reach{{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};  // of what is turned
    for (const Index c : order) {
      if (auto stop = context.stop()) return *stop;
      Component& one = components_[c];
      bool turn = false;
      if (one.sign < 0)
        turn = least_winding(now, one, 1) < 1;
      else if (one.sign > 0 && one.box.overlaps(reach))
        turn = least_winding(before, one, INT_MIN) < 0 && least_winding(now, one, 1) >= 1;
      if (!turn) continue;
      const Result<bool> one_way = faces_one_way(one, context);
      if (!one_way) return one_way.error();
      if (!one_way.value()) continue;
      turned.push_back(c);
      reach.include(one.box);
      for (const Index f : one.faces) std::swap(F(f, 1), F(f, 2));
    }
    std::sort(turned.begin(), turned.end());
    return success();
  }

  // Of all other components, at the vertices of this one: the least, or some number below `enough`. Large
  // where none can be asked.
  int least_winding(const exact::Rays& rays, const Component& c, int enough) const {
    std::vector<Index> vertices;
    for (const Index f : c.faces)
      vertices.insert(vertices.end(), {surface_.F(f, 0), surface_.F(f, 1), surface_.F(f, 2)});
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    if (!c.meets_others) vertices.resize(1);  // all are in one place, as far as the others are concerned
    const auto least = [&](std::int64_t begin, std::int64_t end) {
      int w = INT_MAX;
      for (std::int64_t i = begin; i < end && w >= enough; ++i)
        w = std::min(w, winding_of_rest(rays, surface_.V.data() + 3 * std::int64_t{vertices[i]}, c.faces)
                            .value_or(INT_MAX));
      return w;
    };
    const auto n = static_cast<std::int64_t>(vertices.size());
    const std::int64_t few = std::min<std::int64_t>(n, kMediumGrain);  // mostly they decide
    if (const int w = least(0, few); w < enough || few == n) return w;
    return parallel_reduce(n, kHeavyGrain, INT_MAX, least, [](int a, int b) { return std::min(a, b); });
  }

  // Whether the component's own winding number is nowhere of the other sign than its volume.
  Result<bool> faces_one_way(const Component& c, const RunContext& context) const {
    if (!c.crosses_itself) return true;
    Surface own = sub_surface(surface_, c.faces).surface;
    if (c.sign < 0) own.F.col(1).swap(own.F.col(2));
    const Result<SurfaceTopology> topology = require_topology(own);
    if (!topology || !degenerate_faces(own).empty()) return false;
    TriangleBvh bvh(own.V, own.F);
    IntersectionGraph graph(own, topology.value(), bvh, find_self_intersections(own.V, own.F, bvh));
    WindingRangeOptions options;
    options.stop_at_first_negative = true;
    const Result<WindingRange> range =
        find_winding_range(own, topology.value(), bvh, graph, context, options);
    if (!range) return range.error();
    return range.value().min >= 0;
  }

  const Surface& surface_;
  const std::vector<Index>& component_of_;
  std::vector<Component> components_;
};

}  // namespace

Result<std::vector<Index>> inward_components(const Surface& surface, const std::vector<Index>& component_of,
                                             Index components, const RunContext& context) {
  const OrdinarySize sized(surface);
  return Turning(sized.surface(), component_of, components).run(context);
}

}  // namespace overtet
