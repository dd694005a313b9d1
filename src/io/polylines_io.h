// Polylines with data, for looking at: VTP (ParaView; one line cell a segment, data on cells and points) and
// OBJ (one group with one `l` element a line, no data).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "overtet/io.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

struct Polylines {
  struct Line {
    std::string name;
    std::vector<Index> points;  // two at least; a closed line ends with its first point
  };
  struct Field {
    std::string name;
    std::vector<double> values;  // `components` for each segment (point)
    int components = 1;
    bool whole = true;  // written as integers
  };
  std::vector<std::array<double, 3>> points;
  std::vector<Line> lines;
  std::vector<Field> segment_data;  // line by line
  std::vector<Field> point_data;
};

// Atomic. Coordinates read back as the same doubles.
Status write_polylines(const std::string& path, const Polylines& polylines, CurveFormat format,
                       const RunContext& context = {});

}  // namespace overtet
