#include <cctype>
#include <charconv>
#include <unordered_map>
#include <utility>

#include "kernels/core/tet_tables.h"
#include "src/io/abaqus.h"
#include "src/io/mesh_parts.h"
#include "src/io/names.h"
#include "src/io/text.h"

namespace overtet::io_detail {

namespace {

std::string_view trimmed(std::string_view s) {
  while (!s.empty() && static_cast<unsigned char>(s.front()) <= ' ') s.remove_prefix(1);
  while (!s.empty() && static_cast<unsigned char>(s.back()) <= ' ') s.remove_suffix(1);
  return s;
}

// "*ELEMENT, TYPE=C3D4, ELSET=X": the parameter's value, as it is written.
std::string_view parameter(std::string_view line, std::string_view key) {
  for (std::size_t at = line.find(','); at != std::string_view::npos; at = line.find(',', at + 1)) {
    const std::string_view rest = line.substr(at + 1);
    const std::string_view one = rest.substr(0, rest.find(','));
    const std::size_t equals = one.find('=');
    if (lower(trimmed(one.substr(0, equals))) == key)
      return equals == std::string_view::npos ? std::string_view() : trimmed(one.substr(equals + 1));
  }
  return {};
}

// A set or surface that Overtet has written: "LABEL_7_INLET" is label 7, "REGION_M2" region -2.
bool numbered(std::string_view name, std::string_view prefix, Index& number) {
  if (lower(name.substr(0, prefix.size())) != lower(prefix)) return false;
  name.remove_prefix(prefix.size());
  const bool minus = !name.empty() && (name[0] == 'M' || name[0] == 'm');
  if (minus) name.remove_prefix(1);
  Index digits = 0;
  const auto [stop, code] = std::from_chars(name.data(), name.data() + name.size(), digits);
  if (code != std::errc() || digits < 0 || (stop != name.data() + name.size() && *stop != '_')) return false;
  number = minus ? -digits : digits;
  return true;
}

// More than 12 members: what the lines of a file say, until all have been read.
class AbaqusReader {
 public:
  AbaqusReader(std::string_view name, std::string_view bytes) : name_(name), bytes_(bytes) {}

  Result<MeshParts> read() {
    parts_.format = "Abaqus";
    std::string keyword;
    while (!bytes_.empty()) {
      const std::string_view line = next();
      if (line.empty()) continue;
      if (line.starts_with("**")) {
        comment(line);
      } else if (line[0] == '*') {
        keyword = lower(trimmed(line.substr(1, std::min(line.find(','), line.size()) - 1)));
        if (!begin(keyword, line)) return error_;
      } else if (!data(keyword, line)) {
        return error_;
      }
    }
    finish();
    return std::move(parts_);
  }

 private:
  std::string_view next() {
    const std::size_t end = std::min(bytes_.find('\n'), bytes_.size());
    const std::string_view line = trimmed(bytes_.substr(0, end));
    bytes_.remove_prefix(std::min(end + 1, bytes_.size()));
    ++line_;
    return line;
  }
  bool fail(const std::string& what) {
    error_ = malformed(name_, "line " + std::to_string(line_) + ": " + what);
    return false;
  }

  // What does not fit elsewhere is in comments (write_abaqus.cpp).
  void comment(std::string_view line) {
    if (line.starts_with(kAbaqus.exact)) {
      std::string_view rest = line.substr(kAbaqus.exact.size());
      std::int64_t number = 0;
      if (whole(field(rest), number)) exact_[number] = rest;
      return;
    }
    for (const bool label : {false, true}) {
      const std::string_view prefix = label ? kAbaqus.label_name : kAbaqus.region_name;
      if (!line.starts_with(prefix)) continue;
      Index number = 0;
      const std::string_view rest = line.substr(prefix.size());
      const auto [stop, code] = std::from_chars(rest.data(), rest.data() + rest.size(), number);
      if (code == std::errc() && stop != rest.data() + rest.size())
        (label ? parts_.labels : parts_.regions).names[number] =
            one_line(rest.substr(static_cast<std::size_t>(stop + 1 - rest.data())));
    }
  }

  bool begin(const std::string& keyword, std::string_view line) {
    into_ = nullptr;
    if (keyword == "element") {
      const std::string type = lower(parameter(line, "type"));
      corners_ = type == "c3d4" || type == "c3d4h" ? 4 : type.starts_with("c3d10") ? 10 : 0;
      parts_.second_order |= corners_ == 10;
      region_ = 0;
      const std::string_view set = parameter(line, "elset");
      if (!numbered(set, kAbaqus.region, region_) && !set.empty()) {
        const auto [at, is_new] =
            set_regions_.try_emplace(std::string(set), static_cast<Index>(set_regions_.size() + 1));
        region_ = at->second;
        if (is_new) parts_.regions.names[region_] = one_line(set);
      }
    } else if (keyword == "surface") {
      const std::string type = lower(parameter(line, "type"));
      if (type.empty() || type == "element") {
        surfaces_.push_back({std::string(parameter(line, "name")), {}});
        into_ = &surfaces_.back().faces;
      }
    } else if (keyword == "include") {
      return fail("the file includes another one, which Overtet does not read");
    }
    return true;
  }

  bool data(const std::string& keyword, std::string_view line) {
    if (keyword == "node") return node(line);
    if (keyword == "element") return element(line);
    if (keyword == "surface" && into_) return face(line);
    return true;
  }

  // The fields of a line: whole numbers, as far as there are any.
  static std::string_view field(std::string_view& line) {
    const std::size_t end = std::min(line.find(','), line.size());
    const std::string_view one = trimmed(line.substr(0, end));
    line.remove_prefix(std::min(end + 1, line.size()));
    return one;
  }
  bool whole(std::string_view text, std::int64_t& n) {
    const auto [stop, code] = std::from_chars(text.data(), text.data() + text.size(), n);
    return (code == std::errc() && stop == text.data() + text.size()) ||
           fail(quoted(text) + " is not a whole number");
  }

  bool node(std::string_view line) {
    std::int64_t number = 0;
    if (!whole(field(line), number)) return false;
    if (const auto at = exact_.find(number); at != exact_.end()) line = at->second;
    for (int k = 0; k < 3; ++k) {
      const std::string_view text = field(line);
      TextCursor in(name_, text.empty() ? "0" : text, false, line_);
      double x = 0;
      if (!in.real(x, [] { return "a node"; })) {
        error_ = in.error();
        return false;
      }
      parts_.xyz.push_back(x);
    }
    node_[number] = static_cast<Index>(parts_.xyz.size() / 3 - 1);
    return true;
  }

  // A line may go on with the next one.
  bool element(std::string_view line) {
    if (corners_ == 0) return true;
    std::int64_t number = 0;
    if (!whole(field(line), number)) return false;
    for (int k = 0; k < corners_; ++k) {
      while (line.empty()) {
        if (bytes_.empty()) return fail("the file ends inside an element");
        line = next();
      }
      std::int64_t tag = 0;
      if (!whole(field(line), tag)) return false;
      const auto at = node_.find(tag);
      if (at == node_.end()) return fail("there is no node " + std::to_string(tag));
      if (k < 4) parts_.tets.push_back(at->second);
    }
    element_[number] = static_cast<Index>(parts_.regions.of.size());
    parts_.regions.of.push_back(region_);
    return true;
  }

  // "element, S1"; a set of elements instead of one is passed over.
  bool face(std::string_view line) {
    std::int64_t number = 0;
    const std::string_view first = field(line), side = field(line);
    if (first.empty() || !std::isdigit(static_cast<unsigned char>(first[0]))) return true;
    if (!whole(first, number)) return false;
    const auto at = element_.find(number);
    if (at == element_.end() || side.size() != 2 || side[1] < '1' || side[1] > '4') return true;
    into_->push_back(4 * std::int64_t{at->second} + (side[1] - '1'));
    return true;
  }

  void add_triangle(std::int64_t face, Index label) {
    for (int k = 0; k < 3; ++k)
      parts_.corners.push_back(
          parts_.tets[static_cast<std::size_t>(face / 4 * 4 + kTetFace[kAbaqusFace[face % 4]][k])]);
    parts_.sizes.push_back(3);
    parts_.labels.of.push_back(label);
  }

  // The surface that holds all faces gives their order, those of the labels the labels.
  void finish() {
    std::unordered_map<std::int64_t, Index> label_of;
    Index next_label = 1;
    const Surface* all = nullptr;
    std::vector<const Surface*> others;
    for (const Surface& s : surfaces_) {
      Index label = 0;
      if (lower(s.name) == lower(kAbaqus.boundary))
        all = &s;
      else if (numbered(s.name, kAbaqus.label, label))
        for (const std::int64_t f : s.faces) label_of[f] = label;
      else
        others.push_back(&s);
    }
    for (const Surface* s : others) {
      while (parts_.labels.names.contains(next_label)) ++next_label;
      if (!s->faces.empty()) parts_.labels.names[next_label] = one_line(s->name);
      for (const std::int64_t f : s->faces) label_of.try_emplace(f, next_label);
    }
    const auto label = [&](std::int64_t f) {
      const auto at = label_of.find(f);
      return at == label_of.end() ? 0 : at->second;
    };
    if (all) {
      for (const std::int64_t f : all->faces) add_triangle(f, label(f));
    } else {
      for (const Surface& s : surfaces_)
        for (const std::int64_t f : s.faces)
          if (const auto at = label_of.find(f); at != label_of.end()) {
            add_triangle(f, at->second);
            label_of.erase(at);
          }
    }
  }

  struct Surface {
    std::string name;
    std::vector<std::int64_t> faces;  // 4 * tet + the number of its face, from 0
  };

  std::string_view name_, bytes_;
  std::unordered_map<std::int64_t, std::string_view> exact_;  // coordinates of nodes
  std::int64_t line_ = 0;
  Error error_;
  MeshParts parts_;
  int corners_ = 0;
  Index region_ = 0;
  std::unordered_map<std::int64_t, Index> node_, element_;
  std::map<std::string, Index> set_regions_;
  std::vector<Surface> surfaces_;
  std::vector<std::int64_t>* into_ = nullptr;
};

}  // namespace

Result<MeshParts> parse_abaqus(std::string_view name, std::string_view bytes) {
  return AbaqusReader(name, bytes).read();
}

}  // namespace overtet::io_detail
