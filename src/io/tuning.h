// What can be chosen in this room, with units and reasons.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace overtet {

// How long is waited for someone to read from a pipe: who is started together with us may be a little later.
constexpr auto kReaderWait = std::chrono::seconds(2);
// Blocks of lines that are formatted at the same time and then written.
constexpr std::int64_t kTextBlocks = 32;
// Characters that a hidden neighbour's name has after the file's own: dots, the process, an attempt.
constexpr std::size_t kNameEnding = 24;
// Bytes that are gathered before they are written.
constexpr std::size_t kBuffer = 1 << 20;
// Corners of a polygon: up to so many the best ear of all is cut (cubic time), up to so many any ear
// (quadratic), beyond them it becomes a fan.
constexpr std::size_t kBestEarCorners = 64, kMaxEarCorners = 1024;

// Bytes of the name of a label, an array or a solid: longer ones are cut. Each label may have its own, made
// of the names of what it belongs to, so that without a limit names could take the square of a file's size.
constexpr std::size_t kLongestName = 1000;
// Bytes of data of triangles for each byte of the file: a polygon's data are given to each of its triangles,
// which for a polygon of thousands of corners with hundreds of numbers is more than anyone wants.
constexpr std::size_t kMostSpread = 64;

// Characters that a number in an Abaqus file may have: CalculiX reads no more.
constexpr std::size_t kMostCharacters = 20;

// Of weights of a skin, parts of their sum: what is less is 0 in glTF's weights of 16 bits.
constexpr double kLeastSkinWeight = 0.5 / 65535;

}  // namespace overtet
