// What can be chosen in this room, with units and reasons; RepairOptions has what its users may choose. Moves
// are measured against the diagonal of the surface's box.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>

#include "src/repair/smoothing.h"

namespace overtet {

// --- Where something is wrong (offences.cpp) ---

// Of the diagonal: so far in front of a face the winding number is looked at (of a vertex, kRounding).
constexpr double kAhead = 1e-6;
// Vertices, faces or samples of faces that a region of negative winding is followed over.
constexpr std::size_t kMostFlooded = 200000;

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
// Tried one by one, the most promising first: parts, and those that are turned one after the other; ways of
// turning them that are kept; groups that are refused together, and balls that are made larger (both below).
constexpr std::size_t kMostTried = 8;
// Faces that a part has at least.
constexpr std::size_t kFewestFaces = 4;
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

// --- Moving less (lessening.cpp) ---

// Height over longest edge: no face gets thinner than this, or than it is.
constexpr double kThinnestFace = 1e-3;
// Of lengths and factors.
constexpr int kBisections = 5;
// Passes over single vertices.
constexpr int kLessenPasses = 4;
// What a pass, or a round of the pipeline, leaves at most of the moves to count as one that gains.
constexpr double kGains = 0.97;

// --- The least move (least_move.cpp) ---

// Distances to faces, altogether: a second or so.
constexpr std::int64_t kMostBallWork = 20'000'000;

}  // namespace overtet
