// Is a tet mesh what Overtet promises for a surface? Decided exactly, on the doubles given.
//
// Checked (Sacht et al. 2013, section 3, equations 1 to 3, made exact):
//
//   R1  every coordinate is finite, every index in range, every vertex used
//   R2  vertex i of the tet mesh is vertex i of the surface, unmoved
//   R3  the faces that belong to one tet only are the surface's faces, with its orientation
//   R4  every tet is positive
//   R5  every other face is shared by exactly two tets from opposite sides, and the tets around every
//       vertex form one ball (interior) or one half ball (boundary): a 3-manifold with boundary
//   R6  the tets around every interior edge make exactly one turn. Around edges of the surface more is
//       allowed (the paper's hinges). With allow_branches more is allowed inside, too: such edges are
//       branch lines.
//
// attributes.h has a seventh, about files: R7, the triangles and labels in them are the surface's.
//
// R6 needs no angles: in a ring of positive tets around an edge the number of turns is the number of tets
// whose wedge contains a fixed direction, which two exact orientations per tet decide.
//
// Time and memory are linear in the size of the mesh up to sorting within the star of a vertex. The
// result does not depend on the number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

struct VerifyOptions {
  // Compare coordinates instead of vertex numbers in R2 and R3: for surfaces that carry no vertex order.
  bool geometry_only = false;
  // How far a vertex of the surface may have moved, relative to the diagonal of its bounding box; 0: not
  // at all.
  double max_move = 0;
  // Interior edges with two turns or more (branch lines) are listed instead of refused. Everything else is
  // checked as ever. That a line ends on the boundary only need not be asked: it follows from R5, since the
  // link of an interior vertex, a sphere, covers the directions there d times, and by Riemann and Hurwitz the
  // turns beyond one at its edges sum up to 2 d - 2, with each of them at most d - 1.
  bool allow_branches = false;
};

enum class Rule { R1 = 1, R2, R3, R4, R5, R6, R7 };

struct VerifyFailure {
  Rule rule;
  std::string message;  // one sentence that names the first few elements
  std::int64_t count = 0;
  std::vector<Index> first;  // vertices, tets, or pairs or triples of vertices, as the message says
};

struct TetQuality {
  std::int64_t tets = 0;
  double dihedral_min = 0, dihedral_p01 = 0, dihedral_max = 0;  // degrees; p01: 1 % of the angles are smaller
  double volume = 0;  // sum over the tets, overlaps counted each time
  // Programs that merge equal points when they read a mesh glue its layers where vertices coincide.
  std::int64_t coincident_vertices = 0;  // exactly in one place with another one
  double closest_pair = 0;               // the smallest distance of two vertices over the diagonal; rounded
  std::array<Index, 2> closest = {-1, -1};  // two as near as that
};

struct VerifyResult {
  std::vector<VerifyFailure> failures;  // at most one of each kind, in the order of the rules
  std::int64_t surface_vertices = 0, surface_faces = 0, vertices = 0, tets = 0, boundary_faces = 0;
  std::int64_t moved_vertices = 0;
  double max_move = 0;                             // relative to the diagonal
  std::vector<std::array<Index, 2>> branch_edges;  // with allow_branches: a < b, sorted
  bool complete = true;                            // false: stopped by the context; the answer is unknown

  bool ok() const { return complete && failures.empty(); }
  bool fails(Rule rule) const;
  std::string summary() const;  // the failures' messages joined, or "every rule holds"
};

// Both meshes may be anything: indices out of range and infinite coordinates break R1. `surface_vertices` of
// the mesh is not looked at. May throw std::bad_alloc.
VerifyResult verify(const Surface& surface, const TetMesh& mesh, const VerifyOptions& options = {},
                    const RunContext& context = {});

// pre: indices in range (R1). Only the context's number of threads is used. May throw std::bad_alloc.
TetQuality tet_quality(const TetMesh& mesh, const RunContext& context = {});

}  // namespace overtet
