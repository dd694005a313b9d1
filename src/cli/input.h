// How every command gets its surface: read, and cleaned up.
#pragma once

#include <cstdint>
#include <string>

#include "overtet/attributes.h"
#include "overtet/cleanup.h"
#include "overtet/io.h"
#include "overtet/report.h"
#include "src/cli/terminal.h"

namespace overtet {

struct InputOptions {
  bool strict = false;       // refuse what a clean-up would change
  std::string save_map;      // file for the numbers of vertices and faces; empty: none
  std::string save_cleaned;  // file for the cleaned surface; empty: none
  std::string save_defects;  // file for the places of what is wrong; empty: none
  int most_places = 10;      // that are listed, of each kind
};

struct InputSurface {
  SurfaceReadInfo info;
  Cleanup cleanup;
  SurfaceSource source;             // of the cleaned surface
  SurfaceAttributes attributes;     // of the cleaned surface; those in `info` are of the given one
  std::int64_t given_vertices = 0;  // before the clean-up

  const Surface& surface() const { return cleanup.surface; }
  // The error's sentence, with the numbers of the file where the surface's are others.
  Error in_file(Error error) const;
};

// Reads and cleans; tells the user what was changed. A surface that cannot be cleaned is no error here: the
// clean-up then has a problem. Errors: usage, io, bad_input (of reading), limit, interrupted.
Result<InputSurface> load(const std::string& path, const InputOptions& options, const RunContext& context,
                          Terminal& terminal);

// What the report says of reading and of the clean-up.
void tell(const InputSurface& input, Report& report);

}  // namespace overtet
