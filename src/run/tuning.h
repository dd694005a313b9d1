// What can be chosen in this room, with units and reasons.
#pragma once

#include <chrono>

namespace overtet {

// Between two looks at the memory in use and the time.
constexpr auto kMonitorPeriod = std::chrono::milliseconds(25);

}  // namespace overtet
