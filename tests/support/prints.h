// Flat prints: outlines of many corners, extruded, with caps whose triangles are needles, as slicers and CAD
// programs write them.
#pragma once

#include "overtet/types.h"

namespace overtet::test {

enum class Caps { fan, strip, ears };  // from one corner; to and fro across; ears clipped one after the other

// 100 x 60 x height, its corners rounded by 0.5 with so many points each. 16 of these less 4 are all faces.
Surface rounded_plate(int points_a_corner, Caps caps, double height = 2);
// Between circles of radius 50 and 20.
Surface ring_plate(int points_a_circle, double height = 2);
// Radius 45 to 50, 20 teeth.
Surface gear_plate(int points, Caps caps = Caps::ears, double height = 2);

}  // namespace overtet::test
