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
// Steps in all, of gluings and of all links (about a second each); then the matter is left undecided.
constexpr std::int64_t kMostGluingSteps = 4'000'000;
// Steps of the first attempt; each one after it, which knows where the last ones failed, may take half as
// many more.
constexpr std::int64_t kFirstSteps = 10'000;
// Steps of a search that should be short, as most take a few hundred: near wound edges, and whether a
// conflict is still one without some condition (or as many as the conflict itself has taken).
constexpr std::int64_t kFewSteps = 50'000;
// Where the search is too long, so many conditions around a hinge are tried by themselves, and more as long
// as that is quick; with few steps at first.
constexpr std::size_t kNear[] = {10, 20, 40, 60, 80, 100, 120, 160};
constexpr std::size_t kMostHinges = 32;
constexpr std::int64_t kStepsNear[] = {100'000, 4'000'000};

// --- Vertex links (link.cpp, shared_points.cpp) ---

// A longer search counts as undecided, as do more layers than the last of kSheets. scripts/check_witness
// repeats the search.
constexpr std::int64_t kMostStepsOfLink = 200'000;

// --- Wound edges (wound_edges.cpp) ---

// So many times as much as an edge weighs one that others pierce, whose points are hard to take off the
// boundary; and so many times as much as that a closed chain through a hinge, where others may do. An edge of
// mean length adds the inverse, so that lengths decide between equal counts only.
constexpr double kFarMore = 1000;
// Subsets of so many ends are enumerated.
constexpr int kExactEnds = 16;

}  // namespace overtet
