// What all micro-benchmarks share: the models they run on and their main function.
//
//   micro_X [--model=FILE]... [Google Benchmark's own options]
//
// Without --model the models are made by the generators of the tests. A benchmark's name is
// WHAT/MODEL/ARGUMENTS, so that two results can be laid side by side by name.
#pragma once

#include <benchmark/benchmark.h>

#include <string>
#include <utility>
#include <vector>

#include "overtet/types.h"

namespace overtet::perf {

struct Model {
  std::string name;
  Surface surface;
};

// The models named on the command line, or generated ones that cross themselves, of about 10^4 and 10^5
// faces.
const std::vector<Model>& models();

// benchmark::RegisterBenchmark("what/model", body(state, model)) for every model; returns them, for ->Arg()s.
template <class Body>
std::vector<benchmark::internal::Benchmark*> for_each_model(const std::string& what, Body body) {
  std::vector<benchmark::internal::Benchmark*> out;
  for (const Model& m : models())
    out.push_back(
        benchmark::RegisterBenchmark((what + "/" + m.name).c_str(), [&m, body](benchmark::State& state) {
          body(state, m.surface);
        })->Unit(benchmark::kMillisecond));
  return out;
}

// Counts that stand beside the times.
inline void count(benchmark::State& state, const char* name, double value) { state.counters[name] = value; }

// Reads the models, calls register_all(), runs. Returns the exit code: 2 for a model that cannot be read.
int run(int argc, char** argv, void (*register_all)());

}  // namespace overtet::perf
