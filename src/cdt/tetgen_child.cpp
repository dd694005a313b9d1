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
#include "src/cdt/tuning.h"

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

// The request's complex in TetGen's form, which points into what is stored here.
class Input {
 public:
  Input(const Request& request, tetgenio& in)
      : in_(in),
        points_(3 * request.vertices),
        corners_(3 * request.facets),
        holes_(3 * request.holes),
        tets_(4 * request.tets),
        edges_(2 * request.edges),
        polygons_(request.facets),
        facets_(request.facets),
        markers_(request.facets) {
    if (!read_all(points_.data(), points_.size() * sizeof(double)) ||
        !read_all(corners_.data(), corners_.size() * sizeof(std::int32_t)) ||
        !read_all(holes_.data(), holes_.size() * sizeof(double)) ||
        !read_all(tets_.data(), tets_.size() * sizeof(std::int32_t)) ||
        !read_all(edges_.data(), edges_.size() * sizeof(std::int32_t)))
      finish({});
    in.firstnumber = 0;
    in.numberofpoints = static_cast<int>(request.vertices);
    in.pointlist = points_.data();
    if (request.tets > 0)
      take_tets(request);
    else
      take_facets(request);
    in.numberofholes = static_cast<int>(request.holes);
    in.holelist = holes_.data();
  }
  // TetGen must not free what is not its own.
  ~Input() {
    in_.pointlist = in_.holelist = nullptr;
    in_.facetlist = nullptr;
    in_.facetmarkerlist = in_.pointmarkerlist = nullptr;
    in_.tetrahedronlist = in_.trifacelist = in_.trifacemarkerlist = nullptr;
    in_.edgelist = in_.edgemarkerlist = nullptr;
  }
  Input(const Input&) = delete;
  Input& operator=(const Input&) = delete;

 private:
  void take_facets(const Request& request) {
    for (std::int64_t f = 0; f < request.facets; ++f) {
      polygons_[f].numberofvertices = 3;
      polygons_[f].vertexlist = corners_.data() + 3 * f;
      tetgenio::init(&facets_[f]);
      facets_[f].polygonlist = &polygons_[f];
      facets_[f].numberofpolygons = 1;
      markers_[f] = static_cast<int>(f) + 1;
    }
    in_.numberoffacets = static_cast<int>(request.facets);
    in_.facetlist = facets_.data();
    in_.facetmarkerlist = markers_.data();
  }

  // TetGen joins faces of one plane and one marker, and flips the edges between them, even with -Y: so every
  // face and every edge of the boundary has a marker of its own.
  void take_tets(const Request& request) {
    in_.numberofcorners = 4;
    in_.numberoftetrahedra = static_cast<int>(request.tets);
    in_.tetrahedronlist = tets_.data();
    for (std::int64_t f = 0; f < request.facets; ++f) markers_[f] = static_cast<int>(f) + 1;
    in_.numberoftrifaces = static_cast<int>(request.facets);
    in_.trifacelist = corners_.data();
    in_.trifacemarkerlist = markers_.data();
    edge_markers_.resize(request.edges);
    for (std::int64_t e = 0; e < request.edges; ++e) edge_markers_[e] = static_cast<int>(e) + 1;
    in_.numberofedges = static_cast<int>(request.edges);
    in_.edgelist = edges_.data();
    in_.edgemarkerlist = edge_markers_.data();
    point_markers_.assign(request.vertices, 1);
    for (std::int64_t v = request.kept_vertices; v < request.vertices; ++v)
      point_markers_[v] = -1;  // out with it
    in_.pointmarkerlist = point_markers_.data();
  }

  tetgenio& in_;
  std::vector<double> points_;
  std::vector<std::int32_t> corners_;
  std::vector<double> holes_;
  std::vector<std::int32_t> tets_, edges_;
  std::vector<tetgenio::polygon> polygons_;
  std::vector<tetgenio::facet> facets_;
  std::vector<int> markers_, edge_markers_, point_markers_;
};

void set_up(const Request& request, tetgenbehavior& behaviour) {
  std::string switches = request.tets > 0 ? "rRnQ" : "pnQ";
  char text[40];
  if (request.keep_facets) switches += "Y";
  if (request.fill_convex_hull) switches += "c";
  if (request.quality) {
    std::snprintf(text, sizeof text, "q%.6g", request.radius_edge);
    switches += text;
  }
  if (request.most_points > 0) switches += "S" + std::to_string(request.most_points);
  if (request.tolerance > 0) {
    std::snprintf(text, sizeof text, "T%.3g", request.tolerance);
    switches += text;
  }
  if (!behaviour.parse_commandline(switches.data())) finish({});
  // Every facet counts for itself, no vertex is merged with another or dropped.
  behaviour.nomergefacet = 1;
  behaviour.nomergevertex = 1;
  behaviour.nojettison = 1;
  behaviour.zeroindex = 1;
  behaviour.quiet = 1;
  if (request.largest_star > 0) behaviour.flipstarsize = static_cast<int>(request.largest_star);
}

// Turns all tets, which are the mirror images of ours, and counts those without volume. TetGen's predicates
// are exact and still set up for this mesh.
std::int64_t turn_tets(tetgenio& out) {
  const auto side = [&](const int* corner) {
    return orient3d(out.pointlist + 3 * corner[0], out.pointlist + 3 * corner[1],
                    out.pointlist + 3 * corner[2], out.pointlist + 3 * corner[3]);
  };
  const int n = out.numberoftetrahedra;
  for (int t = 0; t < n; ++t) {
    int* corner = out.tetrahedronlist + 4 * t;
    if (side(corner) > 0) {
      std::swap(corner[2], corner[3]);
      if (out.neighborlist) std::swap(out.neighborlist[4 * t + 2], out.neighborlist[4 * t + 3]);
    }
  }
  std::int64_t flat = 0;
  for (int t = 0; t < n; ++t) flat += !(side(out.tetrahedronlist + 4 * t) < 0);
  return flat;
}

void send(const tetgenio& out, Reply reply) {
  const int n = out.numberoftetrahedra;
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
}

void run() {
  Request request;
  if (!read_all(&request, sizeof request) || request.magic != overtet::tetgen_wire::kMagic) finish({});
  tetgenio in, out;
  const Input input(request, in);
  tetgenbehavior behaviour;
  set_up(request, behaviour);

  namespace watch = overtet::predicate_watch;
  watch::begin(request.most_predicates,
               overtet::kIdleSeconds + static_cast<int>(request.facets / overtet::kLarge), give_up);
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

  if (const std::int64_t flat = turn_tets(out); flat > 0) {
    reply.outcome = Outcome::not_positive;
    reply.count = flat;
    finish(reply);
  }
  send(out, reply);
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
