#include "src/pipeline/preparation.h"

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <utility>

#include "kernels/core/box.h"
#include "src/prepare/joining.h"
#include "src/prepare/steps.h"
#include "src/prepare/working_surface.h"
#include "src/run/stopwatch.h"

namespace overtet {

namespace {

std::string counted(std::int64_t n, const char* one, const char* many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

std::string figure_text(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", x);
  return text;
}

std::int64_t figure(const PrepareRecord& r, const char* name) {
  for (const Figure& f : r.figures)
    if (f.first == name)
      if (const auto* n = std::get_if<std::int64_t>(&f.second)) return *n;
  return 0;
}

std::string first_left(const PrepareRecord& r, const std::string& what) {
  if (r.left == 0 || r.places.empty()) return {};
  const PlaceLeft& p = r.places.front();
  return "; " + std::to_string(r.left) + " left, the first" + what + " at (" + figure_text(p.position[0]) +
         ", " + figure_text(p.position[1]) + ", " + figure_text(p.position[2]) + "): " + p.why;
}

std::string sentence_of(const PrepareRecord& r) {
  const std::string name = std::string(name_of(r.step)) + ": ";
  switch (r.step) {
    case PrepareStep::weld:
      return name + counted(r.done, "vertex", "vertices") + " merged.";
    case PrepareStep::close_cracks:
      return name + counted(r.done, "vertex", "vertices") + " merged, " +
             counted(figure(r, "edges_split"), "edge", "edges") + " split.";
    case PrepareStep::remove_small:
    case PrepareStep::largest:
      return name + std::to_string(r.done) + " of " +
             counted(figure(r, "components"), "component", "components") + " dropped, with " +
             counted(figure(r, "faces"), "face", "faces") + ".";
    case PrepareStep::fill_holes:
      return name + std::to_string(r.done) + " of " + counted(figure(r, "holes"), "hole", "holes") +
             " filled, with " + counted(figure(r, "vertices"), "vertex", "vertices") + " and " +
             counted(figure(r, "faces"), "face", "faces") +
             first_left(r,
                        r.places.empty() ? "" : " of " + counted(r.places.front().edges, "edge", "edges")) +
             ".";
    case PrepareStep::collapse_needles:
      return name + std::to_string(r.done) + " of " + counted(figure(r, "needles"), "needle", "needles") +
             " gone, with " + counted(figure(r, "faces_gone"), "face", "faces") + first_left(r, "") + ".";
  }
  return name;
}

class Preparing {
 public:
  Preparing(const PrepareOptions& options, const RunContext& context) : options_(options), context_(context) {
    cleaning_.allow_open = true;
    cleaning_.most_places = options.most_places;
  }

  Result<Preparation> run(const Surface& given, const SurfaceSource& source) {
    Result<Cleanup> first = clean_up(given, cleaning_, source, context_);
    if (!first) return first.error();
    if (first.value().problem) return *first.value().problem;
    Preparation out;
    out.result.defects = std::move(first.value().defects);
    working_.vertex_of.resize(given.V.rows());
    working_.face_of.resize(given.F.rows());
    std::iota(working_.vertex_of.begin(), working_.vertex_of.end(), 0);
    std::iota(working_.face_of.begin(), working_.face_of.end(), 0);
    working_.become(std::move(first).value());
    diagonal_ = diagonal_of(working_.surface.V);
    for (const PrepareStep step :
         {PrepareStep::weld, PrepareStep::close_cracks, PrepareStep::remove_small, PrepareStep::largest,
          PrepareStep::fill_holes, PrepareStep::collapse_needles}) {
      if (!wanted(step)) continue;
      if (auto stop = context_.stop()) return *stop;
      context_.report("prepare", 0, name_of(step));
      PrepareRecord record;
      record.step = step;
      {
        const Stopwatch watch(record.seconds);
        if (Status s = take(record); !s) return s.error();
      }
      record.message = sentence_of(record);
      out.steps.push_back(std::move(record));
    }
    finish(given, out);
    return out;
  }

 private:
  bool wanted(PrepareStep step) const {
    switch (step) {
      case PrepareStep::weld:
        return options_.weld > 0;
      case PrepareStep::close_cracks:
        return options_.close_cracks;
      case PrepareStep::remove_small:
        return options_.remove_small > 0;
      case PrepareStep::largest:
        return options_.largest;
      case PrepareStep::fill_holes:
        return options_.fill_holes > 0;
      case PrepareStep::collapse_needles:
        return options_.collapse_needles;
    }
    return false;
  }

  Status take(PrepareRecord& record) {
    switch (record.step) {
      case PrepareStep::weld:
        return weld(options_.weld * diagonal_, record);
      case PrepareStep::close_cracks:
        return close_cracks(options_.tolerance * diagonal_, record);
      case PrepareStep::remove_small:
        return note(drop_components(working_, options_.remove_small, false), record);
      case PrepareStep::largest:
        return note(drop_components(working_, 0, true), record);
      case PrepareStep::fill_holes:
        return note(fill_holes(working_, options_, context_), record);
      case PrepareStep::collapse_needles:
        return note(collapse_needles(working_, options_, options_.tolerance * diagonal_, context_), record);
    }
    return success();
  }

  Status note(Result<StepOutcome> outcome, PrepareRecord& record) {
    if (!outcome) return outcome.error();
    StepOutcome& o = outcome.value();
    record.done = o.done;
    record.left = o.left;
    record.figures = std::move(o.figures);
    record.places = std::move(o.places);
    for (PlaceLeft& p : record.places) p.vertex = working_.vertex_of[p.vertex];
    return clean(nullptr, record);
  }

  // What is mended on the way is among the step's figures, but for what the step is there for.
  Status clean(const Joined* joined, PrepareRecord& record) {
    Result<Cleanup> cleaned = clean_up(working_.surface, cleaning_, {}, context_);
    if (!cleaned) return cleaned.error();
    Cleanup& c = cleaned.value();
    if (c.problem) return *c.problem;
    if (joined) record.done += put_back(*joined, c, c.surface);
    for (const Defect& d : c.defects)
      if (is_mended(d.kind) && d.kind != DefectKind::unused_vertex && d.kind != DefectKind::unmerged_vertex)
        record.figures.emplace_back(name_of(d.kind), d.count);
    remaining_ = std::move(c.defects);
    std::erase_if(remaining_, [](const Defect& d) { return is_mended(d.kind); });
    working_.become(std::move(c));
    return success();
  }

  Status weld(double distance, PrepareRecord& record) {
    const Result<Joined> joined = put_together(working_, distance, context_);
    if (!joined) return joined.error();
    return clean(&joined.value(), record);
  }

  Status close_cracks(double distance, PrepareRecord& record) {
    // One clean-up for both: the ends of a crack whose sides have other edges are merged only once these are
    // split.
    const Result<Joined> joined = put_together(working_, distance, context_);
    if (!joined) return joined.error();
    record.figures.emplace_back("edges_split", split_at_vertices(working_, distance));
    return clean(&joined.value(), record);
  }

  void finish(const Surface& given, Preparation& out) {
    Cleanup& r = out.result;
    r.surface = std::move(working_.surface);
    r.vertex_of = std::move(working_.vertex_of);
    r.face_of = std::move(working_.face_of);
    out.remaining = std::move(remaining_);
    for (Index v = 0; v < r.surface.V.rows(); ++v)
      if (r.vertex_of[v] >= 0 && r.surface.V.row(v) != given.V.row(r.vertex_of[v])) out.moved.push_back(v);
  }

  const PrepareOptions& options_;
  const RunContext& context_;
  CleanupOptions cleaning_;
  WorkingSurface working_;
  std::vector<Defect> remaining_;
  double diagonal_ = 0;
};

}  // namespace

Result<Preparation> prepare_surface(const Surface& surface, const PrepareOptions& options,
                                    const SurfaceSource& source, const RunContext& context) {
  return Preparing(options, context).run(surface, source);
}

}  // namespace overtet
