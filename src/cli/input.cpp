#include "src/cli/input.h"

#include <utility>

namespace overtet {

namespace {

Status save(const InputOptions& options, const InputSurface& input, const RunContext& context) {
  if (!options.save_map.empty())
    if (Status s = write_text(options.save_map, map_to_json(input.cleanup, input.info.source)); !s) return s;
  if (options.save_cleaned.empty()) return success();
  const Result<SurfaceFormat> format = surface_format_of(options.save_cleaned);
  if (!format) return format.error();
  return write_surface(options.save_cleaned, input.surface(), format.value(), context);
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
  for (const std::string& file : {options.save_map, options.save_cleaned})
    if (!file.empty() && (file == path || options.save_map == options.save_cleaned))
      return Error{ErrorCode::usage,
                   "What is to be saved of the clean-up would overwrite the input, or itself; "
                   "choose another name."};
  if (!options.save_cleaned.empty())
    if (const Result<SurfaceFormat> format = surface_format_of(options.save_cleaned); !format)
      return format.error();
  InputSurface input;
  Result<Surface> read = read_surface(path, &input.info, context);
  if (!read) return read.error();
  CleanupOptions cleaning;
  cleaning.strict = options.strict;
  Result<Cleanup> cleaned = clean_up(read.value(), cleaning, input.info.source, context);
  if (!cleaned) return cleaned.error();
  input.cleanup = std::move(cleaned).value();
  input.source = source_of(input.cleanup, input.info.source);
  for (const std::string& note : input.info.notes) terminal.say(note);
  if (const std::string done = input.cleanup.summary(); !done.empty()) terminal.say(done);
  if (input.cleanup.problem) return input;
  if (Status s = save(options, input, context); !s) return s.error();
  return input;
}

}  // namespace overtet
