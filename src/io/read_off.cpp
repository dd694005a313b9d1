#include <algorithm>
#include <cmath>

#include "src/io/face_groups.h"
#include "src/io/surface_parts.h"
#include "src/io/text.h"

namespace overtet::io_detail {

namespace {

// "OFF", or a variant whose lines begin in the same way; the order of the prefixes is not held against it.
Status check_variant(std::string_view name, std::string_view word) {
  std::string_view rest = word;
  for (bool found = true; found;) {
    found = false;
    for (const std::string_view prefix : {"ST", "C", "N"})
      if (rest.substr(0, prefix.size()) == prefix) rest.remove_prefix(prefix.size()), found = true;
  }
  if (rest == "OFF" || word == "off") return success();
  if (rest == "4OFF" || rest == "nOFF" || rest == "4nOFF")
    return malformed(
        name, quoted(word) + " is a surface in another dimension; Overtet reads three coordinates a vertex");
  return malformed(name, quoted(word) + " is not a variant of OFF that Overtet reads");
}

// After the coordinates come, as the header says, normals, colours and texture coordinates; after the corners
// of a face the number of a colour, or three or four parts of it.
void take_colours(const Extras& vertices, const Extras& faces, std::string_view header, Polygons& out) {
  const std::size_t count = out.xyz.size() / 3;
  const auto has = [&](const char* what) { return header.find(what) != std::string_view::npos; };
  const bool texture = has("ST"), colour = has("C");
  const std::size_t first = has("N") ? 3 : 0, last = texture ? 2 : 0;
  const std::size_t width = vertices.each() - std::min(vertices.each(), first + last);
  if (colour && (width == 3 || width == 4))
    vertices.take(count, first, static_cast<int>(width), "colour", out.attributes.vertex_data);
  if (texture && vertices.each() >= first + last)
    vertices.take(count, vertices.each() - 2, 2, "uv", out.attributes.vertex_data);

  std::vector<Attribute>& data = out.attributes.face_data;
  const std::size_t parts = faces.each();
  if ((parts != 1 && parts != 3 && parts != 4) ||
      !faces.take(out.sizes.size(), 0, static_cast<int>(parts), "colour", data))
    return;
  if (parts == 1) {
    const std::vector<double>& numbers = data.back().values;
    if (std::all_of(numbers.begin(), numbers.end(),
                    [](double x) { return x == std::floor(x) && std::abs(x) <= double{kMaxCount}; }))
      out.attributes.faces.of.assign(numbers.begin(), numbers.end());
    return;
  }
  Labels labels = labels_by_value(data.back());
  // A colour for nearly every face is a picture and no label.
  if (2 * labels.names.size() <= out.sizes.size()) out.attributes.faces = std::move(labels);
}

struct Counts {
  std::int64_t vertices = 0, faces = 0;
};

// False: the cursor has the error.
bool read_counts(TextCursor& in, Counts& n) {
  if (!in.integer(n.vertices, [] { return "the number of vertices"; })) return false;
  if (!in.integer(n.faces, [] { return "the number of faces"; })) return false;
  std::int64_t edges = 0;
  if (!in.at_line_end() && !in.integer(edges, [] { return "the number of edges"; })) return false;
  if (n.vertices < 0 || n.faces < 0)
    return in.fail(std::to_string(n.vertices < 0 ? n.vertices : n.faces) + " cannot be a number of " +
                   (n.vertices < 0 ? "vertices" : "faces"));
  // The shortest vertex line is "0 0 0\n", the shortest face line "3 0 1 2\n".
  const auto left = static_cast<std::int64_t>(in.bytes_left()) + 1;
  if (n.vertices > kMaxCount || n.faces > kMaxCount || n.vertices > left / 6 || n.faces > left / 8 ||
      6 * n.vertices + 8 * n.faces > left + 1)
    return in.fail("the file is too short for " + std::to_string(n.vertices) + " vertices and " +
                   std::to_string(n.faces) + " faces");
  in.next_line();
  return true;
}

// A face is on one line, with what may follow (colours); or on several, which nothing else is on. False: the
// cursor has the error.
bool read_face(TextCursor& in, std::int64_t f, std::int64_t vertices, Extras& after, Polygons& out) {
  const auto which = [&] { return "face " + std::to_string(f); };
  std::int64_t size = 0;
  const std::int64_t line = in.line();
  if (!in.integer(size, which)) return false;
  if (size >= 3 && size < 1000 && size > static_cast<std::int64_t>(in.bytes_left()))
    return in.fail("the file ends inside face " + std::to_string(f));
  if (size < 3 || size > static_cast<std::int64_t>(in.bytes_left()))
    return in.fail("a face cannot have " + std::to_string(size) + " corners (" + which() + ")");
  for (std::int64_t k = 0; k < size; ++k) {
    std::int64_t v = 0;
    if (in.at_line_end() && !in.to_token()) return in.fail("the file ends inside face " + std::to_string(f));
    if (!in.integer(v, which)) return false;
    if (v < 0 || v >= vertices)
      return in.fail("there is no vertex " + std::to_string(v) + "; vertices are numbered from 0 to " +
                     std::to_string(vertices - 1) + " (" + which() + ")");
    out.corners.push_back(static_cast<Index>(v));
  }
  if (in.line() != line && !in.at_line_end())
    return in.fail_at(line,
                      "a number is missing, or the line that the face ends on goes on (" + which() + ")");
  out.sizes.push_back(static_cast<Index>(size));
  after.read(in, static_cast<std::size_t>(f));
  in.next_line();
  return true;
}

}  // namespace

// Vertices are one a line; what follows the coordinates (colours, texture) is carried along.
Result<Polygons> parse_off(std::string_view name, std::string_view bytes, SurfaceReadInfo& info) {
  if (const std::int64_t line = line_of_nul(bytes))
    return malformed(name, "line " + std::to_string(line) + " contains a NUL byte, so it is not text");
  TextCursor in(name, bytes, true);
  if (!in.to_token()) return malformed(name, "the file is empty");
  const std::string_view header = in.token();
  info.format = std::string(header);
  if (Status s = check_variant(name, header); !s) return s.error();
  if (!in.to_token()) return malformed(name, "the file ends before the numbers of vertices and faces");
  if (!in.at_line_end() && bytes.substr(bytes.size() - in.bytes_left(), 6) == "BINARY")
    return malformed(name, "binary OFF is not read; write it as text, or as PLY");
  Counts n;
  if (!read_counts(in, n)) return in.error();
  const auto [vertices, faces] = n;
  Polygons out;
  Extras after_vertices, after_faces;
  out.xyz.resize(static_cast<std::size_t>(3 * vertices));
  out.vertex_line.reserve(static_cast<std::size_t>(vertices));
  out.face_line.reserve(static_cast<std::size_t>(faces));
  for (std::int64_t v = 0; v < vertices; ++v) {
    if (!in.to_token())
      return malformed(
          name, "the file ends after " + std::to_string(v) + " of " + std::to_string(vertices) + " vertices");
    out.vertex_line.push_back(static_cast<std::uint32_t>(in.line()));
    for (int k = 0; k < 3; ++k)
      if (!in.real(out.xyz[static_cast<std::size_t>(3 * v + k)],
                   [&] { return "vertex " + std::to_string(v); }))
        return in.error();
    after_vertices.read(in, static_cast<std::size_t>(v));
    in.next_line();
  }
  out.corners.reserve(static_cast<std::size_t>(3 * faces));
  out.sizes.reserve(static_cast<std::size_t>(faces));
  for (std::int64_t f = 0; f < faces; ++f) {
    if (!in.to_token())
      return malformed(
          name, "the file ends after " + std::to_string(f) + " of " + std::to_string(faces) + " faces");
    out.face_line.push_back(static_cast<std::uint32_t>(in.line()));
    if (!read_face(in, f, vertices, after_faces, out)) return in.error();
  }
  take_colours(after_vertices, after_faces, info.format, out);
  return out;
}

}  // namespace overtet::io_detail
