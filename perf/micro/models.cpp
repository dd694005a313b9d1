#include "perf/micro/models.h"

#include <cstdio>
#include <cstring>
#include <filesystem>

#include "overtet/io.h"
#include "tests/support/flow_surfaces.h"

namespace overtet::perf {

namespace {

std::vector<Model>& list() {
  static std::vector<Model> models;
  return models;
}

Model capsule(int rings, int sides) {
  Surface s = test::bent_capsule(420, 1, 0.3, rings, sides);
  return {"capsule_" + std::to_string(s.F.rows()), std::move(s)};
}

}  // namespace

const std::vector<Model>& models() { return list(); }

int run(int argc, char** argv, void (*register_all)()) {
  std::vector<char*> rest;
  for (int i = 0; i < argc; ++i) {
    if (std::strncmp(argv[i], "--model=", 8) != 0) {
      rest.push_back(argv[i]);
      continue;
    }
    const std::string file = argv[i] + 8;
    auto surface = read_surface(file);
    if (!surface) {
      std::fprintf(stderr, "%s: %s\n", file.c_str(), surface.error().message.c_str());
      return 2;
    }
    list().push_back({std::filesystem::path(file).stem().string(), std::move(surface).value()});
  }
  if (list().empty()) {
    list().push_back(capsule(125, 40));
    list().push_back(capsule(400, 125));
  }
  int count = static_cast<int>(rest.size());
  rest.push_back(nullptr);
  register_all();
  benchmark::Initialize(&count, rest.data());
  if (benchmark::ReportUnrecognizedArguments(count, rest.data())) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}

}  // namespace overtet::perf
