#include "src/pipeline/unit_box.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "src/pipeline/tuning.h"

namespace overtet {

namespace {

void scale(VertexMatrix& V, const UnitBox& box, int sign) {
  for (Eigen::Index v = 0; v < V.rows(); ++v)
    for (int k = 0; k < 3; ++k)
      V(v, k) = std::ldexp(V(v, k), sign * box.exponent[static_cast<std::size_t>(k)]);
}

// e with 2^(e - 1) <= x < 2^e.
int exponent_of(double x) {
  int e = 0;
  std::frexp(x, &e);
  return e;
}

}  // namespace

Result<UnitBox> into_unit_box(VertexMatrix& V) {
  UnitBox box;
  std::array<int, 3> extent{}, reach{};
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const double low = V.rows() ? V.col(k).minCoeff() : 0, high = V.rows() ? V.col(k).maxCoeff() : 0;
    if (low == high)
      return Error{ErrorCode::unsolved, std::string("The surface is flat: all vertices have the same ") +
                                            "xyz"[k] + ", so there is no inside to mesh."};
    const double largest = std::max(std::abs(low), std::abs(high));
    // Halved before the subtraction, which could overflow.
    extent[i] = exponent_of(high / 2 - low / 2) + 1;
    reach[i] = exponent_of(largest);
  }
  const int widest = *std::max_element(extent.begin(), extent.end());
  const int all = *std::max_element(reach.begin(), reach.end());
  const bool uniform = widest - *std::min_element(extent.begin(), extent.end()) <= kUniformUpTo;
  for (std::size_t k = 0; k < 3; ++k) box.exponent[k] = uniform ? -all : -reach[k];
  VertexMatrix scaled = V;
  scale(scaled, box, 1);
  VertexMatrix back = scaled;
  scale(back, box, -1);
  for (Eigen::Index v = 0; v < V.rows(); ++v)
    if (!(back.row(v).array() == V.row(v).array()).all())
      return Error{ErrorCode::unsolved, "Vertex " + std::to_string(v) +
                                            " has a coordinate so much smaller than the model that scaling" +
                                            " it into a unit box would lose bits; set it to zero."};
  V = std::move(scaled);
  return box;
}

void out_of_unit_box(VertexMatrix& V, const UnitBox& box) { scale(V, box, -1); }
void back_into_unit_box(VertexMatrix& V, const UnitBox& box) { scale(V, box, 1); }

}  // namespace overtet
