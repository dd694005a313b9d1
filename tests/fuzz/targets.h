// What is fuzzed: a function for each target that takes the bytes of a file, as scripts/fuzz makes them up,
// reads them and looks at what came out. One that returns has found nothing wrong.
#pragma once

#include <string_view>

namespace overtet::fuzz {

// Surfaces: a file of that extension. What it begins with counts more, as for users.
void obj(std::string_view bytes);
void off(std::string_view bytes);
void ply(std::string_view bytes);
void stl(std::string_view bytes);
void gltf(std::string_view bytes);

// Meshes, read as tets and as a surface.
void medit(std::string_view bytes);
void gmsh(std::string_view bytes);
void vtk_xml(std::string_view bytes);
void vtk(std::string_view bytes);
void abaqus(std::string_view bytes);
// Its .node, .ele and .face file, with a line "%" between them.
void tetgen(std::string_view bytes);

void sizes(std::string_view bytes);
// Handles, a pose of them and a table of their weights, with a line "%" between them.
void handles(std::string_view bytes);
// A compressed file. Also the bytes themselves, compressed.
void gzip(std::string_view bytes);
// Saved stages: stages.json, a surface and a tet mesh, with a line "%" between them.
void resume(std::string_view bytes);
// What a batch writes and reads: its journal, as text and as a summary; a list of models.
void journal(std::string_view bytes);
void manifest(std::string_view bytes);
// A raw surface, three bytes a vertex and three a face (cleanup_target.cpp): clean-up, topology.
void cleanup(std::string_view bytes);

}  // namespace overtet::fuzz
