#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <optional>
#include <vector>

#include "src/io/text.h"
#include "src/io/vtu.h"

namespace overtet {

namespace {

// The few things that this needs of XML: start tags with attributes, and the text up to the next tag.
struct Tag {
  std::string_view name;  // with a leading / for an end tag
  std::string_view attributes;
  std::string_view text;  // what follows, up to the next tag

  std::string_view attribute(std::string_view key) const {
    for (std::size_t at = attributes.find(key); at != std::string_view::npos;
         at = attributes.find(key, at + 1)) {
      if (at > 0 && static_cast<unsigned char>(attributes[at - 1]) > ' ') continue;
      std::size_t p = at + key.size();
      while (p < attributes.size() && static_cast<unsigned char>(attributes[p]) <= ' ') ++p;
      if (p >= attributes.size() || attributes[p] != '=') continue;
      const std::size_t open = attributes.find_first_of("\"'", p);
      if (open == std::string_view::npos) return "";
      const std::size_t close = attributes.find(attributes[open], open + 1);
      return close == std::string_view::npos ? "" : attributes.substr(open + 1, close - open - 1);
    }
    return "";
  }
};

std::vector<Tag> tags_of(std::string_view xml) {
  std::vector<Tag> tags;
  std::size_t at = xml.find('<');
  while (at != std::string_view::npos) {
    const std::size_t close = xml.find('>', at);
    if (close == std::string_view::npos) break;
    Tag t;
    const std::string_view inside = xml.substr(at + 1, close - at - 1);
    const std::size_t blank = inside.find_first_of(" \t\r\n");
    t.name = inside.substr(0, blank);
    t.attributes = blank == std::string_view::npos ? "" : inside.substr(blank);
    const bool raw = t.name == "AppendedData";
    const std::size_t next = raw ? std::string_view::npos : xml.find('<', close);
    t.text = xml.substr(close + 1, next == std::string_view::npos ? next : next - close - 1);
    tags.push_back(t);
    at = next;
  }
  return tags;
}

std::optional<std::string> decode_base64(std::string_view text) {
  std::string bytes;
  std::uint32_t bits = 0;
  int have = 0;
  for (const char c : text) {
    int d = 0;
    if (c >= 'A' && c <= 'Z')
      d = c - 'A';
    else if (c >= 'a' && c <= 'z')
      d = c - 'a' + 26;
    else if (c >= '0' && c <= '9')
      d = c - '0' + 52;
    else if (c == '+')
      d = 62;
    else if (c == '/')
      d = 63;
    else if (c == '=') {
      bits = 0, have = 0;  // header and body may be two padded runs
      continue;
    } else if (static_cast<unsigned char>(c) <= ' ')
      continue;
    else
      return std::nullopt;
    bits = bits << 6 | static_cast<std::uint32_t>(d);
    have += 6;
    if (have >= 8) {
      have -= 8;
      bytes += static_cast<char>(bits >> have & 255);
    }
  }
  return bytes;
}

struct Arrays {
  std::vector<double> points, connectivity, offsets, types;  // 32-bit indices are exact in a double
};

}  // namespace

Result<TetMesh> read_vtu(std::string_view name, std::string_view bytes) {
  const auto bad = [&](const std::string& what) {
    return Error{ErrorCode::bad_input, std::string(name) + ": " + what + "."};
  };
  const std::vector<Tag> tags = tags_of(bytes);
  std::string_view appended;
  bool appended_raw = false;
  std::size_t header_size = 4;
  for (const Tag& t : tags) {
    if (t.name == "VTKFile") {
      if (t.attribute("type") != "UnstructuredGrid") return bad("this is not a VTK unstructured grid");
      if (!t.attribute("compressor").empty()) return bad("the data are compressed; save them uncompressed");
      if (t.attribute("byte_order") == "BigEndian")
        return bad("the data are big endian; save them little endian");
      if (t.attribute("header_type") == "UInt64") header_size = 8;
    }
    if (t.name == "AppendedData") {
      appended_raw = t.attribute("encoding") == "raw";
      const std::size_t mark = t.text.find('_');
      if (mark != std::string_view::npos) appended = t.text.substr(mark + 1);
    }
  }
  Arrays arrays;
  std::string_view section;
  int pieces = 0;
  std::string_view points_said, cells_said;
  for (const Tag& t : tags) {
    if (t.name == "Piece") {
      if (++pieces > 1) return bad("the file has several pieces");
      points_said = t.attribute("NumberOfPoints");
      cells_said = t.attribute("NumberOfCells");
    }
    if (t.name == "Points" || t.name == "Cells" || t.name == "PointData" || t.name == "CellData")
      section = t.name;
    if (t.name != "DataArray") continue;
    const std::string_view which = t.attribute("Name"), format = t.attribute("format"),
                           type = t.attribute("type");
    std::vector<double>* out = section == "Points"                             ? &arrays.points
                               : section == "Cells" && which == "connectivity" ? &arrays.connectivity
                               : section == "Cells" && which == "offsets"      ? &arrays.offsets
                               : section == "Cells" && which == "types"        ? &arrays.types
                                                                               : nullptr;
    if (!out) continue;
    if (format == "ascii" || format.empty()) {
      TextCursor in(name, t.text, false);
      double x = 0;
      while (in.to_token()) {
        if (!in.real(x, [&] { return std::string(section) + " " + std::string(which); }))
          return bad("the data array " + quoted(which) + " holds something that is not a number");
        out->push_back(x);
      }
      continue;
    }
    std::string decoded;
    std::string_view raw;
    if (format == "binary") {
      auto d = decode_base64(t.text);
      if (!d) return bad("the data array " + quoted(which) + " is not base64");
      decoded = std::move(*d);
      raw = decoded;
    } else if (format == "appended" && appended_raw) {
      std::size_t offset = 0;
      const std::string_view o = t.attribute("offset");
      if (std::from_chars(o.data(), o.data() + o.size(), offset).ec != std::errc() ||
          offset > appended.size())
        return bad("the data array " + quoted(which) + " points outside the file");
      raw = appended.substr(offset);
    } else {
      return bad("data arrays in the format " + quoted(format) + " are not read");
    }
    std::uint64_t size = 0;
    if (raw.size() < header_size) return bad("the data array " + quoted(which) + " is cut short");
    std::memcpy(&size, raw.data(), header_size);
    raw.remove_prefix(header_size);
    if (raw.size() < size) return bad("the data array " + quoted(which) + " is cut short");
    raw = raw.substr(0, size);
    const auto take = [&]<class T>(T) {
      const std::size_t n = raw.size() / sizeof(T);
      out->resize(n);
      for (std::size_t i = 0; i < n; ++i) {
        T x;
        std::memcpy(&x, raw.data() + i * sizeof(T), sizeof(T));
        (*out)[i] = static_cast<double>(x);
      }
    };
    if (type == "Float64")
      take(double{});
    else if (type == "Float32")
      take(float{});
    else if (type == "Int64")
      take(std::int64_t{});
    else if (type == "UInt64")
      take(std::uint64_t{});
    else if (type == "Int32")
      take(std::int32_t{});
    else if (type == "UInt32")
      take(std::uint32_t{});
    else if (type == "UInt8")
      take(std::uint8_t{});
    else if (type == "Int8")
      take(std::int8_t{});
    else
      return bad("data of the type " + quoted(type) + " are not read");
  }
  const auto said = [](std::string_view s) {
    std::int64_t n = -1;
    std::from_chars(s.data(), s.data() + s.size(), n);
    return n;
  };
  const auto vertices = static_cast<std::int64_t>(arrays.points.size() / 3);
  if (pieces != 1 || arrays.points.size() % 3 != 0 || said(points_said) != vertices ||
      said(cells_said) != static_cast<std::int64_t>(arrays.types.size()) ||
      arrays.offsets.size() != arrays.types.size())
    return bad("the numbers of points and cells do not fit the data arrays");
  if (vertices > std::numeric_limits<Index>::max())
    return bad("there are more vertices than Overtet can number");
  TetMesh m;
  m.V = Eigen::Map<const VertexMatrix>(arrays.points.data(), vertices, 3);
  std::vector<Index> corners;
  std::int64_t begin = 0;
  for (std::size_t c = 0; c < arrays.types.size(); ++c) {
    const double end_said = arrays.offsets[c];
    if (!(end_said >= static_cast<double>(begin) &&
          end_said <= static_cast<double>(arrays.connectivity.size())))
      return bad("cell " + std::to_string(c) + " has no corners");
    const auto end = static_cast<std::int64_t>(end_said);
    if (arrays.types[c] == 10) {
      if (end - begin != 4) return bad("tet " + std::to_string(c) + " does not have four corners");
      for (std::int64_t k = begin; k < end; ++k) {
        const double v = arrays.connectivity[static_cast<std::size_t>(k)];
        if (!(v >= 0 && v < static_cast<double>(vertices)))
          return bad("tet " + std::to_string(c) + " names a vertex that is not there");
        corners.push_back(static_cast<Index>(v));
      }
    }
    begin = end;
  }
  if (corners.empty()) return bad("the file holds no tets");
  m.T = Eigen::Map<const TetMatrix>(corners.data(), static_cast<Eigen::Index>(corners.size() / 4), 4);
  return m;
}

}  // namespace overtet
