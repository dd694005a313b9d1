// What `overtet solve` does for each kind of problem: reads its files, solves, writes.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "src/cli/commands.h"

namespace overtet {

struct SolveSummary {
  nlohmann::ordered_json figures = nlohmann::ordered_json::object();  // for --json
  std::string sentence;  // for the user, after the name of the output: "u at 20 nodes, from 0 to 1"
};

// With the mesh's name as data of its vertices: what there was under that name is replaced.
void put_vertex_data(MeshAttributes& attributes, const std::string& name, int width,
                     std::vector<double> values);

// `writing`: the context for who writes the outputs (Watchdog::writing).
Result<SolveSummary> solve_for_field(const SolveCommand& command, const RunContext& context,
                                     const RunContext& writing);
Result<SolveSummary> solve_for_distances(const SolveCommand& command, const RunContext& context,
                                         const RunContext& writing);
Result<SolveSummary> solve_for_weights(const SolveCommand& command, const RunContext& context,
                                       const RunContext& writing);
Result<SolveSummary> solve_for_skin(const SolveCommand& command, const RunContext& context,
                                    const RunContext& writing);

Result<SolveSummary> solve_for_elastic(const SolveCommand& command, const RunContext& context,
                                       const RunContext& writing);

}  // namespace overtet
