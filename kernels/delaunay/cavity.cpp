#include "kernels/delaunay/cavity.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/assertions.h"
#include "kernels/core/tet_tables.h"
#include "kernels/core/triangles.h"
#include "kernels/delaunay/delaunay.h"
#include "kernels/predicates/predicates.h"

namespace overtet {

bool apart(const double* points, const std::array<Index, 4>& tet, const std::array<Index, 3>& triangle) {
  const auto at = [&](Index v) { return points + 3 * static_cast<std::size_t>(v); };
  const auto corner_of = [&](Index v) {
    return v == tet[0] ? 0 : v == tet[1] ? 1 : v == tet[2] ? 2 : v == tet[3] ? 3 : -1;
  };
  const int shared[3] = {corner_of(triangle[0]), corner_of(triangle[1]), corner_of(triangle[2])};
  OVERTET_EXPECTS(orient3d(at(tet[0]), at(tet[1]), at(tet[2]), at(tet[3])) > 0);
  OVERTET_EXPECTS(!collinear(at(triangle[0]), at(triangle[1]), at(triangle[2])));
  OVERTET_EXPECTS(shared[0] < 0 || shared[1] < 0 || shared[2] < 0);
  if (shared[0] < 0 && shared[1] < 0 && shared[2] < 0)
    for (int k = 0; k < 3; ++k) {
      const double x[4] = {at(tet[0])[k], at(tet[1])[k], at(tet[2])[k], at(tet[3])[k]};
      const double y[3] = {at(triangle[0])[k], at(triangle[1])[k], at(triangle[2])[k]};
      const double low = std::min(std::min(x[0], x[1]), std::min(x[2], x[3]));
      const double high = std::max(std::max(x[0], x[1]), std::max(x[2], x[3]));
      if (std::max(std::max(y[0], y[1]), y[2]) < low || std::min(std::min(y[0], y[1]), y[2]) > high)
        return true;
    }
  // A plane proves it that has the tet on one side, the triangle on the other, and no more than three corners
  // on it: the faces of the tet,
  for (int k = 0; k < 4; ++k) {
    bool beyond = true;
    for (int j = 0; beyond && j < 3; ++j)
      beyond = shared[j] >= 0 ? shared[j] != k
                              : orient3d(at(tet[kTetFace[k][0]]), at(tet[kTetFace[k][1]]),
                                         at(tet[kTetFace[k][2]]), at(triangle[j])) > 0;
    if (beyond) return true;
  }
  // the triangle,
  int side_of[4], sum = 0, off = 0;
  for (int i = 0; i < 4; ++i) {
    const bool corner = shared[0] == i || shared[1] == i || shared[2] == i;
    side_of[i] = corner ? 0 : orient3d(at(triangle[0]), at(triangle[1]), at(triangle[2]), at(tet[i]));
    sum += side_of[i];
    off += !corner;
  }
  if (std::abs(sum) == off) return true;
  // an edge of the tet and a corner of the triangle,
  for (int j = 0; j < 3; ++j) {
    if (shared[j] >= 0) continue;
    for (int a = 0; a < 4; ++a)
      for (int b = a + 1; b < 4; ++b) {
        int others[2], n = 0;
        for (int c = 0; c < 4; ++c)
          if (c != a && c != b) others[n++] = c;
        bool possible = true;
        for (int m = 0; m < 3; ++m) possible &= shared[m] < 0 || shared[m] == a || shared[m] == b;
        if (!possible) continue;
        const auto side = [&](Index v) { return orient3d(at(tet[a]), at(tet[b]), at(triangle[j]), at(v)); };
        const int s = side(tet[others[0]]);
        if (s == 0 || side(tet[others[1]]) != s) continue;
        bool beyond = true;
        for (int m = 0; beyond && m < 3; ++m)
          if (m != j && shared[m] < 0) beyond = side(triangle[m]) == -s;
        if (beyond) return true;
      }
  }
  // or an edge of the triangle and a corner of the tet.
  for (int j = 0; j < 3; ++j) {
    const int p = (j + 1) % 3, q = (j + 2) % 3;
    if (shared[j] >= 0 || shared[p] >= 0 || shared[q] >= 0) continue;
    for (int a = 0; a < 4; ++a) {
      const auto side = [&](Index v) {
        return orient3d(at(triangle[p]), at(triangle[q]), at(tet[a]), at(v));
      };
      const int s = side(triangle[j]);
      if (s == 0) continue;
      bool beyond = true;
      for (int b = 0; beyond && b < 4; ++b)
        if (b != a) beyond = side(tet[b]) == -s;
      if (beyond) return true;
    }
  }
  return false;
}

namespace {

using Face = CavityFiller::Face;

Face reversed(const Face& f) { return {f[0], f[2], f[1]}; }

// Volume over the cubed mean length of edges, squared: larger is better.
double quality_of(const double* a, const double* b, const double* c, const double* d) {
  double e[3][3], sum = 0;
  const double* p[4] = {a, b, c, d};
  for (int k = 0; k < 3; ++k) {
    e[0][k] = b[k] - a[k], e[1][k] = c[k] - a[k], e[2][k] = d[k] - a[k];
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < i; ++j) sum += (p[i][k] - p[j][k]) * (p[i][k] - p[j][k]);
  }
  const double volume = e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
                        e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
                        e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
  return volume * volume / (sum * sum * sum);
}

}  // namespace

bool CavityFiller::fill(const double* points, const std::vector<Face>& faces, int steps,
                        std::vector<Tet>& out) {
  points_ = points;
  steps_ = steps;
  tets_.clear();
  corners_.clear();
  if (open_.empty()) open_.resize(1), candidates_.resize(1);
  open_[0].clear();
  for (const Face& f : faces) {
    open_[0].push_back(rotated(f));
    corners_.insert(corners_.end(), f.begin(), f.end());
  }
  std::sort(corners_.begin(), corners_.end());
  corners_.erase(std::unique(corners_.begin(), corners_.end()), corners_.end());
  if (!search(0)) return false;
  out = tets_;
  return true;
}

bool CavityFiller::search(std::size_t depth) {
  if (open_[depth].empty()) return true;
  if (open_.size() < depth + 2) open_.resize(depth + 2), candidates_.resize(depth + 2);
  const auto at = [&](Index v) { return points_ + 3 * static_cast<std::size_t>(v); };
  const Face base = open_[depth].back();
  auto& candidates = candidates_[depth];
  candidates.clear();
  for (const Index v : corners_) {
    if (v == base[0] || v == base[1] || v == base[2]) continue;
    if (orient3d(at(base[0]), at(base[1]), at(base[2]), at(v)) <= 0) continue;
    candidates.push_back({quality_of(at(base[0]), at(base[1]), at(base[2]), at(v)), v});
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.quality != b.quality ? a.quality > b.quality : a.corner < b.corner;
  });
  for (std::size_t i = 0; i < candidates_[depth].size(); ++i) {
    if (steps_-- <= 0) return false;
    const Tet tet{base[0], base[1], base[2], candidates_[depth][i].corner};
    const auto& open = open_[depth];
    auto& rest = open_[depth + 1];
    Face sides[4];
    for (int k = 0; k < 4; ++k) sides[k] = rotated(tet_face(tet, k));
    bool matched[4] = {}, taken[4] = {}, fits = true;
    rest.clear();
    std::size_t beside = 0;  // so many of the rest are faces of the tet, seen from the other side
    for (const Face& f : open) {
      const Face back = rotated(reversed(f));
      bool own = false, other = false;
      for (int k = 0; k < 4; ++k) {
        if (sides[k] == f) other = taken[k] = true;
        if (sides[k] == back) own = matched[k] = true;
      }
      if (own) continue;
      rest.push_back(f);
      if (other) std::swap(rest[beside++], rest.back());
    }
    for (int k = 0; k < 4; ++k) fits &= matched[k] || !taken[k];  // else something else lies beyond that face
    for (std::size_t f = beside; fits && f < rest.size(); ++f) fits = apart(points_, tet, rest[f]);
    if (!fits) continue;
    for (int k = 0; k < 4; ++k)
      if (!matched[k]) rest.push_back(sides[k]);
    tets_.push_back(tet);
    if (search(depth + 1)) return true;
    tets_.pop_back();
  }
  return false;
}

}  // namespace overtet
