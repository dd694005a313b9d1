#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <optional>
#include <vector>

#include "src/io/base64.h"
#include "src/io/gzip.h"
#include "src/io/mesh_parts.h"
#include "src/io/text.h"
#include "src/io/vtk_data.h"

namespace overtet::io_detail {

namespace {

// The few things that this needs of XML: start tags with attributes, and the text up to the next tag.
struct Tag {
  std::string_view name;  // with a leading / for an end tag
  std::string_view attributes;
  std::string_view text;  // what follows, up to the next tag

  // Attribute by attribute: a value may have in it what looks like another one.
  std::string_view attribute(std::string_view key) const {
    std::string_view rest = attributes;
    for (;;) {
      const std::size_t begin = rest.find_first_not_of(" \t\r\n/");
      if (begin == std::string_view::npos) return "";
      rest.remove_prefix(begin);
      const std::string_view name = rest.substr(0, rest.find_first_of("= \t\r\n"));
      const std::size_t open = rest.find_first_not_of("= \t\r\n", name.size());
      if (open == std::string_view::npos || (rest[open] != '"' && rest[open] != '\'')) return "";
      const std::size_t close = rest.find(rest[open], open + 1);
      if (close == std::string_view::npos) return "";
      if (name == key) return rest.substr(open + 1, close - open - 1);
      rest.remove_prefix(close + 1);
    }
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

// Base64 of so many bytes, with padding.
std::size_t base64_length(std::size_t bytes) { return (bytes + 2) / 3 * 4; }

NumberType type_named(std::string_view type) {
  if (type == "Float64") return NumberType::float64;
  if (type == "Float32") return NumberType::float32;
  if (type == "UInt8") return NumberType::uint8;
  if (type == "Int64" || type == "UInt64" || type == "UInt32") return NumberType::int64;
  return NumberType::int32;
}

std::int64_t number_of(std::string_view text, std::int64_t otherwise) {
  std::int64_t n = otherwise;
  std::from_chars(text.data(), text.data() + text.size(), n);
  return n;
}

// The parts of a file, read one after the other; every error names the file. Its many members are what
// attributes and arrays say, until all have been read.
class VtkXmlReader {
 public:
  explicit VtkXmlReader(std::string_view name) : name_(name) {}

  Result<MeshParts> read(std::string_view bytes) {
    file_size_ = bytes.size();
    const std::vector<Tag> tags = tags_of(bytes);
    for (const Tag& t : tags)
      if (Status s = read_header(t); !s.ok()) return s.error();
    for (const Tag& t : tags)
      if (Status s = read_part(t); !s.ok()) return s.error();
    if (poly_data_) add_polygons();
    if (pieces_ != 1 ||
        data_.points.size() != 3 * static_cast<std::size_t>(std::max<std::int64_t>(points_said_, 0)) ||
        points_said_ < 0 || cells_said_ != static_cast<std::int64_t>(data_.types.size()) ||
        data_.ends.size() != data_.types.size())
      return bad("the numbers of points and cells do not fit the data arrays");
    return parts_of(name_, std::move(data_), poly_data_ ? "VTP" : "VTU");
  }

 private:
  Error bad(const std::string& what) const { return malformed(name_, what); }

  // How the data are stored.
  Status read_header(const Tag& t) {
    if (t.name == "VTKFile") {
      poly_data_ = t.attribute("type") == "PolyData";
      if (!poly_data_ && t.attribute("type") != "UnstructuredGrid")
        return bad("this is neither a VTK unstructured grid nor VTK poly data");
      compressed_ = !t.attribute("compressor").empty();
      if (compressed_ && t.attribute("compressor") != "vtkZLibDataCompressor")
        return bad("the data is compressed by another method than zlib; save it uncompressed");
      if (t.attribute("byte_order") == "BigEndian")
        return bad("the data is big endian; save it as little endian");
      if (t.attribute("header_type") == "UInt64") header_size_ = 8;
    }
    if (t.name == "AppendedData") {
      appended_raw_ = t.attribute("encoding") == "raw";
      const std::size_t mark = t.text.find('_');
      if (mark != std::string_view::npos) appended_ = t.text.substr(mark + 1);
      if (!appended_raw_) appended_ = appended_.substr(0, appended_.find('<'));
    }
    return success();
  }

  Status read_part(const Tag& t) {
    if (t.name == "Piece") {
      if (++pieces_ > 1) return bad("the file has several pieces; save it as one");
      points_said_ = number_of(t.attribute("NumberOfPoints"), -1);
      cells_said_ = number_of(t.attribute(poly_data_ ? "NumberOfPolys" : "NumberOfCells"), -1);
      if (poly_data_) {
        if (number_of(t.attribute("NumberOfStrips"), 0) > 0)
          return bad("the file has strips of triangles; save them as triangles");
        for (const std::string_view other : {"NumberOfVerts", "NumberOfLines"}) {
          const std::int64_t n = std::max<std::int64_t>(number_of(t.attribute(other), 0), 0);
          if (n > kMaxCount) return bad("there are too many vertices or lines");
          data_.other_cells += n;
        }
      }
    }
    for (const std::string_view section :
         {"Points", "Cells", "Polys", "PointData", "CellData", "FieldData", "Verts", "Lines", "Strips"})
      if (t.name == section) section_ = section;
    return t.name == "DataArray" ? read_array(t) : success();
  }

  // A name without XML's escapes.
  static std::string unescaped(std::string_view name) {
    static constexpr std::pair<std::string_view, char> escapes[] = {
        {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}, {"&amp;", '&'}};
    std::string out;
    while (!name.empty()) {
      const auto* escape = std::find_if(std::begin(escapes), std::end(escapes),
                                        [&](const auto& e) { return name.starts_with(e.first); });
      out += escape == std::end(escapes) ? name[0] : escape->second;
      name.remove_prefix(escape == std::end(escapes) ? 1 : escape->first.size());
    }
    return one_line(out);
  }

  // The cells and the data; of what is not known nothing is kept.
  Status read_array(const Tag& t) {
    const std::string_view which = t.attribute("Name");
    const bool cells = section_ == (poly_data_ ? "Polys" : "Cells");
    std::vector<double>* out = section_ == "Points"                      ? &data_.points
                               : cells && which == "connectivity"        ? &data_.connectivity
                               : cells && which == "offsets"             ? &data_.ends
                               : section_ == "Cells" && which == "types" ? &data_.types
                                                                         : nullptr;
    std::vector<Attribute>* list = section_ == "PointData"   ? &data_.point_data
                                   : section_ == "CellData"  ? &data_.cell_data
                                   : section_ == "FieldData" ? &data_.field_data
                                                             : nullptr;
    if (!out && !list) return success();
    if (list) {
      const auto width = number_of(t.attribute("NumberOfComponents"), 1);
      if (width < 1 || width > kMaxCount) return success();
      list->push_back({unescaped(which), type_named(t.attribute("type")), static_cast<int>(width), {}});
      out = &list->back().values;
    }
    const std::string_view format = t.attribute("format");
    return format == "ascii" || format.empty() ? read_text(t, *out) : read_binary(t, *out);
  }

  Status read_text(const Tag& t, std::vector<double>& out) const {
    const std::string_view which = t.attribute("Name");
    TextCursor in(name_, t.text, false);
    double x = 0;
    while (in.to_token()) {
      if (!in.real(x, [&] { return std::string(section_) + " " + std::string(which); })) {
        if (section_ != "Points" && section_ != "Cells" && section_ != "Polys") {
          out.clear();  // words, or NaN: not needed
          return success();
        }
        return bad("the data array " + quoted(which) + " contains something that is not a number");
      }
      out.push_back(x);
    }
    return success();
  }

  Status read_binary(const Tag& t, std::vector<double>& out) {
    const std::string_view which = t.attribute("Name"), format = t.attribute("format");
    std::string_view stored = t.text;
    bool encoded = true;
    if (format == "appended") {
      encoded = !appended_raw_;
      std::size_t offset = 0;
      const std::string_view o = t.attribute("offset");
      if (std::from_chars(o.data(), o.data() + o.size(), offset).ec != std::errc() ||
          offset > appended_.size())
        return bad("the data array " + quoted(which) + " points outside the file");
      stored = appended_.substr(offset);
    } else if (format != "binary") {
      return bad("Overtet reads no data arrays in the format " + quoted(format));
    }
    Result<std::string> raw = compressed_ ? inflated(which, stored, encoded) : plain(which, stored, encoded);
    if (!raw) return raw.error();
    // Arrays that share their bytes would take the square of the file's size.
    if (stored_ > file_size_) return bad("data arrays lie in each other");
    return take(t.attribute("type"), raw.value(), out);
  }

  // So many bytes of what is stored, from a place on, which moves on.
  std::optional<std::string> bytes(std::string_view& stored, std::size_t count, bool encoded) const {
    if (!encoded) {
      if (stored.size() < count) return std::nullopt;
      std::string out(stored.substr(0, count));
      stored.remove_prefix(count);
      return out;
    }
    while (!stored.empty() && static_cast<unsigned char>(stored[0]) <= ' ') stored.remove_prefix(1);
    const std::size_t length = base64_length(count);
    if (stored.size() < length || length < count) return std::nullopt;
    std::optional<std::string> out = decode_base64(stored.substr(0, length));
    if (!out || out->size() < count) return std::nullopt;
    stored.remove_prefix(length);
    out->resize(count);
    return out;
  }

  std::uint64_t header_number(const std::string& header, std::size_t i) const {
    std::uint64_t n = 0;
    std::memcpy(&n, header.data() + i * header_size_, header_size_);
    return n;
  }

  // A count of bytes, and the bytes; in base64 both as one run, or (VTK) as two.
  Result<std::string> plain(std::string_view which, std::string_view stored, bool encoded) {
    const Error cut = bad("the data array " + quoted(which) + " is cut short");
    if (!encoded) {
      const auto header = bytes(stored, header_size_, false);
      if (!header || stored.size() < header_number(*header, 0)) return cut;
      stored_ += header_number(*header, 0);
      return std::string(stored.substr(0, header_number(*header, 0)));
    }
    std::string_view front = stored;
    while (!front.empty() && static_cast<unsigned char>(front[0]) <= ' ') front.remove_prefix(1);
    auto head = decode_base64(front.substr(0, base64_length(header_size_)));
    if (!head) return bad("the data array " + quoted(which) + " is not base64");
    if (head->size() < header_size_) return cut;
    const std::uint64_t size = header_number(*head, 0);
    if (size > front.size()) return cut;
    const auto whole = static_cast<std::size_t>(size) + header_size_;
    auto all = decode_base64(front.substr(0, base64_length(whole)));
    if (all && all->size() < whole)
      all = decode_base64(front.substr(0, base64_length(header_size_) + base64_length(whole - header_size_)));
    if (!all) return bad("the data array " + quoted(which) + " is not base64");
    if (all->size() < whole) return cut;
    stored_ += whole;
    return all->substr(header_size_, static_cast<std::size_t>(size));
  }

  // Blocks of zlib: how many, the size of one, of the last if that is smaller, and of each compressed.
  Result<std::string> inflated(std::string_view which, std::string_view stored, bool encoded) {
    const Error cut = bad("the data array " + quoted(which) + " is cut short");
    std::string_view look = stored;
    const auto first = bytes(look, header_size_, encoded);
    if (!first) return cut;
    const std::uint64_t blocks = header_number(*first, 0);
    if (blocks > stored.size()) return cut;
    if (blocks == 0) return std::string();
    const auto header = bytes(stored, (3 + static_cast<std::size_t>(blocks)) * header_size_, encoded);
    if (!header) return cut;
    const std::uint64_t block = header_number(*header, 1), last = header_number(*header, 2);
    std::uint64_t packed = 0;
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::uint64_t size = header_number(*header, 3 + b);
      if (size > stored.size() || packed + size > stored.size()) return cut;
      packed += size;
    }
    const auto body = bytes(stored, static_cast<std::size_t>(packed), encoded);
    if (!body) return cut;
    stored_ += body->size();
    std::string out;
    std::string_view rest = *body;
    for (std::size_t b = 0; b < blocks; ++b) {
      const auto size = static_cast<std::size_t>(header_number(*header, 3 + b));
      const std::uint64_t full = b + 1 == blocks && last > 0 ? last : block;
      if (!inflate_zlib(rest.substr(0, size), full, out))
        return bad("the data array " + quoted(which) + " is damaged");
      rest.remove_prefix(size);
    }
    return out;
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
    else if (type == "Int16")
      as(std::int16_t{});
    else if (type == "UInt16")
      as(std::uint16_t{});
    else if (type == "UInt8")
      as(std::uint8_t{});
    else if (type == "Int8")
      as(std::int8_t{});
    else if (section_ == "Points" || section_ == "Cells" || section_ == "Polys")
      return bad("Overtet reads no data of the type " + quoted(type));
    return success();
  }

  // Poly data lists polygons without types.
  void add_polygons() {
    data_.types.reserve(data_.ends.size());
    for (std::size_t c = 0; c < data_.ends.size(); ++c) data_.types.push_back(7);
  }

  std::string_view name_;
  std::string_view appended_;
  bool appended_raw_ = false, poly_data_ = false, compressed_ = false;
  std::size_t header_size_ = 4;
  std::size_t file_size_ = 0, stored_ = 0;  // bytes; of the arrays so far
  int pieces_ = 0;
  std::string_view section_;
  std::int64_t points_said_ = -1, cells_said_ = -1;
  VtkDataSet data_;
};

}  // namespace

Result<MeshParts> parse_vtk_xml(std::string_view name, std::string_view bytes) {
  return VtkXmlReader(name).read(bytes);
}

}  // namespace overtet::io_detail
