// The ways of meshing one surface, as values. A new one is one more entry in the list of strategies.cpp.
#pragma once

#include <span>

#include "overtet/result.h"
#include "src/pipeline/draft.h"
#include "src/pipeline/meshing_job.h"

namespace overtet {

struct Strategy {
  // What a failure says about the surface.
  enum class Failure {
    of_a_part,   // one part has no mesh by itself; the whole is still to be tried
    of_gluing,   // the error's place, if it has one, is where the sheets could not be glued
    of_this_way  // nothing more than its message
  };

  const char* name;  // in messages: "Route NAME: ..."
  bool (*applies)(const MeshingJob& job);
  // A positive tet mesh in the unit box, not yet checked against the surface. Errors have their place in the
  // input's space.
  Result<Draft> (*run)(const MeshingJob& job);
  Failure failure;
};

// In the order in which they are tried, until one leads to a mesh that passes the check.
std::span<const Strategy> strategies();

}  // namespace overtet
