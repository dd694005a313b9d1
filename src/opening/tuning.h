// What can be chosen in this room, with units and reasons; OpeningOptions has what its users may choose.
#pragma once

namespace overtet {

// Of the target: where the least quality stays below, the surface's vertices at such tets move as well.
constexpr double kAskForHelp = 0.75;
// Times the tets that there were: no more are made by new vertices.
constexpr double kMostTets = 1.5;
// Of one over the sines: so large that the worst ones count, so small that derivatives stay of use. A step
// that leaves more of the sum than the second is not worth another. Of the trace: keeps steps short where
// only few tets say where to go.
constexpr double kSoftPower = 6, kSoftGain = 0.999, kDamping = 1e-3;
// What is left of the largest move, at first, when moves are cut back; where it is nearer to 1 than the
// second, that is not worth another try.
constexpr double kFirstCut = 0.6, kLastCut = 0.93;
// Of the way home, tried in turn.
constexpr double kPartsOfWayHome[] = {1, 0.5, 0.25, 0.1};
// Of the sum of distances: a sweep that leaves more is the last.
constexpr double kHomeGain = 0.98;
// Of the target: tets worse than that leave no room for others to get worse on the way home.
constexpr double kRoomAbove = 1.5;

}  // namespace overtet
