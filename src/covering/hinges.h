// Hinges: vertices whose one-ring passes through itself, and the integers that decide what a positive
// tet mesh must do there.
//
// Theory. At a vertex p the faces' directions draw a closed polygon on the sphere (the link); a vertex is
// a hinge when that polygon crosses itself, which is when two of its faces intersect beyond p. With
// theta_i the interior dihedral at p's edges and A(p) the winding number integrated over a tiny sphere,
// Gauss-Bonnet says that
//
//     B0(p) = (A(p) + sum_i (pi - theta_i)) / 2 pi - 1
//
// is an integer, and that every positive tet mesh satisfies B0(p) = 2 c_p + sum_e k_e over p's edges:
// c_p >= 0 layers cover p without touching it, and the tets at edge e make theta_e + 2 pi k_e, k_e >= 0,
// all along e. So B0 < 0 proves that there is none. Along an edge e the outer side's winding number m_e is
// the capacity: k_e <= m_e everywhere on e, and k_e <= m_e - c_p near p.
//
// How it is computed: exactly, without any angle. The field of meridians towards a direction d (from -d)
// turns along with the polygon; R counts how often the polygon's direction turns past it, to the left, where
// the outside is. An arc runs on one side of the meridians, so R changes at corners only, and signs of
// determinants tell. By Gauss, Bonnet, Poincare and Hopf, with w the winding number just ahead of p,
//
//     B0(p) = w(d) + w(-d) - R - 1.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "kernels/bvh/self_intersections.h"
#include "overtet/types.h"
#include "src/mesh/topology.h"

namespace overtet {

struct Hinge {
  Index vertex = -1;
  // The integer of the theory, exact; none where it is not defined: a face of another part of the surface
  // contains the vertex. A fold (two faces flat on each other at their edge) counts as 2 pi: 0 has no mesh.
  std::optional<int> B0;
  // How far the dihedral nearest to a fold is from 0 or 2 pi, in radians; 0 for a fold. Below about 1e-9 a
  // checker that computes B0 from rounded angles cannot tell the two apart and may come out wrong by one.
  double opening = 0;
  // The largest possible c_p: the smallest winding number around p. Negative where the winding is.
  int covering = 0;
  std::vector<FacePair> crossings;  // faces at the vertex that intersect beyond it, or are folded at an edge
};

// The pairs' hinges by vertex number, with their integers. pairs: all intersecting pairs of the surface.
std::vector<Hinge> find_hinges(const Surface& surface, const SurfaceTopology& topology,
                               const TriangleBvh& bvh, const std::vector<FacePair>& pairs);

// B0 of any vertex (0 for an embedded one that nothing covers).
std::optional<int> vertex_b0(const Surface& surface, const SurfaceTopology& topology, const TriangleBvh& bvh,
                             Index vertex);

// The smallest winding number around a vertex. crossings: of faces at it. None where a face that is not at
// the vertex contains it.
std::optional<int> smallest_winding(const Surface& surface, const SurfaceTopology& topology,
                                    const TriangleBvh& bvh, Index vertex,
                                    const std::vector<FacePair>& crossings);

}  // namespace overtet
