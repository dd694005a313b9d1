// Files of surfaces, tet meshes and curves.
//
// Reading keeps the order of vertices, faces and tets. Whatever is malformed is refused with one sentence
// that names the line or the element (bad_input); what cannot be opened or read is an error of code io. A
// count that the file is too short for is refused before memory is taken for it.
//
// Numbers are written in the shortest decimal form that reads back as the same double, or as the bytes
// themselves: what is read back is what was written, to the last bit. A file appears whole or not at all: it
// gets its name when all of it is on the disk, whatever ends the program. A path that names a pipe or a
// device is written to directly. Errors of writing: io.
//
// Only the number of threads of a context is used here. All functions may throw std::bad_alloc.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "overtet/attributes.h"
#include "overtet/curves.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

class AtomicFile;  // internal, src/io/file.h

// A path "-" is standard input or standard output. What is compressed by gzip is read as what it holds; a
// path that ends in .gz is written so. Extensions count in any case (.OBJ).

// Surfaces: OBJ, OFF (with colours and normals: COFF, NOFF, ...), PLY (ASCII, both byte orders), STL
// (ASCII and binary), glTF 2 (.glb and .gltf), VTP, VTU and legacy VTK (the polygons of them), MEDIT .mesh
// and Gmsh .msh (the triangles and quadrilaterals of them).

// What a file calls the vertices and faces of the surface that was read from it.
struct SurfaceSource {
  Index first = 0;                 // the number of the first vertex, and of the first face: 1 in OBJ
  const char* face_word = "face";  // "triangle" in STL
  // The file's vertex of each vertex (#V), its face of each face (#F; more than one where polygons were cut),
  // both counted from 0. Empty: they are the same.
  std::vector<Index> vertex, face;
  // The lines on which the file's vertices (of STL: the first corner there) and faces begin, counted from 1,
  // in the order of the file. Empty where the file is binary.
  std::vector<std::uint32_t> vertex_line, face_line;

  // For messages: "vertex 12", "face 7 (line 20)".
  std::string vertex_name(Index v) const;
  std::string face_name(Index f) const;
  Index vertex_in_file(Index v) const { return vertex.empty() ? v : vertex[static_cast<std::size_t>(v)]; }
  Index face_in_file(Index f) const { return face.empty() ? f : face[static_cast<std::size_t>(f)]; }
};

struct SurfaceReadInfo {
  std::string format;                // for instance "PLY, binary, little endian"
  std::int64_t polygons = 0;         // faces with more than three corners, now triangulated
  std::int64_t merged_vertices = 0;  // of an STL file: corners that share a vertex with an earlier one
  bool has_vertex_order = true;      // false for STL, which lists corners only
  std::vector<std::string> notes;    // one sentence each, for the user
  SurfaceSource source;              // what the file calls them
  SurfaceAttributes attributes;      // labels, colours and what else the file says of vertices and faces
};

// What the file begins with counts more than its extension. Polygons are cut into triangles, the equal
// vertices of STL are merged; the notes say both. Whether the surface is closed, oriented and so on
// is not looked at here: diagnose() does that. Errors: bad_input, io.
Result<Surface> read_surface(const std::string& path, SurfaceReadInfo* info = nullptr,
                             const RunContext& context = {});

// A number a vertex, in the order of the surface's, with blanks or line ends between them; # begins a
// comment. 0 means any size and is read as infinity (TetSizes::at_vertex). Errors: bad_input (the message
// names the line), io.
Result<std::vector<double>> read_sizes(const std::string& path);

enum class SurfaceFormat { off, obj, ply, vtp };  // PLY: binary, little endian, doubles; VTP: for ParaView

// By extension: .off, .obj, .ply or .vtp. Errors: usage.
Result<SurfaceFormat> surface_format_of(const std::string& path);
// labels: of the faces, if there are any, so that read_surface() has them again: numbers in OFF (after the
// corners), PLY and VTP (`label`); groups in OBJ, which are counted from 1 when they are read. Errors: io.
Status write_surface(const std::string& path, const Surface& surface, SurfaceFormat format,
                     const RunContext& context = {}, const Labels* labels = nullptr);

// Tet meshes: MEDIT .mesh, Gmsh .msh 2.2 and 4.1, VTU, TetGen .node, .ele and .face, Abaqus .inp, legacy VTK
// .vtk. Where several files belong together, all are complete before any gets its name.
//
// Besides the tets a file has what attributes.h says, as far as the format has a place for it:
//   MEDIT    Triangles with labels as references, regions as references of tets
//   Gmsh     a surface entity and a physical group for each label, a volume and a group for each region, with
//            their names; as node data and (4.1) element data what is not what one would expect: layers other
//            than 1, input_vertex and input_face other than the own numbers
//   VTU, VTK all of it: cell data of the tets, point data, and the triangles as field data (boundary_...);
//            the triangles once more as cells of a file NAME_boundary.vtp, to look at
//   TetGen   .face with labels as markers, regions as attributes in .ele
//   Abaqus   sets and surfaces for labels and regions. Coordinates that take more than the 20 characters
//            that CalculiX reads are rounded, and stand before that in a comment as they are, for
//            read_tets().

enum class TetFormat { medit, gmsh22, gmsh41, vtu, tetgen, abaqus, vtk };

// "medit", "msh22", "msh41", "vtu", "tetgen", "abaqus", "vtk". Errors: usage.
Result<TetFormat> tet_format_named(std::string_view name);
std::string_view name_of(TetFormat format);
bool keeps_layers(TetFormat format);  // whether it has a place for MeshAttributes::layers
// By extension: .mesh, .msh (4.1), .vtu, .node or .ele, .inp, .vtk, and any of these with .gz. Errors: usage.
Result<TetFormat> tet_format_of(const std::string& path);

// For TetGen the path may end in .node or .ele. Tets and nothing else. Errors: io.
Status write_tets(const std::string& path, const TetMesh& mesh, TetFormat format,
                  const RunContext& context = {});

// The files that a mesh of this format is written to, the named one first; for a pipe or standard output only
// that.
std::vector<std::string> tet_files(const std::string& path, TetFormat format);

struct TetWriteOptions {
  TetFormat format = TetFormat::medit;
  // 2: tets with ten vertices, triangles with six; those in the middle of edges, at (a + b) / 2.
  int order = 1;

  Status validate() const;  // Errors: usage.
};
// With what the attributes say. Errors: usage (options; several files to standard output), io.
Status write_tets(const std::string& path, const TetMesh& mesh, const MeshAttributes& attributes,
                  const TetWriteOptions& options, const RunContext& context = {});

// Vertices and tets in file order; `surface_vertices` is 0. Of tets with ten vertices the corners are read,
// and vertices that only lie on edges are left out. VTU: ASCII, inline binary and appended, uncompressed or
// with zlib. The extension decides, or what the file begins with. Errors: usage (neither tells), bad_input,
// io.
Result<TetMesh> read_tets(const std::string& path, const RunContext& context = {});

// The same with all that the file says besides. Triangles that no label is given for have label 0; the arrays
// that a file has no place for are as one would expect: input_face counts the triangles, input_vertex the
// vertices that triangles have.
Result<LabelledTetMesh> read_labelled_tets(const std::string& path, const RunContext& context = {});
Result<LabelledTetMesh> read_labelled_tets(const std::string& path, TetFormat format,
                                           const RunContext& context = {});

// A list of files with a time each, as ParaView's collection (.pvd): a film. `file`: as it is found from
// where the list is. The list appears whole: written again after each new file, it always names complete
// files only. Errors: io.
struct FileAtTime {
  double time = 0;
  std::string file;
};
Status write_collection(const std::string& path, const std::vector<FileAtTime>& files,
                        const RunContext& context = {});

// Curves, to look at: VTP (for ParaView; one line cell per segment, with what curves.h says of segments and
// points as data) and OBJ (one group with one `l` element per curve, no data).

enum class CurveFormat { vtp, obj };

// By extension: .vtp or .obj. Errors: usage.
Result<CurveFormat> curve_format_of(const std::string& path);
// Errors: io.
Status write_curves(const std::string& path, const Curves& curves, CurveFormat format,
                    const RunContext& context = {});

// Writes a text as it is, for instance a report's JSON. Errors: io.
Status write_text(const std::string& path, std::string_view text);

// Whether a file of this name can be written: to be asked before hours of work. Nothing is left behind. A
// pipe is kept open until this object is destroyed: its reader would take closing it for the end.
// Errors: io.
class OutputProbe {
 public:
  OutputProbe();
  ~OutputProbe();
  OutputProbe(const OutputProbe&) = delete;
  OutputProbe& operator=(const OutputProbe&) = delete;
  Status open(const std::string& path);

 private:
  std::unique_ptr<AtomicFile> file_;
};

// Removes the unfinished files that are being written. Only for programs that are about to end at once.
void remove_unfinished_files();

}  // namespace overtet
