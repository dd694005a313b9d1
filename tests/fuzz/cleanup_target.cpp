#include <algorithm>

#include "overtet/cleanup.h"
#include "src/mesh/topology.h"
#include "tests/fuzz/checks.h"
#include "tests/fuzz/targets.h"

namespace overtet::fuzz {

namespace {

// How many vertices there are, their coordinates, the corners of faces: a byte each. Coordinates are small
// whole numbers, so that vertices coincide and faces lie in each other; some corners are out of range.
Surface surface_of(std::string_view bytes) {
  constexpr std::size_t most_vertices = 16, most_faces = 32;
  const auto byte = [&](std::size_t i) {
    return i < bytes.size() ? static_cast<unsigned char>(bytes[i]) : 0;
  };
  Surface s;
  const std::size_t vertices = byte(0) % most_vertices + 1, first = 1 + 3 * vertices;
  const std::size_t faces = bytes.size() < first ? 0 : std::min((bytes.size() - first) / 3, most_faces);
  s.V.resize(static_cast<Eigen::Index>(vertices), 3);
  for (Eigen::Index i = 0; i < s.V.size(); ++i) s.V.data()[i] = byte(1 + static_cast<std::size_t>(i)) % 8;
  s.F.resize(static_cast<Eigen::Index>(faces), 3);
  for (Eigen::Index i = 0; i < s.F.size(); ++i) {
    const int corner = byte(first + static_cast<std::size_t>(i));
    s.F.data()[i] = corner == 255 ? -1 : corner % (static_cast<int>(vertices) + (corner > 240 ? 1 : 0));
  }
  return s;
}

void check_cleaned(const Surface& given, const CleanupOptions& options) {
  const Result<Cleanup> result = clean_up(given, options);
  if (!result) return check_error(result.error());
  const Cleanup& c = result.value();
  for (const Defect& d : c.defects) {
    check_line(d.message, "a defect");
    for (const DefectPlace& place : d.places) {
      for (const Index v : place.vertices)
        require(v >= 0 && v < given.V.rows(), "a defect has a vertex that is not there");
      for (const Index f : place.faces)
        require(f >= 0 && f < given.F.rows(), "a defect has a face that is not there");
    }
  }
  check_line(c.summary(), "a summary");
  require(map_to_json(c, {}).starts_with("{"), "a map is no JSON");
  if (c.problem) return check_error(*c.problem);
  for (const Index v : c.surface.F.reshaped())
    require(v >= 0 && v < c.surface.V.rows(), "what was cleaned has a vertex that is not there");
  if (options.allow_open) return;
  const TopologyCheck topology = check_topology(c.surface);
  // (A triangle with two sides is closed and manifold; that it has no mesh is for the certificates to say.)
  require(topology.indices_valid && topology.finite && topology.closed && topology.manifold_edges &&
              topology.oriented && topology.manifold_vertices,
          "what was cleaned needs cleaning", topology.problems.empty() ? "" : topology.problems[0]);
  const Result<Cleanup> again = clean_up(c.surface, options);
  require(again.ok() && !again.value().problem && !again.value().changed(),
          "cleaning twice changes what cleaning once has made");
}

}  // namespace

void cleanup(std::string_view bytes) {
  const Surface s = surface_of(bytes);
  const TopologyCheck topology = check_topology(s);
  for (const std::string& problem : topology.problems) check_line(problem, "a problem");
  const Result<SurfaceTopology> required = require_topology(s);
  if (!required) check_error(required.error());
  if (topology.indices_valid) degenerate_faces(s);
  CleanupOptions options;
  options.allow_open = mixed(bytes) % 2 == 1;
  check_cleaned(s, options);
}

}  // namespace overtet::fuzz
