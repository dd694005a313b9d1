// For .cpp files only: a face's plane, looked at along an axis, for segments that run in it.
#pragma once

#include <utility>

#include "src/exact/rays.h"

namespace overtet::exact {

class PlaneView {
 public:
  // pre: the face has an area.
  PlaneView(const Rays& rays, Index f);

  // On which side of the line from a to b the two ends of a segment lie (1: that of a face's inside, where a
  // and b are neighbouring corners as it turns); and if not on the same side, how far from it.
  struct Crossing {
    int from = 0, to = 0;
    Rational from_height, to_height;
    bool crosses() const { return from * to < 0; }
    // On the segment, 0 to 1. pre: crosses.
    Rational place() const { return from_height / (from_height - to_height); }
  };

  // pre: all four points lie in the plane, and a and b are doubles.
  Crossing crossing(const Point& from, const Point& to, const double* a, const double* b) const;

  // The same for the ends' sides only, of a segment in doubles.
  int side(const double* a, const double* b, const double* p) const;

 private:
  int axis_ = 0, up_ = 1;  // along which it is seen, and the sign of the face's area then
};

}  // namespace overtet::exact
