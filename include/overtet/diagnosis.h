// What can be said about a surface before any mesh is made: whether there can be one, and if not, why not;
// where it passes through itself; and what a mesh has to do at its hinges.
//
// Exact, on the very doubles: the verdict, which faces intersect, hinges and their integers, winding numbers.
// The result does not depend on the number of threads. Vertices and faces are counted from 0. Hinges are the
// "hinge points" of Sacht et al. 2013, section 3; docs/theory.md derives B0 and the rules.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "overtet/certificate.h"
#include "overtet/curves.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

enum class Verdict {
  bad_input,  // not a closed, oriented, manifold surface: fix what `message` names first
  embedded,   // no two faces intersect and the winding is right: an ordinary tet mesh will do
  feasible,   // passes through itself; nothing that forbids a mesh was found
  infeasible  // no mesh exists: the certificate proves it
};
const char* verdict_name(Verdict verdict);

struct ComponentDiagnosis {
  Index faces = 0, vertices = 0;
  Index genus = 0;  // -1: the surface is not closed, oriented and manifold
  // In cubed units; negative: it faces inwards; none: not computed, or the surface is not closed.
  std::optional<double> signed_volume;
};

// Where the solid is thin: faces that face away from each other, the inside between them, with no vertex in
// common. Found by rays from faces and vertices, in doubles. Faces that cross others are left out.
struct ThinSpot {
  Index face = -1, across = -1;      // where it is thinnest
  std::array<double, 3> position{};  // on `face`
  double thickness = 0;              // there, against the normal
  Index faces = 0;                   // how many faces are thin there, of both sides
};

// An edge at a hinge, and how often something may turn around it.
struct EdgeAtHinge {
  Index to = -1;  // the edge's other vertex
  // The winding number on its outer side, from the hinge on, part by part between its crossings with other
  // faces: what bounds the extra turns. None where the edge runs inside another face.
  std::optional<std::vector<int>> levels;
};

// A vertex whose surroundings cross themselves.
struct HingeDiagnosis {
  Index vertex = -1;
  // What a mesh needs there (certificate.h says what B0 is); none where it is not defined: a face of another
  // part of the surface contains the vertex.
  std::optional<int> B0;
  int covering = 0;                             // the smallest winding number around the vertex
  std::vector<std::array<Index, 2>> crossings;  // faces at the vertex that intersect beyond it
  std::vector<EdgeAtHinge> edges;               // counter-clockwise seen from outside
};

// A boundary edge around which the tets of a mesh make k turns more than the surface shows.
struct ExtraTurns {
  Index a = -1, b = -1;  // a < b
  int k = 0;
};

// More than 12 members: a plain record of findings, each on its own, that callers read by name.
struct SurfaceDiagnosis {
  Verdict verdict = Verdict::bad_input;
  std::string message;                     // one sentence: why
  std::optional<Certificate> certificate;  // of `infeasible`
  std::vector<std::string> advice;         // sentences for a person

  Index vertices = 0, faces = 0;
  bool closed = false, manifold = false, oriented = false;
  std::vector<std::string> problems;           // of the topology, the first of each kind
  std::vector<ComponentDiagnosis> components;  // by smallest face; faces that hang together at vertices
  std::vector<Index> degenerate_faces;         // without area

  // From here on: empty for `bad_input`.
  std::vector<std::array<Index, 2>> pairs;  // of faces that intersect, sorted
  Index pairs_sharing_vertex = 0, pairs_sharing_edge = 0;
  std::optional<int> winding_min, winding_max;
  std::vector<HingeDiagnosis> hinges;  // by vertex
  std::vector<ExtraTurns> wound_edges;
  // Hinges that forbid a mesh, by rule: odd groups that no edges join, and those whose edges cannot take the
  // turns or whose surroundings no tets fill; and those for which no edges were found (sorted).
  std::vector<std::vector<Index>> odd_groups;
  std::vector<Index> crowded, unfillable, unmet;
  Curves curves;
  std::vector<ThinSpot> thin_spots;  // thinner than thin_limit, the thinnest first
  double thin_limit = 0;             // a length: a thousandth of the diagonal
};

// What is wrong with the surface is in the diagnosis. Errors: limit, interrupted, internal. Never throws.
Result<SurfaceDiagnosis> diagnose(const Surface& surface, const RunContext& context = {});

}  // namespace overtet
