// The program's commands, with their options as parsed. Internal to src/cli.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "overtet/io.h"
#include "overtet/prepare.h"
#include "overtet/run_context.h"
#include "src/cli/input.h"
#include "src/cli/terminal.h"

namespace overtet {

class Watchdog;

struct CommonOptions {
  int threads = 0;          // 0: all cores
  double time_limit = 0;    // seconds; 0: none
  double memory_limit = 0;  // MiB; 0: what is free at the start
  bool quiet = false;
  std::string log_level = "warning";
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();

  // Deadline, limits, cancellation by signals, messages to the terminal.
  RunContext context(Terminal& terminal) const;
};

struct SizeWishes {
  double max_volume = 0, max_edge = 0;  // in the surface's unit; 0: any
  std::string file;                     // of sizes of the surface's vertices; empty: none
  bool coarse = false;
};

// More than 12 members: what the user chose, option by option.
struct MeshCommand {
  std::string input, output, report, format, save_surface, save_stages, save_flow, resume;
  std::string on_infeasible = "reject", preset = "default";
  std::string forward, reverse, map;  // pieces of the preset paper; empty: its own
  bool allow_branches = false, allow_flips = false;
  std::optional<double> improve_degrees;  // none: as the preset has it
  int order = 1;
  double max_move = 6;  // percent of the diagonal, of a repair
  InputOptions clean;
  SizeWishes sizes;
};

struct InspectCommand {
  std::string input, save_curves;
  bool json = false, pairs = false, curves = false;
  InputOptions clean;
  std::vector<std::string> fail_on;  // "infeasible", "unclean"
};

struct RepairCommand {
  std::string input, output, report;
  bool surface_only = false;
  double max_move = 6;  // percent of the diagonal
  InputOptions clean;
};

struct EmbedCommand {
  std::string input, output, report;
  bool json = false;
  InputOptions clean;
};

struct PrepareCommand {
  std::string input, output, report, save_map;
  PrepareOptions options;
};

struct VerifyCommand {
  std::string surface, mesh, format;
  double max_move = 0;  // percent of the diagonal
  bool allow_branches = false;
  InputOptions clean;
  bool json = false;
};

struct ConvertCommand {
  std::string input, output, from, format;
  int order = 1;
};

// More than 12 members: what the user chose, option by option.
struct BatchCommand {
  std::vector<std::string> models;  // one folder or manifest; of a summary journals and folders
  std::string folder, report, format;
  int jobs = 0, threads_per_job = 0;  // 0: so that all cores are busy
  bool resume = false;
  std::string shard;  // "2/20"; empty: all
  bool summary = false;
  std::string csv, json, html;            // of a summary
  std::vector<std::string> mesh_options;  // what stands after --
};

struct ViewCommand {
  std::string input, page, picture;       // one of page and picture may be empty
  bool open = false;                      // the page, in the browser
  std::string size, eye, cut, colouring;  // of the picture, as given; empty: as the library has it
  double apart = 0;
};

struct CompareCommand {
  std::string input, output;
  bool fused = false, json = false;
  InputOptions clean;
};

struct FieldWords {
  std::vector<std::string> values, fluxes;  // WHERE=FORMULA
  std::string source;                       // a formula
  int order = 1;
  std::string solver = "automatic";
};

struct DistanceWords {
  std::vector<std::string> from;  // WHERE
  double smoothing = 1;
};

struct SkinningWords {
  std::string handles;  // file
  bool cut_bones = false;
  std::string weights, pose;  // files
};

// More than 12 members: what the user chose, option by option.
struct ElasticWords {
  std::string material = "neo-hookean", gravity, damping, rest, method, integrator = "euler";
  double young = 1, poisson = 0.3, density = 1, step = 0.01, tolerance = 1e-8;
  int frames = 1, iterations = 200;
  bool dynamic = false;
  std::vector<std::string> fixed, pulled, tractions,
      forces;  // WHERE, the others WHERE=FORMULA;FORMULA;FORMULA
};
struct SolveCommand {
  std::string kind, input, output;
  bool json = false;
  FieldWords field;
  DistanceWords distances;
  SkinningWords skinning;
  ElasticWords elastic;
};

// Each returns the exit code.
int run(const MeshCommand& command, const CommonOptions& common, Terminal& terminal);
int run(const InspectCommand& command, const CommonOptions& common, Terminal& terminal);
int run(const RepairCommand& command, const CommonOptions& common, Terminal& terminal);
int run(const EmbedCommand& command, const CommonOptions& common, Terminal& terminal);
int run(const PrepareCommand& command, const CommonOptions& common, Terminal& terminal);
int run(const VerifyCommand& command, const CommonOptions& common, Terminal& terminal);
int run(const ConvertCommand& command, const CommonOptions& common, Terminal& terminal);
int run(const ViewCommand& command, const CommonOptions& common, Terminal& terminal);
int run(const CompareCommand& command, const CommonOptions& common, Terminal& terminal);
int run(const SolveCommand& command, const CommonOptions& common, Terminal& terminal);
int run(const BatchCommand& command, const CommonOptions& common, Terminal& terminal);

// The format that is asked for by name, else that of the ending; says so where they differ.
Result<TetFormat> output_format(const std::string& path, const std::string& named, Terminal& terminal);

// The same file under two names, or the same name.
bool same_file(const std::string& a, const std::string& b);
// No two of them are the same file. Errors: usage.
Status check_names(const std::string& input, const std::string& output, const std::string& report);

// Shows early that the output and the report (may be empty) can be written.
struct OutputAndReport {
  OutputProbe output, report;
  Status open(const std::string& output_path, const std::string& report_path);
};

// The error's sentence, with the option that raises the limit where it is about one.
std::string with_hint(const Error& error);

// Says what went wrong and gives the exit code for it. With a watchdog: unless that has said so.
int fail(Terminal& terminal, const Error& error);
int fail(Watchdog& watchdog, Terminal& terminal, const Error& error);

}  // namespace overtet
