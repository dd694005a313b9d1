#include "src/mesh/topology.h"

#include <algorithm>
#include <array>

#include "kernels/bvh/self_intersections.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "kernels/predicates/predicates.h"

namespace overtet {

namespace {

std::string name(const char* what, Index i) { return std::string(what) + " " + std::to_string(i); }

std::string face_name(const TriangleMatrix& F, Index f) {
  return name("Face", f) + " (vertices " + std::to_string(F(f, 0)) + ", " + std::to_string(F(f, 1)) + ", " +
         std::to_string(F(f, 2)) + ", counted from 0)";
}

std::string edge_name(Index a, Index b) {
  return "The edge between vertices " + std::to_string(std::min(a, b)) + " and " +
         std::to_string(std::max(a, b)) + " (counted from 0)";
}

class Checker {
 public:
  Checker(const Surface& surface) : V_(surface.V), F_(surface.F) {}

  TopologyCheck run() {
    indices();
    if (!check_.indices_valid) return std::move(check_);
    coordinates();
    edges();
    duplicates();
    if (check_.closed && check_.manifold_edges && check_.oriented) fans();
    if (check_.ok()) components();
    if (!check_.ok()) check_.topology = {};
    return std::move(check_);
  }

 private:
  // Notes the first problem of a kind.
  void fail(bool& flag, std::string problem) {
    if (flag) check_.problems.push_back(std::move(problem));
    flag = false;
  }

  void indices() {
    const Index n = static_cast<Index>(V_.rows());
    if (F_.rows() == 0) fail(check_.indices_valid, "The surface has no faces.");
    for (Index f = 0; f < F_.rows() && check_.indices_valid; ++f) {
      for (int k = 0; k < 3; ++k)
        if (F_(f, k) < 0 || F_(f, k) >= n)
          fail(check_.indices_valid, face_name(F_, f) + " names a vertex that does not exist: there are " +
                                         std::to_string(n) + " vertices.");
      if (F_(f, 0) == F_(f, 1) || F_(f, 1) == F_(f, 2) || F_(f, 2) == F_(f, 0))
        fail(check_.indices_valid, face_name(F_, f) + " names the same vertex twice.");
    }
  }

  void coordinates() {
    if (all_finite(V_)) return;
    for (Index v = 0; v < V_.rows(); ++v)
      if (!V_.row(v).allFinite())
        fail(check_.finite, name("Vertex", v) + " has a coordinate that is not a finite number.");
  }

  // Half-edges sorted by their smaller vertex; partners then are in one short list.
  void edges() {
    const Index half_edges = 3 * static_cast<Index>(F_.rows());
    std::vector<Index> begin(V_.rows() + 1, 0), list(half_edges);
    const auto low = [&](Index h) { return std::min(half_edge_source(F_, h), half_edge_target(F_, h)); };
    const auto high = [&](Index h) { return std::max(half_edge_source(F_, h), half_edge_target(F_, h)); };
    for (Index h = 0; h < half_edges; ++h) ++begin[low(h) + 1];
    for (Index v = 0; v < V_.rows(); ++v) begin[v + 1] += begin[v];
    std::vector<Index> at(begin.begin(), begin.end() - 1);
    for (Index h = 0; h < half_edges; ++h) list[at[low(h)]++] = h;
    check_.topology.twin.assign(half_edges, -1);
    const auto wrong = parallel_collect<std::pair<Index, Index>>(
        V_.rows(), kLightGrain,
        [&](std::int64_t from, std::int64_t to, std::vector<std::pair<Index, Index>>& out) {
          for (std::int64_t v = from; v < to; ++v) {
            std::sort(list.begin() + begin[v], list.begin() + begin[v + 1],
                      [&](Index x, Index y) { return high(x) != high(y) ? high(x) < high(y) : x < y; });
            for (Index i = begin[v]; i < begin[v + 1];) {
              Index j = i + 1;
              while (j < begin[v + 1] && high(list[j]) == high(list[i])) ++j;
              const Index g = list[i], h = list[j - 1];
              if (j - i == 2 && half_edge_source(F_, g) != half_edge_source(F_, h)) {
                check_.topology.twin[g] = h;
                check_.topology.twin[h] = g;
              } else {
                out.emplace_back(i, j - i);
              }
              i = j;
            }
          }
        });
    for (const auto& [first, count] : wrong) wrong_edge(&list[first], count);
  }

  void wrong_edge(const Index* h, Index count) {
    const Index a = half_edge_source(F_, h[0]), b = half_edge_target(F_, h[0]);
    if (count == 1) {
      fail(check_.closed, edge_name(a, b) + " belongs to face " + std::to_string(half_edge_face(h[0])) +
                              " only: the surface has a hole there; it must be closed.");
    } else if (count > 2) {
      fail(check_.manifold_edges, edge_name(a, b) + " is shared by " + std::to_string(count) + " faces (" +
                                      std::to_string(half_edge_face(h[0])) + ", " +
                                      std::to_string(half_edge_face(h[1])) + ", " +
                                      std::to_string(half_edge_face(h[2])) + (count > 3 ? ", ..." : "") +
                                      "); it must be shared by two.");
    } else {
      fail(check_.oriented,
           "Faces " + std::to_string(half_edge_face(h[0])) + " and " + std::to_string(half_edge_face(h[1])) +
               " run the same way along the edge of vertices " + std::to_string(a) + " and " +
               std::to_string(b) +
               " (counted from 0): the faces are not oriented consistently, or the surface is one-sided.");
    }
  }

  void duplicates() {
    // Two faces with the same vertices share an edge, so only around such edges there can be any.
    std::vector<std::array<Index, 4>> keys;
    const bool edges_fine = check_.manifold_edges;
    for (Index f = 0; f < F_.rows(); ++f) {
      std::array<Index, 3> v{F_(f, 0), F_(f, 1), F_(f, 2)};
      if (edges_fine && check_.closed && check_.oriented) {
        // Then a copy is the neighbour over all three edges at once.
        const Index g = half_edge_face(check_.topology.twin[3 * f]);
        if (half_edge_face(check_.topology.twin[3 * f + 1]) != g ||
            half_edge_face(check_.topology.twin[3 * f + 2]) != g)
          continue;
      }
      std::sort(v.begin(), v.end());
      keys.push_back({v[0], v[1], v[2], f});
    }
    std::sort(keys.begin(), keys.end());
    for (std::size_t i = 1; i < keys.size(); ++i)
      if (std::equal(keys[i].begin(), keys[i].begin() + 3, keys[i - 1].begin()))
        check_.duplicate_faces.emplace_back(keys[i - 1][3], keys[i][3]);
    if (!check_.duplicate_faces.empty())
      check_.problems.push_back("Faces " + std::to_string(check_.duplicate_faces[0].first) + " and " +
                                std::to_string(check_.duplicate_faces[0].second) +
                                " have the same three vertices.");
  }

  void fans() {
    std::vector<Index> faces_at(V_.rows(), 0);
    check_.topology.out.assign(V_.rows(), -1);
    for (Index h = 3 * static_cast<Index>(F_.rows()) - 1; h >= 0; --h) {
      check_.topology.out[half_edge_source(F_, h)] = h;
      ++faces_at[half_edge_source(F_, h)];
    }
    for (Index v = 0; v < V_.rows(); ++v) {
      const Index first = check_.topology.out[v];
      if (first < 0) {
        fail(check_.manifold_vertices, name("Vertex", v) + " belongs to no face; remove it.");
        continue;
      }
      Index seen = 0, h = first;
      do {
        ++seen;
        h = check_.topology.twin[previous_half_edge(h)];
      } while (h != first && seen <= faces_at[v]);
      if (seen != faces_at[v])
        fail(check_.manifold_vertices, name("Vertex", v) +
                                           " joins parts of the surface that meet only in this vertex (" +
                                           std::to_string(seen) + " of its " + std::to_string(faces_at[v]) +
                                           " faces form a fan); give each part a vertex of its own.");
    }
  }

  void components() {
    auto& component = check_.topology.component_of_face;
    component.assign(F_.rows(), -1);
    std::vector<char> seen(V_.rows(), 0);
    std::vector<Index> stack;
    for (Index start = 0; start < F_.rows(); ++start) {
      if (component[start] >= 0) continue;
      const Index c = static_cast<Index>(check_.topology.components.size());
      SurfaceComponent info;
      info.first_face = start;
      component[start] = c;
      stack.push_back(start);
      while (!stack.empty()) {
        const Index f = stack.back();
        stack.pop_back();
        ++info.faces;
        for (int k = 0; k < 3; ++k) {
          if (!seen[F_(f, k)]) seen[F_(f, k)] = 1, ++info.vertices;
          const Index g = half_edge_face(check_.topology.twin[3 * f + k]);
          if (component[g] < 0) component[g] = c, stack.push_back(g);
        }
      }
      // V - 3F/2 + F = 2 - 2 genus
      info.genus = (2 - (info.vertices - info.faces / 2)) / 2;
      check_.topology.components.push_back(info);
    }
  }

  const VertexMatrix& V_;
  const TriangleMatrix& F_;
  TopologyCheck check_;
};

}  // namespace

std::vector<Index> half_edges_around(const SurfaceTopology& topology, Index v) {
  std::vector<Index> around;
  const Index first = topology.out[v];
  Index h = first;
  do {
    around.push_back(h);
    h = topology.twin[previous_half_edge(h)];
  } while (h != first);
  return around;
}

Index find_half_edge(const TriangleMatrix& F, const SurfaceTopology& topology, Index a, Index b) {
  const Index first = topology.out[a];
  Index h = first;
  do {
    if (half_edge_target(F, h) == b) return h;
    h = topology.twin[previous_half_edge(h)];
  } while (h != first);
  return -1;
}

TopologyCheck check_topology(const Surface& surface) { return Checker(surface).run(); }

Result<SurfaceTopology> require_topology(const Surface& surface) {
  TopologyCheck check = check_topology(surface);
  if (!check.ok()) return Error{ErrorCode::bad_input, check.problems.front()};
  return std::move(check.topology);
}

std::vector<Index> degenerate_faces(const Surface& surface) {
  return parallel_collect<Index>(
      surface.F.rows(), kLightGrain, [&](std::int64_t begin, std::int64_t end, std::vector<Index>& out) {
        for (Index f = static_cast<Index>(begin); f < end; ++f) {
          const auto p = [&](int k) { return surface.V.data() + 3 * std::int64_t{surface.F(f, k)}; };
          if (collinear(p(0), p(1), p(2))) out.push_back(f);
        }
      });
}

}  // namespace overtet
