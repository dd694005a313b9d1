#include "src/cdt/star_areas.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "kernels/core/box.h"
#include "kernels/core/tuning.h"
#include "kernels/predicates/predicates.h"
#include "src/cdt/tuning.h"
#include "src/mesh/topology.h"

namespace overtet {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct Plane {
  Vector3d normal, point;
};

struct Shape {
  bool needle;
  double height;  // over the longest side
};

Shape shape_of(const Surface& s, Index f) {
  const Vector3d a = s.V.row(s.F(f, 0)), b = s.V.row(s.F(f, 1)), c = s.V.row(s.F(f, 2));
  std::array<double, 3> side{(b - a).norm(), (c - b).norm(), (a - c).norm()};
  std::sort(side.begin(), side.end());
  const double area = (b - a).cross(c - a).norm();
  return {area<kThinFace * side[1] * side[2], side[2]> 0 ? area / side[2] : 0};
}

class AreaFinder {
 public:
  AreaFinder(const Surface& s, const SurfaceTopology& topology, const RunContext& context)
      : s_(s), topology_(topology), context_(context) {
    const auto n = static_cast<std::size_t>(s.F.rows());
    needle_.resize(n);
    height_.resize(n);
    place_.assign(n, kNowhere);
    size_ = diagonal_of(s.V);
    for (Index f = 0; f < s.F.rows(); ++f) {
      const Shape shape = shape_of(s, f);
      needle_[f] = shape.needle;
      height_[f] = shape.height;
    }
  }

  // Faces with reliable normals first: each tells a plane.
  Result<std::vector<StarArea>> run() {
    std::vector<Index> order;
    for (Index f = 0; f < s_.F.rows(); ++f)
      if (needle_[f]) order.push_back(f);
    std::stable_sort(order.begin(), order.end(), [&](Index f, Index g) { return height_[f] > height_[g]; });
    for (const Index seed : order) {
      if (auto stop = context_.stop()) return *stop;
      if (place_[seed] != kNowhere) continue;
      const auto [plane, faces] = flat_around(seed);
      for (const Index f : faces) place_[f] = kWaiting;
      if (is_flat(plane, faces)) cut_into_stars(plane, faces);
      for (const Index f : faces) place_[f] = kDone;
    }
    return std::move(areas_);
  }

 private:
  enum Place : char { kNowhere, kWaiting, kTaken, kDone };

  Vector3d corner(Index f, int k) const { return s_.V.row(s_.F(f, k % 3)); }
  Vector3d doubled_area(Index f) const {
    return (corner(f, 1) - corner(f, 0)).cross(corner(f, 2) - corner(f, 0));
  }

  // Connected faces that lie in the plane and face the same way as it does, in order.
  std::vector<Index> flood(Index seed, const Plane& plane) {
    std::vector<Index> faces{seed};
    std::vector<char>& place = place_;
    place[seed] = kTaken;
    for (std::size_t head = 0; head < faces.size(); ++head)
      for (int k = 0; k < 3; ++k) {
        const Index g = half_edge_face(topology_.twin[3 * faces[head] + k]);
        if (place[g] != kNowhere || !(doubled_area(g).dot(plane.normal) > 0)) continue;
        bool near = true;
        for (int j = 0; j < 3; ++j)
          near = near && std::abs((corner(g, j) - plane.point).dot(plane.normal)) <= kNearPlane * size_;
        if (!near) continue;
        place[g] = kTaken;
        faces.push_back(g);
      }
    for (const Index f : faces) place[f] = kNowhere;
    return faces;
  }

  // The plane of a needle is not known well; that of all faces beside it is, once they are known.
  std::pair<Plane, std::vector<Index>> flat_around(Index seed) {
    std::vector<Index> faces{seed};
    Plane plane;
    for (int round = 0; round < kInVain; ++round) {
      Vector3d normal = Vector3d::Zero(), sum = Vector3d::Zero();
      for (const Index f : faces) {
        normal += doubled_area(f);
        sum += corner(f, 0) + corner(f, 1) + corner(f, 2);
      }
      plane = {normal.normalized(), sum / (3.0 * static_cast<double>(faces.size()))};
      std::vector<Index> more = flood(seed, plane);
      const bool grown = more.size() > faces.size();
      faces = std::move(more);
      if (!grown) break;
    }
    return {plane, std::move(faces)};
  }

  // Not a narrow strip of something round, whose triangles are thin because it is.
  bool is_flat(const Plane& plane, const std::vector<Index>& faces) const {
    double area = 0, off = 0, extent = 0;
    for (const Index f : faces) {
      area += doubled_area(f).norm() / 2;
      for (int k = 0; k < 3; ++k) {
        const Vector3d p = corner(f, k) - plane.point;
        off = std::max(off, std::abs(p.dot(plane.normal)));
        extent = std::max(extent, p.norm());
      }
    }
    return off * extent <= kFlatness * area;
  }

  // Coordinates in the plane that turn as one sees it from outside: two of the three, so that nothing is
  // rounded.
  void look_along(const Vector3d& normal) {
    int drop = 0;
    normal.cwiseAbs().maxCoeff(&drop);
    x_ = (drop + 1) % 3;
    y_ = (drop + 2) % 3;
    if (normal[drop] < 0) std::swap(x_, y_);
  }
  Vector2d flat(const Vector3d& p) const { return {p[x_], p[y_]}; }
  Vector2d flat(Index v) const { return {s_.V(v, x_), s_.V(v, y_)}; }
  bool sees(const Vector2d& p, Index u, Index v) const {
    const Vector2d a = flat(u), b = flat(v);
    return orient2d(a.data(), b.data(), p.data()) > 0;
  }
  bool contains(Index f, const Vector2d& p) const {
    return sees(p, s_.F(f, 0), s_.F(f, 1)) && sees(p, s_.F(f, 1), s_.F(f, 2)) &&
           sees(p, s_.F(f, 2), s_.F(f, 0));
  }

  // The faces of kWaiting around a face that the point in it sees: each whose third corner lies between the
  // ends of the edge over which it is reached, and whose own plane passes by the point closely enough to be
  // seen from a little below.
  std::vector<Index> seen_from(const Vector3d& centre, Index start, double near) {
    const Vector2d p = flat(centre);
    std::vector<Index> faces{start};
    place_[start] = kTaken;
    for (std::size_t head = 0; head < faces.size(); ++head)
      for (int k = 0; k < 3; ++k) {
        const Index h = topology_.twin[3 * faces[head] + k], g = half_edge_face(h);
        if (place_[g] != kWaiting) continue;
        const Vector3d n = doubled_area(g);
        bool good = std::abs(n.dot(centre - corner(g, 0))) <= near * n.norm();
        for (const Index side : {next_half_edge(h), previous_half_edge(h)})
          good = good && (place_[half_edge_face(topology_.twin[side])] == kTaken ||
                          sees(p, half_edge_source(s_.F, side), half_edge_target(s_.F, side)));
        if (!good) continue;
        place_[g] = kTaken;
        faces.push_back(g);
      }
    for (const Index f : faces) place_[f] = kWaiting;
    return faces;
  }

  std::int64_t needles_among(const std::vector<Index>& faces) const {
    return std::count_if(faces.begin(), faces.end(), [&](Index f) { return needle_[f]; });
  }

  // Places to look from: the middle of all, and those of some faces, the best shaped ones and others.
  std::vector<std::pair<Vector3d, Index>> places(const std::vector<Index>& waiting) const {
    Vector3d middle = Vector3d::Zero();
    double weight = 0;
    const auto middle_of = [&](Index f) {
      return Vector3d((corner(f, 0) + corner(f, 1) + corner(f, 2)) / 3);
    };
    for (const Index f : waiting) {
      const double area = doubled_area(f).norm();
      middle += area * middle_of(f);
      weight += area;
    }
    std::vector<std::pair<Vector3d, Index>> out;
    if (weight > 0) middle /= weight;
    for (const Index f : waiting)
      if (contains(f, flat(middle))) out.emplace_back(middle, f);
    std::vector<Index> order = waiting;
    const std::size_t some = std::min<std::size_t>(order.size(), kRings);
    std::partial_sort(
        order.begin(), order.begin() + static_cast<std::ptrdiff_t>(some), order.end(),
        [&](Index f, Index g) { return height_[f] != height_[g] ? height_[f] > height_[g] : f < g; });
    for (std::size_t i = 0; i < some; ++i) out.emplace_back(middle_of(order[i]), order[i]);
    for (std::size_t i = 0; i < kLookouts; ++i) {
      const Index f = waiting[(2 * i + 1) * waiting.size() / (2 * kLookouts)];
      out.emplace_back(middle_of(f), f);
    }
    return out;
  }

  void cut_into_stars(const Plane& plane, std::vector<Index> waiting) {
    look_along(plane.normal);
    double area = 0;
    for (const Index f : waiting) area += doubled_area(f).norm() / 2;
    const double near = kFlatness * std::sqrt(area);
    std::erase_if(waiting, [&](Index f) {
      const bool turned =
          orient2d(flat(s_.F(f, 0)).data(), flat(s_.F(f, 1)).data(), flat(s_.F(f, 2)).data()) <= 0;
      if (turned) place_[f] = kDone;
      return turned;
    });
    const std::size_t most_areas = areas_.size() + kMostStars;
    for (int vain = 0;
         vain < kInVain && areas_.size() < most_areas && needles_among(waiting) > kFewNeedles;) {
      if (context_.stop()) return;
      std::vector<Index> best;
      std::int64_t most = kFewNeedles;
      Vector3d centre;
      for (auto& [p, f] : places(waiting)) {
        p -= (p - plane.point).dot(plane.normal) * plane.normal;
        std::vector<Index> faces = seen_from(p, f, near);
        if (const std::int64_t n = needles_among(faces); n > most)
          most = n, best = std::move(faces), centre = p;
      }
      if (best.empty()) return;
      std::optional<std::vector<Index>> outline = outline_of(best);
      for (const Index f : best) place_[f] = kDone;
      std::erase_if(waiting, [&](Index f) { return place_[f] == kDone; });
      vain = outline ? 0 : vain + 1;
      if (!outline) continue;
      std::sort(best.begin(), best.end());
      areas_.push_back({std::move(best), std::move(*outline), centre, -plane.normal});
    }
  }

  // One closed line that passes through no vertex twice, or nothing.
  std::optional<std::vector<Index>> outline_of(const std::vector<Index>& faces) {
    for (const Index f : faces) place_[f] = kTaken;
    Index first = -1;
    std::size_t edges = 0;
    for (const Index f : faces)
      for (int k = 0; k < 3; ++k)
        if (place_[half_edge_face(topology_.twin[3 * f + k])] != kTaken) {
          ++edges;
          first = 3 * f + k;
        }
    std::vector<Index> line;
    for (Index h = first; h >= 0 && line.size() <= edges;) {
      line.push_back(half_edge_source(s_.F, h));
      for (h = next_half_edge(h); place_[half_edge_face(topology_.twin[h])] == kTaken;)
        h = next_half_edge(topology_.twin[h]);
      if (h == first) break;
    }
    for (const Index f : faces) place_[f] = kWaiting;
    std::vector<Index> once = line;
    std::sort(once.begin(), once.end());
    const bool simple = std::adjacent_find(once.begin(), once.end()) == once.end();
    return simple && line.size() == edges ? std::optional(std::move(line)) : std::nullopt;
  }

  const Surface& s_;
  const SurfaceTopology& topology_;
  const RunContext& context_;
  std::vector<char> needle_, place_;
  std::vector<double> height_;
  double size_ = 0;
  int x_ = 0, y_ = 1;  // the coordinates that are looked at
  std::vector<StarArea> areas_;
};

}  // namespace

Result<std::vector<StarArea>> find_star_areas(const Surface& surface, const RunContext& context) {
  std::int64_t needles = 0;
  for (Index f = 0; f < surface.F.rows(); ++f) needles += shape_of(surface, f).needle;
  if (needles <= kFewNeedles) return std::vector<StarArea>();
  const Result<SurfaceTopology> topology = require_topology(surface);
  if (!topology) return topology.error();
  return AreaFinder(surface, topology.value(), context).run();
}

}  // namespace overtet
