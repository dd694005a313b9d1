// Surfaces with all that the intersection graph is made from.
#pragma once

#include <utility>
#include <vector>

#include "kernels/bvh/self_intersections.h"
#include "src/arrangement/intersection_graph.h"
#include "tests/support/models.h"

namespace overtet::test {

struct Studied {
  Surface surface;
  SurfaceTopology topology;
  TriangleBvh bvh;
  std::vector<FacePair> pairs;
  exact::Rays rays;
  IntersectionGraph graph;
  explicit Studied(Surface s)
      : surface(std::move(s)),
        topology(require_topology(surface).value()),
        bvh(surface.V, surface.F),
        pairs(find_self_intersections(surface.V, surface.F)),
        rays(surface.V, surface.F, bvh),
        graph(surface, topology, bvh, pairs) {}
};

// Three spheres that cross each other: third faces cut their curves.
inline Surface three_spheres(int subdivisions) {
  const Surface one = sphere(subdivisions);
  return joined(joined(one, shifted(one, 0.73, 0.11, 0.07)), shifted(one, 0.31, 0.67, 0.13));
}

}  // namespace overtet::test
