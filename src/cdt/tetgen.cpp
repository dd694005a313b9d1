#include "src/cdt/tetgen.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <thread>

#include "kernels/core/triangles.h"
#include "kernels/core/tuning.h"
#include "src/cdt/manifold.h"
#include "src/cdt/tetgen_helper.h"
#include "src/cdt/tetgen_wire.h"
#include "src/cdt/tuning.h"
#include "src/cdt/unsolved.h"
#include "src/mesh/tet_complex.h"
#include "src/run/helper_program.h"

namespace overtet {

namespace {

using tetgen_wire::Outcome;
using tetgen_wire::Reply;
using tetgen_wire::Request;

double most_predicates(Eigen::Index facets) {
  return kMostPredicates + kMostPredicatesPerFacet * static_cast<double>(facets);
}

// The child and its socket; killed and reaped when this goes out of scope, whatever happened.
class Child {
 public:
  ~Child() {
    if (socket_ >= 0) close(socket_);
    if (pid_ > 0) {
      kill(pid_, SIGKILL);
      reap();
    }
  }

  Status start(const RunContext& context) {
    const Result<std::string> program = tetgen_helper(context);
    if (!program) return program.error();
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return system_error("socketpair");
    socket_ = ends[0];

    // Half the margin between what is in use and the limit would be too timid: the child gets all of it.
    unsigned long long memory = 0;
    if (context.memory_limit_bytes > 0) {
      const std::size_t used = tree_resident_bytes();
      memory = context.memory_limit_bytes > used ? context.memory_limit_bytes - used : 1;
      memory = std::max<unsigned long long>(memory, 16ull << 20);
    }
    std::string pid = std::to_string(getpid()), mem = std::to_string(memory);
    std::string name = "overtet-tetgen";
    char* argv[] = {name.data(), pid.data(), mem.data(), nullptr};

    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], 0);
    posix_spawn_file_actions_adddup2(&actions, ends[1], 1);
    posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
    pid_t pid_of_child = -1;
    const int failed = start_helper(program.value(), argv, actions, pid_of_child);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    if (failed != 0) {
      errno = failed;
      return system_error("posix_spawn");
    }
    pid_ = pid_of_child;
    return success();
  }

  // false: the child is gone. An error: the run must stop.
  Result<bool> send(const void* data, std::size_t bytes, const RunContext& context) {
    const char* at = static_cast<const char*>(data);
    while (bytes > 0) {
      if (auto error = context.stop()) return *error;
      pollfd p{socket_, POLLOUT, 0};
      if (poll(&p, 1, kLookPeriod.count()) <= 0) continue;
      const ssize_t put =
          ::send(socket_, at, std::min<std::size_t>(bytes, 1 << 20), MSG_NOSIGNAL | MSG_DONTWAIT);
      if (put < 0 && (errno == EAGAIN || errno == EINTR)) continue;
      if (put <= 0) return gone();
      at += put;
      bytes -= static_cast<std::size_t>(put);
    }
    return true;
  }

  Result<bool> receive(void* data, std::size_t bytes, const RunContext& context) {
    char* at = static_cast<char*>(data);
    while (bytes > 0) {
      if (auto error = context.stop()) return *error;
      pollfd p{socket_, POLLIN, 0};
      if (poll(&p, 1, kLookPeriod.count()) <= 0) {
        if (is_stuck()) return false;
        continue;
      }
      idle_looks_ = 0;
      const ssize_t got = recv(socket_, at, std::min<std::size_t>(bytes, 1 << 20), MSG_DONTWAIT);
      if (got < 0 && (errno == EAGAIN || errno == EINTR)) continue;
      if (got <= 0) return gone();
      at += got;
      bytes -= static_cast<std::size_t>(got);
    }
    return true;
  }

  // Waits for a child that has closed its end, and says how it ended. One that does not leave is killed; one
  // that has its end open has nothing more to say that anybody listens to, and is killed at once.
  int reap() {
    if (!gone_) {
      stays_ = true;
      kill(pid_, SIGKILL);
    }
    int status = 0;
    for (int looks = 0;; ++looks) {
      if (looks == kMostLooks) {
        stays_ = true;
        kill(pid_, SIGKILL);
      }
      const pid_t got = wait4(pid_, &status, looks < kMostLooks ? WNOHANG : 0, &usage_);
      if (got == pid_ || (got < 0 && errno != EINTR)) break;
      if (got == 0) std::this_thread::sleep_for(std::chrono::milliseconds(looks < 10 ? 1 : 10));
    }
    pid_ = -1;
    return status;
  }

  // It was waited for in vain: it neither says anything nor works.
  bool stuck() const { return idle_looks_ >= kMostIdleLooks; }

  bool stays() const { return stays_; }  // it had to be killed

  const rusage& usage() const { return usage_; }

 private:
  static Error system_error(const char* call) {
    const bool no_room = errno == ENOMEM || errno == EAGAIN;
    return Error{no_room ? ErrorCode::limit : ErrorCode::internal,
                 std::string("Could not start overtet-tetgen (") + call + ": " + std::strerror(errno) + ")."};
  }

  // Looks are counted, not seconds: who stops the whole program for a while must find it as it was.
  bool is_stuck() {
    const long ticks = processor_ticks();
    idle_looks_ = ticks == ticks_ ? idle_looks_ + 1 : 0;
    ticks_ = ticks;
    return stuck();
  }

  // That the child has used so far.
  long processor_ticks() const {
    std::ifstream in("/proc/" + std::to_string(pid_) + "/stat");
    const std::string text((std::istreambuf_iterator<char>(in)), {});
    long user = 0, system = 0;
    const auto name_end = text.rfind(')');
    if (name_end == std::string::npos ||
        std::sscanf(text.c_str() + name_end + 1, " %*c %*d %*d %*d %*d %*d %*u %*u %*u %*u %*u %ld %ld",
                    &user, &system) != 2)
      return -1;
    return user + system;
  }

  int socket_ = -1;
  pid_t pid_ = -1;
  bool gone() {
    gone_ = true;
    return false;
  }

  int idle_looks_ = 0;
  bool stays_ = false, gone_ = false;
  long ticks_ = 0;
  rusage usage_{};
};

// Why the child left without an answer.
Error explain_end(int status, const RunContext& context) {
  if (auto error = context.stop()) return *error;
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    if (context.memory_limit_bytes > 0 && signal == SIGKILL)
      return Error{.code = ErrorCode::limit,
                   .message = "TetGen was killed, most likely for lack of memory.",
                   .reason = ErrorReason::memory_limit};
    const char* name = signal == SIGSEGV   ? "a segmentation fault"
                       : signal == SIGABRT ? "an abort"
                       : signal == SIGFPE  ? "an arithmetic fault"
                                           : strsignal(signal);
    return unsolved(std::string("TetGen ended with ") + name +
                    " on these facets; they may touch or cross each other.");
  }
  return unsolved("TetGen ended without an answer.");
}

std::string vertex_list(const std::vector<Index>& ids) {
  std::string text;
  for (std::size_t i = 0; i < ids.size() && i < 5; ++i) text += (i ? ", " : "") + std::to_string(ids[i]);
  return ids.size() > 5 ? text + ", ..." : text;
}

Status check_input(const Plc& plc) {
  const Eigen::Index n = plc.V.rows();
  if (n < 4 || plc.F.rows() < 4)
    return Error{ErrorCode::bad_input, "A closed surface has at least 4 vertices and 4 facets."};
  if (!plc.V.allFinite() || !plc.holes.allFinite())
    return Error{ErrorCode::bad_input, "A coordinate is not finite."};
  if (!plc.markers.empty() && plc.markers.size() != static_cast<std::size_t>(plc.F.rows()))
    return Error{ErrorCode::usage, "One marker per facet is needed, or none."};
  for (Eigen::Index f = 0; f < plc.F.rows(); ++f) {
    const auto c = plc.F.row(f);
    for (int k = 0; k < 3; ++k)
      if (c[k] < 0 || c[k] >= n)
        return Error{ErrorCode::bad_input, "Facet " + std::to_string(f) + " has a vertex out of range."};
    if (c[0] == c[1] || c[1] == c[2] || c[2] == c[0])
      return Error{ErrorCode::bad_input, "Facet " + std::to_string(f) + " has the same vertex twice."};
  }
  std::vector<Index> order(n);
  std::iota(order.begin(), order.end(), 0);
  const auto less = [&](Index a, Index b) {
    for (int k = 0; k < 3; ++k)
      if (plc.V(a, k) != plc.V(b, k)) return plc.V(a, k) < plc.V(b, k);
    return false;
  };
  std::sort(order.begin(), order.end(), less);
  for (Eigen::Index i = 0; i + 1 < n; ++i)
    if (!less(order[i], order[i + 1]))
      return Error{ErrorCode::bad_input, "Vertices " + std::to_string(std::min(order[i], order[i + 1])) +
                                             " and " + std::to_string(std::max(order[i], order[i + 1])) +
                                             " have the same coordinates."};
  return success();
}

std::array<Index, 3> key(const TriangleMatrix& F, Eigen::Index f) {
  return sorted(std::array<Index, 3>{F(f, 0), F(f, 1), F(f, 2)});
}

// Drops TetGen's own points that no tet uses; says which input vertices none uses.
std::vector<Index> compact(TetgenResult& result, Eigen::Index input_vertices) {
  const Eigen::Index n = result.V.rows();
  std::vector<char> used(n, 0);
  for (Eigen::Index t = 0; t < result.T.rows(); ++t)
    for (int k = 0; k < 4; ++k) used[result.T(t, k)] = 1;
  std::vector<Index> lost;
  for (Eigen::Index v = 0; v < input_vertices; ++v)
    if (!used[v]) lost.push_back(static_cast<Index>(v));
  std::vector<Index> number(n, -1);
  Index next = 0;
  for (Eigen::Index v = 0; v < n; ++v)
    if (v < input_vertices || used[v]) {
      number[v] = next;
      result.V.row(next) = result.V.row(v).eval();
      ++next;
    }
  if (next == n) return lost;
  result.V.conservativeResize(next, 3);
  for (Eigen::Index t = 0; t < result.T.rows(); ++t)
    for (int k = 0; k < 4; ++k) result.T(t, k) = number[result.T(t, k)];
  for (Eigen::Index f = 0; f < result.facets.rows(); ++f)
    for (int k = 0; k < 3; ++k) result.facets(f, k) = number[result.facets(f, k)];
  return lost;
}

VertexMatrix scaled(const VertexMatrix& V, int exponent) {
  return V.unaryExpr([exponent](double x) { return std::ldexp(x, exponent); });
}

// What the child is told. V, holes: scaled.
struct Question {
  Request request;
  const VertexMatrix& V;
  const TriangleMatrix& F;
  const VertexMatrix& holes;
  TetMatrix T = {};                              // of coarsen-and-refine
  std::vector<std::array<Index, 2>> edges = {};  // of F, then
};

Request request_of(const Plc& plc, const TetgenOptions& options) {
  Request request;
  request.quality = options.quality;
  request.keep_facets = options.keep_facets;
  request.fill_convex_hull = options.fill_convex_hull;
  request.vertices = plc.V.rows();
  request.facets = plc.F.rows();
  request.holes = plc.holes.rows();
  request.radius_edge = options.radius_edge;
  request.tolerance = options.tolerance;
  request.largest_star = options.largest_star;
  request.most_predicates = static_cast<std::int64_t>(options.patience * most_predicates(plc.F.rows()));
  if (options.quality) request.most_points = kMostPointsPerVertex * plc.V.rows() + 10000;
  return request;
}

// Fills the reply and, if that is good news, the result. False: the child is gone. An error: the run must
// stop.
Result<bool> converse(Child& child, const Question& question, const RunContext& context, Reply& reply,
                      TetgenResult& result) {
  const auto receive = [&](void* data, std::size_t bytes) { return child.receive(data, bytes, context); };
  for (const auto& [data, bytes] :
       {std::pair<const void*, std::size_t>{&question.request, sizeof question.request},
        {question.V.data(), sizeof(double) * question.V.size()},
        {question.F.data(), sizeof(Index) * question.F.size()},
        {question.holes.data(), sizeof(double) * question.holes.size()},
        {question.T.data(), sizeof(Index) * question.T.size()},
        {question.edges.data(), sizeof(question.edges[0]) * question.edges.size()}})
    if (auto sent = child.send(data, bytes, context); !sent.ok() || !sent.value()) return sent;
  if (auto got = receive(&reply, sizeof reply); !got.ok() || !got.value()) return got;
  if (reply.magic != tetgen_wire::kMagic) return false;
  if (reply.outcome != Outcome::done) return true;
  constexpr std::int64_t most = std::numeric_limits<Index>::max() / 4;
  for (const std::int64_t n : {reply.vertices, reply.tets, reply.facets})
    if (n < 0 || n > most) return false;
  const std::size_t bytes = 24 * static_cast<std::size_t>(reply.vertices) +
                            32 * static_cast<std::size_t>(reply.tets) +
                            20 * static_cast<std::size_t>(reply.facets);
  if (auto error = context.no_room_for(bytes)) return *error;
  result.V.resize(reply.vertices, 3);
  result.T.resize(reply.tets, 4);
  result.neighbours.resize(reply.tets, 4);
  result.facets.resize(reply.facets, 3);
  result.facet_sources.resize(static_cast<std::size_t>(reply.facets));
  for (const auto& [data, size] :
       {std::pair<void*, std::size_t>{result.V.data(), sizeof(double) * result.V.size()},
        {result.T.data(), sizeof(Index) * result.T.size()},
        {result.neighbours.data(), sizeof(Index) * result.neighbours.size()},
        {result.facets.data(), sizeof(Index) * result.facets.size()},
        {result.facet_sources.data(), sizeof(Index) * result.facet_sources.size()}})
    if (auto got = receive(data, size); !got.ok() || !got.value()) return got;
  return true;
}

// What is wrong, from the child's own words.
std::optional<Error> refusal(const Reply& reply) {
  switch (reply.outcome) {
    case Outcome::done:
      break;
    case Outcome::out_of_memory:
      return Error{.code = ErrorCode::limit,
                   .message = "TetGen ran out of memory.",
                   .reason = ErrorReason::memory_limit};
    case Outcome::not_positive:
      return unsolved("TetGen made " + std::to_string(reply.count) + " tets without volume.");
    case Outcome::gave_up:
      return unsolved(reply.tetgen_code == 3 ? "TetGen found facets that cross each other."
                      : reply.tetgen_code == 4
                          ? "TetGen found features below its tolerance."
                          : "TetGen gave up (its code " + std::to_string(reply.tetgen_code) + ").");
    case Outcome::endless:
      return Error{ErrorCode::unsolved, "TetGen's flips did not end within the work allowed.", std::nullopt,
                   ErrorReason::endless};
    case Outcome::protocol:
      return Error{ErrorCode::internal,
                   "overtet-tetgen did not understand its input; is it of another version?"};
    default:
      return unsolved("TetGen's answer is no mesh.");
  }
  return std::nullopt;
}

// Whether it is a mesh at all that has come: numbers of things that exist, coordinates that are numbers.
bool is_sound(const TetgenResult& r) {
  const auto n = static_cast<Index>(r.V.rows()), tets = static_cast<Index>(r.T.rows());
  const auto within = [](const auto& numbers, Index least, Index end) {
    return numbers.size() == 0 || (numbers.minCoeff() >= least && numbers.maxCoeff() < end);
  };
  return r.V.allFinite() && within(r.T, 0, n) && within(r.neighbours, -1, tets) && within(r.facets, 0, n);
}

// Scales back, drops points that are not used, and looks whether the input's vertices are there. pre: no
// refusal.
std::optional<Error> take_vertices(const Plc& plc, const TetgenOptions& options, int exponent,
                                   TetgenResult& result) {
  if (result.T.rows() == 0) return unsolved("TetGen found no volume inside the facets; are they closed?");

  if (result.V.rows() < plc.V.rows()) return unsolved("TetGen lost input vertices.");
  result.V = scaled(result.V, exponent);
  for (Eigen::Index v = 0; v < plc.V.rows(); ++v)
    if (std::memcmp(result.V.data() + 3 * v, plc.V.data() + 3 * v, 3 * sizeof(double)) != 0)
      return unsolved("TetGen moved or renumbered vertex " + std::to_string(v) + ".");
  if (const auto lost = compact(result, plc.V.rows()); !lost.empty() && !options.accept_unused)
    return unsolved("TetGen left out " + std::to_string(lost.size()) + " input vertices (" +
                    vertex_list(lost) + ").");
  return std::nullopt;
}

// Finds out what each facet is part of, and whether all are there. pre: take_vertices() found nothing wrong.
std::optional<Error> take_facets(const Plc& plc, const TetgenOptions& options, TetgenResult& result) {
  result.facet_markers.resize(result.facet_sources.size());
  for (std::size_t f = 0; f < result.facet_sources.size(); ++f) {
    const Index source = result.facet_sources[f];
    if (source < 0 || source >= plc.F.rows()) return unsolved("TetGen lost track of a facet.");
    result.facet_markers[f] = plc.markers.empty() ? 1 : plc.markers[source];
  }
  if (options.keep_facets && !options.accept_split) {
    std::vector<char> seen(plc.F.rows(), 0);
    bool same = result.facets.rows() == plc.F.rows();
    for (Eigen::Index f = 0; same && f < result.facets.rows(); ++f) {
      const Index source = result.facet_sources[f];
      same = !seen[source] && key(result.facets, f) == key(plc.F, source);
      seen[source] = 1;
    }
    if (!same) return unsolved("TetGen could not keep every facet whole.");
  }
  return std::nullopt;
}

}  // namespace

Status TetgenOptions::validate() const {
  if (quality && !(radius_edge >= 1.1 && radius_edge <= 100))
    return Error{ErrorCode::usage, "The radius-edge bound must lie between 1.1 and 100."};
  if (!(tolerance >= 0 && tolerance <= 1e-3))
    return Error{ErrorCode::usage, "TetGen's tolerance must lie between 0 and 1e-3."};
  if (largest_star < 0) return Error{ErrorCode::usage, "The largest star must not be negative."};
  if (!(patience > 0)) return Error{ErrorCode::usage, "The patience with TetGen must be positive."};
  return success();
}

Result<TetgenResult> tetrahedralize(const Plc& plc, const TetgenOptions& options, const RunContext& context) {
  if (auto status = options.validate(); !status.ok()) return status.error();
  if (auto status = check_input(plc); !status.ok()) return status.error();
  if (auto error = context.stop()) return *error;
  const auto begin = RunContext::Clock::now();

  // The largest coordinate becomes about 1; a power of two changes no bit of any mantissa.
  int exponent = 0;
  std::frexp(plc.V.cwiseAbs().maxCoeff(), &exponent);
  const VertexMatrix V = scaled(plc.V, -exponent), holes = scaled(plc.holes, -exponent);
  if (scaled(V, exponent) != plc.V)
    return Error{ErrorCode::bad_input,
                 "Some coordinates are too small beside the others to be scaled exactly."};

  Child child;
  if (auto status = child.start(context); !status.ok()) return status.error();
  Reply reply;
  reply.magic = 0;
  TetgenResult result;
  const Result<bool> talk =
      converse(child, {request_of(plc, options), V, plc.F, holes}, context, reply, result);
  if (!talk.ok()) return talk.error();
  // The child's end of the socket is closed or all is said: it is leaving.
  const int status = child.reap();
  if (child.stuck()) return unsolved("TetGen neither answered nor worked for a minute, and was ended.");
  if (!talk.value() && child.stays()) return unsolved("TetGen's answer is no mesh.");
  if (!talk.value() || reply.magic != tetgen_wire::kMagic) return explain_end(status, context);
  if (auto error = refusal(reply)) return *error;
  if (!is_sound(result)) return unsolved("TetGen's answer is no mesh.");
  if (auto error = take_vertices(plc, options, exponent, result)) return *error;
  if (auto error = take_facets(plc, options, result)) return *error;
  result.predicates = reply.predicates;
  result.tetgen_facets = static_cast<Index>(plc.F.rows());
  result.seconds = std::chrono::duration<double>(RunContext::Clock::now() - begin).count();
  result.peak_rss_bytes = static_cast<std::size_t>(child.usage().ru_maxrss) * 1024;
  return result;
}

Result<TetMesh> coarsen_and_refine(const TetMesh& mesh, double radius_edge, const RunContext& context) {
  TetgenOptions options;
  options.radius_edge = radius_edge;
  if (auto status = options.validate(); !status.ok()) return status.error();
  Plc plc;
  plc.V = mesh.V;
  std::vector<std::array<Index, 2>> edges;
  {
    const std::vector<std::array<Index, 3>> faces = TetComplex(mesh.V, mesh.T).boundary();
    plc.F.resize(static_cast<Eigen::Index>(faces.size()), 3);
    for (std::size_t f = 0; f < faces.size(); ++f)
      for (int k = 0; k < 3; ++k) {
        const Index a = faces[f][k], b = faces[f][(k + 1) % 3];
        plc.F(static_cast<Eigen::Index>(f), k) = a;
        if (a < b) edges.push_back({a, b});
      }
  }
  int exponent = 0;
  std::frexp(plc.V.cwiseAbs().maxCoeff(), &exponent);
  const VertexMatrix V = scaled(plc.V, -exponent);
  Request request = request_of(plc, options);
  request.tets = mesh.T.rows();
  request.edges = static_cast<std::int64_t>(edges.size());
  request.kept_vertices = mesh.surface_vertices;

  Child child;
  if (auto status = child.start(context); !status.ok()) return status.error();
  Reply reply;
  reply.magic = 0;
  TetgenResult result;
  const Result<bool> talk =
      converse(child, {request, V, plc.F, plc.holes, mesh.T, std::move(edges)}, context, reply, result);
  if (!talk.ok()) return talk.error();
  const int status = child.reap();
  if (!talk.value() || reply.magic != tetgen_wire::kMagic) return explain_end(status, context);
  if (auto error = refusal(reply)) return *error;
  plc.V.conservativeResize(mesh.surface_vertices, 3);
  if (auto error = take_vertices(plc, options, exponent, result)) return *error;
  if (auto error = take_facets(plc, options, result)) return *error;
  if ((result.neighbours.array() < 0).count() != plc.F.rows())
    return unsolved("TetGen changed the boundary.");
  TetMesh made{std::move(result.V), std::move(result.T), mesh.surface_vertices};
  if (const auto split = make_manifold(made, result.neighbours); !split) return split.error();
  return made;
}

}  // namespace overtet
