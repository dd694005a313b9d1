// Surfaces of extreme size, brought to an ordinary one. Everything in this room is decided exactly at any
// size, but far from 1 that is slow (boxes of floats hold everything or nothing, floating-point filters do
// not apply), and what is only computed in doubles may leave their range.
#pragma once

#include <array>
#include <memory>
#include <string>

#include "kernels/bvh/bvh.h"
#include "overtet/types.h"

namespace overtet {

// The exponent e of the power of two that brings points of extreme size to 1 (largest coordinate below 2^-64
// or from 2^64 on), if that is exact. 0: they are of ordinary size, or cannot be scaled without losing bits.
int to_ordinary_size(const VertexMatrix& V);
VertexMatrix times_power(const VertexMatrix& V, int exponent);  // V 2^exponent

// x / 2^(dimensions * exponent): a number with as many dimensions (1 a length, 3 a volume) of what was
// multiplied by 2^exponent; never 0 or infinite where x is not.
double from_ordinary_size(double x, int exponent, int dimensions);

// The surface itself where its largest coordinate is between 2^-64 and 2^64; else a copy, multiplied by the
// power of two that brings it to 1. Only where that is exact, so whatever is decided about the copy is true
// of the surface. Refers to the surface and to the tree.
class OrdinarySize {
 public:
  // pre: indices are valid, V is finite.
  explicit OrdinarySize(const Surface& surface);
  OrdinarySize(const Surface& surface, const TriangleBvh& bvh);  // with the tree of the surface

  bool scaled() const { return copy_ != nullptr; }
  const Surface& surface() const { return scaled() ? *copy_ : surface_; }
  const TriangleBvh& bvh() const { return scaled() ? copy_bvh_ : *bvh_; }  // pre: made with one

  // From the copy to the surface: a number (from_ordinary_size); a point; and a point in fractions, exactly.
  double back(double x, int dimensions = 1) const { return from_ordinary_size(x, exponent_, dimensions); }
  std::array<double, 3> back(const std::array<double, 3>& point) const;
  std::array<std::string, 3> back(const std::array<std::string, 3>& point) const;

 private:
  const Surface& surface_;
  const TriangleBvh* bvh_ = nullptr;
  std::unique_ptr<Surface> copy_;
  TriangleBvh copy_bvh_;
  int exponent_ = 0;  // the copy is the surface times 2^exponent_
};

}  // namespace overtet
