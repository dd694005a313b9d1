// What a run says about itself, as data and as JSON (the contract is in the README: "The report").
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "src/verify/verify.h"

namespace overtet {

enum class RunStatus { exact, repaired, infeasible, unsolved, bad_input, limit, interrupted, failed };
const char* name_of(RunStatus status);  // as in the report, for instance "bad-input"

// A figure of a report: shown under its name.
using Figure = std::pair<std::string, std::variant<std::int64_t, double, std::string, bool>>;

struct StageRecord {
  std::string name;
  double seconds = 0, cpu_seconds = 0;  // children included
  std::int64_t iterations = 0;
  std::vector<Figure> figures;
};

// Why no tet mesh exists.
struct WitnessRecord {
  enum class Rule {
    winding,   // a point of negative winding number
    vertex,    // a vertex whose neighbourhood positive tets cannot fill: B0 < 0
    fold,      // the same at a dihedral so close to 0 or 2 pi that rounded angles may give another integer
    unpaired,  // an odd number of vertices with odd B0 that covered edges join to each other only
    crowded,   // a vertex whose edges cannot take the turns that B0 asks for
    link,      // a vertex whose link polygon bounds no disc that fits
    shared,    // a point where several parts of the surface meet, whose discs need more layers than there is
               // room for
    stack,  // coplanar faces, and moves of their vertices, however small, that make a negative winding number
    gluing  // crossings and edges around which the sheets of the solid cannot be glued at once
  };
  Rule rule = Rule::winding;
  std::array<std::string, 3> point;  // decimal numbers or exact fractions
  int winding = 0;
  Index face = -1;                               // whose normal the vertices move along
  std::vector<int> moves;                        // of the vertices
  std::vector<Index> vertices;                   // one, the whole odd group, or those that move
  std::vector<int> B0;                           // of each
  std::vector<std::array<double, 3>> positions;  // of the vertices, or on the curve of each pair
  std::vector<std::array<Index, 2>> pairs;       // faces that cross,
  std::vector<int> layers;  // where so many sheets lie in front of both; or that each vertex needs
  int room = 0;             // for so many layers in all
  std::vector<std::array<Index, 2>> edges;  // by their vertices
  std::optional<std::array<int, 3>> apart;  // the direction in which the vertices' component moves
};
const char* name_of(WitnessRecord::Rule rule);  // as in the report

struct InputRecord {
  std::string format;
  std::vector<std::string> notes;
  std::int64_t vertices = 0, faces = 0, components = 0;
  std::vector<std::int64_t> genus;  // of each component
  std::int64_t pairs = 0, hinges = 0;
  std::optional<int> winding_min, winding_max;  // absent: not looked at
};

struct Report {
  std::vector<Figure> options;  // as the run used them
  InputRecord input;
  RunStatus status = RunStatus::failed;
  std::string message;
  std::optional<WitnessRecord> witness;
  std::int64_t moved_vertices = 0;
  double max_relative_move = 0, mean_relative_move = 0;  // of the diagonal; the mean of those that moved
  std::vector<std::int64_t> moved_ids;                   // the vertices, sorted
  std::vector<StageRecord> stages;
  std::optional<TetQuality> quality;
  double seconds = 0;
  std::size_t peak_rss_bytes = 0;
  std::string result_hash;  // of the vertices and tets, empty without a result
};

std::string to_json(const Report& report);  // indented, with a line end

// The report's "witness", for who prints it elsewhere; no line end.
std::string to_json(const WitnessRecord& witness);

}  // namespace overtet
