#include "src/pipeline/locked_patch.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>

#include "kernels/core/assertions.h"
#include "kernels/core/tuning.h"
#include "src/mesh/tet_complex.h"
#include "src/mesh/topology.h"
#include "src/pipeline/tuning.h"

namespace overtet {

namespace {

class Grower {
 public:
  explicit Grower(const Surface& s) : surface_(s), in_(static_cast<std::size_t>(s.F.rows()), 0) {}

  void add(Index face) { in_[static_cast<std::size_t>(face)] = 1; }
  bool has(Index face) const { return in_[static_cast<std::size_t>(face)] != 0; }

  // Adds all faces that share a vertex with one that is in.
  void grow() {
    std::vector<char> touched(static_cast<std::size_t>(surface_.V.rows()), 0);
    for (Index f = 0; f < surface_.F.rows(); ++f)
      if (has(f))
        for (int k = 0; k < 3; ++k) touched[static_cast<std::size_t>(surface_.F(f, k))] = 1;
    for (Index f = 0; f < surface_.F.rows(); ++f)
      for (int k = 0; k < 3; ++k)
        if (touched[static_cast<std::size_t>(surface_.F(f, k))]) add(f);
  }

  SubSurface result() const {
    std::vector<Index> faces;
    for (Index f = 0; f < surface_.F.rows(); ++f)
      if (has(f)) faces.push_back(f);
    return sub_surface(surface_, std::move(faces));
  }

 private:
  const Surface& surface_;
  std::vector<char> in_;
};

}  // namespace

SubSurface patch_around(const Surface& surface, const std::vector<FacePair>& pairs,
                        const Eigen::Vector3d& place) {
  Grower patch(surface);
  // Nearest by its corners' mean distance: a place on the surface is near some face's corners.
  Index nearest = 0;
  double best = std::numeric_limits<double>::infinity();
  for (Index f = 0; f < surface.F.rows(); ++f) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) sum += (Eigen::Vector3d(surface.V.row(surface.F(f, k))) - place).norm();
    if (sum < best) best = sum, nearest = f;
  }
  patch.add(nearest);
  for (int ring = 0; ring < kRings; ++ring) patch.grow();
  std::vector<Index> crossed;
  for (const auto& [f, g] : pairs) {
    if (patch.has(f)) crossed.push_back(g);
    if (patch.has(g)) crossed.push_back(f);
  }
  for (const Index f : crossed) patch.add(f);
  patch.grow();
  return patch.result();
}

namespace {

LockedSolid cut_out(const TetMesh& mesh, const VertexMatrix& target, const std::vector<char>& in) {
  std::vector<Index> tets;
  for (Index t = 0; t < mesh.T.rows(); ++t)
    if (in[static_cast<std::size_t>(t)]) tets.push_back(t);
  TetMatrix T(static_cast<Eigen::Index>(tets.size()), 4);
  for (std::size_t i = 0; i < tets.size(); ++i) T.row(static_cast<Eigen::Index>(i)) = mesh.T.row(tets[i]);
  const std::vector<std::array<Index, 3>> faces = TetComplex(mesh.V, T).boundary();
  // Numbers: the boundary's vertices first, all in their order.
  enum : char { unused, inside, boundary };
  std::vector<char> kind(static_cast<std::size_t>(mesh.V.rows()), unused);
  for (Index t = 0; t < T.rows(); ++t)
    for (int k = 0; k < 4; ++k) kind[static_cast<std::size_t>(T(t, k))] = inside;
  for (const auto& f : faces)
    for (const Index v : f) kind[static_cast<std::size_t>(v)] = boundary;
  LockedSolid out;
  std::vector<Index> number(kind.size(), -1);
  for (const char wanted : {boundary, inside}) {
    for (std::size_t v = 0; v < kind.size(); ++v)
      if (kind[v] == wanted) {
        number[v] = static_cast<Index>(out.vertices.size());
        out.vertices.push_back(static_cast<Index>(v));
      }
    if (wanted == boundary) out.start.surface_vertices = static_cast<Index>(out.vertices.size());
  }
  out.start.V.resize(static_cast<Eigen::Index>(out.vertices.size()), 3);
  for (std::size_t i = 0; i < out.vertices.size(); ++i)
    out.start.V.row(static_cast<Eigen::Index>(i)) = mesh.V.row(out.vertices[i]);
  out.start.T.resize(T.rows(), 4);
  for (Index t = 0; t < T.rows(); ++t)
    for (int k = 0; k < 4; ++k) out.start.T(t, k) = number[static_cast<std::size_t>(T(t, k))];
  out.target.V = out.start.V.topRows(out.start.surface_vertices);
  for (Index i = 0; i < out.start.surface_vertices; ++i)
    if (const Index v = out.vertices[static_cast<std::size_t>(i)]; v < target.rows())
      out.target.V.row(i) = target.row(v);
  out.target.F.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (int k = 0; k < 3; ++k)
      out.target.F(static_cast<Eigen::Index>(f), k) =
          number[static_cast<std::size_t>(faces[f][static_cast<std::size_t>(k)])];
  return out;
}

// Vertices of a closed surface at which it is pinched: of edges with more than two faces, and those with more
// than one fan.
std::vector<Index> pinched_at(const Surface& s) {
  std::map<std::array<Index, 2>, int> faces;
  std::map<std::array<Index, 2>, Index> next;  // around (vertex, neighbour): the next neighbour
  std::vector<Index> valence(static_cast<std::size_t>(s.V.rows()), 0), pinched;
  for (Index f = 0; f < s.F.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const Index a = s.F(f, k), b = s.F(f, (k + 1) % 3), c = s.F(f, (k + 2) % 3);
      if (++faces[{std::min(a, b), std::max(a, b)}] > 2) pinched.insert(pinched.end(), {a, b});
      next[{a, b}] = c;
      ++valence[static_cast<std::size_t>(a)];
    }
  for (Index f = 0; f < s.F.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const Index v = s.F(f, k), first = s.F(f, (k + 1) % 3);
      Index turned = 1;
      for (auto at = next.find({v, first}); at != next.end() && at->second != first && turned <= s.F.rows();
           at = next.find({v, at->second}))
        ++turned;
      if (turned != valence[static_cast<std::size_t>(v)]) pinched.push_back(v);
    }
  return pinched;
}

}  // namespace

LockedSolid solid_around(const TetMesh& mesh, const VertexMatrix& target, const std::vector<Index>& away) {
  OVERTET_EXPECTS(target.rows() == mesh.surface_vertices);
  std::vector<char> in(static_cast<std::size_t>(mesh.T.rows()), 0);
  const auto add_stars = [&](const std::vector<Index>& seeds) {
    std::vector<char> seed(static_cast<std::size_t>(mesh.V.rows()), 0);
    for (const Index v : seeds) seed[static_cast<std::size_t>(v)] = 1;
    std::vector<Index> corners;
    for (Index t = 0; t < mesh.T.rows(); ++t)
      for (int k = 0; k < 4; ++k)
        if (seed[static_cast<std::size_t>(mesh.T(t, k))]) {
          in[static_cast<std::size_t>(t)] = 1;
          for (int j = 0; j < 4; ++j) corners.push_back(mesh.T(t, j));
          break;
        }
    return corners;
  };
  std::vector<Index> seeds = away;
  for (int ring = 0; ring < kRings; ++ring) seeds = add_stars(seeds);
  for (int repair = 0; repair < kMostRounds; ++repair) {
    LockedSolid patch = cut_out(mesh, target, in);
    std::vector<Index> pinched = pinched_at(patch.target);
    if (pinched.empty() && require_topology(patch.target)) return patch;
    for (Index& v : pinched) v = patch.vertices[static_cast<std::size_t>(v)];
    add_stars(pinched);
  }
  return cut_out(mesh, target, std::vector<char>(in.size(), 1));
}

}  // namespace overtet
