#include "src/exact/rational.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/core/assertions.h"

namespace overtet::exact {

Whole cross(const Whole& a, const Whole& b) {
  return {mpz_class(a[1] * b[2] - a[2] * b[1]), mpz_class(a[2] * b[0] - a[0] * b[2]),
          mpz_class(a[0] * b[1] - a[1] * b[0])};
}

int dot_sign(const Whole& a, const Whole& b) {
  return sgn(mpz_class(a[0] * b[0] + a[1] * b[1] + a[2] * b[2]));
}

// The sign of a . (b x c). What it works with stays allocated: most of the time went there.
int det_sign(const Whole& a, const Whole& b, const Whole& c) {
  thread_local mpz_class minor, sum;
  sum = 0;
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    mpz_mul(minor.get_mpz_t(), b[i].get_mpz_t(), c[j].get_mpz_t());
    mpz_submul(minor.get_mpz_t(), b[j].get_mpz_t(), c[i].get_mpz_t());
    mpz_addmul(sum.get_mpz_t(), a[k].get_mpz_t(), minor.get_mpz_t());
  }
  return sgn(sum);
}

Vec near_one(const Vec& v) {
  OVERTET_EXPECTS(!is_zero(v));
  long top = std::numeric_limits<long>::min();
  for (int k = 0; k < 3; ++k)
    if (sign(v[k]) != 0)
      top = std::max(top, static_cast<long>(mpz_sizeinbase(v[k].get_num_mpz_t(), 2)) -
                              static_cast<long>(mpz_sizeinbase(v[k].get_den_mpz_t(), 2)));
  Vec out;
  for (int k = 0; k < 3; ++k)
    if (top > 0)
      mpq_div_2exp(out[k].get_mpq_t(), v[k].get_mpq_t(), static_cast<mp_bitcnt_t>(top));
    else
      mpq_mul_2exp(out[k].get_mpq_t(), v[k].get_mpq_t(), static_cast<mp_bitcnt_t>(-top));
  return out;
}

Homogeneous::Homogeneous(const Vec& v) {
  mpz_lcm(denominator.get_mpz_t(), v[0].get_den_mpz_t(), v[1].get_den_mpz_t());
  mpz_lcm(denominator.get_mpz_t(), denominator.get_mpz_t(), v[2].get_den_mpz_t());
  for (int k = 0; k < 3; ++k) {
    mpz_divexact(numerator[k].get_mpz_t(), denominator.get_mpz_t(), v[k].get_den_mpz_t());
    numerator[k] *= v[k].get_num();
  }
}

Whole whole(const Vec& v) { return Homogeneous(v).numerator; }

Whole primitive(const Vec& v) {
  Whole out = whole(v);
  mpz_class divisor;
  for (const mpz_class& x : out) mpz_gcd(divisor.get_mpz_t(), divisor.get_mpz_t(), x.get_mpz_t());
  if (sgn(divisor) == 0) return out;
  const int first = sgn(out[0]) != 0 ? sgn(out[0]) : sgn(out[1]) != 0 ? sgn(out[1]) : sgn(out[2]);
  if (first < 0) divisor = -divisor;
  for (mpz_class& x : out) mpz_divexact(x.get_mpz_t(), x.get_mpz_t(), divisor.get_mpz_t());
  return out;
}

std::array<double, 3> unit(const Whole& a) {
  OVERTET_EXPECTS(!is_zero(a));
  std::array<double, 3> out;
  long exponent[3], top = std::numeric_limits<long>::min();
  for (int k = 0; k < 3; ++k) {
    out[k] = mpz_get_d_2exp(&exponent[k], a[k].get_mpz_t());
    if (out[k] != 0) top = std::max(top, exponent[k]);
  }
  double square = 0;
  for (int k = 0; k < 3; ++k) {
    // What is out of the range of doubles is 0.
    out[k] = std::ldexp(out[k], static_cast<int>(std::max(exponent[k] - top, -1000L)));
    square += out[k] * out[k];
  }
  const double length = std::sqrt(square);
  for (double& x : out) x /= length;
  return out;
}

std::string fraction(const Rational& x) { return x.get_str(); }

}  // namespace overtet::exact
