// Runs the seeds of all targets, and the files with which fuzzing found something (found/, each named after
// what it found), so that no such bug comes back.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "tests/fuzz/targets.h"

namespace overtet::fuzz {
namespace {

using Target = std::pair<const char*, void (*)(std::string_view)>;

#define OVERTET_FUZZ_TARGET(name) \
  Target { #name, name }
const Target kTargets[] = {
    OVERTET_FUZZ_TARGET(obj),     OVERTET_FUZZ_TARGET(off),      OVERTET_FUZZ_TARGET(ply),
    OVERTET_FUZZ_TARGET(stl),     OVERTET_FUZZ_TARGET(gltf),     OVERTET_FUZZ_TARGET(medit),
    OVERTET_FUZZ_TARGET(gmsh),    OVERTET_FUZZ_TARGET(vtk_xml),  OVERTET_FUZZ_TARGET(vtk),
    OVERTET_FUZZ_TARGET(abaqus),  OVERTET_FUZZ_TARGET(tetgen),   OVERTET_FUZZ_TARGET(sizes),
    OVERTET_FUZZ_TARGET(gzip),    OVERTET_FUZZ_TARGET(resume),   OVERTET_FUZZ_TARGET(cleanup),
    OVERTET_FUZZ_TARGET(journal), OVERTET_FUZZ_TARGET(manifest), OVERTET_FUZZ_TARGET(handles)};
#undef OVERTET_FUZZ_TARGET

std::vector<std::filesystem::path> files_in(const std::string& folder) {
  std::vector<std::filesystem::path> files;
  if (std::filesystem::exists(folder))
    for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class Replay : public testing::TestWithParam<Target> {};

TEST_P(Replay, FindsNothing) {
  const auto& [name, run] = GetParam();
  const std::string root = OVERTET_FUZZ_FILES;
  const std::vector<std::filesystem::path> seeds = files_in(root + "/seeds/" + name);
  EXPECT_FALSE(seeds.empty()) << "a target without seeds";
  for (const std::string folder : {"/seeds/", "/found/"})
    for (const std::filesystem::path& file : files_in(root + folder + name)) {
      SCOPED_TRACE(file.string());
      const std::string bytes = bytes_of(file);
      run(bytes);
      // Cut short, and with another byte: what fuzzing would try first.
      for (std::size_t k = 1; k < 8; ++k) {
        run(std::string_view(bytes).substr(0, bytes.size() * k / 8));
        std::string other = bytes;
        if (!other.empty()) other[other.size() * k / 8] ^= static_cast<char>(1 << k % 7);
        run(other);
      }
    }
}

INSTANTIATE_TEST_SUITE_P(, Replay, testing::ValuesIn(kTargets),
                         [](const auto& target) { return std::string(target.param.first); });

// Every folder of files belongs to a target.
TEST(Fuzz, NoFilesWithoutTarget) {
  for (const std::string folder : {"/seeds", "/found"})
    for (const std::filesystem::path& path : files_in(OVERTET_FUZZ_FILES + folder))
      EXPECT_TRUE(std::any_of(std::begin(kTargets), std::end(kTargets), [&](const Target& t) {
        return path.filename() == t.first;
      })) << path;
}

}  // namespace
}  // namespace overtet::fuzz
