// What acts on an elastic body from outside: where it is held, and the forces. Internal to src/solve.
#pragma once

#include <vector>

#include "overtet/elastic.h"

namespace overtet::solve_detail {

// The mesh and the options must outlive it.
class ElasticLoads {
 public:
  // Errors: usage, as Elastic::prepare().
  static Result<ElasticLoads> prepare(const LabelledTetMesh& mesh, const ElasticOptions& options);

  bool is_held(Index v) const { return held_[static_cast<std::size_t>(v)] >= 0; }
  // Where held vertices are to be at this time; the rows of others are as in the mesh. Errors: bad_input.
  Result<VertexMatrix> targets(double time) const;
  // Without gravity's. Errors: bad_input.
  Result<VertexMatrix> forces(double time) const;

 private:
  ElasticLoads(const LabelledTetMesh& mesh, const ElasticOptions& options, const VertexMatrix& rest)
      : mesh_(&mesh), options_(&options), rest_(&rest) {}
  Status find_held();
  Status add_traction(const ElasticCondition& traction, double time, VertexMatrix& to) const;

  const LabelledTetMesh* mesh_;
  const ElasticOptions* options_;
  const VertexMatrix* rest_;
  std::vector<int> held_;  // of each vertex the number of its condition; -1: free
};

}  // namespace overtet::solve_detail
