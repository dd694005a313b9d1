// The program from outside: every exit code, what it writes and what it leaves behind.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <thread>

#include "overtet/io.h"
#include "src/cli/commands.h"
#include "tests/support/files.h"
#include "tests/support/models.h"
#include "tests/support/noise.h"
#include "tests/support/process.h"
#include "tests/support/reports.h"

namespace overtet {
namespace {

using nlohmann::json;
using test::shell;
using test::ShellResult;
using test::TemporaryFolder;

class Cli : public ::testing::Test {
 protected:
  // Every report that a test has made is a valid one.
  void TearDown() override { EXPECT_EQ(test::wrong_with_reports(test::reports_in(folder_.path())), ""); }
  std::string save(const std::string& name, const Surface& s) {
    const std::string path = folder_.file(name);
    EXPECT_TRUE(write_surface(path, s, surface_format_of(path).value()).ok());
    return path;
  }
  ShellResult run(const std::string& arguments) {
    return shell(std::string(OVERTET_PROGRAM) + " " + arguments);
  }
  json report(const std::string& name) { return json::parse(test::read_text(folder_.file(name))); }
  bool exists(const std::string& name) { return !test::read_text(folder_.file(name)).empty(); }
  // One sentence on standard error and nothing else.
  void expect_one_line(const ShellResult& r) {
    EXPECT_EQ(r.out, "");
    EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
    EXPECT_EQ(r.err.find('\r'), std::string::npos);
    EXPECT_EQ(r.err.rfind("overtet: ", 0), 0u) << r.err;
  }
  TemporaryFolder folder_;
};

TEST_F(Cli, HelpAndVersion) {
  for (const char* words : {"--help", "mesh --help", "inspect --help", "verify --help", "--version"}) {
    const ShellResult r = run(words);
    EXPECT_EQ(r.exit_code, 0) << words;
    EXPECT_NE(r.out, "") << words;
    EXPECT_EQ(r.err, "") << words;
  }
}

TEST_F(Cli, HelpAndVersionInOtherWords) {
  EXPECT_EQ(run("help").out, run("--help").out);
  EXPECT_EQ(run("help mesh").out, run("mesh --help").out);
  EXPECT_EQ(run("version").out, run("--version").out);
  EXPECT_EQ(run("-V").out, run("--version").out);
  EXPECT_EQ(run("help").exit_code, 0);
  EXPECT_EQ(run("-V").exit_code, 0);
}

TEST_F(Cli, WhatIsMistypedGetsASuggestion) {
  const std::string in = save("a.off", test::sphere(1));
  const std::pair<std::string, const char*> all[] = {
      {"mehs " + in, "do you mean mesh?"},
      {"help inspcet", "do you mean inspect?"},
      {"dance", "the commands are mesh"},
      {"", "the commands are mesh"},
      {"mesh " + in + " -o o.mesh --fromat medit", "no option --fromat; do you mean --format?"},
      {"verify " + in + " o.mesh --max-mvoe=3", "do you mean --max-move?"},
      {"mesh " + in + " -o o.mesh --zzz", "mesh has no option --zzz"},
      {"mesh " + in + " stray.off -o o.mesh", "one argument too many: stray.off"},
      {"verify " + in + " o.mesh stray", "one argument too many: stray"},
      {"mesh " + in + " -o o.mesh --improve 60", "60 is not from 0 to 40"},
      {"mesh " + in + " -o o.mesh --time-limit 0", "0 is not more than 0"},
      {"repair " + in + " -o o.off --max-move 1000", "1000 is not from 0.000001 to 100"},
      {"mesh " + in + " -o o.mesh --threads x", "x is not a number"},
      {"mesh " + in + " -o -", "--format"}};
  for (const auto& [words, said] : all) {
    const ShellResult r = run(words);
    EXPECT_EQ(r.exit_code, 2) << words;
    expect_one_line(r);
    EXPECT_NE(r.err.find(said), std::string::npos) << words << ": " << r.err;
  }
}

TEST_F(Cli, AFileWithoutACommandIsMeshed) {
  const std::string in = save("a.off", test::sphere(1));
  EXPECT_EQ(run(in + " -o " + folder_.file("o.mesh")).exit_code, 0);
  EXPECT_EQ(run("-o " + folder_.file("p.mesh") + " " + in).exit_code, 0);
  EXPECT_EQ(run("verify " + in + " " + folder_.file("o.mesh")).exit_code, 0);
  EXPECT_EQ(test::read_text(folder_.file("o.mesh")), test::read_text(folder_.file("p.mesh")));
}

TEST_F(Cli, EndingsCountInAnyCase) {
  const std::string in = save("a.off", test::sphere(1));
  EXPECT_EQ(run("mesh " + in + " -o " + folder_.file("o.MESH")).exit_code, 0);
  EXPECT_EQ(run("verify " + in + " " + folder_.file("o.MESH")).exit_code, 0);
  EXPECT_EQ(run("repair " + in + " -o " + folder_.file("o.Ply")).exit_code, 0);
  EXPECT_EQ(run("inspect " + in + " --save-curves " + folder_.file("o.VTP")).exit_code, 0);
}

TEST_F(Cli, AFormatThatIsNotTheEndingsIsSaid) {
  const std::string in = save("a.off", test::sphere(1)), out = folder_.file("o.vtu");
  const ShellResult r = run("mesh " + in + " -o " + out + " --format medit");
  EXPECT_EQ(r.exit_code, 0);
  EXPECT_NE(r.err.find("is written as medit"), std::string::npos) << r.err;
  EXPECT_EQ(run("verify " + in + " " + out).exit_code, 3);
  EXPECT_EQ(run("verify " + in + " " + out + " --format medit").exit_code, 0);
  EXPECT_EQ(run("mesh " + in + " -o " + folder_.file("o.msh") + " --format msh22").err.find("ending"),
            std::string::npos);
}

TEST_F(Cli, AMissingFolderIsNamed) {
  const std::string in = save("a.off", test::sphere(1));
  for (const std::string& words :
       {"mesh " + in + " -o " + folder_.file("no/such/o.mesh"),
        "mesh " + in + " -o " + folder_.file("o.mesh") + " --report " + folder_.file("no/such/r.json")}) {
    const ShellResult r = run(words);
    EXPECT_EQ(r.exit_code, 7);
    EXPECT_NE(r.err.find("there is no folder " + folder_.file("no/such")), std::string::npos) << r.err;
  }
}

TEST_F(Cli, FacesOfAMeshHaveTheNumbersOfThePolygonsInTheFile) {
  const std::string in = folder_.file("box.obj"), out = folder_.file("box.vtu");
  std::ofstream(in) << "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
                       "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
  ASSERT_EQ(run("mesh " + in + " -o " + out).exit_code, 0);
  const Result<LabelledTetMesh> m = read_labelled_tets(out);
  ASSERT_TRUE(m.ok());
  EXPECT_EQ(m.value().attributes.input_face, (std::vector<Index>{0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5}));
}

TEST_F(Cli, StandardInputAndOutput) {
  const std::string in = save("a.off", test::sphere(2)), program = OVERTET_PROGRAM;
  ASSERT_EQ(run("mesh " + in + " -o " + folder_.file("o.msh")).exit_code, 0);
  const ShellResult r = shell("cat " + in + " | " + program + " mesh - -o - --format msh41");
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(r.out, test::read_text(folder_.file("o.msh")));
  EXPECT_EQ(shell("cat " + folder_.file("o.msh") + " | " + program + " verify " + in + " -").exit_code, 0);
  const ShellResult through = shell(program + " convert - - --format vtu < " + folder_.file("o.msh") + " | " +
                                    program + " convert - - --format msh41");
  EXPECT_EQ(through.out, r.out);
  EXPECT_EQ(shell("cat " + in + " | " + program + " inspect -").exit_code, 0);
  EXPECT_EQ(shell(program + " mesh " + in + " -o - --format vtu > /dev/full").exit_code, 7);
}

TEST_F(Cli, CompressedFiles) {
  const std::string in = save("a.off", test::sphere(1));
  ASSERT_EQ(shell("gzip -k " + in).exit_code, 0);
  ASSERT_EQ(run("mesh " + in + ".gz -o " + folder_.file("o.mesh.gz")).exit_code, 0);
  ASSERT_EQ(run("mesh " + in + " -o " + folder_.file("o.mesh")).exit_code, 0);
  EXPECT_EQ(shell("gunzip -c " + folder_.file("o.mesh.gz")).out, test::read_text(folder_.file("o.mesh")));
  EXPECT_EQ(run("verify " + in + ".gz " + folder_.file("o.mesh.gz")).exit_code, 0);
  test::write_text(folder_.file("b.off.gz"), test::read_text(in + ".gz").substr(0, 100));
  const ShellResult r = run("inspect " + folder_.file("b.off.gz"));
  EXPECT_EQ(r.exit_code, 3);
  expect_one_line(r);
}

TEST_F(Cli, ConvertKeepsLabelsToTheBit) {
  const std::string stl = folder_.file("a.stl");
  std::ofstream out(stl);
  for (const double x : {0.0, 0.7}) {
    const Surface s = test::shifted(test::sphere(1), x, 0, 0);
    out << "solid " << (x == 0 ? "left" : "right") << "\n";
    for (Eigen::Index f = 0; f < s.F.rows(); ++f) {
      out << "facet normal 0 0 0\nouter loop\n";
      for (int k = 0; k < 3; ++k) out << "vertex " << s.V.row(s.F(f, k)) << "\n";
      out << "endloop\nendfacet\n";
    }
    out << "endsolid\n";
  }
  out.close();
  ASSERT_EQ(run("mesh " + stl + " -o " + folder_.file("0.vtu")).exit_code, 0);
  int step = 0;
  std::string last = folder_.file("0.vtu");
  for (const char* extension : {".msh", ".vtk", ".vtu"}) {
    const std::string next = folder_.file(std::to_string(++step) + extension);
    ASSERT_EQ(run("convert " + last + " " + next).exit_code, 0) << next;
    EXPECT_EQ(run("verify " + stl + " " + next).exit_code, 0) << next;
    last = next;
  }
  EXPECT_EQ(test::read_text(last), test::read_text(folder_.file("0.vtu")));
  for (const char* extension : {".mesh", ".node", ".inp"}) {
    const std::string next = folder_.file(std::to_string(++step) + extension);
    ASSERT_EQ(run("convert " + folder_.file("0.vtu") + " " + next + " --order 2").exit_code, 0) << next;
    const ShellResult r = run("verify --json " + stl + " " + next);
    EXPECT_EQ(r.exit_code, 0) << r.err;
    EXPECT_EQ(json::parse(r.out)["triangles_in_file"], 160);
  }
  const Result<LabelledTetMesh> m = read_labelled_tets(folder_.file("1.msh"));
  ASSERT_TRUE(m.ok());
  EXPECT_EQ(m.value().attributes.regions.names, (std::map<Index, std::string>{{1, "left"}, {2, "right"}}));
  EXPECT_EQ(m.value().attributes.labels.names, (std::map<Index, std::string>{{1, "left"}, {2, "right"}}));
  // A label that is changed is found.
  std::string text = test::read_text(folder_.file("4.mesh"));
  const std::size_t at = text.find("TrianglesP2");
  const std::size_t end = text.find(" 1\n", at);
  ASSERT_NE(end, std::string::npos);
  test::write_text(folder_.file("w.mesh"), text.replace(end, 3, " 2\n"));
  const ShellResult wrong = run("verify --json " + stl + " " + folder_.file("w.mesh"));
  EXPECT_EQ(wrong.exit_code, 4);
  EXPECT_EQ(json::parse(wrong.out)["failures"][0]["rule"], "R7");
  EXPECT_EQ(run("convert " + last + " " + last).exit_code, 2);
}

// The boundary of a VTU goes into a second file, which must not be the input.
TEST_F(Cli, ASecondOutputDoesNotOverwriteTheInput) {
  const std::string in = save("a.off", test::sphere(1));
  ASSERT_EQ(run("mesh " + in + " -o " + folder_.file("o.vtu")).exit_code, 0);
  const std::string boundary = folder_.file("o_boundary.vtp"), before = test::read_text(boundary);
  EXPECT_EQ(run("mesh " + boundary + " -o " + folder_.file("o.vtu")).exit_code, 2);
  EXPECT_EQ(test::read_text(boundary), before);
  EXPECT_EQ(run("mesh " + boundary + " -o " + folder_.file("p.vtu")).exit_code, 0);
}

TEST_F(Cli, InspectSaysEachThingOnce) {
  Surface s = test::sphere(1);
  s.F = s.F.bottomRows(s.F.rows() - 1).eval();
  const std::string open = save("open.off", s), saucer = save("saucer.off", test::saucer()),
                    worm = save("worm.off", test::curled_worm());
  for (const std::string& in : {open, saucer, worm}) {
    const ShellResult r = run("inspect " + in);
    std::istringstream lines(r.out + r.err);
    std::set<std::string> met;
    for (std::string line; std::getline(lines, line);) {
      const std::string sentence = line.substr(std::min<std::size_t>(12, line.size()));
      if (sentence.size() > 12) {
        EXPECT_TRUE(met.insert(sentence).second) << line;
      }
    }
  }
  EXPECT_EQ(run("inspect " + open).exit_code, 3);
  EXPECT_EQ(run("inspect " + saucer).exit_code, 0);
  EXPECT_EQ(run("inspect " + saucer + " --fail-on unclean").exit_code, 0);
  EXPECT_EQ(run("inspect " + saucer + " --fail-on unclean,infeasible").exit_code, 5);
  EXPECT_EQ(run("inspect " + saucer + " --fail-on anything").exit_code, 2);
  EXPECT_EQ(run("inspect " + worm + " --fail-on infeasible --fail-on unclean").exit_code, 0);
}

TEST_F(Cli, InspectPrintsThePointsOfCurves) {
  const std::string in = save("a.off", test::curled_worm());
  const std::string with = run("inspect " + in + " --curves").out, without = run("inspect " + in).out;
  EXPECT_NE(with.find("point 0: "), std::string::npos);
  EXPECT_EQ(without.find("point 0: "), std::string::npos);
}

TEST_F(Cli, InfoTellsStagesAndTheirFigures) {
  const ShellResult r =
      run("mesh " + save("a.off", test::torus()) + " -o " + folder_.file("o.mesh") + " --log-level info");
  for (const char* word : {"info: diagnose: ", "info: improve: ", "flips ", "info: verify: ", " s"})
    EXPECT_NE(r.err.find(word), std::string::npos) << word << r.err;
}

TEST_F(Cli, RepairsOfSurfacesHaveReports) {
  Surface s = test::box(4);  // a face without area
  s.V.row(s.F(40, 0)) = (s.V.row(s.F(40, 1)) + s.V.row(s.F(40, 2))) / 2;
  const std::string in = save("a.off", s), report_to = " --report " + folder_.file("r.json");
  ASSERT_EQ(run("repair " + in + " -o " + folder_.file("o.off") + report_to).exit_code, 0);
  json j = report("r.json");
  EXPECT_EQ(j["status"], "repaired");
  EXPECT_GT(j["moved"]["vertices"], 0);
  EXPECT_EQ(j["moved"]["ids"].size(), j["moved"]["vertices"]);
  EXPECT_EQ(j["options"]["max_move"], 6);
  const ShellResult r =
      run("repair " + folder_.file("absent.off") + " -o " + folder_.file("p.off") + report_to);
  EXPECT_EQ(r.exit_code, 7);
  j = report("r.json");
  EXPECT_EQ(j["status"], "failed");
  EXPECT_EQ("overtet: " + j["message"].get<std::string>() + "\n", r.err);
}

TEST_F(Cli, EmbedWritesTheSurfaceWithoutCrossings) {
  const Surface s = test::elbow(150, 16);
  const std::string in = save("elbow.off", s), out = folder_.file("u.off"),
                    report_to = " --report " + folder_.file("r.json");
  ShellResult r = run("embed " + in + " -o " + out + report_to);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.err.find("no faces intersect"), std::string::npos) << r.err;
  json j = report("r.json");
  EXPECT_EQ(j["status"], "embedded");
  EXPECT_GT(j["embedding"]["area"]["p01"], 0.3);
  EXPECT_GT(j["moved"]["vertices"], 0);
  // Of the very numbers that were written.
  const Result<Surface> written = read_surface(out);
  ASSERT_TRUE(written.ok());
  EXPECT_EQ(written.value().F, s.F);
  EXPECT_EQ(json::parse(run("inspect --json " + out).out)["verdict"], "embedded");

  r = run("embed " + in + " -o " + out + " --json");
  EXPECT_EQ(json::parse(r.out)["embedding"], j["embedding"]);
  EXPECT_EQ(run("embed " + in + " -o " + in).exit_code, 2);
  EXPECT_EQ(run("embed " + in + " -o " + folder_.file("u.mesh")).exit_code, 2);
  Surface open = s;
  open.F.conservativeResize(s.F.rows() - 1, 3);
  EXPECT_EQ(run("embed " + save("open.off", open) + " -o " + folder_.file("v.off") + report_to).exit_code, 3);
  EXPECT_FALSE(std::filesystem::exists(folder_.file("v.off")));
  EXPECT_EQ(report("r.json")["status"], "bad-input");
}

TEST_F(Cli, AMissingHelperIsExplained) {
  const std::string program = folder_.file("overtet");
  std::filesystem::copy_file(OVERTET_PROGRAM, program);
  const ShellResult r =
      shell(program + " mesh " + save("s.off", test::curled_worm()) + " -o " + folder_.file("o.mesh"));
  EXPECT_EQ(r.exit_code, 7);
  expect_one_line(r);
  EXPECT_NE(r.err.find("overtet-tetgen"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find(folder_.path()), std::string::npos) << r.err;
}

TEST_F(Cli, UsageErrors) {
  const std::string in = save("a.off", test::sphere(1));
  const std::string out = folder_.file("o.mesh");
  for (const std::string& words : std::vector<std::string>{
           "", "dance", "mesh", "mesh " + in, "mesh " + in + " -o " + out + " --frobnicate",
           "mesh " + in + " -o " + folder_.file("o.xyz"), "mesh " + in + " -o " + out + " --format abc",
           "mesh " + in + " -o " + out + " --threads 0", "mesh " + in + " -o " + out + " --time-limit -3",
           "mesh " + in + " -o " + in + " --format medit", "mesh " + in + " -o " + out + " --report " + out,
           "mesh " + in + " -o " + out + " --preset best"}) {
    const ShellResult r = run(words);
    EXPECT_EQ(r.exit_code, 2) << words;
    expect_one_line(r);
  }
  EXPECT_EQ(folder_.entries(), 1);
}

TEST_F(Cli, MeshesACleanSurface) {
  const std::string in = save("a.off", test::torus());
  const ShellResult r =
      run("mesh " + in + " -o " + folder_.file("o.mesh") + " --report " + folder_.file("r.json"));
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(r.out, "");
  EXPECT_EQ(r.err.find('\r'), std::string::npos);
  EXPECT_EQ(folder_.entries(), 3);
  const json j = report("r.json");
  EXPECT_EQ(j["status"], "exact");
  EXPECT_EQ(j["input"]["vertices"], 512);
  EXPECT_EQ(j["input"]["faces"], 1024);
  EXPECT_EQ(j["input"]["genus"], json::array({1}));
  EXPECT_EQ(j["input"]["pairs"], 0);
  EXPECT_GT(j["quality"]["tets"], 1000);
  EXPECT_GT(j["quality"]["dihedral_min"], 1.0);
  EXPECT_GT(j["peak_rss_bytes"], 1 << 20);
  EXPECT_EQ(j["result_hash"].get<std::string>().size(), 16u);
  std::vector<std::string> stages;
  for (const json& s : j["stages"]) {
    stages.push_back(s["name"]);
    EXPECT_TRUE(s["seconds"].is_number() && s["cpu_seconds"].is_number() && s["iterations"].is_number());
  }
  EXPECT_EQ(stages, (std::vector<std::string>{"read", "diagnose", "tet_mesh", "improve", "set_apart",
                                              "verify", "measure", "label", "write"}));
  EXPECT_EQ(j["quality"]["coincident_vertices"], 0);
  EXPECT_GT(j["quality"]["closest_pair"], 1e-6);

  EXPECT_EQ(run("verify " + in + " " + folder_.file("o.mesh")).exit_code, 0);
  const ShellResult other =
      run("verify --json " + save("b.off", test::torus(32, 16, 1, 0.41)) + " " + folder_.file("o.mesh"));
  EXPECT_EQ(other.exit_code, 4);
  EXPECT_EQ(json::parse(other.out)["failures"][0]["rule"], "R2");

  const ShellResult quiet = run("mesh " + in + " -q -o " + folder_.file("o.vtu"));
  EXPECT_EQ(quiet.exit_code, 0);
  EXPECT_EQ(quiet.err, "");
}

TEST_F(Cli, Sizes) {
  const std::string in = save("a.off", test::sphere(3)), out = folder_.file("o.mesh");
  const auto tets = [&](const std::string& options) {
    const ShellResult r =
        run("mesh " + in + " -o " + out + " --report " + folder_.file("r.json") + " " + options);
    EXPECT_EQ(r.exit_code, 0) << options << r.err;
    EXPECT_EQ(run("verify " + in + " " + out).exit_code, 0) << options;
    return report("r.json")["quality"]["tets"].get<int>();
  };
  const int plain = tets("");
  EXPECT_GT(tets("--max-edge 0.2"), plain);
  EXPECT_EQ(report("r.json")["options"]["max_edge"], 0.2);
  EXPECT_GT(tets("--max-volume 1e-3"), plain);
  EXPECT_LE(tets("--coarse"), plain);
  const std::size_t vertices = report("r.json")["input"]["vertices"];
  const std::string file = folder_.file("sizes.txt");
  std::string numbers = "# of each vertex\n";
  for (std::size_t v = 0; v < vertices; ++v) numbers += v % 2 ? "0\n" : "0.2 ";
  test::write_text(file, numbers);
  EXPECT_GT(tets("--size " + file), plain);

  const auto fails = [&](const std::string& options, int code) {
    const ShellResult r = run("mesh " + in + " -o " + out + " " + options);
    EXPECT_EQ(r.exit_code, code) << options;
    expect_one_line(r);
  };
  fails("--max-edge 0", 2);
  fails("--max-edge 1 --improve 0", 2);
  fails("--size " + folder_.file("none.txt"), 7);
  test::write_text(file, "0.1 -2");
  fails("--size " + file, 3);
  test::write_text(file, "0.1 0.1");
  fails("--size " + file, 2);
}

TEST_F(Cli, AReportThatIsNotValidIsNoticed) {
  const TemporaryFolder folder;
  const std::string in = save("a.off", test::sphere(1)), path = folder.file("r.json");
  ASSERT_EQ(run("mesh " + in + " -o " + folder_.file("o.mesh") + " --report " + path).exit_code, 0);
  ASSERT_EQ(test::wrong_with_reports(test::reports_in(folder.path())), "");
  const json good = json::parse(test::read_text(path));
  for (const char* key : {"status", "stages", "quality", "result_hash"}) {
    json bad = good;
    bad.erase(key);
    test::write_text(path, bad.dump());
    EXPECT_NE(test::wrong_with_reports({path}), "") << "without " << key;
  }
  json bad = good;
  bad["status"] = "infeasible";  // without a witness
  test::write_text(path, bad.dump());
  EXPECT_NE(test::wrong_with_reports({path}), "");
}

TEST_F(Cli, EveryFormatIsAccepted) {
  const std::string in = save("a.ply", test::sphere(2));
  for (const std::string& words : std::vector<std::string>{
           "o.mesh", "o.msh", "o.vtu", "o.node", "o2.msh --format msh22", "strange.name --format medit"}) {
    const ShellResult r = run("mesh " + in + " -o " + folder_.file(words));
    EXPECT_EQ(r.exit_code, 0) << words << ": " << r.err;
    if (words[0] == 'o') {
      EXPECT_EQ(run("verify " + in + " " + folder_.file(words.substr(0, words.find(' ')))).exit_code, 0)
          << words;
    }
  }
  EXPECT_TRUE(exists("o.ele"));
}

TEST_F(Cli, SurfacesWithoutVertexNumbersAreComparedByCoordinates) {
  const Surface s = test::sphere(1);
  std::string stl = "solid sphere\n";
  for (Eigen::Index f = 0; f < s.F.rows(); ++f) {
    stl += "facet normal 0 0 0\nouter loop\n";
    for (int k = 0; k < 3; ++k) {
      stl += "vertex";
      for (int c = 0; c < 3; ++c) stl += " " + std::to_string(s.V(s.F(f, k), c));
      stl += "\n";
    }
    stl += "endloop\nendfacet\n";
  }
  test::write_text(folder_.file("a.stl"), stl + "endsolid sphere\n");
  const ShellResult made = run("mesh " + folder_.file("a.stl") + " -o " + folder_.file("o.mesh"));
  EXPECT_EQ(made.exit_code, 0) << made.err;
  EXPECT_NE(made.err.find("merged"), std::string::npos) << made.err;
  EXPECT_EQ(run("verify " + folder_.file("a.stl") + " " + folder_.file("o.mesh")).exit_code, 0);
  EXPECT_EQ(run("verify " + save("b.off", s) + " " + folder_.file("o.mesh")).exit_code, 4);
}

TEST_F(Cli, SameBytesOnAnyNumberOfThreads) {
  const std::string in =
      save("a.off", test::transformed(test::sphere(3), test::some_rotation(3), Eigen::Vector3d(1, 2, 3)));
  std::string first;
  for (const int threads : {1, 2, 3, 8}) {
    const ShellResult r =
        run("mesh " + in + " -o " + folder_.file("o.mesh") + " --threads " + std::to_string(threads));
    ASSERT_EQ(r.exit_code, 0) << r.err;
    const std::string bytes = test::read_text(folder_.file("o.mesh"));
    if (first.empty()) first = bytes;
    EXPECT_EQ(bytes, first) << threads << " threads";
  }
}

TEST_F(Cli, BadInput) {
  Surface open = test::sphere(1);
  open.F.conservativeResize(open.F.rows() - 1, 3);
  const std::string in = save("open.off", open);
  const ShellResult r =
      run("mesh " + in + " -o " + folder_.file("o.mesh") + " --report " + folder_.file("r.json"));
  EXPECT_EQ(r.exit_code, 3);
  expect_one_line(r);
  EXPECT_FALSE(exists("o.mesh"));
  EXPECT_EQ(report("r.json")["status"], "bad-input");
  EXPECT_EQ(run("inspect " + in).exit_code, 3);

  test::write_text(folder_.file("b.off"), "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 zero\n3 0 1 2\n");
  const ShellResult malformed = run("mesh " + folder_.file("b.off") + " -o " + folder_.file("o.mesh"));
  EXPECT_EQ(malformed.exit_code, 3);
  EXPECT_NE(malformed.err.find("line 5"), std::string::npos) << malformed.err;
  expect_one_line(malformed);
}

// A broken installation is nobody's input's fault: a helper that cannot be started is an internal error.
TEST_F(Cli, BrokenInstallationIsAnInternalError) {
  namespace fs = std::filesystem;
  const std::string program = folder_.file("overtet"), helper = folder_.file("overtet-tetgen");
  fs::copy_file(OVERTET_PROGRAM, program);
  std::ofstream(helper) << "no program";
  fs::permissions(helper, fs::perms::owner_all);
  const ShellResult r =
      shell(program + " mesh " + save("s.off", test::curled_worm()) + " -o " + folder_.file("o.mesh"));
  EXPECT_EQ(r.exit_code, 70);
  EXPECT_NE(r.err.find("overtet-tetgen"), std::string::npos) << r.err;
  EXPECT_FALSE(exists("o.mesh"));
}

TEST_F(Cli, Infeasible) {
  const std::string in = save("saucer.off", test::saucer());
  const ShellResult r =
      run("mesh " + in + " -o " + folder_.file("o.mesh") + " --report " + folder_.file("r.json"));
  EXPECT_EQ(r.exit_code, 5);
  expect_one_line(r);
  EXPECT_FALSE(exists("o.mesh"));
  const json j = report("r.json");
  EXPECT_EQ(j["status"], "infeasible");
  EXPECT_EQ(j["input"]["winding_min"], -1);
  ASSERT_EQ(j["witness"]["point"].size(), 3u);
  EXPECT_EQ(j["witness"]["winding"], -1);
  const ShellResult inspected = run("inspect --json " + in);
  EXPECT_EQ(inspected.exit_code, 0);
  EXPECT_EQ(json::parse(inspected.out)["witness"]["winding"], -1);
}

// Whoever reads the witness must not take the hinges for a point or a vertex that proves something by itself.
TEST_F(Cli, RepairMakesAMeshOrASurface) {
  Surface s = test::box(4);  // a face without area
  s.V.row(s.F(40, 0)) = (s.V.row(s.F(40, 1)) + s.V.row(s.F(40, 2))) / 2;
  const std::string in = save("a.off", s);
  const std::string mesh = folder_.file("o.mesh"), surface = folder_.file("o.off");
  ShellResult r = run("repair " + in + " -o " + mesh + " --report " + folder_.file("r.json"));
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const json j = report("r.json");
  EXPECT_EQ(j["status"], "repaired");
  EXPECT_EQ(j["moved"]["ids"].size(), j["moved"]["vertices"].get<std::size_t>());
  EXPECT_GT(j["moved"]["mean_relative"], 0.0);
  EXPECT_LE(j["moved"]["mean_relative"], j["moved"]["max_relative"]);
  EXPECT_LE(j["moved"]["angles"]["least"], j["moved"]["angles"]["bound_as_moved"].get<double>() + 1e-9);
  const std::string message = j["message"];
  for (const char* part : {" s (", "the rest ", "smallest dihedral angle there "})
    EXPECT_NE(message.find(part), std::string::npos) << message;
  r = run("repair " + in + " -o " + surface + " --surface-only");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(run("verify " + surface + " " + mesh).exit_code, 0);
  EXPECT_EQ(run("repair " + in + " -o " + surface).exit_code, 0);
  EXPECT_EQ(run("repair " + in + " -o " + mesh + " --surface-only").exit_code, 2);
  EXPECT_EQ(run("repair " + in + " -o " + surface + " --report " + surface).exit_code, 2);
}

// Labels of the file, when faces were left out, subdivided or moved.
TEST_F(Cli, LabelsGoWithTheSurfaceWhateverIsDoneToIt) {
  const std::string in = folder_.file("in.off"), mesh = folder_.file("o.vtu");
  const Surface s = test::obstructed_elbow(0);
  Labels labels;
  for (Index f = 0; f < s.F.rows(); ++f) labels.of.push_back(7 + f % 3);
  for (const char* name : {"s.off", "s.ply"}) {
    const std::string surface = folder_.file(name);
    // With a face that is there twice and a vertex that none has.
    Surface raw = s;
    raw.V.conservativeResize(s.V.rows() + 1, 3);
    raw.V.row(s.V.rows()).setZero();
    raw.F.conservativeResize(s.F.rows() + 1, 3);
    raw.F.row(s.F.rows()) = raw.F.row(1);
    Labels with_copy = labels;
    with_copy.of.push_back(99);
    ASSERT_TRUE(write_surface(in, raw, SurfaceFormat::off, {}, &with_copy).ok());
    for (const std::string how : {"refine", "branch", "repair"}) {
      const ShellResult r =
          run("mesh " + in + " -o " + mesh + " --on-infeasible " + how + " --save-surface " + surface +
              " --save-cleaned " + folder_.file("c.off") + " --report " + folder_.file("r.json"));
      ASSERT_EQ(r.exit_code, 0) << r.err;
      const Result<LabelledTetMesh> made = read_labelled_tets(mesh);
      ASSERT_TRUE(made.ok());
      std::vector<Index> expected = labels.of;
      if (how == "refine") {
        expected.clear();
        const json refined = report("r.json")["refined"];
        for (const Index f : refined["faces"]) expected.push_back(labels.of[static_cast<std::size_t>(f)]);
      }
      EXPECT_EQ(made.value().attributes.labels.of, expected) << how;
      SurfaceReadInfo info;
      ASSERT_TRUE(read_surface(folder_.file("c.off"), &info).ok());
      EXPECT_EQ(info.attributes.faces.of, labels.of);
      ASSERT_TRUE(read_surface(surface, &info).ok());
      EXPECT_EQ(info.attributes.faces.of, expected) << how;
      EXPECT_EQ(run("verify --allow-branches " + surface + " " + mesh).exit_code, 0) << how;
    }
  }
}

TEST_F(Cli, ThePapersRecipeSaysWhatIsNotExact) {
  const std::string in = save("elbow.off", test::elbow(150, 16)), mesh = folder_.file("o.mesh");
  const std::string common = "mesh " + in + " -o " + mesh + " --report " + folder_.file("r.json");
  ShellResult r = run(common + " --preset paper --map arap");
  EXPECT_EQ(r.exit_code, 4);
  EXPECT_NE(r.err.find("flipped"), std::string::npos) << r.err;
  EXPECT_FALSE(std::filesystem::exists(mesh));
  EXPECT_EQ(report("r.json")["options"]["improve"], 0);

  // It is written, and no script takes it for a mesh.
  r = run(common + " --preset paper --map arap --allow-flips");
  EXPECT_EQ(r.exit_code, 4);
  EXPECT_NE(r.err.find("not positive"), std::string::npos) << r.err;
  EXPECT_TRUE(std::filesystem::exists(mesh));
  EXPECT_EQ(report("r.json")["status"], "flipped");
  EXPECT_FALSE(report("r.json")["flipped_tets"].empty());
  EXPECT_EQ(run("verify " + in + " " + mesh).exit_code, 4);

  for (const char* words : {" --map lim", " --forward global", " --preset flow --reverse pins",
                            " --allow-flips", " --allow-branches", " --preset paper --map none",
                            " --map patch", " --preset flow --map lim", " --preset paper --map patch"})
    EXPECT_EQ(run(common + words).exit_code, 2) << words;
}

TEST_F(Cli, RefinesAndBranchesOnRequest) {
  const std::string in = save("elbow.off", test::obstructed_elbow(0));
  const std::string mesh = folder_.file("o.mesh"), surface = folder_.file("s.off");
  const std::string common = "mesh " + in + " -o " + mesh + " --report " + folder_.file("r.json");
  // What would help is said, and nothing promised.
  ShellResult r = run(common);
  EXPECT_EQ(r.exit_code, 5);
  for (const char* word : {"repair", "refine", "branch", "not ruled out"})
    EXPECT_NE(r.err.find(word), std::string::npos) << r.err;
  const ShellResult saucer = run("mesh " + save("saucer.off", test::saucer(2)) + " -o " + mesh);
  EXPECT_EQ(saucer.exit_code, 5);
  EXPECT_NE(saucer.err.find("would not help"), std::string::npos) << saucer.err;

  r = run(common + " --on-infeasible refine --save-surface " + surface);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  json j = report("r.json");
  EXPECT_EQ(j["status"], "refined");
  EXPECT_EQ(j["refined"]["faces"].size(), read_surface(surface).value().F.rows());
  EXPECT_EQ(run("verify " + surface + " " + mesh).exit_code, 0);
  EXPECT_EQ(run("verify " + in + " " + mesh).exit_code, 4);

  r = run(common + " --on-infeasible branch --save-surface " + surface);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  j = report("r.json");
  EXPECT_EQ(j["status"], "branched");
  EXPECT_EQ(read_surface(surface).value().V, read_surface(in).value().V);
  EXPECT_EQ(run("verify " + in + " " + mesh).exit_code, 4);
  EXPECT_EQ(run("verify " + in + " " + mesh + " --allow-branches").exit_code, 0);
  const json checked = json::parse(run("verify --json --allow-branches " + in + " " + mesh).out);
  EXPECT_EQ(checked["branch_edges"], j["branch_edges"]);
  EXPECT_FALSE(j["branch_edges"].empty());

  for (const std::string& words :
       {common + " --on-infeasible refine --save-stages " + folder_.file("stages"),
        common + " --on-infeasible branch --resume " + folder_.path(), common + " --save-surface " + in,
        common + " --save-surface " + mesh, common + " --save-surface s.xyz"})
    EXPECT_EQ(run(words).exit_code, 2) << words;
}

TEST_F(Cli, UnpairedHingesAreInfeasible) {
  const std::string in = save("elbow.off", test::obstructed_elbow(0));
  const ShellResult r =
      run("mesh " + in + " -o " + folder_.file("o.mesh") + " --report " + folder_.file("r.json"));
  EXPECT_EQ(r.exit_code, 5);
  expect_one_line(r);
  const json w = report("r.json")["witness"];
  EXPECT_EQ(w["rule"], "unpaired");
  EXPECT_EQ(w["vertices"].size() % 2, 1u);
  EXPECT_EQ(w["B0"].size(), w["vertices"].size());
  EXPECT_EQ(w["positions"].size(), w["vertices"].size());
  EXPECT_FALSE(w.contains("vertex") || w.contains("point"));
  const ShellResult inspected = run("inspect --json " + in);
  EXPECT_EQ(inspected.exit_code, 0);
  EXPECT_EQ(json::parse(inspected.out)["witness"], w);
}

TEST_F(Cli, InspectSpeaksTextAndJson) {
  const std::string in = save("a.obj", test::two_spheres());
  const ShellResult text = run("inspect " + in);
  EXPECT_EQ(text.exit_code, 0);
  EXPECT_NE(text.out.find("genus 0"), std::string::npos);
  const ShellResult r = run("inspect --json --pairs " + in);
  const json j = json::parse(r.out);
  EXPECT_EQ(j["components"].size(), 2u);
  EXPECT_GT(j["pairs"], 10);
  EXPECT_EQ(j["pair_list"].size(), j["pairs"].get<std::size_t>());
  EXPECT_EQ(j["winding_max"], 2);
  EXPECT_EQ(j["winding_min"], 0);
}

// The numbers between a tag that holds `name` and its end.
std::vector<double> numbers_of(const std::string& vtp, const std::string& name) {
  const std::size_t tag = vtp.find(name), begin = vtp.find('>', tag) + 1, end = vtp.find("</", begin);
  EXPECT_NE(tag, std::string::npos) << name;
  std::istringstream in(vtp.substr(begin, end - begin));
  std::vector<double> out;
  for (double x; in >> x;) out.push_back(x);
  return out;
}

TEST_F(Cli, CurvesAreSavedForOtherPrograms) {
  for (const Surface& s : {test::two_spheres(), test::elbow(150, 14), test::sphere(1)}) {
    const std::string in = save("a.off", s), vtp = folder_.file("c.vtp"), obj = folder_.file("c.obj");
    const ShellResult r = run("inspect --json --curves " + in + " --save-curves " + vtp);
    ASSERT_EQ(r.exit_code, 0) << r.err;
    ASSERT_EQ(run("inspect " + in + " --save-curves " + obj).exit_code, 0);
    const json curves = json::parse(r.out)["curves"];
    std::vector<double> points, faces, winding;
    std::size_t segments = 0;
    for (const json& c : curves) {
      for (const json& p : c["points"])
        for (const json& x : p["position"]) points.push_back(x);
      for (const json& pair : c["faces"])
        for (const json& f : pair) faces.push_back(f);
      for (const json& w : c["winding"]) winding.push_back(w[0]);
      segments += c["segments"].get<std::size_t>();
    }
    const std::string text = test::read_text(vtp);
    EXPECT_EQ(numbers_of(text, "Name=\"Points\""), points);
    EXPECT_EQ(numbers_of(text, "Name=\"faces\""), faces);
    EXPECT_EQ(numbers_of(text, "Name=\"winding_min\""), winding);
    const auto cells = numbers_of(text, "Name=\"connectivity\""),
               offsets = numbers_of(text, "Name=\"offsets\"");
    EXPECT_EQ(cells.size(), 2 * segments);
    EXPECT_EQ(offsets.size(), segments);
    for (std::size_t i = 0; i < offsets.size(); ++i) EXPECT_EQ(offsets[i], 2.0 * static_cast<double>(i + 1));
    for (const double cell : cells) EXPECT_LT(cell, static_cast<double>(points.size()) / 3);
    for (const char* name : {"curve", "closed", "crossing", "winding_max"})
      EXPECT_EQ(numbers_of(text, "Name=\"" + std::string(name) + "\"").size(), segments);
    EXPECT_EQ(numbers_of(text, "Name=\"barycentric_1\"").size(), points.size());

    std::istringstream lines(test::read_text(obj));
    std::vector<double> read;
    std::vector<std::vector<std::size_t>> polylines;
    for (std::string line; std::getline(lines, line);) {
      std::istringstream words(line);
      std::string key;
      words >> key;
      if (key == "v")
        for (double x; words >> x;) read.push_back(x);
      if (key == "l") {
        polylines.emplace_back();
        for (std::size_t i; words >> i;) polylines.back().push_back(i);
      }
    }
    EXPECT_EQ(read, points);
    ASSERT_EQ(polylines.size(), curves.size());
    for (std::size_t c = 0; c < curves.size(); ++c) {
      EXPECT_EQ(polylines[c].size(), curves[c]["segments"].get<std::size_t>() + 1);
      EXPECT_EQ(polylines[c].front() == polylines[c].back(), curves[c]["closed"].get<bool>());
      for (const std::size_t i : polylines[c]) EXPECT_TRUE(i >= 1 && 3 * i <= read.size());
    }
  }
  const std::string in = save("a.off", test::sphere(1));
  EXPECT_EQ(run("inspect " + in + " --save-curves " + folder_.file("c.stl")).exit_code, 2);
  EXPECT_EQ(run("inspect " + in + " --save-curves " + folder_.file("no/such/c.vtp")).exit_code, 7);
}

TEST_F(Cli, InspectShowsHinges) {
  const std::string in = save("a.off", test::elbow(150, 14));
  const json j = json::parse(run("inspect --json " + in).out);
  ASSERT_FALSE(j["hinges"].empty());
  for (const json& h : j["hinges"]) {
    EXPECT_EQ(h["position"].size(), 3u);
    EXPECT_FALSE(h["crossings"].empty());
    ASSERT_GE(h["edges"].size(), 3u);
    for (const json& e : h["edges"]) EXPECT_FALSE(e["levels"].empty());
  }
  EXPECT_FALSE(j["wound_edges"].empty());
  const std::string text = run("inspect " + in).out;
  for (const char* word : {"hinges", "levels", "wound", "curves", "from vertex"})
    EXPECT_NE(text.find(word), std::string::npos) << word;
}

TEST_F(Cli, FilesThatCannotBeReadOrWritten) {
  const std::string in = save("a.off", test::sphere(1));
  for (const std::string& words :
       std::vector<std::string>{"mesh " + folder_.file("absent.off") + " -o " + folder_.file("o.mesh"),
                                "mesh " + folder_.path() + " -o " + folder_.file("o.mesh"),
                                "mesh " + in + " -o " + folder_.file("no/such/o.mesh"),
                                "mesh " + in + " --format medit -o " + folder_.path(),
                                "mesh " + in + " --format medit -o /dev/full",
                                "verify " + in + " " + folder_.file("absent.mesh")}) {
    const ShellResult r = run(words);
    EXPECT_EQ(r.exit_code, 7) << words << ": " << r.err;
    expect_one_line(r);
  }
  EXPECT_EQ(run("inspect " + in + " > /dev/full").exit_code, 7);
  EXPECT_EQ(folder_.entries(), 1);
}

TEST_F(Cli, TimeLimit) {
  const std::string in = save("a.ply", test::sphere(6));
  const ShellResult r = run("mesh " + in + " -o " + folder_.file("o.mesh") + " --report " +
                            folder_.file("r.json") + " --time-limit 1e-9");
  EXPECT_EQ(r.exit_code, 6);
  expect_one_line(r);
  EXPECT_FALSE(exists("o.mesh"));
  EXPECT_EQ(report("r.json")["status"], "limit");
  EXPECT_EQ(folder_.entries(), 2);
}

TEST_F(Cli, MemoryLimit) {
  const std::string in = save("a.ply", test::sphere(6));
  for (const char* limit : {"1", "60"}) {
    const ShellResult r = run("mesh " + in + " -o " + folder_.file("o.mesh") + " --memory-limit " + limit);
    EXPECT_EQ(r.exit_code, 6) << limit;
    expect_one_line(r);
    EXPECT_NE(r.err.find("memory"), std::string::npos) << r.err;
    EXPECT_EQ(folder_.entries(), 1);
  }
}

TEST_F(Cli, WhatIsFreeIsTheMemoryLimitUnlessOneIsGiven) {
  const std::size_t usable = usable_memory_bytes();
  EXPECT_GT(usable, std::size_t{16} << 20);
  EXPECT_LE(usable, static_cast<std::size_t>(sysconf(_SC_PHYS_PAGES)) * sysconf(_SC_PAGESIZE));
  Terminal terminal(LogLevel::error, Terminal::Talk::errors_only);
  CommonOptions options;
  const std::size_t limit = options.context(terminal).memory_limit_bytes;
  EXPECT_GT(limit, usable / 2);
  EXPECT_LT(limit, usable + usable / 4);
  options.memory_limit = 100;
  EXPECT_EQ(options.context(terminal).memory_limit_bytes, std::size_t{100} << 20);
}

TEST_F(Cli, InterruptsLeaveNothingBehind) {
  const std::string in = save("a.ply", test::box(80));  // grids are left to TetGen
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    const TemporaryFolder logs;
    test::Process p(
        {OVERTET_PROGRAM, "mesh", in, "-o", folder_.file("o.mesh"), "--report", folder_.file("r.json")},
        logs.path());
    // In the middle of the work: when the child that meshes is there.
    std::vector<pid_t> children;
    for (int i = 0; i < 2000 && children.empty(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      children = p.children();
    }
    ASSERT_FALSE(children.empty());
    p.signal(number);
    const std::optional<int> code = p.wait(20);
    ASSERT_TRUE(code.has_value());
    EXPECT_EQ(*code, 128 + number);
    EXPECT_EQ(test::read_text(logs.file("err")), "overtet: Interrupted; nothing was written.\n");
    for (const pid_t child : children) {
      for (int i = 0; i < 400 && test::is_running(child); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      EXPECT_FALSE(test::is_running(child));
    }
    EXPECT_EQ(folder_.entries(), 1);
  }
}

// Named pipes. Opening one waits for the other end, writing to it for who reads, and what waits there heeds
// no flag.

class CliPipes : public Cli {
 protected:
  std::string pipe(const std::string& name) {
    const std::string path = folder_.file(name);
    EXPECT_EQ(mkfifo(path.c_str(), 0600), 0);
    return path;
  }
  std::unique_ptr<test::Process> start(std::vector<std::string> words) {
    words.insert(words.begin(), OVERTET_PROGRAM);
    return std::make_unique<test::Process>(words, logs_.path());
  }
  std::string said() const { return test::read_text(logs_.file("err")); }
  template <class Condition>
  static bool wait_until(Condition&& condition) {
    for (int i = 0; i < 12000; ++i) {
      if (condition()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
  }
  static bool heeds_signals(pid_t process) {
    std::ifstream in("/proc/" + std::to_string(process) + "/status");
    for (std::string line; std::getline(in, line);)
      if (line.rfind("SigCgt:", 0) == 0)
        return (std::stoull(line.substr(7), nullptr, 16) & (1ull << (SIGTERM - 1))) != 0;
    return false;
  }
  // A pipe to read from that holds next to nothing.
  static int narrow_reader(const std::string& path) {
    const int reader = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    EXPECT_GE(fcntl(reader, F_SETPIPE_SZ, 4096), 4096);
    return reader;
  }
  // Until something is in the pipe. It holds less than the file: who writes to it waits soon, if not yet.
  static bool fills(int reader) {
    return wait_until([&] {
      int waiting = 0;
      return ioctl(reader, FIONREAD, &waiting) == 0 && waiting > 0;
    });
  }
  const TemporaryFolder logs_;
};

TEST_F(CliPipes, AnOutputPipeThatNothingReadsFromHung) {
  const std::string in = save("a.off", test::sphere(1));
  for (const std::string& words :
       {"mesh " + in + " -o " + pipe("o.mesh"),
        "mesh " + in + " -o " + folder_.file("p.mesh") + " --report " + pipe("r.json"),
        "repair " + in + " -o " + pipe("o.off"), "inspect " + in + " --save-curves " + pipe("c.obj")}) {
    const ShellResult r = run(words);
    EXPECT_EQ(r.exit_code, 7) << words;
    expect_one_line(r);
    EXPECT_NE(r.err.find("nothing reads from"), std::string::npos) << r.err;
  }
  EXPECT_FALSE(exists("p.mesh"));
}

TEST_F(CliPipes, AnOutputPipeGetsTheWholeFile) {
  const std::string in = save("a.off", test::sphere(3)), out = pipe("o.mesh"), report = pipe("r.json");
  ASSERT_EQ(run("mesh " + in + " -o " + folder_.file("file.mesh")).exit_code, 0);
  const ShellResult r = shell("cat " + out + " > " + folder_.file("copy.mesh") + " & cat " + report + " > " +
                              folder_.file("copy.json") + " & " + OVERTET_PROGRAM + " mesh " + in + " -o " +
                              out + " --report " + report + " && wait");
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(test::read_text(folder_.file("copy.mesh")), test::read_text(folder_.file("file.mesh")));
  EXPECT_EQ(this->report("copy.json")["status"], "exact");
}

TEST_F(CliPipes, AnOutputPipeWhoseReaderGoesAwayIsAnError) {
  const std::string in = save("a.off", test::sphere(3)), out = pipe("o.mesh");
  const int reader = narrow_reader(out);
  const auto p = start({"mesh", in, "-o", out});
  ASSERT_TRUE(fills(reader));
  ::close(reader);
  EXPECT_EQ(p->wait(60), 7);
  EXPECT_NE(said().find("Cannot write " + out), std::string::npos) << said();
}

TEST_F(CliPipes, AnOutputPipeThatIsNotReadIgnoredSignals) {
  const std::string in = save("a.off", test::sphere(3)), out = pipe("o.mesh");
  for (const int number : {SIGTERM, SIGINT}) {
    const int reader = narrow_reader(out);
    const auto p = start({"mesh", in, "-o", out});
    ASSERT_TRUE(fills(reader));
    p->signal(number);
    EXPECT_EQ(p->wait(60), 128 + number);
    EXPECT_EQ(said().rfind("overtet: Interrupted", 0), 0u) << said();
    ::close(reader);
  }
}

TEST_F(CliPipes, AnInputPipeThatNothingComesFromHeedsSignals) {
  const std::string in = pipe("a.off"), other = pipe("a.mesh");
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"mesh", in, "-o", folder_.file("o.mesh")},
                                             {"repair", in, "-o", folder_.file("o.off")},
                                             {"inspect", in},
                                             {"verify", in, other}}) {
    for (const bool writer : {false, true}) {
      const int end = writer ? ::open(in.c_str(), O_RDWR | O_CLOEXEC) : -1;
      const auto p = start(words);
      ASSERT_TRUE(wait_until([&] { return heeds_signals(p->id()); }));
      p->signal(SIGTERM);
      EXPECT_EQ(p->wait(60), 128 + SIGTERM) << words[0];
      if (writer) ::close(end);
    }
  }
  EXPECT_EQ(folder_.entries(), 2);
}

TEST_F(CliPipes, AnInputPipeIsRead) {
  const std::string in = save("a.off", test::sphere(1)), through = pipe("p.off");
  const ShellResult r = shell("cat " + in + " > " + through + " & " + OVERTET_PROGRAM + " mesh " + through +
                              " -o " + folder_.file("o.mesh") + " && wait");
  EXPECT_EQ(r.exit_code, 0) << r.err;
}

TEST_F(Cli, AnOldOutputSurvivesAFailure) {
  test::write_text(folder_.file("o.mesh"), "precious");
  EXPECT_EQ(run("mesh " + save("s.off", test::saucer()) + " -o " + folder_.file("o.mesh")).exit_code, 5);
  EXPECT_EQ(test::read_text(folder_.file("o.mesh")), "precious");
}

}  // namespace
}  // namespace overtet
