#include "kernels/laplacian/laplacian.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <deque>

#include "kernels/core/assertions.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"

namespace overtet {

namespace {

Eigen::Vector3d row(const VertexMatrix& V, Index v) { return V.row(v).transpose(); }

struct Entry {
  std::int64_t key;  // column-major position: larger index is the row
  double weight;
};

// What the entries of an edge come to: their sum, or the weight of an equilateral mesh.
enum class Sum { weights, one };

// Sums entries of equal edges in the order given and builds L from them.
SymmetricMatrix assemble(Index vertices, std::vector<Entry>& entries, double smallest, Sum sum_as) {
  std::stable_sort(entries.begin(), entries.end(),
                   [](const Entry& a, const Entry& b) { return a.key < b.key; });
  std::size_t unique = 0;
  for (std::size_t i = 0; i < entries.size(); ++unique) {
    double sum = 0;
    const std::int64_t key = entries[i].key;
    for (; i < entries.size() && entries[i].key == key; ++i) sum += entries[i].weight;
    entries[unique] = {key, sum_as == Sum::one ? 1 / std::sqrt(3.0) : std::max(sum, smallest)};
  }
  entries.resize(unique);
  std::vector<double> diagonal(static_cast<std::size_t>(vertices), 0.0);
  SymmetricMatrix L(vertices, vertices);
  L.resizeNonZeros(static_cast<Eigen::Index>(unique) + vertices);
  int* outer = L.outerIndexPtr();
  int* inner = L.innerIndexPtr();
  double* value = L.valuePtr();
  std::size_t next = 0;
  int at = 0;
  for (Index c = 0; c < vertices; ++c) {
    outer[c] = at;
    inner[at++] = c;
    for (; next < unique && entries[next].key / vertices == c; ++next) {
      const Index r = static_cast<Index>(entries[next].key % vertices);
      const double w = entries[next].weight;
      inner[at] = r;
      value[at++] = -w;
      diagonal[c] += w;
      diagonal[r] += w;
    }
  }
  outer[vertices] = at;
  for (Index c = 0; c < vertices; ++c) value[outer[c]] = diagonal[c];
  return L;
}

std::int64_t edge_key(Index a, Index b, Index vertices) {
  return static_cast<std::int64_t>(std::min(a, b)) * vertices + std::max(a, b);
}

// Half cotangents from edge lengths (l[k] opposite to corner k).
std::array<double, 3> half_cotangents_from_lengths(const std::array<double, 3>& l) {
  // Heron's formula in Kahan's stable order.
  std::array<double, 3> s = l;
  std::sort(s.begin(), s.end(), std::greater<>());
  const double p =
      (s[0] + (s[1] + s[2])) * (s[2] - (s[0] - s[1])) * (s[2] + (s[0] - s[1])) * (s[0] + (s[1] - s[2]));
  const double area4 = std::max(std::sqrt(std::max(p, 0.0)), 2 * kAreaFloor * s[0] * s[0]);  // 4 area
  if (!(area4 > 0)) return {0, 0, 0};
  std::array<double, 3> c;
  for (int k = 0; k < 3; ++k) {
    const double a = l[k], b = l[(k + 1) % 3], d = l[(k + 2) % 3];
    c[k] = 0.5 * (b * b + d * d - a * a) / area4;
  }
  return c;
}

}  // namespace

VertexMatrix half_cotangents(const VertexMatrix& V, const TriangleMatrix& F) {
  VertexMatrix C(F.rows(), 3);
  parallel_for(F.rows(), kLightGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t f = begin; f < end; ++f) {
      const Eigen::Vector3d p[3] = {row(V, F(f, 0)), row(V, F(f, 1)), row(V, F(f, 2))};
      const Eigen::Vector3d e[3] = {p[2] - p[1], p[0] - p[2], p[1] - p[0]};
      const double longest = std::max({e[0].squaredNorm(), e[1].squaredNorm(), e[2].squaredNorm()});
      const double area2 = std::max(e[0].cross(e[1]).norm(), kAreaFloor * longest);
      for (int k = 0; k < 3; ++k)
        C(f, k) = area2 > 0 ? -0.5 * e[(k + 1) % 3].dot(e[(k + 2) % 3]) / area2 : 0.0;
    }
  });
  return C;
}

SymmetricMatrix cotangent_laplacian(const VertexMatrix& V, const TriangleMatrix& F, double smallest_weight) {
  const VertexMatrix C = half_cotangents(V, F);
  const Index n = static_cast<Index>(V.rows());
  std::vector<Entry> entries;
  entries.reserve(static_cast<std::size_t>(3 * F.rows()));
  for (Eigen::Index f = 0; f < F.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      entries.push_back({edge_key(F(f, (k + 1) % 3), F(f, (k + 2) % 3), n), C(f, k)});
  return assemble(n, entries, smallest_weight, Sum::weights);
}

SymmetricMatrix uniform_laplacian(Index vertices, const TriangleMatrix& F) {
  std::vector<Entry> entries;
  entries.reserve(static_cast<std::size_t>(3 * F.rows()));
  for (Eigen::Index f = 0; f < F.rows(); ++f)
    for (int k = 0; k < 3; ++k) entries.push_back({edge_key(F(f, k), F(f, (k + 1) % 3), vertices), 1.0});
  return assemble(vertices, entries, 0, Sum::one);
}

namespace {

// A triangulation of a surface by its edges' lengths, whose edges can be flipped without moving anything.
class IntrinsicTriangulation {
 public:
  IntrinsicTriangulation(const VertexMatrix& V, const TriangleMatrix& F)
      : vertices_(static_cast<Index>(V.rows())),
        faces_(static_cast<std::size_t>(F.rows())),
        corner_(3 * faces_),
        length_(3 * faces_),
        twin_(3 * faces_, -1) {
    std::vector<std::pair<std::int64_t, std::int64_t>> sides(3 * faces_);
    for (std::size_t f = 0; f < faces_; ++f) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Index a = F(f, (k + 1) % 3), b = F(f, (k + 2) % 3);
        corner_[3 * f + k] = F(f, k);
        length_[3 * f + k] = (V.row(a) - V.row(b)).norm();
        sides[3 * f + k] = {edge_key(a, b, vertices_), static_cast<std::int64_t>(3 * f + k)};
      }
    }
    std::sort(sides.begin(), sides.end());
    for (std::size_t i = 0; i < sides.size();) {
      std::size_t j = i;
      while (j < sides.size() && sides[j].first == sides[i].first) ++j;
      OVERTET_EXPECTS(j - i <= 2);
      if (j - i == 2)
        twin_[sides[i].second] = sides[i + 1].second, twin_[sides[i + 1].second] = sides[i].second;
      i = j;
    }
  }

  // Until every edge is Delaunay, or after so many flips.
  void make_delaunay(std::int64_t most_flips) {
    std::deque<std::int64_t> queue;
    std::vector<char> queued(3 * faces_, 0);
    const auto push = [&](std::int64_t side) {
      if (twin_[side] < 0) return;
      const std::int64_t s = std::min(side, twin_[side]);
      if (!queued[s]) queued[s] = 1, queue.push_back(s);
    };
    for (std::size_t s = 0; s < 3 * faces_; ++s) push(static_cast<std::int64_t>(s));
    while (!queue.empty() && most_flips > 0) {
      const std::int64_t s = queue.front();
      queue.pop_front();
      queued[s] = 0;
      const std::int64_t t = twin_[s];
      if (t < 0 || s / 3 == t / 3) continue;
      // Rounding alone must not flip to and fro: cocircular pairs stay.
      if (weight(s) + weight(t) >= -1e-12 || !flip(s)) continue;
      --most_flips;
      for (int k = 0; k < 3; ++k) push(s / 3 * 3 + k), push(t / 3 * 3 + k);
    }
  }

  SymmetricMatrix laplacian() const {
    std::vector<Entry> entries;
    entries.reserve(3 * faces_);
    for (std::size_t f = 0; f < faces_; ++f) {
      const auto c = half_cotangents_from_lengths({length_[3 * f], length_[3 * f + 1], length_[3 * f + 2]});
      for (std::size_t k = 0; k < 3; ++k) {
        const Index a = corner_[3 * f + (k + 1) % 3], b = corner_[3 * f + (k + 2) % 3];
        if (a != b) entries.push_back({edge_key(a, b, vertices_), c[k]});
      }
    }
    return assemble(vertices_, entries, 0, Sum::weights);
  }

 private:
  double weight(std::int64_t side) const {
    const std::int64_t f = side / 3 * 3;
    return half_cotangents_from_lengths({length_[f], length_[f + 1], length_[f + 2]})[side - f];
  }

  void set(std::int64_t face, const std::array<Index, 3>& v, const std::array<double, 3>& l,
           const std::array<std::int64_t, 3>& twins) {
    for (int k = 0; k < 3; ++k) {
      corner_[face + k] = v[k];
      length_[face + k] = l[k];
      twin_[face + k] = twins[k];
      if (twins[k] >= 0) twin_[twins[k]] = face + k;
    }
  }

  // Faces (c, a, b) and (d, b, a) around side a-b become (c, a, d) and (d, b, c). False where rounding leaves
  // no room for the new edge.
  bool flip(std::int64_t s) {
    const std::int64_t t = twin_[s], f = s / 3 * 3, g = t / 3 * 3;
    const std::int64_t fa = f + (s - f + 1) % 3, fb = f + (s - f + 2) % 3;  // corners a, b of f
    const std::int64_t gb = g + (t - g + 1) % 3, ga = g + (t - g + 2) % 3;  // corners b, a of g
    const Index a = corner_[fa], b = corner_[fb], c = corner_[s], d = corner_[t];
    const double ab = length_[s], bc = length_[fa], ca = length_[fb], ad = length_[gb], db = length_[ga];
    // Lay the two triangles out in the plane: a at 0, b at (ab, 0), c above, d below.
    const double xc = (ab * ab + ca * ca - bc * bc) / (2 * ab), xd = (ab * ab + ad * ad - db * db) / (2 * ab);
    const double yc = std::sqrt(std::max(ca * ca - xc * xc, 0.0)),
                 yd = std::sqrt(std::max(ad * ad - xd * xd, 0.0));
    const double cd = std::hypot(xc - xd, yc + yd);
    if (!std::isfinite(cd) || !(cd > 0)) return false;
    // A side glued to another side of the same two faces needs its partner's new name.
    const auto renamed = [&](std::int64_t side) {
      if (side == fa) return g + 0;
      if (side == fb) return f + 2;
      if (side == gb) return f + 0;
      if (side == ga) return g + 2;
      return side;
    };
    // f = (c, a, d): sides ad, dc, ca. g = (d, b, c): sides bc, cd, db.
    const std::int64_t n_ad = renamed(twin_[gb]), n_ca = renamed(twin_[fb]);
    const std::int64_t n_bc = renamed(twin_[fa]), n_db = renamed(twin_[ga]);
    set(f, {c, a, d}, {ad, cd, ca}, {n_ad, g + 1, n_ca});
    set(g, {d, b, c}, {bc, cd, db}, {n_bc, f + 1, n_db});
    return true;
  }

  // Side 3 f + k lies opposite to corner k of face f, from corner k+1 to corner k+2.
  Index vertices_;
  std::size_t faces_;
  std::vector<Index> corner_;
  std::vector<double> length_;
  std::vector<std::int64_t> twin_;  // -1: none
};

}  // namespace

SymmetricMatrix intrinsic_delaunay_laplacian(const VertexMatrix& V, const TriangleMatrix& F) {
  IntrinsicTriangulation triangulation(V, F);
  triangulation.make_delaunay(30 * (3 * F.rows() / 2));
  return triangulation.laplacian();
}

Eigen::VectorXd lumped_mass(const VertexMatrix& V, const TriangleMatrix& F) {
  Eigen::VectorXd area(F.rows());
  parallel_for(F.rows(), kLightGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t f = begin; f < end; ++f) {
      const Eigen::Vector3d a = row(V, F(f, 0));
      area[f] = 0.5 * (row(V, F(f, 1)) - a).cross(row(V, F(f, 2)) - a).norm();
    }
  });
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(V.rows());
  for (Eigen::Index f = 0; f < F.rows(); ++f)
    for (int k = 0; k < 3; ++k) mass[F(f, k)] += area[f] / 3;
  return mass;
}

double surface_area(const VertexMatrix& V, const TriangleMatrix& F) {
  return parallel_reduce(
      F.rows(), kLightGrain / 2, 0.0,
      [&](std::int64_t begin, std::int64_t end) {
        double sum = 0;
        for (std::int64_t f = begin; f < end; ++f) {
          const Eigen::Vector3d a = row(V, F(f, 0));
          sum += 0.5 * (row(V, F(f, 1)) - a).cross(row(V, F(f, 2)) - a).norm();
        }
        return sum;
      },
      [](double a, double b) { return a + b; });
}

}  // namespace overtet
