// What the reader and the writer of Abaqus files agree on. Internal to src/io.
#pragma once

#include <string_view>

namespace overtet::io_detail {

// Names of the surface that holds all boundary faces, and of sets and surfaces of labels and regions, which
// their numbers follow.
inline constexpr std::string_view kAbaqusBoundary = "BOUNDARY", kAbaqusLabel = "LABEL_",
                                  kAbaqusRegion = "REGION_";
// Comments: a node's number and its coordinates as they are; names as they are.
inline constexpr std::string_view kAbaqusExact = "** exact: ", kAbaqusLabelName = "** label ",
                                  kAbaqusRegionName = "** region ";

// Face S1 .. S4 of a tet as kernels/core/tet_tables.h numbers it: by the corner that it has not.
inline constexpr int kAbaqusFace[4] = {3, 2, 0, 1};

}  // namespace overtet::io_detail
