// Small closed surfaces for the tests of the flows: with known intersections, or known to have none.
#pragma once

#include <cstdint>
#include <functional>

#include "overtet/types.h"

namespace overtet::test {

// A sphere of 20 * 4^levels faces, radius 1.
Surface icosphere(int levels);

// A closed tube of the given radius around the curve centre(t), t in [0, 1], with rounded ends:
// `rings` rings of `sides` vertices and a pole at both ends.
Surface tube(const std::function<Eigen::Vector3d(double)>& centre, double radius, int rings, int sides);

// A tube bent in a planar arc of `degrees` around radius `bend`. From about 380 degrees on its ends pass
// through each other; below 300 degrees it is embedded (radius well below bend).
Surface bent_capsule(double degrees, double bend = 1.0, double radius = 0.3, int rings = 60, int sides = 20);

// A straight capsule whose vertices are moved by at most `amplitude` (uniform, seeded).
Surface bumpy_capsule(double amplitude, std::uint32_t seed);

}  // namespace overtet::test
