#include "tests/support/tet_checks/tet_checks.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "kernels/core/tet_tables.h"
#include "kernels/core/triangles.h"
#include "kernels/predicates/predicates.h"
#include "kernels/tet_energy/tet_quality.h"

namespace overtet::test {

namespace {

std::array<Index, 3> outer(const TetComplex::Tet& t, int k) { return rotated(tet_face(t, k)); }

}  // namespace

FaceSet boundary_faces(const TetComplex& c) {
  FaceSet all, boundary;
  for (Index t = 0; t < c.tet_capacity(); ++t)
    if (c.alive(t))
      for (int k = 0; k < 4; ++k) all.insert(outer(c.tet(t), k));
  for (const auto& f : all)
    if (!all.count(rotated(std::array<Index, 3>{f[0], f[2], f[1]}))) boundary.insert(f);
  return boundary;
}

void expect_valid(const TetComplex& c) {
  std::set<std::array<Index, 3>> oriented;
  std::map<std::pair<Index, Index>, double> turn;
  std::map<Index, std::vector<Index>> stars;
  for (Index t = 0; t < c.tet_capacity(); ++t) {
    if (!c.alive(t)) continue;
    const auto& v = c.tet(t);
    ASSERT_EQ(1, orient3d(c.position(v[0]).data(), c.position(v[1]).data(), c.position(v[2]).data(),
                          c.position(v[3]).data()))
        << "tet " << t;
    for (int k = 0; k < 4; ++k) ASSERT_TRUE(oriented.insert(outer(v, k)).second) << "face of tet " << t;
    const auto angle =
        dihedral_angles(c.position(v[0]), c.position(v[1]), c.position(v[2]), c.position(v[3]));
    for (int e = 0; e < 6; ++e) turn[std::minmax({v[kTetEdge[e][0]], v[kTetEdge[e][1]]})] += angle[e];
    for (const Index x : v) stars[x].push_back(t);
  }
  const FaceSet boundary = boundary_faces(c);
  std::set<std::array<Index, 2>> boundary_edges;
  std::set<Index> boundary_vertices;
  for (const auto& f : boundary)
    for (int k = 0; k < 3; ++k) {
      boundary_edges.insert({std::min(f[k], f[(k + 1) % 3]), std::max(f[k], f[(k + 1) % 3])});
      boundary_vertices.insert(f[k]);
    }
  for (const auto& [edge, sum] : turn)
    if (!boundary_edges.count(
            {edge.first, edge.second})) {  // thin tets have inexact angles, but a turn too many is 2 pi
      ASSERT_NEAR(2 * M_PI, sum, 1) << "edge " << edge.first << " " << edge.second;
    }
  for (const auto& [v, star] : stars) {
    std::set<Index> corners;
    std::map<std::array<Index, 2>, int> edges;
    std::map<Index, Index> parent;
    for (const Index t : star) {
      std::vector<Index> f;
      for (const Index x : c.tet(t))
        if (x != v) f.push_back(x);
      for (int k = 0; k < 3; ++k) {
        corners.insert(f[k]);
        ++edges[{std::min(f[k], f[(k + 1) % 3]), std::max(f[k], f[(k + 1) % 3])}];
      }
    }
    for (const Index x : corners) parent[x] = x;
    const auto root = [&](Index x) {
      while (parent[x] != x) x = parent[x];
      return x;
    };
    int open = 0;
    for (const auto& [e, uses] : edges) {
      ASSERT_LE(uses, 2) << "two edges with the same ends at vertex " << v;
      open += uses == 1;
      parent[root(e[0])] = root(e[1]);
    }
    for (const Index x : corners) ASSERT_EQ(root(*corners.begin()), root(x)) << "link of " << v;
    const auto euler =
        static_cast<int>(corners.size()) - static_cast<int>(edges.size()) + static_cast<int>(star.size());
    ASSERT_EQ(boundary_vertices.count(v) ? 1 : 2, euler) << "link of " << v;
    ASSERT_EQ(boundary_vertices.count(v) > 0, open > 0);
  }
}

}  // namespace overtet::test
