// Cuts a tet mesh into parts that are changed independently of each other, and puts them together again.
//
// Why that is safe: a part is a TetComplex of its own, and what it shares with the rest of the mesh lies on
// its boundary, which LocalOperations leave as it is. Vertices in several parts are marked as shared, so that
// no two parts make the same edge or face (LocalOperations::share). So the whole is a mesh with the same
// boundary and one turn around every interior edge whenever that holds for the parts.
//
// The cut depends on the mesh and the number of parts only, the order of the result on the order of the
// parts only: the same bytes on any number of threads.
#pragma once

#include <span>
#include <vector>

#include "overtet/types.h"
#include "src/mesh/local_operations.h"
#include "src/mesh/tet_complex.h"

namespace overtet {

struct MeshPart {
  TetComplex complex;          // numbered so that what is near in space is near in memory
  std::vector<Index> vertex;   // the mesh's vertex of each of the complex's first vertices
  std::vector<Index> shared;   // of the complex: vertices with tets outside this part
  std::vector<Index> pinched;  // of those: where the part's tets around the vertex, or around one of its
                               // edges, hang together through others only

  // Tells the operations on `complex` what is shared.
  void mark_shared(LocalOperations& work) const;
};

// Numbers 0 .. parts - 1 for the `chosen` tets (others get -1) by planes across an axis, again and again,
// each where it meets little weight and leaves on both sides what the numbers of parts ask for, or up to
// `slack` (of the whole that it cuts) more or less. weight: of each chosen tet, > 0; empty: all the same.
std::vector<int> cut_apart(const TetMesh& mesh, std::span<const Index> chosen, int parts, double slack,
                           std::span<const int> weight = {});

// Pieces of the chosen tets that share no vertex, numbered 0 .. count - 1 in the order of their first tets;
// -1 for other tets.
std::vector<int> connected_pieces(const TetMesh& mesh, std::span<const char> chosen, int& count);

// Whole pieces, without any cut: tets with a common vertex are in the same part; otherwise the weights are as
// equal as they can be made.
struct Pieces {
  std::vector<int> part_of;
  double uneven = 1;  // the heaviest part over the mean of all
};
Pieces in_pieces(const TetMesh& mesh, std::span<const Index> chosen, int parts, std::span<const int> weight);

// One part for each number that occurs; tets with -1 are in none.
std::vector<MeshPart> take_parts(const TetMesh& mesh, std::span<const int> part_of, int parts);

// The same for some tets of a complex: the part numbers its vertices in the order in which `tets` meet them.
// What is shared is so with the rest of this complex. Linear in the stars of the part's vertices.
MeshPart take_part(const TetComplex& mesh, std::span<const Index> tets);

// Puts such a part back in the place of its tets; `created` becomes the numbers of its tets there, in the
// order of the part's. Vertices keep their numbers, new ones come last. Linear in the part.
void put_part(TetComplex& mesh, std::span<const Index> tets, const MeshPart& part,
              std::vector<Index>& created);

// The mesh with its parts as they are now. Tets outside the parts come first, in their order, then the
// parts'. Vertices keep their order; unused ones that are not the surface's are dropped, new ones come last.
// Returns the new number of each old vertex (-1: dropped).
std::vector<Index> put_parts(TetMesh& mesh, std::span<const int> part_of, const std::vector<MeshPart>& parts);

}  // namespace overtet
