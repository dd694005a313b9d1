#include "src/cdt/split_edges.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "kernels/bvh/self_intersections.h"
#include "kernels/delaunay/delaunay.h"
#include "src/cdt/delaunay_match.h"

namespace overtet {

namespace {

using Edge = std::pair<Index, Index>;

Edge edge(Index a, Index b) { return {std::min(a, b), std::max(a, b)}; }

void sort_and_unite(std::vector<Edge>& edges) {
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
}

// The edges of facets that are no edges of the Delaunay tets; empty also when told to stop.
std::vector<Edge> missing_edges(const Plc& plc, const RunContext& context) {
  const TetArrays all =
      delaunay(plc.V.data(), static_cast<Index>(plc.V.rows()), [&] { return context.stop().has_value(); });
  if (all.tet.empty()) return {};
  std::vector<Edge> there, wanted, missing;
  for (const Tet& t : all.tet)
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < i; ++j) there.push_back(edge(t[i], t[j]));
  for (Eigen::Index f = 0; f < plc.F.rows(); ++f)
    for (int k = 0; k < 3; ++k) wanted.push_back(edge(plc.F(f, k), plc.F(f, (k + 1) % 3)));
  sort_and_unite(there);
  sort_and_unite(wanted);
  std::set_difference(wanted.begin(), wanted.end(), there.begin(), there.end(), std::back_inserter(missing));
  return missing;
}

// The parts of a facet with corners p, of which the edge from p[k] to p[k + 1] has the middle m[k], or -1.
void cut(const VertexMatrix& V, const Triple& p, const Triple& m, std::vector<Triple>& out) {
  const auto cuts = std::count_if(m.begin(), m.end(), [](Index i) { return i >= 0; });
  if (cuts == 0) out.push_back(p);
  if (cuts == 3) {
    for (int k = 0; k < 3; ++k) out.push_back({p[k], m[k], m[(k + 2) % 3]});
    out.push_back(m);
  }
  for (int k = 0; k < 3; ++k) {
    const Index a = p[k], b = p[(k + 1) % 3], c = p[(k + 2) % 3], bc = m[(k + 1) % 3], ca = m[(k + 2) % 3];
    if (cuts == 1 && m[k] >= 0) {
      out.push_back({a, m[k], c});
      out.push_back({m[k], b, c});
    }
    if (cuts == 2 && m[k] < 0) {
      out.push_back({c, ca, bc});
      if ((V.row(a) - V.row(bc)).squaredNorm() < (V.row(b) - V.row(ca)).squaredNorm()) {
        out.push_back({a, b, bc});
        out.push_back({a, bc, ca});
      } else {
        out.push_back({a, b, ca});
        out.push_back({b, bc, ca});
      }
    }
  }
}

}  // namespace

std::optional<SplitPlc> split_missing_edges(const Plc& plc, const RunContext& context) {
  const std::vector<Edge> missing = missing_edges(plc, context);
  if (missing.empty()) return std::nullopt;
  const Index n = static_cast<Index>(plc.V.rows());
  SplitPlc out;
  Plc& split = out.plc;
  split.holes = plc.holes;
  split.V.resize(n + static_cast<Eigen::Index>(missing.size()), 3);
  split.V.topRows(n) = plc.V;
  for (std::size_t i = 0; i < missing.size(); ++i)
    split.V.row(n + static_cast<Eigen::Index>(i)) =
        0.5 * (plc.V.row(missing[i].first) + plc.V.row(missing[i].second));
  std::vector<Triple> parts, facets;
  for (Index f = 0; f < static_cast<Index>(plc.F.rows()); ++f) {
    const Triple p{plc.F(f, 0), plc.F(f, 1), plc.F(f, 2)};
    Triple middle{-1, -1, -1};
    for (int k = 0; k < 3; ++k) {
      const Edge e = edge(p[k], p[(k + 1) % 3]);
      const auto at = std::lower_bound(missing.begin(), missing.end(), e);
      if (at != missing.end() && *at == e) middle[k] = n + static_cast<Index>(at - missing.begin());
    }
    parts.clear();
    cut(split.V, p, middle, parts);
    for (const Triple& part : parts) {
      facets.push_back(part);
      out.source.push_back(f);
      if (!plc.markers.empty()) split.markers.push_back(plc.markers[f]);
    }
  }
  split.F.resize(static_cast<Eigen::Index>(facets.size()), 3);
  for (std::size_t f = 0; f < facets.size(); ++f) split.F.row(f) << facets[f][0], facets[f][1], facets[f][2];
  SelfIntersectionOptions first;
  first.stop_at_first = true;
  if (context.stop() || !find_self_intersections(split.V, split.F, first).empty()) return std::nullopt;
  return out;
}

}  // namespace overtet
