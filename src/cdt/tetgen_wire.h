// What parent and child say to each other: fixed-size headers followed by plain arrays.
// Both sides are built together and run on one machine, so layout and byte order agree.
#pragma once

#include <cstdint>

namespace overtet::tetgen_wire {

constexpr std::uint32_t kMagic = 0x4f54475au;

// Followed by V (3 doubles each), F (3 int32 each), holes (3 doubles each). With tets (coarsen-and-refine; F
// is then their boundary) also by these (4 int32 each) and by the edges of the boundary (2 int32 each).
// More than 12 members: a header as it goes from one process to the other.
struct Request {
  std::uint32_t magic = kMagic;
  std::uint32_t quality = 0;
  std::uint32_t keep_facets = 0;
  std::uint32_t fill_convex_hull = 0;
  std::int64_t vertices = 0;
  std::int64_t facets = 0;
  std::int64_t holes = 0;
  std::int64_t most_points = 0;   // that may be added; 0: any number
  std::int64_t largest_star = 0;  // of tets around an edge that flips take apart; 0: any
  std::int64_t most_predicates = 0;
  std::int64_t tets = 0, edges = 0;
  std::int64_t kept_vertices = 0;  // with tets: those that follow are taken out first
  double radius_edge = 0;
  double tolerance = 0;
};

enum class Outcome : std::uint32_t { done, gave_up, endless, out_of_memory, not_positive, protocol };

// Followed, when the outcome is done, by V (3 doubles), T (4 int32), neighbours (4 int32), facets
// (3 int32) and the input facet of each (int32). Tets are positive, vertices in TetGen's order.
struct Reply {
  std::uint32_t magic = kMagic;
  Outcome outcome = Outcome::protocol;
  std::int64_t tetgen_code = 0;  // what TetGen threw
  std::int64_t count = 0;        // of offending tets
  std::int64_t vertices = 0;
  std::int64_t tets = 0;
  std::int64_t facets = 0;
  std::int64_t predicates = 0;  // that TetGen has called
};

}  // namespace overtet::tetgen_wire
