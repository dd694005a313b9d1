// What can be chosen in this room, with units and reasons.
#pragma once

namespace overtet::view {

// Pixels that the edges of tets in a cut are long on average at least where they are drawn: shorter ones
// would be a grey haze.
constexpr double kShortestWire = 5;
// A picture is drawn so many times as wide and as high, and each pixel is the mean of a square: smooth edges.
// That of a picture of 4096 pixels is below the 16384 that OpenGL's renderers have room for.
constexpr int kSamples = 3;

}  // namespace overtet::view
