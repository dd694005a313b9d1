// What can be chosen in this room, with units and reasons. Steps are gluings of single regions that are
// looked at.
#pragma once

#include <cstddef>
#include <cstdint>

namespace overtet {

// --- Gluings (gluing.cpp, gluing_search.cpp) ---

// Conditions of regions with at most so many sheets inside are tried first; then deeper ones, too. Beyond the
// last number a region has too many gluings.
constexpr int kSheets[] = {3, 4, 6};
// Steps in all (about a second); then the matter is left undecided.
constexpr std::int64_t kMostGluingSteps = 4'000'000;
// Steps of the first attempt; each one after it, which knows where the last ones failed, may take half as
// many more.
constexpr std::int64_t kFirstSteps = 10'000;
// To find out whether a conflict is still one without some condition: so many steps, or so many times what
// the conflict itself has taken.
constexpr std::int64_t kMostStepsToDrop = 50'000, kTimesToDrop = 2;
// Where the search is too long, so many conditions around a hinge are tried by themselves, and more as long
// as that is quick; with few steps at first.
constexpr std::size_t kNear[] = {10, 20, 40, 60, 80, 100, 120, 160};
constexpr std::size_t kMostHinges = 32;
constexpr std::int64_t kStepsNear[] = {100'000, 4'000'000};
// Steps in all, to find conflicts near hinges, and to make a conflict small (some seconds each).
constexpr std::int64_t kMostStepsToName = 24'000'000;

// --- Vertex links (link.cpp, shared_points.cpp) ---

// More layers, or a longer search, count as undecided. scripts/check_witness repeats the search.
constexpr int kMostLayers = 6;
constexpr std::int64_t kMostStepsOfLink = 200'000;
// Steps of all links: a second or two.
constexpr std::int64_t kMostLinkSteps = 5'000'000;
// Places that are tried on a piece of an edge.
constexpr int kPlacesOnEdge = 4;

// --- Wound edges (wound_edges.cpp) ---

// In edges: what one that others pierce weighs, what an edge of mean length adds, so that it decides between
// equal counts only, and what a closed chain through a hinge costs, where others may do.
constexpr double kPiercedCost = 1000, kLengthCost = 1e-3, kClosedCost = 1e6;
// Subsets of so many ends are enumerated.
constexpr int kExactEnds = 16;

}  // namespace overtet
