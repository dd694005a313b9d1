// Where the solid is thin: two parts of the surface that face away from each other, with the inside between
// them, near each other. Rays go inwards from every face's centroid and every vertex, against the normal, as
// for the shape diameter [Shapira, Shamir, Cohen-Or 2008]; they end at the first face they meet, those that
// share a vertex with where they begin left out. Where faces cross, what is between them is no wall: faces
// that are in `crossing` are left out.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/bvh/bvh.h"
#include "overtet/diagnosis.h"
#include "overtet/types.h"

namespace overtet {

// Spots thinner than `limit`, a length; the thinnest first. Faces that have a vertex in common, and faces
// across from each other, are one spot. In doubles: it decides nothing. O(#F log #F) where faces are not much
// smaller than `limit`. pre: bvh is of the surface, which is closed and oriented; crossing: a flag for
// each face.
std::vector<ThinSpot> find_thin_spots(const Surface& surface, const TriangleBvh& bvh, double limit,
                                      const std::vector<std::uint8_t>& crossing);

}  // namespace overtet
