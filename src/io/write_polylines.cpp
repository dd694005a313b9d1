#include <string_view>

#include "src/io/filled_file.h"
#include "src/io/names.h"
#include "src/io/polylines_io.h"

namespace overtet {

namespace {

void write_field(TextWriter& out, const Polylines::Field& field) {
  out.text("<DataArray type=\"").text(field.whole ? "Int32" : "Float64").text("\" Name=\"").text(field.name);
  out.text("\" NumberOfComponents=\"").number(std::int64_t{field.components}).text("\" format=\"ascii\">\n");
  for (std::size_t i = 0; i < field.values.size(); ++i) {
    if (field.whole)
      out.number(static_cast<std::int64_t>(field.values[i]));
    else
      out.number(field.values[i]);
    if ((i + 1) % static_cast<std::size_t>(field.components) == 0)
      out.end_line();
    else
      out.character(' ');
  }
  out.text("</DataArray>\n");
}

void write_vtp(TextWriter& out, const Polylines& p) {
  std::int64_t segments = 0;
  for (const auto& line : p.lines) segments += static_cast<std::int64_t>(line.points.size()) - 1;
  out.text(
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
      "<PolyData>\n<Piece NumberOfPoints=\"");
  out.number(static_cast<std::int64_t>(p.points.size())).text("\" NumberOfVerts=\"0\" NumberOfLines=\"");
  out.number(segments).text("\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n<PointData>\n");
  for (const auto& field : p.point_data) write_field(out, field);
  out.text("</PointData>\n<CellData>\n");
  for (const auto& field : p.segment_data) write_field(out, field);
  out.text(
      "</CellData>\n<Points>\n<DataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\" "
      "format=\"ascii\">\n");
  for (const auto& x : p.points)
    out.number(x[0]).character(' ').number(x[1]).character(' ').number(x[2]).end_line();
  out.text(
      "</DataArray>\n</Points>\n<Lines>\n<DataArray type=\"Int64\" Name=\"connectivity\" "
      "format=\"ascii\">\n");
  for (const auto& line : p.lines)
    for (std::size_t i = 0; i + 1 < line.points.size(); ++i)
      out.number(std::int64_t{line.points[i]})
          .character(' ')
          .number(std::int64_t{line.points[i + 1]})
          .end_line();
  out.text("</DataArray>\n<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">\n");
  for (std::int64_t i = 1; i <= segments; ++i) out.number(2 * i).end_line();
  out.text("</DataArray>\n</Lines>\n</Piece>\n</PolyData>\n</VTKFile>\n");
}

void write_obj_lines(TextWriter& out, const Polylines& p) {
  for (const auto& x : p.points)
    out.text("v ").number(x[0]).character(' ').number(x[1]).character(' ').number(x[2]).end_line();
  for (const auto& line : p.lines) {
    out.text("o ").text(line.name).end_line().character('l');
    for (const Index i : line.points) out.character(' ').number(std::int64_t{i} + 1);
    out.end_line();
  }
}

}  // namespace

Result<CurveFormat> curve_format_of(const std::string& path) {
  const std::string extension = io_detail::parts_of_name(path).extension;
  if (extension == "vtp") return CurveFormat::vtp;
  if (extension == "obj") return CurveFormat::obj;
  return Error{ErrorCode::usage, "Curves are written as .vtp or .obj; " + path + " is neither."};
}

Status write_polylines(const std::string& path, const Polylines& polylines, CurveFormat format,
                       const RunContext& context) {
  return io_detail::write_file(path, context, [&](TextWriter& out) {
    if (format == CurveFormat::vtp)
      write_vtp(out, polylines);
    else
      write_obj_lines(out, polylines);
  });
}

}  // namespace overtet
