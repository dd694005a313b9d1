// Private to the .cpp files of this room: the faces of a surface, cut exactly along the curves in which they
// cross.
#pragma once

#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/arrangement/intersection_graph.h"
#include "src/exact/rays.h"
#include "src/mesh/topology.h"

namespace overtet {

// Not in general position; says where.
struct Degenerate {
  std::string what;
};

// Nodes: the vertices, then points where an edge pierces a face, then triple points.
class FaceCuts {
 public:
  struct Half {  // a piece of a part's border, the part to its left
    Index from, to;
    Index part = -1, next = -1;
  };
  struct Piece {  // of a curve; along n_f x n_g, f < g
    Index f, g, from, to;
  };
  using NodePairs = std::vector<std::pair<Index, Index>>;
  using Flat = std::array<exact::Rational, 2>;  // a point of a face, two of its coordinates

  FaceCuts(const Surface& surface, IntersectionGraph& graph) : surface_(surface), graph_(graph) {}

  std::vector<Half> halves;         // by face
  std::vector<Index> half_begin;    // #F + 1; within a face sorted by (from, to)
  std::vector<Index> face_of_part;  // parts of a face follow each other
  std::vector<int> holes;           // per part
  std::vector<Piece> pieces;

  // Throws Degenerate; ends early when the context says so. rays: of the surface.
  void run(const exact::Rays& rays, const RunContext& context);

  // The half-edge of f from node x to node y.
  Index half(Index f, Index x, Index y) const;

  // The nodes on an input edge, from the source of the half-edge on.
  std::vector<Index> edge_chain(Index h) const;

  exact::Vec place(Index node) const;

 private:
  const double* point(Index v) const;
  const double* corner(Index f, int k) const;
  exact::Vec normal(Index f) const;
  static std::string name(Index f, Index g);

  // Nodes and triple points, in a fixed order.
  void number_ends(std::size_t pair);
  Index number(Index graph_node);
  void find_triples(const exact::Rays& rays);

  std::vector<Index> chain(std::vector<Index> nodes, const exact::Vec& along) const;

  void cut(Index f);

  // The nodes of the pieces in f, turned so that the face is counter-clockwise.
  std::map<Index, Flat> flattened(Index f, const NodePairs& found) const;
  // A face that nothing cuts, or cuts into parts: the first `border` pieces run along its border, as it
  // turns.
  void add_whole(Index f, const NodePairs& border);
  void divide(Index f, const NodePairs& found, std::size_t border);

  struct Crossing {  // of two faces
    std::array<Index, 2> ends{-1, -1};
    std::vector<Index> triples;
  };

  const Surface& surface_;
  IntersectionGraph& graph_;
  std::map<Index, Index> number_;  // of the graph's nodes that are not vertices
  std::vector<exact::Vec> added_;
  std::map<FacePair, Crossing> crossings_;
  std::map<Index, std::vector<Index>> partners_;
  std::map<std::pair<Index, Index>, std::vector<Index>> on_edge_;
};

}  // namespace overtet
