// The arrows of the design, read off the include lines: kernels <- stages <- pipeline <- cli, and who may
// name which library.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using Names = std::set<std::string>;

struct Include {
  std::string file, room, what;  // room: "kernels/bvh", "src/io", "include"
};

std::string room_of(const fs::path& relative) {
  auto it = relative.begin();
  const std::string top = it->string();
  if (top == "include") return top;
  return top + "/" + (++it)->string();
}

const std::vector<Include>& includes() {
  static const std::vector<Include> all = [] {
    std::vector<Include> list;
    const fs::path root = OVERTET_SOURCE_DIR;
    const std::regex line_of(R"re(^\s*#\s*include\s*[<"]([^>"]+)[>"])re");
    for (const char* top : {"include", "kernels", "src"})
      for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
        const std::string extension = entry.path().extension().string();
        if (extension != ".h" && extension != ".cpp") continue;
        const fs::path relative = fs::relative(entry.path(), root);
        std::ifstream in(entry.path());
        std::smatch found;
        for (std::string line; std::getline(in, line);)
          if (std::regex_search(line, found, line_of))
            list.push_back({relative.string(), room_of(relative), found[1]});
      }
    return list;
  }();
  return all;
}

// The rooms of this project that a room's files include.
std::map<std::string, Names> rooms_used() {
  std::map<std::string, Names> used;
  for (const Include& i : includes()) {
    used[i.room];
    if (!i.what.starts_with("src/") && !i.what.starts_with("kernels/")) continue;
    const std::string other = room_of(i.what);
    if (other != i.room) used[i.room].insert(other);
  }
  return used;
}

const Names kStages = {"src/forward_flow", "src/reverse_flow", "src/tet_mesh",  "src/volume_map",
                       "src/volume_arap",  "src/lim",          "src/immersion", "src/improve",
                       "src/repair",       "src/labels",       "src/verify",    "src/cleanup",
                       "src/prepare"};
const Names kRoundTheStages = {"src/run",         "src/io",       "src/exact",        "src/mesh",
                               "src/arrangement", "src/covering", "src/certificates", "src/cdt"};

TEST(Layout, SourcesWereFound) { EXPECT_GT(includes().size(), 200u); }

TEST(Layout, KernelsKnowNothingAboveThem) {
  for (const Include& i : includes()) {
    if (!i.room.starts_with("kernels/")) continue;
    EXPECT_FALSE(i.what.starts_with("src/")) << i.file << " includes " << i.what;
    EXPECT_NE(i.what, "overtet/run_context.h") << i.file;
    for (const char* io : {"iostream", "fstream", "filesystem", "nlohmann/json.hpp"})
      EXPECT_NE(i.what, io) << i.file;
  }
}

TEST(Layout, PublicHeadersNeedOnlyTheStandardLibraryAndEigen) {
  for (const Include& i : includes()) {
    if (i.room != "include") continue;
    const bool standard = i.what.find('/') == std::string::npos && i.what.find('.') == std::string::npos;
    EXPECT_TRUE(standard || i.what.starts_with("Eigen/") || i.what.starts_with("overtet/"))
        << i.file << " includes " << i.what;
  }
}

TEST(Layout, StagesNeverIncludeEachOther) {
  for (const auto& [room, others] : rooms_used()) {
    if (!kStages.contains(room)) continue;
    for (const std::string& other : others) {
      if (other.starts_with("kernels/")) continue;
      EXPECT_TRUE(kRoundTheStages.contains(other)) << room << " includes " << other;
    }
  }
}

TEST(Layout, OnlyThePipelineKnowsTheStages) {
  for (const auto& [room, others] : rooms_used())
    for (const std::string& other : others) {
      if (!kStages.contains(other)) continue;
      EXPECT_TRUE(room == "src/pipeline") << room << " includes " << other;
    }
}

TEST(Layout, RoomsRoundTheStagesStandBelowThem) {
  for (const auto& [room, others] : rooms_used()) {
    if (!kRoundTheStages.contains(room)) continue;
    for (const std::string& other : others)
      EXPECT_TRUE(other.starts_with("kernels/") || kRoundTheStages.contains(other))
          << room << " includes " << other;
  }
}

TEST(Layout, OnlyThePublicFunctionsKnowThePipeline) {
  for (const auto& [room, others] : rooms_used())
    for (const std::string& other : others) {
      EXPECT_TRUE(other != "src/pipeline" || room == "src/api") << room;
      EXPECT_NE(other, "src/api") << room;
    }
}

// What the program does, every program can do. Batches are many runs of the program, and part of it.
TEST(Layout, TheProgramIsAClientOfThePublicApi) {
  const std::map<std::string, Names> program = {{"src/cli", {"src/cli", "src/batch"}},
                                                {"src/batch", {"src/batch"}}};
  for (const Include& i : includes()) {
    if (!i.what.starts_with("src/") && !i.what.starts_with("kernels/")) continue;
    const std::string other = room_of(i.what);
    const auto may = program.find(i.room);
    if (may != program.end())
      EXPECT_TRUE(may->second.contains(other)) << i.file << " includes " << i.what;
    else
      EXPECT_FALSE(program.contains(other)) << i.file << " includes " << i.what;
  }
}

TEST(Layout, ThePythonPackageIsAClientOfThePublicApi) {
  const fs::path root = OVERTET_SOURCE_DIR;
  const std::regex line_of(R"re(^\s*#\s*include\s*[<"]([^>"]+)[>"])re");
  int found_includes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(root / "python")) {
    const std::string extension = entry.path().extension().string();
    if (extension != ".h" && extension != ".cpp") continue;
    std::ifstream in(entry.path());
    std::smatch found;
    for (std::string line; std::getline(in, line);)
      if (std::regex_search(line, found, line_of)) {
        ++found_includes;
        const std::string what = found[1];
        EXPECT_FALSE(what.starts_with("src/") || what.starts_with("kernels/"))
            << entry.path() << " includes " << what;
      }
  }
  EXPECT_GT(found_includes, 10);
}

// An option of the program in a message of the library would mean nothing to other programs.
TEST(Layout, TheLibraryNamesNoOptionOfTheProgram) {
  const fs::path root = OVERTET_SOURCE_DIR;
  const std::regex flag(R"re("([^"\\]|\\.)*--[a-z])re");
  for (const char* top : {"include", "kernels", "src"})
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      const std::string file = fs::relative(entry.path(), root).string();
      if (!entry.is_regular_file() || file.starts_with("src/cli/") || file.starts_with("src/batch/"))
        continue;
      const std::string extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp") continue;
      std::ifstream in(entry.path());
      for (std::string line; std::getline(in, line);)
        EXPECT_FALSE(std::regex_search(line, flag)) << file << ": " << line;
    }
}

TEST(Layout, RoomsFormNoCircle) {
  const auto used = rooms_used();
  std::map<std::string, int> state;  // 1: being visited, 2: done
  const auto visit = [&](const auto& self, const std::string& room) -> void {
    state[room] = 1;
    const auto at = used.find(room);
    if (at != used.end())
      for (const std::string& other : at->second) {
        EXPECT_NE(state[other], 1) << room << " and " << other << " include each other";
        if (state[other] == 0) self(self, other);
      }
    state[room] = 2;
  };
  for (const auto& [room, others] : used)
    if (state[room] == 0) visit(visit, room);
}

TEST(Layout, EachLibraryHasOneHome) {
  const std::vector<std::pair<std::regex, std::string>> homes = {
      {std::regex("^(tbb|oneapi)/.*"), "kernels/parallel"},
      {std::regex("^(suitesparse/)?cholmod.*"), "kernels/sparse"},
      {std::regex("^c?cadical.*"), "kernels/sat"},
      {std::regex("^embree.*"), "kernels/bvh"},
      {std::regex("^tetgen\\.h$"), "src/cdt"},
      {std::regex("^zlib\\.h$"), "src/io"},
      {std::regex("^nettle/.*"), "src/batch"},
      {std::regex("^(vtk[A-Z].*|EGL/.*)"), "src/view"},
      {std::regex("^CLI/.*"), "src/cli"}};
  for (const Include& i : includes())
    for (const auto& [library, home] : homes)
      EXPECT_TRUE(i.room == home || !std::regex_match(i.what, library)) << i.file << " includes " << i.what;
}

TEST(Layout, CgalStaysOutOfHeadersThatOthersInclude) {
  Names with_cgal;
  for (const Include& i : includes())
    if (i.what.starts_with("CGAL/") && i.file.ends_with(".h")) with_cgal.insert(i.file);
  for (const Include& i : includes())
    EXPECT_TRUE(!with_cgal.contains(i.what) || room_of(i.what) == i.room) << i.file << " includes " << i.what;
}

TEST(Layout, NothingKnowsThisMachine) {
  const fs::path root = OVERTET_SOURCE_DIR;
  const std::string place = std::string("/") + "work/";
  for (const char* top : {"include", "kernels", "src", "python", "tests", "scripts", "cmake"})
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      if (!entry.is_regular_file()) continue;
      std::ifstream in(entry.path());
      int number = 0;
      for (std::string line; std::getline(in, line);) {
        ++number;
        EXPECT_EQ(line.find(place), std::string::npos) << entry.path() << ":" << number;
      }
    }
}

}  // namespace
