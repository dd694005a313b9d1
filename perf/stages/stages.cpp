// Every stage of the default route alone: how long it takes on 1, 2, ... threads, and what it counted.
//
//   perf_stages [--threads 1,2] [--repeat N] [--stages DIR] [--repair] SURFACE...
//
// A stage's input is computed once, by the stages before it; the cover and the mesh before the quality pass
// are read from DIR where `overtet mesh SURFACE --save-stages DIR` left them (one SURFACE then). The shortest
// of the repeats is printed, in seconds, and how many times faster the last number of threads is than the
// first. The repair runs with --repair only, on the surface as it is.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "kernels/parallel/parallel.h"
#include "overtet/io.h"
#include "overtet/verification.h"
#include "src/certificates/diagnose.h"
#include "src/immersion/immersion.h"
#include "src/improve/improve.h"
#include "src/pipeline/unit_box.h"
#include "src/repair/repair.h"

namespace {

using namespace overtet;
using Clock = std::chrono::steady_clock;

struct Settings {
  std::vector<int> threads = {1, 2};
  int repeat = 3;
  std::string stages;
  bool repair = false;
  std::vector<std::string> files;
};

// body(context) -> what is worth saying beside the times.
void measure(const Settings& settings, const char* stage,
             const std::function<std::string(const RunContext&)>& body) {
  std::printf("  %-12s", stage);
  std::vector<double> best;
  std::string said;
  for (const int threads : settings.threads) {
    const ScopedThreads scope(threads);
    RunContext context;
    context.threads = threads;
    double least = HUGE_VAL;
    for (int i = 0; i < settings.repeat; ++i) {
      const auto start = Clock::now();
      said = body(context);
      least = std::min(least, std::chrono::duration<double>(Clock::now() - start).count());
    }
    best.push_back(least);
    std::printf(" %9.4f", least);
    std::fflush(stdout);
  }
  std::printf("  x%.2f  %s\n", best.front() / best.back(), said.c_str());
}

std::string text(const char* what, std::int64_t n) { return std::to_string(n) + " " + what; }

// False: the run cannot go on with the next stage.
bool run(const std::string& file, const Settings& settings) {
  auto read = read_surface(file);
  if (!read) {
    std::printf("%s: %s\n", file.c_str(), read.error().message.c_str());
    return false;
  }
  Surface surface = std::move(read).value();
  std::printf("%s: %s\n", std::filesystem::path(file).stem().c_str(),
              text("faces", surface.F.rows()).c_str());
  measure(settings, "read", [&](const RunContext&) { return read_surface(file).ok() ? "" : "failed"; });
  const auto box = into_unit_box(surface.V);
  if (!box) return false;

  Diagnosis d;
  measure(settings, "diagnose", [&](const RunContext& context) {
    auto r = diagnose(surface, {}, context);
    if (!r) return r.error().message;
    d = std::move(r).value();
    return text("pairs", static_cast<std::int64_t>(d.pairs.size())) + ", " +
           text("hinges", static_cast<std::int64_t>(d.hinges.size()));
  });
  if (settings.repair)
    measure(settings, "repair", [&](const RunContext& context) {
      auto r = repair(surface, {}, context);
      return r ? std::string("repaired") : r.error().message;
    });
  if (refuse(d)) {
    std::printf("  %s\n", d.message.c_str());
    return true;
  }

  TetMesh mapped;
  measure(settings, "immersion", [&](const RunContext& context) {
    auto r = immerse(surface, d.pairs, d.wound.edges, {}, context);
    if (!r) return r.error().message;
    mapped = r.value().mesh;
    char parts[200];
    std::snprintf(parts, sizeof parts,
                  "%ld tets; arrangement %.3f, tet mesh %.3f, sheets %.3f, boundary %.3f",
                  static_cast<long>(mapped.T.rows()), r.value().arrangement_seconds,
                  r.value().tet_mesh_seconds, r.value().sheets_seconds, r.value().boundary_seconds);
    return std::string(parts);
  });
  if (!settings.stages.empty()) {
    auto saved = read_tets(settings.stages + "/mapped.vtu");
    if (!saved) {
      std::printf("  %s\n", saved.error().message.c_str());
      return false;
    }
    mapped = std::move(saved).value();
    mapped.surface_vertices = static_cast<Index>(surface.V.rows());
    back_into_unit_box(mapped.V, box.value());
  }
  if (mapped.T.rows() == 0) return true;

  TetMesh improved;
  measure(settings, "improve", [&](const RunContext& context) {
    improved = mapped;
    auto r = improve(improved, {}, context);
    if (!r) return r.error().message;
    return text("passes", static_cast<std::int64_t>(r.value().passes.size())) + ", " +
           text("tets", improved.T.rows());
  });
  measure(settings, "verify",
          [&](const RunContext& context) { return verify(surface, improved, {}, context).summary(); });
  const auto out = std::filesystem::temp_directory_path() /
                   ("perf_stages_" + std::to_string(Clock::now().time_since_epoch().count()) + ".mesh");
  measure(settings, "write", [&](const RunContext&) {
    return write_tets(out.string(), improved, TetFormat::medit).ok()
               ? text("bytes", static_cast<std::int64_t>(std::filesystem::file_size(out)))
               : "failed";
  });
  std::filesystem::remove(out);
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  for (int i = 1; i < argc; ++i) {
    const std::string a = argv[i];
    const bool more = i + 1 < argc;
    if (a == "--threads" && more) {
      settings.threads.clear();
      for (const char* p = argv[++i]; *p;) {
        char* end;
        settings.threads.push_back(static_cast<int>(std::strtol(p, &end, 10)));
        p = *end ? end + 1 : end;
      }
    } else if (a == "--repeat" && more) {
      settings.repeat = std::max(1, std::atoi(argv[++i]));
    } else if (a == "--stages" && more) {
      settings.stages = argv[++i];
    } else if (a == "--repair") {
      settings.repair = true;
    } else {
      settings.files.push_back(a);
    }
  }
  if (settings.files.empty() || settings.threads.empty() ||
      (!settings.stages.empty() && settings.files.size() != 1)) {
    std::fprintf(stderr,
                 "usage: perf_stages [--threads 1,2] [--repeat N] [--stages DIR] [--repair] SURFACE...\n");
    return 2;
  }
  std::printf("  %-12s", "stage");
  for (const int t : settings.threads) std::printf(" %7d t", t);
  std::printf("\n");
  int failed = 0;
  for (const std::string& file : settings.files) failed += !run(file, settings);
  return failed ? 1 : 0;
}
