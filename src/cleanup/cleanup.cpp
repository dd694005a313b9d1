#include "overtet/cleanup.h"

#include <algorithm>
#include <exception>
#include <new>
#include <numeric>
#include <utility>

#include "kernels/bvh/self_intersections.h"
#include "kernels/core/indices.h"
#include "kernels/core/tuning.h"
#include "kernels/core/union_find.h"
#include "kernels/parallel/parallel.h"
#include "src/cleanup/holes.h"
#include "src/cleanup/inward.h"
#include "src/cleanup/messages.h"
#include "src/cleanup/orienting.h"
#include "src/cleanup/pairing.h"
#include "src/cleanup/raw_edges.h"
#include "src/cleanup/repeated_faces.h"
#include "src/mesh/topology.h"

namespace overtet {

namespace {

struct KindName {
  const char *report, *one, *many;  // the report's word; what was done, after a count
};

const KindName& words(DefectKind kind) {
  static constexpr KindName names[] = {
      {"repeated-corner", "face with two equal corners dropped", "faces with two equal corners dropped"},
      {"repeated-face", "face that was there twice dropped", "faces that were there twice dropped"},
      {"unmerged-vertex", "vertex merged with another one in the same place",
       "vertices merged with others in the same place"},
      {"crowded-edge", "edge of four or more faces split", "edges of four or more faces split"},
      {"pinched-vertex", "vertex between several fans of faces split",
       "vertices between several fans of faces split"},
      {"unused-vertex", "unused vertex dropped", "unused vertices dropped"},
      {"turned-face", "face turned as its neighbours are", "faces turned as their neighbours are"},
      {"inward-component", "component that faced inwards turned", "components that faced inwards turned"},
      {"odd-edge", "edge of an odd number of faces", "edges of an odd number of faces"},
      {"hole", "hole", "holes"},
      {"unpaired-edge", "edge of faces that cannot be paired", "edges of faces that cannot be paired"},
      {"one-sided", "one-sided component", "one-sided components"},
      {"malformed", "malformed surface", "malformed surfaces"}};
  return names[static_cast<int>(kind)];
}

// The surface being cleaned: faces that are kept, with the given surface's vertices.
struct Faces {
  std::vector<Index> kept;  // numbers of the given surface, ascending
  TriangleMatrix F;
  RawEdges edges;
  Oriented oriented;

  void drop(const std::vector<char>& gone) {
    Index n = 0;
    for (Index f = 0; f < F.rows(); ++f) {
      if (gone[f]) continue;
      kept[n] = kept[f];
      if (n != f) F.row(n) = F.row(f);
      ++n;
    }
    kept.resize(n);
    F.conservativeResize(n, 3);
  }
};

// Notes defects, of each kind the first places.
class Notes {
 public:
  Notes(const Surface& given, const CleanupOptions& options) : given_(given), most_(options.most_places) {}

  void add(DefectKind kind, std::vector<Index> vertices, std::vector<Index> faces, std::int64_t edges = 0) {
    Defect& d = of(kind);
    ++d.count;
    if (d.places.size() >= most_) return;
    DefectPlace p;
    p.vertices = std::move(vertices);
    p.faces = std::move(faces);
    p.edges = edges;
    const Index v = !p.vertices.empty() ? p.vertices[0] : !p.faces.empty() ? given_.F(p.faces[0], 0) : -1;
    for (int k = 0; k < 3 && v >= 0; ++k) p.position[k] = given_.V(v, k);
    d.places.push_back(std::move(p));
  }
  void add(DefectKind kind, DefectPlace place) {
    Defect& d = of(kind);
    ++d.count;
    if (d.places.size() < most_) d.places.push_back(std::move(place));
  }
  // Whether more places are wanted.
  std::size_t most() const { return most_; }
  std::vector<Defect> take() {
    std::stable_sort(defects_.begin(), defects_.end(),
                     [](const Defect& a, const Defect& b) { return a.kind < b.kind; });
    return std::move(defects_);
  }
  bool beyond() const {
    return std::any_of(defects_.begin(), defects_.end(), [](const Defect& d) { return !is_mended(d.kind); });
  }

 private:
  Defect& of(DefectKind kind) {
    for (Defect& d : defects_)
      if (d.kind == kind) return d;
    defects_.emplace_back();
    defects_.back().kind = kind;
    return defects_.back();
  }
  const Surface& given_;
  std::size_t most_;
  std::vector<Defect> defects_;
};

bool is_sane(const Surface& s) {
  return s.F.rows() > 0 && s.V.rows() > 0 && all_below(s.F, s.V.rows()) && all_finite(s.V);
}

class Cleaner {
 public:
  Cleaner(const Surface& given, const CleanupOptions& options)
      : given_(given), notes_(given, options), allow_open_(options.allow_open) {}

  // What is wrong beyond mending is in the notes; the surface then is not there.
  Status run(const RunContext& context, Cleanup& out) {
    faces_.kept.resize(given_.F.rows());
    std::iota(faces_.kept.begin(), faces_.kept.end(), 0);
    faces_.F = given_.F;
    drop_repeated_corners(nullptr);
    if (Status s = drop_faces(context); !s) return s;
    if (faces_.kept.empty()) {
      notes_.add(DefectKind::malformed, DefectPlace{});
      return success();
    }
    faces_.oriented = orient(faces_.F, faces_.edges);
    if (auto stop = context.stop()) return *stop;
    split_edges(out);
    note_what_is_open();
    const bool open = notes_.beyond();
    if (open && (!allow_open_ || !faces_.oriented.one_sided.empty())) return success();
    note_turned_faces();
    note_vertices(out);
    return turn_components(open, context, out);
  }

  Notes& notes() { return notes_; }

 private:
  // Of faces with two corners in one vertex; place: of each vertex, or null.
  bool drop_repeated_corners(const std::vector<Index>* place) {
    const auto at = [&](Index v) { return place ? (*place)[v] : v; };
    const TriangleMatrix& F = faces_.F;
    std::vector<char> gone;
    for (Index f = 0; f < F.rows(); ++f) {
      const Index a = at(F(f, 0)), b = at(F(f, 1)), c = at(F(f, 2));
      if (a != b && b != c && c != a) continue;
      gone.resize(F.rows(), 0);
      gone[f] = 1;
      const int k = a == b ? 0 : b == c ? 1 : 2;
      notes_.add(DefectKind::repeated_corner, {F(f, k)}, {faces_.kept[f]});
    }
    if (gone.empty()) return false;
    faces_.drop(gone);
    return true;
  }

  // Finds the edges, and drops what stands in their way: that changes them, and so on.
  Status drop_faces(const RunContext& context) {
    for (int round = 0; round < kMostRounds; ++round) {
      if (auto stop = context.stop()) return *stop;
      faces_.edges = find_edges(given_.V, faces_.F);
      if (faces_.edges.merges && drop_repeated_corners(&faces_.edges.place)) continue;
      std::vector<Index> copies = repeated_faces(given_.V, faces_.F, faces_.edges);
      if (copies.empty()) copies = loose_copies(given_.V, faces_.F, faces_.edges);
      if (copies.empty()) break;
      std::vector<char> gone(faces_.F.rows(), 0);
      for (const Index f : copies) {
        gone[f] = 1;
        notes_.add(DefectKind::repeated_face, {}, {faces_.kept[f]});
      }
      faces_.drop(gone);
    }
    return success();
  }

  std::vector<Index> faces_at(const EdgeGroup& g) const {
    std::vector<Index> faces;
    for (Index i = g.begin; i < g.begin + g.count; ++i)
      faces.push_back(faces_.kept[half_edge_face(faces_.edges.list[i])]);
    return faces;
  }

  void note_edge(DefectKind kind, const EdgeGroup& g) {
    const Index h = faces_.edges.list[g.begin];
    notes_.add(kind, {half_edge_source(faces_.F, h), half_edge_target(faces_.F, h)}, faces_at(g), g.count);
  }

  // Pairs the faces of crowded edges so that the solid's sectors come apart there; the gaps instead, where
  // the solid's hang together around both ends of the edge.
  void split_edges(Cleanup& out) {
    const std::vector<EdgeGroup>& others = faces_.edges.others;
    std::vector<Sector> sector(others.size(), Sector::solid);
    for (bool again = true; again;) {
      again = false;
      std::vector<char> fails(others.size(), 0);
      bool open = false;
      for (std::size_t i = 0; i < others.size(); ++i)
        if (others[i].count % 2 == 1)
          open = true;
        else if (!pair(others[i], sector[i]))
          fails[i] = 1, open = true;
      if (!open || allow_open_) make_vertices(out);
      const bool met = (!open || allow_open_) && (faces_.edges.merges || !others.empty());
      const RawEdges now = met ? find_edges(out.surface.V, out.surface.F) : RawEdges{};
      std::vector<char> is_met(met ? faces_.F.size() : 0, 0);
      for (const EdgeGroup& g : now.others)
        for (Index i = g.begin; i < g.begin + g.count && is_one_edge(out.surface.F, now, g); ++i)
          is_met[now.list[i]] = 1;
      for (std::size_t i = 0; met && i < others.size(); ++i)
        if (sector[i] == Sector::solid && is_met[faces_.edges.list[others[i].begin]])
          sector[i] = Sector::gap, again = true;
      if (again) continue;
      for (std::size_t i = 0; i < others.size(); ++i)
        if (others[i].count % 2 == 0)
          note_edge(fails[i] ? DefectKind::unpaired_edge : DefectKind::crowded_edge, others[i]);
      for (const EdgeGroup& g : now.others)
        if (is_one_edge(out.surface.F, now, g)) note_met(now, g);
    }
  }

  // Whether an even number of faces have the edge, with the same two vertices: where nothing is open, all
  // that is not an edge of two.
  static bool is_one_edge(const TriangleMatrix& F, const RawEdges& edges, const EdgeGroup& g) {
    if (g.count % 2 == 1) return false;
    const auto ends = [&](Index i) {
      const Index h = edges.list[i];
      return std::minmax({half_edge_source(F, h), half_edge_target(F, h)});
    };
    for (Index i = g.begin + 1; i < g.begin + g.count; ++i)
      if (ends(i) != ends(g.begin)) return false;
    return true;
  }

  // False where the faces cannot be paired.
  bool pair(const EdgeGroup& g, Sector sector) {
    RawEdges& e = faces_.edges;
    const auto pairs = pair_around(given_.V, faces_.F, e, faces_.oriented, g, sector);
    for (const auto& [a, b] : pairs) e.partner[a] = b, e.partner[b] = a;
    return !pairs.empty();
  }

  // Edges between the same two vertices: what was split hangs together at both ends, or what lay beside each
  // other has been merged at both. edges: of the surface with its new vertices, and the same faces.
  void note_met(const RawEdges& edges, const EdgeGroup& g) {
    const Index h = edges.list[g.begin];
    std::vector<Index> faces;
    for (Index i = g.begin; i < g.begin + g.count; ++i)
      faces.push_back(faces_.kept[half_edge_face(edges.list[i])]);
    notes_.add(DefectKind::unpaired_edge, {half_edge_source(faces_.F, h), half_edge_target(faces_.F, h)},
               std::move(faces), g.count);
  }

  void note_what_is_open() {
    for (DefectPlace& hole : find_holes(given_.V, faces_.F, faces_.edges, faces_.oriented, notes_.most())) {
      for (Index& f : hole.faces) f = faces_.kept[f];
      notes_.add(DefectKind::hole, std::move(hole));
    }
    for (const EdgeGroup& g : faces_.edges.others)
      if (g.count % 2 == 1 && g.count > 1) note_edge(DefectKind::odd_edge, g);
    for (const auto& [f, g] : faces_.oriented.one_sided)
      notes_.add(DefectKind::one_sided, {}, {faces_.kept[f], faces_.kept[g]});
  }

  void note_turned_faces() {
    if (faces_.oriented.turned_faces == 0) return;
    for (Index f = 0; f < faces_.F.rows(); ++f)
      if (faces_.oriented.turned[f]) notes_.add(DefectKind::turned_face, {}, {faces_.kept[f]});
  }

  // Corners that hang together over paired edges are one vertex: it gets the smallest number that one of them
  // has, if that is still free, else one behind all.
  void make_vertices(Cleanup& out) {
    const TriangleMatrix& F = faces_.F;
    const RawEdges& e = faces_.edges;
    const Index corners = 3 * static_cast<Index>(F.rows());
    UnionFind fan(corners);
    for (Index h = 0; h < corners; ++h) {
      const Index g = e.partner[h];
      if (g < h) continue;
      const bool along = runs_up(F, e.place, h) == runs_up(F, e.place, g);
      fan.join_smaller(h, along ? g : next_half_edge(g));
      fan.join_smaller(next_half_edge(h), along ? next_half_edge(g) : g);
    }
    const auto vertex = [&](Index c) { return half_edge_source(F, c); };
    std::vector<Index> least(corners);  // of a root: its smallest vertex
    for (Index c = 0; c < corners; ++c) {
      const Index root = fan.root(c);  // the smallest corner: comes first
      least[root] = c == root ? vertex(c) : std::min(least[root], vertex(c));
    }
    std::vector<Index> owner(given_.V.rows(), -1);  // of each vertex: the fan that keeps its number
    for (Index c = 0; c < corners; ++c)
      if (fan.root(c) == c && owner[least[c]] < 0) owner[least[c]] = c;
    std::vector<Index> number(corners);  // of a root
    out.vertex_of.clear();
    for (Index v = 0; v < given_.V.rows(); ++v) {
      if (owner[v] < 0) continue;
      number[owner[v]] = static_cast<Index>(out.vertex_of.size());
      out.vertex_of.push_back(v);
    }
    for (Index c = 0; c < corners; ++c) {
      if (fan.root(c) != c || owner[least[c]] == c) continue;
      number[c] = static_cast<Index>(out.vertex_of.size());
      out.vertex_of.push_back(least[c]);
    }
    out.surface.F.resize(F.rows(), 3);
    for (Index c = 0; c < corners; ++c) out.surface.F(c / 3, c % 3) = number[fan.root(c)];
    out.surface.V.resize(static_cast<Index>(out.vertex_of.size()), 3);
    for (std::size_t v = 0; v < out.vertex_of.size(); ++v)
      out.surface.V.row(static_cast<Index>(v)) = given_.V.row(out.vertex_of[v]);
  }

  // Those that are split (but for the ends of edges that are), merged, or unused.
  void note_vertices(Cleanup& out) {
    std::vector<char> split(given_.V.rows(), 0);  // or an end of an edge that is
    for (const EdgeGroup& g : faces_.edges.others)
      for (Index i = g.begin; i < g.begin + g.count; ++i)
        for (const Index h : {faces_.edges.list[i], next_half_edge(faces_.edges.list[i])})
          split[half_edge_source(faces_.F, h)] = 1;
    std::vector<Index> corner(given_.V.rows(), -1);  // the first one at each vertex
    for (Index c = 3 * static_cast<Index>(faces_.F.rows()); c-- > 0;)
      corner[half_edge_source(faces_.F, c)] = c;
    std::vector<char> kept(given_.V.rows(), 0);
    for (const Index v : out.vertex_of) {
      if (kept[v] && !split[v]) {
        notes_.add(DefectKind::pinched_vertex, {v}, {faces_.kept[corner[v] / 3]});
        split[v] = 1;
      }
      kept[v] = 1;
    }
    for (Index v = 0; v < given_.V.rows(); ++v) {
      const Index c = corner[v];
      if (c < 0) {
        notes_.add(DefectKind::unused_vertex, {v}, {});
      } else if (!kept[v]) {
        const Index became = out.surface.F(c / 3, c % 3);
        out.merged.push_back({v, became});
        notes_.add(DefectKind::unmerged_vertex, {v, out.vertex_of[became]}, {faces_.kept[c / 3]});
      }
    }
  }

  // Of the faces that hang together the first one each; component_of: of each face.
  std::vector<Index> find_components(std::vector<Index>& component_of) const {
    std::vector<Index> first, stack;
    const TriangleMatrix& F = faces_.F;
    component_of.assign(F.rows(), -1);
    for (Index start = 0; start < F.rows(); ++start) {
      if (component_of[start] >= 0) continue;
      const auto c = static_cast<Index>(first.size());
      first.push_back(start);
      component_of[start] = c;
      for (stack.assign(1, start); !stack.empty();) {
        const Index f = stack.back();
        stack.pop_back();
        for (int k = 0; k < 3; ++k) {
          const Index h = faces_.edges.partner[3 * f + k];
          if (h < 0) continue;
          const Index g = half_edge_face(h);
          if (component_of[g] < 0) component_of[g] = c, stack.push_back(g);
        }
      }
    }
    return first;
  }

  // Faces as their neighbours are, then components outwards; open: only the former.
  Status turn_components(bool open, const RunContext& context, Cleanup& out) {
    TriangleMatrix& F = out.surface.F;
    std::vector<char>& turned = faces_.oriented.turned;
    for (Index f = 0; f < F.rows(); ++f)
      if (turned[f]) std::swap(F(f, 1), F(f, 2));
    std::vector<Index> component_of, first;
    std::vector<char> turn;
    if (!open) {
      first = find_components(component_of);
      turn.resize(first.size(), 0);
      const Result<std::vector<Index>> inward =
          inward_components(out.surface, component_of, static_cast<Index>(first.size()), context);
      if (!inward) return inward.error();
      for (const Index c : inward.value()) {
        turn[c] = 1;
        notes_.add(DefectKind::inward_component, {}, {faces_.kept[first[c]]});
      }
    }
    for (Index f = 0; f < F.rows(); ++f) {
      if (!open && turn[component_of[f]]) {
        std::swap(F(f, 1), F(f, 2));
        turned[f] = !turned[f];
      }
      if (turned[f]) out.turned.push_back(f);
    }
    out.face_of = std::move(faces_.kept);
    return success();
  }

  const Surface& given_;
  Faces faces_;
  Notes notes_;
  bool allow_open_;
};

// A map that changes nothing is left out.
void simplify(std::vector<Index>& map, Eigen::Index given) {
  if (static_cast<Eigen::Index>(map.size()) != given) return;
  for (std::size_t i = 0; i < map.size(); ++i)
    if (map[i] != static_cast<Index>(i)) return;
  map.clear();
}

std::string counted(const Defect& d) {
  const KindName& name = words(d.kind);
  return std::to_string(d.count) + " " + (d.count == 1 ? name.one : name.many);
}

void refuse(const CleanupOptions& options, Cleanup& out) {
  const Defect* first = nullptr;
  for (const Defect& d : out.defects) {
    const bool open = d.kind >= DefectKind::odd_edge && d.kind <= DefectKind::unpaired_edge;
    if (!is_mended(d.kind) && !first && !(open && options.allow_open)) first = &d;
  }
  if (!first && options.strict && !out.defects.empty()) first = &out.defects[0];
  if (!first) return;
  Error error{ErrorCode::bad_input, first->message};
  if (is_mended(first->kind)) error.message.insert(0, "A clean-up is needed, but not allowed. ");
  if (!first->places.empty()) error.place = first->places[0].position;
  out.problem = std::move(error);
}

Result<Cleanup> clean(const Surface& given, const CleanupOptions& options, const SurfaceSource& source,
                      const RunContext& context) {
  Cleanup out;
  if (!is_sane(given)) {
    out.defects.push_back({DefectKind::malformed, 1, {DefectPlace{}}, {}});
  } else {
    context.report("clean-up", 0);
    // Half-edges, their partners and corners of all faces; vertices. More than is in use at any time.
    const auto bytes =
        160 * static_cast<std::size_t>(given.F.rows()) + 80 * static_cast<std::size_t>(given.V.rows());
    if (auto full = context.no_room_for(bytes)) return *full;
    Cleaner cleaner(given, options);
    if (Status s = cleaner.run(context, out); !s) return s.error();
    out.defects = cleaner.notes().take();
  }
  for (Defect& d : out.defects) d.message = explain(d, given, source);
  if (!is_sane(given))
    if (const TopologyCheck check = check_topology(given); !check.problems.empty())
      out.defects[0].message = check.problems.front();
  refuse(options, out);
  if (out.problem) {
    out.vertex_of.clear(), out.face_of.clear(), out.turned.clear(), out.merged.clear();
    out.surface = given;
    return out;
  }
  simplify(out.vertex_of, given.V.rows());
  simplify(out.face_of, given.F.rows());
  return out;
}

}  // namespace

const char* name_of(DefectKind kind) { return words(kind).report; }
bool is_mended(DefectKind kind) { return kind < DefectKind::odd_edge; }

Status CleanupOptions::validate() const {
  if (most_places < 1 || most_places > 1000000)
    return Error{ErrorCode::usage, "The number of places to list must lie between 1 and 1000000."};
  return success();
}

std::string Cleanup::summary() const {
  if (!changed()) return {};
  std::string text;
  const char* comma = "Cleaned up: ";
  for (const Defect& d : defects) {
    if (!is_mended(d.kind)) continue;
    text += comma + counted(d);
    comma = ", ";
  }
  return text.empty() ? text : text + ".";
}

Result<Cleanup> clean_up(const Surface& surface, const CleanupOptions& options, const SurfaceSource& source,
                         const RunContext& context) {
  if (Status valid = options.validate(); !valid) return valid.error();
  try {
    const ScopedThreads threads(context.threads);
    return clean(surface, options, source, context);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::limit, "There is not enough memory for this model."};
  } catch (const std::exception& e) {
    return Error{ErrorCode::internal, std::string("Internal error, please report it: ") + e.what() + "."};
  }
}

SurfaceSource source_of(const Cleanup& cleaned, const SurfaceSource& source) {
  SurfaceSource out = source;
  const auto through = [](const std::vector<Index>& map, const auto& in_file) {
    std::vector<Index> all;
    all.reserve(map.size());
    for (const Index i : map) all.push_back(i < 0 ? -1 : in_file(i));
    return all;
  };
  if (!cleaned.vertex_of.empty())
    out.vertex = through(cleaned.vertex_of, [&](Index v) { return source.vertex_in_file(v); });
  if (!cleaned.face_of.empty())
    out.face = through(cleaned.face_of, [&](Index f) { return source.face_in_file(f); });
  return out;
}

}  // namespace overtet
