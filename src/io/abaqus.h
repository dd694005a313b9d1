// What the reader and the writer of Abaqus files agree on. Internal to src/io.
#pragma once

#include <string_view>

namespace overtet::io_detail {

inline constexpr struct AbaqusWords {
  // Names of the surface that holds all boundary faces, and of sets and surfaces of labels and regions, which
  // their numbers follow.
  std::string_view boundary = "BOUNDARY", label = "LABEL_", region = "REGION_";
  // Comments: a node's number and its coordinates as they are; names as they are.
  std::string_view exact = "** exact: ", label_name = "** label ", region_name = "** region ";
} kAbaqus;

// Face S1 .. S4 of a tet as kernels/core/tet_tables.h numbers it: by the corner that it has not.
inline constexpr int kAbaqusFace[4] = {3, 2, 0, 1};

}  // namespace overtet::io_detail
