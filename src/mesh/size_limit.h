// How large tets may be.
//
// At every vertex two lengths: how long edges are asked to be at most, and how short they can be made there.
// Where the boundary's own edges are longer than asked, edges near them cannot be shorter than these without
// thin tets: they shrink inwards. Both are known at the surface, and spread from vertex to vertex along the
// mesh, never through space: layers that overlap do not see each other.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "overtet/types.h"
#include "src/mesh/tet_complex.h"
#include "src/mesh/tuning.h"

namespace overtet {

// Lengths in the user's unit.
struct LocalSize {
  double asked = std::numeric_limits<double>::infinity();  // an edge is not to be longer
  double least = 0;                                        // but may be so long

  // What they are at this distance from there.
  LocalSize at(double distance) const { return {asked + kGrading * distance, least - kShrinking * distance}; }
  void meet(const LocalSize& other) {
    asked = std::min(asked, other.asked);
    least = std::max(least, other.least);
  }
};

class SizeLimit {
 public:
  // unit: what a coordinate is multiplied with to get the user's; volume and edge: infinite for no limit.
  SizeLimit(const Eigen::Vector3d& unit, double volume, double edge);
  SizeLimit like_this() const { return {unit_, volume_, edge_}; }  // without vertices

  double length(const Eigen::Vector3d& p, const Eigen::Vector3d& q) const {
    return (p - q).cwiseProduct(unit_).norm();
  }
  std::vector<LocalSize> sizes;  // of each vertex
  // A new vertex at p, with tets to these.
  void add_vertex(const Eigen::Vector3d& p, std::span<const Index> near,
                  const std::vector<Eigen::Vector3d>& positions);

  // Edges that stay as they are: how long they are does not count. Pairs, the smaller number first, sorted.
  void keep_edges(std::vector<std::array<Index, 2>> edges) { kept_ = std::move(edges); }
  bool kept(Index a, Index b) const;

  // How long an edge may be between two vertices.
  double allowed(Index a, Index b) const {
    const LocalSize &x = sizes[a], &y = sizes[b];
    return std::max(std::min(x.asked, y.asked), std::max(x.least, y.least));
  }
  // How much too large a tet is: the largest of its lengths over what is allowed, the cube root of its volume
  // one of them; 1 or less: it is not. edge: the longest one over what is allowed, -1 where none is too long.
  struct Excess {
    double factor = 0;
    int edge = -1;  // of kTetEdge
  };
  Excess excess(const TetComplex::Tet& tet, const std::array<Eigen::Vector3d, 4>& at) const;
  // The length that edges are to have about there, given the limits of length and volume.
  double wanted(const TetComplex::Tet& tet) const;
  const Eigen::Vector3d& unit() const { return unit_; }
  double volume() const { return volume_; }
  double edge() const { return edge_; }

 private:
  double volume_at(const TetComplex::Tet& tet) const;

  Eigen::Vector3d unit_;
  double volume_, edge_;
  std::vector<std::array<Index, 2>> kept_;
};

}  // namespace overtet
