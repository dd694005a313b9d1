#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include "src/io/mesh_parts.h"
#include "src/io/names.h"
#include "src/io/text.h"
#include "src/io/vtk_data.h"

namespace overtet::io_detail {

namespace {

// VTK's names of types of numbers.
struct VtkType {
  std::string_view name;
  std::size_t size;
  bool real, is_signed;
  NumberType type;
};
// null: unknown.
const VtkType* vtk_type(std::string_view name) {
  static constexpr VtkType types[] = {{"double", 8, true, true, NumberType::float64},
                                      {"float", 4, true, true, NumberType::float32},
                                      {"int", 4, false, true, NumberType::int32},
                                      {"unsigned_int", 4, false, false, NumberType::int64},
                                      {"vtktypeint64", 8, false, true, NumberType::int64},
                                      {"vtktypeuint64", 8, false, false, NumberType::int64},
                                      {"long", 8, false, true, NumberType::int64},
                                      {"unsigned_long", 8, false, false, NumberType::int64},
                                      {"vtkidtype", 4, false, true, NumberType::int32},
                                      {"short", 2, false, true, NumberType::int32},
                                      {"unsigned_short", 2, false, false, NumberType::int32},
                                      {"char", 1, false, true, NumberType::int32},
                                      {"unsigned_char", 1, false, false, NumberType::uint8}};
  const VtkType* type =
      std::find_if(std::begin(types), std::end(types), [&](const VtkType& t) { return t.name == name; });
  return type == std::end(types) ? nullptr : type;
}

double big_endian(const char* p, const VtkType& type) {
  std::uint64_t bits = 0;
  for (std::size_t k = 0; k < type.size; ++k) bits = bits << 8 | static_cast<unsigned char>(p[k]);
  if (type.real)
    return type.size == 8 ? std::bit_cast<double>(bits)
                          : double{std::bit_cast<float>(static_cast<std::uint32_t>(bits))};
  if (!type.is_signed) return static_cast<double>(bits);
  const int unused = static_cast<int>(64 - 8 * type.size);
  return static_cast<double>(static_cast<std::int64_t>(bits << unused) >> unused);
}

// Words and numbers of a legacy VTK file, ASCII or binary. Every function returns false and keeps the error
// after a failure.
class VtkSource {
 public:
  VtkSource(std::string_view name, std::string_view bytes) : name_(name), bytes_(bytes) {}

  std::string_view line() {
    const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
    std::string_view text = bytes_.substr(at_, end - at_);
    at_ = std::min(end + 1, bytes_.size());
    if (!text.empty() && text.back() == '\r') text.remove_suffix(1);
    return text;
  }
  // The next word on this line or a later one; empty at the end.
  std::string_view word() {
    while (at_ < bytes_.size() && static_cast<unsigned char>(bytes_[at_]) <= ' ') ++at_;
    const std::size_t begin = at_;
    while (at_ < bytes_.size() && static_cast<unsigned char>(bytes_[at_]) > ' ') ++at_;
    return bytes_.substr(begin, at_ - begin);
  }
  // The next word of this line, or nothing.
  std::string_view word_here() {
    while (at_ < bytes_.size() && (bytes_[at_] == ' ' || bytes_[at_] == '\t' || bytes_[at_] == '\r')) ++at_;
    return at_ < bytes_.size() && bytes_[at_] != '\n' ? word() : std::string_view();
  }
  bool count(std::int64_t& n, const char* what) {
    const std::string_view w = word();
    const auto [stop, code] = std::from_chars(w.data(), w.data() + w.size(), n);
    if (code == std::errc() && stop == w.data() + w.size() && n >= 0 && n <= 8 * kMaxCount) return true;
    return fail(quoted(w) + " is not a count (" + what + ")");
  }
  bool type(const VtkType*& out) {
    const std::string w = lower(word());
    out = vtk_type(w);
    return out || fail(quoted(w) + " is not a type of numbers that Overtet reads");
  }
  bool numbers(std::int64_t n, const VtkType& type, std::vector<double>& out) {
    const std::int64_t left = static_cast<std::int64_t>(bytes_.size() - at_) + 1;
    if (n > left / (binary_ ? static_cast<std::int64_t>(type.size) : 2))
      return fail("the file is too short for " + std::to_string(n) + " numbers");
    out.resize(static_cast<std::size_t>(n));
    if (binary_) {
      line();
      if (bytes_.size() - at_ < out.size() * type.size) return fail("the file ends too early");
      for (double& x : out) {
        x = big_endian(bytes_.data() + at_, type);
        at_ += type.size;
      }
      return true;
    }
    for (double& x : out) {
      const std::string_view w = word();
      const auto [stop, code] = std::from_chars(w.data(), w.data() + w.size(), x);
      if (code == std::errc::invalid_argument || stop != w.data() + w.size())
        return fail(quoted(w) + " is not a number");
      if (code == std::errc::result_out_of_range) x = std::strtod(std::string(w).c_str(), nullptr);
    }
    return true;
  }
  bool binary() const { return binary_; }
  void set_binary(bool binary) { binary_ = binary; }
  bool fail(const std::string& what) {
    if (!error_) error_ = malformed(name_, what);
    return false;
  }
  Error error() const { return *error_; }

 private:
  std::string_view name_, bytes_;
  std::size_t at_ = 0;
  bool binary_ = false;
  std::optional<Error> error_;
};

class VtkReader {
 public:
  VtkReader(std::string_view name, std::string_view bytes) : name_(name), in_(name, bytes) {}

  Result<MeshParts> read() {
    const std::string_view first = in_.line();
    const std::size_t version = first.rfind(' ');
    v5_ = version != std::string_view::npos && first.substr(version + 1) >= "5" && first.size() > version + 3;
    in_.line();  // the title
    const std::string storage = lower(in_.word());
    if (storage != "ascii" && storage != "binary")
      return malformed(name_, "the third line is neither ASCII nor BINARY");
    in_.set_binary(storage == "binary");
    for (std::string_view key = in_.word(); !key.empty(); key = in_.word())
      if (!section(lower(key))) return in_.error();
    if (poly_data_) data_.types.assign(data_.ends.size(), 7);
    return parts_of(name_, std::move(data_), "VTK");
  }

 private:
  bool section(const std::string& key) {
    std::int64_t n = 0;
    const VtkType* type = nullptr;
    if (key == "dataset") {
      const std::string kind = lower(in_.word());
      poly_data_ = kind == "polydata";
      return poly_data_ || kind == "unstructured_grid" ||
             in_.fail("the data set is neither POLYDATA nor UNSTRUCTURED_GRID");
    }
    if (key == "points")
      return in_.count(n, "the number of points") && in_.type(type) &&
             in_.numbers(3 * n, *type, data_.points);
    if (key == "cells" || key == "polygons") return cells(data_.connectivity, data_.ends);
    if (key == "vertices" || key == "lines" || key == "triangle_strips") {
      std::vector<double> corners, ends;
      if (key == "triangle_strips")
        return in_.fail("the file has strips of triangles; save them as triangles");
      if (!cells(corners, ends)) return false;
      data_.other_cells += static_cast<std::int64_t>(ends.size());
      return true;
    }
    if (key == "cell_types")
      return in_.count(n, "the number of cells") && in_.numbers(n, *vtk_type("int"), data_.types);
    if (key == "point_data" || key == "cell_data") {
      list_ = key == "point_data" ? &data_.point_data : &data_.cell_data;
      return in_.count(items_, "the number of items");
    }
    return data(key);
  }

  bool data(const std::string& key) {
    if (key == "field") {
      in_.word();
      std::int64_t n = 0;
      if (!in_.count(n, "the number of arrays")) return false;
      for (; n > 0; --n)
        if (!field()) return false;
      return true;
    }
    if (key == "metadata") {
      while (!in_.line().empty()) {
      }
      return true;
    }
    if (key == "lookup_table") {
      std::int64_t n = 0;
      std::vector<double> unused;
      in_.word();
      return in_.count(n, "the length of a table") &&
             in_.numbers(4 * n, *vtk_type(in_.binary() ? "unsigned_char" : "double"), unused);
    }
    Attribute a;
    a.name = one_line(in_.word());
    const VtkType* type = vtk_type("double");
    std::int64_t width = 3;
    if (key == "scalars") {
      if (!in_.type(type)) return false;
      const std::string_view more = in_.word_here();
      width = 1;
      if (!more.empty()) std::from_chars(more.data(), more.data() + more.size(), width);
      in_.word(), in_.word();  // LOOKUP_TABLE name
    } else if (key == "color_scalars") {
      if (!in_.count(width, "the number of colours")) return false;
      type = vtk_type(in_.binary() ? "unsigned_char" : "float");
    } else if (key == "texture_coordinates") {
      if (!in_.count(width, "the dimension") || !in_.type(type)) return false;
    } else if (key == "vectors" || key == "normals") {
      if (!in_.type(type)) return false;
    } else if (key == "tensors") {
      width = 9;
      if (!in_.type(type)) return false;
    } else {
      return in_.fail(quoted(key) + " is not a keyword of VTK files that Overtet knows");
    }
    if (width < 1 || width > 1000) return in_.fail("an array cannot have that width");
    a.width = static_cast<int>(width);
    a.type = type->type;
    if (!in_.numbers(items_ * width, *type, a.values)) return false;
    if (list_) list_->push_back(std::move(a));
    return true;
  }

  // One array of a field; before any POINT_DATA or CELL_DATA it belongs to the whole.
  bool field() {
    Attribute a;
    std::string_view name = in_.word();
    if (lower(name) == "metadata") {
      while (!in_.line().empty()) {
      }
      name = in_.word();
    }
    a.name = one_line(name);
    std::int64_t width = 0, tuples = 0;
    const VtkType* type = nullptr;
    if (!in_.count(width, "the width of an array") || !in_.count(tuples, "the length of an array") ||
        !in_.type(type))
      return false;
    if (width > 1000) return in_.fail("an array cannot have that width");
    a.width = static_cast<int>(width);
    a.type = type->type;
    if (!in_.numbers(width * tuples, *type, a.values)) return false;
    if (width > 0) (list_ ? list_ : &data_.field_data)->push_back(std::move(a));
    return true;
  }

  // Up to version 4: how many corners, and they, for each; from 5 on: where each begins, and all corners.
  bool cells(std::vector<double>& corners, std::vector<double>& ends) {
    std::int64_t n = 0, size = 0;
    if (!in_.count(n, "the number of cells") || !in_.count(size, "the number of corners")) return false;
    if (v5_) {
      const VtkType* type = nullptr;
      if (n == 0) return true;
      if (lower(in_.word()) != "offsets") return in_.fail("the OFFSETS of cells are missing");
      if (!in_.type(type) || !in_.numbers(n, *type, ends)) return false;
      if (lower(in_.word()) != "connectivity") return in_.fail("the CONNECTIVITY of cells is missing");
      if (!in_.type(type) || !in_.numbers(size, *type, corners)) return false;
      ends.erase(ends.begin());
      return true;
    }
    std::vector<double> list;
    if (!in_.numbers(size, *vtk_type("int"), list)) return false;
    std::size_t at = 0;
    for (std::int64_t c = 0; c < n; ++c) {
      const double corners_said = at < list.size() ? list[at] : -1;
      if (!(corners_said >= 0 && corners_said <= static_cast<double>(list.size() - at - 1)))
        return in_.fail("cell " + std::to_string(c) + " has no corners");
      const auto count = static_cast<std::ptrdiff_t>(corners_said);
      corners.insert(corners.end(), list.begin() + static_cast<std::ptrdiff_t>(at) + 1,
                     list.begin() + static_cast<std::ptrdiff_t>(at) + 1 + count);
      ends.push_back(static_cast<double>(corners.size()));
      at += static_cast<std::size_t>(count) + 1;
    }
    return true;
  }

  std::string_view name_;
  VtkSource in_;
  VtkDataSet data_;
  bool v5_ = false, poly_data_ = false;
  std::vector<Attribute>* list_ = nullptr;
  std::int64_t items_ = 0;
};

}  // namespace

Result<MeshParts> parse_vtk(std::string_view name, std::string_view bytes) {
  return VtkReader(name, bytes).read();
}

}  // namespace overtet::io_detail
