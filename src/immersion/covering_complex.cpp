#include "src/immersion/covering_complex.h"

#include <algorithm>
#include <map>
#include <span>
#include <string>

#include "kernels/core/tet_tables.h"
#include "kernels/core/union_find.h"
#include "kernels/parallel/grouping.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/raw_vector.h"
#include "kernels/parallel/tuning.h"

namespace overtet {

namespace {

// Copies of tets with explicit neighbours: until duplicate edges are gone, vertices do not identify faces.
struct Copies {
  RawVector<std::array<Index, 4>> tet;
  RawVector<std::array<Index, 4>> next;  // neighbour, or -1 - input face
};

class Builder {
 public:
  Builder(const Surface& surface, const Arrangement& arrangement, const TetgenResult& tets,
          const Sheets& sheets)
      : surface_(surface), arrangement_(arrangement), tets_(tets), sheets_(sheets) {}

  Result<Cover> run() {
    copy_tets();
    if (auto error = number_vertices()) return *error;
    if (auto error = separate_edges()) return *error;
    separate_faces();
    return finish();
  }

 private:
  void copy_tets() {
    const Index n = static_cast<Index>(tets_.T.rows());
    first_.resize(n + 1);
    first_[0] = 0;
    for (Index t = 0; t < n; ++t) first_[t + 1] = first_[t] + sheets_.winding_of(t);
    copies_.tet.resize(first_[n]);
    copies_.next.resize(first_[n]);
    parallel_for(n, kLightGrain, [&](std::int64_t begin, std::int64_t end) {
      for (Index t = static_cast<Index>(begin); t < end; ++t)
        for (Index i = 0; i < first_[t + 1] - first_[t]; ++i) copy_tet(t, i);
    });
  }

  void copy_tet(Index t, Index i) {
    const Index c = first_[t] + i;
    for (int k = 0; k < 4; ++k) {
      copies_.tet[c][k] = tets_.T(t, k);
      const Index f = sheets_.facet_on[t][k];
      const Index other = tets_.neighbours(t, k);
      if (f < 0) {
        copies_.next[c][k] = first_[other] + i;
        continue;
      }
      const int to = sheets_.across(f, sheets_.facets[f].front == t, i);
      const Index triangle = sheets_.facets[f].triangle;
      copies_.next[c][k] = to >= 0
                               ? first_[other] + to
                               : -1 - arrangement_.sheets[arrangement_.sheet_begin[triangle] - 1 - to].face;
    }
  }

  // Vertices of the solid are classes of tet corners that are glued.
  std::optional<Error> number_vertices() {
    const std::size_t n = copies_.tet.size();
    // Only corners at one point can be glued, so each point's corners are a problem of their own.
    RawVector<Index> start, corners;
    group_items(tets_.V.rows(), start, corners, [&](auto visit) {
      for (std::size_t c = 0; c < n; ++c)
        for (int k = 0; k < 4; ++k) visit(copies_.tet[c][k], static_cast<Index>(4 * c + k));
    });
    UnionFind classes(4 * n);      // of corners
    RawVector<Index> root(4 * n);  // the first corner of its class
    parallel_for(tets_.V.rows(), kLightGrain, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t v = begin; v < end; ++v) {
        const std::span<const Index> here(corners.data() + start[v], corners.data() + start[v + 1]);
        for (const Index i : here)
          for (int k = 0; k < 4; ++k) {
            const Index other = copies_.next[i / 4][k];
            if (k == i % 4 || other < i / 4) continue;  // boundary, or done from there
            int m = 0;
            while (copies_.tet[other][m] != v) ++m;
            classes.join_smaller(i, 4 * other + m);
          }
        for (const Index i : here) root[i] = classes.root(i);
      }
    });
    std::vector<Index> number(4 * n, -1);
    const Index surface_vertices = static_cast<Index>(surface_.V.rows());
    std::vector<char> seen(surface_vertices, 0);
    for (std::size_t c = 0; c < n; ++c) {
      for (int k = 0; k < 4; ++k) {
        if (copies_.next[c][k] >= 0) continue;
        const Index face = -1 - copies_.next[c][k];
        for (const int j : kTetFace[k]) {
          for (int m = 0; m < 3; ++m) {
            const Index v = surface_.F(face, m);
            if (arrangement_.vertex_of_input[v] != copies_.tet[c][j]) continue;
            Index& at = number[root[4 * c + j]];
            if (at >= 0 && at != v)
              return Error{ErrorCode::unsolved, "Vertices " + std::to_string(at) + " and " +
                                                    std::to_string(v) +
                                                    " touch, and the solid found would join them."};
            at = v;
            seen[v] = 1;
          }
        }
      }
    }
    for (Index v = 0; v < surface_vertices; ++v)
      if (!seen[v])
        return Error{ErrorCode::unsolved, "Vertex " + std::to_string(v) + " is lost in the arrangement."};
    Index next = surface_vertices;
    position_.reserve(surface_vertices + tets_.V.rows());
    for (Index v = 0; v < surface_vertices; ++v)
      position_.push_back(arrangement_.V.row(arrangement_.vertex_of_input[v]));
    const Index begin_free = static_cast<Index>(arrangement_.V.rows()),
                end_free = begin_free + tets_.free_points;
    for (const bool free : {true, false})
      for (std::size_t i = 0; i < 4 * n; ++i) {
        if (root[i] != static_cast<Index>(i) || number[i] >= 0) continue;
        const Index v = copies_.tet[i / 4][i % 4];
        if (free && (v < begin_free || v >= end_free)) continue;
        number[i] = next++;
        position_.push_back(tets_.V.row(v));
        free_points_ += free;
      }
    parallel_for(static_cast<std::int64_t>(n), kLightGrain, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t c = begin; c < end; ++c)
        for (int k = 0; k < 4; ++k) copies_.tet[c][k] = number[root[4 * c + k]];
    });
    return std::nullopt;
  }

  // The tets around the edge tet[c][i]-tet[c][j], walking both ways from c.
  void ring(Index c, Index a, Index b, std::vector<Index>& out, bool& closed) const {
    out.assign(1, c);
    closed = false;
    for (int direction = 0; direction < 2 && !closed; ++direction) {
      int sides[2], n = 0;
      for (int k = 0; k < 4; ++k)
        if (copies_.tet[c][k] != a && copies_.tet[c][k] != b) sides[n++] = k;
      Index t = c;
      int through = sides[direction];
      for (;;) {
        const Index other = copies_.next[t][through];
        if (other < 0) break;
        if (other == c) {
          closed = true;
          break;
        }
        // Leave `other` by its remaining face: opposite to the corner it shares with t off the edge.
        Index kept = -1;
        for (int k = 0; k < 4; ++k)
          if (k != through && copies_.tet[t][k] != a && copies_.tet[t][k] != b) kept = copies_.tet[t][k];
        t = other;
        out.push_back(t);
        for (int k = 0; k < 4; ++k)
          if (copies_.tet[t][k] == kept) through = k;
      }
    }
  }

  // Vertices that several copies of one tet share.
  void mark_several(std::vector<char>& several) const {
    for (Index t = 0; t < static_cast<Index>(first_.size()) - 1; ++t)
      for (Index i = first_[t] + 1; i < first_[t + 1]; ++i)
        for (Index j = first_[t]; j < i; ++j)
          for (int k = 0; k < 4; ++k)
            if (copies_.tet[i][k] == copies_.tet[j][k]) several[copies_.tet[i][k]] = 1;
  }

  // Tets with so many marked corners or more.
  std::vector<Index> tets_with(const std::vector<char>& marked, int least) const {
    return parallel_collect<Index>(static_cast<std::int64_t>(copies_.tet.size()), kLightGrain,
                                   [&](std::int64_t begin, std::int64_t end, std::vector<Index>& out) {
                                     for (std::int64_t c = begin; c < end; ++c)
                                       if (const auto& t = copies_.tet[c];
                                           marked[t[0]] + marked[t[1]] + marked[t[2]] + marked[t[3]] >= least)
                                         out.push_back(static_cast<Index>(c));
                                   });
  }

  // A vertex may lie on several copies of one tet (around hinges); then two different edges can have the same
  // ends. Only such vertices matter. All but one edge are halved; boundary edges stay whole.
  std::optional<Error> separate_edges() {
    std::vector<char> several(position_.size(), 0);
    mark_several(several);
    // Halving an edge changes its tets, so edges that share a tet with it wait for the next round.
    for (bool waiting = true; waiting;) {
      waiting = false;
      several.resize(position_.size(), 0);
      std::map<std::pair<Index, Index>, std::vector<Index>> tets_at;
      for (const Index c : tets_with(several, 2))
        for (const Index a : copies_.tet[c])
          for (const Index b : copies_.tet[c])
            if (a < b && several[a] && several[b]) tets_at[{a, b}].push_back(c);
      std::vector<char> changed(copies_.tet.size(), 0);
      for (const auto& [edge, tets] : tets_at) {
        if (std::any_of(tets.begin(), tets.end(), [&](Index c) { return changed[c] != 0; })) {
          waiting = true;
          continue;
        }
        if (auto error = separate_edge(edge.first, edge.second, tets, changed)) return error;
      }
    }
    return std::nullopt;
  }

  std::optional<Error> separate_edge(Index a, Index b, std::vector<Index> tets, std::vector<char>& changed) {
    struct Found {
      std::vector<Index> tets;
      bool closed;
    };
    std::vector<Found> found;
    std::vector<Index> around;
    while (!tets.empty()) {
      bool closed;
      ring(tets[0], a, b, around, closed);
      std::erase_if(tets,
                    [&](Index c) { return std::find(around.begin(), around.end(), c) != around.end(); });
      found.push_back({around, closed});
    }
    if (found.size() == 1) return std::nullopt;
    const auto open = std::count_if(found.begin(), found.end(), [](const Found& f) { return !f.closed; });
    if (open > 1)
      return Error{ErrorCode::unsolved, "Two edges of the surface between vertices " + std::to_string(a) +
                                            " and " + std::to_string(b) + " coincide."};
    bool keep = open == 0;  // keep the boundary edge, else the first one
    for (const Found& f : found) {
      if (!f.closed) continue;
      if (keep) {
        keep = false;
        continue;
      }
      for (const Index t : f.tets) changed[t] = 1;
      halve(f.tets, a, b);
    }
    return std::nullopt;
  }

  // Splits a closed edge at its middle; each tet becomes a lower half (keeps its number and a) and an upper
  // one.
  void halve(const std::vector<Index>& tets, Index a, Index b) {
    const Index m = static_cast<Index>(position_.size());
    position_.push_back(0.5 * (position_[a] + position_[b]));
    ++split_;
    std::map<Index, Index> upper;
    for (const Index t : tets) {
      upper[t] = static_cast<Index>(copies_.tet.size());
      copies_.tet.push_back(copies_.tet[t]);
      copies_.next.push_back(copies_.next[t]);
    }
    for (const Index t : tets) {
      const Index u = upper[t];
      int ka = 0, kb = 0;
      for (int k = 0; k < 4; ++k) {
        if (copies_.tet[t][k] == a) ka = k;
        if (copies_.tet[t][k] == b) kb = k;
      }
      const Index beyond = copies_.next[t][ka];  // of the face that has b
      copies_.tet[t][kb] = m;
      copies_.tet[u][ka] = m;
      if (beyond >= 0)
        for (Index& back : copies_.next[beyond])
          if (back == t) back = u;
      copies_.next[u][ka] = beyond;
      copies_.next[u][kb] = t;
      copies_.next[t][ka] = u;
      for (int k = 0; k < 4; ++k)
        if (k != ka && k != kb) copies_.next[u][k] = upper.at(copies_.next[u][k]);
    }
  }

  // With all edges told apart, different faces can still have the same three vertices: inside the solid,
  // under a face whose three edges are wound. All but one get a vertex in their middle; boundary faces stay
  // whole.
  void separate_faces() {
    std::vector<char> several(position_.size(), 0);
    mark_several(several);
    std::map<std::array<Index, 3>, std::vector<std::pair<Index, int>>> sides;
    for (const Index c : tets_with(several, 3))
      for (int k = 0; k < 4; ++k) {
        std::array<Index, 3> f = tet_face(copies_.tet[c], k);
        if (!several[f[0]] || !several[f[1]] || !several[f[2]]) continue;
        std::sort(f.begin(), f.end());
        sides[f].emplace_back(c, k);
      }
    std::vector<std::array<Index, 3>> doubled;
    for (const auto& [f, list] : sides) {
      const auto boundary = std::count_if(list.begin(), list.end(),
                                          [&](const auto& s) { return copies_.next[s.first][s.second] < 0; });
      if (static_cast<Index>(list.size()) + boundary > 2) doubled.push_back(f);
    }
    // Splitting changes tets, so the sides of a face are looked up again before each split.
    for (const auto& f : doubled) {
      bool keep = true;
      for (Index c = 0; c < static_cast<Index>(copies_.tet.size()); ++c) {
        const int k = opposite(c, f);
        if (k < 0) continue;
        if (copies_.next[c][k] < 0) {
          keep = false;  // the boundary face is the one that stays
          break;
        }
      }
      const Index n = static_cast<Index>(copies_.tet.size());
      for (Index c = 0; c < n; ++c) {
        const int k = opposite(c, f);
        if (k < 0 || copies_.next[c][k] < c) continue;
        if (keep)
          keep = false;
        else
          split_face(c, k);
      }
    }
  }

  // The corner of c opposite to the face with these (sorted) vertices, or -1.
  int opposite(Index c, const std::array<Index, 3>& f) const {
    int k = -1, hits = 0;
    for (int j = 0; j < 4; ++j)
      if (std::find(f.begin(), f.end(), copies_.tet[c][j]) != f.end())
        ++hits;
      else
        k = j;
    return hits == 3 ? k : -1;
  }

  // Splits an interior face at its centroid, and the tets on both sides into three each.
  void split_face(Index c, int k) {
    const Index other = copies_.next[c][k];
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const int j : kTetFace[k]) centre += position_[copies_.tet[c][j]] / 3;
    const Index m = static_cast<Index>(position_.size());
    position_.push_back(centre);
    ++split_;
    int back = 0;
    while (copies_.next[other][back] != c) ++back;
    // Part without face vertex v, on each side.
    std::map<Index, Index> part[2];
    const Index tet[2] = {c, other};
    const int apex[2] = {k, back};
    for (int side = 0; side < 2; ++side) {
      const auto corners = copies_.tet[tet[side]];
      const auto next = copies_.next[tet[side]];
      bool first = true;
      for (int j = 0; j < 4; ++j) {
        if (j == apex[side]) continue;
        Index id = tet[side];
        if (!first) {
          id = static_cast<Index>(copies_.tet.size());
          copies_.tet.push_back(corners);
          copies_.next.push_back(next);
        }
        first = false;
        part[side][corners[j]] = id;
        copies_.tet[id] = corners;
        copies_.tet[id][j] = m;
        copies_.next[id] = next;
        // Beyond the face opposite to m lies what lay beyond the face opposite to corner j.
        if (next[j] >= 0)
          for (Index& n : copies_.next[next[j]])
            if (n == tet[side]) {
              n = id;
              break;
            }
      }
    }
    for (int side = 0; side < 2; ++side)
      for (const auto& [vertex, id] : part[side])
        for (int j = 0; j < 4; ++j) {
          if (copies_.tet[id][j] == m) continue;
          copies_.next[id][j] =
              j == apex[side] ? part[1 - side].at(vertex) : part[side].at(copies_.tet[id][j]);
        }
  }

  Result<Cover> finish() {
    Cover out;
    out.split_edges = split_;
    out.free_points = free_points_;
    out.mesh.surface_vertices = static_cast<Index>(surface_.V.rows());
    out.mesh.V.resize(position_.size(), 3);
    for (std::size_t v = 0; v < position_.size(); ++v) out.mesh.V.row(v) = position_[v];
    out.mesh.T.resize(copies_.tet.size(), 4);
    out.neighbours.resize(copies_.tet.size(), 4);
    struct Side {
      std::array<Index, 3> triangle;
      Index face;
    };
    const std::vector<Side> sides =
        parallel_collect<Side>(static_cast<std::int64_t>(copies_.tet.size()), kLightGrain,
                               [&](std::int64_t begin, std::int64_t end, std::vector<Side>& list) {
                                 for (std::int64_t c = begin; c < end; ++c) {
                                   const auto& t = copies_.tet[c];
                                   out.mesh.T.row(c) << t[0], t[1], t[2], t[3];
                                   for (int k = 0; k < 4; ++k) {
                                     out.neighbours(c, k) = std::max(copies_.next[c][k], -1);
                                     if (copies_.next[c][k] < 0)
                                       list.push_back({tet_face(t, k), -1 - copies_.next[c][k]});
                                   }
                                 }
                               });
    for (const Side& side : sides) out.boundary.push_back(side.triangle), out.face.push_back(side.face);
    return out;
  }

  const Surface& surface_;
  const Arrangement& arrangement_;
  const TetgenResult& tets_;
  const Sheets& sheets_;
  std::vector<Index> first_;  // the first copy of each tet
  Copies copies_;
  std::vector<Eigen::Vector3d> position_;
  Index split_ = 0, free_points_ = 0;
};

}  // namespace

Result<Cover> build_cover(const Surface& surface, const Arrangement& arrangement, const TetgenResult& tets,
                          const Sheets& sheets, const RunContext& context) {
  if (auto error = context.no_room_for(static_cast<std::size_t>(tets.T.rows()) * 160)) return *error;
  return Builder(surface, arrangement, tets, sheets).run();
}

}  // namespace overtet
