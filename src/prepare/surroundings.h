// The faces around a place, as a surface of their own.
#pragma once

#include <array>
#include <vector>

#include "src/prepare/working_surface.h"

namespace overtet {

struct Surroundings {
  Surface surface;
  std::vector<Index> vertex, face;  // the whole surface's number of each; vertices ascending

  Index local_vertex(Index v) const;  // pre: it is there
};

// In the order given. Unlike sub_surface() (src/mesh/submesh.h), at no cost of the whole: there are many
// places.
Surroundings of_faces(const Surface& whole, std::vector<Index> faces);

// The faces that have one of the vertices, ascending, and those of their vertices, and so on: `rings` times.
std::vector<Index> faces_around(const Surface& whole, const Incidence& incidence, std::vector<Index> vertices,
                                int rings);

}  // namespace overtet
