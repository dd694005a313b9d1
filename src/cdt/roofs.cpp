#include "src/cdt/roofs.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "kernels/bvh/bvh.h"
#include "kernels/bvh/self_intersections.h"
#include "kernels/core/box.h"
#include "kernels/core/tuning.h"
#include "kernels/predicates/predicates.h"
#include "src/cdt/tuning.h"

namespace overtet {

namespace {

using Eigen::Vector3d;
using Triple = std::array<Index, 3>;

bool positive(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  return orient3d(a.data(), b.data(), c.data(), d.data()) > 0;
}

// Edges of an outline that share a point of the roof.
struct Run {
  std::size_t first = 0, count = 0;
  double towards = 0;  // where the point is: from the middle of the run to the centre, as a share
};

// The roof over one area. Numbers of its vertices: of the outline, then the points of the runs, then the
// middle.
class Roof {
 public:
  Roof(const Surface& s, const StarArea& area) : area_(&area) {
    for (const Index v : area.outline) rim_.emplace_back(s.V.row(v));
    make_runs();
  }

  // False where no arrangement of the points serves.
  bool arrange() {
    for (int round = 0; round < kMostRounds; ++round) {
      place_points();
      const std::vector<char> wrong = misplaced();
      if (std::none_of(wrong.begin(), wrong.end(), [](char w) { return w; })) {
        connect();
        return true;
      }
      refine(wrong);
    }
    return false;
  }

  // depth_at(p): how far it is from a point of the area to what is opposite.
  template <class DepthAt>
  void lower(DepthAt&& depth_at) {
    depth_.clear();
    double most = 0;
    for (std::size_t r = 0; r < runs_.size(); ++r) {
      depth_.push_back(
          std::min(0.5 * (points_[r] - middle_of(runs_[r])).norm(), kRoofDepth * depth_at(points_[r])));
      most = std::max(most, depth_.back());
    }
    depth_.push_back(std::min(most, kRoofDepth * depth_at(area_->centre)));
  }
  void halve() {
    for (double& d : depth_) d /= 2;
  }

  std::size_t added() const { return points_.size() + 1; }
  Vector3d vertex(std::size_t i) const {
    if (i < rim_.size()) return rim_[i];
    i -= rim_.size();
    return (i < points_.size() ? points_[i] : area_->centre) + depth_[i] * area_->inwards;
  }
  const std::vector<Triple>& faces() const { return faces_; }  // turn like the area's

  // A point that sees the roof from above and the area's faces from below, both exactly; none: there is none.
  std::optional<Vector3d> hub(const Surface& s) const {
    double least = std::numeric_limits<double>::infinity();  // of the planes of the roof, under the centre
    for (const Triple& f : faces_) {
      const Vector3d a = vertex(f[0]), n = (vertex(f[1]) - a).cross(vertex(f[2]) - a);
      least = std::min(least, n.dot(a - area_->centre) / n.dot(area_->inwards));
    }
    for (double share = 0.5; share > kPrecise; share /= 4) {
      const Vector3d p = area_->centre + share * least * area_->inwards;
      const bool above = std::all_of(faces_.begin(), faces_.end(), [&](const Triple& f) {
        return positive(vertex(f[0]), vertex(f[1]), vertex(f[2]), p);
      });
      const bool below = std::all_of(area_->faces.begin(), area_->faces.end(), [&](Index f) {
        return positive(s.V.row(s.F(f, 0)), s.V.row(s.F(f, 2)), s.V.row(s.F(f, 1)), p);
      });
      if (above && below) return p;
      if (!below) return std::nullopt;
    }
    return std::nullopt;
  }

 private:
  const Vector3d& rim(std::size_t i) const { return rim_[i % rim_.size()]; }
  double length(std::size_t edge) const { return (rim(edge + 1) - rim(edge)).norm(); }
  // Whether a, b, c turn like the area.
  bool turns(const Vector3d& a, const Vector3d& b, const Vector3d& c) const {
    return (b - a).cross(c - a).dot(area_->inwards) < 0;
  }

  double length(const Run& run) const {
    double sum = 0;
    for (std::size_t i = 0; i < run.count; ++i) sum += length(run.first + i);
    return sum;
  }
  Vector3d middle_of(const Run& run) const {
    double left = length(run) / 2;
    std::size_t e = run.first;
    while (e + 1 < run.first + run.count && left > length(e)) left -= length(e++);
    const double whole = length(e);
    return rim(e) + (whole > 0 ? std::min(1.0, left / whole) : 0.5) * (rim(e + 1) - rim(e));
  }

  // As long as the outline does not turn too far, and the centre is farther away than the run is long.
  void make_runs() {
    const std::size_t n = rim_.size();
    std::size_t start = 0;  // after the longest edge
    for (std::size_t e = 0; e < n; ++e)
      if (length(e) > length((start + n - 1) % n)) start = (e + 1) % n;
    for (std::size_t e = start; e < start + n;) {
      Run run{e, 1, 0};
      double sum = length(e), turn = 0;
      for (++e; e < start + n; ++e, ++run.count) {
        const Vector3d a = rim(e) - rim(e - 1), b = rim(e + 1) - rim(e);
        turn += std::atan2(a.cross(b).norm(), a.dot(b));
        sum += length(e);
        if (turn > kMostTurn || sum > 0.5 * (rim(e) - area_->centre).norm()) break;
      }
      add(run);
    }
    while (runs_.size() < 3 && split(0)) {
    }
  }
  void add(Run run) {
    const double away = (area_->centre - middle_of(run)).norm();
    run.towards = away > 0 ? std::min(0.5, kRoofInset * length(run) / away) : 0.5;
    runs_.push_back(run);
  }
  // The run becomes two; false where it is one edge.
  bool split(std::size_t r) {
    const Run run = runs_[r];
    if (run.count < 2) return false;
    std::vector<Run> after(runs_.begin() + static_cast<std::ptrdiff_t>(r) + 1, runs_.end());
    runs_.resize(r);
    add({run.first, run.count / 2, 0});
    add({run.first + run.count / 2, run.count - run.count / 2, 0});
    runs_.insert(runs_.end(), after.begin(), after.end());
    return true;
  }

  void place_points() {
    points_.clear();
    for (const Run& run : runs_) {
      const Vector3d m = middle_of(run);
      points_.push_back(m + run.towards * (area_->centre - m));
    }
  }

  // The runs whose triangles do not all turn like the area.
  std::vector<char> misplaced() const {
    const std::size_t n = runs_.size();
    std::vector<char> wrong(n, 0);
    for (std::size_t r = 0; r < n; ++r) {
      const Run& run = runs_[r];
      const std::size_t next = (r + 1) % n;
      for (std::size_t e = run.first; e < run.first + run.count; ++e)
        if (!turns(rim(e), rim(e + 1), points_[r])) wrong[r] = 1;
      if (!turns(rim(run.first + run.count), points_[next], points_[r]) ||
          !turns(points_[r], points_[next], area_->centre))
        wrong[r] = wrong[next] = 1;
    }
    return wrong;
  }
  // Shorter runs, and points nearer to the centre.
  void refine(const std::vector<char>& wrong) {
    for (std::size_t r = wrong.size(); r-- > 0;) {
      if (!wrong[r] || split(r)) continue;
      runs_[r].towards = (1 + runs_[r].towards) / 2;
    }
  }

  void connect() {
    faces_.clear();
    const auto n = static_cast<Index>(rim_.size()), m = static_cast<Index>(runs_.size());
    for (Index r = 0; r < m; ++r) {
      const Run& run = runs_[r];
      const Index here = n + r, next = n + (r + 1) % m;
      for (std::size_t e = run.first; e < run.first + run.count; ++e)
        faces_.push_back({static_cast<Index>(e) % n, static_cast<Index>(e + 1) % n, here});
      faces_.push_back({static_cast<Index>(run.first + run.count) % n, next, here});
      faces_.push_back({here, next, n + m});
    }
  }

  const StarArea* area_;
  std::vector<Vector3d> rim_;
  std::vector<Run> runs_;
  std::vector<Vector3d> points_;  // in the plane; of each run
  std::vector<double> depth_;     // of each of these, and of the middle
  std::vector<Triple> faces_;
};

// How far the surface is from a point of it, along a direction; doubles will do.
double far_side(const Surface& s, const TriangleBvh& bvh, const Vector3d& p, const Vector3d& d, double size) {
  double nearest = size;
  bvh.query_ray(p.data(), d.data(), 0, [&](Index f) {
    const Vector3d a = s.V.row(s.F(f, 0)), b = s.V.row(s.F(f, 1)), c = s.V.row(s.F(f, 2));
    const Vector3d n = (b - a).cross(c - a);
    const double down = n.dot(d), t = down > 0 ? n.dot(a - p) / down : 0;
    if (!(t > kRounding * size && t < nearest)) return;
    const Vector3d end = p + 2 * t * d;
    if (segment_triangle_intersect(p.data(), end.data(), a.data(), b.data(), c.data())) nearest = t;
  });
  return nearest;
}

class Roofer {
 public:
  Roofer(const Surface& s, const std::vector<StarArea>& areas, const RunContext& context)
      : s_(s), areas_(areas), context_(context) {}

  Result<RoofedSurface> run() {
    TriangleBvh bvh(s_.V, s_.F);
    const double size = diagonal_of(s_.V);
    for (std::size_t i = 0; i < areas_.size(); ++i) {
      if (auto stop = context_.stop()) return *stop;
      Roof roof(s_, areas_[i]);
      if (!roof.arrange()) continue;
      roof.lower([&](const Vector3d& p) { return far_side(s_, bvh, p, areas_[i].inwards, size); });
      roofs_.push_back({i, std::move(roof)});
    }
    // Those that cross something are lowered, and given up at last.
    for (int round = 0; !roofs_.empty(); ++round) {
      if (auto stop = context_.stop()) return *stop;
      build();
      const std::vector<char> crossing = crossed();
      if (std::none_of(crossing.begin(), crossing.end(), [](char c) { return c; })) break;
      std::vector<Raised> left;
      for (std::size_t r = 0; r < roofs_.size(); ++r) {
        if (crossing[r] && round == kMostRounds) continue;
        if (crossing[r]) roofs_[r].roof.halve();
        left.push_back(std::move(roofs_[r]));
      }
      roofs_ = std::move(left);
    }
    if (roofs_.empty()) build();
    return std::move(out_);
  }

 private:
  struct Raised {
    std::size_t area;
    Roof roof;
  };

  // With the roofs there are, all of which get a hub or go.
  void build() {
    std::vector<Vector3d> hubs;
    std::erase_if(roofs_, [&](const Raised& r) {
      const auto hub = r.roof.hub(s_);
      if (hub) hubs.push_back(*hub);
      return !hub;
    });
    std::vector<char> covered(static_cast<std::size_t>(s_.F.rows()), 0);
    for (const Raised& r : roofs_)
      for (const Index f : areas_[r.area].faces) covered[f] = 1;
    out_ = {};
    std::vector<Index> number(static_cast<std::size_t>(s_.V.rows()), -1);
    std::vector<Triple> faces;
    for (Index f = 0; f < s_.F.rows(); ++f)
      if (!covered[f]) faces.push_back({s_.F(f, 0), s_.F(f, 1), s_.F(f, 2)});
    owner_.assign(faces.size(), -1);
    const auto n = static_cast<Index>(s_.V.rows());
    std::vector<Vector3d> added;
    std::vector<std::array<Index, 4>> slabs;
    Index all_added = 0;
    for (const Raised& r : roofs_) all_added += static_cast<Index>(r.roof.added());
    for (std::size_t r = 0; r < roofs_.size(); ++r) {
      const StarArea& area = areas_[roofs_[r].area];
      const Roof& roof = roofs_[r].roof;
      const auto rim = static_cast<Index>(area.outline.size()), first = n + static_cast<Index>(added.size());
      const Index hub = n + all_added + static_cast<Index>(r);
      for (std::size_t i = 0; i < roof.added(); ++i)
        added.push_back(roof.vertex(static_cast<std::size_t>(rim) + i));
      for (Triple f : roof.faces()) {
        for (Index& v : f) v = v < rim ? area.outline[v] : first + v - rim;
        faces.push_back(f);
        owner_.push_back(static_cast<Index>(r));
        slabs.push_back({f[0], f[1], f[2], hub});
      }
      for (const Index f : area.faces) slabs.push_back({s_.F(f, 0), s_.F(f, 2), s_.F(f, 1), hub});
    }
    for (const Triple& f : faces)
      for (const Index v : f)
        if (v < n) number[v] = 0;
    for (Index v = 0; v < n; ++v)
      if (number[v] == 0) {
        number[v] = static_cast<Index>(out_.vertex.size());
        out_.vertex.push_back(v);
      }
    const auto kept = static_cast<Index>(out_.vertex.size());
    out_.roof_vertices = static_cast<Index>(added.size());
    Surface& s = out_.surface;
    s.V.resize(kept + out_.roof_vertices, 3);
    for (Index v = 0; v < kept; ++v) s.V.row(v) = s_.V.row(out_.vertex[v]);
    for (std::size_t i = 0; i < added.size(); ++i) s.V.row(kept + static_cast<Index>(i)) = added[i];
    s.F.resize(static_cast<Eigen::Index>(faces.size()), 3);
    for (std::size_t f = 0; f < faces.size(); ++f)
      for (int k = 0; k < 3; ++k)
        s.F(static_cast<Index>(f), k) = faces[f][k] < n ? number[faces[f][k]] : faces[f][k] - n + kept;
    out_.hubs.resize(static_cast<Eigen::Index>(hubs.size()), 3);
    for (std::size_t i = 0; i < hubs.size(); ++i) out_.hubs.row(static_cast<Index>(i)) = hubs[i];
    out_.slabs.resize(static_cast<Eigen::Index>(slabs.size()), 4);
    for (std::size_t t = 0; t < slabs.size(); ++t)
      for (int k = 0; k < 4; ++k) out_.slabs(static_cast<Index>(t), k) = slabs[t][k];
  }

  // Of each roof, whether it intersects something.
  std::vector<char> crossed() const {
    SelfIntersectionOptions options;
    for (const Index r : owner_) options.active.push_back(r >= 0);
    std::vector<char> out(roofs_.size(), 0);
    for (const auto& [f, g] : find_self_intersections(out_.surface.V, out_.surface.F, options))
      for (const Index face : {f, g})
        if (owner_[face] >= 0) out[owner_[face]] = 1;
    return out;
  }

  const Surface& s_;
  const std::vector<StarArea>& areas_;
  const RunContext& context_;
  std::vector<Raised> roofs_;
  std::vector<Index> owner_;  // of each face of the result: its roof, or -1
  RoofedSurface out_;
};

}  // namespace

Result<RoofedSurface> raise_roofs(const Surface& surface, const std::vector<StarArea>& areas,
                                  const RunContext& context) {
  return Roofer(surface, areas, context).run();
}

}  // namespace overtet
