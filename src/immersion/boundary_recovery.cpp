#include "src/immersion/boundary_recovery.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include "kernels/core/tet_tables.h"
#include "kernels/core/triangles.h"
#include "kernels/core/tuning.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "kernels/predicates/predicates.h"
#include "src/immersion/kernel_centre.h"
#include "src/immersion/tuning.h"
#include "src/mesh/local_operations.h"

namespace overtet {

namespace {

using Triple = std::array<Index, 3>;
using Eigen::Vector3d;

class Clearer {
 public:
  Clearer(const Surface& surface, TetComplex& complex, const std::vector<Triple>& boundary,
          const std::vector<Index>& face, const BoundaryPointsOptions& options, const RunContext& context)
      : surface_(surface), complex_(complex), options_(options), context_(context) {
    const Index n = static_cast<Index>(surface.V.rows());
    std::set<Index> points;
    for (std::size_t i = 0; i < boundary.size(); ++i)
      for (const Index v : boundary[i])
        if (v >= n) points.insert(v);
    // Only triangles with an added point will change.
    for (std::size_t i = 0; i < boundary.size(); ++i)
      if (std::any_of(boundary[i].begin(), boundary[i].end(), [&](Index v) { return v >= n; }))
        label_[sorted(boundary[i])] = face[i];
    queue_.assign(points.begin(), points.end());
    points_ = queue_;
  }

  BoundaryPointsResult run() {
    result_.smallest_clearance = queue_.empty() ? 0 : std::numeric_limits<double>::infinity();
    for (const double least : kClearances) try_all(least);
    int in_vain = 0;
    for (int round = 0; round < kMostRounds && in_vain < kInVain && !queue_.empty() && !context_.stop();
         ++round) {
      const std::size_t before = queue_.size();
      free_what_is_left();
      thorough_ = round > 0;
      try_all(0);
      in_vain = queue_.size() < before ? 0 : in_vain + 1;
    }
    thorough_ = false;
    result_.left = queue_;
    spread();
    if (!std::isfinite(result_.smallest_clearance)) result_.smallest_clearance = 0;
    return result_;
  }

  std::vector<Index> bring_home() {
    std::vector<Index> left;
    for (Index v = 0; v < static_cast<Index>(surface_.V.rows()); ++v)
      if (complex_.position(v) != Vector3d(surface_.V.row(v))) left.push_back(v);
    for (int round = 0; round < kMostRounds && !left.empty(); ++round) {
      std::vector<Index> still;
      for (const Index v : left) {
        if (context_.stop()) return left;
        if (move_home(v)) continue;
        make_room(v);
        if (!move_home(v)) still.push_back(v);
      }
      left = std::move(still);
    }
    return left;
  }

 private:
  void try_all(double least_clearance) {
    least_clearance_ = least_clearance;
    std::vector<Index> left;
    for (const Index v : queue_) {
      if (context_.stop()) {
        left.push_back(v);
        continue;
      }
      if (clear(v)) continue;
      make_room(v);
      if (!clear(v)) left.push_back(v);
    }
    queue_ = std::move(left);
  }

  // Points that have been cleared may lie in a pocket between two flat parts of their stars, in the plane of
  // a face, which no move opens; and there they stand in the way of others. Flat tets around what is left
  // make way for better ones.
  void free_what_is_left() {
    LocalOperations work(complex_);
    std::vector<Index> star, around;
    for (const Index v : queue_) {
      std::set<TetComplex::Tet> tried;  // sorted
      for (int count = 0; count < kMostFlat && !context_.stop(); ++count) {
        std::set<Index> near;
        complex_.star(v, star);
        for (const Index t : star)
          for (const Index u : complex_.tet(t))
            if (!complex_.on_boundary(u)) near.insert(u);
        near.insert(v);
        Index flattest = -1;
        for (const Index u : near) {
          complex_.star(u, around);
          for (const Index t : around)
            if (work.quality(t) < (flattest < 0 ? kFlat : work.quality(flattest)) &&
                !tried.count(sorted_tet(t)))
              flattest = t;
        }
        if (flattest < 0) break;
        tried.insert(sorted_tet(flattest));
        make_way(work, flattest);
      }
    }
  }

  // For better tets. What is cheap comes first; a point that has been cleared may go for good.
  static void make_way(LocalOperations& work, Index t) {
    const TetComplex::Tet c = work.mesh().tet(t);
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j)
        if (i != j && !work.fixed(c[i]) && work.collapse(c[i], c[j])) return;
    for (const auto& [i, j] : kTetEdge)
      if (work.remove_edge(t, c[i], c[j])) return;
    for (int k = 0; k < 4; ++k)
      if (work.flip_23(t, k)) return;
    for (const Index v : c)
      if (!work.fixed(v) && work.smooth(v)) return;
    if (!work.reconnect(t)) work.insert_around(t);
  }

  TetComplex::Tet sorted_tet(Index t) const {
    TetComplex::Tet tet = complex_.tet(t);
    std::sort(tet.begin(), tet.end());
    return tet;
  }

  // As far as it goes: true when all the way.
  bool move_home(Index v) {
    const Vector3d home = surface_.V.row(v), here = complex_.position(v);
    std::vector<Triple> walls;
    find_walls(v, walls);
    for (double share = 1; share > 1e-3; share *= 0.5) {
      const Vector3d x = share == 1 ? home : Vector3d(here + share * (home - here));
      if (!positive(walls, x)) continue;
      complex_.move(v, x);
      return share == 1;
    }
    return false;
  }

  // All added points look for more room. Those of one colour have no tet in common, so they may do so at the
  // same time; from now on only positions change.
  void spread() {
    std::vector<Index> inside;
    std::vector<std::vector<Triple>> walls;
    std::vector<int> colour(static_cast<std::size_t>(complex_.vertex_count()), -1);
    std::vector<std::vector<std::size_t>> coloured;  // rows of `inside`
    std::vector<char> taken;
    for (const Index v : points_) {
      if (complex_.on_boundary(v)) continue;
      find_walls(v, walls.emplace_back());
      taken.assign(coloured.size() + 1, 0);
      for (const Triple& w : walls.back())
        for (const Index u : w)
          if (colour[u] >= 0) taken[colour[u]] = 1;
      colour[v] = static_cast<int>(std::find(taken.begin(), taken.end(), 0) - taken.begin());
      if (colour[v] == static_cast<int>(coloured.size())) coloured.emplace_back();
      coloured[colour[v]].push_back(inside.size());
      inside.push_back(v);
    }
    for (int sweep = 0; sweep < kSweeps && !context_.stop(); ++sweep)
      for (const auto& rows : coloured)
        result_.smallest_clearance = parallel_reduce(
            static_cast<std::int64_t>(rows.size()), kHeavyGrain, result_.smallest_clearance,
            [&](std::int64_t begin, std::int64_t end) {
              Search search;
              double smallest = std::numeric_limits<double>::infinity();
              for (std::int64_t i = begin; i < end; ++i) {
                const Index v = inside[rows[i]];
                const auto place = find_place(v, walls[rows[i]], 0, search);
                if (!place) continue;
                complex_.move(v, place->position);
                smallest = std::min(smallest, place->clearance);
              }
              return smallest;
            },
            [](double x, double y) { return std::min(x, y); });
  }

  const double* at(Index v) const { return complex_.position(v).data(); }

  // The points from which triangle (a, b, c) turns counter-clockwise.
  struct HalfSpace {
    Vector3d normal;  // unit, inward
    Vector3d origin;
  };

  static bool half_space(const Vector3d& a, const Vector3d& b, const Vector3d& c, HalfSpace& out) {
    const Vector3d n = (b - a).cross(c - a);
    const double length = n.norm();
    if (!(length > 0)) return false;
    out = {n / length, a};
    return true;
  }

  // The faces opposite to v in its star, turned so that v lies on their positive side.
  void find_walls(Index v, std::vector<Triple>& walls) {
    complex_.star(v, star_);
    walls.clear();
    for (const Index t : star_) walls.push_back(tet_inner_face(complex_.tet(t), complex_.corner(t, v)));
  }

  // Moves the interior neighbours of v to roomier places, so that v finds room itself.
  void make_room(Index v) {
    std::vector<Index> neighbours;
    complex_.star(v, star_);
    for (const Index t : star_)
      for (const Index u : complex_.tet(t))
        if (u != v) neighbours.push_back(u);
    std::sort(neighbours.begin(), neighbours.end());
    neighbours.erase(std::unique(neighbours.begin(), neighbours.end()), neighbours.end());
    std::vector<Triple> walls;
    for (const Index u : neighbours) {
      if (complex_.on_boundary(u)) continue;
      find_walls(u, walls);
      if (const auto place = find_place(u, walls, 0, search_)) move(u, *place);
    }
  }

  bool clear(Index v) {
    std::vector<Triple> walls;
    find_walls(v, walls);
    std::map<Index, std::pair<Index, Index>> next;  // ring vertex -> (next ring vertex, face)
    for (const Index t : star_) {
      const auto& tet = complex_.tet(t);
      const int k = complex_.corner(t, v);
      for (int j = 0; j < 4; ++j) {
        if (j == k || complex_.neighbour(t, j) >= 0) continue;
        // Outward boundary face of t opposite to j, rotated to start at v.
        Triple f = tet_face(tet, j);
        while (f[0] != v) std::rotate(f.begin(), f.begin() + 1, f.end());
        const auto label = label_.find(sorted(f));
        if (label == label_.end() || !next.try_emplace(f[1], f[2], label->second).second) return false;
      }
    }
    if (next.size() < 3) return next.empty();
    std::vector<Index> ring{next.begin()->first};
    std::vector<Index> face;
    for (;;) {
      const auto it = next.find(ring.back());
      if (it == next.end()) return false;
      face.push_back(it->second.second);
      if (it->second.first == ring.front()) break;
      ring.push_back(it->second.first);
      if (ring.size() > next.size()) return false;
    }
    if (ring.size() != next.size()) return false;

    // Start where the face changes, if it does: then each face's part of the ring is contiguous.
    const std::size_t n = ring.size();
    std::size_t start = 0;
    int changes = 0;
    for (std::size_t i = 0; i < n; ++i)
      if (face[i] != face[(i + n - 1) % n]) start = i, ++changes;
    if (changes != 0 && changes != 2) return false;
    std::rotate(ring.begin(), ring.begin() + start, ring.end());
    std::rotate(face.begin(), face.begin() + start, face.end());
    std::vector<Triple> caps;
    std::vector<Index> cap_face;
    if (changes == 0) {
      if (!triangulate(ring, face[0], ring, caps)) return false;
      cap_face.assign(caps.size(), face[0]);
    } else {
      std::size_t split = 1;
      while (face[split] == face[0]) ++split;
      std::vector<Index> first(ring.begin(), ring.begin() + split + 1),
          second(ring.begin() + split, ring.end());
      second.push_back(ring[0]);
      // The edge between the two parts becomes an edge of the boundary: no other edge may have its ends.
      if (complex_.has_edge(ring[0], ring[split]) && !split_edge(ring[0], ring[split])) return false;
      if (complex_.has_edge(ring[0], ring[split])) return false;
      if (!triangulate(first, face[0], ring, caps)) return false;
      cap_face.assign(caps.size(), face[0]);
      if (!triangulate(second, face[split], ring, caps)) return false;
      cap_face.resize(caps.size(), face[split]);
      if (const double angle = wedge_angle(v, ring[0]); angle > kWideWedge && !options_.may_branch) {
        const std::size_t first_caps = std::count(cap_face.begin(), cap_face.end(), face[0]);
        if (!clear_wide(v, ring[0], ring[split], angle, caps, first_caps)) return false;
        relabel(v, ring, caps, cap_face);
        return true;
      }
    }
    find_walls(v, walls);  // splitting edges may have changed the star
    // Outward caps seen from inside turn the other way.
    std::vector<Triple> sides = walls;
    for (const Triple& c : caps) sides.push_back({c[0], c[2], c[1]});
    const auto place = find_place(v, sides, least_clearance_, search_);
    if (!place) return false;
    move(v, *place);
    // The star is replaced by itself and the caps, so that the caps find their neighbours in it.
    std::vector<TetComplex::Tet> tets;
    for (const Index t : star_) tets.push_back(complex_.tet(t));
    for (const Triple& c : caps) tets.push_back({c[0], c[2], c[1], v});
    complex_.replace(star_, tets);
    relabel(v, ring, caps, cap_face);
    return true;
  }

  // The boundary triangles around v have become the caps.
  void relabel(Index v, const std::vector<Index>& ring, const std::vector<Triple>& caps,
               const std::vector<Index>& cap_face) {
    for (std::size_t i = 0; i < ring.size(); ++i)
      label_.erase(sorted(Triple{v, ring[i], ring[(i + 1) % ring.size()]}));
    for (std::size_t i = 0; i < caps.size(); ++i) label_[sorted(caps[i])] = cap_face[i];
    ++result_.removed;
  }

  // Directions around the axis from v to p, as unwrapped angles over the tets at that boundary edge.
  struct Wedge {
    std::vector<Index> tets, link;  // as TetComplex::ring
    std::vector<double> angle;      // of each link vertex; the first is 0
    Vector3d axis, u, w;
    Vector3d direction(double a) const { return std::cos(a) * u + std::sin(a) * w; }
  };

  Wedge wedge(Index v, Index p) {
    Wedge out;
    complex_.ring(complex_.tet_with_edge(v, p), v, p, out.tets, out.link);
    const Vector3d x = complex_.position(v);
    out.axis = (complex_.position(p) - x).normalized();
    const auto across = [&](Index i) {
      const Vector3d d = complex_.position(i) - x;
      return Vector3d(d - out.axis * out.axis.dot(d));
    };
    out.u = across(out.link[0]).normalized();
    out.w = out.axis.cross(out.u);
    out.angle.assign(1, 0);
    for (std::size_t i = 0; i + 1 < out.link.size(); ++i) {
      const Vector3d a = across(out.link[i]), b = across(out.link[i + 1]);
      out.angle.push_back(out.angle.back() + std::atan2(out.axis.dot(a.cross(b)), a.dot(b)));
    }
    return out;
  }
  double wedge_angle(Index v, Index p) { return wedge(v, p).angle.back(); }

  // The edges of the link of v that the half-plane at `angle` around the axis v-p crosses on the way from p
  // to n. Empty where it passes too close to a vertex.
  std::vector<std::pair<Index, Index>> crossed_by(Index v, Index p, Index n, double angle, Vector3d& normal) {
    const Wedge fan = wedge(v, p);
    const Vector3d x = complex_.position(v);
    normal = fan.direction(angle + M_PI / 2);
    const auto side = [&](Index i) {
      const Vector3d d = complex_.position(i) - x;
      return normal.dot(d) / d.norm();
    };
    std::size_t i = 0;
    while (i + 1 < fan.tets.size() && fan.angle[i + 1] <= angle) ++i;
    Index before = fan.link[i], after = fan.link[i + 1], tet = fan.tets[i], behind = p;
    std::vector<std::pair<Index, Index>> crossed;
    for (int step = 0;; ++step) {
      const double a = side(before), b = side(after);
      const double off = thorough_ ? kRoundedLength : kOffPlane;
      if (!(a < -off && b > off) || step > 1000) return {};
      crossed.emplace_back(before, after);
      int k = 0;
      while (complex_.tet(tet)[k] != behind) ++k;
      const Index next = complex_.neighbour(tet, k);
      if (next < 0) return {};
      Index corner = -1;
      for (const Index c : complex_.tet(next))
        if (c != v && c != before && c != after) corner = c;
      tet = next;
      if (corner == n) return crossed;
      if (side(corner) > 0) {
        behind = after, after = corner;
      } else {
        behind = before, before = corner;
      }
    }
  }

  // A way through the link of v from p to n, in the half-plane at `angle` around the axis v-p, along edges of
  // the complex, which are halved where the plane crosses them. Empty where it cannot be had.
  std::vector<Index> slit(Index v, Index p, Index n, double angle) {
    const Vector3d x = complex_.position(v);
    Vector3d normal;
    std::vector<std::pair<Index, Index>> crossed;
    for (int round = 0;; ++round) {
      crossed = crossed_by(v, p, n, angle, normal);
      const auto wall = std::find_if(crossed.begin(), crossed.end(), [&](const auto& e) {
        return complex_.edge_on_boundary(e.first, e.second);
      });
      if (wall == crossed.end()) break;
      // The star reaches across to another part of the boundary, whose edges stay whole: it is made smaller
      // there.
      if (round == kMostRounds || !(split_edge(v, wall->first) || split_edge(v, wall->second) ||
                                    (thorough_ && split_triangle(v, wall->first, wall->second))))
        return {};
    }
    if (crossed.empty()) return {};
    std::vector<Index> path{p};
    for (const auto& [a, b] : crossed) {
      const double da = normal.dot(complex_.position(a) - x), db = normal.dot(complex_.position(b) - x);
      const double t = da / (da - db);
      if (!split_edge(a, b, (1 - t) * complex_.position(a) + t * complex_.position(b))) return {};
      path.push_back(complex_.vertex_count() - 1);
    }
    path.push_back(n);
    return path;
  }

  // The star of a point on an edge p-n cut into sectors: by half-planes through the edge, sector j lies
  // between slits j - 1 and j.
  struct Sectors {
    // A triangle of a slit, so that (v, a, b, fourth corner) is the tet of that sector.
    struct Joint {
      int sector;
      Index a, b;
    };
    std::map<Index, int> of;  // tets of the star
    std::vector<Joint> joints;
  };

  // As the single move, for an edge p-n whose tets make almost a full turn or more (wound edges): no single
  // point sees both faces. The star of v is slit along half-planes through the edge, into sectors of less
  // than a half turn around each of several points, which take the place of v and are joined around the edge.
  bool clear_wide(Index v, Index p, Index n, double total, const std::vector<Triple>& caps,
                  std::size_t first_caps) {
    const int points = std::max(2, static_cast<int>(total / M_PI));
    const auto angle_of = [&](double j) { return total * j / (points + 1); };  // j = 1 .. points
    std::vector<std::vector<Index>> slits;
    for (int j = 1; j < points; ++j) {
      std::vector<Index> path;
      for (const double shift : {0.0, 0.07, -0.07, 0.15, -0.15, 0.22, -0.22}) {
        path = slit(v, p, n, angle_of(j + 0.5 + shift));
        if (!path.empty()) break;
      }
      if (thorough_)
        for (double shift = kSlitStep; shift < 0.5 && path.empty(); shift += kSlitStep)
          for (const double side : {shift, -shift})
            if (path.empty()) path = slit(v, p, n, angle_of(j + 0.5 + side));
      if (path.empty()) return false;
      slits.push_back(std::move(path));
    }
    complex_.star(v, star_);
    const Wedge fan = wedge(v, p);
    const std::optional<Sectors> sectors = find_sectors(v, fan.tets.front(), slits);
    if (!sectors) return false;

    const Vector3d origin = complex_.position(v);
    double reach = 0;
    for (const Index t : star_)
      for (const Index c : complex_.tet(t)) reach = std::max(reach, (complex_.position(c) - origin).norm());
    std::vector<Index> point{v};
    while (static_cast<int>(point.size()) < points) point.push_back(complex_.add_vertex(origin));
    std::vector<TetComplex::Tet> tets = joined(v, *sectors, point);
    for (int j = 0; j + 1 < points; ++j) tets.push_back({n, p, point[j], point[j + 1]});
    // The wedge runs from the second face to the first.
    for (std::size_t i = 0; i < caps.size(); ++i)
      tets.push_back({caps[i][0], caps[i][2], caps[i][1], i < first_caps ? point.back() : point.front()});
    for (double step = 0.25 * reach; step > 1e-15 * reach; step *= 0.5) {
      for (int j = 0; j < points; ++j)
        complex_.move(point[j], origin + step * fan.direction(angle_of(j + 1)));
      const bool fits = std::all_of(tets.begin(), tets.end(), [&](const TetComplex::Tet& t) {
        return orient3d(at(t[0]), at(t[1]), at(t[2]), at(t[3])) > 0;
      });
      if (!fits) continue;
      complex_.replace(star_, tets);
      result_.smallest_clearance = std::min(result_.smallest_clearance, step);
      return true;
    }
    complex_.move(v, origin);
    return false;
  }

  // Floods the star of v from the tet `first`, in sector 0; crossing slit j leads from sector j to j + 1.
  // None: the slits do not cut it into sectors. pre: star_ is v's.
  std::optional<Sectors> find_sectors(Index v, Index first, const std::vector<std::vector<Index>>& slits) {
    std::map<std::pair<Index, Index>, int> slit_of;
    for (int j = 0; j < static_cast<int>(slits.size()); ++j)
      for (std::size_t i = 0; i + 1 < slits[j].size(); ++i)
        slit_of[std::minmax(slits[j][i], slits[j][i + 1])] = j;
    Sectors out;
    out.of[first] = 0;
    std::vector<Index> stack{first};
    while (!stack.empty()) {
      const Index t = stack.back();
      stack.pop_back();
      const int here = out.of[t], kv = complex_.corner(t, v);
      for (int k = 0; k < 4; ++k) {
        if (k == kv) continue;
        const Index other = complex_.neighbour(t, k);
        if (other < 0) continue;
        Index edge[2];
        int m = 0;
        for (int j = 0; j < 4; ++j)
          if (j != k && j != kv) edge[m++] = complex_.tet(t)[j];
        int there = here;
        if (const auto cut = slit_of.find(std::minmax(edge[0], edge[1])); cut != slit_of.end()) {
          if (here != cut->second && here != cut->second + 1) return std::nullopt;
          there = here == cut->second ? here + 1 : here - 1;
          if (there == here + 1) {
            // Even permutations put v first and corner k last.
            const bool even = even_permutation(kv, corner_of(t, edge[0]), corner_of(t, edge[1]), k);
            out.joints.push_back({here, even ? edge[0] : edge[1], even ? edge[1] : edge[0]});
          }
        }
        const auto [at, added] = out.of.try_emplace(other, there);
        if (added)
          stack.push_back(other);
        else if (at->second != there)
          return std::nullopt;
      }
    }
    if (out.of.size() != star_.size()) return std::nullopt;
    return out;
  }

  // The star's tets with the point of their sector in v's place, and those between sectors. pre: star_ is
  // v's.
  std::vector<TetComplex::Tet> joined(Index v, const Sectors& sectors,
                                      const std::vector<Index>& point) const {
    std::vector<TetComplex::Tet> tets;
    for (const Index t : star_) {
      auto tet = complex_.tet(t);
      std::replace(tet.begin(), tet.end(), v, point[sectors.of.at(t)]);
      tets.push_back(tet);
    }
    for (const Sectors::Joint& j : sectors.joints)
      tets.push_back({point[j.sector], j.b, j.a, point[j.sector + 1]});
    return tets;
  }

  int corner_of(Index t, Index v) const { return complex_.corner(t, v); }

  static bool even_permutation(int a, int b, int c, int d) {
    const int p[4] = {a, b, c, d};
    int inversions = 0;
    for (int i = 0; i < 4; ++i)
      for (int j = i + 1; j < 4; ++j) inversions += p[i] > p[j];
    return inversions % 2 == 0;
  }

  // Splits an interior edge; false on the boundary or where a part would not be exactly positive.
  bool split_edge(Index a, Index b) {
    return split_edge(a, b, 0.5 * (complex_.position(a) + complex_.position(b)));
  }
  bool split_edge(Index a, Index b, const Vector3d& where) {
    if (complex_.edge_on_boundary(a, b)) return false;
    std::vector<Index> around;
    complex_.ring(a, b, around);
    const Index m = complex_.add_vertex(where);
    std::vector<TetComplex::Tet> halves;
    for (const Index t : around)
      for (const Index end : {a, b}) {
        auto tet = complex_.tet(t);
        std::replace(tet.begin(), tet.end(), end, m);
        if (orient3d(at(tet[0]), at(tet[1]), at(tet[2]), at(tet[3])) <= 0) return false;
        halves.push_back(tet);
      }
    complex_.replace(around, halves);
    ++result_.refined_edges;
    return true;
  }

  // Splits an interior triangle at its centroid; false where a part would not be exactly positive.
  bool split_triangle(Index a, Index b, Index c) {
    std::vector<Index> ring, sides;
    complex_.ring(a, b, ring);
    for (const Index t : ring) {
      const auto& tet = complex_.tet(t);
      if (std::find(tet.begin(), tet.end(), c) != tet.end()) sides.push_back(t);
    }
    if (sides.size() != 2) return false;
    const Index m =
        complex_.add_vertex((complex_.position(a) + complex_.position(b) + complex_.position(c)) / 3);
    std::vector<TetComplex::Tet> parts;
    for (const Index t : sides)
      for (const Index corner : {a, b, c}) {
        auto tet = complex_.tet(t);
        std::replace(tet.begin(), tet.end(), corner, m);
        if (orient3d(at(tet[0]), at(tet[1]), at(tet[2]), at(tet[3])) <= 0) return false;
        parts.push_back(tet);
      }
    complex_.replace(sides, parts);
    return true;
  }

  // Triangulates a flat ring (counter-clockwise seen from outside) in the plane of an input face, with the
  // best worst triangle; new edges must not exist in the complex yet.
  bool triangulate(const std::vector<Index>& polygon, Index face, const std::vector<Index>& ring,
                   std::vector<Triple>& out) {
    const std::size_t n = polygon.size();
    if (n < 3) return false;
    const Vector3d a = surface_.V.row(surface_.F(face, 0)), b = surface_.V.row(surface_.F(face, 1)),
                   c = surface_.V.row(surface_.F(face, 2));
    const Vector3d normal = (b - a).cross(c - a).normalized();
    const auto quality = [&](Index p, Index q, Index r) {
      const Vector3d x = complex_.position(p), y = complex_.position(q), z = complex_.position(r);
      const double longest = std::max({(y - x).squaredNorm(), (z - y).squaredNorm(), (x - z).squaredNorm()});
      return (y - x).cross(z - x).dot(normal) / longest;
    };
    const auto adjacent = [&](std::size_t i, std::size_t j) {
      const auto p = std::find(ring.begin(), ring.end(), polygon[i]) - ring.begin();
      const auto q = std::find(ring.begin(), ring.end(), polygon[j]) - ring.begin();
      const auto m = static_cast<std::ptrdiff_t>(ring.size());
      return (p + 1) % m == q || (q + 1) % m == p;
    };
    std::vector<char> allowed(n * n, 1);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 2; j < n; ++j)
        if (!(i == 0 && j == n - 1) && complex_.has_edge(polygon[i], polygon[j])) {
          // Two neighbours of v that are joined elsewhere: make room if that can be done.
          allowed[i * n + j] = !adjacent(i, j) && split_edge(polygon[i], polygon[j]);
        }
    // best[i][j]: the best worst quality of the part from i to j.
    std::vector<double> best(n * n, -HUGE_VAL);
    std::vector<std::size_t> apex(n * n, 0);
    for (std::size_t i = 0; i + 1 < n; ++i) best[i * n + i + 1] = HUGE_VAL;
    for (std::size_t length = 2; length < n; ++length)
      for (std::size_t i = 0; i + length < n; ++i) {
        const std::size_t j = i + length;
        if (!allowed[i * n + j]) continue;
        for (std::size_t k = i + 1; k < j; ++k) {
          const double worst =
              std::min({best[i * n + k], best[k * n + j], quality(polygon[i], polygon[k], polygon[j])});
          if (worst > best[i * n + j]) best[i * n + j] = worst, apex[i * n + j] = k;
        }
      }
    if (!(best[n - 1] > 0)) return false;
    std::vector<std::pair<std::size_t, std::size_t>> stack{{0, n - 1}};
    while (!stack.empty()) {
      const auto [i, j] = stack.back();
      stack.pop_back();
      if (j - i < 2) continue;
      const std::size_t k = apex[i * n + j];
      out.push_back({polygon[i], polygon[k], polygon[j]});
      stack.emplace_back(i, k);
      stack.emplace_back(k, j);
    }
    return true;
  }

  bool positive(const std::vector<Triple>& sides, const Vector3d& x) const {
    return std::all_of(sides.begin(), sides.end(),
                       [&](const Triple& s) { return orient3d(at(s[0]), at(s[1]), at(s[2]), x.data()) > 0; });
  }

  struct Place {
    Vector3d position;
    double clearance;  // from the closest half-space
  };

  void move(Index v, const Place& place) {
    complex_.move(v, place.position);
    result_.smallest_clearance = std::min(result_.smallest_clearance, place.clearance);
  }

  // What find_place() works with: the half-spaces, and how far a point and the next one lie in them. By
  // coordinate, so that several are measured at once.
  struct Search {
    std::vector<double> nx, ny, nz, ox, oy, oz, distance, there;

    void clear() {
      for (auto* list : {&nx, &ny, &nz, &ox, &oy, &oz}) list->clear();
    }
    void add(const HalfSpace& h) {
      nx.push_back(h.normal[0]), ny.push_back(h.normal[1]), nz.push_back(h.normal[2]);
      ox.push_back(h.origin[0]), oy.push_back(h.origin[1]), oz.push_back(h.origin[2]);
    }
    std::size_t size() const { return nx.size(); }
    double measure(const Vector3d& x, std::vector<double>& into) const {
      const std::size_t n = size();
      const double a = x[0], b = x[1], c = x[2];
      const double *const nx_ = nx.data(), *const ny_ = ny.data(), *const nz_ = nz.data();
      const double *const ox_ = ox.data(), *const oy_ = oy.data(), *const oz_ = oz.data();
      double* const d = into.data();
      for (std::size_t i = 0; i < n; ++i)
        d[i] = nx_[i] * (a - ox_[i]) + ny_[i] * (b - oy_[i]) + nz_[i] * (c - oz_[i]);
      double least = std::numeric_limits<double>::infinity();
      for (std::size_t i = 0; i < n; ++i) least = std::min(least, d[i]);
      return least;
    }
  };

  // A point well inside all half-spaces, which must keep a distance of at least `least` of the star's size.
  std::optional<Place> find_place(Index v, const std::vector<Triple>& sides, double least,
                                  Search& search) const {
    std::optional<Place> place = ascend(v, sides, least, search);
    return place || !thorough_ ? place : find_centre(v, sides);
  }

  // The centre of the kernel, or as far towards it as doubles go: dearer, but it finds thin kernels, too.
  std::optional<Place> find_centre(Index v, const std::vector<Triple>& sides) const {
    std::vector<Wall> walls;
    for (const Triple& s : sides)
      walls.push_back({complex_.position(s[0]), complex_.position(s[1]), complex_.position(s[2])});
    const Vector3d start = complex_.position(v);
    const std::optional<Vector3d> way = kernel_centre(walls, start);
    if (!way) return std::nullopt;
    for (double share = 1; share > kPrecise; share *= 0.5) {
      const Vector3d y = start + share * *way;
      if (!positive(sides, y)) continue;
      double clearance = std::numeric_limits<double>::infinity();
      for (const Wall& w : walls) {
        HalfSpace h;
        if (half_space(w[0], w[1], w[2], h)) clearance = std::min(clearance, h.normal.dot(y - h.origin));
      }
      return Place{y, clearance};
    }
    return std::nullopt;
  }

  // Close to the centre of the largest ball in all half-spaces.
  std::optional<Place> ascend(Index v, const std::vector<Triple>& sides, double least, Search& search) const {
    search.clear();
    for (const Triple& s : sides) {
      HalfSpace h;
      if (!half_space(complex_.position(s[0]), complex_.position(s[1]), complex_.position(s[2]), h))
        return std::nullopt;
      search.add(h);
    }
    search.distance.resize(sides.size());
    search.there.resize(sides.size());
    const Vector3d start = complex_.position(v);
    double size = 0;
    for (const Triple& s : sides)
      for (const Index p : s) size = std::max(size, (complex_.position(p) - start).norm());

    // Ascent on the concave function `clearance`: the step direction balances the faces that bind.
    Vector3d x = start, best = start;
    double value = search.measure(x, search.distance), best_value = value;
    double step = 0.25 * size;
    for (int i = 0; i < 200 && step > std::max(kRoundedLength * size, kPrecise * best_value); ++i) {
      Vector3d direction = Vector3d::Zero();
      for (std::size_t k = 0; k < search.size(); ++k)
        if (const double slack = search.distance[k] - value; slack <= 0.5 * step)
          direction += Vector3d(search.nx[k], search.ny[k], search.nz[k]) * std::exp(-4 * slack / step);
      const double length = direction.norm();
      bool moved = false;
      if (length > 1e-12) {
        const Vector3d y = x + direction * (step / length);
        const double there = search.measure(y, search.there);
        if (there > value) {
          x = y, value = there, moved = true;
          std::swap(search.distance, search.there);
          if (value > best_value) best = x, best_value = value;
        }
      }
      step *= moved ? 1.3 : 0.6;
    }
    if (!(best_value > least * size)) return std::nullopt;
    // The way back towards the start stays inside (convex); take the exact check's word, not ours.
    for (double share = kReach; share > 1e-3; share *= 0.5)
      if (const Vector3d y = start + share * (best - start); positive(sides, y))
        return Place{y, search.measure(y, search.there)};
    if (!positive(sides, best)) return std::nullopt;
    return Place{best, best_value};
  }

  const Surface& surface_;
  TetComplex& complex_;
  const BoundaryPointsOptions options_;
  const RunContext& context_;
  std::map<Triple, Index> label_;  // boundary triangle -> input face
  std::vector<Index> queue_;
  std::vector<Index> points_;  // all added points of the boundary
  std::vector<Index> star_;
  Search search_;
  double least_clearance_ = 0;
  bool thorough_ = false;  // dearer means, for the points that are left
  BoundaryPointsResult result_;
};

}  // namespace

BoundaryPointsResult clear_boundary_points(const Surface& surface, TetComplex& complex,
                                           const std::vector<std::array<Index, 3>>& boundary,
                                           const std::vector<Index>& face, const RunContext& context,
                                           const BoundaryPointsOptions& options) {
  return Clearer(surface, complex, boundary, face, options, context).run();
}

std::vector<Index> bring_home(const Surface& surface, TetComplex& complex, const RunContext& context) {
  return Clearer(surface, complex, {}, {}, {}, context).bring_home();
}

}  // namespace overtet
