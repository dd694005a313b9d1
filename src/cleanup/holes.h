// Holes: closed chains of edges that have one face only.
#pragma once

#include <vector>

#include "overtet/cleanup.h"
#include "overtet/types.h"
#include "src/cleanup/orienting.h"
#include "src/cleanup/raw_edges.h"

namespace overtet {

// The largest first. Faces in the places are numbers of F; as many vertices and faces as most_listed.
std::vector<DefectPlace> find_holes(const VertexMatrix& V, const TriangleMatrix& F, const RawEdges& edges,
                                    const Oriented& oriented, std::size_t most_listed);

}  // namespace overtet
