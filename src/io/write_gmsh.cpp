#include <algorithm>

#include "src/io/tet_view.h"
#include "src/io/text.h"

namespace overtet::io_detail {

namespace {

// Gmsh's entities and groups have positive numbers: other labels get the first free ones, and are kept in
// the name of the group ("label -3", "label -3 inlet").
struct Groups {
  std::map<Index, Index> tag;          // of each label that occurs
  std::map<Index, std::string> names;  // of tags
  Groups(std::int64_t n, const Labels& labels) {
    const std::map<Index, std::int64_t> all = occurring(n, labels.of);
    Index free = 0;
    for (const auto& [label, count] : all) {
      if (label <= 0) do
          ++free;
        while (all.contains(free));
      tag[label] = label > 0 ? label : free;
      const auto name = labels.names.find(label);
      if (label <= 0) names[free] = "label " + std::to_string(label);
      if (name != labels.names.end()) names[tag[label]] += (label > 0 ? "" : " ") + name->second;
    }
  }
};

// As "1 inlet": without the quotes that Gmsh puts around it.
std::string plain_name(std::string_view given) {
  std::string name = one_line(given);
  std::replace(name.begin(), name.end(), '"', '\'');
  return name;
}

// Neighbours in the file with one label: what 4.1 calls a block.
struct Run {
  std::int64_t begin, end;
  Index tag;
};
std::vector<Run> runs_of(std::int64_t n, const std::vector<Index>& labels, const Groups& groups) {
  std::vector<Run> runs;
  for (std::int64_t i = 0; i < n;) {
    const Index label = labels.empty() ? 1 : labels[static_cast<std::size_t>(i)];
    std::int64_t end = i + 1;
    while (end < n && (labels.empty() || labels[static_cast<std::size_t>(end)] == label)) ++end;
    runs.push_back({i, end, groups.tag.at(label)});
    i = end;
  }
  return runs;
}

class GmshWriter {
 public:
  GmshWriter(TextWriter& out, const TetView& m)
      : out_(out),
        m_(m),
        surfaces_(m.triangles(), m.attributes.labels),
        volumes_(m.tets(), m.attributes.regions),
        grouped_(!m.attributes.regions.of.empty()) {}

  void write(bool v41) {
    out_.text(v41 ? "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n" : "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n");
    names();
    if (v41) entities();
    v41 ? nodes41() : nodes22();
    v41 ? elements41() : elements22();
    if (v41) element_data();
    const std::vector<Index>& input = m_.attributes.input_vertex;
    bool own = true;
    for (std::size_t v = 0; v < input.size(); ++v) own &= input[v] == static_cast<Index>(v) || input[v] < 0;
    std::vector<Index> vertices = input;
    vertices.resize(static_cast<std::size_t>(m_.vertices()), -1);
    if (!own) data("NodeData", "input_vertex", {&vertices});
  }

 private:
  // Not in files of version 2.2: meshio reads none that have any.
  void element_data() {
    const MeshAttributes& a = m_.attributes;
    const std::vector<Index> none_of_tets(static_cast<std::size_t>(m_.tets()), -1),
        none_of_faces(static_cast<std::size_t>(m_.triangles()), 0);
    if (std::any_of(a.layers.begin(), a.layers.end(), [](Index n) { return n != 1; }))
      data("ElementData", "layers", {&a.layers, &none_of_faces});
    bool own = true;
    for (std::size_t f = 0; f < a.input_face.size(); ++f) own &= a.input_face[f] == static_cast<Index>(f);
    if (!own) data("ElementData", "input_face", {&none_of_tets, &a.input_face});
  }

  void names() {
    const std::size_t count = surfaces_.names.size() + (grouped_ ? volumes_.names.size() : 0);
    if (count == 0) return;
    out_.text("$PhysicalNames\n").number(static_cast<std::int64_t>(count)).end_line();
    for (const int dimension : {2, 3}) {
      if (dimension == 3 && !grouped_) continue;
      for (const auto& [tag, name] : (dimension == 2 ? surfaces_ : volumes_).names)
        out_.number(dimension).character(' ').number(tag).text(" \"").text(plain_name(name)).text("\"\n");
    }
    out_.text("$EndPhysicalNames\n");
  }

  // Every entity has the box of the whole.
  void entity(Index tag, bool group, const std::vector<Index>& bounded_by) {
    const VertexMatrix& V = m_.mesh.V;
    out_.number(tag);
    for (const bool high : {false, true})
      for (int k = 0; k < 3; ++k)
        out_.character(' ').number(V.rows() == 0 ? 0.0 : high ? V.col(k).maxCoeff() : V.col(k).minCoeff());
    if (group)
      out_.text(" 1 ").number(tag);
    else
      out_.text(" 0");
    out_.character(' ').number(static_cast<std::int64_t>(bounded_by.size()));
    for (const Index b : bounded_by) out_.character(' ').number(b);
    out_.end_line();
  }

  void entities() {
    out_.text("$Entities\n0 0 ").number(static_cast<std::int64_t>(surfaces_.tag.size())).character(' ');
    out_.number(static_cast<std::int64_t>(volumes_.tag.size())).end_line();
    for (const auto& [label, tag] : surfaces_.tag) entity(tag, true, {});
    for (const auto& [label, tag] : volumes_.tag) entity(tag, grouped_, bounds(tag));
    out_.text("$EndEntities\n");
  }

  // Which surfaces bound a volume: those of the tets' vertices.
  std::vector<Index> bounds(Index volume) {
    if (surfaces_.tag.empty()) return {};
    if (volume_of_vertex_.empty()) {
      volume_of_vertex_.resize(static_cast<std::size_t>(m_.mesh.V.rows()));
      for (Eigen::Index t = 0; t < m_.mesh.T.rows(); ++t)
        for (int k = 0; k < 4; ++k)
          volume_of_vertex_[static_cast<std::size_t>(m_.mesh.T(t, k))] = volumes_.tag.at(m_.region(t));
    }
    std::vector<Index> tags;
    Index last = 0;
    for (std::int64_t f = 0; f < m_.triangles(); ++f) {
      if (volume_of_vertex_[static_cast<std::size_t>(m_.triangle(f, 0))] != volume) continue;
      const Index tag = surfaces_.tag.at(m_.label(f));
      if (tag != last) tags.push_back(last = tag);
    }
    std::sort(tags.begin(), tags.end());
    tags.erase(std::unique(tags.begin(), tags.end()), tags.end());
    return tags;
  }

  void nodes22() {
    out_.text("$Nodes\n").number(m_.vertices()).end_line();
    out_.lines(m_.vertices(), [&](TextBuffer& line, std::int64_t v) {
      m_.coordinates(line.number(v + 1).character(' '), v).end_line();
    });
    out_.text("$EndNodes\n");
  }

  void nodes41() {
    const Index volume = volumes_.tag.empty() ? 1 : volumes_.tag.begin()->second;
    out_.text("$Nodes\n1 ").number(m_.vertices()).text(" 1 ").number(m_.vertices()).end_line();
    out_.text("3 ").number(volume).text(" 0 ").number(m_.vertices()).end_line();
    out_.lines(m_.vertices(), [&](TextBuffer& line, std::int64_t v) { line.number(v + 1).end_line(); });
    out_.lines(m_.vertices(), [&](TextBuffer& line, std::int64_t v) { m_.coordinates(line, v).end_line(); });
    out_.text("$EndNodes\n");
  }

  TextBuffer& tet(TextBuffer& line, std::int64_t t) const {
    return m_.tet(line, t, 1, {0, 1, 2, 3, 5, 4});  // Gmsh has the last two the other way round
  }

  // The tets first, so that their numbers are the mesh's.
  void elements22() {
    const bool second = m_.second_order();
    out_.text("$Elements\n").number(m_.tets() + m_.triangles()).end_line();
    out_.lines(m_.tets(), [&](TextBuffer& line, std::int64_t t) {
      const Index tag = volumes_.tag.at(m_.region(t));
      line.number(t + 1).text(second ? " 11 2 " : " 4 2 ").number(tag).character(' ').number(tag);
      tet(line.character(' '), t).end_line();
    });
    out_.lines(m_.triangles(), [&](TextBuffer& line, std::int64_t f) {
      const Index tag = surfaces_.tag.at(m_.label(f));
      line.number(m_.tets() + f + 1).text(second ? " 9 2 " : " 2 2 ").number(tag).character(' ').number(tag);
      m_.triangle(line.character(' '), f, 1).end_line();
    });
    out_.text("$EndElements\n");
  }

  void elements41() {
    const bool second = m_.second_order();
    const std::vector<Run> tets = runs_of(m_.tets(), m_.attributes.regions.of, volumes_),
                           faces = runs_of(m_.triangles(), m_.attributes.labels.of, surfaces_);
    const std::int64_t count = m_.tets() + m_.triangles();
    out_.text("$Elements\n").number(static_cast<std::int64_t>(tets.size() + faces.size()));
    out_.character(' ').number(count).text(" 1 ").number(count).end_line();
    for (const Run& r : tets) {
      out_.text("3 ").number(r.tag).text(second ? " 11 " : " 4 ").number(r.end - r.begin).end_line();
      out_.lines(r.end - r.begin, [&](TextBuffer& line, std::int64_t i) {
        tet(line.number(r.begin + i + 1).character(' '), r.begin + i).end_line();
      });
    }
    for (const Run& r : faces) {
      out_.text("2 ").number(r.tag).text(second ? " 9 " : " 2 ").number(r.end - r.begin).end_line();
      out_.lines(r.end - r.begin, [&](TextBuffer& line, std::int64_t i) {
        m_.triangle(line.number(m_.tets() + r.begin + i + 1).character(' '), r.begin + i, 1).end_line();
      });
    }
    out_.text("$EndElements\n");
  }

  // One number for each node or element, 0 or -1 where there is none: some readers want them all.
  void data(const std::string& section, const char* name,
            const std::vector<const std::vector<Index>*>& parts) {
    std::int64_t count = 0;
    for (const auto* part : parts) count += static_cast<std::int64_t>(part->size());
    out_.text("$" + section + "\n1\n\"").text(name).text("\"\n1\n0\n3\n0\n1\n").number(count).end_line();
    std::int64_t first = 1;
    for (const auto* part : parts) {
      const auto size = static_cast<std::int64_t>(part->size());
      out_.lines(size, [&](TextBuffer& line, std::int64_t i) {
        line.number(first + i).character(' ').number((*part)[static_cast<std::size_t>(i)]).end_line();
      });
      first += size;
    }
    out_.text("$End" + section + "\n");
  }

  TextWriter& out_;
  const TetView& m_;
  Groups surfaces_, volumes_;
  bool grouped_;
  std::vector<Index> volume_of_vertex_;
};

}  // namespace

void write_gmsh22(TextWriter& out, const TetView& m) { GmshWriter(out, m).write(false); }
void write_gmsh41(TextWriter& out, const TetView& m) { GmshWriter(out, m).write(true); }

}  // namespace overtet::io_detail
