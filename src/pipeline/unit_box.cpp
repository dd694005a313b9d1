#include "src/pipeline/unit_box.h"

#include <cmath>
#include <cstdio>
#include <string>

namespace overtet {

namespace {

// Volumes are products of three differences, which may be 2^-53 of the size: 2^(-3 * 240) and 2^(-3 * 53)
// more still are normal numbers.
constexpr int kMaxExponent = 240;

void scale(VertexMatrix& V, int exponent) {
  for (Eigen::Index i = 0; i < V.size(); ++i) V.data()[i] = std::ldexp(V.data()[i], exponent);
}

}  // namespace

Result<UnitBox> into_unit_box(VertexMatrix& V) {
  const double largest = V.size() ? V.cwiseAbs().maxCoeff() : 0;
  if (largest == 0) return Error{ErrorCode::bad_input, "All vertices are at the origin."};
  int exponent = 0;
  std::frexp(largest, &exponent);  // largest = m 2^exponent, m in [1/2, 1)
  if (std::abs(exponent) > kMaxExponent) {
    char size[32];
    std::snprintf(size, sizeof size, "%.3g", largest);
    return Error{ErrorCode::bad_input,
                 "The coordinates reach " + std::string(size) + ", where volumes of tets are not numbers" +
                     " that a double can hold (the limits are about 1e-72 and 1e72): scale the model."};
  }
  VertexMatrix scaled = V;
  scale(scaled, -exponent);
  VertexMatrix back = scaled;
  scale(back, exponent);
  for (Eigen::Index v = 0; v < V.rows(); ++v)
    if (!(back.row(v).array() == V.row(v).array()).all())
      return Error{ErrorCode::bad_input, "Vertex " + std::to_string(v) +
                                             " has a coordinate so much smaller than the model that scaling" +
                                             " it into a unit box would lose bits; set it to zero."};
  V = std::move(scaled);
  return UnitBox{-exponent};
}

void out_of_unit_box(VertexMatrix& V, const UnitBox& box) { scale(V, -box.exponent); }

}  // namespace overtet
