#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <span>

#include "kernels/core/tuning.h"
#include "overtet/view.h"
#include "src/io/filled_file.h"
#include "src/io/png.h"
#include "src/run/helper_program.h"
#include "src/view/checks.h"
#include "src/view/picture_wire.h"
#include "src/view/scene.h"
#include "src/view/tuning.h"

namespace overtet {

namespace {

using view::Scene;
using view::picture_wire::Request;

Error cannot_draw(const std::string& why) { return {ErrorCode::io, "Cannot draw a picture: " + why + "."}; }
Error system_failure(const char* what, int code = errno) {
  return cannot_draw(std::string(what) + ": " + std::strerror(code));
}

class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { close(); }
  void close() {
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
  }
  int get() const { return fd_; }
  bool ok() const { return fd_ >= 0; }

 private:
  int fd_ = -1;
};

// The process that draws; killed and reaped when this goes out of scope, whatever happened.
class Painter {
 public:
  Painter() = default;
  Painter(const Painter&) = delete;
  Painter& operator=(const Painter&) = delete;
  ~Painter() {
    if (id_ <= 0) return;
    kill(id_, SIGKILL);
    reap();
  }

  Status start(const std::string& program, int in, int out, int complaints) {
    std::string name = "overtet-picture", parent = std::to_string(getpid());
    char* argv[] = {name.data(), parent.data(), nullptr};
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, in, 0);
    posix_spawn_file_actions_adddup2(&actions, out, 1);
    posix_spawn_file_actions_adddup2(&actions, complaints, 2);
    const int failed = start_helper(program, argv, actions, id_);
    posix_spawn_file_actions_destroy(&actions);
    if (failed != 0) id_ = -1;
    return failed == 0 ? success() : Status(system_failure(program.c_str(), failed));
  }

  int reap() {
    int status = 0;
    while (waitpid(id_, &status, 0) < 0 && errno == EINTR) {
    }
    id_ = -1;
    return status;
  }

 private:
  pid_t id_ = -1;
};

// What comes until the other end is closed; of very much the end.
Result<std::string> read_complaints(int fd, const RunContext& context) {
  std::string all;
  for (;;) {
    if (auto error = context.stop()) return *error;
    pollfd p{fd, POLLIN, 0};
    if (poll(&p, 1, static_cast<int>(kLookPeriod.count())) <= 0) continue;
    char bytes[1024];
    const ssize_t got = read(fd, bytes, sizeof bytes);
    if (got < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (got <= 0) return all;
    all.append(bytes, static_cast<std::size_t>(got));
    if (all.size() > 1 << 16) all.erase(0, all.size() / 2);
  }
}

template <class T>
std::span<const char> bytes_of(const T* data, std::size_t count) {
  return {reinterpret_cast<const char*>(data), count * sizeof(T)};
}

Status write_scene(const Scene& scene, int fd) {
  Request r;
  r.width = scene.width, r.height = scene.height, r.samples = view::kSamples;
  for (int k = 0; k < 3; ++k) {
    r.eye[k] = scene.camera.eye[k], r.target[k] = scene.camera.target[k], r.up[k] = scene.camera.up[k];
    r.mark_colour[k] = view::mark_colour()[static_cast<std::size_t>(k)];
  }
  r.height_degrees = scene.camera.height_degrees, r.near = scene.camera.near, r.far = scene.camera.far;
  r.triangles = static_cast<std::int64_t>(scene.triangles.colours.size());
  r.wires = static_cast<std::int64_t>(scene.wires.size() / 6);
  r.lines = static_cast<std::int64_t>(scene.lines.size() / 6);
  r.marks = static_cast<std::int64_t>(scene.marks.size() / 3);
  for (std::span<const char> bytes :
       {bytes_of(&r, 1), bytes_of(scene.triangles.corners.data(), scene.triangles.corners.size()),
        bytes_of(scene.triangles.colours.data(), scene.triangles.colours.size()),
        bytes_of(scene.wires.data(), scene.wires.size()), bytes_of(scene.lines.data(), scene.lines.size()),
        bytes_of(scene.marks.data(), scene.marks.size())})
    while (!bytes.empty()) {
      const ssize_t put = write(fd, bytes.data(), bytes.size());
      if (put < 0 && errno == EINTR) continue;
      if (put <= 0) return system_failure("write");
      bytes = bytes.subspan(static_cast<std::size_t>(put));
    }
  return lseek(fd, 0, SEEK_SET) == 0 ? success() : Status(system_failure("lseek"));
}

Result<std::vector<std::uint8_t>> read_pixels(int fd, const Scene& scene) {
  std::vector<std::uint8_t> pixels(3 * static_cast<std::size_t>(scene.width) *
                                   static_cast<std::size_t>(scene.height));
  std::size_t at = 0;
  while (at < pixels.size()) {
    const ssize_t got = pread(fd, pixels.data() + at, pixels.size() - at, static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return cannot_draw("overtet-picture made no whole picture");
    at += static_cast<std::size_t>(got);
  }
  return pixels;
}

Result<std::string> picture_helper(const PictureOptions& options) {
  if (!options.helper.empty()) {
    if (can_run(options.helper)) return options.helper;
    return cannot_draw("the program overtet-picture does not run as " + options.helper);
  }
  if (const std::optional<std::string> path = helper_program("overtet-picture")) return *path;
  return Error{
      ErrorCode::io,
      "This build has no pictures: the program overtet-picture, which draws them with VTK, is missing; "
      "install the package overtet-pictures, or libvtk9-dev and libegl-dev and build Overtet again."};
}

Result<std::vector<std::uint8_t>> drawn(const Scene& scene, const std::string& program,
                                        const RunContext& context) {
  context.report("draw", 0);
  Descriptor in(memfd_create("scene", MFD_CLOEXEC)), out(memfd_create("picture", MFD_CLOEXEC));
  int ends[2] = {-1, -1};
  if (!in.ok() || !out.ok() || pipe2(ends, O_CLOEXEC) != 0) return system_failure("memfd_create");
  Descriptor complaints(ends[0]), written(ends[1]);
  if (Status s = write_scene(scene, in.get()); !s) return s.error();
  Painter painter;
  if (Status s = painter.start(program, in.get(), out.get(), written.get()); !s) return s.error();
  written.close();
  const Result<std::string> said = read_complaints(complaints.get(), context);
  if (!said) return said.error();
  const int status = painter.reap();
  if (WIFSIGNALED(status))
    return cannot_draw("overtet-picture was ended by signal " + std::to_string(WTERMSIG(status)));
  if (WEXITSTATUS(status) != 0) {
    // One line: the last one, as libraries may have said something before.
    std::string why = said.value().substr(0, said.value().find_last_not_of("\n. ") + 1);
    why = why.substr(why.rfind('\n') + 1);
    return cannot_draw(why.empty() ? "overtet-picture failed" : why);
  }
  return read_pixels(out.get(), scene);
}

Error missing(const char* what) {
  return {ErrorCode::usage, std::string("There is nothing to colour by: the input has no ") + what + "."};
}

Status has_what_is_asked_for(const LabelledTetMesh& m, Colouring by) {
  if (by == Colouring::layers && m.attributes.layers.empty()) return missing("layers");
  if (by == Colouring::region && m.attributes.regions.of.empty()) return missing("regions");
  if (by == Colouring::label && m.attributes.labels.of.empty()) return missing("labels");
  return success();
}

Status has_what_is_asked_for(const SurfaceAttributes& attributes, Colouring by) {
  if (by == Colouring::layers) return missing("layers; it is a surface, and they are those of tets");
  if (by == Colouring::region) return missing("regions; it is a surface, and they are those of tets");
  if (by == Colouring::angle) return missing("dihedral angles of tets; it is a surface");
  if (by == Colouring::label && attributes.faces.of.empty()) return missing("labels");
  return success();
}

template <class MakeScene>
Status write_scene_as_png(const std::string& path, const PictureOptions& options, const RunContext& context,
                          MakeScene&& make_scene) {
  const Result<std::string> program = picture_helper(options);
  if (!program) return program.error();
  if (auto error = context.stop()) return *error;
  const Scene scene = make_scene();
  const Result<std::vector<std::uint8_t>> pixels = drawn(scene, program.value(), context);
  if (!pixels) return pixels.error();
  const std::string png = io_detail::encode_png(scene.width, scene.height, pixels.value());
  return io_detail::write_file(path, context, [&](TextWriter& out) { out.text(png); });
}

}  // namespace

Status PictureOptions::validate() const {
  const auto wrong = [](const char* what) { return Error{ErrorCode::usage, what}; };
  if (std::min(width, height) < 16 || std::max(width, height) > 4096)
    return wrong("A picture is 16 to 4096 pixels wide and high.");
  if (eye) {
    const auto& [x, y, z] = *eye;
    if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(z) || (x == 0 && y == 0 && z == 0))
      return wrong("The direction to the eye must be three finite numbers, not all 0.");
  }
  if (cut && (cut->axis < 0 || cut->axis > 2 || !(cut->share >= 0 && cut->share <= 1)))
    return wrong("A picture is cut across x, y or z, at a share of 0 to 1 of the bounding box.");
  if (!(apart >= 0 && apart <= 1)) return wrong("Layers are pulled apart by 0 to 1.");
  return success();
}

Status write_picture(const std::string& path, const LabelledTetMesh& mesh, const PictureOptions& options,
                     const RunContext& context) {
  if (Status s = options.validate(); !s) return s;
  if (Status s = view::check(mesh); !s) return s;
  if (Status s = has_what_is_asked_for(mesh, options.colouring); !s) return s;
  return write_scene_as_png(path, options, context, [&] { return view::scene_of(mesh, options); });
}

Status write_picture(const std::string& path, const Surface& surface, const SurfaceAttributes& attributes,
                     const PictureOptions& options, const RunContext& context) {
  if (Status s = options.validate(); !s) return s;
  if (Status s = view::check(surface, attributes); !s) return s;
  if (Status s = has_what_is_asked_for(attributes, options.colouring); !s) return s;
  return write_scene_as_png(path, options, context,
                            [&] { return view::scene_of(surface, attributes, options); });
}

}  // namespace overtet
