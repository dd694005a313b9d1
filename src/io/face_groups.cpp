#include "src/io/face_groups.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <utility>

#include "src/io/text.h"

namespace overtet::io_detail {

void FaceGroups::begin(Kind kind, TextCursor& line, std::size_t next_face) {
  std::string name;
  while (!line.at_line_end()) {
    if (!name.empty()) name += ' ';
    name += line.token();
  }
  begin(kind, std::move(name), next_face);
}

void FaceGroups::begin(Kind kind, std::string name, std::size_t next_face) {
  seen_[kind] = true;
  if (changes_.empty() || changes_.back().face != next_face)
    changes_.push_back({next_face, changes_.empty() ? Names{} : changes_.back().names});
  const auto [at, is_new] = number_of_.try_emplace(one_line(name), names_.size());
  if (is_new) names_.push_back(at->first);
  changes_.back().names[kind] = at->second;
}

void FaceGroups::finish(std::size_t faces, SurfaceAttributes& out) const {
  if (changes_.empty()) return;
  std::map<Names, Index> labels;
  std::map<std::size_t, Index> solids;
  std::vector<Names> met;
  out.faces.of.resize(faces);
  if (seen_[solid]) out.solids.of.resize(faces);
  std::size_t at = 0;
  const Names none{};
  for (std::size_t f = 0; f < faces;) {
    while (at < changes_.size() && changes_[at].face <= f) ++at;
    const std::size_t end = at < changes_.size() ? std::min(changes_[at].face, faces) : faces;
    const Names& names = at == 0 ? none : changes_[at - 1].names;
    const auto [label, is_new] = labels.try_emplace(names, static_cast<Index>(labels.size() + 1));
    if (is_new) met.push_back(names);
    const auto own = solids.try_emplace(names[solid], static_cast<Index>(solids.size() + 1)).first;
    for (; f < end; ++f) {
      out.faces.of[f] = label->second;
      if (seen_[solid]) out.solids.of[f] = own->second;
    }
  }
  for (std::size_t i = 0; i < met.size(); ++i) {
    std::string name;
    for (const std::size_t part : met[i])
      if (!names_[part].empty() && name.find(names_[part]) == std::string::npos)
        name += (name.empty() ? "" : ":") + names_[part];
    if (!name.empty()) out.faces.names[static_cast<Index>(i + 1)] = name;
  }
  if (seen_[solid])
    for (const auto& [name, number] : solids)
      if (name != 0) out.solids.names[number] = names_[name];
}

void Extras::read(TextCursor& line, std::size_t item) {
  std::size_t count = 0;
  while (!line.at_line_end()) {
    const std::string_view t = line.token();
    double x = 0;
    const auto [stop, code] = std::from_chars(t.data(), t.data() + t.size(), x);
    if (code != std::errc() || stop != t.data() + t.size() || !std::isfinite(x)) {
      even_ = false;
      return;
    }
    values_.push_back(x);
    ++count;
  }
  if (item == 0) each_ = count;
  even_ &= count == each_ && item == items_;
  ++items_;
}

bool Extras::take(std::size_t items, std::size_t first, int width, const std::string& name,
                  std::vector<Attribute>& out) const {
  const auto wide = static_cast<std::size_t>(width);
  if (!even_ || items_ != items || each_ < first + wide) return false;
  Attribute a{name, NumberType::float64, width, {}};
  a.values.reserve(items * wide);
  bool bytes = true;
  for (std::size_t i = 0; i < items; ++i)
    for (std::size_t k = 0; k < wide; ++k) {
      const double x = values_[i * each_ + first + k];
      bytes &= x >= 0 && x <= 255 && x == std::floor(x);
      a.values.push_back(x);
    }
  // Colours are bytes or shares of 1; 0 and 1 alone may be either, and are taken for what they are.
  const double most = a.values.empty() ? 0 : *std::max_element(a.values.begin(), a.values.end());
  if (bytes && most > 1) a.type = NumberType::uint8;
  out.push_back(std::move(a));
  return true;
}

Labels labels_by_value(const Attribute& a) {
  const auto width = static_cast<std::size_t>(a.width);
  std::map<std::vector<double>, Index> met;
  Labels out;
  for (std::size_t i = 0; i + width <= a.values.size(); i += width) {
    const std::vector<double> value(a.values.begin() + static_cast<std::ptrdiff_t>(i),
                                    a.values.begin() + static_cast<std::ptrdiff_t>(i + width));
    const auto [label, is_new] = met.try_emplace(value, static_cast<Index>(met.size() + 1));
    if (is_new) {
      std::string name = a.name;
      for (const double x : value) {
        char text[32];
        name += ' ';
        name.append(text, std::to_chars(text, text + sizeof text, x).ptr);
      }
      out.names[label->second] = name;
    }
    out.of.push_back(label->second);
  }
  return out;
}

void spread_to_triangles(const std::vector<Index>& sizes, SurfaceAttributes& a) {
  std::vector<Index> polygon;
  for (std::size_t f = 0; f < sizes.size(); ++f)
    polygon.insert(polygon.end(), static_cast<std::size_t>(sizes[f] - 2), static_cast<Index>(f));
  if (polygon.size() == sizes.size()) return;
  const auto spread = [&](auto& values, std::size_t width) {
    if (values.empty()) return;
    std::remove_reference_t<decltype(values)> out;
    out.reserve(polygon.size() * width);
    for (const Index f : polygon)
      for (std::size_t k = 0; k < width; ++k) out.push_back(values[static_cast<std::size_t>(f) * width + k]);
    values = std::move(out);
  };
  spread(a.faces.of, 1);
  spread(a.solids.of, 1);
  for (Attribute& d : a.face_data) spread(d.values, static_cast<std::size_t>(d.width));
}

}  // namespace overtet::io_detail
