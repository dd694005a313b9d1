// What a run says about itself, as data and as JSON. The README ("The report") says what the keys mean,
// docs/report.schema.json is their schema. Vertices are counted from 0.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "overtet/certificate.h"
#include "overtet/result.h"
#include "overtet/types.h"
#include "overtet/verification.h"

namespace overtet {

enum class RunStatus {
  exact,
  repaired,
  refined,
  branched,
  flipped,
  embedded,
  infeasible,
  unsolved,
  bad_input,
  limit,
  interrupted,
  failed
};
const char* name_of(RunStatus status);  // as in the report, for instance "bad-input"
RunStatus status_of(ErrorCode code);    // of a run that ended with such an error

// A number or a word of a report, under its key.
using Figure = std::pair<std::string, std::variant<std::int64_t, double, std::string, bool>>;

struct StageRecord {
  std::string name;
  double seconds = 0, cpu_seconds = 0;  // children included
  std::int64_t iterations = 0;
  std::vector<Figure> figures;
};

// A piece of a map from a cleaned surface to its file: for i < count and j < each, number first + i * each +
// j of the surface is number in_file + i of the file. Both are counted from 0.
struct NumberRun {
  std::int64_t first = 0, in_file = 0, count = 0, each = 1;
};

// What a clean-up (cleanup.h) changed before the run.
struct CleanupRecord {
  std::vector<std::pair<std::string, std::int64_t>> steps;  // kinds of defects that were mended, with counts
  std::vector<NumberRun> vertices, faces;                   // of the whole cleaned surface, in order
  std::vector<std::array<std::int64_t, 2>>
      turned;  // faces whose last two corners changed places: first, count
};

struct InputRecord {
  std::string format;
  std::vector<std::string> notes;
  std::optional<CleanupRecord> cleanup;  // where one changed the surface
  std::int64_t vertices = 0, faces = 0, components = 0;
  std::vector<std::int64_t> genus;  // of each component
  std::int64_t pairs = 0, hinges = 0;
  std::optional<int> winding_min, winding_max;  // absent: not looked at
};

// Dihedral angles at what a repair has moved, in degrees, and what no mesh can have more than: the interior
// angle of the surface at an edge is shared by the tets there. Extra turns at edges count as in this mesh. No
// bound is above 70.53, the angle of the regular tet.
struct MovedAngles {
  // The least of the tets at moved vertices; angles near 180 count with what is missing to 180.
  double least = 0;
  // At moved vertices, wherever they go within the allowed move: where the edge of a touched face has not
  // moved.
  double bound = 0;
  double bound_as_moved = 0;   // at moved vertices, where they are now
  double bound_elsewhere = 0;  // between faces without moved vertices, wherever these go
};

// Of an embedding (embed.h): U0 over the input, of all faces and of all edges.
struct RatioRange {
  double least = 1, p01 = 1, p50 = 1, p99 = 1, most = 1;
};
struct EmbeddingQuality {
  RatioRange area, edge;
  double area_within_20 = 1;  // part of the faces whose ratio is in [0.8, 1.2]
  bool collapsed = false;     // a hundredth of the faces has less than a tenth of its area
};

// More than 12 members: a plain record of what the JSON shows.
struct Report {
  std::vector<Figure> options;  // as the run used them
  InputRecord input;
  RunStatus status = RunStatus::failed;
  std::string message;
  std::optional<Certificate> certificate;  // the "witness": why no mesh exists
  std::int64_t moved_vertices = 0;
  double max_relative_move = 0, mean_relative_move = 0;  // of the diagonal; the mean of those that moved
  std::vector<std::int64_t> moved_ids;                   // the vertices, sorted
  std::vector<Index> subdivided_faces;  // of `refined`: the input's faces that are in pieces, sorted
  std::int64_t added_vertices = 0;      // of the refined surface
  std::vector<Index> face_of_piece;     // and of each face of the refined surface the input's
  std::vector<std::array<Index, 2>> branch_edges;  // of `branched`: vertices of the mesh, a < b, sorted
  std::vector<Index> flipped_tets;                 // of `flipped`: tets that are not positive, sorted
  std::optional<MovedAngles> moved_angles;         // of a repaired surface's mesh
  std::vector<StageRecord> stages;
  std::optional<TetQuality> quality;
  std::optional<EmbeddingQuality> embedding;  // of `embedded`
  std::int64_t laid_aside = 0;                // and components that were moved as a whole
  double seconds = 0;
  std::size_t peak_rss_bytes = 0;
  std::string result_hash;  // of the vertices and tets, empty without a result
};

std::string to_json(const Report& report);  // indented, with a line end

}  // namespace overtet
