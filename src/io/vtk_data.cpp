#include "src/io/vtk_data.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "src/io/text.h"

namespace overtet::io_detail {

namespace {

// VTK's numbers of cell types, and how many corners they have.
struct CellKind {
  int type, corners, all;
  bool tet;
};
// null: neither a tet nor a face with a fixed number of corners.
const CellKind* cell_kind(double type) {
  static constexpr CellKind kinds[] = {{5, 3, 3, false},  {9, 4, 4, false},  {10, 4, 4, true},
                                       {22, 3, 6, false}, {23, 4, 8, false}, {24, 4, 10, true}};
  const CellKind* kind =
      std::find_if(std::begin(kinds), std::end(kinds), [&](const CellKind& k) { return k.type == type; });
  return kind == std::end(kinds) ? nullptr : kind;
}

std::vector<Index> as_indices(const std::vector<double>& values) {
  std::vector<Index> out(values.size());
  std::transform(values.begin(), values.end(), out.begin(), as_index);
  return out;
}

std::map<Index, std::string> names_of(const std::vector<double>& bytes) {
  std::string text;
  for (const double b : bytes) text += static_cast<char>(b >= 0 && b < 256 ? static_cast<int>(b) : 0);
  std::map<Index, std::string> names;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    Index label = 0;
    const auto [stop, code] = std::from_chars(&text[at], text.data() + end, label);
    if (code == std::errc() && stop < text.data() + end)
      names[label] = one_line(
          text.substr(static_cast<std::size_t>(stop + 1 - text.data()), text.data() + end - stop - 1));
    at = end + 1;
  }
  return names;
}

class VtkParts {
 public:
  VtkParts(std::string_view name, VtkDataSet&& data) : name_(name), data_(std::move(data)) {}

  Result<MeshParts> make(std::string format) {
    out_.format = std::move(format);
    if (data_.points.size() % 3 != 0 || data_.points.size() / 3 > static_cast<std::size_t>(kMaxCount))
      return bad("the numbers of points and cells do not fit the data arrays");
    vertices_ = static_cast<std::int64_t>(data_.points.size() / 3);
    if (data_.ends.size() != data_.types.size())
      return bad("the numbers of points and cells do not fit the data arrays");
    for (std::size_t c = 0; c < data_.types.size(); ++c)
      if (Status s = cell(c); !s) return s.error();
    for (Attribute& a : data_.point_data) take_point_data(std::move(a));
    for (const Attribute& a : data_.cell_data) take_cell_data(a);
    if (Status s = take_fields(); !s) return s.error();
    out_.xyz = std::move(data_.points);
    return std::move(out_);
  }

 private:
  Error bad(const std::string& what) const { return malformed(name_, what); }

  Status cell(std::size_t c) {
    const std::int64_t begin = c == 0 ? 0 : static_cast<std::int64_t>(data_.ends[c - 1]);
    const double end_said = data_.ends[c];
    if (!(end_said >= static_cast<double>(begin) &&
          end_said <= static_cast<double>(data_.connectivity.size())))
      return bad("cell " + std::to_string(c) + " has no corners");
    const auto end = static_cast<std::int64_t>(end_said);
    const CellKind* kind = cell_kind(data_.types[c]);
    const bool polygon = data_.types[c] == 7 && end - begin >= 3;
    if (!kind && !polygon) return success();
    const std::int64_t corners = polygon ? end - begin : kind->corners, all = polygon ? corners : kind->all;
    const bool tet = !polygon && kind->tet;
    const std::string what = (tet ? "tet " : "face ") + std::to_string(c);
    if (end - begin != all)
      return bad(what + " does not have " + (tet && all == 4 ? "four" : std::to_string(all)) + " corners");
    out_.second_order |= all > corners;
    std::vector<Index>& out = tet ? out_.tets : out_.corners;
    for (std::int64_t k = begin; k < begin + corners; ++k) {
      const double v = data_.connectivity[static_cast<std::size_t>(k)];
      if (!(v >= 0 && v < static_cast<double>(vertices_)))
        return bad(what + " names a vertex that does not exist");
      out.push_back(static_cast<Index>(v));
    }
    if (!tet) out_.sizes.push_back(static_cast<Index>(corners));
    (tet ? tet_cells_ : face_cells_).push_back(c);
    return success();
  }

  void take_point_data(Attribute&& a) {
    if (a.values.size() != static_cast<std::size_t>(a.width) * static_cast<std::size_t>(vertices_)) return;
    if (a.name == "input_vertex" && a.width == 1)
      out_.input_vertex = as_indices(a.values);
    else
      out_.vertex_data.push_back(std::move(a));
  }

  // Those of the tets, or those of the faces, of a cell array.
  std::vector<double> picked(const Attribute& a, const std::vector<std::size_t>& cells) const {
    const auto width = static_cast<std::size_t>(a.width);
    std::vector<double> values;
    values.reserve(cells.size() * width);
    for (const std::size_t c : cells)
      for (std::size_t k = 0; k < width; ++k)
        values.push_back(a.values[(c + static_cast<std::size_t>(data_.other_cells)) * width + k]);
    return values;
  }

  void take_cell_data(const Attribute& a) {
    const std::size_t cells = data_.types.size() + static_cast<std::size_t>(data_.other_cells);
    if (a.width < 1 || a.values.size() != cells * static_cast<std::size_t>(a.width)) return;
    const bool whole = a.width == 1 && a.type != NumberType::float32 && a.type != NumberType::float64;
    if (!tet_cells_.empty()) {
      if (whole && a.name == "region") out_.regions.of = as_indices(picked(a, tet_cells_));
      if (whole && a.name == "layers") out_.layers = as_indices(picked(a, tet_cells_));
    }
    if (face_cells_.empty()) return;
    // Ours, and what meshio calls the labels of Gmsh and MEDIT.
    const bool label = a.name == "label" || a.name == "gmsh:physical" || a.name == "medit:ref";
    if (whole && label)
      out_.labels.of = as_indices(picked(a, face_cells_));
    else if (whole && a.name == "input_face")
      out_.input_face = as_indices(picked(a, face_cells_));
    else if (a.name != "region" && a.name != "layers")
      out_.polygon_data.push_back({a.name, a.type, a.width, picked(a, face_cells_)});
  }

  // Boundary triangles, their labels and data, and names (write_vtk.cpp).
  Status take_fields() {
    constexpr std::string_view prefix = "boundary_";
    const Attribute* triangles = nullptr;
    for (const Attribute& a : data_.field_data) {
      if (a.name == "region_names") out_.regions.names = names_of(a.values);
      if (a.name == "label_names") out_.labels.names = names_of(a.values);
      // The first, as they are written: data of theirs may bear the same name.
      if (a.name == "boundary_triangles" && a.width == 3 && !triangles) triangles = &a;
    }
    if (!triangles || out_.tets.empty()) return success();
    const std::size_t count = triangles->values.size() / 3;
    out_.corners.clear(), out_.polygon_data.clear(), out_.labels.of.clear(), out_.input_face.clear();
    out_.sizes.assign(count, 3);
    for (std::size_t i = 0; i < 3 * count; ++i) {
      const double v = triangles->values[i];
      if (!(v >= 0 && v < static_cast<double>(vertices_)))
        return bad("boundary triangle " + std::to_string(i / 3) + " names a vertex that does not exist");
      out_.corners.push_back(static_cast<Index>(v));
    }
    for (const Attribute& a : data_.field_data) {
      if (&a == triangles || !a.name.starts_with(prefix)) continue;
      if (a.values.size() != count * static_cast<std::size_t>(a.width)) continue;
      const std::string which = a.name.substr(prefix.size());
      if (which == "label" && a.width == 1)
        out_.labels.of = as_indices(a.values);
      else if (which == "input_face" && a.width == 1)
        out_.input_face = as_indices(a.values);
      else
        out_.polygon_data.push_back({which, a.type, a.width, a.values});
    }
    return success();
  }

  std::string_view name_;
  VtkDataSet data_;
  MeshParts out_;
  std::int64_t vertices_ = 0;
  std::vector<std::size_t> tet_cells_, face_cells_;
};

}  // namespace

Result<MeshParts> parts_of(std::string_view name, VtkDataSet&& data, std::string format) {
  return VtkParts(name, std::move(data)).make(std::move(format));
}

std::string text_of_names(const std::map<Index, std::string>& names) {
  std::string text;
  for (const auto& [label, name] : names) text += std::to_string(label) + " " + one_line(name) + "\n";
  return text;
}

std::string escaped(std::string_view name) {
  std::string out;
  for (const char c : name) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return out;
}

}  // namespace overtet::io_detail
