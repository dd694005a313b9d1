#include "overtet/io.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <random>

#include "tests/support/files.h"
#include "tests/support/models.h"

namespace overtet {
namespace {

using test::TemporaryFolder;
using test::write_text;

const char* const kTetrahedron = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";

Result<Surface> read(const std::string& name, const std::string& text, SurfaceReadInfo* info = nullptr) {
  const TemporaryFolder folder;
  write_text(folder.file(name), text);
  return read_surface(folder.file(name), info);
}

void expect_tetrahedron(const Result<Surface>& s) {
  ASSERT_TRUE(s.ok()) << s.error().message;
  ASSERT_EQ(s.value().V.rows(), 4);
  ASSERT_EQ(s.value().F.rows(), 4);
  EXPECT_EQ(s.value().V(1, 0), 1);
  EXPECT_EQ(s.value().V(3, 2), 1);
  EXPECT_TRUE(test::is_closed_oriented(s.value()));
}

// A sentence, with all that is expected in it.
void expect_refused(const Result<Surface>& s, std::initializer_list<const char*> parts) {
  ASSERT_FALSE(s.ok());
  EXPECT_EQ(s.error().code, ErrorCode::bad_input);
  EXPECT_EQ(s.error().message.back(), '.');
  EXPECT_EQ(s.error().message.find('\n'), std::string::npos);
  for (const char* part : parts)
    EXPECT_NE(s.error().message.find(part), std::string::npos) << s.error().message;
}

const std::string kFaces0 = "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";

TEST(SurfaceIo, Off) {
  expect_tetrahedron(read("a.off", std::string("OFF\n4 4 6\n") + kTetrahedron + kFaces0));
  expect_tetrahedron(read(
      "a.off", std::string("# by hand\n\nOFF 4 4 0 # counts\n") + kTetrahedron + "\n# faces\n" + kFaces0));
  std::string text = std::string("OFF\n4 4 6\n") + kTetrahedron + kFaces0;
  std::string dos;
  for (const char c : text) dos += c == '\n' ? "\r\n" : std::string(1, c);
  expect_tetrahedron(read("a.off", dos));
  text.pop_back();
  expect_tetrahedron(read("a.off", text));
  expect_tetrahedron(read("a.off",
                          "COFF\n4 4 0\n0 0 0 255 0 0 255\n1 0 0 1 2 3 4\n0 1 0 0 0 0 0\n0 0 1 0 0 0 0\n"
                          "3 0 2 1 255 0 0\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"));
}

TEST(SurfaceIo, Obj) {
  expect_tetrahedron(
      read("a.obj",
           "# x\nmtllib a.mtl\no thing\nv 0 0 0\nv 1 0 0 1\nv +0 1 0\nvn 0 0 1\nvt 0 0\nv 0 0 1.0e0\n"
           "usemtl red\ns off\nf 1 3 2\nf 1/1 2/1 4/1\nf 2//1 3//1 4//1\nf 1/1/1 4/1/1 3/1/1\n"));
  expect_tetrahedron(read(
      "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf -4 -2 -3\nf -4 -3 -1\nf -3 -2 \\\n -1\nf -4 -1 -2"));
  // Faces may come before their vertices.
  expect_tetrahedron(
      read("a.obj", "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"));
}

template <class T>
void append(std::string& s, T x, bool big) {
  char b[sizeof(T)];
  std::memcpy(b, &x, sizeof(T));
  if (big) std::reverse(b, b + sizeof(T));
  s.append(b, sizeof(T));
}

TEST(SurfaceIo, Ply) {
  const std::string header =
      "element vertex 4\nproperty float x\nproperty double y\nproperty double z\nproperty uchar red\n"
      "element face 4\nproperty list uchar uint vertex_indices\nproperty short tag\nelement edge 1\n"
      "property int vertex1\nend_header\n";
  expect_tetrahedron(read(
      "a.ply", "ply\nformat ascii 1.0\ncomment hello\n" + header +
                   "0 0 0 1\n1 0 0 2\n0 1 0 3\n0 0 1 4\n3 0 2 1 7\n3 0 1 3 7\n3 1 2 3 7\n3 0 3 2 7\n0\n"));
  for (const bool big : {false, true}) {
    std::string text =
        std::string("ply\nformat binary_") + (big ? "big" : "little") + "_endian 1.0\n" + header;
    const double xyz[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (const auto& p : xyz) {
      append(text, static_cast<float>(p[0]), big);
      append(text, p[1], big);
      append(text, p[2], big);
      text += '\x01';
    }
    const std::uint32_t faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    for (const auto& f : faces) {
      text += '\x03';
      for (const std::uint32_t v : f) append(text, v, big);
      append(text, std::int16_t{7}, big);
    }
    append(text, std::int32_t{0}, big);
    SurfaceReadInfo info;
    expect_tetrahedron(read("a.ply", text, &info));
    EXPECT_EQ(info.format, big ? "PLY, binary, big endian" : "PLY, binary, little endian");
    expect_refused(read("a.ply", text.substr(0, text.size() - 30)), {"ends inside", "face"});
    // The content counts, not the name.
    expect_tetrahedron(read("a.off", text, &info));
    EXPECT_EQ(info.notes.size(), 1u);
  }
}

TEST(SurfaceIo, StlMergesEqualCorners) {
  const double p[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const int f[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  std::string ascii = "solid some thing\n", binary(80, ' ');
  append(binary, std::uint32_t{4}, false);
  for (const auto& t : f) {
    ascii += " facet normal 0 0 0\n  outer loop\n";
    for (int k = 0; k < 3; ++k) append(binary, 0.0f, false);
    for (const int v : t) {
      ascii += "   vertex";
      for (int k = 0; k < 3; ++k) {
        // Both zeros are the same point.
        const double x = p[v][k] == 0 && t[0] == 1 ? -0.0 : p[v][k];
        ascii += x == 0 && std::signbit(x) ? " -0.0" : " " + std::to_string(x);
        append(binary, static_cast<float>(x), false);
      }
      ascii += "\n";
    }
    ascii += "  endloop\n endfacet\n";
    append(binary, std::uint16_t{0}, false);
  }
  ascii += "endsolid some thing\n";
  for (const std::string& text : {ascii, binary}) {
    SurfaceReadInfo info;
    const Result<Surface> s = read("a.stl", text, &info);
    ASSERT_TRUE(s.ok()) << s.error().message;
    EXPECT_EQ(s.value().V.rows(), 4);
    EXPECT_TRUE(test::is_closed_oriented(s.value()));
    EXPECT_EQ(info.merged_vertices, 8);
    EXPECT_FALSE(info.has_vertex_order);
    EXPECT_EQ(info.notes.size(), 1u);
  }
  expect_refused(read("a.stl", ascii.substr(0, ascii.size() / 2)), {"triangle"});
  expect_refused(read("a.stl", binary.substr(0, 200)), {"binary STL"});
}

TEST(SurfaceIo, PolygonsAreCutIntoTriangles) {
  // A box of six squares, and an L-shaped prism, which is not convex.
  SurfaceReadInfo info;
  const Result<Surface> box = read("a.off",
                                   "OFF\n8 6 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n"
                                   "4 3 2 1 0\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n",
                                   &info);
  ASSERT_TRUE(box.ok()) << box.error().message;
  EXPECT_EQ(info.polygons, 6);
  EXPECT_EQ(info.notes.size(), 1u);
  EXPECT_EQ(box.value().F.rows(), 12);
  EXPECT_TRUE(test::is_closed_oriented(box.value()));
  EXPECT_DOUBLE_EQ(test::signed_volume(box.value()), 1);
  const Result<Surface> prism =
      read("a.obj",
           "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\n"
           "v 0 0 1\nv 2 0 1\nv 2 1 1\nv 1 1 1\nv 1 2 1\nv 0 2 1\n"
           "f 6 5 4 3 2 1\nf 7 8 9 10 11 12\nf 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\nf 4 5 11 10\n"
           "f 5 6 12 11\nf 6 1 7 12\n");
  ASSERT_TRUE(prism.ok()) << prism.error().message;
  EXPECT_EQ(prism.value().F.rows(), 2 * 4 + 6 * 2);
  EXPECT_TRUE(test::is_closed_oriented(prism.value()));
  EXPECT_DOUBLE_EQ(test::signed_volume(prism.value()), 3);
  // The caps must lie inside the L: no triangle of the cap covers the notch.
  double cap = 0;
  for (Eigen::Index f = 0; f < 4; ++f) {
    const auto& F = prism.value().F;
    const auto& V = prism.value().V;
    const Eigen::Vector3d a = V.row(F(f, 0)), b = V.row(F(f, 1)), c = V.row(F(f, 2));
    cap += std::abs((b - a).x() * (c - a).y() - (b - a).y() * (c - a).x()) / 2;
  }
  EXPECT_DOUBLE_EQ(cap, 3);
}

TEST(SurfaceIo, MalformedFilesAreRefusedWithTheirPlace) {
  const std::string v = kTetrahedron;
  expect_refused(read("a.off", ""), {"empty"});
  expect_refused(read("a.off", "OFF\n"), {"ends before"});
  expect_refused(read("a.off", "hello\n"), {"OFF"});
  expect_refused(read("a.xyz", "1 2 3\n"), {"OBJ, OFF, PLY, STL"});
  expect_refused(read("a.off", "4OFF\n4 4 0\n"), {"4OFF"});
  expect_refused(read("a.off", "OFF\n4 -4 0\n" + v), {"line 2", "-4"});
  expect_refused(read("a.off", "OFF\n4000000000 4 0\n" + v), {"line 2", "too short"});
  expect_refused(read("a.off", "OFF\n4 99999999999999999999 0\n" + v), {"line 2", "too large"});
  expect_refused(read("a.off", "OFF\n4 4 0\n" + v + "3 0 2 1\n3 0 1"), {"too short"});
  expect_refused(read("a.off", "OFF\n4 4 0\n" + v + "3 0 2 1\n3 0 1 3\n3 1 2 3                  \n"),
                 {"ends after 3 of 4 faces"});
  expect_refused(read("a.off", "OFF\n4 4 0\n0 0 0\n1 0 inf\n0 1 0\n0 0 1\n" + kFaces0),
                 {"line 4", "inf", "vertex 1"});
  expect_refused(read("a.off", "OFF\n4 4 0\n0 0 0\n1 0 nan\n0 1 0\n0 0 1\n" + kFaces0),
                 {"line 4", "vertex 1"});
  expect_refused(read("a.off", "OFF\n4 4 0\n0 0 0\n1 0 1e999\n0 1 0\n0 0 1\n" + kFaces0),
                 {"line 4", "too large"});
  expect_refused(read("a.off", "OFF\n4 4 0\n0 0 0\n1 0.1abc 0\n0 1 0\n0 0 1\n" + kFaces0),
                 {"line 4", "0.1abc"});
  expect_refused(read("a.off", "OFF\n4 4 0\n0 0 0\n1,0 0 0\n0 1 0\n0 0 1\n" + kFaces0), {"line 4", "1,0"});
  expect_refused(read("a.off", "OFF\n4 4 0\n0 0 0\n1 0\n0 1 0\n0 0 1\n" + kFaces0), {"line 4", "missing"});
  expect_refused(read("a.off", "OFF\n4 4 0\n" + v + "3 0 2 1\n3 0 1 4\n3 1 2 3\n3 0 3 2\n"),
                 {"line 8", "vertex 4", "face 1"});
  expect_refused(read("a.off", "OFF\n4 4 0\n" + v + "3 0 2 1\n3 0 1 -1\n3 1 2 3\n3 0 3 2\n"),
                 {"line 8", "-1"});
  expect_refused(read("a.off", "OFF\n4 4 0\n" + v + "3 0 2 1\n2 0 1   \n3 1 2 3\n3 0 3 2\n"),
                 {"line 8", "2 corners"});
  expect_refused(read("a.off", std::string("OFF\n4 4 0\n0 0 0\n1 0 \0\n0 1 0\n0 0 1\n", 35) + kFaces0),
                 {"line 4", "NUL"});
  expect_refused(read("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n"), {"line 4", "vertex 0"});
  expect_refused(read("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"), {"line 4", "vertex 9"});
  expect_refused(read("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n"), {"line 4", "4 vertices"});
  expect_refused(read("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n"), {"line 4", "three corners"});
  expect_refused(read("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 x\n"), {"line 4", "\"x\""});
  expect_refused(read("a.obj", "v 0 0\n"), {"line 1", "missing", "vertex 1"});
  expect_refused(read("a.obj", "v 0 0 0\n\x01\x02\x03\n"), {"line 2"});
  expect_refused(read("a.obj", "# nothing\n"), {"no vertices"});
  expect_refused(read("a.obj", "v 0 0 0\n"), {"no faces"});
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n";
  const std::string face = "element face 4\nproperty list uchar int vertex_index\nend_header\n";
  expect_refused(read("a.ply", head + face), {"too short"});
  expect_refused(read("a.ply", head + "element face 1\n" + v), {"end_header"});
  expect_refused(read("a.ply", head + face + v + "3 0 2 1\n3 0 1\n3 1 2 3\n3 0 3 2\n"),
                 {"line 15", "missing"});
  expect_refused(read("a.ply", "ply\nformat ebcdic 1.0\n" + face), {"ebcdic"});
  expect_refused(
      read("a.ply",
           "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\n"
           "element face 0\nproperty list uchar int vertex_indices\nend_header\n"),
      {"no vertices"});
  const Result<Surface> absent = read_surface("/nonexistent/file.off");
  ASSERT_FALSE(absent.ok());
  EXPECT_EQ(absent.error().code, ErrorCode::io);
  const TemporaryFolder folder;
  EXPECT_EQ(read_surface(folder.path()).error().code, ErrorCode::io);
}

// What other programs read, and one test each: a bug a test.

TEST(SurfaceIo, OffFacesMayTakeSeveralLines) {
  const std::string head = std::string("OFF\n4 4 6\n") + kTetrahedron;
  SurfaceReadInfo info;
  expect_tetrahedron(read("a.off", head + "3 0 \n 2\n1\n3 0 1 3\n3\n1 2\n3\n3 0 3 2\n", &info));
  EXPECT_EQ(info.source.face_line, (std::vector<std::uint32_t>{7, 10, 11, 14}));
  // A line that is too short does not take the next face's numbers.
  expect_refused(read("a.off", head + "3 0 2 1\n3 0 1\n3 1 2 3\n3 0 3 2\n"), {"line 8", "face 1"});
}

TEST(SurfaceIo, VariantsOfOffAreRead) {
  const std::string faces = kFaces0;
  expect_tetrahedron(
      read("a.off", "NOFF\n4 4 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n0 0 1 0 0 1\n" + faces));
  expect_tetrahedron(read("a.off", "STOFF\n4 4 0\n0 0 0 0 1\n1 0 0 0 1\n0 1 0 0 1\n0 0 1 0 1\n" + faces));
  expect_tetrahedron(read("a.off", "NCOFF 4 4 0\n0 0 0 9\n1 0 0 9\n0 1 0 9\n0 0 1 9\n" + faces));
  expect_tetrahedron(read("a.off", std::string("off\n4 4 0\n") + kTetrahedron + faces));
  expect_refused(read("a.off", "4OFF\n1 1 0\n0 0 0 1\n"), {"4OFF", "dimension"});
  expect_refused(read("a.off", "OFF BINARY\n" + faces), {"binary OFF"});
}

TEST(SurfaceIo, NulsAtTheEndOfATextAreIgnored) {
  const std::string off = std::string("OFF\n4 4 6\n") + kTetrahedron + kFaces0;
  expect_tetrahedron(read("a.off", off + std::string(1, '\0')));
  expect_tetrahedron(read("a.off", off + std::string(700, '\0')));
  const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
  expect_tetrahedron(read("a.obj", obj + std::string(1, '\0')));
}

TEST(SurfaceIo, LinesMayEndWithACarriageReturnAlone) {
  std::string obj = "# old\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
  std::replace(obj.begin(), obj.end(), '\n', '\r');
  SurfaceReadInfo info;
  expect_tetrahedron(read("a.obj", obj, &info));
  EXPECT_EQ(info.source.vertex_line, (std::vector<std::uint32_t>{2, 3, 4, 5}));
  std::string off = std::string("OFF\n4 4 6\n") + kTetrahedron + kFaces0;
  std::replace(off.begin(), off.end(), '\n', '\r');
  expect_tetrahedron(read("a.off", off));
}

TEST(SurfaceIo, ObjLinesMayBeVeryLongOrGoOn) {
  std::string obj =
      "# " + std::string(3000000, 'x') + "\nv 0 0 0\nv 1 \\\n 0 0\nv 0 1 0\nv 0 0 1\nf 1 \\\r\n3 2\nf 1";
  obj += std::string(1000000, ' ') + "2 4\nf 2 3 4\nf -4 -1 -2\n";
  expect_tetrahedron(read("a.obj", obj));
}

TEST(SurfaceIo, PlyMayHaveMoreValuesAndAnyTypesOfLists) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n";
  SurfaceReadInfo info;
  expect_tetrahedron(
      read("a.ply",
           head + "element face 4\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1\n1 0 0 1\n"
                  "0 1 0\n0 0 1\n3 0 2 1 255 0 0\n3 0 1 3\n3 1 2 3\n3 0 3 2\n",
           &info));
  ASSERT_EQ(info.notes.size(), 1u);
  EXPECT_NE(info.notes[0].find("line 10"), std::string::npos) << info.notes[0];
  expect_tetrahedron(
      read("a.ply", head + "property list int float weights\nelement face 4\nproperty list float "
                           "double vertex_index\nproperty list uint char more\nend_header\n0 0 0 2 .5 .5\n"
                           "1 0 0 0\n0 1 0 0\n0 0 1 1 1\n3 0 2 1 0\n3 0 1 3 1 7\n3 1 2 3 0\n3 0 3 2 0\n"));
  expect_tetrahedron(read("a.ply", head + "element face 4\nproperty list ushort uint corners\nend_header\n" +
                                       kTetrahedron + "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"));
}

TEST(SurfaceIo, EndSolidMayBeTwoWords) {
  const char* const corners[] = {"0 0 0", "1 0 0", "0 1 0", "0 0 1"};
  const int f[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  std::string text = "SOLID a\n";
  for (const auto& t : f) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const int v : t) text += std::string("vertex ") + corners[v] + "\n";
    text += "end loop\nend facet\n";
  }
  const Result<Surface> s = read("a.stl", text + "end solid\n");
  ASSERT_TRUE(s.ok()) << s.error().message;
  EXPECT_TRUE(test::is_closed_oriented(s.value()));
}

TEST(SurfaceIo, BytesBehindABinaryStlAreIgnored) {
  std::string stl(80, ' ');
  append(stl, std::uint32_t{1}, false);
  for (int i = 0; i < 12; ++i) append(stl, static_cast<float>(i * i % 7), false);
  append(stl, std::uint16_t{0}, false);
  SurfaceReadInfo info;
  const Result<Surface> s = read("a.stl", stl + "more", &info);
  ASSERT_TRUE(s.ok()) << s.error().message;
  EXPECT_EQ(s.value().F.rows(), 1);
  EXPECT_EQ(info.notes.size(), 1u);
}

TEST(SurfaceIo, APolygonMayNameACornerTwice) {
  SurfaceReadInfo info;
  const Result<Surface> s = read(
      "a.obj",
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv .5 .5 1\nf 1 4 4 3 2\nf 1 2 5 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n",
      &info);
  ASSERT_TRUE(s.ok()) << s.error().message;
  ASSERT_EQ(s.value().F.rows(), 8);
  EXPECT_EQ(info.source.face, (std::vector<Index>{0, 0, 0, 1, 1, 2, 3, 4}));
  int flat = 0;
  for (Index f = 0; f < 8; ++f)
    flat += s.value().F(f, 0) == s.value().F(f, 1) || s.value().F(f, 1) == s.value().F(f, 2) ||
            s.value().F(f, 2) == s.value().F(f, 0);
  EXPECT_EQ(flat, 2);
}

TEST(SurfaceIo, PlacesInTheFileAreKnown) {
  SurfaceReadInfo info;
  const Result<Surface> s = read(
      "a.obj",
      "# x\nv 0 0 0\n\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 \\\n4\nf 1 4 3\n", &info);
  expect_tetrahedron(s);
  EXPECT_EQ(info.source.vertex_name(0), "vertex 1 (line 2)");
  EXPECT_EQ(info.source.vertex_name(3), "vertex 4 (line 7)");
  EXPECT_EQ(info.source.face_name(2), "face 3 (line 10)");
  EXPECT_EQ(info.source.face_name(3), "face 4 (line 12)");
}

// Cutting a good file anywhere, or changing any byte, never does harm.
TEST(SurfaceIo, DamagedFilesNeverCrash) {
  const std::uint64_t seed = 20130713;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  const TemporaryFolder folder;
  const Surface s = test::sphere(1);
  for (const char* name : {"a.off", "a.obj", "a.ply", "a.vtp"}) {
    ASSERT_TRUE(write_surface(folder.file(name), s, surface_format_of(name).value()).ok());
    const std::string good = test::read_text(folder.file(name));
    for (int i = 0; i < 300; ++i) {
      std::string bad = good;
      if (i % 2 == 0) bad.resize(random() % bad.size());
      for (int k = 0; k < i % 4 && !bad.empty(); ++k)
        bad[random() % bad.size()] = static_cast<char>(random());
      write_text(folder.file("b"), bad);
      const Result<Surface> r = read_surface(folder.file("b"));
      if (!r.ok()) {
        EXPECT_EQ(r.error().message.find('\n'), std::string::npos);
        continue;
      }
      EXPECT_TRUE(r.value().V.allFinite());
      EXPECT_GE(r.value().F.minCoeff(), 0);
      EXPECT_LT(r.value().F.maxCoeff(), r.value().V.rows());
    }
  }
}

TEST(SurfaceIo, WrittenSurfacesReadBackToTheBit) {
  const TemporaryFolder folder;
  Surface s = test::transformed(test::torus(), test::some_rotation(5), Eigen::Vector3d(1e3, 1.0 / 3, -1e-9));
  s.V(0, 0) = 0x1.fffffffffffffp-1022;  // smaller than any number that prints nicely
  s.V(1, 1) = -0x1.0000000000001p+300;
  s.V(2, 2) = 0x0.0000000000001p-1022;
  s.V(3, 0) = -0.0;
  for (const char* name : {"a.off", "a.obj", "a.ply", "a.vtp"}) {
    ASSERT_TRUE(write_surface(folder.file(name), s, surface_format_of(name).value()).ok());
    const Result<Surface> r = read_surface(folder.file(name));
    ASSERT_TRUE(r.ok()) << r.error().message;
    ASSERT_EQ(r.value().V.rows(), s.V.rows());
    EXPECT_EQ(
        std::memcmp(r.value().V.data(), s.V.data(), sizeof(double) * static_cast<std::size_t>(s.V.size())), 0)
        << name;
    EXPECT_EQ(r.value().F, s.F) << name;
  }
  EXPECT_EQ(folder.entries(), 4);  // nothing beside the files
}

}  // namespace
}  // namespace overtet
