// The intersection graph of a surface with itself: in which segments its faces meet, how these hang together,
// and where third faces cut them. Found once, by the diagnosis, for all that asks about them: winding numbers
// (winding_range.h), curves (curves.h), and faces cut up for gluing (face_cuts.h). For .cpp files only (exact
// numbers); others know it by its name.
//
// Exact, all of it. A pair of faces meets in a segment. Its ends are where an edge of one face meets the
// other face, or a vertex of one lies on the other; they are named by these simplices, never by how close
// points are. Third faces that meet both faces may cut the segment. What costs exact numbers is computed when
// it is first asked for (prepare).
//
// tolerant_cutter.h, and the cutter of arrangement.h, are another thing: they cut surfaces of their own,
// moved by the rounding of the round before, and need whole triangulations of the faces in CGAL's numbers.
#pragma once

#include <array>
#include <compare>
#include <optional>
#include <vector>

#include "kernels/bvh/self_intersections.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/exact/rays.h"
#include "src/mesh/topology.h"

namespace overtet {

class IntersectionGraph {
 public:
  // A vertex (dimension 0), an edge (1, by its smaller half-edge) or a face (2).
  struct Simplex {
    int dimension = 0;
    Index id = -1;
    auto operator<=>(const Simplex&) const = default;
  };

  // An end of a segment: the smallest simplex that contains it on each of the two faces. If they met in more
  // than one point there, the segment would go on: so they name the point, whichever pair it is found from.
  using Meeting = std::array<Simplex, 2>;

  enum class Kind { nothing, point, segment, coplanar };  // what two faces have in common

  struct Segment {
    FacePair faces;                     // first < second
    std::array<Meeting, 2> ends;        // on the first face, on the second
    std::array<Simplex, 2> along{};     // the smallest simplices that contain the segment
    std::array<Index, 2> node{-1, -1};  // first < second
    // Both faces pass through each other; otherwise it runs along an edge.
    bool plain() const { return along[0].dimension == 2 && along[1].dimension == 2; }
  };

  // A place on a segment where third faces cut it, from 0 at its first node to 1 at its second.
  struct Cut {
    double near = 0, error = 0;
    std::optional<exact::Rational> exact;  // where it has been needed
    int step = 0;                          // of the winding number, on the way; 0 where a border cuts
    bool plain = true;         // each third face crosses with its inside, and so do the segment's own two
    Index by = -1;             // the face that the place is computed from
    std::vector<Index> faces;  // third ones; empty where only the line of an edge crosses, in a face's plane
  };

  // What third faces do to a segment.
  struct Cuts {
    std::vector<Cut> places;  // in order
    bool overlaid = false;    // the segment, or part of it, runs along a third face
    bool in_plane = false;    // it runs in the plane of one, at least
  };

  // pairs: all intersecting pairs of the surface, sorted. pre: no face without area. A surface of extreme
  // size is given as OrdinarySize makes it (src/exact/ordinary_size.h), here and to prepare.
  IntersectionGraph(const Surface& surface, const SurfaceTopology& topology, const TriangleBvh& bvh,
                    const std::vector<FacePair>& pairs);

  const std::vector<FacePair>& pairs() const { return pairs_; }
  std::vector<Index> common_partners(Index f, Index g) const;  // faces that intersect both, sorted
  Kind kind(std::size_t pair) const { return kind_[pair]; }
  // Segments are numbered in the order of the pairs. Of a pair that meets in something else: the next one's.
  Index segment_of(std::size_t pair) const { return first_segment_[pair]; }
  const std::vector<Segment>& segments() const { return segments_; }
  const std::vector<Meeting>& nodes() const { return nodes_; }  // sorted; in each the smaller simplex first

  // Computes the nodes and cuts of segments [first, last), if that has not been done; only then may one ask
  // for them. The surface and its tree are those of the beginning. Errors: limit or interrupted.
  Status prepare(const exact::Rays& rays, Index first, Index last, const RunContext& context);
  Status prepare_all(const exact::Rays& rays, const RunContext& context) {
    return prepare(rays, 0, static_cast<Index>(segments_.size()), context);
  }

  const exact::Point& position(Index node) const { return *position_[node]; }
  const Cuts& cuts(Index segment) const { return *cuts_[segment]; }
  // A cut's place in full.
  exact::Rational place(const exact::Rays& rays, Index segment, const Cut& cut) const;

 private:
  void number_nodes();
  exact::Point locate(const exact::Rays& rays, const Meeting& meeting) const;
  Cuts find_cuts(const exact::Rays& rays, const Segment& segment) const;
  void cut_in_plane(const exact::Rays& rays, const Segment& segment, Index third, Cuts& out) const;

  std::vector<FacePair> pairs_;
  std::vector<FacePair> partners_;    // both ways round, sorted
  std::vector<Kind> kind_;            // per pair
  std::vector<Index> first_segment_;  // per pair: its own, or the next one
  std::vector<Segment> segments_;
  std::vector<Meeting> nodes_;
  std::vector<std::optional<exact::Point>> position_;
  std::vector<std::optional<Cuts>> cuts_;
};

}  // namespace overtet
