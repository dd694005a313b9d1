// What can be chosen in this room, with units and reasons.
#pragma once

#include <cstdint>

namespace overtet {

constexpr std::int64_t kElementGrain = 1024;  // tets or nodes a block: some tenths of a millisecond of work

}  // namespace overtet
