#include "src/io/tet_view.h"

#include <algorithm>

#include "kernels/core/assertions.h"
#include "src/io/mesh_parts.h"

namespace overtet::io_detail {

TetView::TetView(const TetMesh& m, const MeshAttributes& a, int order)
    : mesh(m), attributes(a), second_(order == 2) {
  if (second_) add_middles();
}

// The edges, each at its smaller vertex, sorted; the number of an edge is its place in that list.
void TetView::add_middles() {
  const auto vertices = static_cast<std::size_t>(mesh.V.rows());
  std::vector<std::int64_t> start(vertices + 1, 0);
  const auto each = [&](auto&& visit) {
    for (Eigen::Index t = 0; t < mesh.T.rows(); ++t)
      for (const auto& [i, j] : kMiddleOf)
        visit(std::min(mesh.T(t, i), mesh.T(t, j)), std::max(mesh.T(t, i), mesh.T(t, j)));
  };
  each([&](Index a, Index) { ++start[static_cast<std::size_t>(a) + 1]; });
  for (std::size_t v = 0; v < vertices; ++v) start[v + 1] += start[v];
  std::vector<Index> ends(static_cast<std::size_t>(start[vertices]));
  std::vector<std::int64_t> at(start.begin(), start.end() - 1), count(vertices);
  each([&](Index a, Index b) { ends[static_cast<std::size_t>(at[static_cast<std::size_t>(a)]++)] = b; });
  parallel_for(mesh.V.rows(), kMediumGrain, [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t v = from; v < to; ++v) {
      const auto begin = ends.begin() + start[static_cast<std::size_t>(v)],
                 end = ends.begin() + start[static_cast<std::size_t>(v) + 1];
      std::sort(begin, end);
      count[static_cast<std::size_t>(v)] = std::unique(begin, end) - begin;
    }
  });
  first_edge_.assign(vertices + 1, 0);
  for (std::size_t v = 0; v < vertices; ++v) {
    first_edge_[v + 1] = first_edge_[v] + count[v];
    const auto begin = ends.begin() + start[v];
    std::copy(begin, begin + count[v], ends.begin() + first_edge_[v]);
  }
  ends.resize(static_cast<std::size_t>(first_edge_[vertices]));
  other_end_ = std::move(ends);
  middle_.resize(first_edge_[vertices], 3);
  middle_of_tet_.resize(mesh.T.rows(), 6);
  parallel_for(mesh.V.rows(), kMediumGrain, [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t v = from; v < to; ++v)
      for (std::int64_t e = first_edge_[static_cast<std::size_t>(v)];
           e < first_edge_[static_cast<std::size_t>(v) + 1]; ++e)
        for (int k = 0; k < 3; ++k)  // halves first: a sum could overflow
          middle_(e, k) = 0.5 * mesh.V(v, k) + 0.5 * mesh.V(other_end_[static_cast<std::size_t>(e)], k);
  });
  parallel_for(mesh.T.rows(), kMediumGrain, [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t t = from; t < to; ++t)
      for (int e = 0; e < 6; ++e)
        middle_of_tet_(t, e) = middle(mesh.T(t, kMiddleOf[e][0]), mesh.T(t, kMiddleOf[e][1]));
  });
}

Index TetView::middle(Index a, Index b) const {
  if (a > b) std::swap(a, b);
  const auto begin = other_end_.begin() + first_edge_[static_cast<std::size_t>(a)],
             end = other_end_.begin() + first_edge_[static_cast<std::size_t>(a) + 1];
  const auto found = std::lower_bound(begin, end, b);
  OVERTET_EXPECTS(found != end && *found == b);
  return static_cast<Index>(mesh.V.rows() + (found - other_end_.begin()));
}

Index TetView::triangle(std::int64_t f, int k) const {
  const auto corner = [&](int i) { return attributes.triangles(f, i % 3); };
  return k < 3 ? corner(k) : middle(corner(k), corner(k + 1));
}

TextBuffer& TetView::tet(TextBuffer& out, std::int64_t t, Index first,
                         const std::array<int, 6>& edges) const {
  out.number(mesh.T(t, 0) + first);
  for (int k = 1; k < 4; ++k) out.character(' ').number(mesh.T(t, k) + first);
  if (second_)
    for (const int e : edges) out.character(' ').number(middle_of_tet_(t, e) + first);
  return out;
}

TextBuffer& TetView::triangle(TextBuffer& out, std::int64_t f, Index first) const {
  out.number(triangle(f, 0) + first);
  for (int k = 1; k < (second_ ? 6 : 3); ++k) out.character(' ').number(triangle(f, k) + first);
  return out;
}

std::map<Index, std::int64_t> occurring(std::int64_t n, const std::vector<Index>& values) {
  std::map<Index, std::int64_t> out;
  if (values.empty() && n > 0) out[1] = n;
  for (std::size_t i = 0; i < values.size();) {
    std::size_t end = i;
    while (end < values.size() && values[end] == values[i]) ++end;
    out[values[i]] += static_cast<std::int64_t>(end - i);
    i = end;
  }
  return out;
}

}  // namespace overtet::io_detail
