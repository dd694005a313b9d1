// Files that say more than they have, or that would take the square of their size: what fuzzing with small
// files does not come across. Memory is counted in builds with the address sanitizer.
#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <string_view>

#include "src/io/surface_parts.h"
#include "tests/fuzz/checks.h"
#include "tests/fuzz/targets.h"

namespace overtet::fuzz {
namespace {

std::string repeated(const std::string& text, int times) {
  std::string out;
  for (int i = 0; i < times; ++i) out += text;
  return out;
}

// Reads a surface that takes at most `each` bytes of memory for each byte of the file.
Result<Surface> read_within(const std::string& path, const std::string& bytes, std::size_t each,
                            SurfaceReadInfo& info) {
  const MemoryUse memory;
  Result<Surface> s = io_detail::parse_surface("/no/such/folder/" + path, bytes, info);
  memory.check(bytes.size(), each);
  return s;
}

// Counts that no file has room for, in every format: the checks of the targets hold, memory among them.
TEST(Hostile, AnnouncedCountsTakeNoMemory) {
  for (const char* n : {"2147483647", "1099511627776", "9223372036854775807", "4611686018427387904"}) {
    const std::string many = n;
    off("OFF\n" + many + " " + many + " 0\n0 0 0\n");
    off("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n" + many + " 0 1 2\n");
    obj("v 0 0 0\nvt 0 0\nf " + many + "/1 1/1 1/1\n");
    obj("v 0 0 0\nf -" + many + " 1 1\n");
    for (const char* format : {"ascii", "binary_little_endian"}) {
      ply("ply\nformat " + std::string(format) + " 1.0\nelement vertex " + many +
          "\nproperty char x\nproperty char y\nproperty char z\nelement face " + many +
          "\nproperty list uchar char vertex_indices\nend_header\n0 0 0\n");
      ply("ply\nformat " + std::string(format) +
          " 1.0\nelement vertex 1\nproperty char x\nproperty char y\nproperty char z\nelement face 1\n"
          "property list uint char vertex_indices\nend_header\n0 0 0\n" +
          many + " 0 0 0\n");
    }
    medit("MeshVersionFormatted 2 Dimension 3 Vertices " + many + " 0 0 0 0");
    medit("MeshVersionFormatted 2 Dimension 3 Vertices 1 0 0 0 0 Tetrahedra " + many + " 1 1 1 1 1");
    gmsh("$MeshFormat\n2.2 0 8\n$Nodes\n" + many + "\n1 0 0 0\n");
    gmsh("$MeshFormat\n2.2 0 8\n$Nodes\n1\n1 0 0 0\n$Elements\n1\n1 4 -" + many + " 1 1 1 1\n");
    gmsh("$MeshFormat\n4.1 0 8\n$Nodes\n" + many + " " + many + " 1 1\n2 1 0 " + many + "\n");
    gmsh("$MeshFormat\n4.1 0 8\n$Entities\n0 0 " + many + " " + many + "\n");
    gmsh("$MeshFormat\n2.2 0 8\n$NodeData\n1\n\"layers\"\n0\n3\n0\n" + many + "\n" + many + "\n");
    vtk("# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS " + many + " double\n0 0 0\n");
    vtk("# vtk DataFile Version 3.0\nx\nBINARY\nDATASET POLYDATA\nPOLYGONS " + many + " " + many +
        "\n0 0 0\n");
    vtk("# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nFIELD f " + many + "\na 1000 " + many +
        " int\n");
    vtk_xml("<VTKFile type=\"PolyData\"><Piece NumberOfPoints=\"" + many + "\" NumberOfPolys=\"" + many +
            "\" NumberOfVerts=\"" + many + "\" NumberOfLines=\"" + many + "\"/></VTKFile>");
    tetgen(many + " 3 0 0\n0 0 0 0\n");
    tetgen("1 3 0 0\n" + many + " 0 0 0\n%\n" + many + " 4 0\n0 0 0 0 0\n");
    gltf(
        "{\"asset\":{},\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"accessors\":[{"
        "\"bufferView\":0,"
        "\"componentType\":5126,\"type\":\"VEC3\",\"count\":" +
        many +
        "}],\"bufferViews\":[{\"buffer\":0}],\"buffers\":"
        "[{\"uri\":\"data:,AAAA\"}]}");
  }
}

// A compressed array says in 64 bits how large it is.
TEST(Hostile, SizesOfArraysTakeNoMemory) {
  for (const char* attribute : {"", " compressor=\"vtkZLibDataCompressor\""}) {
    std::string file = "<VTKFile type=\"PolyData\" header_type=\"UInt64\"" + std::string(attribute) +
                       "><Piece NumberOfPoints=\"1\" NumberOfPolys=\"1\"><Points><DataArray type=\"Float64\" "
                       "format=\"appended\" offset=\"0\"/></Points></Piece><AppendedData encoding=\"raw\">_";
    for (const std::uint64_t n :
         {std::uint64_t{1}, ~std::uint64_t{0} - 7, std::uint64_t{1} << 40, ~std::uint64_t{0}}) {
      char bytes[8];
      std::memcpy(bytes, &n, sizeof bytes);
      file.append(bytes, sizeof bytes);
      vtk_xml(file + std::string(64, 'x'));
    }
  }
}

// Two blocks whose sizes add up to little only because they wrap.
TEST(Hostile, SizesOfBlocksDoNotWrap) {
  std::string file =
      "<VTKFile type=\"PolyData\" header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\"><Piece "
      "NumberOfPoints=\"1\" "
      "NumberOfPolys=\"1\"><Points><DataArray type=\"Float64\" format=\"appended\" "
      "offset=\"0\"/></Points></Piece>"
      "<AppendedData encoding=\"raw\">_";
  const std::string zlib("\x78\x9c\x4b\x04\x00\x00\x62\x00\x62", 9);  // "a"
  for (const std::uint64_t n :
       {std::uint64_t{2}, std::uint64_t{1}, std::uint64_t{1}, std::uint64_t{10}, ~std::uint64_t{0}}) {
    char bytes[8];
    std::memcpy(bytes, &n, sizeof bytes);
    file.append(bytes, sizeof bytes);
  }
  vtk_xml(file + zlib + zlib);
}

// Cell data counts the lines, too: as many as make the sum wrap.
TEST(Hostile, CountsOfCellsDoNotWrap) {
  vtk_xml(
      "<VTKFile type=\"PolyData\"><Piece NumberOfPoints=\"3\" NumberOfLines=\"4611686018427387900\" "
      "NumberOfPolys=\"5\"><CellData>"
      "<DataArray type=\"Int32\" Name=\"a\" NumberOfComponents=\"4\">1 2 3 "
      "4</DataArray></CellData><Points><DataArray "
      "type=\"Int32\">0 0 0 1 0 0 0 1 0</DataArray></Points><Polys><DataArray type=\"Int32\" "
      "Name=\"connectivity\">0 1 2 0 1 2 0 1 "
      "2 0 1 2 0 1 2</DataArray><DataArray type=\"Int32\" Name=\"offsets\">3 6 9 12 "
      "15</DataArray></Polys></Piece></VTKFile>");
}

// A long name holds for what follows, whatever else changes.
TEST(Hostile, LongNamesAreNotCopied) {
  SurfaceReadInfo info;
  std::string file = "v 0 0 0\nv 1 0 0\nv 0 1 0\ng " + std::string(100000, 'n') + "\n";
  for (int i = 0; i < 2000; ++i) file += "usemtl m" + std::to_string(i) + "\nf 1 2 3\n";
  const Result<Surface> s = read_within("x.obj", file, 64, info);
  ASSERT_TRUE(s.ok()) << s.error().message;
  EXPECT_EQ(info.attributes.faces.names.size(), 2000u);
  for (const auto& [label, name] : info.attributes.faces.names) EXPECT_LE(name.size(), 2010u);
}

// What a polygon has, each of its triangles gets: not where that is the square of the file.
TEST(Hostile, WideDataOfLargeFaces) {
  constexpr int corners = 3000, properties = 1000;
  std::string file =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty char x\nproperty char y\nproperty char z\nelement "
      "face 1\n"
      "property list uint uint vertex_indices\n";
  for (int i = 0; i < properties; ++i) file += "property char p" + std::to_string(i) + "\n";
  file += "end_header\n0 0 0\n1 0 0\n0 1 0\n" + std::to_string(corners) + repeated(" 0 1 2", corners / 3) +
          repeated(" 1", properties) + "\n";
  SurfaceReadInfo info;
  const Result<Surface> s = read_within("x.ply", file, 200, info);
  ASSERT_TRUE(s.ok()) << s.error().message;
  EXPECT_EQ(s.value().F.rows(), corners - 2);
  EXPECT_TRUE(info.attributes.face_data.empty());
}

// Arrays that all are the same bytes.
TEST(Hostile, ArraysInEachOther) {
  constexpr int arrays = 500, values = 4000;
  std::string file = "<VTKFile type=\"PolyData\"><Piece NumberOfPoints=\"" + std::to_string(values) +
                     "\" NumberOfPolys=\"0\"><PointData>";
  for (int i = 0; i < arrays; ++i)
    file += "<DataArray type=\"Int8\" Name=\"a" + std::to_string(i) + "\" format=\"appended\" offset=\"0\"/>";
  file += "</PointData></Piece><AppendedData encoding=\"raw\">_" + std::string("\xa0\x0f\0\0", 4) +
          std::string(values, 'x') + "</AppendedData></VTKFile>";
  SurfaceReadInfo info;
  const Result<Surface> s = read_within("x.vtp", file, 64, info);
  ASSERT_FALSE(s.ok());
  EXPECT_NE(s.error().message.find("lie in each other"), std::string::npos) << s.error().message;
}

// A tree of nodes as deep as there are nodes, and a list in a list in a list.
TEST(Hostile, DeepTrees) {
  constexpr int depth = 100000;
  std::string file = "{\"asset\":{},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[";
  for (int i = 1; i < depth; ++i) file += "{\"children\":[" + std::to_string(i) + "]},";
  file += "{}]}";
  SurfaceReadInfo info;
  EXPECT_FALSE(read_within("x.gltf", file, 2000, info).ok());
  const std::string lists = repeated("[", depth) + repeated("]", depth);
  for (const std::string key : {"scenes", "nodes", "meshes", "extensionsRequired"})
    EXPECT_FALSE(read_within("x.gltf", "{\"asset\":{},\"" + key + "\":" + lists + "}", 2000, info).ok());
  EXPECT_FALSE(
      read_within("x.gltf",
                  "{\"asset\":{},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"children\":" + lists + "}]}",
                  2000, info)
          .ok());
}

}  // namespace
}  // namespace overtet::fuzz
