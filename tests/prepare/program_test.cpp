// `overtet prepare` on files.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "overtet/io.h"
#include "tests/support/files.h"
#include "tests/support/models.h"

namespace overtet {
namespace {

using nlohmann::json;

class PrepareProgram : public ::testing::Test {
 protected:
  static test::ShellResult run(const std::string& arguments) {
    return test::shell(std::string(OVERTET_PROGRAM) + " " + arguments);
  }
  std::string file(const char* name) const { return folder_.file(name); }
  // A ball of which the first face is missing, and a vertex that no face uses.
  void write_open(const std::string& path) const {
    Surface s = test::sphere(2);
    s.F = TriangleMatrix(s.F.bottomRows(s.F.rows() - 1));
    s.V.conservativeResize(s.V.rows() + 1, 3);
    s.V.row(s.V.rows() - 1) << 9, 9, 9;
    ASSERT_TRUE(write_surface(path, s, surface_format_of(path).value()).ok());
  }
  static void expect_valid(const std::string& report) {
    const test::ShellResult r =
        test::shell("/usr/bin/python3 -W ignore -m jsonschema -i " + report + " " OVERTET_PREPARE_SCHEMA);
    EXPECT_EQ(r.exit_code, 0) << r.out << r.err;
  }
  test::TemporaryFolder folder_;
};

TEST_F(PrepareProgram, FillsAHoleSaysSoAndMapsToTheFile) {
  write_open(file("in.off"));
  const test::ShellResult r =
      run("prepare " + file("in.off") + " -o " + file("out.off") + " --fill-holes 10 --report " +
          file("r.json") + " --save-map " + file("m.json"));
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.err.find("1 unused vertex dropped"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("fill-holes: 1 of 1 hole filled"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("closed, oriented and manifold"), std::string::npos) << r.err;
  EXPECT_EQ(run("inspect " + file("out.off") + " --strict --fail-on unclean").exit_code, 0);
  const json report = json::parse(test::read_text(file("r.json"))),
             map = json::parse(test::read_text(file("m.json")));
  EXPECT_EQ(report["status"], "prepared");
  EXPECT_TRUE(report["result"]["closed"]);
  EXPECT_EQ(report["input"]["clean_up"]["unused-vertex"], 1);
  EXPECT_EQ(report["steps"][0]["step"], "fill-holes");
  EXPECT_EQ(report["steps"][0]["done"], 1);
  // The runs of the report and the map say the same.
  const Surface given = read_surface(file("in.off")).value(), out = read_surface(file("out.off")).value();
  for (const char* what : {"vertices", "faces"}) {
    const json& list = map[what];
    ASSERT_EQ(list.size(), std::size_t(what[0] == 'v' ? out.V.rows() : out.F.rows()));
    std::size_t covered = 0;
    for (const json& run : report["result"]["map"][what])
      for (int i = 0; i < run[2]; ++i)
        for (int j = 0; j < run[3]; ++j, ++covered) {
          const int number = run[0].get<int>() + i * run[3].get<int>() + j;
          EXPECT_EQ(list[number], run[1] < 0 ? -1 : run[1].get<int>() + i);
        }
    EXPECT_EQ(covered, list.size());
  }
  for (Index v = 0; v < out.V.rows(); ++v)
    if (const int u = map["vertices"][v]; u >= 0) EXPECT_EQ(out.V.row(v), given.V.row(u));
  expect_valid(file("r.json"));
}

// What `inspect` says would mend the holes does, and it says where they are.
TEST_F(PrepareProgram, InspectNamesWhatMends) {
  Surface s = test::sphere(3);
  s.F = TriangleMatrix(s.F.bottomRows(s.F.rows() - 1).topRows(s.F.rows() - 2));
  ASSERT_TRUE(write_surface(file("in.off"), s, SurfaceFormat::off).ok());
  const test::ShellResult text = run("inspect " + file("in.off"));
  EXPECT_EQ(text.exit_code, 3);
  EXPECT_NE(text.out.find("also 3 edges"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("component   " + std::to_string(s.F.rows()) + " faces"), std::string::npos)
      << text.out;
  const json found = json::parse(run("inspect --json " + file("in.off")).out);
  EXPECT_EQ(found["thin_spots"], nullptr);
  const json& hole = found["defects"][0];
  EXPECT_EQ(hole["kind"], "hole");
  EXPECT_EQ(hole["count"], 2);
  const std::string mend = hole["mend"], step = "--fill-holes 3";
  EXPECT_NE(mend.find("overtet prepare " + step), std::string::npos) << mend;
  EXPECT_NE(text.out.find(mend), std::string::npos);
  EXPECT_EQ(run("prepare " + file("in.off") + " -o " + file("out.off") + " " + step).exit_code, 0);
  const json mended = json::parse(run("inspect --json " + file("out.off")).out);
  EXPECT_TRUE(mended["closed"]);
  EXPECT_EQ(mended["components"][0]["faces_inwards"], false);
  EXPECT_EQ(mended["thin_spots"]["count"], 0);
}

TEST_F(PrepareProgram, InspectListsThinSpots) {
  const Surface shell = test::joined(test::sphere(3), test::flipped(test::sphere(3, 0.9995)));
  ASSERT_TRUE(write_surface(file("in.obj"), shell, SurfaceFormat::obj).ok());
  const std::string text = run("inspect " + file("in.obj")).out;
  EXPECT_NE(text.find("thin        1 spot where"), std::string::npos) << text;
  EXPECT_NE(text.find("faces inwards, volume"), std::string::npos) << text;
  const json found = json::parse(run("inspect --json " + file("in.obj")).out)["thin_spots"];
  EXPECT_EQ(found["count"], 1);
  const json& spot = found["spots"][0];
  EXPECT_NEAR(spot["thickness"].get<double>(), 5e-4, 1e-5);
  // Numbers of the file: OBJ counts from 1. One side each.
  ASSERT_EQ(spot["faces"].size(), 2u);
  const int half = static_cast<int>(shell.F.rows()) / 2;
  EXPECT_NE(spot["faces"][0].get<int>() <= half, spot["faces"][1].get<int>() <= half);
}

TEST_F(PrepareProgram, SaysWhatIsStillOpen) {
  write_open(file("in.obj"));
  const test::ShellResult r =
      run("prepare " + file("in.obj") + " -o " + file("out.ply") + " --remove-small 3");
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.err.find("not closed yet: The surface has a hole of 3 edges"), std::string::npos) << r.err;
}

TEST_F(PrepareProgram, RefusesUsage) {
  write_open(file("in.off"));
  EXPECT_EQ(run("prepare " + file("in.off") + " -o " + file("out.off")).exit_code, 2);
  EXPECT_EQ(run("prepare " + file("in.off") + " -o " + file("in.off") + " --all").exit_code, 2);
  EXPECT_EQ(run("prepare " + file("in.off") + " -o " + file("out.stl") + " --all").exit_code, 2);
  EXPECT_EQ(
      run("prepare " + file("in.off") + " -o " + file("out.off") + " --all --report " + file("r.json") +
          " --remove-small 100 --largest --needle-angle 5 --tolerance 0.1 --weld 0.01 --allow-crossings")
          .exit_code,
      0);
  expect_valid(file("r.json"));
  EXPECT_EQ(run("prepare " + file("in.off") + " -o " + file("out.off") + " --fill-holes 2").exit_code, 2);
  EXPECT_EQ(run("prepare " + file("none.off") + " -o " + file("out.off") + " --all").exit_code, 7);
  const test::ShellResult help = run("help prepare");
  EXPECT_EQ(help.exit_code, 0);
  for (const char* step :
       {"--weld", "--close-cracks", "--remove-small", "--largest", "--fill-holes", "--collapse-needles"})
    EXPECT_NE(help.out.find(step), std::string::npos) << step;
}

}  // namespace
}  // namespace overtet
