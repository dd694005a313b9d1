// What goes to overtet-picture, which draws, and what comes back. Both are memory that the two processes
// share, on the same machine: plain structs, no conversion.
//
// Standard input: a Request, then the scene's arrays, one after the other: corners (float, 9 a triangle),
// colours (3 bytes a triangle), wires, lines (float, 6 a segment), marks (float, 3 a place). Standard output:
// the pixels, 3 bytes each, row by row from the top. Standard error, if the exit code is not 0: why.
#pragma once

#include <cstdint>

namespace overtet::view::picture_wire {

// More than 12 members: a header as it goes from one process to the other.
struct Request {
  std::uint64_t magic = 0x70696374'75726531;  // what else is on standard input is no request
  std::int32_t width = 0, height = 0;         // of the picture, in pixels
  std::int32_t samples = 1;                   // it is drawn so many times as wide and as high
  std::int32_t padding = 0;
  double eye[3]{}, target[3]{}, up[3]{};
  double height_degrees = 0, near = 0, far = 0;
  std::uint8_t mark_colour[8]{};  // red, green, blue; the rest is padding
  std::int64_t triangles = 0, wires = 0, lines = 0, marks = 0;
};

}  // namespace overtet::view::picture_wire
