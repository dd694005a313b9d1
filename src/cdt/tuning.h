// What can be chosen in this room, with units and reasons.
#pragma once

#include <cstddef>
#include <cstdint>

namespace overtet {

// --- TetGen (tetgen.cpp, tetgen_child.cpp) ---

// At needles, refinement for quality can go on for ever; natural inputs need about one added point a vertex.
constexpr std::int64_t kMostPointsPerVertex = 4;
// In some orders of points TetGen's flips never end; in another one, or in halves, they do. It usually calls
// some hundred predicates a facet, and up to 9000 among needles: 5 million are a second.
constexpr double kMostPredicates = 3e7, kMostPredicatesPerFacet = 3e4;
// Without a predicate, only lists are gone through: seconds, and one more for every kLarge facets.
constexpr int kIdleSeconds = 10;

// Looks, some 25 ms apart, at a child that neither answers nor works: a minute, in which any process that can
// run gets the processor, however many others want it. And some 10 ms apart at one that has nothing more to
// do: a second.
constexpr int kMostIdleLooks = 2400, kMostLooks = 100;

// --- Attempts (facet_recovery.cpp) ---

// Orders of the points that are tried.
constexpr int kOrders = 6;
// So many facets TetGen is given in all attempts at one mesh, times the patience: all attempts there are for
// most, a few for large ones, where each takes long and other orders seldom help.
constexpr double kMostFacets = 3e6;
// Part of the patience for the first time round, as what leads anywhere takes little; and for what another
// route or no mesh at all can stand in for.
constexpr double kShortPatience = 0.3;
// From so many facets on, Delaunay tets first are faster, and TetGen's part of them is shared out in pieces,
// which can run at the same time, of so many each. From so many on, it pays to begin with those before all
// points are known: tets in another order are another problem for TetGen where it works in parts, and for the
// quality pass.
constexpr std::ptrdiff_t kLarge = 10'000, kWorthAStart = 40'000;
// Sine of the smallest angle of a face that TetGen still refines around in useful time: 0.006 degrees.
constexpr double kNeedle = 1e-4;
// So many tets a vertex without vertices inside: points lie on common spheres, and flat tets fill the gaps.
// Around 4 is usual.
constexpr double kCrowd = 4.5;

// --- Delaunay tets first (delaunay_first.cpp, delaunay_match.cpp, domain_parts.cpp) ---

// Bytes that Delaunay tets take for each point.
constexpr std::size_t kDelaunayBytesPerPoint = 1500;
// A cavity with more pairs of a tet and a missing facet is TetGen's, where one facet goes after the other.
constexpr std::size_t kMostPairs = 300'000;
// Pieces that TetGen's part is shared out in.
constexpr std::int64_t kMostPieces = 4;
// Facets of a part that is halved where TetGen fails.
constexpr std::size_t kSmallestPart = 200;
// Facets for each part of which the tree is made that shares out the tets.
constexpr std::int64_t kSampledFacets = 2048;
// Missing facets pass through three tets or so. Needles pass through hundreds, and what they join is no part
// that TetGen does sooner than the whole.
constexpr std::size_t kMostCrossed = 20;

// --- Free points (free_points.cpp) ---

// A cell of the octree with more vertices is divided: cells are about as large as two or three faces then,
// and an empty one beside them leaves room for well-shaped tets. With 5 or 40, the quality pass leaves the
// same angles and takes as long.
constexpr std::size_t kVerticesPerCell = 10;
// Faces for each vertex in a cell: about 3. Where it has many more, needles pass through, and dividing it
// only copies them.
constexpr std::size_t kFacesPerVertex = 8;
// Of a cell's size: the range around its middle in which the point lies.
constexpr double kOffMiddle = 0.2;

// --- Roofs over needles (star_areas.cpp, roofs.cpp) ---

// Sine of the smallest angle of a needle: 0.6 degrees. With no more of them, an area is no trouble for
// TetGen.
constexpr double kThinFace = 1e-2;
constexpr std::int64_t kFewNeedles = 10;
// Of the diagonal: vertices so near to a plane are in it, as far as files of single precision can say.
constexpr double kNearPlane = 1e-6;
// Of its width: an area that is farther from a plane is a strip of something round.
constexpr double kFlatness = 1e-4;
// Areas that one plane is cut into, at most: each takes a look at all that is left.
constexpr std::size_t kMostStars = 200;
// Faces beside the best shaped ones from which it is tried how much of an area can be seen.
constexpr std::size_t kLookouts = 8;
// A point of a roof is so far from the middle of its run, in lengths of the run: at the centre of a quarter
// of a circle. A run turns by little more than a quarter, in radians. And a roof is at most so deep, as a
// share of the solid there.
constexpr double kRoofInset = 0.6, kMostTurn = 1.7, kRoofDepth = 0.3;

}  // namespace overtet
