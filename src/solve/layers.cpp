#include "src/solve/layers.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <unordered_map>
#include <unordered_set>

#include "kernels/core/tet_tables.h"
#include "kernels/fem/elements.h"
#include "src/solve/tuning.h"

namespace overtet::solve_detail {

namespace {

bool contains(const Barycentric& b) { return *std::min_element(b.begin(), b.end()) >= -kInTet; }

unsigned corners_of(const Barycentric& b) {
  unsigned bits = 0;
  for (unsigned k = 0; k < 4; ++k)
    if (b[k] > kHeldCorner) bits |= 1u << k;
  return bits;
}

Barycentric mixed(const Barycentric& a, const Barycentric& b, double s) {
  Barycentric out;
  for (std::size_t k = 0; k < 4; ++k) out[k] = (1 - s) * a[k] + s * b[k];
  return out;
}

// A part of a triangle, by the barycentric coordinates of its corners in the triangle (where) and in a tet.
struct PolygonCorner {
  Eigen::Vector3d where;
  Barycentric in;
};
using PolygonPart = std::vector<PolygonCorner>;

// What of it is on the inner side of the tet's face k [Sutherland and Hodgman 1974].
PolygonPart clipped(const PolygonPart& polygon, std::size_t k) {
  PolygonPart out;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const PolygonCorner &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const double a = p.in[k] + kInTet, b = q.in[k] + kInTet;
    if (a >= 0) out.push_back(p);
    if ((a < 0) != (b < 0)) {
      const double s = a / (a - b);
      out.push_back({(1 - s) * p.where + s * q.where, mixed(p.in, q.in, s)});
    }
  }
  return out;
}

}  // namespace

Result<Layers> Layers::of(const TetMesh& mesh) {
  Layers out(mesh);
  const TetMatrix& T = mesh.T;
  out.neighbour_.setConstant(T.rows(), 4, -1);
  struct Face {
    std::array<Index, 3> corners;
    Index tet;
    int k;
  };
  std::vector<Face> faces;
  faces.reserve(static_cast<std::size_t>(4 * T.rows()));
  for (Index t = 0; t < T.rows(); ++t)
    for (int k = 0; k < 4; ++k) {
      std::array<Index, 3> c = tet_face(T.row(t), k);
      std::sort(c.begin(), c.end());
      faces.push_back({c, t, k});
    }
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
    return a.corners != b.corners ? a.corners < b.corners : a.tet < b.tet;
  });
  for (std::size_t i = 0; i + 1 < faces.size(); ++i) {
    const Face &a = faces[i], &b = faces[i + 1];
    if (a.corners != b.corners) continue;
    if (out.neighbour_(a.tet, a.k) >= 0)
      return Error{ErrorCode::bad_input, "Tet " + std::to_string(b.tet) +
                                             " (counted from 0) has a face that two other tets have, too."};
    out.neighbour_(a.tet, a.k) = b.tet;
    out.neighbour_(b.tet, b.k) = a.tet;
  }
  out.boxes_.build(static_cast<Index>(T.rows()), [&](Index t) {
    Box box;
    for (int k = 0; k < 3; ++k) {
      box.low[k] = box.high[k] = mesh.V(T(t, 0), k);
      for (int c = 1; c < 4; ++c) {
        box.low[k] = std::min(box.low[k], mesh.V(T(t, c), k));
        box.high[k] = std::max(box.high[k], mesh.V(T(t, c), k));
      }
    }
    return box;
  });
  return out;
}

Barycentric Layers::in(Index tet, const Eigen::Vector3d& p) const {
  const TetShape shape = tet_shape(mesh_->V, mesh_->T, tet);
  const Eigen::Vector3d d = p - mesh_->V.row(mesh_->T(tet, 0)).transpose();
  Barycentric b;
  for (int k = 1; k < 4; ++k) b[static_cast<std::size_t>(k)] = shape.gradient.row(k) * d;
  b[0] = 1 - b[1] - b[2] - b[3];
  return b;
}

std::vector<std::vector<Index>> Layers::at(const Eigen::Vector3d& p) const {
  std::vector<Index> tets;
  boxes_.query_box(p.data(), p.data(), [&](Index t) {
    if (contains(in(t, p))) tets.push_back(t);
  });
  std::sort(tets.begin(), tets.end());
  std::vector<std::vector<Index>> out;
  std::vector<char> taken(tets.size(), 0);
  for (std::size_t i = 0; i < tets.size(); ++i) {
    if (taken[i]) continue;
    std::vector<Index> layer{tets[i]};
    taken[i] = 1;
    for (std::size_t n = 0; n < layer.size(); ++n)
      for (int k = 0; k < 4; ++k) {
        const auto found = std::lower_bound(tets.begin(), tets.end(), neighbour_(layer[n], k));
        if (found == tets.end() || *found != neighbour_(layer[n], k)) continue;
        if (char& is = taken[static_cast<std::size_t>(found - tets.begin())]; !is) {
          is = 1;
          layer.push_back(*found);
        }
      }
    std::sort(layer.begin(), layer.end());
    out.push_back(std::move(layer));
  }
  return out;
}

std::vector<Index> Layers::around(Index vertex) const {
  std::vector<Index> out;
  const Eigen::Vector3d p = mesh_->V.row(vertex);
  boxes_.query_box(p.data(), p.data(), [&](Index t) {
    if ((mesh_->T.row(t).array() == vertex).any()) out.push_back(t);
  });
  std::sort(out.begin(), out.end());
  return out;
}

std::vector<Crossed> Layers::segment(const Eigen::Vector3d& p, const Eigen::Vector3d& q,
                                     const std::vector<Index>& begin) const {
  std::vector<Crossed> out;
  // None where begin > end.
  const auto crossed = [&](Index t) {
    const Barycentric a = in(t, p), b = in(t, q);
    Crossed c{t, 0, 0, 1};
    for (std::size_t k = 0; k < 4; ++k) {
      const double from = a[k] + kInTet, to = b[k] + kInTet;
      if (from < 0 && to < 0) c.begin = 2;
      if (from < 0 && to >= 0) c.begin = std::max(c.begin, from / (from - to));
      if (from >= 0 && to < 0) c.end = std::min(c.end, from / (from - to));
    }
    if (c.begin <= c.end) c.corners = corners_of(mixed(a, b, c.begin)) | corners_of(mixed(a, b, c.end));
    return c;
  };
  std::unordered_set<Index> seen(begin.begin(), begin.end());
  for (const Index t : begin) {
    Crossed c = crossed(t);
    if (c.begin <= c.end) out.push_back(c);
  }
  for (std::size_t n = 0; n < out.size(); ++n)
    for (int k = 0; k < 4; ++k) {
      const Index next = neighbour_(out[n].tet, k);
      if (next < 0 || seen.contains(next)) continue;
      const Crossed c = crossed(next);
      if (std::max(c.begin, out[n].begin) > std::min(c.end, out[n].end) + kInTet) continue;
      seen.insert(next);
      if (c.begin <= c.end) out.push_back(c);
    }
  return out;
}

std::vector<Crossed> Layers::triangle(const std::array<Eigen::Vector3d, 3>& corners,
                                      const std::vector<Index>& begin,
                                      std::optional<Eigen::Vector3d>& leaves) const {
  std::vector<Crossed> out;
  std::unordered_set<Index> seen(begin.begin(), begin.end());
  std::vector<Index> list = begin;
  for (std::size_t n = 0; n < list.size(); ++n) {
    const Index t = list[n];
    PolygonPart whole;
    for (std::size_t c = 0; c < 3; ++c)
      whole.push_back({Eigen::Vector3d::Unit(static_cast<int>(c)), in(t, corners[c])});
    PolygonPart part = whole;
    for (std::size_t k = 0; k < 4; ++k) part = clipped(part, k);
    if (part.empty()) continue;
    Crossed crossed{t, 0, 0, 1};
    for (const PolygonCorner& c : part) crossed.corners |= corners_of(c.in);
    out.push_back(crossed);
    for (std::size_t k = 0; k < 4; ++k) {
      const auto at =
          std::find_if(part.begin(), part.end(), [&](const PolygonCorner& c) { return c.in[k] <= kInTet; });
      if (at == part.end()) continue;
      const Index next = neighbour_(t, static_cast<int>(k));
      if (next >= 0) {
        if (seen.insert(next).second) list.push_back(next);
        continue;
      }
      // Does it go on beyond this face of the boundary?
      PolygonPart beyond = whole;
      for (std::size_t other = 0; other < 4; ++other)
        if (other != k) beyond = clipped(beyond, other);
      if (!leaves && std::any_of(beyond.begin(), beyond.end(),
                                 [&](const PolygonCorner& c) { return c.in[k] < -2 * kInTet; }))
        leaves = at->where[0] * corners[0] + at->where[1] * corners[1] + at->where[2] * corners[2];
    }
  }
  return out;
}

}  // namespace overtet::solve_detail
