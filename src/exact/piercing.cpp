#include "src/exact/piercing.h"

#include <algorithm>
#include <bit>
#include <cstdint>

#include "kernels/core/assertions.h"

namespace overtet::exact {

namespace {

// x = mantissa * 2^exponent, the mantissa odd or 0.
struct Binary {
  std::int64_t mantissa = 0;
  int exponent = std::numeric_limits<int>::max();

  explicit Binary(double x) {
    if (x == 0) return;
    mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(x, &exponent), 53));
    const int zeros = std::countr_zero(static_cast<std::uint64_t>(mantissa));
    mantissa >>= zeros;
    exponent += zeros - 53;
  }
};

void subtract(const Whole& a, const Whole& b, Whole& out) {
  for (int k = 0; k < 3; ++k) mpz_sub(out[k].get_mpz_t(), a[k].get_mpz_t(), b[k].get_mpz_t());
}

void multiply_add(mpz_class& sum, const mpz_class& a, const mpz_class& b) {
  mpz_addmul(sum.get_mpz_t(), a.get_mpz_t(), b.get_mpz_t());
}

}  // namespace

Vec piercing(const double* p, const double* q, const double* a, const double* b, const double* c) {
  // What it works with stays allocated.
  thread_local Whole point[5], difference[4], normal;
  thread_local mpz_class height[2];
  const double* const given[5] = {p, q, a, b, c};
  int unit = std::numeric_limits<int>::max();
  for (const double* x : given)
    for (int k = 0; k < 3; ++k) unit = std::min(unit, Binary(x[k]).exponent);
  for (int i = 0; i < 5; ++i)
    for (int k = 0; k < 3; ++k) {
      const Binary x(given[i][k]);
      mpz_set_si(point[i][k].get_mpz_t(), x.mantissa);
      if (x.mantissa != 0)
        mpz_mul_2exp(point[i][k].get_mpz_t(), point[i][k].get_mpz_t(),
                     static_cast<mp_bitcnt_t>(x.exponent - unit));
    }
  for (int i = 0; i < 4; ++i) subtract(point[i < 2 ? i : i + 1], point[2], difference[i]);
  const auto& [from, to, ab, ac] = difference;
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    mpz_mul(normal[k].get_mpz_t(), ab[i].get_mpz_t(), ac[j].get_mpz_t());
    mpz_submul(normal[k].get_mpz_t(), ab[j].get_mpz_t(), ac[i].get_mpz_t());
  }
  for (int e = 0; e < 2; ++e) {
    height[e] = 0;
    for (int k = 0; k < 3; ++k) multiply_add(height[e], normal[k], difference[e][k]);
  }
  // Between p and q in proportion to their heights.
  Vec out;
  for (int k = 0; k < 3; ++k) {
    mpz_class& numerator = out[k].get_num();
    numerator = height[0] * point[1][k];
    mpz_submul(numerator.get_mpz_t(), height[1].get_mpz_t(), point[0][k].get_mpz_t());
    out[k].get_den() = height[0] - height[1];
    OVERTET_EXPECTS(sgn(out[k].get_den()) != 0);
    out[k].canonicalize();
    if (unit < 0)
      mpq_div_2exp(out[k].get_mpq_t(), out[k].get_mpq_t(), static_cast<mp_bitcnt_t>(-unit));
    else
      mpq_mul_2exp(out[k].get_mpq_t(), out[k].get_mpq_t(), static_cast<mp_bitcnt_t>(unit));
  }
  return out;
}

}  // namespace overtet::exact
