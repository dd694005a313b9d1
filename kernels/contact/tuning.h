// What can be chosen in this room, with units and reasons.
#pragma once

namespace overtet {

// Part of the local mean edge that a vertex may move before the remembered pairs are looked for again:
// between these two, by how fast the last steps were.
constexpr double kSkinLeast = 0.005, kSkinMost = 0.1;
// Lengths may grow by this factor before that.
constexpr double kSkinGrowth = 1.3;
// Of the present distance of two primitives: what a safe step leaves.
constexpr double kKeep = 0.1;
// Of conservative advancement: each goes most of the way that is left, and what is reached is safe.
constexpr int kAdvances = 64;

}  // namespace overtet
