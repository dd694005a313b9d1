// What can be chosen in this room, with units and reasons; OpeningOptions has what its users may choose.
#pragma once

namespace overtet {

// Vertices are inserted and removed only where the least quality is more than this part of what is wanted:
// before that it is larger balls that help, for a tenth of the time.
constexpr double kNearTarget = 0.3;

// What is left of the largest move, at first, when moves are cut back; where it is nearer to 1 than the second,
// that is not worth another try.
constexpr double kFirstCut = 0.6, kLastCut = 0.93;
// Of the way home, tried in turn.
constexpr double kPartsOfWayHome[] = {1, 0.5, 0.25, 0.1};
// Of the sum of distances: a sweep that leaves more is the last.
constexpr double kHomeGain = 0.98;
// Of the target: tets worse than that leave no room for others to get worse on the way home.
constexpr double kRoomAbove = 1.5;

}  // namespace overtet
