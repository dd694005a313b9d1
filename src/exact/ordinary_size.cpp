#include "src/exact/ordinary_size.h"

#include <gmpxx.h>

#include <cmath>
#include <limits>

#include "src/exact/tuning.h"

namespace overtet {

VertexMatrix times_power(const VertexMatrix& V, int exponent) {
  return V.unaryExpr([&](double x) { return std::ldexp(x, exponent); });
}

int to_ordinary_size(const VertexMatrix& V) {
  const double largest = V.size() > 0 ? V.cwiseAbs().maxCoeff() : 0;
  if (!(largest > 0) || !std::isfinite(largest)) return 0;
  int reach = 0;
  std::frexp(largest, &reach);
  if (std::abs(reach) <= kOrdinary || times_power(times_power(V, -reach), reach) != V) return 0;
  return -reach;
}

double from_ordinary_size(double x, int exponent, int dimensions) {
  if (exponent == 0 || x == 0 || !std::isfinite(x)) return x;
  using Limits = std::numeric_limits<double>;
  const double y = std::ldexp(x, -dimensions * exponent);
  return y == 0          ? std::copysign(Limits::denorm_min(), x)
         : std::isinf(y) ? std::copysign(Limits::max(), x)
                         : y;
}

OrdinarySize::OrdinarySize(const Surface& surface)
    : surface_(surface), exponent_(to_ordinary_size(surface.V)) {
  if (exponent_ != 0)
    copy_ = std::make_unique<Surface>(Surface{times_power(surface.V, exponent_), surface.F});
}

OrdinarySize::OrdinarySize(const Surface& surface, const TriangleBvh& bvh) : OrdinarySize(surface) {
  bvh_ = &bvh;
  if (scaled()) copy_bvh_.build(copy_->V, copy_->F);
}

std::array<double, 3> OrdinarySize::back(const std::array<double, 3>& point) const {
  return {back(point[0]), back(point[1]), back(point[2])};
}

std::array<std::string, 3> OrdinarySize::back(const std::array<std::string, 3>& point) const {
  if (exponent_ == 0) return point;
  std::array<std::string, 3> out;
  for (std::size_t k = 0; k < 3; ++k) {
    mpq_class x(point[k], 10);
    x.canonicalize();
    if (exponent_ > 0)
      mpq_div_2exp(x.get_mpq_t(), x.get_mpq_t(), static_cast<mp_bitcnt_t>(exponent_));
    else
      mpq_mul_2exp(x.get_mpq_t(), x.get_mpq_t(), static_cast<mp_bitcnt_t>(-exponent_));
    out[k] = x.get_str();
  }
  return out;
}

}  // namespace overtet
