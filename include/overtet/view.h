// A page that shows a tet mesh or a surface: one HTML file that needs nothing else, no network and no server.
//
// It draws what shows of the mesh: a cutting plane can be moved through it, tets can be shrunken, coloured by
// layers, labels, regions and dihedral angles, and layers that overlap can be pulled apart. An element that
// is picked says its number, region, label and angles. Coordinates on the page are rounded to single
// precision; the mesh itself is not touched.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "overtet/attributes.h"
#include "overtet/curves.h"
#include "overtet/result.h"
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
Status write_page(const std::string& path, const LabelledTetMesh& mesh, const PageOptions& options = {});
Status write_page(const std::string& path, const Surface& surface, const SurfaceAttributes& attributes,
                  const PageOptions& options = {});

}  // namespace overtet
