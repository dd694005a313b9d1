// What can be chosen in this room, with units and reasons; OpeningOptions has what its users may choose.
#pragma once

namespace overtet {

// What is left of the largest move, at first, when moves are cut back.
constexpr double kFirstCut = 0.6;
// Of what is wanted: tets worse than that leave no room for others to get worse.
constexpr double kRoomAbove = 1.5;

}  // namespace overtet
