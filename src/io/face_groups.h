// Labels of faces from lines that hold from there on: OBJ's o, g and usemtl, STL's solid. Internal to src/io.
#pragma once

#include <array>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "overtet/attributes.h"
#include "src/io/text.h"

namespace overtet::io_detail {

class FaceGroups {
 public:
  enum Kind { solid, group, material };

  // What is left of the line is the name of what the faces from `next_face` on belong to.
  void begin(Kind kind, TextCursor& line, std::size_t next_face);
  void begin(Kind kind, std::string name, std::size_t next_face);

  // One label for each solid, group and material that occur together, named by what differs and is not empty;
  // nothing where no line has said anything.
  void finish(std::size_t faces, SurfaceAttributes& out) const;

 private:
  // Names by their numbers, so that many changes of one do not copy the others.
  using Names = std::array<std::size_t, 3>;
  struct Change {
    std::size_t face;
    Names names;
  };
  std::vector<Change> changes_;
  std::map<std::string, std::size_t> number_of_ = {{"", 0}};
  std::vector<std::string> names_ = {""};
  std::array<bool, 3> seen_ = {};
};

// Numbers that follow the coordinates of a vertex or the corners of a face, each of another width perhaps.
class Extras {
 public:
  // What is left of the line, as far as it is numbers.
  void read(TextCursor& line, std::size_t item);
  // Where every one of the items has the same number of them, those from `first` on, `width` of them.
  // Whole numbers, if all are, become bytes where they fit.
  bool take(std::size_t items, std::size_t first, int width, const std::string& name,
            std::vector<Attribute>& out) const;
  std::size_t each() const { return each_; }

 private:
  std::vector<double> values_;
  std::size_t each_ = 0, items_ = 0;
  bool even_ = true;
};

// A label for each different value of an attribute of the faces, in order of first appearance.
Labels labels_by_value(const Attribute& values);

// What holds for polygons, for the triangles that each was cut into.
void spread_to_triangles(const std::vector<Index>& sizes, SurfaceAttributes& attributes);

}  // namespace overtet::io_detail
