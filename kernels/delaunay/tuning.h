// What can be chosen in this room, with units and reasons.
#pragma once

namespace overtet {

// Faces that are looked at while a small polyhedron is filled with tets: what is found at all is mostly found
// before.
constexpr int kFillSteps = 300;

}  // namespace overtet
