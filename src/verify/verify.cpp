#include "overtet/verification.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numeric>
#include <unordered_map>

#include "kernels/core/box.h"
#include "kernels/core/tet_tables.h"
#include "kernels/core/triangles.h"
#include "kernels/core/union_find.h"
#include "kernels/parallel/grouping.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "kernels/predicates/predicates.h"
#include "src/verify/tuning.h"

namespace overtet {

namespace {

using Triple = std::array<Index, 3>;

// Corners of the face opposite to corner k, outward.
std::string list(const std::vector<Index>& items, std::size_t width) {
  std::string s;
  for (std::size_t i = 0; i < items.size(); i += width) {
    if (i > 0) s += ", ";
    for (std::size_t k = 0; k < width; ++k) {
      if (k > 0) s += '-';
      s += std::to_string(items[i + k]);
    }
  }
  return s;
}

// Collects the failures of one kind.
struct Finding {
  std::int64_t count = 0;
  std::vector<Index> first;
  std::size_t width = 1;

  explicit Finding(std::size_t elements_each = 1) : width(elements_each) {}
  template <class... I>
  void add(I... i) {
    ++count;
    if (first.size() < kNamed * width) (first.push_back(i), ...);
  }
  void append(const Finding& next) {
    count += next.count;
    const std::size_t room = kNamed * width - std::min(first.size(), kNamed * width);
    first.insert(first.end(), next.first.begin(),
                 next.first.begin() + static_cast<std::ptrdiff_t>(std::min(room, next.first.size())));
  }
};

void report(VerifyResult& r, Rule rule, const Finding& f, const std::string& what) {
  if (f.count == 0) return;
  std::string m = "R" + std::to_string(static_cast<int>(rule)) + ": " + std::to_string(f.count) + " " + what;
  if (!f.first.empty()) {
    m += f.count > static_cast<std::int64_t>(f.first.size() / f.width) ? " (first " : " (";
    m += list(f.first, f.width) + ")";
  }
  r.failures.push_back({rule, m + ".", f.count, f.first});
}

Triple corners(const TetMatrix& T, Index t, int face) { return tet_face(T.row(t), face); }

// The tets around one vertex and its link: the triangles opposite to it, turned outwards, with their vertices
// and edges numbered from 0. Edges of the link are faces of the mesh. Used for one vertex after the other.
class Star {
 public:
  struct Edge {
    Index a, b;      // vertices of the link, a < b
    Index place;     // 3 i + k: side k of triangle i, from its corner k to the next, is the first one here
    Index count;     // sides
    bool same_side;  // two sides run the same way
  };

  void read(const TetMatrix& T, Index v, const Index* tets, Index count) {
    v_ = v;
    tets_ = tets;
    triangle_.clear();
    vertices_.clear();
    edges_.clear();
    std::size_t slots = 32;
    while (slots < 6 * static_cast<std::size_t>(count)) slots *= 2;
    vertex_at_.assign(slots, -1);
    edge_at_.assign(slots, -1);
    for (Index i = 0; i < count; ++i) {
      int corner = 0;
      while (T(tets[i], corner) != v) ++corner;
      Index t[3];
      for (int k = 0; k < 3; ++k) t[k] = number_vertex(T(tets[i], kTetFace[corner][k]));
      for (int k = 0; k < 3; ++k) {
        triangle_.push_back(t[k]);
        add_edge(t[k], t[(k + 1) % 3], 3 * i + k);
      }
    }
    rim_.assign(vertices_.size(), 0);
    for (const Edge& e : edges_)
      if (e.count == 1) ++rim_[e.a], ++rim_[e.b];
  }

  const std::vector<Edge>& edges() const { return edges_; }
  // The face of an edge of the link, ascending.
  Triple face(const Edge& e) const {
    Triple f = {v_, vertices_[e.a], vertices_[e.b]};
    std::sort(f.begin(), f.end());
    return f;
  }
  // The same as it stands in its first tet, outwards.
  Triple outward(const TetMatrix& T, const Edge& e) const {
    const Index t = tets_[e.place / 3], i = e.place - e.place % 3;
    const Index opposite = vertices_[triangle_[i + (e.place + 2) % 3]];
    int corner = 0;
    while (T(t, corner) != opposite) ++corner;
    return corners(T, t, corner);
  }
  // The vertex is the smallest of the face's: it alone speaks for it.
  bool owns(const Edge& e) const { return v_ < vertices_[e.a] && v_ < vertices_[e.b]; }

  bool on_boundary() const {
    return std::any_of(edges_.begin(), edges_.end(), [](const Edge& e) { return e.count == 1; });
  }
  // Whether the link is a disc (with a boundary) or a sphere.
  bool fine() {
    const Index euler = static_cast<Index>(vertices_.size()) - static_cast<Index>(edges_.size()) +
                        static_cast<Index>(triangle_.size() / 3);
    if (euler != (on_boundary() ? 1 : 2)) return false;
    for (const Edge& e : edges_)
      if (e.count > 2) return false;
    // An edge of the boundary has two boundary faces, or the links of its ends are pinched there.
    for (const Index n : rim_)
      if (n != 0 && n != 2) return false;
    // In one piece?
    joined_.reset(vertices_.size());
    std::size_t pieces = vertices_.size();
    for (const Edge& e : edges_)
      if (joined_.join_smaller(e.a, e.b)) --pieces;
    return pieces == 1;
  }

  // visit(other end, turns) for every interior edge from here to a vertex with a larger number, ascending. x:
  // the coordinates. pre: every tet is positive.
  template <class Visit>
  void turns(const double* x, Visit&& visit) {
    const Index n = static_cast<Index>(vertices_.size());
    around_.begin.assign(static_cast<std::size_t>(n) + 1, 0);
    for (const Index t : triangle_) ++around_.begin[t + 1];
    std::partial_sum(around_.begin.begin(), around_.begin.end(), around_.begin.begin());
    around_.places.resize(triangle_.size());
    for (Index place = static_cast<Index>(triangle_.size()); place-- > 0;)
      around_.places[--around_.begin[triangle_[place] + 1]] = place;
    // around_.begin[i + 1] is now where i begins.
    order_.clear();
    for (Index i = 0; i < n; ++i)
      if (vertices_[i] > v_ && rim_[i] == 0) order_.push_back(i);
    std::sort(order_.begin(), order_.end(), [&](Index a, Index b) { return vertices_[a] < vertices_[b]; });
    side_.assign(static_cast<std::size_t>(n), Side::unknown);
    const auto point = [&](Index v) { return x + 3 * static_cast<std::ptrdiff_t>(v); };
    const double* const from_point = point(v_);
    for (const Index other : order_) {
      const Index begin = around_.begin[other + 1],
                  end = other + 1 < n ? around_.begin[other + 2] : static_cast<Index>(around_.places.size());
      const double* const to_point = point(vertices_[other]);
      const auto wedge = [&](Index place, int k) { return triangle_[place - place % 3 + (place + k) % 3]; };
      const Index fixed = wedge(around_.places[begin], 1);
      const auto side = [&](Index y) {
        if (side_[y] == Side::unknown)
          side_[y] =
              static_cast<Side>(orient3d(from_point, to_point, point(vertices_[y]), point(vertices_[fixed])));
        return side_[y];
      };
      int turns = 0;
      for (Index i = begin; i < end; ++i) {
        // The wedge [k, l) is less than half a turn wide.
        const Index k = wedge(around_.places[i], 1), l = wedge(around_.places[i], 2);
        if ((k == fixed || side(k) != Side::negative) && l != fixed && side(l) == Side::negative) ++turns;
      }
      for (Index i = begin; i < end; ++i)
        for (int k = 1; k < 3; ++k) side_[wedge(around_.places[i], k)] = Side::unknown;
      visit(vertices_[other], turns);
    }
  }

 private:
  enum class Side : signed char { negative = -1, zero, positive, unknown };  // of orient3d

  static std::size_t scattered(std::uint64_t key) { return (key * 0x9e3779b97f4a7c15u) >> 32; }

  Index number_vertex(Index v) {
    const std::size_t mask = vertex_at_.size() - 1;
    std::size_t slot = scattered(static_cast<std::uint64_t>(v)) & mask;
    for (; vertex_at_[slot] >= 0; slot = (slot + 1) & mask)
      if (vertices_[vertex_at_[slot]] == v) return vertex_at_[slot];
    vertex_at_[slot] = static_cast<Index>(vertices_.size());
    vertices_.push_back(v);
    return vertex_at_[slot];
  }

  void add_edge(Index from, Index to, Index place) {
    const Index a = std::min(from, to), b = std::max(from, to);
    const std::size_t mask = edge_at_.size() - 1;
    std::size_t slot = scattered(static_cast<std::uint64_t>(a) << 32 | static_cast<std::uint64_t>(b)) & mask;
    for (; edge_at_[slot] >= 0; slot = (slot + 1) & mask) {
      Edge& e = edges_[edge_at_[slot]];
      if (e.a != a || e.b != b) continue;
      ++e.count;
      e.same_side = e.same_side || triangle_start(e.place) == from;
      return;
    }
    edge_at_[slot] = static_cast<Index>(edges_.size());
    edges_.push_back({a, b, place, 1, false});
  }
  Index triangle_start(Index place) const { return triangle_[place]; }

  Index v_ = 0;
  const Index* tets_ = nullptr;
  std::vector<Index> triangle_;  // three a tet, numbers of the link
  std::vector<Index> vertices_;  // of the mesh
  std::vector<Edge> edges_;
  std::vector<Index> rim_;                  // by vertex of the link: boundary edges there
  std::vector<Index> vertex_at_, edge_at_;  // hash tables with open addressing
  UnionFind joined_;
  struct Around {
    std::vector<Index> begin, places;  // by vertex of the link: the corners of triangles there
  };
  Around around_;
  std::vector<Index> order_;
  std::vector<Side> side_;
};

// What the stars of a range of vertices show.
struct Stars {
  std::vector<Triple> boundary;  // outward, as they stand in their tet
  Finding crowded{3}, same_side{3}, bad_link, turned{2}, unturned{2};
  std::vector<std::array<Index, 2>> branched;  // interior edges with more than one turn

  void read(const TetMatrix& T, const double* x, bool positive, Index v, const Index* tets, Index count,
            Star& star, std::vector<char>& on_boundary) {
    if (count == 0) return;
    star.read(T, v, tets, count);
    on_boundary[static_cast<std::size_t>(v)] = star.on_boundary();
    own_.clear();
    for (const Star::Edge& e : star.edges())
      if ((e.count != 2 || e.same_side) && star.owns(e)) own_.push_back({star.face(e), &e});
    std::sort(own_.begin(), own_.end());
    for (const auto& [f, e] : own_) {
      if (e->count == 1)
        boundary.push_back(star.outward(T, *e));
      else
        (e->count == 2 ? same_side : crowded).add(f[0], f[1], f[2]);
    }
    if (!star.fine()) bad_link.add(v);
    if (positive)
      star.turns(x, [&](Index other, int turns) {
        if (turns != 1) turned.add(v, other);
        if (turns < 1) unturned.add(v, other);
        if (turns > 1) branched.push_back({v, other});
      });
  }

  void append(const Stars& next) {
    boundary.insert(boundary.end(), next.boundary.begin(), next.boundary.end());
    crowded.append(next.crowded);
    same_side.append(next.same_side);
    bad_link.append(next.bad_link);
    turned.append(next.turned);
    unturned.append(next.unturned);
    branched.insert(branched.end(), next.branched.begin(), next.branched.end());
  }

 private:
  std::vector<std::pair<Triple, const Star::Edge*>> own_;
};

// R3 by vertex numbers: both sides as sorted lists of distinct faces.
void compare_boundary(VerifyResult& r, const Surface& surface, const std::vector<Triple>& boundary) {
  std::vector<Triple> want, have;
  const auto distinct = [](std::vector<Triple>& side) {
    parallel_sort(side);
    side.erase(std::unique(side.begin(), side.end()), side.end());
  };
  parallel_invoke(
      [&] {
        for (Index f = 0; f < surface.F.rows(); ++f)
          want.push_back(rotated(Triple{surface.F(f, 0), surface.F(f, 1), surface.F(f, 2)}));
        distinct(want);
      },
      [&] {
        for (const Triple& f : boundary) have.push_back(rotated(f));
        distinct(have);
      });
  std::vector<Triple> missing, extra;
  std::set_difference(want.begin(), want.end(), have.begin(), have.end(), std::back_inserter(missing));
  std::set_difference(have.begin(), have.end(), want.begin(), want.end(), std::back_inserter(extra));
  Finding lost(3), added(3);
  for (const Triple& f : missing) lost.add(f[0], f[1], f[2]);
  for (const Triple& f : extra) added.add(f[0], f[1], f[2]);
  report(r, Rule::R3, lost, "faces of the surface are not boundary faces of the tet mesh");
  report(r, Rule::R3, added, "boundary faces of the tet mesh are not faces of the surface");
  if (missing.empty() && extra.empty() && boundary.size() != static_cast<std::size_t>(surface.F.rows())) {
    Finding twice;
    twice.count = std::abs(surface.F.rows() - static_cast<std::int64_t>(boundary.size()));
    report(r, Rule::R3, twice, "faces of the surface are listed more than once");
  }
}

// R3 by coordinates.
void compare_boundary_points(VerifyResult& r, const Surface& surface, const VertexMatrix& X,
                             const std::vector<Triple>& boundary) {
  using Point = std::array<double, 3>;
  const auto face = [](const VertexMatrix& V, const Triple& f) {
    std::array<Point, 3> p;
    for (std::size_t k = 0; k < 3; ++k)
      for (int c = 0; c < 3; ++c) p[k][static_cast<std::size_t>(c)] = V(f[k], c) + 0.0;  // -0 is 0
    std::rotate(p.begin(), std::min_element(p.begin(), p.end()), p.end());
    return p;
  };
  std::vector<std::array<Point, 3>> want, have;
  for (Index f = 0; f < surface.F.rows(); ++f)
    want.push_back(face(surface.V, {surface.F(f, 0), surface.F(f, 1), surface.F(f, 2)}));
  for (const Triple& f : boundary) have.push_back(face(X, f));
  for (auto* side : {&want, &have}) {
    std::sort(side->begin(), side->end());
    side->erase(std::unique(side->begin(), side->end()), side->end());
  }
  Finding lost, added;
  std::vector<std::array<Point, 3>> rest;
  std::set_difference(want.begin(), want.end(), have.begin(), have.end(), std::back_inserter(rest));
  lost.count = static_cast<std::int64_t>(rest.size());
  rest.clear();
  std::set_difference(have.begin(), have.end(), want.begin(), want.end(), std::back_inserter(rest));
  added.count = static_cast<std::int64_t>(rest.size());
  report(r, Rule::R3, lost, "faces of the surface are not boundary faces of the tet mesh");
  report(r, Rule::R3, added, "boundary faces of the tet mesh are not faces of the surface");
}

void compare_vertices(VerifyResult& r, const Surface& surface, const TetMesh& mesh, double max_move) {
  const Eigen::Index common = std::min(surface.V.rows(), mesh.V.rows());
  const double diagonal = diagonal_of(surface.V);
  Finding moved, too_far;
  for (Eigen::Index v = 0; v < common; ++v) {
    if ((surface.V.row(v).array() == mesh.V.row(v).array()).all()) continue;
    const double move = (surface.V.row(v) - mesh.V.row(v)).norm() / diagonal;
    r.max_move = std::max(r.max_move, move);
    ++r.moved_vertices;
    moved.add(static_cast<Index>(v));
    if (!(move <= max_move)) too_far.add(static_cast<Index>(v));
  }
  report(r, Rule::R2, max_move > 0 ? too_far : moved,
         max_move > 0 ? "vertices of the surface have moved farther than allowed"
                      : "vertices of the surface have moved");
  Finding missing;
  missing.count = std::max<std::int64_t>(0, surface.V.rows() - mesh.V.rows());
  report(r, Rule::R2, missing, "vertices of the surface are missing from the tet mesh");
}

}  // namespace

bool VerifyResult::fails(Rule rule) const {
  return std::any_of(failures.begin(), failures.end(),
                     [&](const VerifyFailure& f) { return f.rule == rule; });
}

std::string VerifyResult::summary() const {
  if (!complete) return "the check was stopped";
  if (failures.empty()) return "every rule holds";
  std::string s;
  for (const VerifyFailure& f : failures) s += (s.empty() ? "" : " ") + f.message;
  return s;
}

namespace {

// R1. False: the numbers make no sense, and nothing more can be looked at. infinite: vertices.
bool check_numbers(VerifyResult& r, const TetMesh& mesh, Finding& infinite) {
  const auto vertices = static_cast<Index>(mesh.V.rows());
  const auto tets = static_cast<Index>(mesh.T.rows());
  const TetMatrix& T = mesh.T;
  if (tets == 0) {
    Finding none;
    none.count = 1;
    report(r, Rule::R1, none, "tet mesh has no tets");
    return false;
  }
  Finding out_of_range, unused;
  for (Index v = 0; v < vertices; ++v)
    if (!mesh.V.row(v).allFinite()) infinite.add(v);
  std::vector<char> used(static_cast<std::size_t>(vertices), 0);
  for (Index t = 0; t < tets; ++t) {
    bool good = true;
    for (int k = 0; k < 4; ++k) good = good && T(t, k) >= 0 && T(t, k) < vertices;
    if (!good) {
      out_of_range.add(t);
      continue;
    }
    for (int k = 0; k < 4; ++k) used[static_cast<std::size_t>(T(t, k))] = 1;
  }
  report(r, Rule::R1, infinite, "vertices have a coordinate that is not finite");
  report(r, Rule::R1, out_of_range, "tets name a vertex that does not exist");
  if (out_of_range.count > 0) return false;
  for (Index v = 0; v < vertices; ++v)
    if (!used[static_cast<std::size_t>(v)]) unused.add(v);
  report(r, Rule::R1, unused, "vertices belong to no tet");
  return true;
}

// R2, R3. on_boundary: of each vertex.
void compare_with_surface(VerifyResult& r, const Surface& surface, const TetMesh& mesh,
                          const VerifyOptions& options, const std::vector<Triple>& boundary,
                          const std::vector<char>& on_boundary) {
  if (options.geometry_only) {
    compare_boundary_points(r, surface, mesh.V, boundary);
    return;
  }
  compare_vertices(r, surface, mesh, options.max_move);
  compare_boundary(r, surface, boundary);
  Finding added;
  for (Index v = static_cast<Index>(surface.V.rows()); v < static_cast<Index>(mesh.V.rows()); ++v)
    if (on_boundary[static_cast<std::size_t>(v)]) added.add(v);
  report(r, Rule::R3, added, "added vertices lie on the boundary");
}

// R4. sign: of each tet.
void report_signs(VerifyResult& r, const std::vector<signed char>& sign) {
  Finding inverted, flat;
  for (std::size_t t = 0; t < sign.size(); ++t) {
    if (sign[t] < 0) inverted.add(static_cast<Index>(t));
    if (sign[t] == 0) flat.add(static_cast<Index>(t));
  }
  report(r, Rule::R4, inverted, "tets are inverted");
  report(r, Rule::R4, flat, "tets are flat");
}

}  // namespace

VerifyResult verify(const Surface& surface, const TetMesh& mesh, const VerifyOptions& options,
                    const RunContext& context) {
  const ScopedThreads threads(context.threads > 0 ? context.threads : thread_cap());
  VerifyResult r;
  r.surface_vertices = surface.V.rows();
  r.surface_faces = surface.F.rows();
  r.vertices = mesh.V.rows();
  r.tets = mesh.T.rows();
  const auto vertices = static_cast<Index>(mesh.V.rows());
  const auto tets = static_cast<Index>(mesh.T.rows());
  const TetMatrix& T = mesh.T;
  const auto stopped = [&] {
    r.complete = !context.stop();
    return !r.complete;
  };

  Finding infinite;
  if (!check_numbers(r, mesh, infinite)) return r;
  if (stopped()) return r;

  // R4 first: R6 is a question for positive tets.
  std::vector<signed char> sign(static_cast<std::size_t>(tets), 1);
  const double* const x = mesh.V.data();
  const auto point = [&](Index v) { return x + 3 * static_cast<std::ptrdiff_t>(v); };
  bool positive = infinite.count == 0;
  if (positive)
    positive = parallel_reduce(
        tets, kLightGrain, true,
        [&](std::int64_t begin, std::int64_t end) {
          bool all = true;
          for (std::int64_t t = begin; t < end; ++t) {
            const int s = orient3d(point(T(t, 0)), point(T(t, 1)), point(T(t, 2)), point(T(t, 3)));
            sign[static_cast<std::size_t>(t)] = static_cast<signed char>(s);
            all = all && s > 0;
          }
          return all;
        },
        [](bool a, bool b) { return a && b; });
  if (stopped()) return r;

  // What the tets around each vertex show, of a block of vertices at a time.
  RawVector<std::size_t> star_begin;
  RawVector<Index> star_tets;
  group_items(vertices, star_begin, star_tets, [&](auto visit) {
    for (Index t = 0; t < tets; ++t)
      for (int k = 0; k < 4; ++k) visit(T(t, k), t);
  });
  if (stopped()) return r;
  std::vector<char> on_boundary(static_cast<std::size_t>(vertices), 0);
  std::vector<Stars> blocks(static_cast<std::size_t>((vertices + kLightGrain - 1) / kLightGrain));
  parallel_for(vertices, kLightGrain, [&](std::int64_t begin, std::int64_t end) {
    Stars& block = blocks[static_cast<std::size_t>(begin / kLightGrain)];
    Star star;
    for (std::int64_t v = begin; v < end; ++v)
      block.read(T, x, positive, static_cast<Index>(v), star_tets.data() + star_begin[v],
                 static_cast<Index>(star_begin[v + 1] - star_begin[v]), star, on_boundary);
  });
  Stars stars;
  for (const Stars& block : blocks) stars.append(block);
  if (stopped()) return r;

  r.boundary_faces = static_cast<std::int64_t>(stars.boundary.size());
  compare_with_surface(r, surface, mesh, options, stars.boundary, on_boundary);
  if (stopped()) return r;

  if (!positive && infinite.count == 0) report_signs(r, sign);
  // R5, R6
  report(r, Rule::R5, stars.crowded, "faces are shared by more than two tets");
  report(r, Rule::R5, stars.same_side, "shared faces have both tets on the same side");
  report(r, Rule::R5, stars.bad_link, "vertices have a link that is neither a disc nor a sphere");
  if (options.allow_branches) r.branch_edges = std::move(stars.branched);
  report(r, Rule::R6, options.allow_branches ? stars.unturned : stars.turned,
         "interior edges are surrounded by tets that do not make exactly one turn");
  return r;
}

}  // namespace overtet
