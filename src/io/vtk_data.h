// The arrays of a VTK file, XML or legacy, and what they mean. Internal to src/io.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "overtet/attributes.h"
#include "src/io/mesh_parts.h"

namespace overtet::io_detail {

// The cells and arrays of a data set, as a file lists them. Polygons of poly data come after `other_cells`
// cells that are none (vertices and lines): cell data counts those, too.
struct VtkDataSet {
  std::vector<double> points;
  std::vector<double> connectivity, ends;  // of cells: the last of each ends there; 32-bit numbers are exact
  std::vector<double> types;               // VTK's numbers of cell types
  std::int64_t other_cells = 0;
  std::vector<Attribute> point_data, cell_data, field_data;
};

// Errors: bad_input, where numbers do not fit each other.
Result<MeshParts> parts_of(std::string_view name, VtkDataSet&& data, std::string format);

// "1 inlet\n2 outlet\n": names of labels, as bytes of a field that every program reads as numbers.
std::string text_of_names(const std::map<Index, std::string>& names);

// Without what XML does not take as it is.
std::string escaped(std::string_view name);

}  // namespace overtet::io_detail
