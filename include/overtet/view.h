// Tet meshes and surfaces to look at: as a page, and as a picture.
//
// A page is one HTML file that needs nothing else, no network and no server. It draws what shows of the mesh:
// a cutting plane can be moved through it, tets can be shrunken, coloured by layers, labels, regions and
// dihedral angles, and layers that overlap can be pulled apart. An element that is picked says its number,
// region, label and angles. Coordinates on the page are rounded to single precision; the mesh itself is not
// touched.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "overtet/attributes.h"
#include "overtet/curves.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

struct PageOptions {
  std::string title;                         // usually the name of the file
  const Curves* curves = nullptr;            // to draw: where the surface crosses itself
  std::vector<std::array<double, 3>> marks;  // places to mark: hinges, a witness
};

// Arrays of attributes that are empty are not shown; the others have the sizes that attributes.h says. The
// file appears whole or not at all (io.h). Errors: bad_input (an index out of range, a coordinate that is not
// finite, an array of another size), io. May throw std::bad_alloc.
Status write_page(const std::string& path, const LabelledTetMesh& mesh, const PageOptions& options = {},
                  const RunContext& context = {});
Status write_page(const std::string& path, const Surface& surface, const SurfaceAttributes& attributes,
                  const PageOptions& options = {}, const RunContext& context = {});

// What a tet or a face is coloured by; what the input does not have is an error.
enum class Colouring {
  automatic,  // the first of layers (if there is a place with two), label, region, angle and plain
  layers,     // of tets: how often the solid is there
  label,      // of the boundary
  region,     // of tets
  angle,      // of tets: the smallest dihedral angle
  plain       // one colour
};

// A plane across an axis: what lies beyond it is left out.
struct Cut {
  int axis = 0;       // 0 x, 1 y, 2 z
  double share = .5;  // of the bounding box along the axis, from its lower end: 0 to 1
};

struct PictureOptions {
  int width = 1200, height = 900;            // pixels: 16 to 4096
  std::optional<std::array<double, 3>> eye;  // the direction to it from the mesh; none: one that sees the cut
  Colouring colouring = Colouring::automatic;
  std::optional<Cut> cut;                    // surfaces then show their inner side
  double apart = 0;                          // layers pulled apart: 0 to 1
  const Curves* curves = nullptr;            // to draw: where the surface crosses itself
  std::vector<std::array<double, 3>> marks;  // places to mark: hinges, a witness
  // The program overtet-picture. Empty: beside the running program, else where this installation has it.
  std::string helper;

  Status validate() const;  // errors: usage
};

// The background is white; all of the mesh is in the picture. The same input gives the same bytes on a
// machine (other versions of VTK and Mesa may round edges of faces differently). The file appears whole or
// not at all. Errors: usage (options that do not hold, or that the input has nothing for), bad_input as
// above, io (the file cannot be written, the program is missing or cannot draw), limit, interrupted. May
// throw std::bad_alloc.
Status write_picture(const std::string& path, const LabelledTetMesh& mesh, const PictureOptions& options = {},
                     const RunContext& context = {});
Status write_picture(const std::string& path, const Surface& surface, const SurfaceAttributes& attributes,
                     const PictureOptions& options = {}, const RunContext& context = {});

}  // namespace overtet
