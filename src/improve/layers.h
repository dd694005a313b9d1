// The tets around some vertices, layer by layer.
#pragma once

#include <span>
#include <vector>

#include "overtet/types.h"

namespace overtet {

// Of each vertex, how many tets it has.
std::vector<int> star_sizes(const TetMesh& mesh);

// Of each tet, 1 for those within so many layers around the vertices with near[v] != 0: first those at them,
// then those at the corners of these, and so on; vertices with more than kLargestStar tets spread no further
// layer. Passes over the mesh, two a layer.
std::vector<char> within_layers(const TetMesh& mesh, std::span<const int> star, std::vector<char> near,
                                int layers);

// Several threads may mark the same vertex.
void mark(char& c);

}  // namespace overtet
