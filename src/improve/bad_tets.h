// How bad tets are, and those that a pass works on, the worst one first.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "kernels/tet_energy/tet_quality.h"
#include "overtet/types.h"
#include "src/mesh/tet_complex.h"

namespace overtet {

struct BadTet {
  double rank;  // smaller is worse
  Index tet;
  TetComplex::Tet corners;

  // Numbers are reused: is it still the tet that was meant?
  bool still_in(const TetComplex& mesh) const { return mesh.alive(tet) && mesh.tet(tet) == corners; }
};

inline double quality(const TetMesh& mesh, Index t) {
  return min_dihedral_sine(mesh.V.row(mesh.T(t, 0)), mesh.V.row(mesh.T(t, 1)), mesh.V.row(mesh.T(t, 2)),
                           mesh.V.row(mesh.T(t, 3)));
}

// rank(t): a std::optional<double>, nothing for tets that are good enough.
template <class Rank>
std::vector<BadTet> bad_tets(const TetComplex& mesh, Rank&& rank) {
  std::vector<BadTet> bad;
  for (Index t = 0; t < mesh.tet_capacity(); ++t) {
    if (!mesh.alive(t)) continue;
    if (const std::optional<double> r = rank(t)) bad.push_back({*r, t, mesh.tet(t)});
  }
  std::sort(bad.begin(), bad.end(), [](const BadTet& x, const BadTet& y) {
    return x.rank != y.rank ? x.rank < y.rank : x.tet < y.tet;
  });
  return bad;
}

}  // namespace overtet
