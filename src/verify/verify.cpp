#include "src/verify/verify.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numeric>
#include <unordered_map>

#include "kernels/parallel/parallel.h"
#include "kernels/predicates/predicates.h"

namespace overtet {

namespace {

constexpr std::int64_t kTetGrain = 1 << 14, kVertexGrain = 1 << 12;
constexpr std::size_t kNamed = 4;  // elements named in a message

using Triple = std::array<Index, 3>;

// Corners of the face opposite to corner k, outward.
constexpr int kFace[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
// Edge e runs from corner 0 to corner 1; seen along it, corner 2 comes before corner 3 counter-clockwise.
constexpr int kEdge[6][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2},
                             {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 3, 0, 1}};

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

// Items grouped by a vertex: counting sort, so that the order within a group is the order of the items.
template <class Item>
struct Groups {
  std::vector<std::size_t> begin;  // #V + 1
  std::vector<Item> items;

  template <class Visit>  // visit(emit) calls emit(vertex, item) for every item, twice in the same order
  void build(Index vertices, const Visit& visit) {
    begin.assign(static_cast<std::size_t>(vertices) + 2, 0);
    visit([&](Index v, const Item&) { ++begin[static_cast<std::size_t>(v) + 2]; });
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    items.resize(begin.back());
    visit([&](Index v, const Item& item) { items[begin[static_cast<std::size_t>(v) + 1]++] = item; });
    begin.pop_back();
  }
  Item* first(Index v) { return items.data() + begin[static_cast<std::size_t>(v)]; }
  Item* last(Index v) { return items.data() + begin[static_cast<std::size_t>(v) + 1]; }
};

Triple smallest_first(const Triple& f) {
  if (f[0] <= f[1] && f[0] <= f[2]) return f;
  if (f[1] <= f[0] && f[1] <= f[2]) return {f[1], f[2], f[0]};
  return {f[2], f[0], f[1]};
}

struct FaceItem {
  Index middle, largest;
  std::uint32_t parity : 1, face : 2, unused : 29;
  Index tet;
};

struct EdgeItem {
  Index other;  // the larger end
  Index tet;
  std::int32_t edge;  // 0 .. 5
};

struct Faces {
  std::vector<Triple> boundary;               // outward, as they stand in their tet
  std::vector<Index> at_vertex;               // #V: distinct faces that contain the vertex
  std::vector<char> on_boundary, on_crowded;  // #V: has a face of one tet, of more than two
  Finding crowded{3}, same_side{3};
};

Triple corners(const TetMatrix& T, Index t, int face) {
  return {T(t, kFace[face][0]), T(t, kFace[face][1]), T(t, kFace[face][2])};
}

Faces match_faces(const TetMatrix& T, Index vertices) {
  Faces out;
  out.at_vertex.assign(static_cast<std::size_t>(vertices), 0);
  out.on_boundary.assign(static_cast<std::size_t>(vertices), 0);
  out.on_crowded.assign(static_cast<std::size_t>(vertices), 0);
  Groups<FaceItem> groups;
  groups.build(vertices, [&](auto emit) {
    for (Index t = 0; t < T.rows(); ++t)
      for (int k = 0; k < 4; ++k) {
        Triple f = corners(T, t, k);
        const int turns = (f[0] < f[1]) + (f[1] < f[2]) + (f[0] < f[2]);
        std::sort(f.begin(), f.end());
        emit(f[0], FaceItem{f[1], f[2], static_cast<std::uint32_t>(turns & 1), static_cast<std::uint32_t>(k),
                            0, t});
      }
  });
  parallel_for(vertices, kVertexGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v)
      std::sort(groups.first(static_cast<Index>(v)), groups.last(static_cast<Index>(v)),
                [](const FaceItem& a, const FaceItem& b) {
                  if (a.middle != b.middle) return a.middle < b.middle;
                  if (a.largest != b.largest) return a.largest < b.largest;
                  return a.tet != b.tet ? a.tet < b.tet : a.face < b.face;
                });
  });
  for (Index v = 0; v < vertices; ++v) {
    const FaceItem* const last = groups.last(v);
    for (const FaceItem* a = groups.first(v); a != last;) {
      const FaceItem* b = a + 1;
      while (b != last && b->middle == a->middle && b->largest == a->largest) ++b;
      const Triple f = {v, a->middle, a->largest};
      for (const Index x : f) ++out.at_vertex[static_cast<std::size_t>(x)];
      if (b - a == 1) {
        out.boundary.push_back(corners(T, a->tet, static_cast<int>(a->face)));
        for (const Index x : f) out.on_boundary[static_cast<std::size_t>(x)] = 1;
      } else if (b - a > 2) {
        out.crowded.add(f[0], f[1], f[2]);
        for (const Index x : f) out.on_crowded[static_cast<std::size_t>(x)] = 1;
      } else if (a->parity == a[1].parity) {
        out.same_side.add(f[0], f[1], f[2]);
      }
      a = b;
    }
  }
  return out;
}

// R3 by vertex numbers: both sides as sorted lists of distinct faces.
void compare_boundary(VerifyResult& r, const Surface& surface, const std::vector<Triple>& boundary) {
  std::vector<Triple> want, have;
  for (Index f = 0; f < surface.F.rows(); ++f)
    want.push_back(smallest_first({surface.F(f, 0), surface.F(f, 1), surface.F(f, 2)}));
  for (const Triple& f : boundary) have.push_back(smallest_first(f));
  for (auto* side : {&want, &have}) {
    std::sort(side->begin(), side->end());
    side->erase(std::unique(side->begin(), side->end()), side->end());
  }
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
  const double diagonal =
      surface.V.rows() ? (surface.V.colwise().maxCoeff() - surface.V.colwise().minCoeff()).norm() : 0;
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
         max_move > 0 ? "vertices of the surface have moved further than allowed"
                      : "vertices of the surface have moved");
  Finding missing;
  missing.count = std::max<std::int64_t>(0, surface.V.rows() - mesh.V.rows());
  report(r, Rule::R2, missing, "vertices of the surface are missing");
}

struct UnionFind {
  std::vector<std::int32_t> parent;
  explicit UnionFind(std::size_t n) : parent(n) { std::iota(parent.begin(), parent.end(), 0); }
  std::int32_t find(std::int32_t i) {
    while (parent[static_cast<std::size_t>(i)] != i) {
      auto& p = parent[static_cast<std::size_t>(i)];
      p = parent[static_cast<std::size_t>(p)];
      i = p;
    }
    return i;
  }
  void join(std::int32_t a, std::int32_t b) {
    a = find(a), b = find(b);
    if (a != b) parent[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }
};

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

VerifyResult verify(const Surface& surface, const TetMesh& mesh, const VerifyOptions& options,
                    const RunContext& context) {
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

  // R1
  if (tets == 0) {
    Finding none;
    none.count = 1;
    report(r, Rule::R1, none, "mesh has no tets");
    return r;
  }
  Finding infinite, out_of_range, unused;
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
  report(r, Rule::R1, out_of_range, "tets name a vertex that is not there");
  if (out_of_range.count > 0) return r;
  for (Index v = 0; v < vertices; ++v)
    if (!used[static_cast<std::size_t>(v)]) unused.add(v);
  report(r, Rule::R1, unused, "vertices belong to no tet");
  if (stopped()) return r;

  // R2, R3 and the faces of R5
  const Faces faces = match_faces(T, vertices);
  r.boundary_faces = static_cast<std::int64_t>(faces.boundary.size());
  if (options.geometry_only) {
    compare_boundary_points(r, surface, mesh.V, faces.boundary);
  } else {
    compare_vertices(r, surface, mesh, options.max_move);
    compare_boundary(r, surface, faces.boundary);
    Finding added;
    for (Index v = static_cast<Index>(surface.V.rows()); v < vertices; ++v)
      if (faces.on_boundary[static_cast<std::size_t>(v)]) added.add(v);
    report(r, Rule::R3, added, "added vertices lie on the boundary");
  }
  if (stopped()) return r;

  // R4
  std::vector<signed char> sign(static_cast<std::size_t>(tets));
  const double* const x = mesh.V.data();
  const auto point = [&](Index v) { return x + 3 * static_cast<std::ptrdiff_t>(v); };
  if (infinite.count == 0) {
    parallel_for(tets, kTetGrain, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t t = begin; t < end; ++t)
        sign[static_cast<std::size_t>(t)] = static_cast<signed char>(
            orient3d(point(T(t, 0)), point(T(t, 1)), point(T(t, 2)), point(T(t, 3))));
    });
    Finding inverted, flat;
    for (Index t = 0; t < tets; ++t) {
      if (sign[static_cast<std::size_t>(t)] < 0) inverted.add(t);
      if (sign[static_cast<std::size_t>(t)] == 0) flat.add(t);
    }
    report(r, Rule::R4, inverted, "tets are inverted");
    report(r, Rule::R4, flat, "tets are flat");
  }
  const bool positive = infinite.count == 0 && !r.fails(Rule::R4);
  if (stopped()) return r;

  // R5: edges grouped by their smaller end; equal ones become neighbours.
  report(r, Rule::R5, faces.crowded, "faces are shared by more than two tets");
  report(r, Rule::R5, faces.same_side, "shared faces have both tets on the same side");
  Groups<EdgeItem> edges;
  edges.build(vertices, [&](auto emit) {
    for (Index t = 0; t < tets; ++t)
      for (int e = 0; e < 6; ++e) {
        const Index a = T(t, kEdge[e][0]), b = T(t, kEdge[e][1]);
        emit(std::min(a, b), EdgeItem{std::max(a, b), t, e});
      }
  });
  parallel_for(vertices, kVertexGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v)
      std::sort(edges.first(static_cast<Index>(v)), edges.last(static_cast<Index>(v)),
                [](const EdgeItem& a, const EdgeItem& b) {
                  if (a.other != b.other) return a.other < b.other;
                  return a.tet != b.tet ? a.tet < b.tet : a.edge < b.edge;
                });
  });
  if (stopped()) return r;
  // Numbers for the distinct edges, and through them one for every (vertex, neighbour): a vertex of the
  // vertex's link.
  std::vector<std::int32_t> number(6 * static_cast<std::size_t>(tets));
  std::vector<std::size_t> edge_begin;  // into edges.items
  std::vector<Index> low_end, link_vertices(static_cast<std::size_t>(vertices), 0);
  for (Index v = 0; v < vertices; ++v) {
    const EdgeItem* const last = edges.last(v);
    for (const EdgeItem* a = edges.first(v); a != last; ++a) {
      if (a == edges.first(v) || a->other != a[-1].other) {
        edge_begin.push_back(static_cast<std::size_t>(a - edges.items.data()));
        low_end.push_back(v);
        ++link_vertices[static_cast<std::size_t>(v)];
        ++link_vertices[static_cast<std::size_t>(a->other)];
      }
      number[6 * static_cast<std::size_t>(a->tet) + static_cast<std::size_t>(a->edge)] =
          static_cast<std::int32_t>(low_end.size() - 1);
    }
  }
  edge_begin.push_back(edges.items.size());
  UnionFind link(2 * low_end.size());
  std::vector<Index> link_faces(static_cast<std::size_t>(vertices), 0),
      components(static_cast<std::size_t>(vertices), 0);
  for (Index t = 0; t < tets; ++t) {
    std::int32_t seen[4] = {-1, -1, -1, -1};  // a link vertex of each corner
    for (int e = 0; e < 6; ++e)
      for (int end = 0; end < 2; ++end) {
        const int corner = kEdge[e][end];
        const Index here = T(t, corner), there = T(t, kEdge[e][1 - end]);
        const std::int32_t slot =
            2 * number[6 * static_cast<std::size_t>(t) + static_cast<std::size_t>(e)] + (here > there);
        if (seen[corner] >= 0) link.join(seen[corner], slot);
        seen[corner] = slot;
      }
    for (int k = 0; k < 4; ++k) ++link_faces[static_cast<std::size_t>(T(t, k))];
  }
  for (std::size_t e = 0; e < low_end.size(); ++e)
    for (std::int32_t side = 0; side < 2; ++side) {
      const auto slot = static_cast<std::int32_t>(2 * e) + side;
      if (link.find(slot) == slot)
        ++components[static_cast<std::size_t>(side ? edges.items[edge_begin[e]].other : low_end[e])];
    }
  // How many boundary faces each edge has: none, or two, or the links of its ends are pinched there.
  std::vector<std::uint8_t> boundary_faces_at(low_end.size(), 0);
  for (const Triple& f : faces.boundary)
    for (std::size_t k = 0; k < 3; ++k) {
      const Index a = std::min(f[k], f[(k + 1) % 3]), b = std::max(f[k], f[(k + 1) % 3]);
      const EdgeItem* it = std::lower_bound(edges.first(a), edges.last(a), b,
                                            [](const EdgeItem& e, Index other) { return e.other < other; });
      auto& count = boundary_faces_at[static_cast<std::size_t>(
          number[6 * static_cast<std::size_t>(it->tet) + static_cast<std::size_t>(it->edge)])];
      if (count < 3) ++count;
    }
  std::vector<char> pinched(static_cast<std::size_t>(vertices), 0);
  for (std::size_t e = 0; e < low_end.size(); ++e)
    if (boundary_faces_at[e] != 0 && boundary_faces_at[e] != 2)
      pinched[static_cast<std::size_t>(low_end[e])] =
          pinched[static_cast<std::size_t>(edges.items[edge_begin[e]].other)] = 1;
  Finding bad_link;
  for (Index v = 0; v < vertices; ++v) {
    const auto i = static_cast<std::size_t>(v);
    if (!used[i]) continue;
    const Index euler = link_vertices[i] - faces.at_vertex[i] + link_faces[i];
    if (euler != (faces.on_boundary[i] ? 1 : 2) || faces.on_crowded[i] || components[i] != 1 || pinched[i])
      bad_link.add(v);
  }
  report(r, Rule::R5, bad_link, "vertices have a link that is neither a disc nor a sphere");
  if (!positive || stopped()) return r;

  // R6
  const auto branched = parallel_collect<std::pair<std::size_t, int>>(
      static_cast<std::int64_t>(low_end.size()), kTetGrain,
      [&](std::int64_t begin, std::int64_t end, auto& found) {
        for (auto e = static_cast<std::size_t>(begin); e < static_cast<std::size_t>(end); ++e) {
          if (boundary_faces_at[e] != 0) continue;
          const EdgeItem& head = edges.items[edge_begin[e]];
          const Index a = low_end[e], b = head.other, fixed = T(head.tet, kEdge[head.edge][2]);
          int turns = 0;
          for (std::size_t i = edge_begin[e]; i < edge_begin[e + 1]; ++i) {
            const EdgeItem& item = edges.items[i];
            Index k = T(item.tet, kEdge[item.edge][2]), l = T(item.tet, kEdge[item.edge][3]);
            if (T(item.tet, kEdge[item.edge][0]) != a) std::swap(k, l);  // seen from the other end
            // The wedge [k, l) is less than half a turn wide.
            const bool from = k == fixed || orient3d(point(a), point(b), point(k), point(fixed)) >= 0;
            if (from && l != fixed && orient3d(point(a), point(b), point(fixed), point(l)) > 0) ++turns;
          }
          if (turns != 1) found.emplace_back(e, turns);
        }
      });
  Finding turned(2);
  for (const auto& [e, turns] : branched) turned.add(low_end[e], edges.items[edge_begin[e]].other);
  report(r, Rule::R6, turned, "interior edges have tets around them that do not make one turn");
  return r;
}

}  // namespace overtet
