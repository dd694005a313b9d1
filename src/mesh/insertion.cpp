// LocalOperations: new vertices in cavities, for quality and for Delaunay refinement.
#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>

#include "kernels/core/tet_tables.h"
#include "kernels/core/tuning.h"
#include "kernels/core/union_find.h"
#include "kernels/predicates/predicates.h"
#include "kernels/tet_energy/tet_quality.h"
#include "src/mesh/local_operations.h"
#include "src/mesh/tuning.h"

namespace overtet {

namespace {

using Eigen::Vector3d;

}  // namespace

bool LocalOperations::hull_of(const Tets& cavity, std::vector<Face>& hull) {
  const std::uint32_t inside = ++tet_stamp_;
  for (const Index t : cavity) tet_mark_[t] = inside;
  hull.clear();
  const std::uint32_t seen = ++vertex_stamp_;
  std::size_t vertices = 0;
  for (const Index t : cavity)
    for (int k = 0; k < 4; ++k) {
      const Index u = mesh_.neighbour(t, k);
      if (u >= 0 && tet_mark_[u] == inside) continue;
      hull.push_back(inner_face(t, k));
      for (const Index v : hull.back())
        if (vertex_mark_[v] != seen) {
          vertex_mark_[v] = seen;
          ++vertices;
        }
    }
  // A fixed vertex must not vanish.
  for (const Index t : cavity)
    for (const Index v : mesh_.tet(t))
      if (fixed_[v] && vertex_mark_[v] != seen) return false;
  // A sphere: every edge twice, Euler's number 2, connected across edges.
  struct Edge {
    Index a, b, face;  // the first face; -1 when the second one has been met
  };
  static thread_local std::vector<Edge> edges;
  static thread_local std::vector<Index> slots;
  static thread_local UnionFind pieces;
  if (hull.size() % 2 != 0) return false;
  edges.clear();
  pieces.reset(hull.size());
  const std::size_t mask = std::bit_ceil(4 * hull.size()) - 1;
  slots.assign(mask + 1, -1);
  std::size_t piece_count = hull.size();
  for (std::size_t f = 0; f < hull.size(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const Index x = hull[f][k], y = hull[f][(k + 1) % 3], a = std::min(x, y), b = std::max(x, y);
      std::size_t at = (static_cast<std::size_t>(a) * 0x9E3779B97F4A7C15u +
                        static_cast<std::size_t>(b) * 0xC2B2AE3D27D4EB4Fu) >>
                           20 &
                       mask;
      while (slots[at] >= 0 && (edges[slots[at]].a != a || edges[slots[at]].b != b)) at = (at + 1) & mask;
      if (slots[at] < 0) {
        slots[at] = static_cast<Index>(edges.size());
        edges.push_back({a, b, static_cast<Index>(f)});
        continue;
      }
      Edge& e = edges[slots[at]];
      if (e.face < 0) return false;
      if (pieces.join(static_cast<Index>(f), e.face)) --piece_count;
      e.face = -1;
    }
  }
  // No edge has three faces, and there are half as many edges as sides: each has two.
  return edges.size() == 3 * hull.size() / 2 && piece_count == 1 &&
         vertices + hull.size() == edges.size() + 2;
}

bool LocalOperations::insert(Tets& cavity, const Vector3d& start, double gain) {
  if (!hull_of(cavity, hull_)) return false;
  double old_worst = worst(cavity);
  Vector3d x = start;
  faces_ = hull_;
  load_bases();
  double q = quality_at(x, 0);
  if (!(q > 0)) return false;
  q = optimise(x, q, 3);
  // Take in the neighbour behind the face that makes the worst tet, as long as that helps.
  for (int growth = 0; growth < kMostGrowth && cavity.size() < kLargestCavity; ++growth) {
    double least = HUGE_VAL;
    Face at{};
    for (const Face& f : hull_) {
      const double here =
          min_dihedral_sine(mesh_.position(f[0]), mesh_.position(f[1]), mesh_.position(f[2]), x);
      if (here < least) {
        least = here;
        at = f;
      }
    }
    const std::uint32_t inside = tet_stamp_;  // of the last hull_of(), which was this cavity's
    Index beyond = -1;
    for (const Index t : cavity)
      for (int k = 0; k < 4 && beyond < 0; ++k) {
        const Index u = mesh_.neighbour(t, k);
        if (u >= 0 && tet_mark_[u] != inside && inner_face(t, k) == at) beyond = u;
      }
    if (beyond < 0) break;
    cavity.push_back(beyond);
    bool better = hull_of(cavity, grown_hull_);
    if (better) {
      faces_ = grown_hull_;
      load_bases();
      Vector3d moved = x;
      double grown = quality_at(moved, 0);
      if (grown > 0) grown = optimise(moved, grown, 2);
      better = grown > q;
      if (better) {
        q = grown;
        x = moved;
        std::swap(hull_, grown_hull_);
        old_worst = std::min(old_worst, quality_[beyond]);
      }
    }
    if (!better) {
      cavity.pop_back();
      break;
    }
  }
  faces_ = hull_;
  load_bases();
  q = optimise(x, quality_at(x, 0), 6);
  if (!(q > old_worst * gain)) return false;
  return fill(cavity, x);
}

double LocalOperations::grow_cavity(Index t, const Vector3d& x, double need, std::size_t most,
                                    Judged judged) {
  cavity_ = {t};
  const std::uint32_t inside = ++tet_stamp_;
  tet_mark_[t] = inside;
  for (std::size_t i = 0; i < cavity_.size(); ++i)
    for (int k = 0; k < 4; ++k) {
      const Index u = mesh_.neighbour(cavity_[i], k);
      if (u >= 0 ? tet_mark_[u] == inside : judged == Judged::inside) continue;
      const Face f = inner_face(cavity_[i], k);
      if (min_dihedral_sine(mesh_.position(f[0]), mesh_.position(f[1]), mesh_.position(f[2]), x) > need)
        continue;
      if (u < 0 || cavity_.size() == most) return 0;
      tet_mark_[u] = inside;
      cavity_.push_back(u);
    }
  if (!hull_of(cavity_, hull_)) return 0;
  faces_ = hull_;
  load_bases();
  return quality_at(x, 0);
}

bool LocalOperations::insert_near(Index t, const Vector3d& start, double gain) {
  Vector3d x = start;
  double q = 0;
  for (const double part : kPartsOfAim) {
    q = grow_cavity(t, x, part * gain * quality_[t], kLargestCavity,
                    part < 1 ? Judged::inside : Judged::boundary_too);
    if (!(q > 0)) return false;
    q = optimise(x, q, 4);
  }
  return q > gain * worst(cavity_) && fill(cavity_, x);
}

std::vector<Vector3d> LocalOperations::places_around(Index t) const {
  const auto middle = [&](Index u) -> Vector3d {
    const auto& c = mesh_.tet(u);
    return (mesh_.position(c[0]) + mesh_.position(c[1]) + mesh_.position(c[2]) + mesh_.position(c[3])) / 4;
  };
  std::vector<Vector3d> places{middle(t)};
  for (int k = 0; k < 4; ++k)
    if (const Index u = mesh_.neighbour(t, k); u >= 0) places.push_back(middle(u));
  const auto& c = mesh_.tet(t);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < i; ++j) places.push_back((mesh_.position(c[i]) + mesh_.position(c[j])) / 2);
  return places;
}

bool LocalOperations::insert_around(Index t, double gain) {
  const std::vector<Vector3d> starts = places_around(t);
  return std::any_of(starts.begin(), starts.end(),
                     [&](const Vector3d& x) { return insert_near(t, x, gain); });
}

bool LocalOperations::seen_once(const Vector3d& x) const {
  // Every face is seen from the same side, so each direction meets equally many of them: count in one. Where
  // it passes too near to an edge, the solid angles are added up.
  const auto from_x = [&](Index v) -> Vector3d { return mesh_.position(v) - x; };
  const Face& first = hull_.front();
  const Vector3d d = from_x(first[0]) + from_x(first[1]) + from_x(first[2]);
  // A direction that passes an edge in an angle of about so much may belong to either side.
  const double size = kRounding * d.cwiseAbs().maxCoeff();
  int met = 0;
  bool clear = true;
  for (const Face& f : hull_) {
    const Vector3d a = from_x(f[0]), b = from_x(f[1]), c = from_x(f[2]);
    const double sa = a.cwiseAbs().maxCoeff(), sb = b.cwiseAbs().maxCoeff(), sc = c.cwiseAbs().maxCoeff();
    // Negative outside the face; (f, x) is positive, so (a, b, c) is a negative triple.
    const double u = -d.dot(b.cross(c)), tiny_u = size * sb * sc;
    if (u < -tiny_u) continue;
    const double v = -d.dot(c.cross(a)), tiny_v = size * sc * sa;
    if (v < -tiny_v) continue;
    const double w = -d.dot(a.cross(b)), tiny_w = size * sa * sb;
    if (w < -tiny_w) continue;
    if (u > tiny_u && v > tiny_v && w > tiny_w)
      ++met;
    else
      clear = false;
  }
  if (clear) return met == 1;
  double angle = 0;
  for (const Face& f : hull_)
    angle += solid_angle(mesh_.position(f[0]), mesh_.position(f[1]), mesh_.position(f[2]), x);
  return angle < 6 * M_PI;
}

bool LocalOperations::fill(const Tets& cavity, const Vector3d& x) {
  // Seen from x the cavity's boundary must fill the sphere once; in a mesh that overlaps itself it might
  // do so twice, and then the old tets were no embedded cavity.
  if (!seen_once(x)) return false;
  return star_of_new_vertex(hull_, x, cavity);
}

bool LocalOperations::insert_at_edge(Index t, Index a, Index b, double gain) {
  mesh_.ring(t, a, b, ring_, link_);
  if (link_.size() != ring_.size()) return false;
  cavity_ = ring_;
  return insert(cavity_, (mesh_.position(a) + mesh_.position(b)) / 2, gain);
}

bool LocalOperations::insert_at_tet(Index t, double gain) {
  cavity_ = {t};
  const auto& c = mesh_.tet(t);
  return insert(
      cavity_,
      (mesh_.position(c[0]) + mesh_.position(c[1]) + mesh_.position(c[2]) + mesh_.position(c[3])) / 4, gain);
}

namespace {

// The smallest sphere through a triangle's corners, a little shrunk, contains x. (Delaunay refinement that
// may split the boundary takes the whole sphere; here vertices are wanted near it, too.)
bool in_smallest_sphere(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& x) {
  const Vector3d u = b - a, v = c - a, n = u.cross(v);
  const Vector3d out = (u.squaredNorm() * v.cross(n) + v.squaredNorm() * n.cross(u)) / (2 * n.squaredNorm());
  return (x - a - out).squaredNorm() < kEncroaching * out.squaredNorm();
}

// x is on the inner side of the face's plane, but nearer than the root of `square`.
bool is_close_below(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& x,
                    double square) {
  const Vector3d normal = (b - a).cross(c - a);
  const double height = normal.dot(x - a);  // times the length of the normal
  return height > 0 && height * height < square * normal.squaredNorm();
}

}  // namespace

namespace {

// From a to the centre of the sphere through all four.
Vector3d to_circumcentre(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  const Vector3d u = b - a, v = c - a, w = d - a, vw = v.cross(w);
  return (u.squaredNorm() * vw + v.squaredNorm() * w.cross(u) + w.squaredNorm() * u.cross(v)) /
         (2 * u.dot(vw));
}

double squared_shortest_edge(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  return std::min({(a - b).squaredNorm(), (a - c).squaredNorm(), (a - d).squaredNorm(), (b - c).squaredNorm(),
                   (b - d).squaredNorm(), (c - d).squaredNorm()});
}

}  // namespace

double squared_radius_edge(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  return to_circumcentre(a, b, c, d).squaredNorm() / squared_shortest_edge(a, b, c, d);
}

const LocalOperations::Sphere& LocalOperations::circumsphere(Index t) {
  if (spheres_.empty()) spheres_.resize(mesh_.tet_capacity());
  Sphere& s = spheres_[t];
  if (s.squared_radius >= 0) return s;
  const auto& corner = mesh_.tet(t);
  const Vector3d out = to_circumcentre(mesh_.position(corner[0]), mesh_.position(corner[1]),
                                       mesh_.position(corner[2]), mesh_.position(corner[3]));
  s.centre = mesh_.position(corner[0]) + out;
  s.squared_radius = out.squaredNorm();
  return s;
}

double LocalOperations::squared_radius_edge(Index t) {
  return circumsphere(t).squared_radius / squared_shortest_edge(t);
}

double LocalOperations::squared_shortest_edge(Index t) const {
  const auto& c = mesh_.tet(t);
  return overtet::squared_shortest_edge(mesh_.position(c[0]), mesh_.position(c[1]), mesh_.position(c[2]),
                                        mesh_.position(c[3]));
}

Index LocalOperations::walk(Index from, const Vector3d& x) const {
  // In the complex: from tet to tet across faces that x is beyond.
  const auto sees = [&](const Face& f) {
    const Vector3d& a = mesh_.position(f[0]);
    return (mesh_.position(f[1]) - a).cross(mesh_.position(f[2]) - a).dot(x - a) > 0;
  };
  Index at = from, before = -1;
  for (int step = 0; step < kLongestWalk; ++step) {
    Index beyond = at;
    for (int k = 0; k < 4 && beyond == at; ++k)
      if (const Index u = mesh_.neighbour(at, k); u != before && !sees(inner_face(at, k))) beyond = u;
    if (beyond < 0) return -1;
    if (beyond == at) return at;
    before = at;
    at = beyond;
  }
  return -1;
}

bool LocalOperations::insert_circumcentre(Index t, double radius_edge) {
  Vector3d x = circumsphere(t).centre;
  if (!x.allFinite()) return false;
  const auto& c = mesh_.tet(t);
  double room = HUGE_VAL;
  Vector3d middle = x;  // of the shortest edge
  for (const auto& [i, j] : kTetEdge) {
    const Vector3d &p = mesh_.position(c[i]), &q = mesh_.position(c[j]);
    if (const double square = (p - q).squaredNorm(); square < room) room = square, middle = (p + q) / 2;
  }
  // So far from an edge of length 1 the apex of an isosceles triangle lies on a circle of radius radius_edge.
  const double most = std::sqrt(room) * (radius_edge + std::sqrt(radius_edge * radius_edge - 0.25));
  if (const double far = (x - middle).norm(); far > most) x = middle + (most / far) * (x - middle);
  const Index at = walk(t, x);
  return at >= 0 && insert_delaunay(t, at, x, room);
}

bool LocalOperations::make_smaller(Index t, Splits splits) {
  const auto c = mesh_.tet(t);
  const SizeLimit::Excess before = excess(t);
  // Coordinates may be in other units along the axes than lengths: the largest one is on the safe side.
  const double wanted = limit_->wanted(c) / limit_->unit().maxCoeff();
  const auto room = [&](double part) { return part * part * wanted * wanted; };
  if (const Vector3d x = circumsphere(t).centre; x.allFinite())
    if (const Index at = walk(t, x); at >= 0 && insert_delaunay(t, at, x, room(kCentreRoom))) return true;
  // Too large for its volume alone: its longest edge, but that may stay.
  int edge = before.edge;
  double longest = 0;
  for (int k = 0; k < 6 && before.edge < 0; ++k) {
    const Index a = c[kTetEdge[k][0]], b = c[kTetEdge[k][1]];
    const double length = limit_->length(mesh_.position(a), mesh_.position(b));
    if (length > longest && !limit_->kept(a, b)) longest = length, edge = k;
  }
  if (edge < 0) return false;
  Index a = c[kTetEdge[edge][0]], b = c[kTetEdge[edge][1]];
  Vector3d middle = (mesh_.position(a) + mesh_.position(b)) / 2;
  if (insert_delaunay(t, t, middle, room(kMiddleRoom))) return true;
  if (before.edge < 0 && splits == Splits::roomy) return false;
  // Where the boundary is near: by itself, but never before a longer one beside it. (Else edges that are too
  // long become ever more, around vertices with thousands of tets. Source: Rivara 1984, longest-edge
  // bisection.)
  to_longest_edge(t, a, b);
  mesh_.ring(t, a, b, ring_, link_);
  middle = (mesh_.position(a) + mesh_.position(b)) / 2;
  const auto roomy = [&](Index v) { return (mesh_.position(v) - middle).squaredNorm() > room(kSplitRoom); };
  return (splits == Splits::all || std::all_of(link_.begin(), link_.end(), roomy)) &&
         split_edge(a, b, middle);
}

void LocalOperations::to_longest_edge(Index& t, Index& a, Index& b) {
  double longest = limit_->length(mesh_.position(a), mesh_.position(b));
  for (bool longer = true; longer;) {
    longer = false;
    mesh_.ring(t, a, b, ring_, link_);
    for (const Index u : ring_)
      for (const auto& [i, j] : kTetEdge) {
        const Index p = mesh_.tet(u)[i], q = mesh_.tet(u)[j];
        const double length = limit_->length(mesh_.position(p), mesh_.position(q));
        if (!(length > longest) || limit_->kept(p, q) || mesh_.edge_on_boundary(p, q)) continue;
        longest = length, t = u, a = p, b = q;
        longer = true;
      }
  }
}

bool LocalOperations::insert_delaunay(Index t, Index at, const Vector3d& x, double room) {
  cavity_ = {at};
  const std::uint32_t inside = ++tet_stamp_, near = ++vertex_stamp_;
  tet_mark_[at] = inside;
  for (std::size_t i = 0; i < cavity_.size(); ++i) {
    if (cavity_.size() > kLargestDelaunayCavity) return false;
    for (const Index v : mesh_.tet(cavity_[i])) {
      if (vertex_mark_[v] == near) continue;
      vertex_mark_[v] = near;
      if ((mesh_.position(v) - x).squaredNorm() < room) return false;
    }
    for (int k = 0; k < 4; ++k) {
      const Index u = mesh_.neighbour(cavity_[i], k);
      if (u < 0) {
        const Face f = inner_face(cavity_[i], k);
        // Faces between parts are not there to stay, and may be very long.
        if (shared(f[0]) && shared(f[1]) && shared(f[2])) {
          if (is_close_below(mesh_.position(f[0]), mesh_.position(f[1]), mesh_.position(f[2]), x,
                             kEncroaching * room))
            return false;
          continue;
        }
        if (in_smallest_sphere(mesh_.position(f[0]), mesh_.position(f[1]), mesh_.position(f[2]), x))
          return false;
        continue;
      }
      if (tet_mark_[u] == inside) continue;
      const Sphere& s = circumsphere(u);
      if (!((x - s.centre).squaredNorm() < s.squared_radius)) continue;
      tet_mark_[u] = inside;
      cavity_.push_back(u);
    }
  }
  if (tet_mark_[t] != inside) return false;
  // Tets with a face that x does not see stay, until x sees all of the hull.
  for (bool shrunk = true; shrunk;) {
    shrunk = false;
    std::size_t kept = 0;
    for (const Index u : cavity_) {
      bool visible = true;
      for (int k = 0; k < 4 && visible; ++k) {
        const Index w = mesh_.neighbour(u, k);
        if (w >= 0 && tet_mark_[w] == inside) continue;
        const Face f = inner_face(u, k);
        visible = orient3d(mesh_.position(f[0]).data(), mesh_.position(f[1]).data(),
                           mesh_.position(f[2]).data(), x.data()) > 0;
      }
      if (visible) {
        cavity_[kept++] = u;
      } else {
        tet_mark_[u] = 0;
        shrunk = true;
      }
    }
    cavity_.resize(kept);
  }
  if (tet_mark_[t] != inside || !hull_of(cavity_, hull_)) return false;
  return fill(cavity_, x);
}

}  // namespace overtet
