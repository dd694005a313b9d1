// What every mesh of a complex must be.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <set>
#include <vector>

#include "kernels/predicates/predicates.h"
#include "src/cdt/tetgen.h"

namespace overtet {
namespace test {

inline std::array<Index, 3> key(Index a, Index b, Index c) {
  std::array<Index, 3> t{a, b, c};
  std::sort(t.begin(), t.end());
  return t;
}

inline void expect_sound(const TetgenResult& r, const Plc& plc, double volume) {
  ASSERT_GE(r.V.rows(), plc.V.rows());
  EXPECT_EQ(0, std::memcmp(r.V.data(), plc.V.data(), sizeof(double) * plc.V.size()));
  std::map<std::array<Index, 3>, std::vector<Index>> faces;
  double sum = 0;
  for (Index t = 0; t < r.T.rows(); ++t) {
    const auto p = [&](int k) { return r.V.data() + 3 * r.T(t, k); };
    ASSERT_GT(orient3d(p(0), p(1), p(2), p(3)), 0);
    const Eigen::RowVector3d a = r.V.row(r.T(t, 0));
    sum += (r.V.row(r.T(t, 1)) - a).cross(r.V.row(r.T(t, 2)) - a).dot(r.V.row(r.T(t, 3)) - a) / 6;
    for (int k = 0; k < 4; ++k) {
      const std::array<Index, 3> f = key(r.T(t, (k + 1) % 4), r.T(t, (k + 2) % 4), r.T(t, (k + 3) % 4));
      faces[f].push_back(t);
    }
  }
  EXPECT_NEAR(sum, volume, 1e-9 * std::abs(volume));
  for (Index t = 0; t < r.T.rows(); ++t)
    for (int k = 0; k < 4; ++k) {
      const auto& owners = faces[key(r.T(t, (k + 1) % 4), r.T(t, (k + 2) % 4), r.T(t, (k + 3) % 4))];
      ASSERT_LE(owners.size(), 2u);
      ASSERT_EQ(r.neighbours(t, k), owners.size() == 1 ? -1 : owners[0] == t ? owners[1] : owners[0]);
    }
  // Facets are faces; those of the input are there, or in parts.
  std::map<std::array<Index, 3>, Index> row;
  for (Index f = 0; f < r.facets.rows(); ++f) row[key(r.facets(f, 0), r.facets(f, 1), r.facets(f, 2))] = f;
  for (Index t = 0; t < static_cast<Index>(r.facet_on.size()); ++t)
    for (int k = 0; k < 4; ++k) {
      const auto f = row.find(key(r.T(t, (k + 1) % 4), r.T(t, (k + 2) % 4), r.T(t, (k + 3) % 4)));
      ASSERT_EQ(r.facet_on[t][k], f == row.end() ? -1 : f->second);
    }
  std::set<Index> sources;
  for (Index f = 0; f < r.facets.rows(); ++f) {
    EXPECT_TRUE(faces.count(key(r.facets(f, 0), r.facets(f, 1), r.facets(f, 2))));
    const Index source = r.facet_sources[f];
    sources.insert(source);
    EXPECT_EQ(r.facet_markers[f], plc.markers[source]);
  }
  EXPECT_EQ(sources.size(), static_cast<std::size_t>(plc.F.rows()));
}

inline Plc plc_of(const Surface& s) {
  Plc plc;
  plc.V = s.V;
  plc.F = s.F;
  for (Index f = 0; f < s.F.rows(); ++f) plc.markers.push_back(f + 1);
  return plc;
}

inline void expect_same(const TetgenResult& a, const TetgenResult& b) {
  EXPECT_EQ(a.V, b.V);
  EXPECT_EQ(a.T, b.T);
  EXPECT_EQ(a.neighbours, b.neighbours);
  EXPECT_EQ(a.facets, b.facets);
  EXPECT_EQ(a.facet_on, b.facet_on);
  EXPECT_EQ(a.facet_sources, b.facet_sources);
}

}  // namespace test
}  // namespace overtet
