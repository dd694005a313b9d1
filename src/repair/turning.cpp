#include "src/repair/turning.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

#include "kernels/bvh/bvh.h"
#include "kernels/core/box.h"
#include "kernels/core/union_find.h"
#include "kernels/sparse/cholesky.h"
#include "src/exact/winding.h"
#include "src/repair/ray_hit.h"
#include "src/repair/tuning.h"

namespace overtet {

namespace {

using Eigen::Vector3d;

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

// Evenly spread points of a face, more of them the longer it is.
void sample(const Surface& s, Index f, double spacing, std::vector<WallSample>& out) {
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
    out.push_back({f, a + u * (b - a) + v * (c - a), n / twice, {1 - u - v, u, v}, twice / 2 / count});
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

// The nearest of a tree's faces that the ray hits from its front, with barycentric coordinates.
struct Hit {
  Index row = -1;
  double far = 1e300, weights[3] = {};
};

class Walls {
 public:
  Walls(const Surface& surface, const std::vector<Index>& faces)
      : surface_(surface), own_(static_cast<Eigen::Index>(faces.size()), 3) {
    for (std::size_t i = 0; i < faces.size(); ++i)
      own_.row(static_cast<Eigen::Index>(i)) = surface.F.row(faces[i]);
    tree_.build(surface.V, own_);
  }

  Hit opposite(const Vector3d& from, const Vector3d& d, Index but, double slack) const {
    Hit hit;
    const Vector3d p = from + slack * d;
    tree_.query_ray(p.data(), d.data(), slack, [&](Index g) {
      if (g == but) return;
      const auto met = ray_hit(p, d, corner(g, 0), corner(g, 1), corner(g, 2));
      if (!met || met->far > hit.far || (met->far == hit.far && g > hit.row)) return;
      hit = {g, met->far, {1 - met->u - met->v, met->u, met->v}};
    });
    if (hit.row >= 0 &&
        (corner(hit.row, 1) - corner(hit.row, 0)).cross(corner(hit.row, 2) - corner(hit.row, 0)).dot(d) >= 0)
      hit.row = -1;
    return hit;
  }

  Index vertex(Index row, int k) const { return own_(row, k); }

 private:
  Vector3d corner(Index f, int k) const { return surface_.V.row(own_(f, k)); }

  const Surface& surface_;
  TriangleMatrix own_;
  TriangleBvh tree_;
};

class PartFinder {
 public:
  PartFinder(const Surface& surface, const Diagnosis& diagnosis, const RunContext& context)
      : surface_(surface),
        diagnosis_(diagnosis),
        context_(context),
        n_(static_cast<Index>(surface.F.rows())),
        ahead_(kAhead * diagonal_of(surface.V)),
        spacing_(median_edge(surface)),
        winding_(surface, *diagnosis.bvh) {}

  std::vector<InsideOutPart> run() {
    if (!(spacing_ > 0)) return {};
    find_creased();
    find_regions();
    std::stable_sort(parts_.begin(), parts_.end(), [](const InsideOutPart& a, const InsideOutPart& b) {
      return a.negative_area > b.negative_area;
    });
    if (parts_.size() > kMostTried) parts_.resize(kMostTried);
    return std::move(parts_);
  }

 private:
  bool negative(const WallSample& x) const {
    const Vector3d p = x.at + ahead_ * x.normal;
    const auto w = winding_.at(p.data());
    return w && *w < 0;
  }

  Index twin_face(Index h) const { return half_edge_face(diagnosis_.topology.topology.twin[h]); }

  void finish(InsideOutPart part) {
    part.vertices = vertices_of(surface_, part.faces);
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const WallSample& x : part.samples) spread += x.area * x.normal * x.normal.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
    for (int k = 0; k < kAngles; ++k) {
      const double angle = M_PI * k / kAngles;
      part.directions.push_back(std::cos(angle) * axes.eigenvectors().col(2) +
                                std::sin(angle) * axes.eigenvectors().col(1));
    }
    if (!part.creased) part.directions.push_back(axes.eigenvectors().col(0));
    parts_.push_back(std::move(part));
  }

  // What sharp creases cut off and negative winding is in front of.
  void find_creased() {
    std::vector<Vector3d> normal(static_cast<std::size_t>(n_));
    for (Index f = 0; f < n_; ++f) {
      const Vector3d a = surface_.V.row(surface_.F(f, 0)), b = surface_.V.row(surface_.F(f, 1)),
                     c = surface_.V.row(surface_.F(f, 2));
      normal[f] = (b - a).cross(c - a).normalized();
    }
    for (const double crease : kCreases)
      add_connected([&](Index f, Index g) { return normal[f].dot(normal[g]) > crease; });
    // What was pulled long, creases or not.
    std::vector<double> length(static_cast<std::size_t>(n_));
    for (Index f = 0; f < n_; ++f) length[f] = longest_edge(surface_, f);
    for (const double stretch : kStretches)
      add_connected(
          [&](Index f, Index g) { return length[f] > stretch * spacing_ && length[g] > stretch * spacing_; });
  }

  // The sets of faces that edges join, where there is enough negative winding in front of them.
  template <class Joined>
  void add_connected(Joined&& joined) {
    const SurfaceTopology& topology = diagnosis_.topology.topology;
    UnionFind sets(static_cast<std::size_t>(n_));
    for (Index h = 0; h < 3 * n_; ++h) {
      const Index f = half_edge_face(h), g = twin_face(h);
      if (f < g && joined(f, g)) sets.join(f, g);
    }
    std::vector<char> touched(static_cast<std::size_t>(n_), 0);
    for (const auto& [f, g] : diagnosis_.winding.negative_at)
      if (f >= 0) touched[sets.root(f)] = touched[sets.root(g)] = 1;
    std::vector<std::vector<Index>> faces(static_cast<std::size_t>(n_));
    for (Index f = 0; f < n_; ++f)
      if (touched[sets.root(f)]) faces[sets.root(f)].push_back(f);
    for (Index r = 0; r < n_; ++r) {
      if (faces[r].size() < kFewestFaces) continue;
      if (static_cast<Index>(faces[r].size()) > topology.components[topology.component_of_face[r]].faces / 2)
        continue;  // what the rest hangs on
      if (std::any_of(parts_.begin(), parts_.end(),
                      [&](const InsideOutPart& p) { return p.faces == faces[r]; }))
        continue;
      if (context_.stop()) return;
      InsideOutPart part;
      for (const Index f : faces[r]) sample(surface_, f, spacing_, part.samples);
      double all = 0;
      for (const WallSample& x : part.samples) {
        all += x.area;
        if (negative(x)) part.negative_area += x.area;
      }
      if (!(part.negative_area > kNegativeShare * all)) continue;
      part.faces = std::move(faces[r]);
      finish(std::move(part));
    }
  }

  // All walls of a region of negative winding.
  void find_regions() {
    std::vector<Index> list;
    std::vector<char> seen(static_cast<std::size_t>(n_), 0);
    const auto look_at = [&](Index f) {
      if (f >= 0 && !seen[f]) seen[f] = 1, list.push_back(f);
    };
    for (const auto& [f, g] : diagnosis_.winding.negative_at) look_at(f), look_at(g);
    std::vector<WallSample> samples, here;
    std::vector<Index> walls;
    for (std::size_t i = 0; i < list.size() && samples.size() < kMostFlooded; ++i) {
      if (i % 256 == 0 && context_.stop()) return;
      here.clear();
      sample(surface_, list[i], spacing_, here);
      std::erase_if(here, [&](const WallSample& x) { return !negative(x); });
      if (here.empty()) continue;
      samples.insert(samples.end(), here.begin(), here.end());
      walls.push_back(list[i]);
      for (Index h = 3 * list[i]; h < 3 * list[i] + 3; ++h) look_at(twin_face(h));
    }
    std::sort(walls.begin(), walls.end());
    const auto row_of = [&](Index f) {
      const auto i = std::lower_bound(walls.begin(), walls.end(), f);
      return i != walls.end() && *i == f ? static_cast<Index>(i - walls.begin()) : -1;
    };
    const auto rows = static_cast<Index>(walls.size());
    UnionFind sets(static_cast<std::size_t>(rows));
    for (Index i = 0; i < rows; ++i)
      for (Index h = 3 * walls[i]; h < 3 * walls[i] + 3; ++h)
        if (const Index j = row_of(twin_face(h)); j >= 0) sets.join(i, j);
    const Walls all(surface_, walls);
    for (const WallSample& x : samples) {
      const Hit hit = all.opposite(x.at, x.normal, row_of(x.face), ahead_);
      if (hit.row >= 0) sets.join(row_of(x.face), hit.row);
    }
    std::vector<InsideOutPart> found(static_cast<std::size_t>(rows));
    for (Index i = 0; i < rows; ++i) found[sets.root(i)].faces.push_back(walls[i]);
    for (const WallSample& x : samples) {
      InsideOutPart& part = found[sets.root(row_of(x.face))];
      part.samples.push_back(x);
      part.negative_area += x.area;
    }
    for (InsideOutPart& part : found) {
      if (part.faces.size() < kFewestFaces) continue;
      part.creased = false;
      finish(std::move(part));
    }
  }

  const Surface& surface_;
  const Diagnosis& diagnosis_;
  const RunContext& context_;
  const Index n_;
  const double ahead_, spacing_;
  const WindingNumber winding_;
  std::vector<InsideOutPart> parts_;
};

}  // namespace

std::vector<InsideOutPart> inside_out_parts(const Surface& surface, const Diagnosis& diagnosis,
                                            const RunContext& context) {
  if (!diagnosis.complete()) return {};
  return PartFinder(surface, diagnosis, context).run();
}

Turn turned(const Surface& surface, const InsideOutPart& part, const Vector3d& along, double thickness,
            double thin) {
  const double slack = 1e-9 * diagonal_of(surface.V);
  const Walls walls(surface, part.faces);
  const auto n = static_cast<int>(part.vertices.size());
  const auto column = [&](Index v) {
    return static_cast<int>(std::lower_bound(part.vertices.begin(), part.vertices.end(), v) -
                            part.vertices.begin());
  };
  // Opposite points: what they are combinations of, how far apart, and how much they count.
  struct Pair {
    int id[6];
    double part[6], distance, sign, weight;
  };
  std::vector<Pair> pairs;
  double total = 0, thickest = 0;
  for (const WallSample& x : part.samples) {
    total += x.area;
    const double facing = x.normal.dot(along);
    if (std::fabs(facing) < kGrazing) continue;
    const auto own = static_cast<Index>(std::lower_bound(part.faces.begin(), part.faces.end(), x.face) -
                                        part.faces.begin());
    const double sign = facing > 0 ? 1 : -1;
    const Hit hit = walls.opposite(x.at, sign * along, own, slack);
    if (hit.row < 0) continue;
    thickest = std::max(thickest, hit.far);
    Pair p;
    for (int k = 0; k < 3; ++k) {
      p.id[k] = column(surface.F(x.face, k)), p.part[k] = x.weights[k];
      p.id[3 + k] = column(walls.vertex(hit.row, k)), p.part[3 + k] = -hit.weights[k];
    }
    p.distance = hit.far, p.sign = sign, p.weight = x.area * std::fabs(facing);
    pairs.push_back(p);
  }
  Turn out;
  if (!(thickest > thin)) return out;
  std::vector<Eigen::Triplet<double>> entries;
  VertexMatrix right = VertexMatrix::Zero(n, 3);
  for (const Pair& p : pairs) {
    const double want = p.sign * (p.distance + thickness * (part.creased ? p.distance : thickest));
    for (int a = 0; a < 6; ++a) {
      right(p.id[a], 0) += p.weight * p.part[a] * want;
      for (int b = 0; b < 6; ++b)
        if (p.id[a] >= p.id[b]) entries.emplace_back(p.id[a], p.id[b], p.weight * p.part[a] * p.part[b]);
    }
  }
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
