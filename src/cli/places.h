// Parts of a tet mesh as the user names them, WHERE: all (of the boundary), label:NUMBER, label:NAME,
// vertices:N,N,... (counted from 0) or vertices:@FILE. And what holds there, WHERE=FORMULA.
#pragma once

#include <string>
#include <vector>

#include "overtet/attributes.h"
#include "overtet/elastic.h"
#include "overtet/result.h"
#include "overtet/solve.h"

namespace overtet {

// A condition without a function. Errors: usage (words that are no place, a name that no label has), io.
Result<BoundaryValue> place_in(const std::string& text, const LabelledTetMesh& mesh);

// WHERE=FORMULA, in their order. Errors: as place_in() and function_of().
Result<std::vector<BoundaryValue>> conditions_in(const std::vector<std::string>& words,
                                                 const LabelledTetMesh& mesh);

// WHERE=FORMULA;FORMULA;FORMULA, in their order. Errors: as place_in() and vector_function_of().
Result<std::vector<ElasticCondition>> vector_conditions_in(const std::vector<std::string>& words,
                                                           const LabelledTetMesh& mesh);

// All vertices of these places. Errors: as place_in(); usage, where no triangle is in one.
Result<std::vector<Index>> vertices_of(const std::vector<std::string>& words, const LabelledTetMesh& mesh);

}  // namespace overtet
