#include "src/repair/turning.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "kernels/bvh/bvh.h"
#include "kernels/sparse/cholesky.h"
#include "src/surface/winding.h"

namespace overtet {

namespace {

using Eigen::Vector3d;

// Faces whose normals make a larger angle than this belong to different parts: where an inside-out part
// begins, the normals jump. No single threshold fits all surfaces, so each gives candidates.
constexpr double kCreases[] = {0.0, 0.3, 0.5, 0.7, 0.85, 0.95};  // cosines
// Of a part's area that must have negative winding in front: the rest may lie inside other parts.
constexpr double kNegativeShare = 0.25;
constexpr std::size_t kMostParts = 8;
constexpr int kMostSamples = 40;  // of one face
constexpr std::size_t kFewestFaces = 4;
constexpr double kAhead = 1e-6;    // of the diagonal: in front of a face
constexpr double kGrazing = 0.05;  // cosine between a direction and a normal: no wall across it
constexpr double kStay = 1e-3;     // how strongly vertices stay where no pair of walls moves them

struct Sample {
  Vector3d at, normal;
  double part[3];  // barycentric
  double area = 0;
};

double longest_edge(const Surface& s, Index f) {
  double most = 0;
  for (int k = 0; k < 3; ++k)
    most = std::max(most, (s.V.row(s.F(f, k)) - s.V.row(s.F(f, (k + 1) % 3))).norm());
  return most;
}

double median_edge(const Surface& s) {
  std::vector<double> length;
  for (Index f = 0; f < s.F.rows(); ++f) length.push_back((s.V.row(s.F(f, 0)) - s.V.row(s.F(f, 1))).norm());
  std::nth_element(length.begin(), length.begin() + static_cast<std::ptrdiff_t>(length.size() / 2),
                   length.end());
  return length[length.size() / 2];
}

double diagonal_of(const Surface& s) { return (s.V.colwise().maxCoeff() - s.V.colwise().minCoeff()).norm(); }

// Evenly spread points of a face, more of them the longer it is.
void sample(const Surface& s, Index f, double spacing, std::vector<Sample>& out) {
  const Vector3d a = s.V.row(s.F(f, 0)), b = s.V.row(s.F(f, 1)), c = s.V.row(s.F(f, 2));
  const Vector3d n = (b - a).cross(c - a);
  const double twice = n.norm();
  if (!(twice > 0)) return;
  const int count =
      std::clamp(static_cast<int>(std::min(longest_edge(s, f) / spacing, 1e3)), 1, kMostSamples);
  for (int i = 0; i < count; ++i) {
    // The plastic number's sequence, folded into the triangle.
    double u = 1. / 3, v = 1. / 3;
    if (count > 1) {
      u = std::fmod(0.5 + 0.7548776662466927 * (i + 1), 1.0);
      v = std::fmod(0.5 + 0.5698402909980532 * (i + 1), 1.0);
      if (u + v > 1) u = 1 - u, v = 1 - v;
    }
    out.push_back({a + u * (b - a) + v * (c - a), n / twice, {1 - u - v, u, v}, twice / 2 / count});
  }
}

std::vector<Index> vertices_of(const Surface& s, const std::vector<Index>& faces) {
  std::vector<Index> all;
  for (const Index f : faces)
    for (int k = 0; k < 3; ++k) all.push_back(s.F(f, k));
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

}  // namespace

std::vector<InsideOutPart> inside_out_parts(const Surface& surface, const Diagnosis& diagnosis,
                                            const RunContext& context) {
  std::vector<InsideOutPart> parts;
  const Index n = static_cast<Index>(surface.F.rows());
  const SurfaceTopology& topology = diagnosis.topology.topology;
  const double diagonal = diagonal_of(surface), spacing = median_edge(surface);
  if (!diagnosis.bvh || !(spacing > 0)) return parts;
  const WindingNumber winding(surface, *diagnosis.bvh);
  std::vector<Vector3d> normal(static_cast<std::size_t>(n));
  for (Index f = 0; f < n; ++f) {
    const Vector3d a = surface.V.row(surface.F(f, 0)), b = surface.V.row(surface.F(f, 1)),
                   c = surface.V.row(surface.F(f, 2));
    normal[f] = (b - a).cross(c - a).normalized();
  }
  for (const double crease : kCreases) {
    std::vector<Index> parent(static_cast<std::size_t>(n));
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](Index i) {
      while (parent[i] != i) i = parent[i] = parent[parent[i]];
      return i;
    };
    for (Index h = 0; h < 3 * n; ++h) {
      const Index f = half_edge_face(h), g = half_edge_face(topology.twin[h]);
      if (f < g && normal[f].dot(normal[g]) > crease) parent[root(f)] = root(g);
    }
    std::vector<char> touched(static_cast<std::size_t>(n), 0);
    for (const auto& [f, g] : diagnosis.winding.negative_at)
      if (f >= 0) touched[root(f)] = touched[root(g)] = 1;
    std::vector<std::vector<Index>> faces(static_cast<std::size_t>(n));
    for (Index f = 0; f < n; ++f)
      if (touched[root(f)]) faces[root(f)].push_back(f);
    for (Index r = 0; r < n; ++r) {
      if (faces[r].size() < kFewestFaces) continue;
      if (static_cast<Index>(faces[r].size()) > topology.components[topology.component_of_face[r]].faces / 2)
        continue;  // what the rest hangs on
      if (std::any_of(parts.begin(), parts.end(),
                      [&](const InsideOutPart& p) { return p.faces == faces[r]; }))
        continue;
      if (context.stop()) return {};
      std::vector<Sample> samples;
      for (const Index f : faces[r]) sample(surface, f, spacing, samples);
      double all = 0, negative = 0;
      Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
      for (const Sample& x : samples) {
        const Vector3d ahead = x.at + kAhead * diagonal * x.normal;
        const auto w = winding.at(ahead.data());
        all += x.area;
        if (w && *w < 0) negative += x.area;
        spread += x.area * x.normal * x.normal.transpose();
      }
      if (!(negative > kNegativeShare * all)) continue;
      InsideOutPart part;
      part.vertices = vertices_of(surface, faces[r]);
      part.faces = std::move(faces[r]);
      part.negative_area = negative;
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
      part.across[0] = axes.eigenvectors().col(2);
      part.across[1] = axes.eigenvectors().col(1);
      parts.push_back(std::move(part));
    }
  }
  std::stable_sort(parts.begin(), parts.end(), [](const InsideOutPart& a, const InsideOutPart& b) {
    return a.negative_area > b.negative_area;
  });
  if (parts.size() > kMostParts) parts.resize(kMostParts);
  return parts;
}

Turn turned(const Surface& surface, const InsideOutPart& part, double angle, double thickness, double thin) {
  const double diagonal = diagonal_of(surface), spacing = median_edge(surface);
  const Vector3d along = std::cos(angle) * part.across[0] + std::sin(angle) * part.across[1];
  TriangleMatrix own(static_cast<Eigen::Index>(part.faces.size()), 3);
  std::vector<Sample> samples;
  std::vector<Index> face_of;
  for (std::size_t i = 0; i < part.faces.size(); ++i) {
    own.row(static_cast<Eigen::Index>(i)) = surface.F.row(part.faces[i]);
    sample(surface, part.faces[i], spacing, samples);
    face_of.resize(samples.size(), static_cast<Index>(i));
  }
  const TriangleBvh tree(surface.V, own);
  const auto corner = [&](Index f, int k) { return Vector3d(surface.V.row(own(f, k))); };
  const auto n = static_cast<int>(part.vertices.size());
  const auto column = [&](Index v) {
    return static_cast<int>(std::lower_bound(part.vertices.begin(), part.vertices.end(), v) -
                            part.vertices.begin());
  };
  std::vector<Eigen::Triplet<double>> entries;
  VertexMatrix right = VertexMatrix::Zero(n, 3);
  double total = 0, thickest = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Sample& x = samples[i];
    total += x.area;
    const double facing = x.normal.dot(along);
    if (std::fabs(facing) < kGrazing) continue;
    const double sign = facing > 0 ? 1 : -1;
    const Vector3d d = sign * along, p = x.at + 1e-9 * diagonal * d;
    double nearest = 1e300, u = 0, v = 0;
    Index hit = -1;
    tree.query_ray(p.data(), d.data(), 1e-9 * diagonal, [&](Index g) {
      if (g == face_of[i]) return;
      const Vector3d a = corner(g, 0), e1 = corner(g, 1) - a, e2 = corner(g, 2) - a, q = d.cross(e2),
                     t = p - a;
      const double det = e1.dot(q);
      if (!(det != 0)) return;
      const double s1 = t.dot(q) / det, s2 = d.dot(t.cross(e1)) / det, far = e2.dot(t.cross(e1)) / det;
      if (s1 >= 0 && s2 >= 0 && s1 + s2 <= 1 && far > 0 && far < nearest)
        nearest = far, hit = g, u = s1, v = s2;
    });
    if (hit < 0 || (corner(hit, 1) - corner(hit, 0)).cross(corner(hit, 2) - corner(hit, 0)).dot(d) >= 0)
      continue;
    thickest = std::max(thickest, nearest);
    const double weight = x.area * std::fabs(facing), want = sign * nearest * (1 + thickness);
    const double other[3] = {1 - u - v, u, v};
    int id[6];
    double part_of[6];
    for (int k = 0; k < 3; ++k) {
      id[k] = column(own(face_of[i], k)), part_of[k] = x.part[k];
      id[3 + k] = column(own(hit, k)), part_of[3 + k] = -other[k];
    }
    for (int a = 0; a < 6; ++a) {
      right(id[a], 0) += weight * part_of[a] * want;
      for (int b = 0; b < 6; ++b)
        if (id[a] >= id[b]) entries.emplace_back(id[a], id[b], weight * part_of[a] * part_of[b]);
    }
  }
  Turn out;
  if (!(thickest > thin)) return out;
  for (int i = 0; i < n; ++i) entries.emplace_back(i, i, kStay * total / n);
  SymmetricMatrix Q(n, n);
  Q.setFromTriplets(entries.begin(), entries.end());
  Q.makeCompressed();
  SparseCholesky factor;
  VertexMatrix moves;
  if (!factor.analyze(Q) || !factor.factor(Q) || !factor.solve(right, moves) || !moves.allFinite())
    return out;
  out.vertices = part.vertices;
  out.to.resize(n, 3);
  for (int i = 0; i < n; ++i) {
    out.to.row(i) = surface.V.row(part.vertices[i]) + moves(i, 0) * along.transpose();
    out.farthest = std::max(out.farthest, std::fabs(moves(i, 0)));
  }
  return out;
}

}  // namespace overtet
