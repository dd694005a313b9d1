// Why a surface has no tet mesh, as data that anyone can check without this library.
//
// Each type below is what one rule found: a proof that no mesh of positive tets exists with every input face
// and vertex as it is and one turn of tets around every interior edge. scripts/check_witness checks each in
// rational numbers, from the surface and the certificate alone. Vertices and faces are those of the surface
// that was examined, counted from 0; lists that name a property "of each" run along `vertices`. Positions are
// the surface's own coordinates.
//
// What the words mean. The winding number of a point says how many layers of the solid cover it. B0 of a
// vertex p is the integer (A + sum (pi - theta_e)) / 2 pi - 1, with A the winding number integrated over a
// tiny sphere around p and theta_e the interior dihedral angle at each of its edges; by Gauss and Bonnet a
// mesh has B0 = 2 c + sum k_e with c >= 0 layers that cover p without touching it and k_e >= 0 turns around
// edge e beyond theta_e, where k_e is at most the winding number on the outer side of e, all along it. An
// edge is covered when that number is positive all along. (Sources: Sacht et al. 2013, section 3, for what a
// mesh must satisfy; Blank 1967 for discs with a given boundary; docs/theory.md derives the rest and names
// all sources.)
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace overtet {

// A face without area: its corners lie on one line, and no tet with volume can have it as a face.
struct AreaCertificate {
  std::int32_t face = -1;
  std::vector<std::int32_t> vertices;            // its corners
  std::vector<std::array<double, 3>> positions;  // of each
};

// A point of negative winding number. Positive tets only ever add to it.
struct WindingCertificate {
  std::array<double, 3> point{};     // the nearest doubles
  std::array<std::string, 3> exact;  // the point itself: integers, or fractions such as "12345/65536"
  int winding = 0;                   // of the exact point, < 0
  bool doubles_suffice = false;      // the winding number at `point` is negative, too
};

// A vertex with B0 < 0.
struct VertexCertificate {
  std::int32_t vertex = -1;
  int B0 = 0;
  std::array<double, 3> position{};
};

// The same where two faces lie flat on each other at an edge of the vertex, or almost: only exact arithmetic
// can tell a dihedral angle of 0 from 2 pi there.
struct FoldCertificate {
  std::int32_t vertex = -1;
  int B0 = 0;
  std::array<double, 3> position{};
};

// Coplanar faces that lie on each other in an order that forbids a mesh. Vertices that move by moves[i] * eps
// along the normal of `face` make the winding number at `exact` negative between the faces, for every eps > 0
// that is small enough; a surface that has a mesh still has one after such a move.
struct StackCertificate {
  std::int32_t face = -1;              // its normal is (b - a) x (c - a)
  std::array<double, 3> point{};       // the nearest doubles
  std::array<std::string, 3> exact;    // integers or fractions
  std::vector<std::int32_t> vertices;  // sorted
  std::vector<int> moves;              // of each
  int winding = 0;                     // < 0
};

// An odd number of vertices with odd B0 that covered edges join to each other and to no others: over them the
// sum of B0 would have to be even.
struct UnpairedCertificate {
  std::vector<std::int32_t> vertices;            // sorted
  std::vector<int> B0;                           // of each, odd
  std::vector<std::array<double, 3>> positions;  // of each
};

// A vertex whose edges cannot take the turns that B0 asks for, whatever c is.
struct CrowdedCertificate {
  std::int32_t vertex = -1;
  int B0 = 0;
  std::array<double, 3> position{};
};

// A vertex whose surroundings no tets fill: the polygon in which its faces meet a small sphere bounds no disc
// that turns at covered edges only, in as many layers as the winding numbers allow.
struct LinkCertificate {
  std::int32_t vertex = -1;
  int B0 = 0;
  std::array<double, 3> position{};
};

// Vertices in one place. The surroundings of each need at least `layers` beyond the fewest that its faces
// show, and all that passes through the place has room for `room`, fewer than the sum.
struct SharedCertificate {
  std::vector<std::int32_t> vertices;
  std::vector<int> layers;                       // of each
  std::vector<std::array<double, 3>> positions;  // of each
  int room = 0;
};

// As UnpairedCertificate, for one component by itself: once it has moved in `direction`, however little, away
// from others that it touches, these cover none of the edges in question. Its rule is called "unpaired", too.
struct SeparatedCertificate {
  std::vector<std::int32_t> vertices;
  std::vector<int> B0;                           // of each, in the component by itself
  std::vector<std::array<double, 3>> positions;  // of each
  std::array<int, 3> direction{};
};

// Crossings of faces and edges around which the layers of the solid cannot be glued, all at once, so that one
// turn leads every layer back to itself.
struct GluingCertificate {
  struct Crossing {
    std::array<std::int32_t, 2> faces{};  // that cross,
    int layers = 0;                       // where so many layers lie in front of both;
    std::array<double, 3> position{};     // about the middle of that piece of their common curve
  };
  std::vector<Crossing> crossings;                 // sorted
  std::vector<std::array<std::int32_t, 2>> edges;  // by their vertices, the smaller one first; sorted
};

// What a rule that is not part of Overtet found: see "How to add a certificate" in CONTRIBUTING.md.
struct CustomCertificate {
  std::string rule;  // its name
  std::string explanation;
  std::vector<std::int32_t> vertices;
  std::vector<std::array<double, 3>> positions;  // of each
};

// In the order in which the rules are tried: the first that objects decides. Certificates that the library
// hands out have an entry of each list for each vertex; those that you make must, too.
using Certificate =
    std::variant<AreaCertificate, WindingCertificate, VertexCertificate, FoldCertificate, StackCertificate,
                 UnpairedCertificate, CrowdedCertificate, LinkCertificate, SharedCertificate,
                 SeparatedCertificate, GluingCertificate, CustomCertificate>;

// Whether it forbids branch lines and subdivided faces, too: a face without area, w < 0 and B0 < 0 do,
// whatever happens inside. The others rest on the one turn around every interior edge, or on where the
// surface has edges; a mesh with branch lines, or of the surface subdivided, is not ruled out by them, nor
// promised. Custom ones: unknown, so true.
bool forbids_branch_lines(const Certificate& certificate);

// "winding", "vertex", ...: what a report calls it. Valid as long as the certificate. These three functions
// throw nothing but std::bad_alloc.
const char* rule_name(const Certificate& certificate);

// One sentence for a person: where and why no mesh exists.
std::string explain(const Certificate& certificate);

// The "witness" of a report, on one line without a line end; its keys are in the README ("The report").
std::string to_json(const Certificate& certificate);

}  // namespace overtet
