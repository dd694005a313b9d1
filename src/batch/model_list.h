// What a batch has to mesh: the surfaces of a folder, or those that a manifest names; and which of them
// belong to a shard.
//
// A manifest is text, a model a line: the path of a surface, relative to the manifest's folder. Empty lines
// and lines that begin with # are skipped. A line that begins with { is JSON:
//
//     {"input": "scans/hand 3.obj", "output": "hands/3", "options": ["--improve", "20"]}
//
// where "output" (the name of the results, without an ending) and "options" (after those of all models) may
// be left out. So any name can be written, one with a line end in it, too.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "overtet/result.h"

namespace overtet {

struct Model {
  std::string path;  // to open
  std::string name;  // of its results, without an ending: a relative path, no two of a list are alike
  std::vector<std::string> options;
  std::int64_t bytes = 0;  // 0 where there is no such file
};

// The models, sorted by name. In a folder: all files in it and below that are named like a surface
// (is_surface_name), but not those in `except` (the folder of the results); links to files are followed,
// links to folders are not. A model's name is its path in the folder, or as the manifest has it without ..
// and a leading /, without the ending; where that is the same for several, the ending stays, and where that
// is the same, too, they get numbers in the order of the manifest. Errors: io; bad_input (a line of a
// manifest).
Result<std::vector<Model>> models_of(const std::string& manifest_or_folder, const std::string& except);

// The same from the text of a manifest in `folder`. Errors: bad_input, with the line.
Result<std::vector<Model>> models_of_manifest(const std::string& text, const std::string& folder,
                                              const std::string& manifest_name);

// .obj, .off, .ply, .stl, .glb, .gltf or .vtp, in any case, perhaps with .gz. (.mesh, .msh, .vtu and .vtk are
// more often tet meshes; a manifest can name them.)
bool is_surface_name(const std::string& name);

// Biggest first; equally big ones by name.
void sort_by_size(std::vector<Model>& models);

// One of `count` parts of the list, number `index` from 1, so that all have about the same bytes to read:
// each model, biggest first, goes to the part that has least. It depends on the list alone.
std::vector<Model> shard_of(std::vector<Model> models, int index, int count);

}  // namespace overtet
