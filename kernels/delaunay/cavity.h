// Small polyhedra filled with tets.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "overtet/types.h"

namespace overtet {

// True when a tet and a triangle have nothing in common but corners with the same number, and the edge
// between two such corners. Exact where it says so; false also for some touching pairs that have no more than
// that in common but lie in special position. pre: the tet is positive, the triangle has an area and is none
// of its faces.
// tet, triangle: numbers; points: three doubles each, by number.
bool apart(const double* points, const std::array<Index, 4>& tet, const std::array<Index, 3>& triangle);

// Fills a small polyhedron with tets on its own corners ("small polyhedron reconnection"), by backtracking.
class CavityFiller {
 public:
  using Face = std::array<Index, 3>;
  using Tet = std::array<Index, 4>;

  // faces: what the tets must have beside them, turned so that a tet (a, b, c, inside) is positive: the faces
  // of the polyhedron and, in both directions, those that it must have inside.
  // points: three doubles each, by number. steps: how many tets may be tried.
  //
  // True: out has exactly positive tets that fill the polyhedron once and have all the faces. (Positive tets
  // whose boundary is that of the polyhedron cover each point of it once.)
  bool fill(const double* points, const std::vector<Face>& faces, int steps, std::vector<Tet>& out);

 private:
  struct Candidate {
    double quality;
    Index corner;
  };
  bool search(std::size_t depth);

  const double* points_ = nullptr;
  int steps_ = 0;
  std::vector<Index> corners_;
  std::vector<std::vector<Face>> open_;  // by depth
  std::vector<std::vector<Candidate>> candidates_;
  std::vector<Tet> tets_;
};

}  // namespace overtet
