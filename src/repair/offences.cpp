#include "src/repair/offences.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "kernels/core/tuning.h"
#include "src/exact/winding.h"
#include "src/mesh/flat_faces.h"
#include "src/repair/tuning.h"

namespace overtet {

namespace {

// All vertices around `seed` in front of which the winding number is negative: the part that pokes out.
Offence flooded(const Surface& now, const Diagnosis& diagnosis, const VertexRings& rings, double diagonal,
                const Offence& seed) {
  const WindingNumber winding(now, *diagnosis.bvh);
  std::vector<char> seen(now.V.rows(), 0);
  Offence all = seed, queue = seed;
  for (const Index v : seed) seen[v] = 1;
  const double ahead = kRounding * diagonal;
  while (!queue.empty() && all.size() < kMostFlooded) {
    Offence next;
    for (const Index v : queue)
      for (const Index u : rings(v)) {
        if (seen[u]) continue;
        seen[u] = 1;
        Eigen::Vector3d normal = Eigen::Vector3d::Zero();
        for (const Index h : half_edges_around(diagnosis.topology.topology, u)) {
          const Index f = half_edge_face(h);
          const Eigen::Vector3d a = now.V.row(now.F(f, 0)), b = now.V.row(now.F(f, 1)),
                                c = now.V.row(now.F(f, 2));
          normal += (b - a).cross(c - a);
        }
        const double length = normal.norm();
        if (!(length > 0)) continue;
        const Eigen::Vector3d p = now.V.row(u).transpose() + ahead / length * normal;
        const auto w = winding.at(p.data());
        if (w && *w < 0) next.push_back(u);
      }
    all.insert(all.end(), next.begin(), next.end());
    queue = std::move(next);
  }
  return all;
}

}  // namespace

Result<Findings> offences_of(const Surface& surface, Diagnosis known, const VertexRings& rings,
                             double diagonal, PokingOut poking_out) {
  Findings found;
  std::vector<Offence>& offences = found.offences;
  const auto corners = [&](Index f) { return Offence{surface.F(f, 0), surface.F(f, 1), surface.F(f, 2)}; };
  const Eigen::RowVector3d centre = (surface.V.colwise().minCoeff() + surface.V.colwise().maxCoeff()) / 2;
  for (const Index f : flat_faces(surface, kRoundedLength, centre.cwiseAbs().maxCoeff()))
    offences.push_back(corners(f));
  found.diagnosis = std::move(known);
  const Diagnosis& diagnosis = found.diagnosis;
  if (!diagnosis.topology.ok()) return Error{ErrorCode::bad_input, diagnosis.message};
  for (const Index f : diagnosis.degenerate_faces) offences.push_back(corners(f));
  const std::size_t without_area = offences.size();
  for (const auto& [f, g] : diagnosis.winding.negative_at) {
    if (f < 0) {
      found.hopeless = found.hopeless || diagnosis.winding.negative_pairs == 0;
      continue;
    }
    Offence o = corners(f), more = corners(g);
    o.insert(o.end(), more.begin(), more.end());
    offences.push_back(o);
  }
  if (poking_out == PokingOut::all && diagnosis.winding.negative_pairs > 0) {
    Offence all;
    for (const auto& [f, g] : diagnosis.winding.negative_at)
      if (f >= 0) {
        const Offence a = corners(f), b = corners(g);
        all.insert(all.end(), a.begin(), a.end());
        all.insert(all.end(), b.begin(), b.end());
      }
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    const std::size_t known = all.size();
    all = flooded(surface, diagnosis, rings, diagonal, all);
    for (std::size_t i = known; i < all.size(); ++i) offences.push_back({all[i]});
  }
  for (const Hinge& h : diagnosis.hinges)
    if (h.B0 && *h.B0 < 0) offences.push_back({h.vertex});
  for (const auto& group : diagnosis.wound.odd_groups)
    for (const Index v : group) offences.push_back({v});
  for (const Index v : diagnosis.wound.crowded) offences.push_back({v});
  for (const Index v : diagnosis.wound.unfillable) offences.push_back({v});
  // Otherwise what the certificate names.
  if (offences.size() == without_area && diagnosis.certificate)
    if (Offence named = named_vertices(*diagnosis.certificate); !named.empty()) offences.push_back(named);
  for (Offence& o : offences) {
    std::sort(o.begin(), o.end());
    o.erase(std::unique(o.begin(), o.end()), o.end());
  }
  return found;
}

Result<Findings> find_offences(const Surface& surface, const VertexRings& rings, double diagonal,
                               PokingOut poking_out, const RunContext& context) {
  if (auto stop = context.stop()) return *stop;
  RunContext silent = context;
  silent.progress = nullptr;
  Result<Diagnosis> d = diagnose(surface, {}, silent);
  if (!d) return d.error();
  return offences_of(surface, std::move(d).value(), rings, diagonal, poking_out);
}

bool sorted_share(const std::vector<Index>& a, const std::vector<Index>& b) {
  auto i = a.begin();
  auto j = b.begin();
  while (i != a.end() && j != b.end()) {
    if (*i == *j) return true;
    *i < *j ? ++i : ++j;
  }
  return false;
}

}  // namespace overtet
