// What can be chosen in this room, with units and reasons; OpeningOptions has what its users may choose.
#pragma once

namespace overtet {

// Of what is wanted: tets worse than that leave no room for others to get worse.
constexpr double kRoomAbove = 1.5;

}  // namespace overtet
