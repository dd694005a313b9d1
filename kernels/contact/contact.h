// Contacts of a triangle mesh with itself: what is close, what a step would hit, what meets.
//
// Only primitives (vertex against triangle, edge against edge) that share a vertex are left out; faces that
// share a vertex or an edge still have pairs without a common one (the two free corners of two faces on an
// edge, for instance), and leaving those out is what locked earlier reverse flows.
//
// Why these pairs are enough: let two faces be disjoint but for common corners and move. The first moment
// they meet, the meeting is a vertex on a triangle or an edge on an edge, of the two faces and without a
// common vertex. So if no such pair comes closer than some part of its present distance during a
// step, the state after the step is as free of intersections as the one before.
//
// While little moves, the pairs in reach are remembered: the list is made with a skin around every vertex and
// holds until a vertex leaves its skin (as in molecular dynamics [Verlet 1967]). Answers do not change.
//
// Some vertices may be frozen: pairs of four frozen vertices are never looked at, and the frozen faces'
// tree is built once. All results are in an order that does not depend on the number of threads.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "kernels/bvh/box_tree.h"
#include "kernels/contact/distance.h"
#include "overtet/types.h"

namespace overtet {

struct IndexPair {
  Index a, b;
  friend bool operator==(const IndexPair&, const IndexPair&) = default;
  friend auto operator<=>(const IndexPair&, const IndexPair&) = default;
};

struct Contact {
  std::array<Index, 4> v;  // vertex | triangle, or edge | edge
  PairKind kind;
  Closest closest;  // at the positions of the search
  double dhat;      // the barrier starts here
  double h;         // the local mean edge the pair was judged by
};

struct ContactRule {
  double reach = 0.4;       // dhat = reach * (the smaller local mean edge)
  double ring_reach = 0.5;  // but for one-ring neighbours at most this part of the distance at rest
  double ring_floor = 0.1;  // and at least this part of the mean edge (rest shapes may touch)
};

// One class, because pairs are remembered from one question to the next, with the lengths they were found
// for.
class ContactMesh {
 public:
  // X: positions; frozen vertices (free[v] == 0) keep them for good. rest: the positions at which one-ring
  // neighbours are measured; h: local mean edge, one per vertex.
  // pre: F's indices are below X's rows, everything is finite.
  ContactMesh(const VertexMatrix& X, const TriangleMatrix& F, const std::vector<char>& free,
              const VertexMatrix& rest, const Eigen::VectorXd& h, const ContactRule& rule = {});
  // For intersection tests only.
  ContactMesh(const VertexMatrix& X, const TriangleMatrix& F, const std::vector<char>& free);

  // Other lengths for find_contacts from now on. pre: none is larger than the constructor's.
  void set_mean_edges(const Eigen::VectorXd& h);

  // Every pair closer than its dhat at X, each once. pre: X is finite.
  std::vector<Contact> find_contacts(const VertexMatrix& X);

  // Face pairs (a free vertex among them) that intersect exactly at X, ascending. pre: X is finite.
  std::vector<IndexPair> intersections(const VertexMatrix& X);

  // A primitive pair that the straight step from X to X + P may bring into contact.
  struct Hit {
    std::array<Index, 4> v;
    double safe;  // the part of the step that is certain to be free of contact
  };
  // The pairs for which X + P cannot be reached safely, and, of faces that meet exactly at X + P, the
  // corners (safe 0). Empty: the step is safe and X + P is exactly free of intersections.
  // pre: X is exactly free of intersections, X and P are finite, P is zero at frozen vertices.
  std::vector<Hit> check_step(const VertexMatrix& X, const VertexMatrix& P);

  // Faces with a free vertex, ascending.
  const std::vector<Index>& free_faces() const { return free_faces_.list; }
  // Joined by an edge.
  bool adjacent(Index a, Index b) const;
  // Sorted neighbours of v.
  std::span<const Index> ring(Index v) const {
    return {rings_.to.data() + rings_.begin[v],
            static_cast<std::size_t>(rings_.begin[v + 1] - rings_.begin[v])};
  }

 private:
  struct Primitive {
    std::array<Index, 4> v;
    PairKind kind;
    bool near;    // one-ring neighbours
    double rest;  // their distance at rest
  };

  template <class BoxOf>
  std::vector<IndexPair> candidates(const BoxOf& box_of);
  template <class Visit>
  void primitives(const IndexPair& faces, Visit&& visit) const;
  double margin(Index face) const;
  double reach_of(bool near, double rest, double h) const;  // dhat
  double mean_edge(const std::array<Index, 4>& v, PairKind kind, const Eigen::VectorXd& h) const;
  // Every vertex of X lies in its skin, and h is within what the lists were made for.
  bool remembered(const VertexMatrix& X) const;
  void remember(const VertexMatrix& X);

  struct Faces {
    std::vector<Index> list;  // ascending
    BoxTree tree;
  };
  struct Rings {
    std::vector<Index> begin, to;
  };
  // What can come into reach while no vertex leaves its skin.
  struct Lists {
    Eigen::VectorXd most_h;    // the constructor's
    VertexMatrix X;            // where they were made; empty: no lists
    Eigen::VectorXd h, skin;   // for which lengths, and how far a vertex may go
    double relative_skin = 0;  // to the mean edge
    int uses = 0;
    std::vector<Primitive> primitives;  // every pair that can come into reach
    std::vector<IndexPair> faces;       // every pair of faces whose boxes can overlap
  };

  TriangleMatrix F_;
  std::vector<char> free_;
  VertexMatrix rest_;
  Eigen::VectorXd h_;
  ContactRule rule_;
  Faces free_faces_, frozen_faces_;
  // What a face stands for, so that every vertex and every edge is looked at once: bit k: corner k, bit
  // 3 + k: the edge opposite to corner k [representative triangles: Curtis, Tamstorf, Manocha 2008].
  std::vector<unsigned char> owns_;
  Rings rings_;
  std::vector<Box> boxes_;  // of the free faces
  std::vector<Index> free_vertices_;
  Lists lists_;
};

}  // namespace overtet
