// Faces that lie on each other, in an order that nobody has said.
//
// A positive mesh stays positive when its vertices move by little enough, whatever the moves. So a surface
// that has a mesh still has one after every small enough move of its vertices, and its winding number is
// nowhere negative then, either. Where coplanar faces lie on each other, such moves put them into another
// order: at a point q inside some faces, vertices that move by m_v times eps along a normal n take a face
// with q = sum b_k p_k across the line q + s n at s = eps * sum b_k m_k, exactly. If the winding number is
// negative somewhere between the faces in that order, no mesh exists. A fold pressed flat onto its own
// surface is the usual case.
#pragma once

#include <optional>
#include <vector>

#include "kernels/bvh/self_intersections.h"
#include "overtet/certificate.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

// Looks at one or a few points of every pair of coplanar faces that overlap; none found is no proof.
// pairs: all intersecting pairs of the surface, sorted.
// pre: every face has an area. Errors: limit or interrupted only.
Result<std::optional<StackCertificate>> find_stack_certificate(const Surface& surface, const TriangleBvh& bvh,
                                                               const std::vector<FacePair>& pairs,
                                                               const RunContext& context);

}  // namespace overtet
