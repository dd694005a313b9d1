#include "python/core/records.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <utility>
#include <variant>

#include "python/core/arrays.h"
#include "python/core/calls.h"

namespace overtet::python {

py::str message_text(const std::string& text) {
  return py::reinterpret_steal<py::str>(
      PyUnicode_DecodeUTF8(text.data(), static_cast<py::ssize_t>(text.size()), "backslashreplace"));
}

py::str name_text(const std::string& text) {
  return py::reinterpret_steal<py::str>(
      PyUnicode_DecodeUTF8(text.data(), static_cast<py::ssize_t>(text.size()), "surrogateescape"));
}

std::string name_bytes(const py::handle& text) {
  const auto bytes =
      py::reinterpret_steal<py::bytes>(PyUnicode_AsEncodedString(text.ptr(), "utf-8", "surrogateescape"));
  if (!bytes) throw py::error_already_set();
  return bytes;
}

namespace {

template <class Matrix>
Matrix checked(const py::handle& given, const char* what) {
  try {
    return matrix_of<Matrix>(py::reinterpret_borrow<py::array>(given));
  } catch (const OutOfRange& out) {
    Error e{ErrorCode::bad_input, std::string(what) + " " + std::to_string(out.row) +
                                      " has a corner of number " + out.number +
                                      ", and there is no such vertex; numbers count from 0."};
    if (std::string(what) == "Face") e.face = static_cast<int>(out.row);
    raise(e);
  }
}

std::vector<Index> numbers(const py::handle& given, const char* what) {
  try {
    return vector_of<Index>(given);
  } catch (const OutOfRange& out) {
    raise({ErrorCode::usage, std::string(what) + "[" + std::to_string(out.row) + "] is " + out.number +
                                 ", which does not fit into 32 bits."});
  }
}

// A key that may be missing.
py::object at(const py::dict& d, const char* key) {
  return d.contains(key) ? py::object(d[key]) : py::object(py::none());
}

Labels labels_of(const py::dict& d, const char* of, const char* names) {
  Labels labels;
  labels.of = numbers(at(d, of), of);
  const py::object named = at(d, names);
  if (!named.is_none())
    for (const auto& [number, name] : py::reinterpret_borrow<py::dict>(named))
      labels.names[number.cast<Index>()] = name_bytes(name);
  return labels;
}

void add_labels(py::dict& d, const char* of, const char* names, Labels labels) {
  d[of] = labels.of.empty() ? py::object(py::none()) : py::object(array_of(std::move(labels.of)));
  py::dict named;
  for (const auto& [number, name] : labels.names) named[py::int_(number)] = name_text(name);
  d[names] = named;
}

std::vector<Attribute> data_of(const py::dict& d, const char* key) {
  std::vector<Attribute> out;
  const py::object all = at(d, key);
  if (all.is_none()) return out;
  for (const auto& [name, given] : py::reinterpret_borrow<py::dict>(all)) {
    const auto array = py::reinterpret_borrow<py::array>(given);
    const std::string type = py::str(array.dtype());
    Attribute a;
    a.name = name_bytes(name);
    a.type = type == "uint8"     ? NumberType::uint8
             : type == "int32"   ? NumberType::int32
             : type == "int64"   ? NumberType::int64
             : type == "float32" ? NumberType::float32
                                 : NumberType::float64;
    a.width = array.ndim() == 2 ? static_cast<int>(array.shape(1)) : 1;
    a.values.resize(static_cast<std::size_t>(array.size()));
    copy_array(py::array_t<double>(array), a.values.data(), a.width);
    out.push_back(std::move(a));
  }
  return out;
}

template <class T>
py::array typed(const Attribute& a) {
  std::vector<T> values(a.values.size());
  std::transform(a.values.begin(), a.values.end(), values.begin(),
                 [](double x) { return static_cast<T>(x); });
  const auto rows = static_cast<py::ssize_t>(values.size()) / std::max(1, a.width);
  std::vector<py::ssize_t> shape = {rows};
  if (a.width != 1) shape.push_back(a.width);
  return owned<T>(std::move(values), std::move(shape));
}

py::dict dict_of_data(const std::vector<Attribute>& data) {
  py::dict out;
  for (const Attribute& a : data) {
    const py::str name = name_text(a.name);
    switch (a.type) {
      case NumberType::uint8:
        out[name] = typed<std::uint8_t>(a);
        break;
      case NumberType::int32:
        out[name] = typed<std::int32_t>(a);
        break;
      case NumberType::int64:
        out[name] = typed<std::int64_t>(a);
        break;
      case NumberType::float32:
        out[name] = typed<float>(a);
        break;
      case NumberType::float64:
        out[name] = typed<double>(a);
        break;
    }
  }
  return out;
}

py::object array_or_none(std::vector<Index> v) {
  return v.empty() ? py::object(py::none()) : py::object(array_of(std::move(v)));
}

py::list texts(const std::vector<std::string>& all) {
  py::list out;
  for (const std::string& text : all) out.append(message_text(text));
  return out;
}

py::object of(const Figure& figure) {
  return std::visit(
      [](const auto& value) -> py::object {
        if constexpr (std::is_same_v<std::decay_t<decltype(value)>, std::string>)
          return message_text(value);
        else
          return py::cast(value);
      },
      figure.second);
}

}  // namespace

Surface surface_of(const py::handle& V, const py::handle& F) {
  Surface s;
  s.V = checked<VertexMatrix>(V, "Vertex");
  s.F = checked<TriangleMatrix>(F, "Face");
  return s;
}

SurfaceAttributes attributes_of(const py::dict& surface) {
  SurfaceAttributes a;
  a.faces = labels_of(surface, "labels", "label_names");
  a.solids = labels_of(surface, "solids", "solid_names");
  a.vertex_data = data_of(surface, "vertex_data");
  a.face_data = data_of(surface, "face_data");
  a.input_vertex = numbers(at(surface, "input_vertex"), "input_vertex");
  a.input_face = numbers(at(surface, "input_face"), "input_face");
  return a;
}

py::dict dict_of(SurfaceAttributes a) {
  py::dict d;
  add_labels(d, "labels", "label_names", std::move(a.faces));
  add_labels(d, "solids", "solid_names", std::move(a.solids));
  d["vertex_data"] = dict_of_data(a.vertex_data);
  d["face_data"] = dict_of_data(a.face_data);
  d["input_vertex"] = array_or_none(std::move(a.input_vertex));
  d["input_face"] = array_or_none(std::move(a.input_face));
  return d;
}

TetMesh tets_of(const py::handle& V, const py::handle& T) {
  TetMesh m;
  m.V = checked<VertexMatrix>(V, "Vertex");
  m.T = checked<TetMatrix>(T, "Tet");
  return m;
}

LabelledTetMesh labelled_tets_of(const py::dict& mesh) {
  LabelledTetMesh m;
  m.mesh = tets_of(mesh["V"], mesh["T"]);
  m.mesh.surface_vertices = mesh["surface_vertices"].cast<Index>();
  MeshAttributes& a = m.attributes;
  if (const py::object boundary = at(mesh, "boundary"); !boundary.is_none())
    a.triangles = checked<TriangleMatrix>(boundary, "Boundary face");
  a.labels = labels_of(mesh, "labels", "label_names");
  a.regions = labels_of(mesh, "regions", "region_names");
  a.input_face = numbers(at(mesh, "boundary_face"), "boundary_face");
  a.layers = numbers(at(mesh, "layers"), "layers");
  a.input_vertex = numbers(at(mesh, "input_vertex"), "input_vertex");
  a.vertex_data = data_of(mesh, "vertex_data");
  a.triangle_data = data_of(mesh, "triangle_data");
  return m;
}

void add(py::dict& mesh, MeshAttributes a) {
  mesh["boundary"] = array_of(std::move(a.triangles));
  mesh["boundary_face"] = array_of(std::move(a.input_face));
  add_labels(mesh, "labels", "label_names", std::move(a.labels));
  add_labels(mesh, "regions", "region_names", std::move(a.regions));
  mesh["layers"] = array_or_none(std::move(a.layers));
  mesh["input_vertex"] = array_or_none(std::move(a.input_vertex));
  mesh["vertex_data"] = dict_of_data(a.vertex_data);
  mesh["triangle_data"] = dict_of_data(a.triangle_data);
}

py::dict dict_of(const TetQuality& q) {
  using namespace py::literals;
  return py::dict("tets"_a = q.tets, "dihedral_min"_a = q.dihedral_min, "dihedral_p01"_a = q.dihedral_p01,
                  "dihedral_max"_a = q.dihedral_max, "volume"_a = q.volume,
                  "coincident_vertices"_a = q.coincident_vertices, "closest_pair"_a = q.closest_pair,
                  "closest"_a = py::make_tuple(q.closest[0], q.closest[1]));
}

namespace {

py::dict dict_of(Curve&& c) {
  using namespace py::literals;
  constexpr const char* ends[] = {"none", "hinge", "contact"};
  constexpr const char* kinds[] = {"edge", "vertex", "hinge", "triple"};
  std::vector<std::array<double, 3>> points;
  std::vector<std::array<Index, 2>> faces, winding;
  py::list node_kinds;
  for (const CurveNode& n : c.nodes) {
    points.push_back(n.position);
    node_kinds.append(kinds[static_cast<int>(n.kind)]);
  }
  for (const CurveSegment& s : c.segments) {
    faces.push_back(s.faces);
    winding.push_back({s.winding_min, s.winding_max});
  }
  return py::dict(
      "closed"_a = c.closed, "sheets_swap"_a = c.sheets_swap,
      "ends"_a = py::make_tuple(ends[static_cast<int>(c.ends[0])], ends[static_cast<int>(c.ends[1])]),
      "points"_a = array_of(std::move(points)), "kinds"_a = node_kinds,
      "faces"_a = array_of(std::move(faces)), "winding"_a = array_of(std::move(winding)),
      "length"_a = c.length);
}

py::list list_of_hinges(const std::vector<HingeDiagnosis>& hinges) {
  using namespace py::literals;
  py::list out;
  for (const HingeDiagnosis& h : hinges) {
    py::list edges;
    for (const EdgeAtHinge& e : h.edges) edges.append(py::dict("to"_a = e.to, "levels"_a = e.levels));
    out.append(py::dict("vertex"_a = h.vertex, "B0"_a = h.B0, "covering"_a = h.covering,
                        "crossings"_a = h.crossings, "edges"_a = edges));
  }
  return out;
}

}  // namespace

py::dict dict_of(SurfaceDiagnosis d) {
  using namespace py::literals;
  py::dict out(
      "verdict"_a = verdict_name(d.verdict), "message"_a = message_text(d.message),
      "advice"_a = texts(d.advice), "vertices"_a = d.vertices, "faces"_a = d.faces, "closed"_a = d.closed,
      "manifold"_a = d.manifold, "oriented"_a = d.oriented, "problems"_a = texts(d.problems),
      "degenerate_faces"_a = array_of(std::move(d.degenerate_faces)),
      "pairs"_a = array_of(std::move(d.pairs)), "pairs_sharing_vertex"_a = d.pairs_sharing_vertex,
      "pairs_sharing_edge"_a = d.pairs_sharing_edge, "winding_min"_a = d.winding_min,
      "winding_max"_a = d.winding_max, "hinges"_a = list_of_hinges(d.hinges), "odd_groups"_a = d.odd_groups,
      "crowded"_a = array_of(std::move(d.crowded)), "unfillable"_a = array_of(std::move(d.unfillable)),
      "unmet"_a = array_of(std::move(d.unmet)), "thin_limit"_a = d.thin_limit);
  out["certificate"] =
      d.certificate ? py::object(message_text(to_json(*d.certificate))) : py::object(py::none());
  out["explanation"] = message_text(d.certificate ? explain(*d.certificate) : std::string());
  py::list components, curves, thin;
  for (const ComponentDiagnosis& c : d.components)
    components.append(py::dict("faces"_a = c.faces, "vertices"_a = c.vertices, "genus"_a = c.genus,
                               "signed_volume"_a = c.signed_volume));
  out["components"] = components;
  std::vector<std::array<Index, 3>> wound;
  for (const ExtraTurns& e : d.wound_edges) wound.push_back({e.a, e.b, e.k});
  out["wound_edges"] = array_of(std::move(wound));
  for (Curve& c : d.curves.curves) curves.append(dict_of(std::move(c)));
  out["curves"] = curves;
  for (const ThinSpot& t : d.thin_spots)
    thin.append(py::dict("face"_a = t.face, "across"_a = t.across, "position"_a = t.position,
                         "thickness"_a = t.thickness, "faces"_a = t.faces));
  out["thin_spots"] = thin;
  return out;
}

py::dict dict_of(VerifyResult r) {
  using namespace py::literals;
  py::list failures;
  for (const VerifyFailure& f : r.failures)
    failures.append(py::dict("rule"_a = "R" + std::to_string(static_cast<int>(f.rule)),
                             "message"_a = message_text(f.message), "count"_a = f.count,
                             "first"_a = f.first));
  return py::dict("failures"_a = failures, "surface_vertices"_a = r.surface_vertices,
                  "surface_faces"_a = r.surface_faces, "vertices"_a = r.vertices, "tets"_a = r.tets,
                  "boundary_faces"_a = r.boundary_faces, "moved_vertices"_a = r.moved_vertices,
                  "max_move"_a = r.max_move, "branch_edges"_a = array_of(std::move(r.branch_edges)));
}

py::list list_of(const std::vector<Defect>& defects) {
  using namespace py::literals;
  py::list out;
  for (const Defect& d : defects) {
    py::list places;
    for (const DefectPlace& p : d.places)
      places.append(py::dict("vertices"_a = p.vertices, "faces"_a = p.faces, "position"_a = p.position,
                             "edges"_a = p.edges, "length"_a = p.length));
    out.append(py::dict("kind"_a = name_of(d.kind), "mended"_a = is_mended(d.kind), "count"_a = d.count,
                        "message"_a = message_text(d.message), "places"_a = places));
  }
  return out;
}

py::list list_of(const std::vector<PrepareRecord>& steps) {
  using namespace py::literals;
  py::list out;
  for (const PrepareRecord& s : steps) {
    py::dict figures;
    for (const Figure& f : s.figures) figures[message_text(f.first)] = of(f);
    py::list places;
    for (const PlaceLeft& p : s.places)
      places.append(py::dict("position"_a = p.position, "vertex"_a = p.vertex, "edges"_a = p.edges,
                             "why"_a = message_text(p.why)));
    out.append(py::dict("step"_a = name_of(s.step), "seconds"_a = s.seconds, "done"_a = s.done,
                        "left"_a = s.left, "figures"_a = figures, "places"_a = places,
                        "message"_a = message_text(s.message)));
  }
  return out;
}

py::dict dict_of(Cleanup c) {
  using namespace py::literals;
  py::dict out("defects"_a = list_of(c.defects), "summary"_a = message_text(c.summary()),
               "changed"_a = c.changed());  // before anything is moved away
  out["vertex_of"] = array_or_none(std::move(c.vertex_of));
  out["face_of"] = array_or_none(std::move(c.face_of));
  out["turned"] = array_of(std::move(c.turned));
  out["merged"] = array_of(std::move(c.merged));
  out["V"] = array_of(std::move(c.surface.V));
  out["F"] = array_of(std::move(c.surface.F));
  return out;
}

}  // namespace overtet::python
