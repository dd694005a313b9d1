#include "src/immersion/cells.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <tuple>

#include "kernels/core/tet_tables.h"
#include "kernels/core/triangles.h"
#include "kernels/parallel/grouping.h"
#include "src/cdt/facets_on_faces.h"

namespace overtet {

namespace {

using Triple = std::array<Index, 3>;

class CellFinder {
 public:
  CellFinder(const Arrangement& arrangement, const TetgenResult& tets, Sheets& out)
      : arrangement_(arrangement), tets_(tets), out_(out) {}

  Result<std::vector<Triple>> run() {
    find_facets();
    number_cells();
    if (auto error = find_windings()) return *error;
    cut_handles();
    return std::move(corners_);
  }

 private:
  void find_facets() {
    const Index n = static_cast<Index>(tets_.T.rows());
    const Index m = static_cast<Index>(tets_.facets.rows());
    std::vector<Index> facet_of(m, -1);
    out_.facet_on.assign(n, {-1, -1, -1, -1});
    corners_.clear();
    const std::vector<std::array<Index, 4>> searched =
        tets_.facet_on.empty() ? facets_on_faces(tets_) : std::vector<std::array<Index, 4>>();
    const std::vector<std::array<Index, 4>>& found = searched.empty() ? tets_.facet_on : searched;
    for (Index t = 0; t < n; ++t) {
      for (int k = 0; k < 4; ++k) {
        const Index i = found[t][k];
        if (i < 0) continue;
        const Triple f = tet_face(tets_.T.row(t), k);
        if (facet_of[i] < 0) {
          facet_of[i] = static_cast<Index>(out_.facets.size());
          Facet facet;
          facet.triangle = tets_.facet_markers[i] - 1;
          out_.facets.push_back(facet);
          corners_.push_back(oriented(f, facet.triangle));
        }
        const Index facet = facet_of[i];
        out_.facet_on[t][k] = facet;
        // f points out of t, so where the facet is oriented like f, t is behind it.
        const Triple& c = corners_[facet];
        const int at = c[0] == f[0] ? 0 : c[1] == f[0] ? 1 : 2;
        (c[(at + 1) % 3] == f[1] ? out_.facets[facet].back : out_.facets[facet].front) = t;
      }
    }
  }

  // The facet's corners in the orientation of its arrangement triangle.
  Triple oriented(const Triple& f, Index triangle) const {
    const Triple g{arrangement_.F(triangle, 0), arrangement_.F(triangle, 1), arrangement_.F(triangle, 2)};
    bool same;
    if (sorted(f) == sorted(g)) {
      const int at = g[0] == f[0] ? 0 : g[1] == f[0] ? 1 : 2;
      same = g[(at + 1) % 3] == f[1];
    } else {  // TetGen has split the triangle: compare normals
      const auto normal = [&](const Triple& t) {
        const Eigen::Vector3d a = tets_.V.row(t[0]), b = tets_.V.row(t[1]), c = tets_.V.row(t[2]);
        return Eigen::Vector3d((b - a).cross(c - a));
      };
      same = normal(f).dot(normal(g)) > 0;
    }
    return same ? f : Triple{f[0], f[2], f[1]};
  }

  void number_cells() {
    const Index n = static_cast<Index>(tets_.T.rows());
    out_.cell.assign(n, -1);
    std::vector<Index> stack;
    for (Index seed = 0; seed < n; ++seed) {
      if (out_.cell[seed] >= 0) continue;
      const Index id = cells_++;
      out_.cell[seed] = id;
      stack.push_back(seed);
      while (!stack.empty()) {
        const Index t = stack.back();
        stack.pop_back();
        for (int k = 0; k < 4; ++k) {
          const Index other = tets_.neighbours(t, k);
          if (other < 0 || out_.facet_on[t][k] >= 0 || out_.cell[other] >= 0) continue;
          out_.cell[other] = id;
          stack.push_back(other);
        }
      }
    }
  }

  // A cell that is not simply connected may be covered by copies that change places on the way round. Such
  // cells are cut: all faces between their tets that do not close up around edges become facets without a
  // sheet, whose gluing is a permutation. Starting from a spanning tree of the tets, a face is no cut when it
  // is the last open one around an edge; in a ball that leaves none.
  void cut_handles() {
    Insides insides = deep_insides();
    if (insides.faces.empty()) return;
    find_inner_edges(insides);
    close_faces(insides);
    for (const Insides::Face& face : insides.faces)
      if (face.open) cut(face);
  }

  // The faces between tets of cells with several sheets, and their edges inside the cells.
  struct Insides {
    struct Face {
      Index tet;
      int corner;
      std::array<Index, 3> edges{-1, -1, -1};
      bool open = true;
    };
    std::vector<char> deep;                     // per tet
    std::vector<std::array<Index, 4>> face_on;  // per tet and corner
    std::vector<Face> faces;
    std::vector<std::vector<Index>> faces_of;  // per edge
    std::vector<Index> open_count;             // of these
    std::vector<Index> single;                 // edges that had one open face left

    void close(Index f) {
      faces[f].open = false;
      for (const Index e : faces[f].edges)
        if (e >= 0 && --open_count[e] == 1) single.push_back(e);
    }
  };

  // With its faces.
  Insides deep_insides() const {
    Insides in;
    const Index n = static_cast<Index>(tets_.T.rows());
    in.deep.assign(n, 0);
    bool any = false;
    for (Index t = 0; t < n; ++t) any |= in.deep[t] = out_.winding_of(t) >= 2;
    if (!any) return in;
    in.face_on.assign(n, {-1, -1, -1, -1});
    for (Index t = 0; t < n; ++t) {
      if (!in.deep[t]) continue;
      for (int k = 0; k < 4; ++k) {
        const Index other = tets_.neighbours(t, k);
        if (other < t || out_.facet_on[t][k] >= 0) continue;
        in.face_on[t][k] = static_cast<Index>(in.faces.size());
        for (int j = 0; j < 4; ++j)
          if (tets_.neighbours(other, j) == t) in.face_on[other][j] = in.face_on[t][k];
        in.faces.push_back({t, k});
      }
    }
    return in;
  }

  // Those that are on no facet: the faces around them close up in the cell.
  void find_inner_edges(Insides& in) const {
    struct Use {
      Index p, q, face;
      int side;
      bool operator<(const Use& other) const {
        return std::tie(p, q, face) < std::tie(other.p, other.q, other.face);
      }
    };
    std::vector<Use> uses;
    for (Index f = 0; f < static_cast<Index>(in.faces.size()); ++f)
      for (int i = 0; i < 3; ++i) {
        const Index a = tets_.T(in.faces[f].tet, kTetFace[in.faces[f].corner][i]);
        const Index b = tets_.T(in.faces[f].tet, kTetFace[in.faces[f].corner][(i + 1) % 3]);
        uses.push_back({std::min(a, b), std::max(a, b), f, i});
      }
    parallel_sort_groups(uses, tets_.V.rows(), [](const auto& use) { return use.p; });
    std::vector<std::pair<Index, Index>> on_surface;
    for (const Triple& c : corners_)
      for (int k = 0; k < 3; ++k)
        on_surface.emplace_back(std::min(c[k], c[(k + 1) % 3]), std::max(c[k], c[(k + 1) % 3]));
    parallel_sort_groups(on_surface, tets_.V.rows(), [](const auto& edge) { return edge.first; });
    for (std::size_t b = 0, e = 0; b < uses.size(); b = e) {
      for (e = b + 1; e < uses.size() && uses[e].p == uses[b].p && uses[e].q == uses[b].q;) ++e;
      if (std::binary_search(on_surface.begin(), on_surface.end(), std::make_pair(uses[b].p, uses[b].q)))
        continue;
      in.faces_of.emplace_back();
      in.open_count.push_back(static_cast<Index>(e - b));
      for (std::size_t i = b; i < e; ++i) {
        in.faces_of.back().push_back(uses[i].face);
        in.faces[uses[i].face].edges[uses[i].side] = static_cast<Index>(in.faces_of.size()) - 1;
      }
    }
  }

  // Those of a spanning tree of the tets, and then each that is the last open one around an edge.
  void close_faces(Insides& in) const {
    const Index n = static_cast<Index>(tets_.T.rows());
    std::vector<char> reached(n, 0);
    std::vector<Index> queue;
    for (Index seed = 0; seed < n; ++seed) {
      if (!in.deep[seed] || reached[seed]) continue;
      reached[seed] = 1;
      queue.assign(1, seed);
      for (std::size_t head = 0; head < queue.size(); ++head)
        for (int k = 0; k < 4; ++k) {
          const Index f = in.face_on[queue[head]][k];
          if (f < 0) continue;
          const Index other = tets_.neighbours(queue[head], k);
          if (reached[other]) continue;
          reached[other] = 1;
          queue.push_back(other);
          in.close(f);
        }
    }
    while (!in.single.empty()) {
      const std::vector<Index>& around = in.faces_of[in.single.back()];
      in.single.pop_back();
      const auto open = std::find_if(around.begin(), around.end(), [&](Index f) { return in.faces[f].open; });
      if (open != around.end()) in.close(*open);
    }
  }

  // The face becomes a facet without a sheet.
  void cut(const Insides::Face& face) {
    const Index t = face.tet, other = tets_.neighbours(t, face.corner);
    const Index id = static_cast<Index>(out_.facets.size());
    Facet facet;
    facet.back = t, facet.front = other;
    out_.facets.push_back(facet);
    corners_.push_back(tet_face(tets_.T.row(t), face.corner));
    out_.facet_on[t][face.corner] = id;
    for (int j = 0; j < 4; ++j)
      if (tets_.neighbours(other, j) == t) out_.facet_on[other][j] = id;
    ++out_.cuts;
  }

  std::optional<Error> find_windings() {
    out_.winding.assign(cells_, 0);
    std::vector<std::vector<std::pair<Index, Index>>> links(cells_ + 1);  // (cell, w there - w here)
    const auto index = [&](Index tet) { return tet < 0 ? cells_ : out_.cell[tet]; };
    std::map<std::tuple<Index, Index, Index>, char> seen;
    std::tuple<Index, Index, Index> last(-1, -1, 0);
    for (Index f = 0; f < static_cast<Index>(out_.facets.size()); ++f) {
      Index jump = 0;
      if (const Index g = out_.facets[f].triangle; g >= 0)
        for (Index s = arrangement_.sheet_begin[g]; s < arrangement_.sheet_begin[g + 1]; ++s)
          jump += arrangement_.sheets[s].sign;
      const Index front = index(out_.facets[f].front), back = index(out_.facets[f].back);
      const std::tuple key(front, back, jump);
      if (key == last || !seen.try_emplace(key, 1).second) continue;
      last = key;
      links[front].emplace_back(back, jump);
      links[back].emplace_back(front, -jump);
    }
    std::vector<std::optional<Index>> known(cells_ + 1);
    std::vector<Index> stack{cells_};
    known[cells_] = 0;
    while (!stack.empty()) {
      const Index c = stack.back();
      stack.pop_back();
      for (const auto& [other, jump] : links[c]) {
        if (!known[other]) {
          known[other] = *known[c] + jump;
          stack.push_back(other);
        } else if (*known[other] != *known[c] + jump) {
          return Error{ErrorCode::unsolved,
                       "The rounded arrangement has lost a face: its winding numbers disagree."};
        }
      }
    }
    for (Index c = 0; c < cells_; ++c) {
      if (!known[c]) return Error{ErrorCode::unsolved, "The arrangement has a cell that no face bounds."};
      out_.winding[c] = *known[c];
      if (*known[c] < 0)
        // Whether the surface itself has such a region is for the exact diagnosis to say; rounding can make
        // one.
        return Error{ErrorCode::unsolved,
                     "The rounded arrangement has a cell with the negative winding number " +
                         std::to_string(*known[c]) + "."};
    }
    return std::nullopt;
  }

  const Arrangement& arrangement_;
  const TetgenResult& tets_;
  Sheets& out_;
  Index cells_ = 0;
  std::vector<Triple> corners_;  // per facet
};

}  // namespace

Result<std::vector<std::array<Index, 3>>> find_cells(const Arrangement& arrangement, const TetgenResult& tets,
                                                     Sheets& sheets) {
  return CellFinder(arrangement, tets, sheets).run();
}

}  // namespace overtet
