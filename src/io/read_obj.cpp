#include <algorithm>
#include <cctype>
#include <optional>

#include "src/io/face_groups.h"
#include "src/io/surface_parts.h"
#include "src/io/text.h"

namespace overtet::io_detail {

namespace {

// Texture coordinates belong to corners of faces. They become the vertices' where each has one pair.
class TextureCoordinates {
 public:
  void read(TextCursor& line) { all_.read(line, count_++); }
  // A corner is written as v/vt/vn or v/vt.
  void corner(std::size_t vertex, std::string_view text) {
    const std::size_t slash = text.find('/');
    if (slash == std::string_view::npos) return;
    text = text.substr(slash + 1);
    text = text.substr(0, text.find('/'));
    std::int64_t vt = 0;
    if (std::from_chars(text.data(), text.data() + text.size(), vt).ec != std::errc()) return;
    if (vt < 0) vt += static_cast<std::int64_t>(count_) + 1;
    if (of_vertex_.size() <= vertex) of_vertex_.resize(vertex + 1, 0);
    seams_ |= of_vertex_[vertex] != 0 && of_vertex_[vertex] != vt;
    of_vertex_[vertex] = vt;
  }
  void finish(std::size_t vertices, SurfaceReadInfo& info, std::vector<Attribute>& out) const {
    if (of_vertex_.empty()) return;
    std::vector<Attribute> pairs;
    if (!all_.take(count_, 0, 2, "uv", pairs)) return;
    if (seams_) {
      info.notes.push_back("Some vertices have several texture coordinates; none were carried.");
      return;
    }
    Attribute uv{"uv", NumberType::float64, 2, std::vector<double>(2 * vertices, 0.0)};
    for (std::size_t v = 0; v < of_vertex_.size() && v < vertices; ++v)
      if (const std::int64_t vt = of_vertex_[v]; vt >= 1 && vt <= static_cast<std::int64_t>(count_))
        for (std::size_t k = 0; k < 2; ++k)
          uv.values[2 * v + k] = pairs[0].values[2 * static_cast<std::size_t>(vt - 1) + k];
    out.push_back(std::move(uv));
  }

 private:
  Extras all_;
  std::size_t count_ = 0;
  std::vector<std::int64_t> of_vertex_;  // counted from 1; 0: none
  bool seams_ = false;
};

std::optional<FaceGroups::Kind> group_kind(std::string_view key) {
  if (key == "o") return FaceGroups::solid;
  if (key == "g") return FaceGroups::group;
  if (key == "usemtl") return FaceGroups::material;
  return std::nullopt;
}

bool is_keyword(std::string_view word) {
  const auto in_keyword = [](unsigned char c) { return std::isalnum(c) || c == '_'; };
  return std::isalpha(static_cast<unsigned char>(word[0])) &&
         std::all_of(word.begin(), word.end(), in_keyword);
}

// The vertex that a corner names, as the file does. False: the cursor has the error.
bool read_corner(TextCursor& in, std::string_view corner, std::int64_t face, std::int64_t vertices,
                 std::int64_t& v) {
  const auto which = [&] { return " (face " + std::to_string(face) + ")"; };
  const std::string_view number = corner.substr(0, corner.find('/'));
  const auto [stop, code] = std::from_chars(number.data(), number.data() + number.size(), v);
  if (code != std::errc() || stop != number.data() + number.size())
    return in.fail(quoted(corner) + " does not name a vertex" + which());
  if (v == 0) return in.fail("there is no vertex 0; OBJ numbers vertices from 1" + which());
  if (v < -vertices)
    return in.fail("there are fewer than " + std::string(number.substr(1)) + " vertices before this line" +
                   which());
  return true;
}

}  // namespace

// Reads v and f lines, and what they carry; everything else that looks like an OBJ keyword is ignored.
Result<Polygons> parse_obj(std::string_view name, std::string_view bytes, SurfaceReadInfo& info) {
  info.format = "OBJ";
  info.source.first = 1;
  if (const std::int64_t line = line_of_nul(bytes))
    return malformed(name, "line " + std::to_string(line) + " contains a NUL byte, so it is not text");
  TextCursor in(name, bytes, true);
  Polygons out;
  FaceGroups groups;
  Extras colours;
  TextureCoordinates texture;
  // A face may name a vertex that comes later in the file: the largest such name, checked at the end.
  std::int64_t ahead = 0, ahead_line = 0, ahead_face = 0;
  std::int64_t vertices = 0;
  while (in.to_token()) {
    const std::string_view key = in.token();
    if (key == "v") {
      const auto which = [&] { return "vertex " + std::to_string(vertices + 1); };
      double p[3];
      for (double& x : p)
        if (!in.real(x, which)) return in.error();
      out.xyz.insert(out.xyz.end(), p, p + 3);
      out.vertex_line.push_back(static_cast<std::uint32_t>(in.line()));
      colours.read(in, static_cast<std::size_t>(vertices));
      if (++vertices > kMaxCount)
        return malformed(name,
                         "the file has more than 2147483647 vertices, the most that Overtet can number");
    } else if (key == "f") {
      const auto face = static_cast<std::int64_t>(out.sizes.size()) + 1;
      const auto which = [&] { return "face " + std::to_string(face); };
      Index size = 0;
      out.face_line.push_back(static_cast<std::uint32_t>(in.line()));
      while (!in.at_line_end()) {
        const std::string_view corner = in.token();
        std::int64_t v = 0;
        if (!read_corner(in, corner, face, vertices, v)) return in.error();
        const std::int64_t zero_based = v > 0 ? v - 1 : vertices + v;
        if (v > vertices && v > ahead) ahead = v, ahead_line = in.line(), ahead_face = face;
        if (zero_based > kMaxCount) break;
        out.corners.push_back(static_cast<Index>(zero_based));
        // (A vertex that the rest of the file has no room for must not take memory.)
        if (zero_based < vertices + static_cast<std::int64_t>(in.bytes_left()))
          texture.corner(static_cast<std::size_t>(zero_based), corner);
        ++size;
      }
      if (ahead > kMaxCount) break;
      if (size < 3) {
        in.fail("a face needs at least three corners (" + which() + ")");
        return in.error();
      }
      out.sizes.push_back(size);
    } else if (const std::optional<FaceGroups::Kind> kind = group_kind(key)) {
      groups.begin(*kind, in, out.sizes.size());
    } else if (key == "vt") {
      texture.read(in);
    } else {
      if (!is_keyword(key)) {
        in.fail(quoted(key) + " is not an OBJ keyword");
        return in.error();
      }
    }
    in.next_line();
  }
  if (ahead > vertices) {
    in.fail_at(ahead_line, "there is no vertex " + std::to_string(ahead) + "; the file has " +
                               std::to_string(vertices) + " (face " + std::to_string(ahead_face) + ")");
    return in.error();
  }
  groups.finish(out.sizes.size(), out.attributes);
  if (colours.each() == 3)
    colours.take(static_cast<std::size_t>(vertices), 0, 3, "colour", out.attributes.vertex_data);
  texture.finish(static_cast<std::size_t>(vertices), info, out.attributes.vertex_data);
  return out;
}

}  // namespace overtet::io_detail
