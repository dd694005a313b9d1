// Tets as small as they are asked to be: the sizes at all vertices of a mesh, and the vertices that are
// inserted until every tet is small enough.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "overtet/run_context.h"
#include "src/improve/improve.h"
#include "src/mesh/local_operations.h"
#include "src/mesh/partition.h"
#include "src/mesh/size_limit.h"

namespace overtet {

// The sizes of a mesh's vertices, kept while its parts are worked on.
class SizeField {
 public:
  // From the surface inwards along the mesh's edges. pre: options.any().
  SizeField(const TetMesh& mesh, const SizeOptions& options);
  // The same again, after the mesh's vertices have been numbered anew.
  void spread(const TetMesh& mesh, const SizeOptions& options);

  SizeLimit of_part(const MeshPart& part) const;
  // After put_parts(), with what it returned. sizes: of each part's vertices.
  void take(std::span<const Index> number, const std::vector<MeshPart>& parts,
            const std::vector<std::vector<LocalSize>>& sizes);

  // Tets that are too large, ascending.
  std::vector<Index> too_large(const TetMesh& mesh) const;
  // Edges of the boundary that are longer than asked.
  std::int64_t fixed_too_long(const TetMesh& mesh) const;
  // About how many tets each of these has to become, at least one.
  std::vector<int> weights(const TetMesh& mesh, std::span<const Index> tets) const;
  double estimate(const TetMesh& mesh) const;  // the same for all together

 private:
  double becomes(const TetMesh& mesh, Index t) const;

  SizeLimit limit_;
  std::vector<std::array<Index, 2>> boundary_;  // its edges
};

// Inserts vertices until no tet of the complex is too large (LocalOperations::make_smaller), the largest
// first, or the mesh has `most_tets`. Stops early when `context` says so. Returns how many. pre: sizes are
// limited.
std::int64_t make_small(LocalOperations& work, LocalOperations::Splits splits, std::int64_t most_tets,
                        const RunContext& context);

}  // namespace overtet
