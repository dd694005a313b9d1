// CGAL's readers, to compare with.
#pragma once

#include <cstddef>
#include <string>

// Into points and polygons (CGAL::IO::read_polygon_soup, by extension); 0 where it fails.
std::size_t faces_read_by_cgal(const std::string& path);
