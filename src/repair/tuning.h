// What can be chosen in this room, with units and reasons; RepairOptions has what its users may choose. Moves
// are measured against the diagonal of the surface's box.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>

#include "src/repair/smoothing.h"

namespace overtet {

// --- Where something is wrong (offences.cpp) ---

// Of the diagonal: so far in front of a face, or of a vertex, the winding number is looked at.
constexpr double kAhead = 1e-6, kAheadOfVertex = 1e-9;
// Height over reach below which a face counts as one without area.
constexpr double kFlatFace = 1e-14;
// Vertices, or samples of faces, that a region of negative winding is followed over.
constexpr std::size_t kMostFlooded = 200000;
// Every so many rounds all of what pokes out is looked for.
constexpr int kFloodRounds = 4;

// --- Smoothing (smoothing.cpp, clusters.cpp) ---

// Edges shorter than this part of the mean count as that long.
constexpr double kShortestEdge = 0.05;
// How a vertex that forbids a mesh is moved: with so many rings around it, so much of the way. Gently: as far
// as gentle moves go; far: as far as moves are allowed at all; in creases, less than two rings leave needles
// that no mesh generator takes.
struct SmoothingStep {
  enum class Reach { gentle, far, crease } reach;
  int rings;
  double part;
  Smoothing kind = Smoothing::membrane;
};
constexpr SmoothingStep kLadder[] = {{SmoothingStep::Reach::gentle, 0, 0.1},
                                     {SmoothingStep::Reach::gentle, 0, 0.3},
                                     {SmoothingStep::Reach::gentle, 0, 0.6},
                                     {SmoothingStep::Reach::gentle, 1, 0.3},
                                     {SmoothingStep::Reach::gentle, 0, 0.9},
                                     {SmoothingStep::Reach::gentle, 1, 0.6},
                                     {SmoothingStep::Reach::gentle, 2, 0.6},
                                     {SmoothingStep::Reach::gentle, 1, 0.9},
                                     {SmoothingStep::Reach::gentle, 2, 0.9},
                                     {SmoothingStep::Reach::gentle, 1, 1.0, Smoothing::thin_plate},
                                     {SmoothingStep::Reach::gentle, 1, 1.0},
                                     {SmoothingStep::Reach::gentle, 2, 1.0, Smoothing::thin_plate},
                                     {SmoothingStep::Reach::gentle, 3, 0.95},
                                     {SmoothingStep::Reach::gentle, 3, 1.0, Smoothing::thin_plate},
                                     {SmoothingStep::Reach::far, 0, 0.6},
                                     {SmoothingStep::Reach::far, 0, 0.9},
                                     {SmoothingStep::Reach::far, 1, 0.6},
                                     {SmoothingStep::Reach::far, 1, 0.9},
                                     {SmoothingStep::Reach::far, 2, 0.9},
                                     {SmoothingStep::Reach::far, 1, 1.0, Smoothing::thin_plate},
                                     {SmoothingStep::Reach::far, 1, 1.0},
                                     {SmoothingStep::Reach::far, 2, 1.0, Smoothing::thin_plate},
                                     {SmoothingStep::Reach::far, 3, 0.95},
                                     {SmoothingStep::Reach::far, 3, 1.0, Smoothing::thin_plate},
                                     {SmoothingStep::Reach::far, 3, 1.0},
                                     {SmoothingStep::Reach::far, 5, 0.95},
                                     {SmoothingStep::Reach::far, 5, 1.0, Smoothing::thin_plate},
                                     {SmoothingStep::Reach::far, 5, 1.0},
                                     {SmoothingStep::Reach::far, 8, 1.0, Smoothing::thin_plate},
                                     {SmoothingStep::Reach::far, 8, 1.0},
                                     {SmoothingStep::Reach::far, 12, 1.0, Smoothing::thin_plate},
                                     {SmoothingStep::Reach::far, 12, 1.0},
                                     {SmoothingStep::Reach::far, 18, 1.0, Smoothing::thin_plate},
                                     {SmoothingStep::Reach::far, 18, 1.0},
                                     {SmoothingStep::Reach::far, 27, 1.0},
                                     {SmoothingStep::Reach::crease, 2, 1.0},
                                     {SmoothingStep::Reach::crease, 3, 1.0},
                                     {SmoothingStep::Reach::crease, 4, 1.0},
                                     {SmoothingStep::Reach::crease, 6, 1.0},
                                     {SmoothingStep::Reach::crease, 9, 1.0},
                                     {SmoothingStep::Reach::crease, 14, 1.0}};
// Creases in which nearly everything crosses nearly everything (offences per vertex) are smoothed as a whole,
// with all faces that cross so many others of the same crease.
constexpr double kDense = 8;
constexpr int kCreasePartners = 4;

// --- Turning parts over (turning.cpp, turn_search.cpp) ---

// Cosines. Faces whose normals make a larger angle than this belong to different parts: where an inside-out
// part begins, the normals jump. No single threshold fits all surfaces, so each gives candidates. So do faces
// with longest edges over the median one by such factors.
constexpr double kCreases[] = {0.0, 0.3, 0.5, 0.7, 0.85, 0.95};
constexpr double kStretches[] = {4, 10};
// Of a part's area that must have negative winding in front: the rest may lie inside other parts.
constexpr double kNegativeShare = 0.25;
// Parts that are tried, the largest first, and faces that one has at least.
constexpr std::size_t kMostTurnedParts = 8, kFewestFaces = 4;
// Samples of one face.
constexpr int kMostSamples = 40;
// Directions across a part, over half a turn.
constexpr int kAngles = 8;
// Cosine between a direction and a normal: no wall across it.
constexpr double kGrazing = 0.05;
// How strongly vertices stay where no pair of walls moves them.
constexpr double kStay = 1e-3;
// Of the distance between two walls: the thickness they get, the likeliest first; and rings around the part
// that follow.
constexpr double kThickness[] = {0.3, 0.2, 0.1, 0.5, 0.05};
constexpr int kFollowers[] = {0, 1, 3, 6};
// Parts that are turned, one after the other.
constexpr int kMostTurns = 6;
// Ways of turning a part that are looked at closely, and that are kept.
constexpr std::size_t kRefinedTurns = 3, kMostTurnTrials = 8;
// Rings around turned parts in which only gentle steps are taken.
constexpr int kTurnedRings = 3;

// --- Moving less (lessening.cpp) ---

// Height over longest edge: no face gets thinner than this, or than it is.
constexpr double kThinnestFace = 1e-3;
// Looks at the whole surface that there must be time for: fewer gain nothing.
constexpr int kFewestLooks = 10;
// Of lengths and factors.
constexpr int kBisections = 5;
// So many groups that are refused together are looked at by themselves.
constexpr std::size_t kOneByOne = 8;
// Passes over single vertices; one that shortens the moves by less than this part, altogether, is the last.
constexpr int kLessenPasses = 4;
constexpr double kPassPays = 0.02;

// --- The least move (least_move.cpp) ---

// Faces in front of which a ball of negative winding is looked for, and balls that are made larger.
constexpr std::size_t kMostFacesLookedAt = 20000, kMostStarts = 8;
// Of the ball's radius: the shortest step, and what counts as larger.
constexpr double kBallPrecision = 1e-3;
// Distances to faces, altogether: a second or so.
constexpr std::int64_t kMostBallWork = 20'000'000;
// Of distances, far more than their rounding: what is said is never too much.
constexpr double kRoundingOfDistances = 1e-9;

}  // namespace overtet
