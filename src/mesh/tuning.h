// What can be chosen in this room, with units and reasons. Qualities are smallest dihedral sines.
#pragma once

#include <cstddef>
#include <cstdint>

namespace overtet {

// A change that gains less than this factor is rounding, and not worth it.
constexpr double kAnyGain = 1.001;
// Qualities that differ by less are equal: computed from other orders of the corners, or by a climb that ends
// a hair below a floor that it keeps.
constexpr double kSameQuality = 1 - 1e-6;
// A cavity for a new vertex is found in steps, each for such a part of the quality that is aimed at, so that
// the vertex finds its place meanwhile.
constexpr double kPartsOfAim[] = {0.3, 0.7, 1};
// Tets. Larger cavities seldom have a place for a vertex that makes good tets with all of their faces.
constexpr std::size_t kLargestCavity = 20;
// Tets. A trade may take more of them apart: those that are bad anyway.
constexpr std::size_t kLargestTradeCavity = 24;
// Steps in which a cavity grows; more seldom lead to a place.
constexpr int kMostGrowth = 10;
// Tets. Where a Delaunay cavity is larger, something is wrong with the walk to it: the first vertices inside
// a thick solid of ten million faces replace some 100,000.
constexpr std::size_t kLargestDelaunayCavity = 500'000;
// Tets. A walk towards a point may go round in circles where tets are not Delaunay.
constexpr int kLongestWalk = 100;
// Of the square of the radius of the smallest sphere through a boundary face: nearer vertices are not
// inserted. (All of it leaves too few vertices near the boundary.) Also of the square of the shortest edge of
// the tet that is refined: so far from a face between two parts of the mesh a vertex stays.
constexpr double kEncroaching = 0.5;

// Sizes: how much longer edges may become with the distance from where they are to be short; and how much
// shorter they get with the distance from where the boundary's are long. Both lengths over lengths:
// neighbours differ by less than a factor of two, and tets between them stay good.
constexpr double kGrading = 0.4, kShrinking = 0.4;
// Of the wanted length: a new vertex keeps so far from others, in the centre of a tet, in the middle of an
// edge, or where that is split by itself. Shorter edges than that make thin tets, which nothing may contract.
constexpr double kCentreRoom = 0.55, kMiddleRoom = 0.3, kSplitRoom = 0.12;

// Functions within such a factor of the worst steer a climb together with it: tried in this order, all where
// care is wanted.
constexpr double kActiveFactor[] = {1.5, 1.1}, kAllFactors[] = {1.5, 1.1, 2.0, 1.25, 1.02};
// Functions beyond this factor of the worst do not matter for a step.
constexpr double kFarFromWorst = 4;
// So many functions at most steer a climb: subsets of three are gone through.
constexpr int kMostActive = 5;
// Of a step: a thousandth of the way to where the first tet is flat.
constexpr int kMostHalvings = 10;
// A step is not tried where the linear model of the logarithm promises less than this, without care.
constexpr double kLeastStepGain = 0.01;

// In bad tets: a change that saves less is not worth it. A new vertex costs a few tets.
constexpr double kLeastSaving = 0.02, kLeastSavingOfVertex = 0.1;
// So many bad tets around a vertex are given up, one after the other.
constexpr int kMostGivenUp = 6;

// Tets around an edge that is removed: the time grows with the cube.
constexpr int kLargestRing = 10;
// Points of a polyhedron that is filled: bits of a word, and the time grows exponentially.
constexpr int kMostPoints = 24;
// Radians. Sums of angles around an edge are right up to rounding, or wrong by a whole turn.
constexpr double kTurnTolerance = 1e-2;

// Of the diagonal: walls of a solid that are thinner are worth telling. A tenth of a millimetre of a print of
// ten centimetres; edges of scans are longer.
constexpr double kThinWall = 1e-3;

// Along an axis: places where a cut through a mesh may be.
constexpr int kPlaces = 64;

}  // namespace overtet
