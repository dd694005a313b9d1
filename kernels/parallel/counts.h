// What the hot loops of this process have done so far, for reports: the difference before and after a stage
// says how much work it was. The same on any number of threads, as the work is.
#pragma once

#include <cstdint>

namespace overtet {

enum class Count {
  exact_evaluations,  // predicates that floating-point filters could not decide
  tested_pairs,       // of faces, with exact predicates
  contacts,           // found by the contact search
  factorisations,     // sparse Cholesky
  factor_nonzeros,    // entries of these factors, summed
  touched_tets,       // looked at or made by passes over tet meshes, each as often as it was
  copied_bytes,       // of tet meshes that were taken apart and put together
  end                 // how many there are
};

// Costs a nanosecond or two; every thread has its own counters.
void count(Count what, std::int64_t n = 1);

// Sum over all threads. Exact for work that has ended before the call.
std::int64_t counted(Count what);

}  // namespace overtet
