#include "src/arrangement/tolerant_cutter.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "kernels/bvh/box_tree.h"
#include "src/arrangement/exact_triangulation.h"

namespace overtet {

namespace {

using Eigen::Vector3d;
using exact::Point2;
using exact::Scalar;
using exact::Triangulation;

using Edge = std::pair<Index, Index>;  // smaller vertex first

Edge edge_of(Index a, Index b) { return {std::min(a, b), std::max(a, b)}; }

struct TolerantCuts {
  std::vector<Index> points;  // in its inside
  std::vector<Edge> segments;
};

class TolerantCutter {
 public:
  TolerantCutter(std::vector<Vector3d>& points, std::vector<Piece>& pieces, double near)
      : points_(points), pieces_(pieces), near_(near) {}

  Result<ToleranceRound> run(CutIf when, const RunContext& context) {
    const auto pairs = meeting_pairs();
    std::size_t done = 0;
    for (const auto& [f, g] : pairs) {
      if (++done % 256 == 0)
        if (auto stop = context.stop()) return *stop;
      compare(f, g);
    }
    if (when == CutIf::touching && round_.touching == 0) return round_;
    for (Index f = 0; f < static_cast<Index>(pieces_.size()); ++f)
      if (pieces_[f].fresh && pieces_[f].cut) close_needle(f);
    for (auto& [edge, list] : on_edge_) sort_along(edge, list);

    std::vector<Piece> out;
    for (Index f = 0; f < static_cast<Index>(pieces_.size()); ++f) {
      if (!needs_cut(f)) {
        out.push_back(std::move(pieces_[f]));
        out.back().fresh = false;
        continue;
      }
      if (auto stop = context.stop()) return *stop;
      ++round_.cut;
      if (!triangulate(f, out))
        return Error{ErrorCode::unsolved, "Parts of the surface are too close together to be told apart."};
    }
    pieces_ = std::move(out);
    return round_;
  }

 private:
  const Vector3d& at(Index v) const { return points_[v]; }
  static bool has(const Piece& p, Index v) {
    return p.corners[0] == v || p.corners[1] == v || p.corners[2] == v;
  }

  // Pairs of pieces that have more in common than vertices, one of them fresh.
  std::vector<std::pair<Index, Index>> meeting_pairs() const {
    std::vector<std::uint8_t> fresh(pieces_.size());
    for (std::size_t f = 0; f < pieces_.size(); ++f) fresh[f] = pieces_[f].fresh;
    BoxTree tree;
    tree.build(static_cast<Index>(pieces_.size()), [&](Index f) { return box(f); });
    tree.set_active(fresh);
    auto out = tree.collect_self_pairs<std::pair<Index, Index>>([&](Index f, Index g, auto& pairs) {
      if (box(f).overlaps(box(g)) && meet(f, g)) pairs.emplace_back(f, g);
    });
    std::sort(out.begin(), out.end());
    return out;
  }

  Box box(Index f) const {
    const auto& c = pieces_[f].corners;
    Box b;
    for (int k = 0; k < 3; ++k) {
      b.low[k] = std::min({at(c[0])[k], at(c[1])[k], at(c[2])[k]});
      b.high[k] = std::max({at(c[0])[k], at(c[1])[k], at(c[2])[k]});
    }
    b.grow(near_);
    return b;
  }

  // Where on the edge its point closest to p is (0 to 1), and how far away that is.
  std::pair<double, double> along(const Edge& e, const Vector3d& p) const {
    const Vector3d d = at(e.second) - at(e.first);
    const double dd = d.squaredNorm();
    const double t = dd > 0 ? std::clamp(d.dot(p - at(e.first)) / dd, 0.0, 1.0) : 0;
    return {t, (at(e.first) + t * d - p).norm()};
  }

  struct Plane {
    Vector3d origin, normal;
    double height(const Vector3d& p) const { return normal.dot(p - origin); }
  };
  Plane plane(const Piece& p) const {
    const Vector3d a = at(p.corners[0]);
    return {a, (at(p.corners[1]) - a).cross(at(p.corners[2]) - a).normalized()};
  }
  // Over the inside of the piece, seen along its normal.
  bool over(const Piece& p, const Plane& plane, const Vector3d& x) const {
    for (int k = 0; k < 3; ++k) {
      const Vector3d a = at(p.corners[k]), b = at(p.corners[(k + 1) % 3]);
      if (!((b - a).cross(x - a).dot(plane.normal) > 0)) return false;
    }
    return true;
  }

  // Where vertex v, no corner of f, touches f: at the edge from corner 0, 1 or 2, inside (3), or nowhere
  // (-1).
  int touching(Index v, Index f, const Plane& plane) const {
    const Piece& p = pieces_[f];
    for (int k = 0; k < 3; ++k) {
      const auto [t, distance] = along(edge_of(p.corners[k], p.corners[(k + 1) % 3]), at(v));
      if (distance < near_ && t > 0 && t < 1) return k;
    }
    return std::abs(plane.height(at(v))) < near_ && over(p, plane, at(v)) ? 3 : -1;
  }

  // Writes down where v touches f.
  bool touch(Index v, Index f, const Plane& plane) {
    const int where = touching(v, f, plane);
    if (where < 0) return false;
    const auto& c = pieces_[f].corners;
    (where < 3 ? on_edge_[edge_of(c[where], c[(where + 1) % 3])] : cuts_[f].points).push_back(v);
    ++round_.touching;
    return true;
  }

  using Cell = std::array<double, 3>;
  Cell cell(const Vector3d& x) const {
    return {std::floor(x[0] / near_), std::floor(x[1] / near_), std::floor(x[2] / near_)};
  }

  // The vertex closer than the tolerance to a point, or a new one there.
  Index vertex_at(const Vector3d& x) {
    if (cells_.empty())
      for (const Piece& p : pieces_)
        for (const Index v : p.corners) {
          auto& list = cells_[cell(at(v))];
          if (std::find(list.begin(), list.end(), v) == list.end()) list.push_back(v);
        }
    const Cell c = cell(x);
    for (int i = 0; i < 27; ++i) {
      const auto there = cells_.find({c[0] + i % 3 - 1, c[1] + i / 3 % 3 - 1, c[2] + i / 9 - 1});
      if (there == cells_.end()) continue;
      for (const Index v : there->second)
        if ((at(v) - x).norm() < near_) return v;
    }
    const Index v = static_cast<Index>(points_.size());
    points_.push_back(x);
    cells_[c].push_back(v);
    return v;
  }

  // Where two edges pass each other within the tolerance.
  std::optional<Vector3d> crossing(const Edge& e, const Edge& g) const {
    if (e.first == g.first || e.first == g.second || e.second == g.first || e.second == g.second)
      return std::nullopt;
    const Edge &a = std::min(e, g), &b = std::max(e, g);
    const Vector3d d = at(a.second) - at(a.first), h = at(b.second) - at(b.first),
                   r = at(a.first) - at(b.first);
    const double dd = d.squaredNorm(), hh = h.squaredNorm(), dh = d.dot(h);
    const double det = dd * hh - dh * dh;
    if (!(det > 0)) return std::nullopt;
    const double s = (dh * h.dot(r) - hh * d.dot(r)) / det, t = (dd * h.dot(r) - dh * d.dot(r)) / det;
    if (!(s > 0 && s < 1 && t > 0 && t < 1)) return std::nullopt;
    const Vector3d x = at(a.first) + s * d, y = at(b.first) + t * h;
    if (!((x - y).norm() < near_)) return std::nullopt;
    // An end that touches the other edge stands for the crossing.
    for (const Index v : {a.first, a.second})
      if (along(b, at(v)).second < near_) return std::nullopt;
    for (const Index v : {b.first, b.second})
      if (along(a, at(v)).second < near_) return std::nullopt;
    return 0.5 * (x + y);
  }

  Index cross_edges(const Edge& e, const Edge& g) {
    const std::optional<Vector3d> x = crossing(e, g);
    if (!x) return -1;
    const Index v = vertex_at(*x);
    for (const Edge& edge : {std::min(e, g), std::max(e, g)}) on_edge_[edge].push_back(v);
    ++round_.touching;
    return v;
  }

  // Where an edge pierces the inside of piece g.
  std::optional<Vector3d> piercing(const Edge& e, Index g, const Plane& plane) const {
    const Piece& p = pieces_[g];
    if (has(p, e.first) || has(p, e.second)) return std::nullopt;
    const double h0 = plane.height(at(e.first)), h1 = plane.height(at(e.second));
    if (!(h0 * h1 < 0) || std::abs(h0) < near_ || std::abs(h1) < near_) return std::nullopt;
    const Vector3d x = at(e.first) + h0 / (h0 - h1) * (at(e.second) - at(e.first));
    if (!over(p, plane, x)) return std::nullopt;
    for (int k = 0; k < 3; ++k)
      if (along(edge_of(p.corners[k], p.corners[(k + 1) % 3]), x).second < near_) return std::nullopt;
    for (const Index v : {e.first, e.second})
      if ((at(v) - x).norm() < near_) return std::nullopt;
    return x;
  }

  Index pierce(const Edge& e, Index g, const Plane& plane) {
    const std::optional<Vector3d> x = piercing(e, g, plane);
    if (!x) return -1;
    const Index v = vertex_at(*x);
    on_edge_[e].push_back(v);
    cuts_[g].points.push_back(v);
    return v;
  }

  // Whether compare() would write anything down.
  bool meet(Index f, Index g) const {
    const Piece &p = pieces_[f], &q = pieces_[g];
    const Plane pf = plane(p), pg = plane(q);
    for (const Index v : p.corners)
      if (!has(q, v) && touching(v, g, pg) >= 0) return true;
    for (const Index v : q.corners)
      if (!has(p, v) && touching(v, f, pf) >= 0) return true;
    for (int i = 0; i < 3; ++i) {
      const Edge e = edge_of(p.corners[i], p.corners[(i + 1) % 3]);
      for (int j = 0; j < 3; ++j)
        if (crossing(e, edge_of(q.corners[j], q.corners[(j + 1) % 3]))) return true;
      if (piercing(e, g, pg) || piercing(edge_of(q.corners[i], q.corners[(i + 1) % 3]), f, pf)) return true;
    }
    return false;
  }

  void compare(Index f, Index g) {
    const Piece &p = pieces_[f], &q = pieces_[g];
    const Plane pf = plane(p), pg = plane(q);
    std::vector<Index> common;
    for (const Index v : p.corners)
      if (has(q, v) || touch(v, g, pg)) common.push_back(v);
    for (const Index v : q.corners)
      if (!has(p, v) && touch(v, f, pf)) common.push_back(v);
    const auto add = [&](Index v) {
      if (v >= 0) common.push_back(v);
    };
    for (int i = 0; i < 3; ++i) {
      const Edge e = edge_of(p.corners[i], p.corners[(i + 1) % 3]);
      for (int j = 0; j < 3; ++j) add(cross_edges(e, edge_of(q.corners[j], q.corners[(j + 1) % 3])));
      add(pierce(e, g, pg));
      add(pierce(edge_of(q.corners[i], q.corners[(i + 1) % 3]), f, pf));
    }
    std::sort(common.begin(), common.end());
    common.erase(std::unique(common.begin(), common.end()), common.end());
    if (common.size() >= 2) join(f, g, common);
  }

  // What two pieces have in common becomes a chain of edges, or a triangulated polygon, of both.
  void join(Index f, Index g, std::vector<Index>& common) {
    const auto connect = [&](Index a, Index b) {
      for (const Index i : {f, g}) {
        const Piece& p = pieces_[i];
        if (!has(p, a) || !has(p, b)) cuts_[i].segments.push_back(edge_of(a, b));
      }
    };
    // The two points farthest apart, and who is farthest from the line through them.
    Index a = common[0], b = common[1];
    for (const Index v : common)
      for (const Index w : common)
        if (v < w && (at(v) - at(w)).squaredNorm() > (at(a) - at(b)).squaredNorm()) a = v, b = w;
    const Vector3d d = (at(b) - at(a)).normalized();
    Vector3d side = Vector3d::Zero();
    for (const Index v : common) {
      const Vector3d r = at(v) - at(a), off = r - d * d.dot(r);
      if (off.norm() > side.norm()) side = off;
    }
    if (side.norm() < 4 * near_) {
      std::sort(common.begin(), common.end(), [&](Index v, Index w) {
        const double x = d.dot(at(v)), y = d.dot(at(w));
        return x != y ? x < y : v < w;
      });
      for (std::size_t i = 0; i + 1 < common.size(); ++i) connect(common[i], common[i + 1]);
      return;
    }
    side.normalize();
    Vector3d centre = Vector3d::Zero();
    for (const Index v : common) centre += at(v) / static_cast<double>(common.size());
    std::vector<std::pair<double, Index>> ring;
    for (const Index v : common)
      ring.emplace_back(std::atan2(side.dot(at(v) - centre), d.dot(at(v) - centre)), v);
    std::sort(ring.begin(), ring.end());
    for (std::size_t i = 0; i < ring.size(); ++i) connect(ring[i].second, ring[(i + 1) % ring.size()].second);
  }

  // A piece whose corner touches the opposite edge collapses.
  void close_needle(Index f) {
    const auto& c = pieces_[f].corners;
    for (int k = 0; k < 3; ++k) {
      const Edge e = edge_of(c[(k + 1) % 3], c[(k + 2) % 3]);
      const auto [t, distance] = along(e, at(c[k]));
      if (distance < near_ && t > 0 && t < 1) on_edge_[e].push_back(c[k]);
    }
  }

  void sort_along(const Edge& e, std::vector<Index>& list) const {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    const Vector3d d = at(e.second) - at(e.first);
    std::stable_sort(list.begin(), list.end(), [&](Index v, Index w) { return d.dot(at(v)) < d.dot(at(w)); });
  }

  bool needs_cut(Index f) const {
    if (cuts_.count(f)) return true;
    const auto& c = pieces_[f].corners;
    for (int k = 0; k < 3; ++k)
      if (on_edge_.count(edge_of(c[k], c[(k + 1) % 3]))) return true;
    return false;
  }

  // In the plane: points on edges lie exactly on them.
  bool triangulate(Index f, std::vector<Piece>& out) {
    const Piece piece = pieces_[f];
    const auto& corners = piece.corners;
    const Vector3d normal = plane(piece).normal;
    int drop;
    normal.cwiseAbs().maxCoeff(&drop);
    const int i = (drop + 1) % 3, j = (drop + 2) % 3;
    const auto flat = [&](Index v) { return Point2(at(v)[i], at(v)[j]); };
    const Point2 base[3] = {flat(corners[0]), flat(corners[1]), flat(corners[2])};
    const CGAL::Orientation turn = CGAL::orientation(base[0], base[1], base[2]);
    if (turn == CGAL::COLLINEAR) return false;

    std::map<Index, Point2> place;
    for (int k = 0; k < 3; ++k) place.emplace(corners[k], base[k]);
    for (int k = 0; k < 3; ++k) {
      const auto on = on_edge_.find(edge_of(corners[k], corners[(k + 1) % 3]));
      if (on == on_edge_.end()) continue;
      for (const Index v : on->second) {
        if (has(piece, v)) return true;  // it has collapsed
        const double t = along(on->first, at(v)).first;
        const int from = corners[k] == on->first.first ? k : (k + 1) % 3;
        const Point2 &a = base[from], &b = base[from == k ? (k + 1) % 3 : k];
        place.emplace(v, a + Scalar(t) * (b - a));
      }
    }
    static const TolerantCuts kNone;
    const auto found = cuts_.find(f);
    const TolerantCuts& cuts = found == cuts_.end() ? kNone : found->second;
    for (const Index v : cuts.points) place.emplace(v, flat(v));

    Triangulation triangulation;
    std::map<Index, Triangulation::Vertex_handle> handle;
    for (const auto& [v, p] : place) {
      const auto h = triangulation.insert(p);
      if (h->info().id >= 0) return false;
      h->info().id = v;
      handle[v] = h;
    }
    for (const auto& [a, b] : cuts.segments) {
      const auto p = handle.find(a), q = handle.find(b);
      if (p == handle.end() || q == handle.end()) return false;
      triangulation.insert_constraint(p->second, q->second);
    }
    const Vector3d origin = at(corners[0]);
    for (auto v = triangulation.finite_vertices_begin(); v != triangulation.finite_vertices_end(); ++v) {
      if (v->info().id >= 0) continue;
      Vector3d x;
      x[i] = CGAL::to_double(v->point().x());
      x[j] = CGAL::to_double(v->point().y());
      x[drop] =
          origin[drop] - (normal[i] * (x[i] - origin[i]) + normal[j] * (x[j] - origin[j])) / normal[drop];
      if (!x.allFinite()) return false;  // too small for doubles
      v->info().id = static_cast<Index>(points_.size());
      points_.push_back(x);
    }
    for (auto t = triangulation.finite_faces_begin(); t != triangulation.finite_faces_end(); ++t) {
      Piece part{{t->vertex(0)->info().id, t->vertex(1)->info().id, t->vertex(2)->info().id},
                 piece.sheet,
                 piece.more,
                 true};
      if (turn == CGAL::CLOCKWISE) std::swap(part.corners[1], part.corners[2]);
      out.push_back(std::move(part));
    }
    return true;
  }

  std::vector<Vector3d>& points_;
  std::vector<Piece>& pieces_;
  const double near_;
  ToleranceRound round_;
  std::map<Edge, std::vector<Index>> on_edge_;
  std::map<Index, TolerantCuts> cuts_;
  std::map<Cell, std::vector<Index>> cells_;  // vertices, by cells of the tolerance's size
};

}  // namespace

Result<ToleranceRound> cut_with_tolerance(std::vector<Eigen::Vector3d>& points, std::vector<Piece>& pieces,
                                          double tolerance, CutIf when, const RunContext& context) {
  return TolerantCutter(points, pieces, tolerance).run(when, context);
}

}  // namespace overtet
