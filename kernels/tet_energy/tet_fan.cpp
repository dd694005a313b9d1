#include "kernels/tet_energy/tet_fan.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "kernels/tet_energy/tet_quality.h"
#include "kernels/tet_energy/tuning.h"

namespace overtet {

using Eigen::Vector3d;

namespace tet_fan_detail {

// GCC makes of it what the target of the function has: one register of AVX, or two of SSE2.
// Aligned as doubles are: so much any allocator promises.
using Four = double __attribute__((vector_size(sizeof(double) * kLanes), aligned(alignof(double))));

struct Four3 {
  Four x, y, z;
};

#define OVERTET_INLINE [[gnu::always_inline]] inline

// References, as there is no agreement on how registers of AVX are passed.
OVERTET_INLINE void minus(const Vector3d& p, const Four3& q, Four3& out) {
  out.x = p[0] - q.x, out.y = p[1] - q.y, out.z = p[2] - q.z;
}
OVERTET_INLINE void minus(const Four3& p, const Four3& q, Four3& out) {
  out.x = p.x - q.x, out.y = p.y - q.y, out.z = p.z - q.z;
}
OVERTET_INLINE void plus(const Four3& p, const Four3& q, Four3& out) {
  out.x = p.x + q.x, out.y = p.y + q.y, out.z = p.z + q.z;
}
OVERTET_INLINE void times(const Four3& p, const Four& s, Four3& out) {
  out.x = p.x * s, out.y = p.y * s, out.z = p.z * s;
}
OVERTET_INLINE void cross(const Four3& p, const Four3& q, Four3& out) {
  out.x = p.y * q.z - p.z * q.y, out.y = p.z * q.x - p.x * q.z, out.z = p.x * q.y - p.y * q.x;
}
OVERTET_INLINE void dot(const Four3& p, const Four3& q, Four& out) {
  out = (p.x * q.x + p.y * q.y) + p.z * q.z;
}
OVERTET_INLINE void less(Four& least, const Four& x) { least = x < least ? x : least; }
OVERTET_INLINE void more(Four& most, const Four& x) { most = x > most ? x : most; }
OVERTET_INLINE void magnitude(const Four& x, Four& out) { out = x < 0 ? -x : x; }

}  // namespace tet_fan_detail

using namespace tet_fan_detail;

// Four tets without what depends on the apex.
struct TetFan::Block {
  Four3 a, b, c, ab, ac, bc, nd;
  Four square[3];  // of ab, ac, bc
  Four qd, size, weight;
};

namespace {

// What depends on the apex.
struct AtApex {
  Four3 ad, bd, cd, na, nb, nc;  // edges and normals
  Four det, qa, qb, qc;
  Four square[3];  // of ad, bd, cd
};

template <class Block>
OVERTET_INLINE void look_from(const Block& f, const Vector3d& x, AtApex& at) {
  minus(x, f.a, at.ad), minus(x, f.b, at.bd), minus(x, f.c, at.cd);
  cross(at.ad, f.ab, at.nc), cross(f.ac, at.ad, at.nb), cross(at.bd, f.bc, at.na);
  dot(f.nd, at.ad, at.det);
  dot(at.na, at.na, at.qa), dot(at.nb, at.nb, at.qb), dot(at.nc, at.nc, at.qc);
  dot(at.ad, at.ad, at.square[0]), dot(at.bd, at.bd, at.square[1]), dot(at.cd, at.cd, at.square[2]);
}

// The least sines of four tets; 0 where rounding might have changed a sign. See min_dihedral_sine().
template <class Block>
OVERTET_INLINE void least_sines(const Block& f, const Vector3d& x, double* out) {
  AtApex at;
  look_from(f, x, at);
  Four far, other;
  magnitude(at.ad.x, far);
  magnitude(at.ad.y, other), more(far, other);
  magnitude(at.ad.z, other), more(far, other);
  const Four size = f.size * far;
  Four least = f.square[0] / (at.qc * f.qd);
  less(least, f.square[1] / (at.qb * f.qd));
  less(least, f.square[2] / (at.qa * f.qd));
  less(least, at.square[0] / (at.qb * at.qc));
  less(least, at.square[1] / (at.qa * at.qc));
  less(least, at.square[2] / (at.qa * at.qb));
  for (std::size_t k = 0; k < kLanes; ++k) {
    const bool sure = at.det[k] > 1e-14 * size[k] && size[k] > 1e-250;
    const double sine = at.det[k] * std::sqrt(least[k]);
    out[k] = !sure ? 0 : sine > kThinnestSine ? std::min(sine, 1.0) : kThinnestSine;
  }
}

// Six sines of four tets, in the order of dihedral_sines(), and gradients.
struct SixSines {
  Four sine[6];
  Four3 log_gradient[6];
};

template <class Block>
OVERTET_INLINE void all_sines(const Block& f, const Vector3d& x, SixSines& out) {
  AtApex at;
  look_from(f, x, at);
  // A volume lost in rounding still has a direction in which it grows.
  for (std::size_t k = 0; k < kLanes; ++k)
    at.det[k] = std::max(at.det[k], 1e-17 * std::sqrt(f.qd[k] * at.square[0][k]));
  const Four ia = 1 / at.qa, ib = 1 / at.qb, ic = 1 / at.qc, id = 1 / f.qd, iv = 1 / at.det;
  // Of the logarithm of the volume, and of the lengths of the normals.
  Four3 gv, ga, gb, gc;
  times(f.nd, iv, gv);
  cross(f.bc, at.na, ga), times(ga, ia, ga);
  cross(at.nb, f.ac, gb), times(gb, ib, gb);
  cross(f.ab, at.nc, gc), times(gc, ic, gc);
  out.sine[0] = f.square[0] * (ic * id), out.sine[1] = f.square[2] * (ia * id),
  out.sine[2] = f.square[1] * (ib * id);
  out.sine[3] = at.square[0] * (ib * ic), out.sine[4] = at.square[1] * (ia * ic),
  out.sine[5] = at.square[2] * (ia * ib);
  for (Four& s : out.sine)
    for (std::size_t k = 0; k < kLanes; ++k) s[k] = at.det[k] * std::sqrt(s[k]);
  Four3 g;
  minus(gv, gc, out.log_gradient[0]), minus(gv, ga, out.log_gradient[1]), minus(gv, gb, out.log_gradient[2]);
  const auto at_apex = [&](const Four3& edge, const Four& square, const Four3& g1, const Four3& g2, Four3& to)
      __attribute__((always_inline)) {
    times(edge, 1 / square, g), plus(gv, g, g), minus(g, g1, g), minus(g, g2, to);
  };
  at_apex(at.ad, at.square[0], gb, gc, out.log_gradient[3]);
  at_apex(at.bd, at.square[1], ga, gc, out.log_gradient[4]);
  at_apex(at.cd, at.square[2], ga, gb, out.log_gradient[5]);
}

// The same for this processor.
#if defined(__x86_64__)
template <class Block>
[[gnu::target("avx2")]] void least_sines_avx2(const Block& f, const Vector3d& x, double* out) {
  least_sines(f, x, out);
}
template <class Block>
[[gnu::target("avx2")]] void all_sines_avx2(const Block& f, const Vector3d& x, SixSines& out) {
  all_sines(f, x, out);
}
bool has_avx2() {
  static const bool has = __builtin_cpu_supports("avx2");
  return has;
}
template <class Block>
void least_sines_here(const Block& f, const Vector3d& x, double* out) {
  has_avx2() ? least_sines_avx2(f, x, out) : least_sines(f, x, out);
}
template <class Block>
void all_sines_here(const Block& f, const Vector3d& x, SixSines& out) {
  has_avx2() ? all_sines_avx2(f, x, out) : all_sines(f, x, out);
}
#else
template <class Block>
void least_sines_here(const Block& f, const Vector3d& x, double* out) {
  least_sines(f, x, out);
}
template <class Block>
void all_sines_here(const Block& f, const Vector3d& x, SixSines& out) {
  all_sines(f, x, out);
}
#endif

void set(Four3& to, std::size_t lane, const Vector3d& p) {
  to.x[lane] = p[0], to.y[lane] = p[1], to.z[lane] = p[2];
}

}  // namespace

TetFan::TetFan() = default;
TetFan::~TetFan() = default;
TetFan::TetFan(TetFan&&) noexcept = default;
TetFan& TetFan::operator=(TetFan&&) noexcept = default;

void TetFan::clear() {
  lanes_.clear();
  blocks_.clear();
  order_.clear();
}

void TetFan::add(const Vector3d& a, const Vector3d& b, const Vector3d& c, double weight) {
  const std::size_t lane = lanes_.size() % kLanes;
  if (lane == 0) {
    order_.push_back(blocks_.size());
    blocks_.emplace_back();
  }
  lanes_.push_back({a, b, c, weight});
  const Vector3d ab = b - a, ac = c - a, bc = c - b,
                 nd = Vector3d(ab[1] * ac[2] - ab[2] * ac[1], ab[2] * ac[0] - ab[0] * ac[2],
                               ab[0] * ac[1] - ab[1] * ac[0]);
  const double size = ab.cwiseAbs().maxCoeff() * ac.cwiseAbs().maxCoeff();
  Block& f = blocks_.back();
  // The lanes that are still to come repeat this one.
  for (std::size_t k = lane; k < kLanes; ++k) {
    set(f.a, k, a), set(f.b, k, b), set(f.c, k, c);
    set(f.ab, k, ab), set(f.ac, k, ac), set(f.bc, k, bc), set(f.nd, k, nd);
    f.square[0][k] = ab.squaredNorm(), f.square[1][k] = ac.squaredNorm(), f.square[2][k] = bc.squaredNorm();
    f.qd[k] = nd.squaredNorm();
    f.size[k] = size;
    f.weight[k] = weight;
  }
}

double TetFan::exact(std::size_t lane, const Vector3d& x) const {
  const Lane& t = lanes_[std::min(lane, lanes_.size() - 1)];
  return min_dihedral_sine(t.a, t.b, t.c, x);
}

const std::vector<double>& TetFan::qualities_at(const Vector3d& x) {
  qualities_.resize(kLanes * blocks_.size());
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    double* out = qualities_.data() + kLanes * b;
    least_sines_here(blocks_[b], x, out);
    for (std::size_t k = 0; k < kLanes; ++k) {
      if (out[k] == 0) out[k] = exact(kLanes * b + k, x);
      out[k] *= blocks_[b].weight[k];
    }
  }
  qualities_.resize(lanes_.size());
  return qualities_;
}

double TetFan::worst_at(const Vector3d& x, double stop) {
  double worst = HUGE_VAL;
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const std::size_t b = order_[i];
    double q[kLanes];
    least_sines_here(blocks_[b], x, q);
    double here = HUGE_VAL;
    for (std::size_t k = 0; k < kLanes; ++k) {
      if (q[k] == 0) q[k] = exact(kLanes * b + k, x);
      here = std::min(here, blocks_[b].weight[k] * q[k]);
    }
    if (here >= worst) continue;
    worst = here;
    if (i > 0) std::swap(order_[i], order_[i / 2]);
    if (worst <= stop) return worst;
  }
  return worst;
}

void TetFan::sines_near_worst(const Vector3d& x, double factor, std::vector<Sine>& out) {
  out.clear();
  const std::vector<double>& qualities = qualities_at(x);
  const double most = factor * *std::min_element(qualities.begin(), qualities.end());
  SixSines six;
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    const std::size_t first = kLanes * b, last = std::min(first + kLanes, qualities.size());
    if (!(*std::min_element(&qualities[first], &qualities[first] + (last - first)) <= most)) continue;
    all_sines_here(blocks_[b], x, six);
    for (std::size_t i = first; i < last; ++i) {
      if (!(qualities[i] <= most)) continue;
      const std::size_t k = i - first;
      for (int e = 0; e < 6; ++e) {
        const double sine = lanes_[i].weight * six.sine[e][k];
        const Four3& g = six.log_gradient[e];
        if (!(sine > most)) out.push_back({sine, {g.x[k], g.y[k], g.z[k]}});
      }
    }
  }
}

#undef OVERTET_INLINE

}  // namespace overtet
