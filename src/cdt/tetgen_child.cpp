// overtet-tetgen: one TetGen call in a process of its own, so that what TetGen does wrong (crash, abort,
// print, hang, eat memory) stays here. Not a command for people: it talks binary on descriptors 0 and 1.
//
//   overtet-tetgen PARENT_PID MEMORY_BYTES
#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <tetgen.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <new>
#include <string>
#include <vector>

#include "src/cdt/predicate_counter.h"
#include "src/cdt/tetgen_wire.h"

namespace {

using overtet::tetgen_wire::Outcome;
using overtet::tetgen_wire::Reply;
using overtet::tetgen_wire::Request;

bool read_all(void* data, std::size_t bytes) {
  char* at = static_cast<char*>(data);
  while (bytes > 0) {
    const ssize_t got = read(0, at, std::min<std::size_t>(bytes, 1 << 20));
    if (got <= 0) return false;
    at += got;
    bytes -= static_cast<std::size_t>(got);
  }
  return true;
}

int reply_fd = 1;

void write_all(const void* data, std::size_t bytes) {
  const char* at = static_cast<const char*>(data);
  while (bytes > 0) {
    const ssize_t put = write(reply_fd, at, std::min<std::size_t>(bytes, 1 << 20));
    if (put <= 0) _exit(1);
    at += put;
    bytes -= static_cast<std::size_t>(put);
  }
}

[[noreturn]] void finish(const Reply& reply) {
  write_all(&reply, sizeof reply);
  _exit(0);
}

// Without a predicate, only lists are gone through: at most some microseconds a facet.
constexpr int kIdleSeconds = 10, kFacetsPerIdleSecond = 10'000;

void give_up() {
  Reply reply;
  reply.outcome = Outcome::endless;
  finish(reply);
}

void limit(int what, unsigned long long value) {
  if (value == 0) return;
  const rlimit r{static_cast<rlim_t>(value), static_cast<rlim_t>(value)};
  setrlimit(what, &r);
}

void run() {
  Request request;
  if (!read_all(&request, sizeof request) || request.magic != overtet::tetgen_wire::kMagic) finish({});
  std::vector<double> points(3 * request.vertices);
  std::vector<std::int32_t> corners(3 * request.facets);
  std::vector<double> holes(3 * request.holes);
  if (!read_all(points.data(), points.size() * sizeof(double)) ||
      !read_all(corners.data(), corners.size() * sizeof(std::int32_t)) ||
      !read_all(holes.data(), holes.size() * sizeof(double)))
    finish({});

  tetgenio in, out;
  in.firstnumber = 0;
  in.numberofpoints = static_cast<int>(request.vertices);
  in.pointlist = points.data();
  std::vector<tetgenio::polygon> polygons(request.facets);
  std::vector<tetgenio::facet> facets(request.facets);
  std::vector<int> markers(request.facets);
  for (std::int64_t f = 0; f < request.facets; ++f) {
    polygons[f].numberofvertices = 3;
    polygons[f].vertexlist = corners.data() + 3 * f;
    tetgenio::init(&facets[f]);
    facets[f].polygonlist = &polygons[f];
    facets[f].numberofpolygons = 1;
    markers[f] = static_cast<int>(f) + 1;
  }
  in.numberoffacets = static_cast<int>(request.facets);
  in.facetlist = facets.data();
  in.facetmarkerlist = markers.data();
  in.numberofholes = static_cast<int>(request.holes);
  in.holelist = holes.data();

  std::string switches = "pnQ";
  if (request.keep_facets) switches += "Y";
  if (request.fill_convex_hull) switches += "c";
  if (request.quality) {
    char text[40];
    std::snprintf(text, sizeof text, "q%.6g", request.radius_edge);
    switches += text;
  }
  if (request.most_points > 0) switches += "S" + std::to_string(request.most_points);
  if (request.tolerance > 0) {
    char text[40];
    std::snprintf(text, sizeof text, "T%.3g", request.tolerance);
    switches += text;
  }
  tetgenbehavior behaviour;
  if (!behaviour.parse_commandline(switches.data())) finish({});
  // Every facet counts for itself, no vertex is merged with another or dropped.
  behaviour.nomergefacet = 1;
  behaviour.nomergevertex = 1;
  behaviour.nojettison = 1;
  behaviour.zeroindex = 1;
  behaviour.quiet = 1;
  if (request.largest_star > 0) behaviour.flipstarsize = static_cast<int>(request.largest_star);

  namespace watch = overtet::predicate_watch;
  watch::begin(request.most_predicates,
               kIdleSeconds + static_cast<int>(request.facets / kFacetsPerIdleSecond), give_up);
  Reply reply;
  try {
    tetrahedralize(&behaviour, &in, &out, nullptr, nullptr);
  } catch (int code) {
    reply.outcome = code == 1 ? Outcome::out_of_memory : Outcome::gave_up;
    reply.tetgen_code = code;
    finish(reply);
  }

  reply.predicates = watch::calls();
  watch::end();

  // TetGen's predicates are exact and still set up for this mesh. Its tets are the mirror image of ours.
  const int n = out.numberoftetrahedra;
  for (int t = 0; t < n; ++t) {
    int* corner = out.tetrahedronlist + 4 * t;
    if (orient3d(out.pointlist + 3 * corner[0], out.pointlist + 3 * corner[1], out.pointlist + 3 * corner[2],
                 out.pointlist + 3 * corner[3]) > 0) {
      std::swap(corner[2], corner[3]);
      if (out.neighborlist) std::swap(out.neighborlist[4 * t + 2], out.neighborlist[4 * t + 3]);
    }
  }
  std::int64_t flat = 0;
  for (int t = 0; t < n; ++t) {
    const int* corner = out.tetrahedronlist + 4 * t;
    if (!(orient3d(out.pointlist + 3 * corner[0], out.pointlist + 3 * corner[1],
                   out.pointlist + 3 * corner[2], out.pointlist + 3 * corner[3]) < 0))
      ++flat;
  }
  if (flat > 0) {
    reply.outcome = Outcome::not_positive;
    reply.count = flat;
    finish(reply);
  }

  reply.outcome = Outcome::done;
  reply.vertices = out.numberofpoints;
  reply.tets = n;
  reply.facets = out.numberoftrifaces;
  std::vector<std::int32_t> source(out.numberoftrifaces, -1);
  if (out.trifacemarkerlist)
    for (int f = 0; f < out.numberoftrifaces; ++f) source[f] = out.trifacemarkerlist[f] - 1;
  write_all(&reply, sizeof reply);
  write_all(out.pointlist, sizeof(double) * 3 * out.numberofpoints);
  write_all(out.tetrahedronlist, sizeof(int) * 4 * n);
  write_all(out.neighborlist, sizeof(int) * 4 * n);
  write_all(out.trifacelist, sizeof(int) * 3 * out.numberoftrifaces);
  write_all(source.data(), sizeof(std::int32_t) * source.size());
  _exit(0);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  // Dies with its parent, also when the parent was gone before this line.
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != static_cast<pid_t>(std::strtol(argv[1], nullptr, 10))) return 1;
  limit(RLIMIT_AS, std::strtoull(argv[2], nullptr, 10));
  rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);

  // The reply gets a descriptor of its own; what TetGen prints goes nowhere.
  reply_fd = dup(1);
  const int nowhere = open("/dev/null", O_RDWR);
  if (reply_fd < 0 || nowhere < 0 || dup2(nowhere, 1) < 0 || dup2(nowhere, 2) < 0) return 1;
  try {
    run();
  } catch (const std::bad_alloc&) {
    Reply reply;
    reply.outcome = Outcome::out_of_memory;
    finish(reply);
  }
  return 1;
}
