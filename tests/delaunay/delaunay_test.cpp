#include "kernels/delaunay/delaunay.h"
#include "kernels/core/tet_tables.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <random>
#include <set>

#include "kernels/delaunay/cavity.h"
#include "kernels/predicates/predicates.h"

namespace overtet {
namespace {

using Tet = std::array<Index, 4>;
using Triple = std::array<Index, 3>;

const double* row(const VertexMatrix& V, Index v) { return V.data() + 3 * v; }

VertexMatrix random_points(int n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  VertexMatrix V(n, 3);
  for (Eigen::Index i = 0; i < V.size(); ++i) V.data()[i] = uniform(random);
  return V;
}

VertexMatrix grid(int n) {
  VertexMatrix V(n * n * n, 3);
  for (int i = 0; i < n * n * n; ++i) V.row(i) << i % n, i / n % n, i / n / n;
  return V;
}

double volume(const VertexMatrix& V, const Tet& t) {
  const Eigen::RowVector3d a = V.row(t[0]), b = V.row(t[1]), c = V.row(t[2]), d = V.row(t[3]);
  return (b - a).cross(c - a).dot(d - a) / 6;
}

void expect_sound(const VertexMatrix& V, const TetArrays& mesh) {
  std::map<Triple, int> faces;
  for (std::size_t t = 0; t < mesh.tet.size(); ++t) {
    const Tet& c = mesh.tet[t];
    ASSERT_GT(orient3d(row(V, c[0]), row(V, c[1]), row(V, c[2]), row(V, c[3])), 0);
    for (int k = 0; k < 4; ++k) {
      Triple face = tet_face(c, k);
      const Index other = mesh.next[t][k];
      if (other >= 0) {
        for (const Index v : face)
          EXPECT_NE(std::find(mesh.tet[other].begin(), mesh.tet[other].end(), v), mesh.tet[other].end());
      } else {  // on the hull: all points are behind it
        for (Index v = 0; v < V.rows(); ++v)
          EXPECT_LE(orient3d(row(V, face[0]), row(V, face[1]), row(V, face[2]), row(V, v)), 0);
      }
    }
  }
}

TEST(Delaunay, SpheresAreEmpty) {
  const VertexMatrix V = random_points(150, 5);
  const TetArrays mesh = delaunay(V.data(), 150, [] { return false; });
  expect_sound(V, mesh);
  for (const Tet& t : mesh.tet) {
    Eigen::Matrix3d A;
    Eigen::Vector3d b;
    const Eigen::Vector3d a = V.row(t[0]);
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d d = V.row(t[k + 1]).transpose() - a;
      A.row(k) = 2 * d;
      b[k] = d.squaredNorm();
    }
    const Eigen::Vector3d centre = A.fullPivLu().solve(b);
    for (Index v = 0; v < V.rows(); ++v)
      EXPECT_GE((V.row(v).transpose() - a - centre).norm(), centre.norm() * (1 - 1e-9));
  }
}

TEST(Delaunay, PointsOnCommonSpheres) {
  const VertexMatrix V = grid(5);
  const TetArrays mesh = delaunay(V.data(), 125, [] { return false; });
  expect_sound(V, mesh);
  double sum = 0;
  for (const Tet& t : mesh.tet) sum += volume(V, t);
  EXPECT_NEAR(sum, 64, 1e-9);
}

TEST(Delaunay, FlatInputAndStopGiveNothing) {
  VertexMatrix V = random_points(50, 1);
  EXPECT_TRUE(delaunay(V.data(), 50, [] { return true; }).tet.empty());
  V.col(2).setConstant(0.5);
  EXPECT_TRUE(delaunay(V.data(), 50, [] { return false; }).tet.empty());
}

// In lots: the same tets, whatever the lots are, also where points lie on common spheres.
TEST(Delaunay, LotsMakeNoDifference) {
  const auto stop = [] { return false; };
  const auto set_of = [](const TetArrays& mesh) {
    std::set<Tet> tets;
    for (Tet t : mesh.tet) std::sort(t.begin(), t.end()), tets.insert(t);
    return tets;
  };
  for (const VertexMatrix& V : {random_points(200, 9), grid(5)}) {
    const Index n = static_cast<Index>(V.rows());
    const std::set<Tet> whole = set_of(delaunay(V.data(), n, stop));
    for (const Index first : {1, 3, 70, n}) {
      DelaunayBuilder builder;
      EXPECT_EQ(builder.points(), 0);
      EXPECT_TRUE(builder.tets().tet.empty());
      ASSERT_TRUE(builder.insert(V.data(), first, stop));
      EXPECT_EQ(builder.points(), first);
      ASSERT_TRUE(builder.insert(V.data() + 3 * first, n - first, stop));
      const TetArrays mesh = builder.tets();
      expect_sound(V, mesh);
      EXPECT_EQ(set_of(mesh), whole);
    }
  }
}

TEST(Delaunay, BuilderRefusesEqualPointsAndIsEmptyAfterwards) {
  const VertexMatrix V = random_points(50, 2);
  DelaunayBuilder builder;
  ASSERT_TRUE(builder.insert(V.data(), 50, [] { return false; }));
  EXPECT_FALSE(builder.insert(V.data() + 3 * 7, 1, [] { return false; }));
  EXPECT_EQ(builder.points(), 0);
  EXPECT_FALSE(builder.insert(V.data(), 50, [] { return true; }));
  EXPECT_TRUE(builder.insert(V.data(), 50, [] { return false; }));
  EXPECT_EQ(builder.points(), 50);
}

// Where apart() says so, no point of the triangle's inside lies in the tet.
TEST(Apart, AgainstPointsOfTheTriangle) {
  std::mt19937 random(11);
  int yes = 0, no = 0;
  for (int round = 0; round < 400; ++round) {
    const VertexMatrix V = random_points(7, 100 + round);
    Tet tet{0, 1, 2, 3};
    if (orient3d(row(V, 0), row(V, 1), row(V, 2), row(V, 3)) < 0) std::swap(tet[2], tet[3]);
    const int shared = round % 3;  // corners of the tet that are corners of the triangle
    Triple triangle{4, 5, 6};
    for (int k = 0; k < shared; ++k) triangle[k] = k;
    std::shuffle(triangle.begin(), triangle.end(), random);
    bool hit = false;
    const int n = 40;
    for (int i = 1; i < n; ++i)
      for (int j = 1; i + j < n; ++j) {
        const Eigen::RowVector3d p =
            (i * V.row(triangle[0]) + j * V.row(triangle[1]) + (n - i - j) * V.row(triangle[2])) / n;
        bool inside = true;
        for (int k = 0; inside && k < 4; ++k)
          inside = orient3d(row(V, tet[kTetFace[k][0]]), row(V, tet[kTetFace[k][1]]),
                            row(V, tet[kTetFace[k][2]]), p.data()) < 0;
        hit |= inside;
      }
    const bool is_apart = apart(V.data(), tet, triangle);
    ++(is_apart ? yes : no);
    EXPECT_FALSE(hit && is_apart) << "round " << round;
  }
  EXPECT_GT(yes, 50);
  EXPECT_GT(no, 50);
}

TEST(CavityFiller, FindsFacetsThatAnEdgePierces) {
  // Two tets above each other with the face (0, 1, 2) between them, given as three around the edge 3-4.
  VertexMatrix V(5, 3);
  V << 1, 0, 0, -0.5, 0.9, 0, -0.5, -0.9, 0, 0, 0, 1, 0, 0, -1;
  std::vector<Triple> faces;
  for (int k = 0; k < 3; ++k) {
    faces.push_back({(k + 1) % 3, k, 3});
    faces.push_back({k, (k + 1) % 3, 4});
  }
  faces.push_back({0, 1, 2});
  faces.push_back({0, 2, 1});
  std::vector<Tet> tets;
  ASSERT_TRUE(CavityFiller().fill(V.data(), faces, 100, tets));
  ASSERT_EQ(tets.size(), 2u);
  for (const Tet& t : tets) EXPECT_GT(volume(V, t), 0);
}

TEST(CavityFiller, SaysNoToTheTwistedPrism) {
  // Schoenhardt's: no tet fits in without crossing the outside.
  VertexMatrix V(6, 3);
  for (int k = 0; k < 3; ++k) {
    const double a = 2 * M_PI * k / 3, b = a + M_PI / 6;
    V.row(k) << std::cos(a), std::sin(a), 0;
    V.row(3 + k) << std::cos(b), std::sin(b), 1;
  }
  std::vector<Triple> outward{{0, 2, 1}, {3, 4, 5}};
  for (int k = 0; k < 3; ++k) {
    const int n = (k + 1) % 3;
    outward.push_back({k, n, 3 + k});
    outward.push_back({n, 3 + n, 3 + k});
  }
  // Twisted the other way, the quadrilaterals' diagonals bulge out and it can be filled.
  const auto fills = [&](double twist) {
    for (int k = 0; k < 3; ++k) {
      const double b = 2 * M_PI * k / 3 + twist;
      V.row(3 + k) << std::cos(b), std::sin(b), 1;
    }
    std::vector<Triple> faces;
    for (const Triple& f : outward) faces.push_back({f[0], f[2], f[1]});
    std::vector<Tet> tets;
    return CavityFiller().fill(V.data(), faces, 10000, tets);
  };
  EXPECT_NE(fills(M_PI / 6), fills(-M_PI / 6));
}

// Stars of points, refilled from their faces alone.
TEST(CavityFiller, FillsStarsOnce) {
  for (unsigned seed = 0; seed < 30; ++seed) {
    const VertexMatrix V = random_points(25, seed);
    const TetArrays mesh = delaunay(V.data(), 25, [] { return false; });
    const Index centre = static_cast<Index>(seed % 25);
    std::set<Index> star;
    for (std::size_t t = 0; t < mesh.tet.size(); ++t)
      if (std::count(mesh.tet[t].begin(), mesh.tet[t].end(), centre)) star.insert(static_cast<Index>(t));
    std::vector<Triple> faces;
    std::set<Triple> keys;
    double before = 0;
    for (const Index t : star) {
      before += volume(V, mesh.tet[t]);
      for (int k = 0; k < 4; ++k)
        if (mesh.next[t][k] < 0 || !star.count(mesh.next[t][k])) {
          const Tet& c = mesh.tet[t];
          faces.push_back(tet_inner_face(c, k));
        }
    }
    std::vector<Tet> tets;
    ASSERT_TRUE(CavityFiller().fill(V.data(), faces, 10000, tets)) << "seed " << seed;
    double after = 0;
    for (const Tet& t : tets) {
      EXPECT_GT(orient3d(row(V, t[0]), row(V, t[1]), row(V, t[2]), row(V, t[3])), 0);
      after += volume(V, t);
    }
    EXPECT_NEAR(after, before, 1e-12);
  }
}

}  // namespace
}  // namespace overtet
