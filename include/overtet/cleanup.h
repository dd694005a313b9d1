// Clean-up of raw surfaces that changes no shape: what other programs write, brought to what everything else
// here asks of a surface (closed, oriented, manifold). docs/raw-surfaces.md says what each step guarantees.
//
// Guaranteed of every cleaned surface: its triangles are triangles of the given one, corner for corner in the
// same places, each at most as often; only their numbers, the order of their corners, and which corners share
// a vertex may differ. No coordinate is computed. Vertices and faces keep their order; vertices that were
// split off come last. A surface that needs no clean-up comes back as it was, to the bit. Same surface: same
// result, on any number of threads. Everything is decided exactly, on the very doubles; -0 and 0 are one
// place. Time is near-linear in the size of the surface.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "overtet/io.h"
#include "overtet/report.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

// What can be wrong with a surface. The first ones are mended, in this order; the rest is beyond a clean-up
// that changes no shape.
enum class DefectKind {
  repeated_corner,   // a face with two corners in one vertex: dropped
  repeated_face,     // a face that is there twice: one is dropped
  unmerged_vertex,   // a vertex in the same place as another one, where only merging them closes the surface
  crowded_edge,      // an edge of 4, 6, ... faces, where solids touch: split, so that they come apart
  pinched_vertex,    // a vertex that joins several fans of faces: split
  unused_vertex,     // a vertex of no face: dropped
  turned_face,       // a face that is not oriented as its neighbours are: turned
  inward_component,  // a component that faces inwards and is no cavity: turned
  odd_edge,          // an edge of 3, 5, ... faces
  hole,              // a closed chain of edges that have one face only
  unpaired_edge,     // an edge of 4, 6, ... faces that cannot be told apart in pairs
  one_sided,         // a component that has no orientation, as a Klein bottle
  malformed          // an index out of range, a coordinate that is not finite, no faces
};
const char* name_of(DefectKind kind);  // as in the report, for instance "repeated-corner"
bool is_mended(DefectKind kind);       // by the clean-up

// One place of a defect, in numbers of the surface that was given.
struct DefectPlace {
  std::vector<Index> vertices;  // of a hole in order around it, the first ones
  std::vector<Index> faces;     // the first ones
  std::array<double, 3> position{};
  std::int64_t edges = 0;  // of a hole
  double length = 0;       // of a hole's edges together
};

struct Defect {
  DefectKind kind = DefectKind::malformed;
  std::int64_t count = 0;           // of faces, vertices, edges, components or holes, as the kind says
  std::vector<DefectPlace> places;  // the first ones
  std::string message;              // one sentence, with the first place in numbers of the file
};

struct CleanupOptions {
  bool strict = false;  // what would be mended is a problem, too
  // What is beyond a clean-up is a defect, but no problem: the surface is cleaned as far as that goes. Holes
  // stay; an edge whose faces cannot be paired comes apart, each face with a border of its own there.
  // Components are turned outwards only where nothing is open. One-sided ones are a problem still.
  bool allow_open = false;
  int most_places = 10;  // of each kind that are listed, 1 to 1000000

  Status validate() const;  // Errors: usage.
};

struct Cleanup {
  Surface surface;               // cleaned; where there is a problem, as it was given
  std::vector<Defect> defects;   // what was found, in the order of the kinds
  std::optional<Error> problem;  // bad_input: why the surface cannot be cleaned, with its place
  // The given surface's number of each vertex (#V) and face (#F) of the cleaned one. Empty: all are the same.
  std::vector<Index> vertex_of, face_of;
  std::vector<Index> turned;  // faces of the cleaned surface that have their last two corners swapped, sorted
  // Vertices that are gone because they were merged, with what they became: given, cleaned. Sorted.
  std::vector<std::array<Index, 2>> merged;

  // Whether the surface differs from the given one.
  bool changed() const { return !vertex_of.empty() || !face_of.empty() || !turned.empty(); }
  // One line for the user that says what was done, with counts; empty where nothing was.
  std::string summary() const;
};

// source: how messages call vertices and faces. What is wrong with the surface is in the result.
// Errors: usage (options), limit, interrupted. Never throws.
Result<Cleanup> clean_up(const Surface& surface, const CleanupOptions& options = {},
                         const SurfaceSource& source = {}, const RunContext& context = {});

// The places of defects, to look at: VTP (for ParaView; with the kind, by number in DefectKind, and the
// number of the place as data) or OBJ (one group a place). An edge and a hole are lines along them, a face
// its outline, a vertex the outline of a face at it, or a line without length. surface: the given one.
// Errors: io.
Status write_defects(const std::string& path, const Surface& surface, const std::vector<Defect>& defects,
                     CurveFormat format);

// For a report. source: of the given surface.
CleanupRecord record_of(const Cleanup& cleaned, const SurfaceSource& source);
// The map from the cleaned surface to the file, as JSON, each number by itself and counted from 0: `vertices`
// and `faces` (the file's number of each), `turned` (faces of the surface whose last two corners changed
// places) and `merged` (pairs: a vertex of the file that is gone, and the surface's vertex that it became).
std::string map_to_json(const Cleanup& cleaned, const SurfaceSource& source);

// Where the cleaned surface's vertices and faces stand in the file.
SurfaceSource source_of(const Cleanup& cleaned, const SurfaceSource& source);

}  // namespace overtet
