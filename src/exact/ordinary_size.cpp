#include "src/exact/ordinary_size.h"

#include <gmpxx.h>

#include <cmath>
#include <limits>

#include "src/exact/tuning.h"

namespace overtet {

namespace {

VertexMatrix times_power(const VertexMatrix& V, int exponent) {
  return V.unaryExpr([&](double x) { return std::ldexp(x, exponent); });
}

}  // namespace

OrdinarySize::OrdinarySize(const Surface& surface) : surface_(surface) {
  const double largest = surface.V.size() > 0 ? surface.V.cwiseAbs().maxCoeff() : 0;
  if (!(largest > 0) || !std::isfinite(largest)) return;
  int reach = 0;
  std::frexp(largest, &reach);
  if (std::abs(reach) <= kOrdinary) return;
  VertexMatrix V = times_power(surface.V, -reach);
  if (times_power(V, reach) != surface.V) return;
  exponent_ = -reach;
  copy_ = std::make_unique<Surface>(Surface{std::move(V), surface.F});
}

OrdinarySize::OrdinarySize(const Surface& surface, const TriangleBvh& bvh) : OrdinarySize(surface) {
  bvh_ = &bvh;
  if (scaled()) copy_bvh_.build(copy_->V, copy_->F);
}

double OrdinarySize::back(double x, int dimensions) const {
  if (exponent_ == 0 || x == 0 || !std::isfinite(x)) return x;
  using Limits = std::numeric_limits<double>;
  const double y = std::ldexp(x, -dimensions * exponent_);
  return y == 0          ? std::copysign(Limits::denorm_min(), x)
         : std::isinf(y) ? std::copysign(Limits::max(), x)
                         : y;
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
