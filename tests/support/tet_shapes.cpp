#include "tests/support/tet_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <vector>

namespace overtet::test {

namespace {

Surface from_lists(const std::vector<Eigen::Vector3d>& V, const std::vector<std::array<Index, 3>>& F) {
  Surface s;
  s.V.resize(V.size(), 3);
  s.F.resize(F.size(), 3);
  for (std::size_t i = 0; i < V.size(); ++i) s.V.row(i) = V[i];
  for (std::size_t i = 0; i < F.size(); ++i) s.F.row(i) << F[i][0], F[i][1], F[i][2];
  return s;
}

}  // namespace

Surface box_surface(double x, double y, double z) {
  std::vector<Eigen::Vector3d> V;
  for (int i = 0; i < 8; ++i) V.emplace_back(i & 1 ? x : 0, i & 2 ? y : 0, i & 4 ? z : 0);
  return from_lists(V, {{0, 2, 3},
                        {0, 3, 1},
                        {4, 5, 7},
                        {4, 7, 6},
                        {0, 1, 5},
                        {0, 5, 4},
                        {2, 6, 7},
                        {2, 7, 3},
                        {0, 4, 6},
                        {0, 6, 2},
                        {1, 3, 7},
                        {1, 7, 5}});
}

Surface sphere_surface(int subdivisions) {
  const double t = (1 + std::sqrt(5.0)) / 2;
  std::vector<Eigen::Vector3d> V = {{-1, t, 0}, {1, t, 0}, {-1, -t, 0}, {1, -t, 0},
                                    {0, -1, t}, {0, 1, t}, {0, -1, -t}, {0, 1, -t},
                                    {t, 0, -1}, {t, 0, 1}, {-t, 0, -1}, {-t, 0, 1}};
  for (auto& p : V) p.normalize();
  std::vector<std::array<Index, 3>> F = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                         {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                         {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                         {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (int s = 0; s < subdivisions; ++s) {
    std::map<std::pair<Index, Index>, Index> middle;
    const auto mid = [&](Index a, Index b) {
      const auto [at, fresh] = middle.try_emplace(std::minmax(a, b), static_cast<Index>(V.size()));
      if (fresh) V.push_back((V[a] + V[b]).normalized());
      return at->second;
    };
    std::vector<std::array<Index, 3>> finer;
    for (const auto& f : F) {
      const Index a = mid(f[0], f[1]), b = mid(f[1], f[2]), c = mid(f[2], f[0]);
      finer.insert(finer.end(), {{f[0], a, c}, {f[1], b, a}, {f[2], c, b}, {a, b, c}});
    }
    F = finer;
  }
  return from_lists(V, F);
}

Surface torus_surface(int around, int across, double R, double r) {
  std::vector<Eigen::Vector3d> V;
  std::vector<std::array<Index, 3>> F;
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double u = 2 * M_PI * i / around, v = 2 * M_PI * j / across;
      V.emplace_back((R + r * std::cos(v)) * std::cos(u), (R + r * std::cos(v)) * std::sin(u),
                     r * std::sin(v));
      const auto at = [&](int a, int b) { return static_cast<Index>((a % around) * across + b % across); };
      F.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      F.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return from_lists(V, F);
}

TetMesh grid_tets(int n, double jitter, unsigned seed) { return grid_tets(n, n, n, jitter, seed); }

TetMesh bent_grid(int n, double degrees, double jitter, unsigned seed) {
  const int nx = static_cast<int>(degrees / 20) + n;
  TetMesh mesh = grid_tets(nx, n, n, jitter, seed);
  for (Eigen::Index v = 0; v < mesh.V.rows(); ++v) {
    const double angle = mesh.V(v, 0) / nx * degrees * M_PI / 180;
    const double radius = 1.5 + mesh.V(v, 1) / n;
    mesh.V.row(v) << radius * std::sin(angle), radius * std::cos(angle), mesh.V(v, 2) / n;
  }
  return mesh;
}

TetMesh grid_tets(int nx, int ny, int nz, double jitter, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> offset(-jitter, jitter);
  TetMesh mesh;
  mesh.V.resize((nx + 1) * (ny + 1) * (nz + 1), 3);
  const auto at = [=](int x, int y, int z) { return static_cast<Index>((z * (ny + 1) + y) * (nx + 1) + x); };
  for (int z = 0; z <= nz; ++z)
    for (int y = 0; y <= ny; ++y)
      for (int x = 0; x <= nx; ++x) {
        const bool inside = x > 0 && x < nx && y > 0 && y < ny && z > 0 && z < nz;
        Eigen::RowVector3d p(x, y, z);
        if (inside)
          for (int k = 0; k < 3; ++k) p[k] += offset(random);
        mesh.V.row(at(x, y, z)) = p;
      }
  mesh.T.resize(6 * nx * ny * nz, 4);
  int row = 0;
  const int axes[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x)
        for (const auto& axis : axes) {
          std::array<int, 3> p{x, y, z};
          std::array<Index, 4> t{at(x, y, z), 0, 0, 0};
          for (int k = 0; k < 3; ++k) {
            ++p[axis[k]];
            t[k + 1] = at(p[0], p[1], p[2]);
          }
          const bool even = (axis[1] - axis[0] + 3) % 3 == 1;
          if (!even) std::swap(t[2], t[3]);
          mesh.T.row(row++) << t[0], t[1], t[2], t[3];
        }
  return mesh;
}

TetMesh surface_first(const TetMesh& mesh) {
  const auto n = static_cast<Index>(mesh.V.rows());
  std::map<std::array<Index, 3>, int> faces;
  for (Eigen::Index t = 0; t < mesh.T.rows(); ++t)
    for (int k = 0; k < 4; ++k) {
      std::array<Index, 3> f{mesh.T(t, (k + 1) % 4), mesh.T(t, (k + 2) % 4), mesh.T(t, (k + 3) % 4)};
      std::sort(f.begin(), f.end());
      ++faces[f];
    }
  std::vector<char> outside(static_cast<std::size_t>(n), 0);
  for (const auto& [f, count] : faces)
    if (count == 1)
      for (const Index v : f) outside[v] = 1;
  std::vector<Index> order(static_cast<std::size_t>(n)), number(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  const auto begin_inside =
      std::stable_partition(order.begin(), order.end(), [&](Index v) { return outside[v] != 0; });
  TetMesh out = mesh;
  out.surface_vertices = static_cast<Index>(begin_inside - order.begin());
  for (Index i = 0; i < n; ++i) {
    number[order[i]] = i;
    out.V.row(i) = mesh.V.row(order[i]);
  }
  for (Eigen::Index i = 0; i < out.T.size(); ++i) out.T.data()[i] = number[mesh.T.data()[i]];
  return out;
}

}  // namespace overtet::test
