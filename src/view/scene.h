// What a picture shows, as triangles, lines and points with their colours: computed here, drawn by whoever
// can.
//
// The unit of length is the radius of the mesh about the middle of its bounding box, which is the origin, so
// that single precision is enough for a mesh of any size anywhere. Shading is part of the colours: a light at
// the eye, a flat face a triangle. Internal to src/view.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "overtet/view.h"

namespace overtet::view {

using Colour = std::array<std::uint8_t, 3>;  // red, green, blue

// Colours of the page (page/colours.js), before shading.
Colour plain_colour();
Colour inside_colour();        // of cuts, and of faces seen from inside
Colour group_colour(Index n);  // of labels and regions: numbers 8 apart have the same
Colour layer_colour(Index layers);
Colour angle_colour(double degrees);
Colour mark_colour();

// At `shade` of its brightness: every part times that, so that the hue stays.
Colour shaded(const Colour& colour, double shade);
// Of a triangle seen along a unit vector: from this much, where it is seen edge-on, to 1.
double shade_of(const Eigen::Vector3d& normal, const Eigen::Vector3d& towards_eye);

struct Camera {
  Eigen::Vector3d eye, target, up;  // up: of length 1, across the line of sight
  double height_degrees = 35;       // what is seen from bottom to top
  double near = 0, far = 0;         // along the line of sight: all that is seen lies between
};

struct SceneTriangles {
  enum class From : std::uint8_t { boundary, cut };
  std::vector<float> corners;   // 9 a triangle; counter-clockwise seen from outside, or from beyond the cut
  std::vector<Colour> colours;  // shaded
  std::vector<Index> element;   // the tet, or the face of the surface
  std::vector<From> from;
};

struct Scene {
  Camera camera;
  int width = 0, height = 0;
  SceneTriangles triangles;
  std::vector<float> wires;  // 6 a segment: outlines of tets in the cut, if they are not too small to be seen
  std::vector<float> lines;  // 6 a segment: the curves; they shine through what hides them
  std::vector<float> marks;  // 3 a place, likewise
};

// pre: indices in range, finite coordinates, arrays of the right sizes; options that hold (check in
// view.cpp).
Scene scene_of(const LabelledTetMesh& mesh, const PictureOptions& options);
Scene scene_of(const Surface& surface, const SurfaceAttributes& attributes, const PictureOptions& options);

// How far each vertex is from one end of its component, along edges, from 0 to 1; 0 where it has none. Where
// the solid overlaps itself, its layers have different distances: this is what pulls them apart. `corners`
// numbers an element.
std::vector<double> along_of(const VertexMatrix& V, const std::vector<Index>& elements, int corners);

}  // namespace overtet::view
