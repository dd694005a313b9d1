// What can be chosen in this room, with units and reasons; ReverseFlowOptions has what its users may choose.
#pragma once

namespace overtet {

// A contact's distance over its reach is not taken below this: the barrier's curvature grows as 1/x^2, and
// beyond 1e9 times the surface's own stiffness the factor loses what it knows about the surface.
constexpr double kSmallestRelativeDistance = 1e-4;
// Of the mean edge of all: no vertex has a smaller one. Collapsed rest states must not switch the barrier
// off.
constexpr double kEdgeFloor = 1e-4;
// A matrix that rounding has made indefinite gets this much more mass, so many times in turn.
constexpr double kMoreMass = 1e3;
constexpr int kMoreMassTries = 4;
// Steps in a row in which nothing moved at all: the stage has locked and will not come free.
constexpr int kStandstill = 3;
// A step is scaled down at offenders between these two factors.
constexpr double kLeastRamp = 1.0 / 16, kMostRamp = 0.7;
// Solutions of one step with more and more pinned vertices, before it is given up.
constexpr int kPinRounds = 30;

}  // namespace overtet
