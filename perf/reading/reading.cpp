// Measures how long surfaces take to be read, and to be cleaned up, format by format:
//
//   perf_reading [--faces N] [--threads N] [--repeat N] [--folder DIR] [--cgal] [FILE...]
//
// Without files, a torus of N faces (default: a million) is written in every format, to DIR (default: the
// system's temporary folder) and read from there; also with vertices of its own for each face, which is what
// cleaning takes longest for. The best of some runs is printed: MiB, and the wall and CPU seconds to read and
// to clean up.
// --cgal: the same for CGAL's readers (one thread).
// The files stay where they are when a folder is named, so that other programs can be measured on them.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "overtet/cleanup.h"
#include "overtet/io.h"
#include "perf/reading/cgal.h"

namespace {

using namespace overtet;
namespace fs = std::filesystem;

struct Settings {
  int faces = 1'000'000, threads = 0, repeat = 3;
  bool cgal = false;
  std::string folder;
  std::vector<std::string> files;
};

Surface torus(int faces) {
  const int rows = static_cast<int>(std::sqrt(faces / 4.0)), columns = faces / (2 * rows);
  Surface s{VertexMatrix(rows * columns, 3), TriangleMatrix(2 * rows * columns, 3)};
  const double pi = std::acos(-1.0);
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) {
      const double a = 2 * pi * i / rows, b = 2 * pi * j / columns, r = 2 + 0.7 * std::cos(a);
      s.V.row(i * columns + j) << r * std::cos(b), r * std::sin(b), 0.7 * std::sin(a);
      const int p = i * columns + j, q = i * columns + (j + 1) % columns;
      const int u = (i + 1) % rows * columns + j, w = (i + 1) % rows * columns + (j + 1) % columns;
      s.F.row(2 * p) << p, q, w;
      s.F.row(2 * p + 1) << p, w, u;
    }
  return s;
}

Surface soup(const Surface& s) {
  Surface out{VertexMatrix(3 * s.F.rows(), 3), s.F};
  for (Index c = 0; c < 3 * s.F.rows(); ++c) {
    out.V.row(c) = s.V.row(s.F(c / 3, c % 3));
    out.F(c / 3, c % 3) = c;
  }
  return out;
}

void write_text_ply(const std::string& path, const Surface& s) {
  std::FILE* out = std::fopen(path.c_str(), "w");
  std::fprintf(
      out,
      "ply\nformat ascii 1.0\nelement vertex %ld\nproperty double x\nproperty double y\nproperty double z\n",
      static_cast<long>(s.V.rows()));
  std::fprintf(out, "element face %ld\nproperty list uchar int vertex_indices\nend_header\n",
               static_cast<long>(s.F.rows()));
  for (Index v = 0; v < s.V.rows(); ++v)
    std::fprintf(out, "%.9g %.9g %.9g\n", s.V(v, 0), s.V(v, 1), s.V(v, 2));
  for (Index f = 0; f < s.F.rows(); ++f) std::fprintf(out, "3 %d %d %d\n", s.F(f, 0), s.F(f, 1), s.F(f, 2));
  std::fclose(out);
}

void write_stl(const std::string& path, const Surface& s, bool text) {
  std::FILE* out = std::fopen(path.c_str(), "wb");
  const auto count = static_cast<std::uint32_t>(s.F.rows());
  if (text) {
    std::fputs("solid torus\n", out);
  } else {
    const char header[80] = {};
    std::fwrite(header, 1, sizeof header, out);
    std::fwrite(&count, 1, sizeof count, out);
  }
  for (Index f = 0; f < s.F.rows(); ++f) {
    if (text) std::fputs(" facet normal 0 0 0\n  outer loop\n", out);
    float numbers[12] = {};
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < 3; ++i) numbers[3 + 3 * k + i] = static_cast<float>(s.V(s.F(f, k), i));
      if (text)
        std::fprintf(out, "   vertex %.9g %.9g %.9g\n", numbers[3 + 3 * k], numbers[4 + 3 * k],
                     numbers[5 + 3 * k]);
    }
    if (text) {
      std::fputs("  endloop\n endfacet\n", out);
    } else {
      const std::uint16_t attributes = 0;
      std::fwrite(numbers, 1, sizeof numbers, out);
      std::fwrite(&attributes, 1, sizeof attributes, out);
    }
  }
  if (text) std::fputs("endsolid torus\n", out);
  std::fclose(out);
}

std::vector<std::string> written(const Settings& settings) {
  const Surface s = torus(settings.faces), loose = soup(s);
  std::vector<std::string> files;
  const auto add = [&](const char* name, const std::function<void(const std::string&)>& write) {
    files.push_back((fs::path(settings.folder) / name).string());
    if (!fs::exists(files.back())) write(files.back());
  };
  const auto as = [](const Surface& surface, SurfaceFormat format) {
    return [&surface, format](const std::string& path) { (void)write_surface(path, surface, format).ok(); };
  };
  add("torus.off", as(s, SurfaceFormat::off));
  add("torus.obj", as(s, SurfaceFormat::obj));
  add("torus.ply", as(s, SurfaceFormat::ply));
  add("torus_text.ply", [&](const std::string& path) { write_text_ply(path, s); });
  add("torus.stl", [&](const std::string& path) { write_stl(path, s, false); });
  add("torus_text.stl", [&](const std::string& path) { write_stl(path, s, true); });
  add("soup.obj", as(loose, SurfaceFormat::obj));
  add("soup.ply", as(loose, SurfaceFormat::ply));
  return files;
}

void measure(const std::string& path, const Settings& settings) {
  using Clock = std::chrono::steady_clock;
  RunContext context;
  context.threads = settings.threads;
  double read_best = HUGE_VAL, clean_best = HUGE_VAL, read_cpu = HUGE_VAL, clean_cpu = HUGE_VAL;
  const auto cpu = [] { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; };
  std::string what;
  for (int i = 0; i < settings.repeat; ++i) {
    const auto t0 = Clock::now();
    const double c0 = cpu();
    SurfaceReadInfo info;
    const Result<Surface> read = read_surface(path, &info, context);
    const auto t1 = Clock::now();
    const double c1 = cpu();
    if (!read) {
      std::printf("%-16s %s\n", fs::path(path).filename().c_str(), read.error().message.c_str());
      return;
    }
    const Result<Cleanup> cleaned = clean_up(read.value(), {}, info.source, context);
    const auto t2 = Clock::now();
    read_cpu = std::min(read_cpu, c1 - c0);
    clean_cpu = std::min(clean_cpu, cpu() - c1);
    read_best = std::min(read_best, std::chrono::duration<double>(t1 - t0).count());
    clean_best = std::min(clean_best, std::chrono::duration<double>(t2 - t1).count());
    what = std::to_string(read.value().F.rows()) + " faces. ";
    if (cleaned)
      what += cleaned.value().problem ? cleaned.value().problem->message : cleaned.value().summary();
  }
  std::printf("%-16s %7.1f MiB  read %6.3f s (CPU %6.3f)  clean-up %6.3f s (CPU %6.3f)  %s\n",
              fs::path(path).filename().c_str(), static_cast<double>(fs::file_size(path)) / 0x1p20, read_best,
              read_cpu, clean_best, clean_cpu, what.c_str());
}

void measure_cgal(const std::string& path, int repeat) {
  double best = HUGE_VAL;
  std::size_t faces = 0;
  for (int i = 0; i < repeat; ++i) {
    const std::clock_t start = std::clock();
    faces = faces_read_by_cgal(path);
    best = std::min(best, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  std::printf("%-16s CGAL: read, CPU %6.3f s  %zu faces\n", fs::path(path).filename().c_str(), best, faces);
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  for (int i = 1; i < argc; ++i) {
    const auto next = [&] { return i + 1 < argc ? argv[++i] : ""; };
    if (!std::strcmp(argv[i], "--faces"))
      settings.faces = std::max(16, std::atoi(next()));
    else if (!std::strcmp(argv[i], "--threads"))
      settings.threads = std::atoi(next());
    else if (!std::strcmp(argv[i], "--repeat"))
      settings.repeat = std::max(1, std::atoi(next()));
    else if (!std::strcmp(argv[i], "--cgal"))
      settings.cgal = true;
    else if (!std::strcmp(argv[i], "--folder"))
      settings.folder = next();
    else
      settings.files.push_back(argv[i]);
  }
  fs::path temporary;
  if (settings.files.empty()) {
    if (settings.folder.empty()) {
      std::string name = (fs::temp_directory_path() / "perf_reading.XXXXXX").string();
      if (!::mkdtemp(name.data())) return 1;
      temporary = settings.folder = name;
    }
    settings.files = written(settings);
  }
  for (const std::string& file : settings.files) {
    measure(file, settings);
    if (settings.cgal) measure_cgal(file, settings.repeat);
  }
  if (!temporary.empty()) fs::remove_all(temporary);
}
