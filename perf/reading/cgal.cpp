#include "perf/reading/cgal.h"

#include <CGAL/IO/polygon_soup_io.h>
#include <CGAL/Simple_cartesian.h>

#include <vector>

std::size_t faces_read_by_cgal(const std::string& path) {
  std::vector<CGAL::Simple_cartesian<double>::Point_3> points;
  std::vector<std::vector<std::size_t>> faces;
  return CGAL::IO::read_polygon_soup(path, points, faces) ? faces.size() : 0;
}
