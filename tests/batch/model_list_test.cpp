// Lists of models, their names, and shards.
#include "src/batch/model_list.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>
#include <set>

#include "tests/support/files.h"

namespace overtet {
namespace {

namespace fs = std::filesystem;

std::vector<Model> listed_models(const std::string& text) {
  Result<std::vector<Model>> models = models_of_manifest(text, "dir", "list.txt");
  EXPECT_TRUE(models.ok()) << (models.ok() ? "" : models.error().message);
  return models.ok() ? std::move(models).value() : std::vector<Model>();
}

std::string refusal(const std::string& text) {
  const Result<std::vector<Model>> models = models_of_manifest(text, "dir", "list.txt");
  EXPECT_FALSE(models.ok());
  return models.ok() ? "" : models.error().message;
}

std::vector<std::string> names_of(const std::vector<Model>& models) {
  std::vector<std::string> names;
  for (const Model& m : models) names.push_back(m.name);
  return names;
}

TEST(ModelList, LinesAreRelativeToTheManifest) {
  const auto models = listed_models("# models\n\na.obj\r\nsub/b.off\n/abs/c.ply.gz\n../up/d.stl\n");
  ASSERT_EQ(names_of(models), (std::vector<std::string>{"a", "abs/c", "sub/b", "up/d"}));
  EXPECT_EQ(models[0].path, "dir/a.obj");
  EXPECT_EQ(models[1].path, "/abs/c.ply.gz");
  EXPECT_EQ(models[3].path, "dir/../up/d.stl");
}

TEST(ModelList, NamesDifferAndStayInTheFolder) {
  const auto models =
      listed_models("a.obj\na.off\na.off\n../../etc/x.obj\n/etc/x.obj\n./b.obj\nb.OBJ.gz\na_2.off\n");
  std::set<std::string> names;
  for (const Model& m : models) {
    EXPECT_TRUE(names.insert(m.name).second) << m.name;
    EXPECT_FALSE(m.name.starts_with("/"));
    EXPECT_EQ(m.name.find(".."), std::string::npos);
    EXPECT_FALSE(m.name.empty());
  }
  EXPECT_EQ(models.size(), 8u);
}

TEST(ModelList, JsonLinesCanSayAnything) {
  const auto models =
      listed_models(R"({"input": "odd\nname.obj", "output": "n/1", "options": ["--improve", "20"]})"
                    "\n"
                    R"({"input": "b.off"})"
                    "\n");
  ASSERT_EQ(names_of(models), (std::vector<std::string>{"b", "n/1"}));
  EXPECT_EQ(models[1].path, "dir/odd\nname.obj");
  EXPECT_EQ(models[1].options, (std::vector<std::string>{"--improve", "20"}));
}

TEST(ModelList, WrongLinesAreNamed) {
  EXPECT_NE(refusal("a.obj\n{\"output\": \"x\"}\n").find("line 2"), std::string::npos);
  for (const char* line :
       {"{", "{}", "{\"input\": 3}", "{\"input\": \"\"}", "{\"input\": \"a.obj\", \"outptu\": \"b\"}",
        "{\"input\": \"a.obj\", \"output\": \"..\"}", "{\"input\": \"a.obj\", \"options\": \"-q\"}",
        "{\"input\": \"a.obj\", \"options\": [1]}"})
    EXPECT_NE(refusal(std::string(line) + "\n").find("line 1"), std::string::npos) << line;
  EXPECT_NE(refusal("..\n"), "");
  EXPECT_NE(refusal(std::string("a\0b.obj\n", 8)), "");
}

TEST(ModelList, FoldersAreWalkedWithoutTheResults) {
  const test::TemporaryFolder folder;
  const auto put = [&](const std::string& name) {
    fs::create_directories(fs::path(folder.file(name)).parent_path());
    test::write_text(folder.file(name), "x");
  };
  for (const char* name : {"b.obj", "A.OFF", "deep/er/c.stl.gz", "notes.txt", "mesh.mesh", "out/b.obj",
                           "-dash.ply", "line\nend.off", "\xff\xfe.obj"})
    put(name);
  fs::create_symlink("b.obj", folder.file("link.obj"));
  fs::create_symlink("nowhere.obj", folder.file("dangling.obj"));
  fs::create_directory_symlink(".", folder.file("circle"));
  const auto models = models_of(folder.path(), folder.file("out"));
  ASSERT_TRUE(models.ok());
  EXPECT_EQ(names_of(models.value()),
            (std::vector<std::string>{"-dash", "A", "b", "deep/er/c", "line\nend", "link", "\xff\xfe"}));
  EXPECT_FALSE(models_of(folder.file("none"), "").ok());
}

TEST(ModelList, ShardsAreAllModelsAndAboutEquallyBig) {
  const unsigned seed = 20261130;
  std::mt19937 random(seed);
  for (int round = 0; round < 50; ++round) {
    SCOPED_TRACE("seed " + std::to_string(seed) + ", round " + std::to_string(round));
    std::vector<Model> models(random() % 300);
    std::int64_t sum = 0, largest = 0;
    for (std::size_t i = 0; i < models.size(); ++i) {
      models[i].name = std::to_string(i);
      models[i].bytes = static_cast<std::int64_t>(std::exp(static_cast<double>(random() % 1000) / 80));
      sum += models[i].bytes;
      largest = std::max(largest, models[i].bytes);
    }
    const int count = 1 + static_cast<int>(random() % 20);
    std::set<std::string> seen;
    for (int i = 1; i <= count; ++i) {
      const std::vector<Model> shard = shard_of(models, i, count);
      std::int64_t own = 0;
      for (std::size_t k = 0; k < shard.size(); ++k) {
        EXPECT_TRUE(seen.insert(shard[k].name).second);
        if (k > 0) EXPECT_GE(shard[k - 1].bytes, shard[k].bytes);
        own += shard[k].bytes;
      }
      EXPECT_LE(own, sum / count + largest + 1);
    }
    EXPECT_EQ(seen.size(), models.size());
  }
}

}  // namespace
}  // namespace overtet
