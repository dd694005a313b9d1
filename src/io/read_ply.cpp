#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <optional>

#include "src/io/face_groups.h"
#include "src/io/surface_parts.h"
#include "src/io/text.h"

namespace overtet::io_detail {

namespace {

enum class Type { i8, u8, i16, u16, i32, u32, f32, f64 };

// Of a number, in bytes.
int size_of(Type type) {
  switch (type) {
    case Type::i8:
    case Type::u8:
      return 1;
    case Type::i16:
    case Type::u16:
      return 2;
    case Type::i32:
    case Type::u32:
    case Type::f32:
      return 4;
    case Type::f64:
      break;
  }
  return 8;
}

std::optional<Type> type_named(std::string_view s) {
  constexpr std::pair<std::string_view, Type> names[] = {
      {"char", Type::i8},   {"int8", Type::i8},     {"uchar", Type::u8},   {"uint8", Type::u8},
      {"short", Type::i16}, {"int16", Type::i16},   {"ushort", Type::u16}, {"uint16", Type::u16},
      {"int", Type::i32},   {"int32", Type::i32},   {"uint", Type::u32},   {"uint32", Type::u32},
      {"float", Type::f32}, {"float32", Type::f32}, {"double", Type::f64}, {"float64", Type::f64}};
  for (const auto& [name, type] : names)
    if (name == s) return type;
  return std::nullopt;
}

NumberType kept_as(Type type) {
  switch (type) {
    case Type::u8:
      return NumberType::uint8;
    case Type::u32:
      return NumberType::int64;
    case Type::f32:
      return NumberType::float32;
    case Type::f64:
      return NumberType::float64;
    case Type::i8:
    case Type::i16:
    case Type::u16:
    case Type::i32:
      break;
  }
  return NumberType::int32;
}

struct Property {
  std::string name;
  Type type = Type::f64;
  bool list = false;
  Type count_type = Type::u8;
};

struct Element {
  std::string name;
  std::int64_t count = 0;
  std::vector<Property> properties;
};

template <class T>
T load(const char* p, bool swap) {
  std::array<char, sizeof(T)> b;
  std::memcpy(b.data(), p, sizeof(T));
  if (swap) std::reverse(b.begin(), b.end());
  return std::bit_cast<T>(b);
}

double load_number(const char* p, Type type, bool swap) {
  switch (type) {
    case Type::i8:
      return load<std::int8_t>(p, swap);
    case Type::u8:
      return load<std::uint8_t>(p, swap);
    case Type::i16:
      return load<std::int16_t>(p, swap);
    case Type::u16:
      return load<std::uint16_t>(p, swap);
    case Type::i32:
      return load<std::int32_t>(p, swap);
    case Type::u32:
      return load<std::uint32_t>(p, swap);
    case Type::f32:
      return load<float>(p, swap);
    case Type::f64:
      return load<double>(p, swap);
  }
  return 0;
}

// One way of getting the next number of the body, the same for text and binary files.
class Source {
 public:
  virtual ~Source() = default;
  virtual bool next(Type type, double& x) = 0;  // false: the error is set
  virtual bool end_element() = 0;
  virtual bool begin_element() = 0;
  virtual std::int64_t bytes_left() const = 0;
  virtual std::string place() const = 0;  // for messages
  virtual std::int64_t line() const { return 0; }

  Error error;
  std::string_view name;
  const char* element = "";
  std::int64_t number = 0;
  std::int64_t first_extra = 0;  // the first line with more values than the header names

  std::string which() const { return std::string(element) + " " + std::to_string(number); }
  bool fail(const std::string& what) {
    error = malformed(name, place() + what);
    return false;
  }
};

class BinarySource final : public Source {
 public:
  BinarySource(std::string_view body, bool swap) : p_(body.data()), end_(p_ + body.size()), swap_(swap) {}
  bool next(Type type, double& x) override {
    const int size = size_of(type);
    if (end_ - p_ < size) return fail("the file ends inside " + which());
    x = load_number(p_, type, swap_);
    p_ += size;
    return true;
  }
  bool begin_element() override { return true; }
  bool end_element() override { return true; }
  std::int64_t bytes_left() const override { return end_ - p_; }
  std::string place() const override { return ""; }

 private:
  const char* p_;
  const char* end_;
  bool swap_;
};

class TextSource final : public Source {
 public:
  TextSource(std::string_view file, std::string_view body, std::int64_t line)
      : in_(file, body, false, line) {}
  bool next(Type, double& x) override {
    if (in_.real(x, [&] { return which(); })) return true;
    error = in_.error();
    return false;
  }
  bool begin_element() override { return in_.to_token() || fail("the file ends before " + which()); }
  bool end_element() override {
    if (!in_.at_line_end() && first_extra == 0) first_extra = in_.line();
    in_.next_line();
    return true;
  }
  std::int64_t bytes_left() const override { return static_cast<std::int64_t>(in_.bytes_left()); }
  std::string place() const override { return "line " + std::to_string(line()) + ": "; }
  std::int64_t line() const override { return in_.line(); }

 private:
  TextCursor in_;
};

// The property that lists the corners of a face: it is called so, or is the only list. None where no list or
// more than one is that.
std::optional<std::size_t> corners_of(const Element& face) {
  std::size_t lists = 0, named = 0, list = 0, name = 0;
  for (std::size_t i = 0; i < face.properties.size(); ++i) {
    const Property& p = face.properties[i];
    if (!p.list) continue;
    ++lists, list = i;
    if (p.name == "vertex_indices" || p.name == "vertex_index") ++named, name = i;
  }
  if (named == 1) return name;
  return named == 0 && lists == 1 ? std::optional(list) : std::nullopt;
}

// What a property is for: a coordinate (0 to 2), the corners, or something to carry along.
struct Role {
  int coordinate = -1;
  bool corners = false;
  Attribute* data = nullptr;
};

std::vector<Role> roles_of(const Element& e, Polygons& out) {
  std::vector<Role> roles(e.properties.size());
  const bool is_vertex = e.name == "vertex", is_face = e.name == "face";
  const std::optional<std::size_t> corners = is_face ? corners_of(e) : std::nullopt;
  std::vector<Attribute>& data = is_vertex ? out.attributes.vertex_data : out.attributes.face_data;
  data.reserve(e.properties.size());  // roles point into it
  for (std::size_t i = 0; i < e.properties.size(); ++i) {
    const Property& p = e.properties[i];
    if (is_vertex && !p.list && p.name.size() == 1 && p.name[0] >= 'x' && p.name[0] <= 'z')
      roles[i].coordinate = p.name[0] - 'x';
    else if (corners == i)
      roles[i].corners = true;
    else if ((is_vertex || is_face) && !p.list) {
      data.push_back({one_line(p.name), kept_as(p.type), 1, {}});
      roles[i].data = &data.back();
    }
  }
  return roles;
}

// The property that is a label, if there is one; else the colours, if they are few.
void take_labels(Polygons& out) {
  const std::vector<Attribute>& data = out.attributes.face_data;
  for (const std::string_view name :
       {"label", "labels", "material", "material_index", "material_id", "region", "group"})
    for (const Attribute& a : data) {
      const auto whole = [](double x) { return x == std::floor(x) && std::abs(x) <= double{kMaxCount}; };
      if (a.name != name || !std::all_of(a.values.begin(), a.values.end(), whole)) continue;
      out.attributes.faces.of.assign(a.values.begin(), a.values.end());
      return;
    }
  Attribute colour{"colour", NumberType::float64, 3, {}};
  std::array<const Attribute*, 3> parts{};
  for (const Attribute& a : data)
    for (std::size_t k = 0; k < 3; ++k)
      if (a.name == std::array{"red", "green", "blue"}[k]) parts[k] = &a;
  if (!parts[0] || !parts[1] || !parts[2]) return;
  for (std::size_t f = 0; f < out.sizes.size(); ++f)
    for (const Attribute* part : parts) {
      if (std::isnan(part->values[f])) return;
      colour.values.push_back(part->values[f]);
    }
  Labels labels = labels_by_value(colour);
  if (2 * labels.names.size() <= out.sizes.size()) out.attributes.faces = std::move(labels);
}

Status read_body(Source& in, const std::vector<Element>& elements, Polygons& out) {
  std::int64_t vertices = 0;
  for (const Element& e : elements)
    if (e.name == "vertex") vertices = e.count;
  for (const Element& e : elements) {
    in.element = e.name.c_str();
    const bool is_vertex = e.name == "vertex", is_face = e.name == "face";
    const std::vector<Role> role = roles_of(e, out);
    if (is_vertex) out.xyz.resize(static_cast<std::size_t>(3 * e.count));
    if (is_face) {
      out.sizes.reserve(static_cast<std::size_t>(e.count));
      out.corners.reserve(static_cast<std::size_t>(3 * e.count));
    }
    std::vector<std::uint32_t>* const lines = in.line() == 0 ? nullptr
                                              : is_vertex    ? &out.vertex_line
                                              : is_face      ? &out.face_line
                                                             : nullptr;
    for (std::int64_t n = 0; n < e.count; ++n) {
      in.number = n;
      if (!in.begin_element()) return in.error;
      if (lines) lines->push_back(static_cast<std::uint32_t>(in.line()));
      for (std::size_t i = 0; i < e.properties.size(); ++i) {
        const Property& p = e.properties[i];
        double x = 0;
        if (!p.list) {
          if (!in.next(p.type, x)) return in.error;
          if (role[i].data) role[i].data->values.push_back(x);
          if (role[i].coordinate < 0) continue;
          if (!std::isfinite(x)) {
            in.fail("a coordinate is not a finite number (" + in.which() + ")");
            return in.error;
          }
          out.xyz[static_cast<std::size_t>(3 * n + role[i].coordinate)] = x;
          continue;
        }
        if (!in.next(p.count_type, x)) return in.error;
        if (!(x >= 0) || x != std::floor(x) || x > static_cast<double>(in.bytes_left()) ||
            x > double{kMaxCount}) {
          if (x >= 0 && x < 1000)
            in.fail("the file ends inside " + in.which());
          else
            in.fail("a list cannot have that length (" + in.which() + ")");
          return in.error;
        }
        const auto size = static_cast<Index>(x);
        if (role[i].corners && size < 3) {
          in.fail("a face needs at least three corners (" + in.which() + ")");
          return in.error;
        }
        for (Index k = 0; k < size; ++k) {
          if (!in.next(p.type, x)) return in.error;
          if (!role[i].corners) continue;
          if (!(x >= 0 && x < static_cast<double>(vertices)) || x != std::floor(x)) {
            const bool whole = std::isfinite(x) && std::abs(x) < 1e15;
            in.fail("there is no vertex " +
                    (whole ? std::to_string(static_cast<std::int64_t>(x)) : "with that number") +
                    "; vertices are numbered from 0 to " + std::to_string(vertices - 1) + " (" + in.which() +
                    (size > 64 ? ", which claims to have " + std::to_string(size) + " corners)" : ")"));
            return in.error;
          }
          out.corners.push_back(static_cast<Index>(x));
        }
        if (role[i].corners) out.sizes.push_back(size);
      }
      if (!in.end_element()) return in.error;
    }
  }
  return success();
}

struct Header {
  enum class Format { ascii, little_endian, big_endian } format = Format::ascii;
  std::vector<Element> elements;
};

Result<Property> read_property(TextCursor& in) {
  const auto bad = [&](const std::string& what) {
    in.fail(what);
    return in.error();
  };
  const auto word = [&]() -> std::string_view { return in.at_line_end() ? std::string_view() : in.token(); };
  Property p;
  std::string_view type = word();
  if (type == "list") {
    p.list = true;
    const std::string_view count_name = word();
    const auto count_type = type_named(count_name);
    if (!count_type) return bad(quoted(count_name) + " is not a PLY type");
    p.count_type = *count_type;
    type = word();
  }
  const auto t = type_named(type);
  if (!t) return bad(quoted(type) + " is not a PLY type");
  p.type = *t;
  p.name = word();
  if (p.name.empty()) return bad("a property has no name");
  return p;
}

// text: what comes before end_header.
Result<Header> read_header(std::string_view name, std::string_view text) {
  TextCursor in(name, text, false);
  std::string format;
  Header header;
  std::vector<Element>& elements = header.elements;
  const auto bad = [&](const std::string& what) {
    in.fail(what);
    return in.error();
  };
  while (in.to_token()) {
    const std::string_view key = in.token();
    const auto word = [&]() -> std::string_view {
      return in.at_line_end() ? std::string_view() : in.token();
    };
    if (key == "format") {
      format = word();
    } else if (key == "element") {
      Element e;
      e.name = word();
      if (e.name.empty()) return bad("an element has no name");
      if (!in.integer(e.count, [&] { return "the number of " + quoted(e.name) + " elements"; }))
        return in.error();
      if (e.count < 0 || e.count > kMaxCount)
        return bad(std::to_string(e.count) + " cannot be a number of " + quoted(e.name) + " elements");
      if ((e.name == "vertex" || e.name == "face") &&
          std::any_of(elements.begin(), elements.end(), [&](const Element& o) { return o.name == e.name; }))
        return bad("the header lists " + quoted(e.name) + " twice");
      elements.push_back(std::move(e));
    } else if (key == "property") {
      if (elements.empty()) return bad("a property comes before any element");
      auto p = read_property(in);
      if (!p.ok()) return p.error();
      elements.back().properties.push_back(std::move(p).value());
    } else if (key != "ply" && key != "comment" && key != "obj_info") {
      return bad(quoted(key) + " is not a PLY header keyword");
    }
    in.next_line();
  }
  if (format == "binary_little_endian")
    header.format = Header::Format::little_endian;
  else if (format == "binary_big_endian")
    header.format = Header::Format::big_endian;
  else if (format != "ascii")
    return malformed(name, quoted(format) + " is not a PLY format");
  return header;
}

// Whether a body of so many bytes can hold what the header names; in text every number takes two bytes.
Status check_header(std::string_view name, const Header& header, std::int64_t body_size) {
  const bool text = header.format == Header::Format::ascii;
  std::int64_t least = 0;
  int seen = 0;
  for (const Element& e : header.elements) {
    std::int64_t each = 0;
    std::array<int, 3> coordinates{};
    for (const Property& p : e.properties) {
      each += text ? 2 : size_of(p.list ? p.count_type : p.type);
      if (!p.list && (p.name == "x" || p.name == "y" || p.name == "z"))
        ++coordinates[static_cast<std::size_t>(p.name[0] - 'x')];
    }
    if (e.name == "vertex" && coordinates != std::array{1, 1, 1})
      return malformed(name, "the vertices have no x, y and z");
    if (e.name == "face" && !corners_of(e))
      return malformed(name, "the faces have no list of vertex_indices");
    if (each == 0 && e.count > 0)
      return malformed(name, "the element " + quoted(e.name) + " has no properties");
    if (each > 0 && e.count > body_size / each) {
      return malformed(
          name, "the file is too short for " + std::to_string(e.count) + " elements " + quoted(e.name));
    }
    least += each * e.count;
    if (least > body_size) return malformed(name, "the file is too short for what its header declares");
    seen += e.name == "vertex" || e.name == "face";
  }
  if (seen != 2) return malformed(name, "the header declares no vertices or no faces");
  return success();
}

}  // namespace

Result<Polygons> parse_ply(std::string_view name, std::string_view bytes, SurfaceReadInfo& info) {
  const auto header_end = bytes.find("end_header");
  const auto body_at = header_end == std::string_view::npos ? header_end : bytes.find('\n', header_end);
  if (body_at == std::string_view::npos) return malformed(name, "the PLY header has no end_header line");
  const std::string_view body = bytes.substr(body_at + 1);

  const Result<Header> header = read_header(name, bytes.substr(0, header_end));
  if (!header.ok()) return header.error();
  const std::vector<Element>& elements = header.value().elements;
  const bool text = header.value().format == Header::Format::ascii,
             little = header.value().format == Header::Format::little_endian;
  info.format = text ? "PLY, ASCII" : little ? "PLY, binary, little endian" : "PLY, binary, big endian";
  if (Status s = check_header(name, header.value(), static_cast<std::int64_t>(body.size()) + 1); !s.ok())
    return s.error();

  Polygons out;
  Status status = success();
  if (text) {
    std::int64_t line =
        1 + std::count(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(body_at) + 1, '\n');
    if (const std::int64_t nul = line_of_nul(body))
      return malformed(name,
                       "line " + std::to_string(line + nul - 1) + " contains a NUL byte, so it is not text");
    TextSource source(name, body, line);
    source.name = name;
    status = read_body(source, elements, out);
    if (source.first_extra > 0)
      info.notes.push_back("Values that the header does not name were ignored, from line " +
                           std::to_string(source.first_extra) + " on.");
  } else {
    BinarySource source(body, little != (std::endian::native == std::endian::little));
    source.name = name;
    status = read_body(source, elements, out);
  }
  if (!status) return status.error();
  take_labels(out);
  return out;
}

}  // namespace overtet::io_detail
