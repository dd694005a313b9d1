#include "src/improve/sizes.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>
#include <queue>
#include <utility>

#include "kernels/core/tet_tables.h"
#include "kernels/core/tuning.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "src/improve/bad_tets.h"
#include "src/improve/insert_at.h"
#include "src/improve/tuning.h"

namespace overtet {

namespace {

using Eigen::Vector3d;
using Edge = std::array<Index, 2>;

TetComplex::Tet tet_row(const TetMesh& mesh, Index t) {
  return {mesh.T(t, 0), mesh.T(t, 1), mesh.T(t, 2), mesh.T(t, 3)};
}

std::array<Vector3d, 4> points_of(const TetMesh& mesh, Index t) {
  return {mesh.V.row(mesh.T(t, 0)), mesh.V.row(mesh.T(t, 1)), mesh.V.row(mesh.T(t, 2)),
          mesh.V.row(mesh.T(t, 3))};
}

std::vector<Edge> edges_of(const std::vector<std::array<Index, 3>>& faces) {
  std::vector<Edge> edges;
  for (const auto& f : faces)
    for (int k = 0; k < 3; ++k)
      if (const Index a = f[k], b = f[(k + 1) % 3]; a < b) edges.push_back({a, b});
  // The boundary is closed: each edge runs both ways. That of a part may pass an edge more often.
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

// The other ends of each vertex's edges.
struct Ends {
  std::vector<std::int64_t> begin;
  std::vector<Index> vertex;

  explicit Ends(const TetMesh& mesh) : begin(static_cast<std::size_t>(mesh.V.rows()) + 1, 0) {
    for (Index t = 0; t < mesh.T.rows(); ++t)
      for (int k = 0; k < 4; ++k) begin[mesh.T(t, k) + 1] += 3;
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    vertex.resize(static_cast<std::size_t>(begin.back()));
    std::vector<std::int64_t> at(begin.begin(), begin.end() - 1);
    for (Index t = 0; t < mesh.T.rows(); ++t)
      for (int k = 0; k < 4; ++k)
        for (int j = 0; j < 4; ++j)
          if (j != k) vertex[at[mesh.T(t, k)]++] = mesh.T(t, j);
  }
};

// Dijkstra's algorithm: every value becomes what its best neighbour leaves it. better(x, y); step(value,
// length).
template <class Better, class Step>
void spread_along(const TetMesh& mesh, const Ends& ends, const SizeLimit& limit, std::vector<double>& value,
                  Better&& better, Step&& step) {
  using Item = std::pair<double, Index>;
  const auto later = [&](const Item& x, const Item& y) {
    return x.first != y.first ? better(y.first, x.first) : x.second > y.second;
  };
  std::priority_queue<Item, std::vector<Item>, decltype(later)> queue(later);
  for (std::size_t v = 0; v < value.size(); ++v) queue.emplace(value[v], static_cast<Index>(v));
  while (!queue.empty()) {
    const auto [here, v] = queue.top();
    queue.pop();
    if (here != value[v]) continue;
    for (std::int64_t i = ends.begin[v]; i < ends.begin[v + 1]; ++i) {
      const Index w = ends.vertex[i];
      const double there = step(here, limit.length(mesh.V.row(v), mesh.V.row(w)));
      if (!better(there, value[w])) continue;
      value[w] = there;
      queue.emplace(there, w);
    }
  }
}

}  // namespace

SizeField::SizeField(const TetMesh& mesh, const SizeOptions& options)
    : limit_(options.unit, options.max_volume, options.max_edge),
      boundary_(edges_of(TetComplex(mesh.V, mesh.T).boundary())) {
  limit_.keep_edges(boundary_);
  spread(mesh, options);
}

void SizeField::spread(const TetMesh& mesh, const SizeOptions& options) {
  const auto vertices = static_cast<std::size_t>(mesh.V.rows());
  std::vector<double> asked(vertices, options.max_edge), least(vertices, 0);
  for (std::size_t v = 0; v < options.at_surface.size(); ++v)
    asked[v] = std::min(asked[v], options.at_surface[v]);
  for (const auto& [a, b] : boundary_) {
    const double length = limit_.length(mesh.V.row(a), mesh.V.row(b));
    least[a] = std::max(least[a], length);
    least[b] = std::max(least[b], length);
  }
  const Ends ends(mesh);
  if (!options.at_surface.empty())
    spread_along(
        mesh, ends, limit_, asked, [](double x, double y) { return x < y; },
        [](double x, double length) { return x + kGrading * length; });
  spread_along(
      mesh, ends, limit_, least, [](double x, double y) { return x > y; },
      [](double x, double length) { return x - kShrinking * length; });
  limit_.sizes.resize(vertices);
  for (std::size_t v = 0; v < vertices; ++v) limit_.sizes[v] = {asked[v], least[v]};
}

SizeLimit SizeField::of_part(const MeshPart& part) const {
  SizeLimit limit = limit_.like_this();
  limit.sizes.reserve(part.vertex.size());
  for (const Index v : part.vertex) limit.sizes.push_back(limit_.sizes[v]);
  limit.keep_edges(edges_of(part.complex.boundary()));
  return limit;
}

void SizeField::take(std::span<const Index> number, const std::vector<MeshPart>& parts,
                     const std::vector<std::vector<LocalSize>>& sizes) {
  std::vector<LocalSize> now;
  for (std::size_t v = 0; v < number.size(); ++v)
    if (number[v] >= 0) now.push_back(limit_.sizes[v]);
  for (std::size_t p = 0; p < parts.size(); ++p)
    for (std::size_t v = parts[p].vertex.size(); v < sizes[p].size(); ++v)
      if (parts[p].complex.tet_of(static_cast<Index>(v)) >= 0) now.push_back(sizes[p][v]);
  limit_.sizes = std::move(now);
}

std::vector<Index> SizeField::too_large(const TetMesh& mesh) const {
  return parallel_collect<Index>(mesh.T.rows(), kMediumGrain,
                                 [&](std::int64_t begin, std::int64_t end, std::vector<Index>& out) {
                                   for (Index t = static_cast<Index>(begin); t < end; ++t)
                                     if (limit_.excess(tet_row(mesh, t), points_of(mesh, t)).factor > 1)
                                       out.push_back(t);
                                 });
}

std::int64_t SizeField::fixed_too_long(const TetMesh& mesh) const {
  return std::count_if(boundary_.begin(), boundary_.end(), [&](const Edge& e) {
    return limit_.length(mesh.V.row(e[0]), mesh.V.row(e[1])) >
           std::min(limit_.sizes[e[0]].asked, limit_.sizes[e[1]].asked);
  });
}

double SizeField::becomes(const TetMesh& mesh, Index t) const {
  const auto at = points_of(mesh, t);
  const auto side = [&](int k) { return (at[k] - at[0]).cwiseProduct(limit_.unit()).eval(); };
  const double volume = side(1).cross(side(2)).dot(side(3)) / 6, wanted = limit_.wanted(tet_row(mesh, t));
  return 1 + volume / (kUsualVolume * wanted * wanted * wanted);
}

std::vector<int> SizeField::weights(const TetMesh& mesh, std::span<const Index> tets) const {
  std::vector<int> weight(tets.size());
  parallel_for(static_cast<std::int64_t>(tets.size()), kMediumGrain,
               [&](std::int64_t begin, std::int64_t end) {
                 for (std::int64_t i = begin; i < end; ++i)
                   weight[i] = static_cast<int>(std::min(becomes(mesh, tets[i]), 1.0 * kMostWeight));
               });
  return weight;
}

double SizeField::estimate(const TetMesh& mesh) const {
  return parallel_reduce(
      mesh.T.rows(), kMediumGrain, 0.0,
      [&](std::int64_t begin, std::int64_t end) {
        double sum = 0;
        for (Index t = static_cast<Index>(begin); t < end; ++t) sum += becomes(mesh, t);
        return sum;
      },
      std::plus<>());
}

std::int64_t make_small(LocalOperations& work, LocalOperations::Splits splits, std::int64_t most_tets,
                        const RunContext& context) {
  const TetComplex& mesh = work.mesh();
  std::vector<char> hopeless(mesh.tet_capacity(), 0);  // tried in vain
  std::int64_t all = 0;
  for (int pass = 0; pass < kMostRounds; ++pass) {
    const std::vector<BadTet> large = bad_tets(mesh, [&](Index t) -> std::optional<double> {
      if (hopeless[t]) return std::nullopt;
      const double factor = work.excess(t).factor;
      return factor > 1 ? std::optional(-factor) : std::nullopt;
    });
    const Insertions done = insert_at(work, large, hopeless, most_tets, context,
                                      [&](Index t) { return work.make_smaller(t, splits); });
    all += done.count;
    if (done.stopped || done.count == 0) break;
  }
  return all;
}

}  // namespace overtet
