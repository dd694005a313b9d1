// For .cpp files only: where a line goes through a plane, both given by doubles.
#pragma once

#include "src/exact/rational.h"

namespace overtet::exact {

// The point in which the line through p and q meets the plane of a, b and c: three doubles each. In integers,
// as multiples of a power of two, with one division at the end. pre: there is one such point.
Vec piercing(const double* p, const double* q, const double* a, const double* b, const double* c);

}  // namespace overtet::exact
