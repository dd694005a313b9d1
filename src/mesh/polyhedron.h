// The best filling of a small polyhedron by tets on given points. Liu, Chen, Zheng and Chen, "Small
// polyhedron reconnection for mesh improvement and its implementation based on advancing front technique"
// (2009); Marot and Remacle, "Reviving the search for optimal tetrahedralizations" (2020). It goes from face
// to face, the one with the fewest choices first, and leaves out every choice that would be no better than
// what is known.
//
// Why what it finds is a filling: its tets are exactly positive, and their faces cancel each other but for
// the polyhedron's. So they cover each point as often as the tets did that the polyhedron was made of; once,
// where these did not overlap.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "src/mesh/tuning.h"

namespace overtet {

// More than 12 members: the tables of one search, in arrays of fixed size, kept from step to step.
class Polyhedron {
 public:
  using Face = std::array<int, 3>;  // (face, x) is positive for x inside
  using Tet = std::array<int, 4>;

  void clear();
  int add_point(const Eigen::Vector3d& p);  // its number; corners of faces get tets, others may
  void add_face(const Face& f);
  // No tet gets these. pre: the points and faces are there.
  void bar_edge(int i, int j);
  void bar_face(int i, int j, int k);

  int points() const { return count_; }
  const Eigen::Vector3d& point(int i) const { return point_[i]; }

  // Finds the tets whose worst min_dihedral_sine is best, and above `must`; returns that sine, or 0 where
  // there are none. Ends after `most_steps` faces with the best so far; complete() says whether it has seen
  // all.
  double fill(double must, std::int64_t most_steps, std::vector<Tet>& tets);
  bool complete() const { return steps_left_ > 0; }

 private:
  static constexpr int kTriples = kMostPoints * (kMostPoints - 1) * (kMostPoints - 2) / 6;
  enum class State : std::uint8_t { unused, open_even, open_odd, closed, barred };
  struct Open {
    Face face;
    int triple;
  };

  static int triple(int i, int j, int k);  // of any order
  void open(const Face& face, int triple, bool odd);
  void close(int triple);
  double quality(const Face& f, int v);
  bool leaves(const Face& f);       // goes through an edge or a face of the polyhedron
  bool edge_leaves(int p, int q);   // through a face
  bool face_leaves(const Face& f);  // around an edge
  const std::vector<double>& sides_of(int p);
  std::uint32_t choices(const Face& f, int triple, bool odd);
  // Takes the tet; false (and nothing has changed) where it does not fit.
  bool push(const Tet& tet);
  void pop();
  void search(double worst);

  int count_ = 0;
  std::array<Eigen::Vector3d, kMostPoints> point_;
  std::array<std::uint32_t, kMostPoints> barred_{};
  std::vector<Face> faces_;
  std::vector<Eigen::Vector3d> normals_;                // of the faces
  std::array<std::vector<double>, kMostPoints> sides_;  // of a point, of each face's plane; empty: not known
  std::array<std::uint32_t, kMostPoints> edges_;        // of the polyhedron: of a point, its neighbours
  std::array<State, kTriples> state_;
  std::array<std::int16_t, kTriples> place_;  // in open_
  std::vector<Open> open_;
  std::vector<double> quality_[2];  // per quad and orientation; < 0: not known
  std::array<std::int8_t, kTriples> leaves_;
  std::array<std::array<std::int8_t, kMostPoints>, kMostPoints> edge_leaves_;
  struct Choices {
    std::uint32_t mask;
    int age;
  };
  std::array<Choices, kTriples> choices_[2];
  std::vector<Tet> tets_, best_tets_;
  double bound_ = 0;
  int age_ = 0;
  std::int64_t steps_left_ = 0;
};

}  // namespace overtet
