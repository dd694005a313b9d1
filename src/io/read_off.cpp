#include <algorithm>
#include <cmath>

#include "src/io/face_groups.h"
#include "src/io/surface_parts.h"
#include "src/io/text.h"

namespace overtet::io_detail {

namespace {

// After the coordinates come, as the header says, normals, colours and texture coordinates; after the corners
// of a face the number of a colour, or three or four parts of it.
void take_colours(const Extras& vertices, const Extras& faces, std::string_view header, Polygons& out) {
  const std::size_t count = out.xyz.size() / 3;
  const bool texture = header.starts_with("ST");
  if (texture) header.remove_prefix(2);
  const bool colour = header.starts_with("C");
  const std::size_t first = header.substr(colour ? 1 : 0).starts_with("N") ? 3 : 0, last = texture ? 2 : 0;
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
                    [](double x) { return x == std::floor(x) && std::abs(x) < 1e9; }))
      out.attributes.faces.of.assign(numbers.begin(), numbers.end());
    return;
  }
  Labels labels = labels_by_value(data.back());
  // A colour for nearly every face is a picture and no label.
  if (2 * labels.names.size() <= out.sizes.size()) out.attributes.faces = std::move(labels);
}

}  // namespace

// Vertices and faces are one a line; what follows the coordinates or the indices (colours, normals) is
// carried along. "4OFF" and "nOFF" (other dimensions) and the binary variant are refused.
Result<Polygons> parse_off(std::string_view name, std::string_view bytes, SurfaceReadInfo& info) {
  if (const std::int64_t line = line_of_nul(bytes))
    return malformed(name, "line " + std::to_string(line) + " contains a NUL byte, so it is not text");
  TextCursor in(name, bytes, true);
  if (!in.to_token()) return malformed(name, "the file is empty");
  std::string_view header = in.token();
  info.format = std::string(header);
  for (const std::string_view prefix : {"ST", "C", "N"})
    if (header.substr(0, prefix.size()) == prefix) header.remove_prefix(prefix.size());
  if (header != "OFF")
    return malformed(name, quoted(info.format) + " is not a variant of OFF that Overtet reads");
  if (!in.to_token()) return malformed(name, "the file ends before the numbers of vertices and faces");
  std::int64_t vertices = 0, faces = 0;
  if (!in.integer(vertices, [] { return "the number of vertices"; })) return in.error();
  if (!in.integer(faces, [] { return "the number of faces"; })) return in.error();
  std::int64_t edges = 0;
  if (!in.at_line_end() && !in.integer(edges, [] { return "the number of edges"; })) return in.error();
  if (vertices < 0 || faces < 0) {
    in.fail(std::to_string(vertices < 0 ? vertices : faces) + " cannot be a number of " +
            (vertices < 0 ? "vertices" : "faces"));
    return in.error();
  }
  // The shortest vertex line is "0 0 0\n", the shortest face line "3 0 1 2\n".
  const auto left = static_cast<std::int64_t>(in.bytes_left()) + 1;
  if (vertices > kMaxCount || faces > kMaxCount || vertices > left / 6 || faces > left / 8 ||
      6 * vertices + 8 * faces > left + 1) {
    in.fail("the file is too short for " + std::to_string(vertices) + " vertices and " +
            std::to_string(faces) + " faces");
    return in.error();
  }
  in.next_line();

  Polygons out;
  Extras after_vertices, after_faces;
  out.xyz.resize(static_cast<std::size_t>(3 * vertices));
  for (std::int64_t v = 0; v < vertices; ++v) {
    if (!in.to_token())
      return malformed(
          name, "the file ends after " + std::to_string(v) + " of " + std::to_string(vertices) + " vertices");
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
    const auto which = [&] { return "face " + std::to_string(f); };
    if (!in.to_token())
      return malformed(
          name, "the file ends after " + std::to_string(f) + " of " + std::to_string(faces) + " faces");
    std::int64_t size = 0;
    if (!in.integer(size, which)) return in.error();
    if (size >= 3 && size < 1000 && size > static_cast<std::int64_t>(in.bytes_left()))
      return malformed(name, "the file ends inside face " + std::to_string(f));
    if (size < 3 || size > static_cast<std::int64_t>(in.bytes_left())) {
      in.fail("a face cannot have " + std::to_string(size) + " corners (" + which() + ")");
      return in.error();
    }
    for (std::int64_t k = 0; k < size; ++k) {
      std::int64_t v = 0;
      if (!in.integer(v, which)) return in.error();
      if (v < 0 || v >= vertices) {
        in.fail("there is no vertex " + std::to_string(v) + "; vertices are numbered from 0 to " +
                std::to_string(vertices - 1) + " (" + which() + ")");
        return in.error();
      }
      out.corners.push_back(static_cast<Index>(v));
    }
    out.sizes.push_back(static_cast<Index>(size));
    after_faces.read(in, static_cast<std::size_t>(f));
    in.next_line();
  }
  take_colours(after_vertices, after_faces, info.format, out);
  return out;
}

}  // namespace overtet::io_detail
