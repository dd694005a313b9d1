#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdlib>
#include <unordered_map>

#include "kernels/core/tet_tables.h"
#include "kernels/core/triangles.h"
#include "src/io/abaqus.h"
#include "src/io/tet_view.h"
#include "src/io/text.h"
#include "src/io/tuning.h"

namespace overtet::io_detail {

namespace {

std::string exact(double x) {
  TextBuffer out;
  return std::string(out.number(x).view());
}

// With as many digits as there is room for.
std::string fitting(double x) {
  std::string text = exact(x);
  for (int digits = 16; text.size() > kMostCharacters; --digits) {
    char shorter[32];
    text.assign(shorter,
                std::to_chars(shorter, shorter + sizeof shorter, x, std::chars_format::general, digits).ptr);
  }
  return text;
}

// "LABEL_7_INLET" for the label 7 named "inlet!": names are of capitals, digits and underscores.
std::string set_name(std::string_view prefix, Index number, const Labels& labels) {
  std::string out(prefix);
  if (number < 0) out += 'M';
  out += std::to_string(std::abs(std::int64_t{number}));
  const auto name = labels.names.find(number);
  if (name == labels.names.end()) return out;
  out += '_';
  for (const char c : name->second)
    out += std::isalnum(static_cast<unsigned char>(c))
               ? static_cast<char>(std::toupper(static_cast<unsigned char>(c)))
               : '_';
  return out.substr(0, 72);  // at most 80 characters for most programs
}

class AbaqusWriter {
 public:
  AbaqusWriter(TextWriter& out, const TetView& m) : out_(out), m_(m) {}

  void write() {
    out_.text("*HEADING\nTet mesh by Overtet\n");
    nodes();
    elements();
    if (m_.triangles() > 0) boundary();
  }

 private:
  // Comments come before the nodes: some readers take one between them for their end.
  void nodes() {
    out_.lines(m_.vertices(), [&](TextBuffer& line, std::int64_t v) {
      bool all_fit = true;
      for (int k = 0; k < 3; ++k) all_fit &= exact(m_.coordinate(v, k)).size() <= kMostCharacters;
      if (all_fit) return;
      line.text(kAbaqus.exact).number(v + 1);
      for (int k = 0; k < 3; ++k) line.text(", ").number(m_.coordinate(v, k));
      line.end_line();
    });
    out_.text("*NODE, NSET=ALL_NODES\n");
    out_.lines(m_.vertices(), [&](TextBuffer& line, std::int64_t v) {
      line.number(v + 1);
      for (int k = 0; k < 3; ++k) line.text(", ").text(fitting(m_.coordinate(v, k)));
      line.end_line();
    });
  }

  // A block for each run of one region: elements keep their order.
  void elements() {
    const Labels& regions = m_.attributes.regions;
    for (const auto& [region, name] : regions.names)
      out_.text(kAbaqus.region_name).number(region).character(' ').text(one_line(name)).end_line();
    for (std::int64_t begin = 0; begin < m_.tets();) {
      const Index region = m_.region(begin);
      std::int64_t end = begin + 1;
      while (end < m_.tets() && m_.region(end) == region) ++end;
      out_.text(m_.second_order() ? "*ELEMENT, TYPE=C3D10, ELSET=" : "*ELEMENT, TYPE=C3D4, ELSET=");
      out_.text(set_name(kAbaqus.region, region, regions)).end_line();
      out_.lines(end - begin, [&](TextBuffer& line, std::int64_t i) {
        line.number(begin + i + 1);
        for (int k = 0; k < (m_.second_order() ? 10 : 4); ++k)
          line.text(", ").number(m_.tet(begin + i, k) + 1);
        line.end_line();
      });
      begin = end;
    }
  }

  // Of each triangle: 4 * tet + the number of its side, from 0; -1: no tet has it.
  std::vector<std::int64_t> sides() const {
    struct Hash {
      std::size_t operator()(const std::array<Index, 3>& f) const {
        std::uint64_t h = 0;
        for (const Index v : f) h = (h ^ static_cast<std::uint64_t>(v)) * 0x9E3779B97F4A7C15ull, h ^= h >> 29;
        return static_cast<std::size_t>(h);
      }
    };
    std::unordered_map<std::array<Index, 3>, std::int64_t, Hash> triangle;
    std::vector<bool> outer(static_cast<std::size_t>(m_.mesh.V.rows()));
    for (std::int64_t f = 0; f < m_.triangles(); ++f) {
      const std::array<Index, 3> corners = {m_.triangle(f, 0), m_.triangle(f, 1), m_.triangle(f, 2)};
      triangle[rotated(corners)] = f;
      for (const Index v : corners) outer[static_cast<std::size_t>(v)] = true;
    }
    std::vector<std::int64_t> out(static_cast<std::size_t>(m_.triangles()), -1);
    for (std::int64_t t = 0; t < m_.tets(); ++t)
      for (int s = 0; s < 4; ++s) {
        const auto& local = kTetFace[kAbaqusFace[s]];
        const std::array<Index, 3> face = {m_.tet(t, local[0]), m_.tet(t, local[1]), m_.tet(t, local[2])};
        if (!std::all_of(face.begin(), face.end(),
                         [&](Index v) { return outer[static_cast<std::size_t>(v)]; }))
          continue;
        if (const auto at = triangle.find(rotated(face)); at != triangle.end())
          out[static_cast<std::size_t>(at->second)] = 4 * t + s;
      }
    return out;
  }

  void surface(const std::string& name, const std::vector<std::int64_t>& faces) {
    out_.text("*SURFACE, TYPE=ELEMENT, NAME=").text(name).end_line();
    out_.lines(static_cast<std::int64_t>(faces.size()), [&](TextBuffer& line, std::int64_t i) {
      const std::int64_t f = faces[static_cast<std::size_t>(i)];
      line.number(f / 4 + 1).text(", S").number(f % 4 + 1).end_line();
    });
  }

  void boundary() {
    const Labels& labels = m_.attributes.labels;
    std::vector<std::int64_t> all = sides();
    std::map<Index, std::vector<std::int64_t>> of_label;
    std::map<Index, std::vector<Index>> nodes_of_label;
    for (std::size_t f = 0; f < all.size(); ++f) {
      if (all[f] < 0) continue;
      of_label[m_.label(static_cast<std::int64_t>(f))].push_back(all[f]);
      std::vector<Index>& nodes = nodes_of_label[m_.label(static_cast<std::int64_t>(f))];
      for (int k = 0; k < (m_.second_order() ? 6 : 3); ++k)
        nodes.push_back(m_.triangle(static_cast<std::int64_t>(f), k) + 1);
    }
    std::erase(all, -1);
    surface(std::string(kAbaqus.boundary), all);
    for (const auto& [label, name] : labels.names)
      out_.text(kAbaqus.label_name).number(label).character(' ').text(one_line(name)).end_line();
    for (auto& [label, faces] : of_label) {
      const std::string name = set_name(kAbaqus.label, label, labels);
      surface(name, faces);
      std::vector<Index>& nodes = nodes_of_label[label];
      std::sort(nodes.begin(), nodes.end());
      nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
      out_.text("*NSET, NSET=N_").text(name).end_line();
      out_.lines(static_cast<std::int64_t>(nodes.size()), [&](TextBuffer& line, std::int64_t i) {
        line.number(nodes[static_cast<std::size_t>(i)]).text(",\n");
      });
    }
  }

  TextWriter& out_;
  const TetView& m_;
};

}  // namespace

void write_abaqus(TextWriter& out, const TetView& m) { AbaqusWriter(out, m).write(); }

}  // namespace overtet::io_detail
