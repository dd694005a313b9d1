#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <filesystem>
#include <optional>

#include "overtet/diagnosis.h"
#include "overtet/io.h"
#include "overtet/view.h"
#include "src/cli/commands.h"
#include "src/cli/signals.h"

namespace overtet {

namespace {

std::optional<double> number(std::string_view text) {
  double x = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), x);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return x;
}

// -1: it is no number.
int pixels(std::string_view text) {
  int n = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), n);
  return error == std::errc() && end == text.data() + text.size() ? n : -1;
}

Error usage(const std::string& message) { return {ErrorCode::usage, message}; }

Result<PictureOptions> picture_options(const ViewCommand& command) {
  PictureOptions o;
  if (!command.size.empty()) {
    const std::size_t x = command.size.find('x');
    const std::string_view size = command.size;
    o.width = pixels(size.substr(0, x));
    o.height = x == std::string::npos ? -1 : pixels(size.substr(x + 1));
    if (o.width < 0 || o.height < 0) return usage("--size " + command.size + " is not of the form 1200x900.");
  }
  if (!command.eye.empty()) {
    std::string_view rest = command.eye;
    std::array<double, 3> eye{};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t end = k < 2 ? rest.find(',') : rest.size();
      const auto x = end == std::string_view::npos ? std::nullopt : number(rest.substr(0, end));
      if (!x) return usage("--eye " + command.eye + " is not three numbers, as 1,0,.5 is.");
      eye[k] = *x;
      rest.remove_prefix(std::min(rest.size(), end + 1));
    }
    o.eye = eye;
  }
  if (!command.cut.empty()) {
    const std::size_t axis = std::string("xyz").find(command.cut[0]);
    const bool has_share = command.cut.size() > 2 && command.cut[1] == '=';
    const auto share =
        has_share ? number(std::string_view(command.cut).substr(2)) : std::optional(Cut().share);
    if (axis == std::string::npos || (command.cut.size() > 1 && !has_share) || !share)
      return usage("--cut " + command.cut + " is not an axis, as x or x=.3 is.");
    o.cut = Cut{static_cast<int>(axis), *share};
  }
  const std::pair<const char*, Colouring> colourings[] = {{"layers", Colouring::layers},
                                                          {"label", Colouring::label},
                                                          {"region", Colouring::region},
                                                          {"angle", Colouring::angle},
                                                          {"plain", Colouring::plain}};
  for (const auto& [name, colouring] : colourings)
    if (command.colouring == name) o.colouring = colouring;
  o.apart = command.apart;
  if (Status s = o.validate(); !s) return s.error();
  return o;
}

// What is written of a file, once that is read.
struct Outputs {
  std::string page, picture;  // empty: none
  PageOptions page_options;
  PictureOptions picture_options;

  template <class... What>
  Status write(const RunContext& writing, const What&... what) const {
    if (!picture.empty())
      if (Status s = write_picture(picture, what..., picture_options, writing); !s) return s;
    return page.empty() ? success() : write_page(page, what..., page_options, writing);
  }
};

// Tets if there are any: files of several formats may hold either.
Status write_view(const std::string& path, Outputs outputs, const RunContext& context,
                  const RunContext& writing, Terminal& terminal) {
  outputs.page_options.title = std::filesystem::path(path).filename();
  if (tet_format_of(path)) {
    const Result<LabelledTetMesh> mesh = read_labelled_tets(path, context);
    if (mesh) return outputs.write(writing, mesh.value());
    // A surface of the same format? If it is none either, what is wrong with the tets is said.
    if (!read_surface(path, nullptr, context)) return mesh.error();
  }
  const Result<InputSurface> loaded = load(path, {}, context, terminal);
  if (!loaded) return loaded.error();
  const InputSurface& input = loaded.value();
  // What cannot be diagnosed can be looked at.
  std::optional<Curves> curves;
  if (!input.cleanup.problem) {
    Result<SurfaceDiagnosis> diagnosis = diagnose(input.surface(), context);
    if (!diagnosis) return diagnosis.error();
    for (const HingeDiagnosis& h : diagnosis.value().hinges) {
      const auto p = input.surface().V.row(h.vertex);
      outputs.page_options.marks.push_back({p[0], p[1], p[2]});
    }
    curves = std::move(diagnosis.value().curves);
    outputs.page_options.curves = &*curves;
  }
  outputs.picture_options.marks = outputs.page_options.marks;
  outputs.picture_options.curves = outputs.page_options.curves;
  return outputs.write(writing, input.surface(),
                       input.cleanup.problem ? SurfaceAttributes{} : input.attributes);
}

// By the desktop's own means; false where there is none.
bool open_in_browser(const std::string& path) {
  std::string program = "xdg-open", argument = std::filesystem::absolute(path);
  char* const words[] = {program.data(), argument.data(), nullptr};
  pid_t id = -1;
  if (::posix_spawnp(&id, program.c_str(), nullptr, nullptr, words, environ) != 0) return false;
  int status = 0;
  return ::waitpid(id, &status, 0) == id && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace

int run(const ViewCommand& command, const CommonOptions& common, Terminal& terminal) {
  if (command.page.empty() && command.picture.empty())
    return fail(terminal,
                usage("Name what to write: a page (-o FILE.html), a picture (--png FILE.png) or both."));
  for (const std::string& output : {command.page, command.picture})
    if (!output.empty() && same_file(command.input, output))
      return fail(terminal, usage("The " + std::string(output == command.page ? "page" : "picture") +
                                  " would overwrite the input; choose another name."));
  if (!command.page.empty() && !command.picture.empty() && same_file(command.page, command.picture))
    return fail(terminal, usage("The page and the picture cannot have one name."));
  Outputs outputs{command.page, command.picture, {}, {}};
  if (!command.picture.empty()) {
    Result<PictureOptions> options = picture_options(command);
    if (!options) return fail(terminal, options.error());
    outputs.picture_options = std::move(options).value();
  }
  OutputProbe page, picture;
  if (Status s = command.page.empty() ? success() : page.open(command.page); !s)
    return fail(terminal, s.error());
  if (Status s = command.picture.empty() ? success() : picture.open(command.picture); !s)
    return fail(terminal, s.error());
  const RunContext context = common.context(terminal);
  Watchdog watchdog(context, common.start,
                    [&](const Error& error) { terminal.last_words(with_hint(error)); });
  context.report("read", 0);
  if (Status s = write_view(command.input, std::move(outputs), context, watchdog.writing(context), terminal);
      !s)
    return fail(watchdog, terminal, s.error());
  terminal.clear();
  if (!command.page.empty()) terminal.say(command.page + ": open it in any browser.");
  if (command.open && !open_in_browser(command.page))
    return fail(terminal,
                {ErrorCode::io, "Cannot open " + command.page + ": xdg-open did not work; open it by hand."});
  return 0;
}

}  // namespace overtet
