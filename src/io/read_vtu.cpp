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

// The parts of a file, read one after the other; every error names the file. Its many members are what
// attributes and arrays say, until all have been read.
class VtuReader {
 public:
  explicit VtuReader(std::string_view name) : name_(name) {}

  Result<TetMesh> read(std::string_view bytes) {
    const std::vector<Tag> tags = tags_of(bytes);
    for (const Tag& t : tags)
      if (Status s = read_header(t); !s.ok()) return s.error();
    for (const Tag& t : tags)
      if (Status s = read_part(t); !s.ok()) return s.error();
    return mesh();
  }

 private:
  Error bad(const std::string& what) const {
    return {ErrorCode::bad_input, std::string(name_) + ": " + what + "."};
  }

  // How the data are stored.
  Status read_header(const Tag& t) {
    if (t.name == "VTKFile") {
      if (t.attribute("type") != "UnstructuredGrid") return bad("this is not a VTK unstructured grid");
      if (!t.attribute("compressor").empty()) return bad("the data is compressed; save it uncompressed");
      if (t.attribute("byte_order") == "BigEndian")
        return bad("the data is big endian; save it as little endian");
      if (t.attribute("header_type") == "UInt64") header_size_ = 8;
    }
    if (t.name == "AppendedData") {
      appended_raw_ = t.attribute("encoding") == "raw";
      const std::size_t mark = t.text.find('_');
      if (mark != std::string_view::npos) appended_ = t.text.substr(mark + 1);
    }
    return success();
  }

  // The arrays that tets are made of; others are left out.
  Status read_part(const Tag& t) {
    if (t.name == "Piece") {
      if (++pieces_ > 1) return bad("the file has several pieces; save it as one");
      points_said_ = t.attribute("NumberOfPoints");
      cells_said_ = t.attribute("NumberOfCells");
    }
    if (t.name == "Points" || t.name == "Cells" || t.name == "PointData" || t.name == "CellData")
      section_ = t.name;
    if (t.name != "DataArray") return success();
    const std::string_view which = t.attribute("Name");
    std::vector<double>* out = section_ == "Points"                             ? &points_
                               : section_ == "Cells" && which == "connectivity" ? &connectivity_
                               : section_ == "Cells" && which == "offsets"      ? &offsets_
                               : section_ == "Cells" && which == "types"        ? &types_
                                                                                : nullptr;
    if (!out) return success();
    const std::string_view format = t.attribute("format");
    if (format == "ascii" || format.empty()) return read_text(t, *out);
    return read_binary(t, *out);
  }

  Status read_text(const Tag& t, std::vector<double>& out) const {
    const std::string_view which = t.attribute("Name");
    TextCursor in(name_, t.text, false);
    double x = 0;
    while (in.to_token()) {
      if (!in.real(x, [&] { return std::string(section_) + " " + std::string(which); }))
        return bad("the data array " + quoted(which) + " contains something that is not a number");
      out.push_back(x);
    }
    return success();
  }

  Status read_binary(const Tag& t, std::vector<double>& out) const {
    const std::string_view which = t.attribute("Name"), format = t.attribute("format");
    std::string decoded;
    std::string_view raw;
    if (format == "binary") {
      auto d = decode_base64(t.text);
      if (!d) return bad("the data array " + quoted(which) + " is not base64");
      decoded = std::move(*d);
      raw = decoded;
    } else if (format == "appended" && appended_raw_) {
      std::size_t offset = 0;
      const std::string_view o = t.attribute("offset");
      if (std::from_chars(o.data(), o.data() + o.size(), offset).ec != std::errc() ||
          offset > appended_.size())
        return bad("the data array " + quoted(which) + " points outside the file");
      raw = appended_.substr(offset);
    } else {
      return bad("Overtet reads no data arrays in the format " + quoted(format));
    }
    std::uint64_t size = 0;
    if (raw.size() < header_size_) return bad("the data array " + quoted(which) + " is cut short");
    std::memcpy(&size, raw.data(), header_size_);
    raw.remove_prefix(header_size_);
    if (raw.size() < size) return bad("the data array " + quoted(which) + " is cut short");
    return take(t.attribute("type"), raw.substr(0, size), out);
  }

  Status take(std::string_view type, std::string_view raw, std::vector<double>& out) const {
    const auto as = [&]<class T>(T) {
      const std::size_t n = raw.size() / sizeof(T);
      out.resize(n);
      for (std::size_t i = 0; i < n; ++i) {
        T x;
        std::memcpy(&x, raw.data() + i * sizeof(T), sizeof(T));
        out[i] = static_cast<double>(x);
      }
    };
    if (type == "Float64")
      as(double{});
    else if (type == "Float32")
      as(float{});
    else if (type == "Int64")
      as(std::int64_t{});
    else if (type == "UInt64")
      as(std::uint64_t{});
    else if (type == "Int32")
      as(std::int32_t{});
    else if (type == "UInt32")
      as(std::uint32_t{});
    else if (type == "UInt8")
      as(std::uint8_t{});
    else if (type == "Int8")
      as(std::int8_t{});
    else
      return bad("Overtet reads no data of the type " + quoted(type));
    return success();
  }

  Result<TetMesh> mesh() const {
    const auto said = [](std::string_view s) {
      std::int64_t n = -1;
      std::from_chars(s.data(), s.data() + s.size(), n);
      return n;
    };
    const auto vertices = static_cast<std::int64_t>(points_.size() / 3);
    if (pieces_ != 1 || points_.size() % 3 != 0 || said(points_said_) != vertices ||
        said(cells_said_) != static_cast<std::int64_t>(types_.size()) || offsets_.size() != types_.size())
      return bad("the numbers of points and cells do not fit the data arrays");
    if (vertices > std::numeric_limits<Index>::max())
      return bad("there are more vertices than Overtet can number");
    TetMesh m;
    m.V = Eigen::Map<const VertexMatrix>(points_.data(), vertices, 3);
    std::vector<Index> corners;
    std::int64_t begin = 0;
    for (std::size_t c = 0; c < types_.size(); ++c) {
      const double end_said = offsets_[c];
      if (!(end_said >= static_cast<double>(begin) && end_said <= static_cast<double>(connectivity_.size())))
        return bad("cell " + std::to_string(c) + " has no corners");
      const auto end = static_cast<std::int64_t>(end_said);
      if (types_[c] == 10) {
        if (end - begin != 4) return bad("tet " + std::to_string(c) + " does not have four corners");
        for (std::int64_t k = begin; k < end; ++k) {
          const double v = connectivity_[static_cast<std::size_t>(k)];
          if (!(v >= 0 && v < static_cast<double>(vertices)))
            return bad("tet " + std::to_string(c) + " names a vertex that does not exist");
          corners.push_back(static_cast<Index>(v));
        }
      }
      begin = end;
    }
    if (corners.empty()) return bad("the file has no tets");
    m.T = Eigen::Map<const TetMatrix>(corners.data(), static_cast<Eigen::Index>(corners.size() / 4), 4);
    return m;
  }

  std::string_view name_;
  std::string_view appended_;
  bool appended_raw_ = false;
  std::size_t header_size_ = 4;
  int pieces_ = 0;
  std::string_view section_, points_said_, cells_said_;
  std::vector<double> points_, connectivity_, offsets_, types_;  // 32-bit indices are exact in a double
};

}  // namespace

Result<TetMesh> read_vtu(std::string_view name, std::string_view bytes) {
  return VtuReader(name).read(bytes);
}

}  // namespace overtet
