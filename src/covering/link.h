// Private to the .cpp files of this room: whether positive tets can fill what is around a vertex at all.
//
// The tets at p meet a tiny sphere around p in spherical triangles, all turning the same way, and together
// these make a disc whose boundary is p's link polygon. (Interior vertices of the disc are interior edges of
// the mesh at p, with one turn each, so the disc lies on the sphere without branch points.) Over a piece of
// the sphere where the winding number just outside of p is w the disc has w - c layers, with c layers of the
// solid that pass over p without touching it. So disc and passing layers together are w copies of every piece
// into which the polygon cuts the sphere, glued along its arcs, w outside to w of the w + 1 inside, such that
// around every crossing a copy closes after one turn, or begins and ends at the same strand. At corner e the
// disc turns k_e times more than the surface shows, which is less than or equal to the outer winding number
// all along e. And it is a disc: 2 c + sum k_e = B0, with c the number of closed parts. All gluings are
// tried; if there is none, no positive mesh exists. It is Blank's question about curves in the plane (see
// Poenaru 1968; Shor and Van Wyk 1992), asked on the sphere.
#pragma once

#include <cstdint>
#include <vector>

#include "src/covering/hinges.h"
#include "src/mesh/topology.h"

namespace overtet {

enum class LinkVerdict { filled, unfillable, undecided };

struct LinkAnswer {
  LinkVerdict verdict = LinkVerdict::undecided;
  std::int64_t steps = 0;  // of the search
};

// near, least: the winding number on the outer side of each edge next to the hinge, and its minimum all along
// the edge, in the order of half_edges_around. Undecided where arcs touch or overlap, where three arcs meet
// in a point, and where the search is too large.
LinkAnswer fill_link(const Surface& surface, const SurfaceTopology& topology, const Hinge& hinge,
                     const std::vector<int>& near, const std::vector<int>& least);

// Whether arcs of a vertex's link only cross each other, two at a time; crossings: of faces at the vertex.
bool has_regular_link(const Surface& surface, const SurfaceTopology& topology, Index vertex,
                      const std::vector<FacePair>& crossings);

}  // namespace overtet
