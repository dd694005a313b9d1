#include "src/cli/input.h"

#include <iterator>
#include <utility>

#include "src/cli/commands.h"

namespace overtet {

namespace {

Status save(const InputOptions& options, const InputSurface& input, const RunContext& context) {
  if (!options.save_map.empty())
    if (Status s = write_text(options.save_map, map_to_json(input.cleanup, input.info.source)); !s) return s;
  if (options.save_cleaned.empty()) return success();
  const Result<SurfaceFormat> format = surface_format_of(options.save_cleaned);
  if (!format) return format.error();
  return write_surface(options.save_cleaned, input.surface(), format.value(), context,
                       &input.attributes.faces);
}

// The names of what is to be saved.
Status check(const std::string& path, const InputOptions& o) {
  const std::string* const files[] = {&path, &o.save_map, &o.save_cleaned, &o.save_defects};
  for (std::size_t i = 1; i < std::size(files); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (same_file(*files[i], *files[j]))
        return Error{ErrorCode::usage, "Two files that are read or written are both called " + *files[i] +
                                           "; choose another name for one of them."};
  if (!o.save_cleaned.empty())
    if (const Result<SurfaceFormat> format = surface_format_of(o.save_cleaned); !format)
      return format.error();
  if (!o.save_defects.empty())
    if (const Result<CurveFormat> format = curve_format_of(o.save_defects); !format) return format.error();
  return success();
}

}  // namespace

Error InputSurface::in_file(Error error) const {
  if (error.face < 0 || error.face >= surface().F.rows()) return error;
  if (source.face_in_file(error.face) == error.face && source.first == 0 && source.face_line.empty())
    return error;
  error.message += " In the file it is " + source.face_name(error.face) + ".";
  return error;
}

Result<InputSurface> load(const std::string& path, const InputOptions& options, const RunContext& context,
                          Terminal& terminal) {
  if (Status s = check(path, options); !s) return s.error();
  InputSurface input;
  Result<Surface> read = read_surface(path, &input.info, context);
  if (!read) return read.error();
  input.given_vertices = read.value().V.rows();
  CleanupOptions cleaning;
  cleaning.strict = options.strict;
  cleaning.most_places = options.most_places;
  Result<Cleanup> cleaned = clean_up(read.value(), cleaning, input.info.source, context);
  if (!cleaned) return cleaned.error();
  input.cleanup = std::move(cleaned).value();
  input.source = source_of(input.cleanup, input.info.source);
  SurfaceAttributes attributes = std::move(input.info.attributes);
  if (attributes.input_face.empty()) attributes.input_face = input.info.source.face;
  if (attributes.input_vertex.empty()) attributes.input_vertex = input.info.source.vertex;
  input.attributes = carried(attributes, input.cleanup.vertex_of, input.cleanup.face_of);
  for (const std::string& note : input.info.notes) terminal.say(note);
  if (const std::string done = input.cleanup.summary(); !done.empty()) terminal.say(done);
  if (!options.save_defects.empty())
    if (Status s = write_defects(options.save_defects, read.value(), input.cleanup.defects,
                                 curve_format_of(options.save_defects).value());
        !s)
      return s.error();
  if (input.cleanup.problem) return input;
  if (Status s = save(options, input, context); !s) return s.error();
  return input;
}

void tell(const InputSurface& input, Report& report) {
  report.input.format = input.info.format;
  report.input.notes = input.info.notes;
  if (input.cleanup.changed()) report.input.cleanup = record_of(input.cleanup, input.info.source);
}

}  // namespace overtet
