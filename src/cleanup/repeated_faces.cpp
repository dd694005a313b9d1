#include "src/cleanup/repeated_faces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <compare>
#include <tuple>

#include "kernels/core/point_table.h"
#include "kernels/core/union_find.h"
#include "kernels/parallel/grouping.h"
#include "src/mesh/topology.h"

namespace overtet {

namespace {

enum Keep { one_copy, one_of_each_orientation, all_copies, ways };

struct Copy {
  std::array<Index, 3> corners;  // sorted
  Index face;
  bool odd;  // whether the face runs through them in odd order
};

// What is left of a patch, for each way.
struct Remains {
  std::array<Index, ways> odd{};      // edges with an odd number of faces
  std::array<Index, ways> not_two{};  // edges with another number than two
  bool both_orientations = false;
};

class Patches {
 public:
  Patches(const VertexMatrix& V, const TriangleMatrix& F, const RawEdges& edges)
      : V_(V), F_(F), edges_(edges) {}

  std::vector<Index> to_drop() {
    find_copies();
    if (sets_.empty()) return {};
    join_sets();
    look_at_edges();
    std::vector<Index> drop;
    for (std::size_t s = 0; s < sets_.size(); ++s)
      drop_from(s, way_of(patch_.root(static_cast<Index>(s))), drop);
    std::sort(drop.begin(), drop.end());
    return drop;
  }

 private:
  struct Set {  // copies of one face: copies_[begin] ... copies_[end - 1]
    std::size_t begin, end;
    Index gone[ways];
  };

  void find_copies() {
    // Copies share all edges, so each has edges of more than two faces (or it and its copy are closed).
    std::vector<char> seen(F_.rows(), 0);
    std::vector<Copy> all;
    for (const EdgeGroup& g : edges_.others)
      for (Index i = g.begin; g.count > 2 && i < g.begin + g.count; ++i) {
        const Index f = half_edge_face(edges_.list[i]);
        if (seen[f]) continue;
        seen[f] = 1;
        Copy c{{}, f, false};
        for (int k = 0; k < 3; ++k) c.corners[k] = edges_.place[F_(f, k)];
        for (const auto& [i, j] : {std::pair{0, 1}, {1, 2}, {0, 1}})
          if (c.corners[i] > c.corners[j]) std::swap(c.corners[i], c.corners[j]), c.odd = !c.odd;
        all.push_back(c);
      }
    std::sort(all.begin(), all.end(), [](const Copy& a, const Copy& b) {
      return std::tie(a.corners, a.face) < std::tie(b.corners, b.face);
    });
    set_of_.assign(F_.rows(), -1);
    for (std::size_t i = 0, j = 0; i < all.size(); i = j) {
      for (j = i + 1; j < all.size() && all[j].corners == all[i].corners;) ++j;
      if (j - i == 1) continue;
      Set set{copies_.size(), copies_.size() + (j - i), {}};
      Index odd = 0;
      for (std::size_t k = i; k < j; ++k) {
        copies_.push_back(all[k]);
        set_of_[all[k].face] = static_cast<Index>(sets_.size());
        odd += all[k].odd;
      }
      const Index n = static_cast<Index>(j - i);
      set.gone[one_copy] = n - 1;
      set.gone[one_of_each_orientation] = n - (odd > 0) - (odd < n);
      sets_.push_back(set);
    }
  }

  void join_sets() {
    patch_.reset(sets_.size());
    for (const EdgeGroup& g : edges_.others) {
      Index first = -1;
      for (Index i = g.begin; i < g.begin + g.count; ++i) {
        const Index s = set_of_[half_edge_face(edges_.list[i])];
        if (s < 0) continue;
        if (first >= 0) patch_.join_smaller(first, s);
        first = s;
      }
    }
  }

  void look_at_edges() {
    remains_.resize(sets_.size());
    std::vector<Index> here;
    for (const EdgeGroup& g : edges_.others) {
      here.clear();
      for (Index i = g.begin; i < g.begin + g.count; ++i)
        if (const Index s = set_of_[half_edge_face(edges_.list[i])]; s >= 0) here.push_back(s);
      if (here.empty()) continue;
      std::sort(here.begin(), here.end());
      here.erase(std::unique(here.begin(), here.end()), here.end());
      Remains& r = remains_[patch_.root(here[0])];
      for (int way = 0; way < ways; ++way) {
        Index left = g.count;
        for (const Index s : here) left -= sets_[s].gone[way];
        r.odd[way] += left % 2;
        r.not_two[way] += left != 2;
      }
    }
    for (std::size_t s = 0; s < sets_.size(); ++s)
      if (sets_[s].gone[one_copy] != sets_[s].gone[one_of_each_orientation])
        remains_[patch_.root(static_cast<Index>(s))].both_orientations = true;
  }

  Keep way_of(Index patch) {
    const Remains& r = remains_[patch];
    const Index least = *std::min_element(r.odd.begin(), r.odd.end());
    if (r.odd[one_copy] == least && (!r.both_orientations || r.odd[one_of_each_orientation] != least ||
                                     (r.not_two[one_copy] == 0 && !is_surrounded(patch))))
      return one_copy;
    return r.odd[one_of_each_orientation] == least ? one_of_each_orientation : all_copies;
  }

  // Whether the box of all other faces contains the patch's.
  bool is_surrounded(Index patch) {
    Eigen::AlignedBox3d inner, outer;
    for (Index f = 0; f < F_.rows(); ++f) {
      const bool own = set_of_[f] >= 0 && patch_.root(set_of_[f]) == patch;
      for (int k = 0; k < 3; ++k) (own ? inner : outer).extend(V_.row(F_(f, k)).transpose());
    }
    return !outer.isEmpty() && outer.contains(inner);
  }

  void drop_from(std::size_t s, Keep way, std::vector<Index>& drop) const {
    if (way == all_copies) return;
    bool kept[2] = {false, false};
    for (std::size_t i = sets_[s].begin; i < sets_[s].end; ++i) {
      const Copy& c = copies_[i];
      const int kind = way == one_of_each_orientation && c.odd;
      if (kept[kind]) drop.push_back(c.face);
      kept[kind] = true;
    }
  }

  const VertexMatrix& V_;
  const TriangleMatrix& F_;
  const RawEdges& edges_;
  std::vector<Copy> copies_;
  std::vector<Set> sets_;
  std::vector<Index> set_of_;  // of each face, or -1
  UnionFind patch_;            // of sets
  std::vector<Remains> remains_;
};

// Three numbers in order.
std::array<Index, 3> in_order(Index a, Index b, Index c) {
  if (a > b) std::swap(a, b);
  if (b > c) std::swap(b, c);
  if (a > b) std::swap(a, b);
  return {a, b, c};
}

// Faces in places that others have, too: of each face the set it belongs to, or -1; sets have two members or
// more.
struct Places {
  std::vector<Index> set_of, left;  // left: of each set, how many are not dropped

  Places(const VertexMatrix& V, const TriangleMatrix& F) : set_of(F.rows(), -1) {
    PointTable table(static_cast<std::size_t>(V.rows()));
    std::vector<Index> point(V.rows());
    for (Index v = 0; v < V.rows(); ++v) point[v] = table.number_of(V.data() + 3 * std::int64_t{v});
    struct Face {
      std::array<Index, 3> corners;
      Index face;
      auto operator<=>(const Face&) const = default;
    };
    std::vector<Face> all(F.rows());
    for (Index f = 0; f < F.rows(); ++f)
      all[f] = {in_order(point[F(f, 0)], point[F(f, 1)], point[F(f, 2)]), f};
    parallel_sort_groups(all, V.rows(), [](const Face& f) { return f.corners[0]; });
    for (std::size_t i = 0, j = 0; i < all.size(); i = j) {
      for (j = i + 1; j < all.size() && all[j].corners == all[i].corners;) ++j;
      if (j - i == 1) continue;
      for (std::size_t k = i; k < j; ++k) set_of[all[k].face] = static_cast<Index>(left.size());
      left.push_back(static_cast<Index>(j - i));
    }
  }
};

}  // namespace

std::vector<Index> loose_copies(const VertexMatrix& V, const TriangleMatrix& F, const RawEdges& edges) {
  if (std::none_of(edges.others.begin(), edges.others.end(),
                   [](const EdgeGroup& g) { return g.count % 2 == 1; }))
    return {};
  Places places(V, F);
  if (places.left.empty()) return {};
  // Edges are called by a number in edges.list, those of two faces by their smaller half-edge behind these.
  const auto listed = static_cast<Index>(edges.list.size());
  std::vector<Index> edge_of(3 * F.rows());
  std::vector<char> odd(edges.list.size(), 0);
  for (Index h = 0; h < 3 * F.rows(); ++h)
    edge_of[h] = edges.partner[h] < 0 ? 0 : listed + std::min(h, edges.partner[h]);
  for (const EdgeGroup& g : edges.others) {
    odd[g.begin] = g.count % 2 == 1;
    for (Index i = g.begin; i < g.begin + g.count; ++i) edge_of[edges.list[i]] = g.begin;
  }
  odd.resize(static_cast<std::size_t>(listed) + 3 * static_cast<std::size_t>(F.rows()), 0);
  const auto is_loose = [&](Index f) {
    return places.set_of[f] >= 0 && places.left[places.set_of[f]] > 1 &&
           odd[edge_of[3 * f]] + odd[edge_of[3 * f + 1]] + odd[edge_of[3 * f + 2]] > 1;
  };
  std::vector<Index> drop, stack;
  std::vector<char> gone(F.rows(), 0);
  for (Index f = 0; f < F.rows(); ++f)
    if (is_loose(f)) stack.push_back(f);
  while (!stack.empty()) {
    const Index f = stack.back();
    stack.pop_back();
    if (gone[f] || !is_loose(f)) continue;
    gone[f] = 1;
    drop.push_back(f);
    --places.left[places.set_of[f]];
    for (Index h = 3 * f; h < 3 * f + 3; ++h) {
      odd[edge_of[h]] = !odd[edge_of[h]];
      if (edges.partner[h] >= 0) stack.push_back(half_edge_face(edges.partner[h]));
    }
  }
  std::sort(drop.begin(), drop.end());
  return drop;
}

std::vector<Index> repeated_faces(const VertexMatrix& V, const TriangleMatrix& F, const RawEdges& edges) {
  return Patches(V, F, edges).to_drop();
}

}  // namespace overtet
