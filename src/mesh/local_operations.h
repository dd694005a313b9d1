// Small changes of a tet mesh inside its boundary: flips, edge removal, splits, collapses, insertions and
// smoothing, each done only when it keeps everything that must be kept.
//
// Guaranteed for every operation that returns true (and nothing changes when it returns false):
//  1. Every new or moved tet is exactly positive.
//  2. Boundary faces, boundary edges and boundary vertices stay as they are, to the last bit.
//  3. The complex stays a 3-manifold with boundary; no two edges get the same end vertices, no two faces
//     the same corners.
//  4. The tets around every interior edge still make one turn, if they did before. Why: where a cavity is
//     filled anew on its own points, the angles at each of its edges are added up before and after. Every
//     other cavity is the star of an interior vertex, the ring of an interior edge, two tets with a common
//     face, or a grown one whose boundary is seen from the new vertex under exactly 4 pi. It is embedded
//     (one turn around its inner edges and positive tets make the map of the vertex's link to the sphere a
//     covering of degree one). Old and new tets have the same boundary, hence the same degree at every
//     point; all positive, they cover every point of the cavity once. So the angle at each edge of the
//     cavity's boundary is the same before and after, also where that edge is a hinge of more than one turn.
//     Where a mesh has branch lines, 1 to 3 hold as ever, and vertices on a line may move; which edges branch
//     may change. (The exact check at the end of a run lists them.)
//  5. With a criterion: the worst tet among those replaced gets better; with a price: their price falls.
//
// The mesh may overlap itself: nothing here searches by position.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "kernels/tet_energy/tet_fan.h"
#include "src/mesh/size_limit.h"
#include "src/mesh/tet_complex.h"
#include "src/mesh/tuning.h"

namespace overtet {

class Polyhedron;

// Squares of a tet's circumradius over its shortest edge; rounded, not finite for tets that are too flat.
double squared_radius_edge(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                           const Eigen::Vector3d& d);

// More than 12 members: the tables that every operation has to keep right, and buffers that keep their memory
// from one operation to the next.
class LocalOperations {
 public:
  // Works on `mesh`, which must stay alive and must not be changed by others meanwhile.
  // pre: every tet is positive.
  explicit LocalOperations(TetComplex& mesh);

  const TetComplex& mesh() const { return mesh_; }
  double quality(Index t) const { return quality_[t]; }  // min_dihedral_sine
  bool fixed(Index v) const { return fixed_[v] != 0; }   // on the boundary (or pinned)
  void pin(Index v) { fixed_[v] = 1; }                   // treat an interior vertex like a boundary one
  // v is fixed and belongs to tets outside this complex as well: no operation makes an edge or a face between
  // shared vertices that was not there, so that it cannot be there twice in the whole. When pinched (tets
  // of this complex around v, or around an edge of it, hang together outside only) no edge to v either.
  enum class Sharing { plain, pinched };
  void share(Index v, Sharing how);
  bool shared(Index v) const { return v < static_cast<Index>(shared_.size()) && shared_[v] != 0; }
  // New or changed tets of the last operation that returned true.
  const std::vector<Index>& changed() const { return changed_; }
  // From now on no operation makes an interior edge between two fixed vertices.
  void forbid_fixed_chords() { fixed_chords_ = false; }
  // From now on no operation makes a tet that is too large, unless it replaces one that is so by as much. The
  // limit has sizes of all vertices; those of new ones are added.
  void limit_sizes(SizeLimit limit) { limit_ = std::move(limit); }
  const std::optional<SizeLimit>& limit() const { return limit_; }
  // How much too large a tet is. pre: sizes are limited.
  SizeLimit::Excess excess(Index t) const { return limit_->excess(mesh_.tet(t), corners_of(mesh_.tet(t))); }
  // From now on vertices are placed with more care: twice the time for the last tenths.
  void be_thorough() { thorough_ = true; }

  // A new vertex on the interior edge a-b, at p. No criterion; false when a tet would not be positive or
  // the edge is not an interior one.
  bool split_edge(Index a, Index b, const Eigen::Vector3d& p);
  // A new vertex inside face k of t (two tets), or inside t. No criterion.
  bool split_face(Index t, int k, const Eigen::Vector3d& p);
  bool split_tet(Index t, const Eigen::Vector3d& p);

  // Two tets with a common face become three around a new edge. Must improve the worst of the two.
  bool flip_23(Index t, int k);
  // Removes the interior edge a-b of t by the best triangulation of its ring (3-2, 4-4, ...; rings of up to
  // kLargestRing tets, dynamic programming after Klincsek). Must improve the worst tet of the ring, or reach
  // at least `enough` in every new tet.
  bool remove_edge(Index t, Index a, Index b, double enough = 1e9);
  // Contracts the edge between the free vertex v and w; v goes to where w is. Must improve the worst tet
  // of v's star, or reach at least `enough` in every new tet.
  bool collapse(Index v, Index w, double enough = 1e9);
  // A new vertex with every face of the edge's ring / the face's two tets / the tet itself, placed by
  // optimisation; the cavity is grown over bad neighbours first. Must make the worst tet of the cavity
  // better by the factor `gain`.
  bool insert_at_edge(Index t, Index a, Index b, double gain = kAnyGain);
  bool insert_at_tet(Index t, double gain = kAnyGain);
  // The same with a cavity that is found the other way round: from where the vertex is to be (start), all
  // around t that makes no better tet with it goes. Around: starts in
  // t, in the tets beside it and halfway along its edges.
  bool insert_near(Index t, const Eigen::Vector3d& start, double gain = kAnyGain);
  bool insert_around(Index t, double gain = kAnyGain);
  // The best tets (polyhedron.h) for the star of a free corner of t, which may be left out of them, or else
  // for what lies around t. Every new tet must be better than t was by the factor `gain`.
  bool reconnect(Index t, double gain = 1.02);
  // The best tets for the star of v without v. Must improve the worst tet of the star, or reach at least
  // `enough` in every new tet.
  bool remove_vertex(Index v, double enough = 1e9);
  // The same with v, where it has moved to `to`, without the face `no_face` (of v).
  bool rebuild_star(Index v, const std::array<Index, 3>& no_face, const Eigen::Vector3d& to,
                    double enough = 1e9);
  // Delaunay refinement (Shewchuk 1998): a new vertex at the centre of t's circumsphere, or on the way there from
  // t's shortest edge, where it makes a triangle with that edge whose circumradius over the edge is radius_edge
  // (off-centres, Uengoer 2004: vertices come in layers from the boundary inwards, and far fewer tets are taken
  // apart), instead of the tets around it whose circumspheres contain it. False where the boundary is in the
  // way, where the vertex lies in a boundary face's smallest sphere or nearer to another one than t's shortest
  // edge is long, and where t would stay. No criterion of quality: what it bounds is the circumradius over the
  // shortest edge. pre: radius_edge > 1/2.
  bool insert_circumcentre(Index t, double radius_edge);
  // The same where t is too large: a vertex at the centre, or in the middle of the edge that is too long for
  // it, with the tets around chosen like this or, last, by splitting the edge alone: where that makes no
  // short edges, or in any case. pre: sizes are limited.
  enum class Splits { roomy, all };
  bool make_smaller(Index t, Splits splits);

  // Moves the free vertex v so that the worst tet of its star gets better by at least the factor `gain`.
  bool smooth(Index v, double gain = kAnyGain);
  // The same for any vertex, boundary ones included (the boundary moves with it), no further from `centre`
  // than the radius.
  bool smooth_within(Index v, const Eigen::Vector3d& centre, double radius);
  // smooth() towards a given place: the best of a few points on the way. Must improve the worst.
  bool move_towards(Index v, const Eigen::Vector3d& target);

  // What makes fewer tets bad, be it that other bad ones get worse. (The best worst tet of a star is as good
  // as several others there: all bad, where one could be.) A tet has a price: nothing when it is as good as
  // `goal`, else 1 and a little more the worse it is, up to 1 + slope. Below `low` it costs more, up to
  // `steep`. A change is made when the sum for the tets that it replaces falls. No tet becomes worse than
  // `low`; those that are get better or stay when they are only moved, else none gets worse than the worst
  // that it replaces.
  struct Price {
    double goal = 0, low = 0;
    double slope = 1, steep = 0;

    double operator()(double quality) const {
      if (quality >= goal) return 0;
      const double p = 1 + slope * (1 - quality / goal);
      return quality < low ? p + steep * (1 - quality / low) : p;
    }
  };
  bool smooth_cheaper(Index v, const Price& price);
  bool collapse_cheaper(Index v, Index w, const Price& price);
  bool insert_cheaper(Index t, const Price& price);  // starts where insert_around() does

  // Moves any vertex, boundary ones included, when every tet of its star stays exactly positive. (Volume is
  // linear in one vertex, so it is positive on the whole way: no edge gets another turn.)
  bool place(Index v, const Eigen::Vector3d& p);
  // Moves many at once, or none: when every one of `tets` (all that have a moved corner) is exactly positive
  // afterwards. One turn around every edge is the caller's affair here.
  bool place_all(std::span<const Index> vertices, std::span<const Eigen::Vector3d> positions,
                 std::span<const Index> tets);

  struct Sphere {
    Eigen::Vector3d centre;
    double squared_radius = -1;  // < 0: not known
  };
  const Sphere& circumsphere(Index t);  // rounded; not finite for tets that are too flat
  double squared_radius_edge(Index t);  // the square of the circumradius over the shortest edge, of t

 private:
  using Tets = std::vector<Index>;
  using Face = std::array<Index, 3>;  // (face, x) is positive for the vertex x that sees it
  struct Base {                       // where a face's corners are
    Eigen::Vector3d a, b, c;
    double weight = 1;  // of the quality of the tet on it, in quality_at() and optimise()
    double floor = 0;   // the least quality that it may have when others are to get better
  };

  // Replaces the tets by added_ and keeps the tables; false when what is shared forbids it.
  // pre: every added tet is positive.
  bool commit(const Tets& removed);
  // near: vertices around it, for its size.
  Index new_vertex(const Eigen::Vector3d& p, std::span<const Index> near);
  std::array<Eigen::Vector3d, 4> corners_of(const TetComplex::Tet& c) const {
    return {mesh_.position(c[0]), mesh_.position(c[1]), mesh_.position(c[2]), mesh_.position(c[3])};
  }
  bool respects_limit(const Tets& removed) const;
  // v may move there, as far as sizes are limited. pre: star_ is its star.
  bool may_move(Index v, const Eigen::Vector3d& to) const;
  // A new vertex at x, in the tet `at`, instead of t and the tets around whose circumspheres contain it; see
  // insert_circumcentre(). Nothing may be nearer than the root of `room`.
  bool insert_delaunay(Index t, Index at, const Eigen::Vector3d& x, double room);
  // From the edge a-b of t to the longest one around that may be split, from ring to ring.
  void to_longest_edge(Index& t, Index& a, Index& b);
  Index walk(Index from, const Eigen::Vector3d& x) const;  // to the tet that contains x; -1: not found
  // Tets from the faces to a new vertex. pre: it sees their inner sides (commit() would find out).
  bool star_of_new_vertex(const std::vector<Face>& faces, const Eigen::Vector3d& p, const Tets& removed);
  bool respects_shared(const Tets& removed) const;
  // What is known about tets that have changed.
  void refresh(std::span<const Index> tets);
  void forget_spheres(std::span<const Index> tets);
  double worst(const Tets& tets) const;
  double quality_of(Index a, Index b, Index c, Index d) const;
  double squared_shortest_edge(Index t) const;
  Face inner_face(Index t, int k) const;
  void load_bases();  // bases_ from faces_
  void load_fan();    // fan_ from bases_
  // The worst tet that x makes with bases_; stops (with some value <= stop) when it is not above stop.
  double quality_at(const Eigen::Vector3d& x, double stop);
  // Climbs from x, whose quality is q; returns the quality reached. x changes only for the better.
  double optimise(Eigen::Vector3d& x, double q, int rounds);
  struct LogSine {
    double value;
    Eigen::Vector3d gradient;
  };
  // The log sines at x that are not far from the least one; returns that.
  double gather_sines(const Eigen::Vector3d& x, std::vector<LogSine>& all);
  struct Uphill {
    Eigen::Vector3d direction;
    double slope;
  };
  // A direction in which all sines up to the limit grow, and how fast the slowest of them does.
  static std::optional<Uphill> uphill(const std::vector<LogSine>& all, double limit);
  // Where on the way from x the first tet becomes flat.
  double end_of_way(const Eigen::Vector3d& x, const Eigen::Vector3d& direction) const;
  // To the best place on the way, at which steps are halved until one is better than q, or the first doubled
  // as long as that pays; returns the quality there.
  double climb(Eigen::Vector3d& x, double q, const Uphill& way, double step, double end);
  // The tets around t with faces that make tets with x no better than `need`, `most` at most, go to cavity_,
  // the faces around them to hull_ and bases_. Which faces have to be better: those inside, or those of the
  // boundary, too.
  // Returns the worst quality of a vertex at x; not positive where there is no such cavity.
  enum class Judged { inside, boundary_too };
  double grow_cavity(Index t, const Eigen::Vector3d& x, double need, std::size_t most, Judged judged);
  // Replaces the cavity (grown first) by a new vertex that sees its faces; starts looking at `start`.
  bool insert(Tets& cavity, const Eigen::Vector3d& start, double gain);
  // The cheapest place found from x for a vertex that sees bases_; returns the price of the tets there.
  double cheapest(Eigen::Vector3d& x, const Price& price);
  bool insert_cheaper_near(Index t, const Eigen::Vector3d& start, const Price& price);
  std::vector<Eigen::Vector3d> places_around(Index t) const;  // where a vertex might go
  bool seen_once(const Eigen::Vector3d& x) const;             // hull_ from x, which sees all of its faces
  bool fill(const Tets& cavity, const Eigen::Vector3d& x);  // tets from hull_ to a new vertex; pre: x sees it
  bool hull_of(const Tets& cavity, std::vector<Face>& hull);  // false: not a ball with free inside vertices
  struct Refill {
    double must = 0;     // new tets must be better
    Index without = -1;  // a free vertex inside the cavity that is left out
    std::array<Index, 3> no_face{-1, -1, -1};
    Index moved = -1;  // a vertex with all of its tets in the cavity, which moves
    Eigen::Vector3d to = Eigen::Vector3d::Zero();
  };
  bool refill(const Tets& cavity, const Refill& how);       // with the best tets on its points
  using EdgeBits = std::array<std::uint32_t, kMostPoints>;  // bit j of i: there is an edge i-j
  // What the mesh has elsewhere, or may get where others work on it, is not made in the polyhedron. known:
  // edges of the cavity (marked), hull: those of its hull, by the numbers of the points in link_.
  void bar_elsewhere(const Refill& how, const EdgeBits& known, const EdgeBits& hull, Polyhedron& p);
  void load_star(Index v);     // star_, faces_ and bases_
  bool star_of_free(Index v);  // the same; false when v is fixed

  TetComplex& mesh_;
  std::vector<double> quality_;
  std::vector<Sphere> spheres_;  // empty until one is asked for
  std::vector<char> fixed_;
  std::vector<char> shared_;  // empty: no vertex is shared; 2: pinched
  std::optional<SizeLimit> limit_;
  bool fixed_chords_ = true;
  bool thorough_ = false;
  Tets changed_, ring_, star_, other_star_, link_, cavity_;
  std::vector<TetComplex::Tet> added_;
  std::vector<Face> faces_, hull_, grown_hull_;
  std::vector<Base> bases_;
  TetFan fan_;  // the same, for many places
  std::vector<std::uint32_t> vertex_mark_, tet_mark_;
  std::uint32_t vertex_stamp_ = 0, tet_stamp_ = 0;
};

}  // namespace overtet
