// What can be chosen in this room, with units and reasons; ForwardFlowOptions has what its users may choose.
#pragma once

namespace overtet {

// Between two full tests for intersections at most this many steps look only at the pairs known before.
constexpr int kFullTestEvery = 4;

}  // namespace overtet
