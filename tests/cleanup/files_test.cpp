// The program on files as people have them: each is meshed after an announced clean-up, or refused with its
// place.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "overtet/io.h"
#include "tests/support/files.h"
#include "tests/support/models.h"
#include "tests/support/reports.h"

namespace overtet {
namespace {

using nlohmann::json;
using test::shell;
using test::ShellResult;

class RawFiles : public ::testing::Test {
 protected:
  void TearDown() override { EXPECT_EQ(test::wrong_with_reports(test::reports_in(folder_.path())), ""); }
  static ShellResult run(const std::string& arguments) {
    return shell(std::string(OVERTET_PROGRAM) + " " + arguments);
  }
  static std::string at(const char* name) { return std::string(OVERTET_CASES) + "/" + name; }

  // Meshed, and `verify` agrees; `says` is announced. What was done is in the report, and --strict refuses
  // it.
  json expect_meshed(const std::string& path, const char* says) {
    const std::string mesh = folder_.file("o.mesh");
    const ShellResult made = run("mesh " + path + " -o " + mesh + " --report " + folder_.file("r.json"));
    EXPECT_EQ(made.exit_code, 0) << made.err;
    if (*says) EXPECT_NE(made.err.find(says), std::string::npos) << made.err;
    const ShellResult judged = run("verify " + path + " " + mesh);
    EXPECT_EQ(judged.exit_code, 0) << judged.err;
    const json report = json::parse(test::read_text(folder_.file("r.json")));
    EXPECT_EQ(report["status"], "exact");
    const bool cleaned = report["input"].contains("clean_up");
    EXPECT_EQ(cleaned, made.err.find("Cleaned up: ") != std::string::npos);
    EXPECT_EQ(run("mesh " + path + " -o " + mesh + " --strict").exit_code, cleaned ? 3 : 0);
    EXPECT_EQ(run("inspect " + path).exit_code, 0);
    return report["input"];
  }
  test::TemporaryFolder folder_;
};

TEST_F(RawFiles, UnweldedObjIsMerged) { expect_meshed(at("unwelded.obj"), "16 vertices merged"); }
TEST_F(RawFiles, UnweldedPlyIsMerged) { expect_meshed(at("unwelded.ply"), "16 vertices merged"); }
TEST_F(RawFiles, UnusedVerticesAreDropped) {
  expect_meshed(at("unreferenced.obj"), "1 unused vertex dropped");
}
TEST_F(RawFiles, FacesWithTwoEqualCornersAreDropped) {
  expect_meshed(at("repeated_corner.stl"), "two equal corners dropped");
}
TEST_F(RawFiles, EndSolidIsTwoWordsToSome) { expect_meshed(at("end_solid.stl"), ""); }
TEST_F(RawFiles, ANulAtTheEndIsNoHarm) { expect_meshed(at("nul_at_end.obj"), ""); }
TEST_F(RawFiles, OffFacesMayTakeSeveralLines) { expect_meshed(at("face_over_lines.off"), ""); }
TEST_F(RawFiles, APolygonMayNameACornerTwice) {
  const json input = expect_meshed(at("polygon_repeats.obj"), "1 face with two equal corners dropped");
  EXPECT_EQ(input["clean_up"]["faces"], json::parse("[[0, 0, 6, 2]]"));
}
TEST_F(RawFiles, OneTurnedFaceIsTurned) {
  const json input = expect_meshed(at("one_face_turned.off"), "1 face turned");
  EXPECT_EQ(input["clean_up"]["turned"], json::parse("[[0, 1]]"));
}
TEST_F(RawFiles, BoxesThatShareAnEdgeComeApart) {
  EXPECT_EQ(expect_meshed(at("shared_edge.obj"), "1 edge of four or more faces split")["components"], 2);
}
TEST_F(RawFiles, BoxesThatShareAVertexComeApart) {
  EXPECT_EQ(expect_meshed(at("stl_pinch.stl"), "1 vertex between several fans")["components"], 2);
}
TEST_F(RawFiles, BoxesThatTouchInAVertexStayAsTheyAre) { expect_meshed(at("stl_pinch.obj"), ""); }
TEST_F(RawFiles, ASurfaceThatFacesInwardsIsTurned) {
  expect_meshed(at("inside_out.off"), "faced inwards turned");
}
TEST_F(RawFiles, AComponentThatFacesInwardsIsTurned) {
  const json input = expect_meshed(at("one_inside_out.off"), "1 component that faced inwards turned");
  EXPECT_EQ(input["clean_up"]["turned"], json::parse("[[12, 12]]"));
  EXPECT_EQ(input["winding_max"], 2);
}

TEST_F(RawFiles, AHoleIsNamedWithItsSizeAndPlace) {
  const ShellResult r = run("mesh " + at("one_face_missing.off") + " -o " + folder_.file("o.mesh") +
                            " --report " + folder_.file("r.json"));
  EXPECT_EQ(r.exit_code, 3);
  for (const char* part :
       {"hole of 3 edges", "3.41421 long", "vertices 0, 2, 3 (lines 3, 5, 6)", "(0, 0, 0)"})
    EXPECT_NE(r.err.find(part), std::string::npos) << r.err;
  const ShellResult seen = run("inspect --json " + at("one_face_missing.off"));
  EXPECT_EQ(seen.exit_code, 3);
  const json defects = json::parse(seen.out)["defects"];
  ASSERT_EQ(defects.size(), 1u);
  EXPECT_EQ(defects[0]["kind"], "hole");
  EXPECT_EQ(defects[0]["places"][0]["edges"], 3);
}

// The map and the cleaned surface that are saved belong together and to the file.
TEST_F(RawFiles, TheMapLeadsBackToTheFile) {
  const std::string map = folder_.file("map"), clean = folder_.file("clean.off"),
                    mesh = folder_.file("o.mesh");
  const ShellResult r =
      run("mesh " + at("unwelded.obj") + " -o " + mesh + " --save-map " + map + " --save-cleaned " + clean);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(run("verify --strict " + clean + " " + mesh).exit_code, 0);
  const Result<Surface> cleaned = read_surface(clean), raw = read_surface(at("unwelded.obj"));
  ASSERT_TRUE(cleaned.ok() && raw.ok());
  const json j = json::parse(test::read_text(map));
  ASSERT_EQ(static_cast<Eigen::Index>(j["vertices"].size()), cleaned.value().V.rows());
  for (Index v = 0; v < cleaned.value().V.rows(); ++v)
    EXPECT_EQ(raw.value().V.row(j["vertices"][v].get<Index>()), cleaned.value().V.row(v));
  EXPECT_EQ(j["faces"], json::parse("[0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5]"));
  EXPECT_EQ(j["merged"].size(), 16u);
  for (const json& m : j["merged"])
    EXPECT_EQ(raw.value().V.row(m[0].get<Index>()), cleaned.value().V.row(m[1].get<Index>()));
}

TEST_F(RawFiles, AFaceWithoutAreaIsNamedAsInTheFile) {
  // The box with a vertex on an edge, in OBJ, after an unused vertex.
  test::write_text(folder_.file("a.obj"),
                   "v 9 9 9\nv 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 2\nv 1 0 0\n"
                   "f 2 4 3\nf 2 5 4\nf 3 4 5\nf 2 6 5\nf 6 3 5\nf 2 3 6\n");
  const ShellResult r = run("mesh " + folder_.file("a.obj") + " -o " + folder_.file("o.mesh"));
  EXPECT_EQ(r.exit_code, 5);
  EXPECT_NE(r.err.find("face 6 (line 12)"), std::string::npos) << r.err;
}

TEST_F(RawFiles, WhatIsMendedIsUncleanAllTheSame) {
  EXPECT_EQ(run("inspect " + at("unreferenced.obj")).exit_code, 0);
  EXPECT_EQ(run("inspect --fail-on infeasible " + at("unreferenced.obj")).exit_code, 0);
  EXPECT_EQ(run("inspect --fail-on unclean " + at("unreferenced.obj")).exit_code, 3);
  EXPECT_EQ(run("inspect --json --fail-on unclean " + at("unreferenced.obj")).exit_code, 3);
}

TEST_F(RawFiles, DefectsAreSavedToLookAt) {
  const std::string obj = folder_.file("d.obj"), vtp = folder_.file("d.vtp");
  EXPECT_EQ(run("inspect " + at("one_face_missing.off") + " --save-defects " + obj).exit_code, 3);
  EXPECT_EQ(test::read_text(obj), "v 0 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 0\no hole_0\nl 1 2 3 4\n");
  EXPECT_EQ(run("inspect " + at("one_inside_out.off") + " --save-defects " + vtp).exit_code, 0);
  EXPECT_NE(test::read_text(vtp).find("NumberOfLines=\"3\""), std::string::npos);
  const ShellResult few = run("inspect --json --places 2 " + at("unwelded.obj"));
  const json defect = json::parse(few.out)["defects"][0];
  EXPECT_EQ(defect["count"], 16);
  EXPECT_EQ(defect["places"].size(), 2u);
  EXPECT_EQ(defect["places"][0]["vertices"], json::parse("[9, 1]"));
  EXPECT_EQ(defect["places"][0]["vertex_lines"], json::parse("[9, 1]"));
}

TEST_F(RawFiles, SavingOverTheInputIsRefused) {
  const std::string in = folder_.file("a.off");
  ASSERT_TRUE(write_surface(in, test::sphere(1), SurfaceFormat::off).ok());
  for (const char* option : {" --save-map ", " --save-cleaned "})
    EXPECT_EQ(run("inspect " + in + option + in).exit_code, 2);
  EXPECT_EQ(run("inspect " + in + " --save-cleaned " + folder_.file("a.xyz")).exit_code, 2);
}

}  // namespace
}  // namespace overtet
