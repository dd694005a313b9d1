// Formulas of a place, as the user types them: "1 + x*y", "sin(_pi*z)".
#pragma once

#include <string>

#include "overtet/elastic.h"
#include "overtet/result.h"
#include "overtet/solve.h"

namespace overtet {

// What a text file holds. Errors: io.
Result<std::string> text_of(const std::string& path);

// Of x, y and z, in muParser's notation; what begins with @ names a file that holds the formula. Errors:
// usage (the message names the place in the formula), io.
Result<ScalarFunction> function_of(const std::string& formula);

// Three formulas of x, y, z and the time t, with semicolons between them: "0; 0; 0.1*t"; or @FILE. Errors: as
// function_of().
Result<VectorFunction> vector_function_of(const std::string& formulas);

}  // namespace overtet
