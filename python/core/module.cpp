// overtet._core: the library's functions for overtet/, which checks and converts what users give and makes
// dataclasses of what comes back.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "overtet/overtet.h"
#include "python/core/arrays.h"
#include "python/core/calls.h"
#include "python/core/elastic.h"
#include "python/core/records.h"
#include "python/core/solve.h"
#include "python/core/weights.h"

namespace overtet::python {

namespace {

using namespace py::literals;

MeshingOptions meshing_options(const py::dict& o) {
  MeshingOptions m;
  const auto preset = o["preset"].cast<std::string>(), infeasible = o["on_infeasible"].cast<std::string>();
  m.preset = preset == "default" ? Preset::standard : Preset::flow;
  m.on_infeasible = infeasible == "repair"   ? OnInfeasible::repair
                    : infeasible == "refine" ? OnInfeasible::refine
                    : infeasible == "branch" ? OnInfeasible::branch
                                             : OnInfeasible::reject;
  m.max_repair_move = o["max_move"].cast<double>();
  m.improve_degrees = o["improve"].cast<double>();
  m.sizes.max_edge = o["max_edge"].cast<double>();
  m.sizes.max_volume = o["max_volume"].cast<double>();
  m.sizes.at_vertex = vector_of<double>(o["sizes"]);
  m.sizes.coarse = o["coarse"].cast<bool>();
  return m;
}

std::vector<Figure> figures_of(const py::dict& given) {
  std::vector<Figure> out;
  for (const auto& [key, value] : given) {
    const auto name = key.cast<std::string>();
    if (py::isinstance<py::bool_>(value))
      out.emplace_back(name, value.cast<bool>());
    else if (py::isinstance<py::int_>(value))
      out.emplace_back(name, value.cast<std::int64_t>());
    else if (py::isinstance<py::float_>(value))
      out.emplace_back(name, value.cast<double>());
    else
      out.emplace_back(name, value.cast<std::string>());
  }
  return out;
}

struct LabelledSurface {
  Surface surface;
  SurfaceAttributes attributes;
};

// What the mesh is of: the input, repaired or refined. Pieces of a face have its label.
LabelledSurface meshed_surface(const LabelledSurface& given, const Meshing& made) {
  const RefinedSurface& refined = made.refined;
  const Eigen::Index n = given.surface.V.rows();
  if (refined.subdivided.empty()) return {{made.mesh.V.topRows(n), given.surface.F}, given.attributes};
  std::vector<Index> old_vertex(static_cast<std::size_t>(refined.surface.V.rows()), -1);
  std::iota(old_vertex.begin(), old_vertex.begin() + n, 0);
  return {refined.surface, carried(given.attributes, old_vertex, refined.face)};
}

Result<MeshAttributes> attributes_of_mesh(const LabelledSurface& given, const Meshing& made,
                                          const Report& report, bool layers, const RunContext& context) {
  context.report("label", 0);
  MeshAttributeOptions wanted;
  wanted.layers = layers;
  if (report.status != RunStatus::repaired) wanted.winding_max = report.input.winding_max;
  const LabelledSurface of = meshed_surface(given, made);
  return mesh_attributes(of.surface, of.attributes, made.mesh, wanted, context);
}

double seconds_since(RunContext::Clock::time_point start) {
  return std::chrono::duration<double>(RunContext::Clock::now() - start).count();
}

py::dict dict_of_mesh(Meshing made, MeshAttributes attributes, const Report& report) {
  py::dict out;
  out["surface_vertices"] = made.mesh.surface_vertices;
  out["V"] = array_of(std::move(made.mesh.V));
  out["T"] = array_of(std::move(made.mesh.T));
  add(out, std::move(attributes));
  out["moved"] = array_of(std::move(made.moved));
  out["max_relative_move"] = made.max_relative_move;
  out["branch_edges"] = array_of(std::move(made.branch_edges));
  out["subdivided_faces"] = array_of(std::move(made.refined.subdivided));
  out["quality"] = dict_of(made.quality);
  out["status"] = name_of(report.status);
  out["report"] = message_text(to_json(report));
  out["hash"] = made.hash;
  return out;
}

py::dict tetrahedralize_(const py::handle& V, const py::handle& F, const py::dict& surface,
                         const py::dict& options, const py::dict& run) {
  const auto start = RunContext::Clock::now();
  LabelledSurface given{surface_of(V, F), attributes_of(surface)};
  const MeshingOptions wanted = meshing_options(options);
  const bool layers = options["layers"].cast<bool>();
  Report report;
  std::optional<MeshAttributes> attributes;
  Result<Meshing> made = call(run, [&](const RunContext& context) -> Result<Meshing> {
    Result<Meshing> meshing = tetrahedralize(given.surface, wanted, context, &report);
    if (!meshing) return meshing;
    Result<MeshAttributes> labelled = attributes_of_mesh(given, meshing.value(), report, layers, context);
    if (!labelled) return labelled.error();
    attributes = std::move(labelled).value();
    given = {};
    return meshing;
  });
  report.options = figures_of(options["told"]);
  report.input.format = "numpy";
  report.seconds = seconds_since(start);
  if (!made) {
    report.status = status_of(made.error().code);
    report.message = made.error().message;
    raise(made.error(), &report);
  }
  report.message = std::to_string(made.value().mesh.V.rows()) + " vertices, " +
                   std::to_string(made.value().mesh.T.rows()) + " tets, checked exactly.";
  return dict_of_mesh(std::move(made).value(), std::move(*attributes), report);
}

py::dict inspect(const py::handle& V, const py::handle& F, const py::dict& run) {
  const Surface surface = surface_of(V, F);
  return dict_of(value_of(call(run, [&](const RunContext& context) { return diagnose(surface, context); })));
}

py::dict repair(const py::handle& V, const py::handle& F, double max_move, const py::dict& run) {
  const auto start = RunContext::Clock::now();
  Surface surface = surface_of(V, F);
  SurfaceRepairOptions options;
  options.max_relative_move = max_move;
  Report report;
  Result<SurfaceRepair> made = call(
      run, [&](const RunContext& context) { return repair_surface(surface, options, context, &report); });
  report.options = {{"max_move", max_move}};
  report.input.format = "numpy";
  report.seconds = seconds_since(start);
  if (!made) {
    report.status = status_of(made.error().code);
    report.message = made.error().message;
    raise(made.error(), &report);
  }
  SurfaceRepair r = std::move(made).value();
  return py::dict("V"_a = array_of(std::move(r.surface.V)), "F"_a = array_of(std::move(r.surface.F)),
                  "moved"_a = array_of(std::move(r.moved)), "max_relative_move"_a = r.max_relative_move,
                  "mean_relative_move"_a = r.mean_relative_move, "report"_a = message_text(to_json(report)));
}

py::dict ratios_of(const RatioRange& r) {
  return py::dict("least"_a = r.least, "p01"_a = r.p01, "p50"_a = r.p50, "p99"_a = r.p99, "most"_a = r.most);
}

py::dict embed_(const py::handle& V, const py::handle& F, const py::dict& run) {
  const auto start = RunContext::Clock::now();
  Surface surface = surface_of(V, F);
  Report report;
  Result<Embedding> made =
      call(run, [&](const RunContext& context) { return embed(surface, {}, context, &report); });
  report.input.format = "numpy";
  report.seconds = seconds_since(start);
  if (!made) raise(made.error(), &report);
  Embedding e = std::move(made).value();
  report.message = "No faces intersect, checked exactly.";
  return py::dict("V"_a = array_of(std::move(e.surface.V)), "F"_a = array_of(std::move(e.surface.F)),
                  "moved"_a = array_of(std::move(e.moved)),
                  "laid_aside"_a = array_of(std::move(e.laid_aside)), "area"_a = ratios_of(e.quality.area),
                  "edge"_a = ratios_of(e.quality.edge), "area_within_20"_a = e.quality.area_within_20,
                  "collapsed"_a = e.quality.collapsed, "report"_a = message_text(to_json(report)));
}

// surface, mesh: dicts with what is known besides; where the mesh has boundary triangles they are checked,
// too.
py::dict verify_(const py::dict& surface, const py::dict& mesh, const py::dict& options,
                 const py::dict& run) {
  const LabelledSurface of{surface_of(surface["V"], surface["F"]), attributes_of(surface)};
  const LabelledTetMesh tets = labelled_tets_of(mesh);
  VerifyOptions wanted;
  wanted.geometry_only = options["geometry_only"].cast<bool>();
  wanted.max_move = options["max_move"].cast<double>();
  wanted.allow_branches = options["allow_branches"].cast<bool>();
  std::optional<TetQuality> quality;
  const Result<VerifyResult> result = call(run, [&](const RunContext& context) -> Result<VerifyResult> {
    VerifyResult r = verify(of.surface, tets.mesh, wanted, context);
    if (!r.complete) return context.stop().value_or(Error{ErrorCode::interrupted, "Interrupted."});
    for (VerifyFailure& f : verify_attributes(of.surface, of.attributes, tets, wanted.geometry_only))
      r.failures.push_back(std::move(f));
    if (!r.fails(Rule::R1)) quality = tet_quality(tets.mesh, context);
    return r;
  });
  if (!result) raise(result.error());
  py::dict out = dict_of(result.value());
  out["quality"] = quality ? py::object(dict_of(*quality)) : py::object(py::none());
  return out;
}

py::dict clean_up_(const py::handle& V, const py::handle& F, const py::dict& surface, const py::dict& options,
                   const py::dict& run) {
  const Surface given = surface_of(V, F);
  const SurfaceAttributes attributes = attributes_of(surface);
  CleanupOptions wanted;
  wanted.strict = options["strict"].cast<bool>();
  wanted.allow_open = options["allow_open"].cast<bool>();
  wanted.most_places = options["places"].cast<int>();
  Cleanup cleaned =
      value_of(call(run, [&](const RunContext& context) { return clean_up(given, wanted, {}, context); }));
  if (cleaned.problem) raise(*cleaned.problem);
  py::dict out = dict_of(carried(attributes, cleaned.vertex_of, cleaned.face_of));
  out["record"] = dict_of(std::move(cleaned));
  return out;
}

PrepareOptions prepare_options(const py::dict& o) {
  PrepareOptions p = o["all"].cast<bool>() ? PrepareOptions::all() : PrepareOptions();
  const auto set = [&](const char* key, auto& to) {
    if (!o[key].is_none()) to = o[key].cast<std::decay_t<decltype(to)>>();
  };
  set("weld", p.weld);
  set("close_cracks", p.close_cracks);
  set("remove_small", p.remove_small);
  set("largest", p.largest);
  set("fill_holes", p.fill_holes);
  set("collapse_needles", p.collapse_needles);
  set("tolerance", p.tolerance);
  set("needle_degrees", p.needle_degrees);
  set("allow_crossings", p.allow_crossings);
  set("places", p.most_places);
  return p;
}

py::dict prepare_(const py::handle& V, const py::handle& F, const py::dict& surface, const py::dict& options,
                  const py::dict& run) {
  const Surface given = surface_of(V, F);
  const SurfaceAttributes attributes = attributes_of(surface);
  const PrepareOptions wanted = prepare_options(options);
  Preparation p =
      value_of(call(run, [&](const RunContext& context) { return prepare(given, wanted, {}, context); }));
  SurfaceAttributes carried_on = carried(attributes, p.result.vertex_of, p.result.face_of);
  for (std::size_t f = 0; f < carried_on.faces.of.size() && f < p.result.face_of.size(); ++f)
    if (p.result.face_of[f] < 0) carried_on.faces.of[f] = 0;  // a new face has no label
  py::dict out = dict_of(std::move(carried_on));
  out["steps"] = list_of(p.steps);
  out["moved"] = array_of(std::move(p.moved));
  out["remaining"] = list_of(p.remaining);
  out["record"] = dict_of(std::move(p.result));
  return out;
}

py::dict read_surface_(const std::string& path, const py::dict& run) {
  SurfaceReadInfo info;
  Surface surface =
      value_of(call(run, [&](const RunContext& context) { return read_surface(path, &info, context); }));
  if (info.attributes.input_face.empty()) info.attributes.input_face = std::move(info.source.face);
  if (info.attributes.input_vertex.empty()) info.attributes.input_vertex = std::move(info.source.vertex);
  py::dict out = dict_of(std::move(info.attributes));
  out["V"] = array_of(std::move(surface.V));
  out["F"] = array_of(std::move(surface.F));
  out["format"] = message_text(info.format);
  py::list notes;
  for (const std::string& note : info.notes) notes.append(message_text(note));
  out["notes"] = notes;
  out["has_vertex_order"] = info.has_vertex_order;
  return out;
}

void write_surface_(const std::string& path, const py::handle& V, const py::handle& F, const py::dict& more,
                    const py::dict& run) {
  const SurfaceFormat format = value_of(surface_format_of(path));
  const Surface surface = surface_of(V, F);
  const SurfaceAttributes attributes = attributes_of(more);
  value_of(call(run, [&](const RunContext& context) {
    return write_surface(path, surface, format, context, &attributes.faces);
  }));
}

py::dict fused_(const py::handle& V, const py::handle& F, const py::dict& surface, double improve,
                const py::dict& run) {
  const Surface given = surface_of(V, F);
  const SurfaceAttributes attributes = attributes_of(surface);
  FusedMesh made = value_of(call(
      run, [&](const RunContext& context) { return fused_mesh(given, attributes, {improve}, context); }));
  py::dict mesh;
  mesh["surface_vertices"] = 0;
  mesh["V"] = array_of(std::move(made.mesh.mesh.V));
  mesh["T"] = array_of(std::move(made.mesh.mesh.T));
  add(mesh, std::move(made.mesh.attributes));
  return py::dict("mesh"_a = mesh, "cut_faces"_a = made.cut_faces, "inner_vertices"_a = made.inner_vertices,
                  "surface_components"_a = made.surface_components, "components"_a = made.components,
                  "solid_volume"_a = made.solid_volume, "volume"_a = made.volume);
}

// format: empty: as the path says.
void write_mesh_(const std::string& path, const std::string& format, int order, const py::dict& mesh,
                 const py::dict& run) {
  const TetWriteOptions options{value_of(format.empty() ? tet_format_of(path) : tet_format_named(format)),
                                order};
  value_of(options.validate());
  const LabelledTetMesh labelled = labelled_tets_of(mesh);
  value_of(call(run, [&](const RunContext& context) {
    return write_tets(path, labelled.mesh, labelled.attributes, options, context);
  }));
}

py::dict read_mesh_(const std::string& path, const std::string& format, const py::dict& run) {
  std::optional<TetFormat> named;
  if (!format.empty()) named = value_of(tet_format_named(format));
  LabelledTetMesh read = value_of(call(run, [&](const RunContext& context) {
    return named ? read_labelled_tets(path, *named, context) : read_labelled_tets(path, context);
  }));
  py::dict out;
  out["surface_vertices"] = read.mesh.surface_vertices;
  out["V"] = array_of(std::move(read.mesh.V));
  out["T"] = array_of(std::move(read.mesh.T));
  add(out, std::move(read.attributes));
  return out;
}

py::dict quality_(const py::handle& V, const py::handle& T, const py::dict& run) {
  const TetMesh mesh = tets_of(V, T);
  return dict_of(value_of(
      call(run, [&](const RunContext& context) { return Result<TetQuality>(tet_quality(mesh, context)); })));
}

}  // namespace

PYBIND11_MODULE(_core, m) {
  m.doc() = "The library behind overtet. Use the package: it checks what this takes as it is.";
  m.def("tetrahedralize", &tetrahedralize_);
  m.def("inspect", &inspect);
  m.def("repair", &repair);
  m.def("embed", &embed_);
  m.def("verify", &verify_);
  m.def("clean_up", &clean_up_);
  m.def("prepare", &prepare_);
  m.def("read_surface", &read_surface_);
  m.def("write_surface", &write_surface_);
  m.def("write_mesh", &write_mesh_);
  m.def("read_mesh", &read_mesh_);
  m.def("quality", &quality_);
  m.def("fused", &fused_);
  add_solvers(m);
  add_elastic(m);
  add_weights(m);
  m.def("version", &version);
  m.def("usable_memory_bytes", &usable_memory_bytes);
  m.def("usable_cores", &usable_cores);
}

}  // namespace overtet::python
