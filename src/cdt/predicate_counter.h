// Whether TetGen gets on: its exact predicates, counted. The library calls them through the dynamic linker,
// which finds those of this program first; they count and hand on.
#pragma once

#include <cstdint>

namespace overtet::predicate_watch {

// From now on, ends by way of `give_up`, once the predicates have been called more than `most` times, or not
// at all for `idle_seconds` of CPU time: in a loop without an end, because TetGen does no work that long
// without one. `give_up` may be called from a signal handler, and must not return.
void begin(std::int64_t most, int idle_seconds, void (*give_up)());

// No more of that.
void end();

// Of the predicates so far.
std::int64_t calls();

}  // namespace overtet::predicate_watch
