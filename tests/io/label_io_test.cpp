// Labels and all that goes with them: from surfaces of every format, into tet meshes of every format and
// back, also through other programs.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <random>
#include <sstream>

#include "overtet/io.h"
#include "tests/support/files.h"
#include "tests/support/models.h"

namespace overtet {
namespace {

using test::TemporaryFolder;
using Names = std::map<Index, std::string>;
using List = std::vector<Index>;

// A tetrahedron with its four faces, in the words of each format.
const std::string kObj =
    "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nv 0 0 1 .5 .5 .5\nvt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\n"
    "o body\nusemtl skin\nf 1/1 3/3 2/2\nf 1/1 2/2 4/4\nusemtl eye\nf 2/2 3/3 4/4\no head\nf 3/3 1/1 4/4\n";

struct Read {
  Surface surface;
  SurfaceReadInfo info;
};
Read read(const TemporaryFolder& folder, const std::string& name, const std::string& text) {
  test::write_text(folder.file(name), text);
  Read r;
  const Result<Surface> s = read_surface(folder.file(name), &r.info);
  EXPECT_TRUE(s.ok()) << s.error().message;
  if (s.ok()) r.surface = s.value();
  return r;
}

TEST(Labels, OfObjAreObjectsGroupsAndMaterials) {
  const TemporaryFolder folder;
  const Read r = read(folder, "a.obj", kObj);
  const SurfaceAttributes& a = r.info.attributes;
  EXPECT_EQ(a.faces.of, (List{1, 1, 2, 3}));
  EXPECT_EQ(a.faces.names, (Names{{1, "body:skin"}, {2, "body:eye"}, {3, "head:eye"}}));
  EXPECT_EQ(a.solids.of, (List{1, 1, 1, 2}));
  EXPECT_EQ(a.solids.names, (Names{{1, "body"}, {2, "head"}}));
  ASSERT_EQ(a.vertex_data.size(), 2u);
  EXPECT_EQ(a.vertex_data[0].name, "colour");
  EXPECT_EQ(a.vertex_data[0].values[9], .5);
  EXPECT_EQ(a.vertex_data[1].name, "uv");
  EXPECT_EQ(a.vertex_data[1].values, (std::vector<double>{0, 0, 1, 0, 0, 1, 1, 1}));
}

TEST(Labels, OfAPolygonGoToItsTriangles) {
  const TemporaryFolder folder;
  const Read r = read(folder, "a.obj",
                      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv .5 .5 1\ng base\nf 4 3 2 1\ng side\nf 1 2 5\n"
                      "f 2 3 5\nf 3 4 5\nf 4 1 5\n");
  EXPECT_EQ(r.info.attributes.faces.of, (List{1, 1, 2, 2, 2, 2}));
}

TEST(Labels, TextureSeamsAreSaidAndNotCarried) {
  const TemporaryFolder folder;
  std::string text = kObj;
  text.replace(text.find("f 3/3"), 5, "f 3/1");
  const Read r = read(folder, "a.obj", text);
  EXPECT_EQ(r.info.attributes.vertex_data.size(), 1u);
  ASSERT_EQ(r.info.notes.size(), 1u);
  EXPECT_NE(r.info.notes[0].find("texture"), std::string::npos);
}

TEST(Labels, OfStlAreItsSolids) {
  const TemporaryFolder folder;
  std::string text;
  for (const char* name : {"left part", "right"}) {
    text += std::string("solid ") + name + "\n";
    const std::string x = name[0] == 'l' ? "0" : "5", y = name[0] == 'l' ? "1" : "6";
    const std::string p[4] = {x + " 0 0", y + " 0 0", x + " 1 0", x + " 0 1"};
    for (const auto& f : {std::array{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}) {
      text += "facet normal 0 0 0\nouter loop\n";
      for (const int v : f) text += "vertex " + p[v] + "\n";
      text += "endloop\nendfacet\n";
    }
    text += "endsolid\n";
  }
  const Read r = read(folder, "a.stl", text);
  EXPECT_EQ(r.info.attributes.faces.of, (List{1, 1, 1, 1, 2, 2, 2, 2}));
  EXPECT_EQ(r.info.attributes.solids.names, (Names{{1, "left part"}, {2, "right"}}));
}

TEST(Labels, OfPlyAreItsPropertiesOrColours) {
  const TemporaryFolder folder;
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty float quality\nelement face 4\nproperty list uchar int vertex_indices\n";
  const std::string vertices = "0 0 0 255 .5\n1 0 0 3 1\n0 1 0 4 2\n0 0 1 7 nan\n";
  const Read r = read(folder, "a.ply",
                      head + "property int label\nproperty uchar red\nend_header\n" +
                          vertices.substr(0, vertices.size() - 4) +
                          "3\n3 0 2 1 -7 9\n3 0 1 3 -7 9\n3 1 2 3 12 8\n3 2 0 3 12 8\n");
  const SurfaceAttributes& a = r.info.attributes;
  EXPECT_EQ(a.faces.of, (List{-7, -7, 12, 12}));
  ASSERT_EQ(a.vertex_data.size(), 2u);
  EXPECT_EQ(a.vertex_data[0].name, "red");
  EXPECT_EQ(a.vertex_data[0].type, NumberType::uint8);
  EXPECT_EQ(a.vertex_data[0].values, (std::vector<double>{255, 3, 4, 7}));
  EXPECT_EQ(a.vertex_data[1].values, (std::vector<double>{.5, 1, 2, 3}));
  ASSERT_EQ(a.face_data.size(), 2u);
  EXPECT_EQ(a.face_data[1].values, (std::vector<double>{9, 9, 8, 8}));
}

TEST(Labels, OfOffAreItsColours) {
  const TemporaryFolder folder;
  const Read r = read(folder, "a.off",
                      "COFF\n4 4 0\n0 0 0 1 0 0 1\n1 0 0 0 1 0 1\n0 1 0 0 0 1 1\n0 0 1 1 1 1 1\n"
                      "3 0 2 1 255 0 0\n3 0 1 3 0 0 255\n3 1 2 3 255 0 0\n3 2 0 3 255 0 0\n");
  const SurfaceAttributes& a = r.info.attributes;
  EXPECT_EQ(a.faces.of, (List{1, 2, 1, 1}));
  EXPECT_EQ(a.faces.names.at(2), "colour 0 0 255");
  ASSERT_EQ(a.vertex_data.size(), 1u);
  EXPECT_EQ(a.vertex_data[0].width, 4);
}

TEST(Labels, OfOffMayBeNumbersOfColours) {
  const TemporaryFolder folder;
  const Read r = read(folder, "a.off",
                      "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1 4\n3 0 1 3 4\n3 1 2 3 0\n3 2 0 3 4\n");
  EXPECT_EQ(r.info.attributes.faces.of, (List{4, 4, 0, 4}));
}

// What a mesh of two overlapping solids would have: labels, also a negative one, names, regions, layers,
// data.
LabelledTetMesh sample() {
  LabelledTetMesh out;
  TetMesh& m = out.mesh;
  m.V.resize(9, 3);
  m.V << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 5, 0, 0, 6, 0, 0, 5, 1. / 3, 0, 5, 0, -1e-7 / 3, 0.1, 0.2, 0.3;
  m.T.resize(5, 4);
  m.T << 8, 1, 2, 3, 0, 8, 2, 3, 0, 1, 8, 3, 0, 1, 2, 8, 4, 6, 5, 7;
  MeshAttributes& a = out.attributes;
  a.triangles.resize(8, 3);
  a.triangles << 0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3, 6, 4, 5, 5, 4, 7, 6, 5, 7, 4, 6, 7;
  a.labels = {{3, 7, 3, -2, 7, 7, 9, 7}, {{3, "inlet"}, {7, "wall, outer"}}};
  a.input_face = {0, 1, 2, 3, 4, 5, 6, 7};
  a.regions = {{1, 1, 1, 1, 4}, {{1, "left"}, {4, "right part"}}};
  a.layers = {1, 1, 2, 1, 1};
  a.input_vertex = {0, 1, 2, 3, 4, 5, 6, 7, -1};
  a.vertex_data = {{"heat", NumberType::float64, 1, {.1, .2, .3, 1. / 3, 5, 6, 7, 8, 0}},
                   {"colour", NumberType::uint8, 3, std::vector<double>(27, 200)}};
  a.triangle_data = {{"patch", NumberType::int32, 1, {1, 2, 3, 4, 5, 6, 7, 8}}};
  return out;
}

std::vector<std::array<Index, 4>> sorted_triangles(const MeshAttributes& a) {
  std::vector<std::array<Index, 4>> out;
  for (Eigen::Index f = 0; f < a.triangles.rows(); ++f) {
    std::array<Index, 3> t = {a.triangles(f, 0), a.triangles(f, 1), a.triangles(f, 2)};
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    out.push_back({t[0], t[1], t[2], a.labels.of[static_cast<std::size_t>(f)]});
  }
  std::sort(out.begin(), out.end());
  return out;
}

void expect_same_mesh(const LabelledTetMesh& a, const LabelledTetMesh& b) {
  ASSERT_EQ(a.mesh.V.rows(), b.mesh.V.rows());
  EXPECT_EQ(std::memcmp(a.mesh.V.data(), b.mesh.V.data(),
                        sizeof(double) * static_cast<std::size_t>(a.mesh.V.size())),
            0);
  EXPECT_EQ(a.mesh.T, b.mesh.T);
  EXPECT_EQ(a.attributes.regions.of, b.attributes.regions.of);
}

struct Place {
  const char* name;
  TetFormat format;
  bool names, arrays, corners;  // what there is a place for
};
const Place kPlaces[] = {
    {"a.mesh", TetFormat::medit, false, false, true},  {"b.msh", TetFormat::gmsh22, true, false, true},
    {"c.msh", TetFormat::gmsh41, true, false, true},   {"d.vtu", TetFormat::vtu, true, true, true},
    {"e.node", TetFormat::tetgen, false, false, true}, {"f.inp", TetFormat::abaqus, true, false, false},
    {"g.vtk", TetFormat::vtk, true, true, true}};

TEST(Labels, SurviveEveryFormatOfEitherOrderCompressedOrNot) {
  const TemporaryFolder folder;
  const LabelledTetMesh m = sample();
  for (const Place& c : kPlaces)
    for (const int order : {1, 2})
      for (const char* gz : {"", ".gz"}) {
        SCOPED_TRACE(std::string(c.name) + gz + " of order " + std::to_string(order));
        const std::string path = folder.file(c.name + std::string(gz));
        ASSERT_TRUE(write_tets(path, m.mesh, m.attributes, {c.format, order}).ok());
        if (*gz) {
          EXPECT_EQ(test::read_text(path).substr(0, 2), "\x1f\x8b");
        }
        const Result<LabelledTetMesh> r = read_labelled_tets(path);
        ASSERT_TRUE(r.ok()) << r.error().message;
        expect_same_mesh(m, r.value());
        const MeshAttributes& a = r.value().attributes;
        EXPECT_EQ(a.labels.of, m.attributes.labels.of);
        EXPECT_EQ(sorted_triangles(a), sorted_triangles(m.attributes));
        if (c.corners) {
          EXPECT_EQ(a.triangles, m.attributes.triangles);
        }
        EXPECT_EQ(a.input_face, m.attributes.input_face);
        EXPECT_EQ(a.input_vertex, m.attributes.input_vertex);
        if (c.names) {
          EXPECT_EQ(a.labels.names, m.attributes.labels.names);
          EXPECT_EQ(a.regions.names, m.attributes.regions.names);
        }
        if (keeps_layers(c.format)) {
          EXPECT_EQ(a.layers, m.attributes.layers);
        }
        if (!c.arrays) continue;
        ASSERT_EQ(a.vertex_data.size(), 2u);
        EXPECT_EQ(a.vertex_data[0].values, m.attributes.vertex_data[0].values);
        EXPECT_EQ(a.vertex_data[1].type, NumberType::uint8);
        EXPECT_EQ(a.vertex_data[1].values, m.attributes.vertex_data[1].values);
        ASSERT_EQ(a.triangle_data.size(), 1u);
        EXPECT_EQ(a.triangle_data[0].values, m.attributes.triangle_data[0].values);
      }
}

TEST(Labels, InputNumbersThatAreNotTheOwnSurviveWhereThereIsAPlace) {
  const TemporaryFolder folder;
  LabelledTetMesh m = sample();
  m.attributes.input_face = {0, 1, 2, 5, 6, 7, 8, 9};
  m.attributes.input_vertex = {0, 2, 3, 4, 5, 6, 7, 8, -1};
  for (const Place& c : kPlaces) {
    if (c.format == TetFormat::medit || c.format == TetFormat::tetgen || c.format == TetFormat::abaqus)
      continue;
    SCOPED_TRACE(c.name);
    ASSERT_TRUE(write_tets(folder.file(c.name), m.mesh, m.attributes, {c.format, 1}).ok());
    const Result<LabelledTetMesh> r = read_labelled_tets(folder.file(c.name));
    ASSERT_TRUE(r.ok());
    if (c.format != TetFormat::gmsh22) {
      EXPECT_EQ(r.value().attributes.input_face, m.attributes.input_face);
    }
    EXPECT_EQ(r.value().attributes.input_vertex, m.attributes.input_vertex);
  }
}

// CalculiX reads twenty characters of a number.
TEST(Labels, AbaqusNumbersAreShortAndExactOnesStandInComments) {
  const TemporaryFolder folder;
  const LabelledTetMesh m = sample();
  ASSERT_TRUE(write_tets(folder.file("a.inp"), m.mesh, m.attributes, {TetFormat::abaqus, 1}).ok());
  std::istringstream in(test::read_text(folder.file("a.inp")));
  int exact = 0;
  for (std::string line; std::getline(in, line);) {
    exact += line.starts_with("** exact");
    if (line.starts_with("*")) continue;
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) EXPECT_LE(field.size(), 21u) << line;
  }
  EXPECT_EQ(exact, 1);
}

TEST(Labels, WritersOfSeveralFilesNameThem) {
  EXPECT_EQ(tet_files("x/a.vtu.gz", TetFormat::vtu),
            (std::vector<std::string>{"x/a.vtu.gz", "x/a_boundary.vtp.gz"}));
  EXPECT_EQ(tet_files("x/a.b.ele", TetFormat::tetgen),
            (std::vector<std::string>{"x/a.b.node", "x/a.b.ele", "x/a.b.face"}));
  EXPECT_EQ(tet_files("-", TetFormat::vtu), std::vector<std::string>{"-"});
  EXPECT_EQ(write_tets("-", sample().mesh, {}, {TetFormat::tetgen, 1}).error().code, ErrorCode::usage);
  EXPECT_EQ(write_tets("a.mesh", sample().mesh, {}, {TetFormat::medit, 3}).error().code, ErrorCode::usage);
}

// The same surface in every format that has polygons: read to the bit, with labels.
TEST(Labels, SurfacesAreReadFromFilesOfMeshes) {
  const TemporaryFolder folder;
  const LabelledTetMesh m = sample();
  for (const Place& c : kPlaces) {
    if (c.format == TetFormat::tetgen || c.format == TetFormat::abaqus || c.arrays) continue;
    SCOPED_TRACE(c.name);
    ASSERT_TRUE(write_tets(folder.file(c.name), m.mesh, m.attributes, {c.format, 2}).ok());
    SurfaceReadInfo info;
    const Result<Surface> s = read_surface(folder.file(c.name), &info);
    ASSERT_TRUE(s.ok()) << s.error().message;
    EXPECT_EQ(s.value().V, m.mesh.V.topRows(8));
    EXPECT_EQ(s.value().F, m.attributes.triangles);
    EXPECT_EQ(info.attributes.faces.of, m.attributes.labels.of);
    EXPECT_EQ(info.notes.size(), 1u);  // what no face has was left out
  }
  ASSERT_TRUE(write_tets(folder.file("d.vtu"), m.mesh, m.attributes, {TetFormat::vtu, 1}).ok());
  SurfaceReadInfo info;
  const Result<Surface> s = read_surface(folder.file("d_boundary.vtp"), &info);
  ASSERT_TRUE(s.ok()) << s.error().message;
  EXPECT_EQ(s.value().V, m.mesh.V.topRows(8));
  EXPECT_EQ(s.value().F, m.attributes.triangles);
  EXPECT_EQ(info.attributes.faces.of, m.attributes.labels.of);
  EXPECT_EQ(info.attributes.faces.names, m.attributes.labels.names);
  EXPECT_EQ(info.format, "VTP");
}

TEST(Labels, LegacyVtkSurfacesAreRead) {
  const TemporaryFolder folder;
  const Read r =
      read(folder, "a.vtk",
           "# vtk DataFile Version 3.0\nby hand\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n0 0 0 1 0 0\n0 1 0 "
           "0 0 1\n"
           "VERTICES 1 2\n1 0\nPOLYGONS 4 16\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\nCELL_DATA 5\n"
           "SCALARS label int 1\nLOOKUP_TABLE default\n0 1 1 2 2\nPOINT_DATA 4\nSCALARS heat double\n"
           "LOOKUP_TABLE default\n1 2 3 4\nVECTORS v float\n0 0 0 0 0 0 0 0 0 0 0 0\n");
  EXPECT_EQ(r.surface.F.rows(), 4);
  EXPECT_EQ(r.info.attributes.faces.of, (List{1, 1, 2, 2}));
  ASSERT_EQ(r.info.attributes.vertex_data.size(), 2u);
  EXPECT_EQ(r.info.attributes.vertex_data[0].values[3], 4);
}

// The attributes with the vertices numbered as in `mesh`: Gmsh writes them in another order.
MeshAttributes in_places_of(const TetMesh& mesh, const LabelledTetMesh& other) {
  MeshAttributes a = other.attributes;
  for (Eigen::Index i = 0; i < a.triangles.size(); ++i) {
    Index& v = a.triangles.data()[i];
    for (Index w = 0; w < mesh.V.rows(); ++w)
      if (mesh.V.row(w) == other.mesh.V.row(v)) {
        v = w;
        break;
      }
  }
  return a;
}

// A binary glTF file of a JSON text and a buffer.
std::string glb(std::string json, std::string buffer) {
  const auto word = [](std::size_t x) {
    std::string s;
    for (int k = 0; k < 4; ++k) s += static_cast<char>(x >> (8 * k) & 255);
    return s;
  };
  json.resize((json.size() + 3) / 4 * 4, ' ');
  buffer.resize((buffer.size() + 3) / 4 * 4, '\0');
  return "glTF" + word(2) + word(28 + json.size() + buffer.size()) + word(json.size()) + "JSON" + json +
         word(buffer.size()) + std::string("BIN\0", 4) + buffer;
}

template <class T>
std::string bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), sizeof(T) * values.size()};
}

// Two primitives that share their vertices, moved and mirrored by a node.
TEST(Labels, OfGltfAreItsNodesAndMaterials) {
  const TemporaryFolder folder;
  const std::vector<float> xyz = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0.1f};
  const std::vector<std::uint16_t> corners = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
  const std::vector<float> uv = {0, 0, 1, 0, 0, 1, 1, 1};
  const std::string json =
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
      "nodes":[{"name":"body","children":[1],"translation":[10,0,0]},{"name":"arm","mesh":0,"scale":[-2,1,1]}],
      "meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"indices":2,"material":0},
      {"attributes":{"POSITION":0,"TEXCOORD_0":1},"indices":3,"material":1}]}],
      "materials":[{"name":"skin"},{"name":"nail"}],"buffers":[{"byteLength":104}],
      "bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":32},
      {"buffer":0,"byteOffset":80,"byteLength":24}],
      "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},
      {"bufferView":1,"componentType":5126,"count":4,"type":"VEC2"},
      {"bufferView":2,"componentType":5123,"count":9,"type":"SCALAR"},
      {"bufferView":2,"byteOffset":18,"componentType":5123,"count":3,"type":"SCALAR"}]})";
  const std::string buffer = bytes_of(xyz) + bytes_of(uv) + bytes_of(corners);
  const Read r = read(folder, "a.glb", glb(json, buffer));
  ASSERT_EQ(r.surface.V.rows(), 4);
  EXPECT_EQ(r.surface.V(1, 0), 8);
  EXPECT_EQ(r.surface.V(3, 2), double{0.1f});
  EXPECT_EQ(r.surface.F, (TriangleMatrix(4, 3) << 0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0).finished());
  EXPECT_EQ(r.info.attributes.faces.of, (List{1, 1, 1, 2}));
  EXPECT_EQ(r.info.attributes.faces.names, (Names{{1, "arm:skin"}, {2, "arm:nail"}}));
  ASSERT_EQ(r.info.attributes.vertex_data.size(), 1u);
  EXPECT_EQ(r.info.attributes.vertex_data[0].values[7], 1);
  // The same with the buffer in a file beside it.
  std::string beside = json;
  beside.replace(beside.find("{\"byteLength\":104}"), 18, R"({"byteLength":104,"uri":"a.bin"})");
  test::write_text(folder.file("a.bin"), buffer);
  EXPECT_EQ(read(folder, "b.gltf", beside).surface.V, r.surface.V);

  const std::uint64_t seed = 79;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  const std::string good = glb(json, buffer);
  for (int i = 0; i < 500; ++i) {
    std::string bad = good;
    if (i % 2 == 0) bad.resize(random() % bad.size());
    for (int k = 0; k < i % 4 && !bad.empty(); ++k) bad[random() % bad.size()] = static_cast<char>(random());
    test::write_text(folder.file("c.glb"), bad);
    const Result<Surface> s = read_surface(folder.file("c.glb"));
    if (s.ok()) {
      EXPECT_LT(s.value().F.maxCoeff(), s.value().V.rows());
    }
  }
}

struct Trip {
  const char *reader, *from, *to;
};

// What another program has read and written again has the same triangles, labels and regions.
TEST(Labels, SurviveOtherPrograms) {
  const TemporaryFolder folder;
  LabelledTetMesh m = sample();
  for (Index& l : m.attributes.labels.of) l = std::abs(l);  // Gmsh has no others
  for (const Place& c : kPlaces)
    ASSERT_TRUE(write_tets(folder.file(c.name), m.mesh, m.attributes, {c.format, 1}).ok());
  for (const Trip& t :
       {Trip{"meshio", "a.mesh", "m1.msh"}, Trip{"meshio", "a.mesh", "m2.vtu"},
        Trip{"meshio", "b.msh", "m3.vtu"}, Trip{"meshio", "c.msh", "m4.msh"}, Trip{"gmsh", "b.msh", "g1.msh"},
        Trip{"gmsh", "c.msh", "g2_22.msh"}, Trip{"gmsh", "a.mesh", "g3.msh"},
        Trip{"gmsh", "c.msh", "g4.mesh"}, Trip{"vtk", "d.vtu", "v1.vtu"}, Trip{"vtk", "d.vtu", "v2_raw.vtu"},
        Trip{"vtk", "g.vtk", "v3.vtk"}, Trip{"vtk", "g.vtk", "v4_binary.vtk"}}) {
    SCOPED_TRACE(std::string(t.reader) + " from " + t.from + " to " + t.to);
    const auto r = test::shell("/usr/bin/python3 -B " OVERTET_ROUND_TRIP " " + std::string(t.reader) + " " +
                               folder.file(t.from) + " " + folder.file(t.to));
    if (r.exit_code == 77) {
      std::fprintf(stderr, "SKIPPED, no round trip: %s", r.err.c_str());
      continue;
    }
    ASSERT_EQ(r.exit_code, 0) << r.err;
    const Result<LabelledTetMesh> read = read_labelled_tets(folder.file(t.to));
    ASSERT_TRUE(read.ok()) << read.error().message;
    const MeshAttributes& a = read.value().attributes;
    EXPECT_EQ(read.value().mesh.V.rows(), m.mesh.V.rows());
    EXPECT_EQ(read.value().mesh.T.rows(), m.mesh.T.rows());
    EXPECT_EQ(sorted_triangles(in_places_of(m.mesh, read.value())), sorted_triangles(m.attributes));
    List regions = a.regions.of;
    if (std::string(t.to) == "m2.vtu" || std::string(t.to) == "m3.vtu")
      continue;  // meshio names them otherwise
    std::sort(regions.begin(), regions.end());
    EXPECT_EQ(regions, m.attributes.regions.of);
  }
}

// Gmsh refused legacy VTK with field data before the points.
TEST(Labels, OtherProgramsReadTheTetsAllTheSame) {
  const TemporaryFolder folder;
  const LabelledTetMesh m = sample();
  const std::string numbers = std::to_string(m.mesh.V.rows()) + " " + std::to_string(m.mesh.T.rows()) + "\n";
  for (const Place& c : kPlaces)
    ASSERT_TRUE(write_tets(folder.file(c.name), m.mesh, m.attributes, {c.format, 1}).ok());
  for (const auto& [library, file] :
       std::initializer_list<std::pair<std::string, std::string>>{{"gmsh", "a.mesh"},
                                                                  {"gmsh", "b.msh"},
                                                                  {"gmsh", "c.msh"},
                                                                  {"gmsh", "g.vtk"},
                                                                  {"meshio", "a.mesh"},
                                                                  {"meshio", "b.msh"},
                                                                  {"meshio", "c.msh"},
                                                                  {"meshio", "d.vtu"},
                                                                  {"meshio", "g.vtk"},
                                                                  {"vtk", "d.vtu"},
                                                                  {"vtk", "g.vtk"}}) {
    SCOPED_TRACE(library + " reads " + file);
    const auto r =
        test::shell("/usr/bin/python3 -B " OVERTET_READ_BACK " " + library + " " + folder.file(file));
    ASSERT_EQ(r.exit_code, 0) << r.err;
    EXPECT_TRUE(r.out.starts_with(numbers) || r.out.find("\n" + numbers) != std::string::npos)
        << r.out.substr(0, 200);
  }
}

TEST(Labels, ManyFilesThatAreDamagedNeverCrash) {
  const std::uint64_t seed = 78;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  const TemporaryFolder folder;
  const LabelledTetMesh m = sample();
  for (const Place& c : kPlaces)
    for (const char* gz : {"", ".gz"}) {
      const std::string path = folder.file(c.name + std::string(gz));
      ASSERT_TRUE(write_tets(path, m.mesh, m.attributes, {c.format, 2}).ok());
      const std::string good = test::read_text(path);
      for (int i = 0; i < 200; ++i) {
        std::string bad = good;
        if (i % 2 == 0) bad.resize(random() % bad.size());
        for (int k = 0; k < i % 4 && !bad.empty(); ++k)
          bad[random() % bad.size()] = static_cast<char>(random());
        test::write_text(path, bad);
        const Result<LabelledTetMesh> r = read_labelled_tets(path);
        (void)read_surface(path).ok();
        if (!r.ok()) continue;
        const MeshAttributes& a = r.value().attributes;
        if (a.triangles.rows() > 0) {
          EXPECT_LT(a.triangles.maxCoeff(), r.value().mesh.V.rows());
        }
        EXPECT_EQ(a.labels.of.size(), static_cast<std::size_t>(a.triangles.rows()));
      }
    }
}

}  // namespace
}  // namespace overtet
