// What can be chosen in this room, with units and reasons; ReverseFlowOptions has what its users may choose.
#pragma once

namespace overtet {

// A contact's distance over its reach is not taken below this: the barrier's curvature grows as 1/x^2, and
// beyond 1e9 times the surface's own stiffness the factor loses what it knows about the surface. Nor is a
// vertex's mean edge, over that of all: collapsed rest states must not switch the barrier off.
constexpr double kSmallestShare = 1e-4;
// A matrix that rounding has made indefinite gets this much more mass, a few times in turn.
constexpr double kMoreMass = 1e3;
// A step is scaled down at offenders between these two factors.
constexpr double kLeastRamp = 1.0 / 16, kMostRamp = 0.7;

}  // namespace overtet
