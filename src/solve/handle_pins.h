// Where handles hold a mesh. Internal to src/solve.
#pragma once

#include <vector>

#include "overtet/weights.h"

namespace overtet::solve_detail {

// Of one vertex: the handles that hold it, and the weight that each has there. They sum to 1.
struct Pin {
  Index vertex = 0;
  std::vector<std::pair<int, double>> weights;  // by handle
  bool shared = false;                          // by points or bones
};

struct HandlePins {
  std::vector<Pin> pins;       // by vertex
  std::vector<double> cut_at;  // of each handle, see HandleWeights
};

// pre: the handles are valid, every tet is positive. Errors: usage, bad_input (see skinning_weights()).
Result<HandlePins> handle_pins(const TetMesh& mesh, const Handles& handles, const WeightOptions& options);

}  // namespace overtet::solve_detail
