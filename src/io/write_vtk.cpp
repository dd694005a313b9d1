#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "src/io/tet_view.h"
#include "src/io/vtk_data.h"

namespace overtet::io_detail {

namespace {

static_assert(std::endian::native == std::endian::little,
              "the VTU writer stores native bytes as little endian");

const char* xml_name(NumberType type) {
  static constexpr const char* names[] = {"UInt8", "Int32", "Int64", "Float32", "Float64"};
  return names[static_cast<int>(type)];
}
const char* legacy_name(NumberType type) {
  static constexpr const char* names[] = {"unsigned_char", "int", "vtktypeint64", "float", "double"};
  return names[static_cast<int>(type)];
}

// Base64 of a byte count (64 bit) and the bytes: VTK's "binary" data array.
void base64(TextWriter& out, const void* data, std::size_t size) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const std::uint64_t count = size;
  const auto* head = reinterpret_cast<const unsigned char*>(&count);
  const auto* body = static_cast<const unsigned char*>(data);
  const std::size_t total = sizeof count + size;
  const auto byte = [&](std::size_t i) -> std::uint32_t {
    return i < sizeof count ? head[i] : body[i - sizeof count];
  };
  std::string block;
  for (std::size_t i = 0; i < total; i += 3) {
    const std::size_t have = std::min<std::size_t>(3, total - i);
    const std::uint32_t bits =
        byte(i) << 16 | (have > 1 ? byte(i + 1) << 8 : 0) | (have > 2 ? byte(i + 2) : 0);
    for (std::size_t k = 0; k < 4; ++k) block += k <= have ? kDigits[bits >> (18 - 6 * k) & 63] : '=';
    if (block.size() >= 3072) out.text(block), block.clear();
  }
  out.text(block).end_line();
}

// A name in a legacy file has no blanks.
std::string one_word(std::string_view name) {
  std::string out(name);
  for (char& c : out)
    if (static_cast<unsigned char>(c) <= ' ') c = '_';
  return out.empty() ? "_" : out;
}

// The nearest number that the type has; 0 for NaN. (A file may say that 300 is a byte.)
template <class T>
T nearest(double x) {
  if constexpr (std::is_floating_point_v<T>) return static_cast<T>(x);
  constexpr double low = static_cast<double>(std::numeric_limits<T>::lowest()),
                   high = static_cast<double>(std::numeric_limits<T>::max());
  if (!(x > low)) return std::isnan(x) ? T{0} : std::numeric_limits<T>::lowest();
  return x >= high ? std::numeric_limits<T>::max() : static_cast<T>(x);
}

template <class T>
std::vector<T> as_type(const std::vector<double>& values) {
  std::vector<T> out(values.size());
  std::transform(values.begin(), values.end(), out.begin(), nearest<T>);
  return out;
}

Attribute whole(std::string name, const std::vector<Index>& values) {
  return {std::move(name), NumberType::int32, 1, {values.begin(), values.end()}};
}

// All that goes with the tets, the points, and the file.
std::vector<Attribute> cell_data(const TetView& m) {
  std::vector<Attribute> out;
  if (!m.attributes.regions.of.empty()) out.push_back(whole("region", m.attributes.regions.of));
  if (!m.attributes.layers.empty()) out.push_back(whole("layers", m.attributes.layers));
  return out;
}

std::vector<Attribute> point_data(const TetView& m, std::int64_t points) {
  std::vector<Attribute> out;
  if (!m.attributes.input_vertex.empty()) out.push_back(whole("input_vertex", m.attributes.input_vertex));
  for (const Attribute& a : m.attributes.vertex_data) out.push_back(a);
  for (Attribute& a : out) {  // those in the middle of edges have no values
    const bool real = a.type == NumberType::float32 || a.type == NumberType::float64;
    a.values.resize(static_cast<std::size_t>(points * a.width), real
                                                                    ? std::numeric_limits<double>::quiet_NaN()
                                                                : a.name == "input_vertex" ? -1.0
                                                                                           : 0.0);
  }
  return out;
}

void add_names(std::vector<Attribute>& out, const char* name, const Labels& labels) {
  const std::string text = text_of_names(labels.names);
  if (text.empty()) return;
  Attribute a{name, NumberType::uint8, 1, {}};
  for (const char c : text) a.values.push_back(static_cast<unsigned char>(c));
  out.push_back(std::move(a));
}

std::vector<Attribute> triangle_data(const TetView& m) {
  std::vector<Attribute> out = {whole("label", m.attributes.labels.of)};
  if (!m.attributes.input_face.empty()) out.push_back(whole("input_face", m.attributes.input_face));
  out.insert(out.end(), m.attributes.triangle_data.begin(), m.attributes.triangle_data.end());
  return out;
}

std::vector<Attribute> field_data(const TetView& m) {
  std::vector<Attribute> out;
  if (m.triangles() == 0) return out;
  const TriangleMatrix& F = m.attributes.triangles;
  out.push_back({"boundary_triangles", NumberType::int32, 3, {F.data(), F.data() + F.size()}});
  for (Attribute& a : triangle_data(m)) {
    a.name = "boundary_" + a.name;
    out.push_back(std::move(a));
  }
  add_names(out, "label_names", m.attributes.labels);
  add_names(out, "region_names", m.attributes.regions);
  return out;
}

// One array, or a list of them, in XML.
template <class T>
void binary(TextWriter& out, const std::vector<T>& values) {
  base64(out, values.data(), sizeof(T) * values.size());
}

void xml_array(TextWriter& out, const Attribute& a, bool field) {
  out.text("<DataArray type=\"").text(xml_name(a.type)).text("\" Name=\"");
  out.text(escaped(a.name)).text("\" NumberOfComponents=\"").number(std::int64_t{a.width});
  if (field) out.text("\" NumberOfTuples=\"").number(static_cast<std::int64_t>(a.values.size()) / a.width);
  out.text("\" format=\"binary\">\n");
  switch (a.type) {
    case NumberType::uint8:
      binary(out, as_type<std::uint8_t>(a.values));
      break;
    case NumberType::int32:
      binary(out, as_type<std::int32_t>(a.values));
      break;
    case NumberType::int64:
      binary(out, as_type<std::int64_t>(a.values));
      break;
    case NumberType::float32:
      binary(out, as_type<float>(a.values));
      break;
    case NumberType::float64:
      binary(out, a.values);
      break;
  }
  out.text("</DataArray>\n");
}

void xml_arrays(TextWriter& out, const char* section, const std::vector<Attribute>& list) {
  if (list.empty()) return;
  out.text("<").text(section).text(">\n");
  for (const Attribute& a : list) xml_array(out, a, std::string_view(section) == "FieldData");
  out.text("</").text(section).text(">\n");
}

void xml_begin(TextWriter& out, const char* type) {
  out.text("<?xml version=\"1.0\"?>\n<VTKFile type=\"").text(type);
  out.text("\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<")
      .text(type)
      .text(">\n");
}

void xml_points(TextWriter& out, const TetView& m, std::int64_t count) {
  out.text("<Points>\n<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"binary\">\n");
  std::vector<double> xyz(static_cast<std::size_t>(3 * count));
  for (std::int64_t v = 0; v < count; ++v)
    for (int k = 0; k < 3; ++k) xyz[static_cast<std::size_t>(3 * v + k)] = m.coordinate(v, k);
  binary(out, xyz);
  out.text("</DataArray>\n</Points>\n");
}

void xml_cells(TextWriter& out, const std::vector<Index>& connectivity, std::int64_t each) {
  out.text("<DataArray type=\"Int32\" Name=\"connectivity\" format=\"binary\">\n");
  binary(out, connectivity);
  out.text("</DataArray>\n<DataArray type=\"Int64\" Name=\"offsets\" format=\"binary\">\n");
  std::vector<std::int64_t> offsets(connectivity.size() / static_cast<std::size_t>(each));
  for (std::size_t c = 0; c < offsets.size(); ++c) offsets[c] = each * static_cast<std::int64_t>(c + 1);
  binary(out, offsets);
  out.text("</DataArray>\n");
}

int corners_each(const TetView& m) { return m.second_order() ? 10 : 4; }
int cell_type(const TetView& m) { return m.second_order() ? 24 : 10; }  // VTK_QUADRATIC_TETRA, VTK_TETRA

void legacy_number(TextBuffer& line, const Attribute& a, std::size_t i) {
  // Streams of C++, by which VTK reads, know no NaN.
  const double x = std::isnan(a.values[i]) ? 0 : a.values[i];
  if (a.type == NumberType::float64)
    line.number(x);
  else if (a.type == NumberType::float32)
    line.number(double{static_cast<float>(x)});
  else
    line.number(nearest<std::int64_t>(x));
}

void legacy_field(TextWriter& out, const std::vector<Attribute>& list) {
  out.text("FIELD FieldData ").number(static_cast<std::int64_t>(list.size())).end_line();
  for (const Attribute& a : list) {
    const auto tuples = static_cast<std::int64_t>(a.values.size()) / a.width;
    out.text(one_word(a.name)).character(' ').number(std::int64_t{a.width}).character(' ').number(tuples);
    out.character(' ').text(legacy_name(a.type)).end_line();
    out.lines(tuples, [&](TextBuffer& line, std::int64_t t) {
      for (int k = 0; k < a.width; ++k) {
        if (k > 0) line.character(' ');
        legacy_number(line, a, static_cast<std::size_t>(t * a.width + k));
      }
      line.end_line();
    });
  }
}

void triangles_as_vtp(TextWriter& out, const TetView& m, std::int64_t points,
                      const std::vector<Attribute>& cell_data) {
  const TriangleMatrix& F = m.attributes.triangles;
  std::vector<Attribute> names;
  add_names(names, "label_names", m.attributes.labels);
  xml_begin(out, "PolyData");
  xml_arrays(out, "FieldData", names);
  out.text("<Piece NumberOfPoints=\"").number(points);
  out.text("\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"");
  out.number(m.triangles()).text("\">\n");
  xml_arrays(out, "PointData", point_data(m, points));
  xml_arrays(out, "CellData", cell_data);
  xml_points(out, m, points);
  out.text("<Polys>\n");
  xml_cells(out, {F.data(), F.data() + F.size()}, 3);
  out.text("</Polys>\n</Piece>\n</PolyData>\n</VTKFile>\n");
}

}  // namespace

void write_vtu(TextWriter& out, const TetView& m) {
  xml_begin(out, "UnstructuredGrid");
  xml_arrays(out, "FieldData", field_data(m));
  out.text("<Piece NumberOfPoints=\"").number(m.vertices());
  out.text("\" NumberOfCells=\"").number(m.tets()).text("\">\n");
  xml_arrays(out, "PointData", point_data(m, m.vertices()));
  xml_arrays(out, "CellData", cell_data(m));
  xml_points(out, m, m.vertices());
  out.text("<Cells>\n");
  const int each = corners_each(m);
  std::vector<Index> corners(static_cast<std::size_t>(each * m.tets()));
  for (std::int64_t t = 0; t < m.tets(); ++t)
    for (int k = 0; k < each; ++k) corners[static_cast<std::size_t>(t * each + k)] = m.tet(t, k);
  xml_cells(out, corners, each);
  out.text("<DataArray type=\"UInt8\" Name=\"types\" format=\"binary\">\n");
  binary(out, std::vector<std::uint8_t>(static_cast<std::size_t>(m.tets()),
                                        static_cast<std::uint8_t>(cell_type(m))));
  out.text("</DataArray>\n</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
}

// The triangles with the vertices that they have: in our results those come first.
void write_boundary_vtp(TextWriter& out, const TetView& m) {
  const TriangleMatrix& F = m.attributes.triangles;
  triangles_as_vtp(out, m, F.rows() == 0 ? 0 : std::int64_t{F.maxCoeff()} + 1, triangle_data(m));
}

void write_surface_vtp(TextWriter& out, const TetView& m) {
  triangles_as_vtp(out, m, m.vertices(),
                   m.attributes.labels.of.empty() ? std::vector<Attribute>{} : triangle_data(m));
}

void write_vtk(TextWriter& out, const TetView& m) {
  out.text("# vtk DataFile Version 3.0\nTet mesh by Overtet\nASCII\nDATASET UNSTRUCTURED_GRID\n");
  out.text("POINTS ").number(m.vertices()).text(" double\n");
  out.lines(m.vertices(), [&](TextBuffer& line, std::int64_t v) { m.coordinates(line, v).end_line(); });
  const std::int64_t each = corners_each(m);
  out.text("CELLS ").number(m.tets()).character(' ').number((each + 1) * m.tets()).end_line();
  out.lines(m.tets(), [&](TextBuffer& line, std::int64_t t) {
    m.tet(line.number(each).character(' '), t, 0).end_line();
  });
  out.text("CELL_TYPES ").number(m.tets()).end_line();
  out.lines(m.tets(),
            [&](TextBuffer& line, std::int64_t) { line.number(std::int64_t{cell_type(m)}).end_line(); });
  // Not before the points: Gmsh would take the file for an error, and meshio would overlook it.
  if (const std::vector<Attribute> fields = field_data(m); !fields.empty()) legacy_field(out, fields);
  if (const std::vector<Attribute> cells = cell_data(m); !cells.empty()) {
    out.text("CELL_DATA ").number(m.tets()).end_line();
    legacy_field(out, cells);
  }
  if (const std::vector<Attribute> points = point_data(m, m.vertices()); !points.empty()) {
    out.text("POINT_DATA ").number(m.vertices()).end_line();
    legacy_field(out, points);
  }
}

}  // namespace overtet::io_detail
