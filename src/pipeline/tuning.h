// What can be chosen in this room, with units and reasons.
#pragma once

#include <cstddef>

namespace overtet {

// --- The unit box (unit_box.cpp) ---

// Exponents of two. Volumes are products of three differences, which may be 2^-53 of the size: 2^(-3 * 240)
// and 2^(-3 * 53) more still are normal numbers. Extents that differ by more than 2^12 are scaled separately.
constexpr int kMaxExponent = 240, kUniformUpTo = 12;

// Of a face, its height over the size of its coordinates: so flat it is by the rounding of its corners alone.
constexpr double kRoundedHeight = 4 * 0x1p-53;

// --- Routes ---

// With TetGen, for what another route or no mesh at all can stand in for: its flips nearly always end in
// less.
constexpr double kShortPatience = 0.3;
// Every part is compared with every group; beyond this number that takes longer than it saves.
constexpr std::size_t kMostParts = 20000;
// Parts that surround one without a mesh, tried one by one.
constexpr std::size_t kMostCarriers = 3;
// A reverse flow that takes more than this (one to a few minutes) has locked; what it has by then is judged
// as it is.
constexpr double kReverseWork = 2e7, kReverseWorkOfFace = 600;
// Of the time that is left, where there is a limit: for the way back of a flow or a repair, and for a volume
// map.
constexpr double kWayBackTime = 0.4, kMapTime = 0.8;
// Layers around vertices that are locked, which are meshed again; and repairs of what that leaves.
constexpr int kLockedRings = 3, kSolidRepairs = 20;

// --- The way by a surface nearby (nearby_surface.cpp) ---

// How far vertices move, of the diagonal: first far enough for digits, then near enough for small details.
// And no further than this share of the shortest edge.
constexpr double kNudge = 1e-3, kSmallNudge = 1e-4, kNudgeOfEdge = 0.25;
// Of one pull home: work (src/volume_map/volume_map.h), a few seconds; and pulls in turn, among better tets
// each.
constexpr double kHomeWork = 1e8;
constexpr int kPulls = 3;

// --- The repair route (repair_route.cpp). Moves are relative to the diagonal of the surface's box. ---

// Repairs that follow each other where the next stage finds more to repair.
constexpr int kRepairs = 8;
// A move as far as it takes; the way back is still to come. And one that is as good as any smaller one.
constexpr double kFar = 0.6, kGentle = 0.01;
// Work of gentle repairs: the way back does the rest.
constexpr double kShrinkWork = 1e4;
// What is said of a least move: three digits that are printed are never more.
constexpr double kDown = 0.995;
// Rounds of moving less: of far moves, and of gentle ones of many vertices. Of few vertices none is made.
constexpr int kRounds = 8, kGentleRounds = 1;
constexpr std::size_t kFew = 3, kMany = 50;
// Rounds in turn that gain nothing.
constexpr int kIdle = 2, kIdleTooFar = 4;
// What a round leaves at most, to count as one that gains; and what one may leave, of the best, to go on
// from.
constexpr double kGains = 0.97, kWorse = 1.2;
// Times what is allowed: worth the rounds at once; and beyond which eight rounds do not come that far.
constexpr double kPromising = 3, kOutOfReach = 15;
// A round aims at so much of the largest move, where that is too far, and at so much of what is allowed,
// where that is near.
constexpr double kNearer = 0.7, kNearlyAllowed = 0.98;
// What it costs to be too far, in moves: more than anything else.
constexpr double kTooFar = 1e30;
// Times that a surface is drawn straight back.
constexpr int kStraightBack = 2;
// Work (src/volume_map/volume_map.h) of all rounds, about 10 s on one thread; and of a tet that is made or
// improved, in the same unit. And of the time that is left, where there is a limit.
constexpr double kRoundsWork = 2e8, kTetWork = 1000, kRoundsTime = 0.5;

}  // namespace overtet
