#include <array>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "src/io/mesh_parts.h"
#include "src/io/tokens.h"

namespace overtet::io_detail {

namespace {

// Corners of Gmsh's element types 1 .. 19, to skip what is not a tet or a face.
constexpr std::array<int, 20> kGmshCorners = {0, 2,  3,  4,  4,  8, 6, 5,  3,  6,
                                              9, 10, 27, 18, 14, 1, 8, 20, 15, 13};

// Gmsh numbers nodes and elements as it likes; file order becomes our order.
class FileNumbers {
 public:
  void add(std::int64_t tag) {
    if (consecutive_ && tag != count_ + 1) {
      for (Index k = 0; k < count_; ++k) of_[k + 1] = k;
      consecutive_ = false;
    }
    if (!consecutive_) of_[tag] = count_;
    ++count_;
  }
  Index find(std::int64_t tag) const {
    if (consecutive_) return tag >= 1 && tag <= count_ ? static_cast<Index>(tag - 1) : -1;
    const auto it = of_.find(tag);
    return it == of_.end() ? -1 : it->second;
  }
  Index count() const { return count_; }

 private:
  std::unordered_map<std::int64_t, Index> of_;
  bool consecutive_ = true;  // number k is k + 1: no table needed
  Index count_ = 0;
};

// How an element of a type is read: as a tet or a face with so many corners, or (0) not at all.
struct Kind {
  bool tet = false;
  int corners = 0;
};
Kind kind_of(std::int64_t type) {
  switch (type) {
    case 2:
    case 9:
      return {false, 3};
    case 3:
    case 10:
    case 16:
      return {false, 4};
    case 4:
    case 11:
      return {true, 4};
    default:
      return {};
  }
}

// Named data of nodes or elements: one number each.
struct Values {
  std::string name;
  std::vector<std::pair<std::int64_t, double>> of;
};

// A name that stands for a label which Gmsh has no number for (write_gmsh.cpp): "label -3", or "label -3
// inlet". Its own name is what is left.
bool hidden_label(const std::string& name, Index& label, std::string& own) {
  constexpr std::string_view prefix = "label ";
  if (!name.starts_with(prefix)) return false;
  const char *begin = name.data() + prefix.size(), *end = name.data() + name.size();
  const auto [stop, code] = std::from_chars(begin, end, label);
  if (code != std::errc() || label > 0 || (stop != end && *stop != ' ')) return false;
  own = stop == end ? "" : std::string(stop + 1, end);
  return true;
}

// More than 12 members: what the sections of a file say, until all have been read.
class GmshReader {
 public:
  GmshReader(std::string_view name, std::string_view bytes) : in_(name, bytes, false) {}

  Result<MeshParts> read() {
    std::string_view key;
    while (in_.word(key)) {
      if (key[0] != '$' || key.substr(0, 4) == "$End") continue;
      if (!section(key)) return in_.error();
    }
    if (nodes_.count() == 0) return malformed(in_.name(), "the file has no nodes");
    parts_.format = v41_ ? "Gmsh 4.1" : "Gmsh 2.2";
    finish();
    return std::move(parts_);
  }

 private:
  bool section(std::string_view key) {
    if (key == "$MeshFormat") return format();
    if (key == "$PhysicalNames") return names();
    if (key == "$Entities") return !v41_ || entities();
    if (key == "$Nodes") return nodes();
    if (key == "$Elements") return elements();
    if (key == "$NodeData") return data(node_data_);
    if (key == "$ElementData") return data(element_data_);
    const std::string end = "$End" + std::string(key.substr(1));
    std::string_view word;
    while (in_.word(word) && word != end) {
    }
    return true;
  }

  bool format() {
    std::string_view version;
    std::int64_t binary = 0;
    if (!in_.word(version)) return in_.fail("the file ends where its version should be");
    if (!in_.integer(binary, "the file type")) return false;
    if (version != "4.1" && version != "2.2")
      return in_.fail("Gmsh version " + quoted(version) + " is not 2.2 or 4.1");
    if (binary != 0) return in_.fail("this is a binary Gmsh file; save it as ASCII");
    v41_ = version == "4.1";
    return true;
  }

  bool names() {
    std::int64_t n = 0, dimension = 0;
    if (!in_.count(n, 6, "the number of physical names")) return false;
    for (std::int64_t i = 0; i < n; ++i) {
      Index tag = 0;
      if (!in_.integer(dimension, "a dimension") || !in_.label(tag, "a physical group")) return false;
      std::string_view name = in_.rest_of_line();
      if (name.size() >= 2 && name.front() == '"' && name.back() == '"')
        name = name.substr(1, name.size() - 2);
      if (dimension == 2) parts_.labels.names[tag] = one_line(name);
      if (dimension == 3) parts_.regions.names[tag] = one_line(name);
    }
    return true;
  }

  // Which physical group each surface and volume belongs to: the first one that is named.
  bool entities() {
    std::int64_t n[4];
    for (std::int64_t& x : n)
      if (!in_.count(x, 8, "the number of entities")) return false;
    for (int d = 0; d < 4; ++d)
      for (std::int64_t i = 0; i < n[d]; ++i) {
        std::int64_t tag = 0, groups = 0, bounding = 0;
        if (!in_.integer(tag, "an entity") || !in_.skip(d == 0 ? 3 : 6) ||
            !in_.count(groups, 2, "the number of physical groups"))
          return false;
        for (std::int64_t g = 0; g < groups; ++g) {
          Index group = 0;
          if (!in_.label(group, "a physical group")) return false;
          if (g == 0 && d >= 2) group_[d - 2][tag] = std::abs(group);
        }
        if (d > 0 && (!in_.count(bounding, 2, "a number of entities") || !in_.skip(bounding))) return false;
      }
    return true;
  }

  bool point() {
    double c = 0;
    for (int k = 0; k < 3; ++k) {
      if (!in_.real(c, "a node")) return false;
      parts_.xyz.push_back(c);
    }
    return true;
  }

  bool nodes() {
    std::int64_t n = 0, blocks = 1, x = 0;
    if (!v41_) {
      if (!in_.count(n, 8, "the number of nodes")) return false;
      for (std::int64_t v = 0; v < n; ++v) {
        if (!in_.integer(x, "a node number")) return false;
        nodes_.add(x);
        if (!point()) return false;
      }
      return true;
    }
    if (!in_.integer(blocks, "the number of blocks") || !in_.count(n, 8, "the number of nodes") ||
        !in_.skip(2))
      return false;
    for (std::int64_t b = 0; b < blocks; ++b) {
      std::int64_t dimension = 0, parametric = 0, in_block = 0;
      if (!in_.integer(dimension, "a dimension") || !in_.skip(1) || !in_.integer(parametric, "a flag") ||
          !in_.count(in_block, 8, "the number of nodes of a block"))
        return false;
      for (std::int64_t v = 0; v < in_block; ++v) {
        if (!in_.integer(x, "a node number")) return false;
        nodes_.add(x);
      }
      for (std::int64_t v = 0; v < in_block; ++v)
        if (!point() || !in_.skip(parametric ? dimension : 0)) return false;
    }
    return true;
  }

  // The rest of an element's line: its vertices.
  bool element(std::int64_t number, std::int64_t type, Index group, Index entity) {
    const Kind kind = kind_of(type);
    const int all = kGmshCorners[static_cast<std::size_t>(type)];
    std::vector<Index>& out = kind.tet ? parts_.tets : parts_.corners;
    for (int k = 0; k < kind.corners; ++k) {
      std::int64_t tag = 0;
      if (!in_.integer(tag, kind.tet ? "a corner of a tet" : "a corner of a face")) return false;
      const Index v = nodes_.find(tag);
      if (v < 0) return in_.fail("there is no node " + std::to_string(tag));
      out.push_back(v);
    }
    if (!in_.skip(all - kind.corners)) return false;
    if (kind.corners == 0) return true;
    parts_.second_order |= all > kind.corners;
    if (!kind.tet) parts_.sizes.push_back(kind.corners);
    (kind.tet ? parts_.regions : parts_.labels).of.push_back(group);
    entity_[kind.tet].push_back(entity);
    element_[kind.tet].add(number);
    return true;
  }

  bool known(std::int64_t type) {
    return (type > 0 && type < static_cast<std::int64_t>(kGmshCorners.size())) ||
           in_.fail("element type " + std::to_string(type) + " is not one that Overtet knows");
  }

  bool elements() {
    std::int64_t n = 0, blocks = 1, type = 0, tags = 0, number = 0;
    if (!v41_) {
      if (!in_.count(n, 8, "the number of elements")) return false;
      for (std::int64_t t = 0; t < n; ++t) {
        Index tag[2] = {0, 0};
        if (!in_.integer(number, "an element number") || !in_.integer(type, "an element type") ||
            !known(type) || !in_.integer(tags, "a number of tags"))
          return false;
        for (std::int64_t k = 0; k < tags && k < 2; ++k)
          if (!in_.label(tag[k], "a tag")) return false;
        if ((tags > 2 && !in_.skip(tags - 2)) || !element(number, type, std::abs(tag[0]), tag[1]))
          return false;
      }
      return true;
    }
    if (!in_.integer(blocks, "the number of blocks") || !in_.count(n, 4, "the number of elements") ||
        !in_.skip(2))
      return false;
    for (std::int64_t b = 0; b < blocks; ++b) {
      std::int64_t dimension = 0, in_block = 0;
      Index entity = 0;
      if (!in_.integer(dimension, "a dimension") || !in_.label(entity, "an entity") ||
          !in_.integer(type, "an element type") || !known(type) ||
          !in_.count(in_block, 4, "the number of elements of a block"))
        return false;
      Index group = 0;
      if (dimension == 2 || dimension == 3)
        if (const auto at = group_[dimension - 2].find(entity); at != group_[dimension - 2].end())
          group = at->second;
      for (std::int64_t t = 0; t < in_block; ++t)
        if (!in_.integer(number, "an element number") || !element(number, type, group, entity)) return false;
    }
    return true;
  }

  // Data with one number each; others are passed over.
  bool data(std::vector<Values>& out) {
    Values values;
    std::int64_t n = 0, width = 0, count = 0;
    double x = 0;
    if (!in_.count(n, 2, "the number of names")) return false;
    in_.next_line();
    for (std::int64_t i = 0; i < n; ++i, in_.next_line()) {
      std::string_view name = in_.rest_of_line();
      if (name.size() >= 2 && name.front() == '"') name = name.substr(1, name.size() - 2);
      if (i == 0) values.name = name;
    }
    if (!in_.count(n, 2, "the number of reals") || !in_.skip(n)) return false;
    if (!in_.count(n, 2, "the number of whole numbers")) return false;
    for (std::int64_t i = 0; i < n; ++i)
      if (!in_.integer(i == 1 ? width : i == 2 ? count : tag_, "a whole number")) return false;
    for (std::int64_t i = 0; i < count; ++i) {
      std::int64_t number = 0;
      if (!in_.integer(number, "a number of a node or element")) return false;
      for (std::int64_t k = 0; k < width; ++k)
        if (!in_.real(x, "a value")) return false;
      values.of.emplace_back(number, x);
    }
    if (width == 1) out.push_back(std::move(values));
    return true;
  }

  // Groups where there are any, else entities; and the data that Overtet knows.
  void finish() {
    for (const bool tet : {false, true}) {
      Labels& labels = tet ? parts_.regions : parts_.labels;
      bool grouped = false;
      for (const Index g : labels.of) grouped |= g != 0;
      if (!grouped) labels.of = entity_[tet];
      std::map<Index, Index> hidden;
      std::map<Index, std::string> own_names;
      for (auto it = labels.names.begin(); it != labels.names.end();) {
        Index label = 0;
        std::string own;
        const bool hides = hidden_label(it->second, label, own);
        if (hides) hidden[it->first] = label;
        if (!own.empty()) own_names[label] = own;
        it = hides ? labels.names.erase(it) : std::next(it);
      }
      if (hidden.empty()) continue;
      labels.names.merge(own_names);
      for (Index& l : labels.of)
        if (const auto at = hidden.find(l); at != hidden.end()) l = at->second;
    }
    for (const Values& values : element_data_) {
      if (values.name == "layers") fill(values, element_[1], 1, parts_.layers);
      if (values.name == "input_face") fill(values, element_[0], -1, parts_.input_face);
    }
    for (const Values& values : node_data_)
      if (values.name == "input_vertex") fill(values, nodes_, -1, parts_.input_vertex);
  }

  static void fill(const Values& values, const FileNumbers& numbers, Index otherwise,
                   std::vector<Index>& out) {
    if (out.empty()) out.assign(static_cast<std::size_t>(numbers.count()), otherwise);
    for (const auto& [number, x] : values.of)
      if (const Index i = numbers.find(number); i >= 0 && std::abs(x) <= double{kMaxCount})
        out[static_cast<std::size_t>(i)] = static_cast<Index>(x);
  }

  Tokens in_;
  MeshParts parts_;
  bool v41_ = false;
  std::int64_t tag_ = 0;            // read and not needed
  FileNumbers nodes_, element_[2];  // of faces, of tets
  std::vector<Index> entity_[2];
  std::unordered_map<std::int64_t, Index> group_[2];  // of surfaces, of volumes
  std::vector<Values> node_data_, element_data_;
};

}  // namespace

Result<MeshParts> parse_gmsh(std::string_view name, std::string_view bytes) {
  return GmshReader(name, bytes).read();
}

}  // namespace overtet::io_detail
