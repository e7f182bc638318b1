// Meshes of other programs as elements with markers: Gmsh's `.msh` (2.2 and 4.1), Medit's
// `.mesh` (ASCII), VTK's `.vtu` (ASCII or base64, with zlib or without), and the `.node`, `.ele`
// and so on of Triangle and TetGen. As input geometry, to be refined, or to be judged.
//
// Points, lines, triangles and tetrahedra are read; of elements of higher order the corners. Other
// elements (quadrangles, hexahedra, prisms) are errors. Reading checks form, counts and numbers of
// vertices: INVALID_ARGUMENT as `file:line: what is wrong` (in a .vtu the line of the tag),
// NOT_FOUND and the like if a file cannot be read. O(file). Plain data; functions are thread-safe.
#ifndef DYNMESH_CORE_IO_ELEMENTS_ELEMENT_MESH_H_
#define DYNMESH_CORE_IO_ELEMENTS_ELEMENT_MESH_H_

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/io/common/file_features.h"
#include "core/io/common/text_reader.h"
#include "core/io/meshes/indexed_mesh.h"

namespace dynmesh::io {

// `marker`: the physical group in Gmsh, the reference in Medit, the marker in Triangle and TetGen;
// of a .vtu the cell array `marker`, else `medit:ref` or `gmsh:physical`. 0: none.
template <std::size_t N>
struct Element {
  std::array<std::uint32_t, N> corners;  // vertices from 0
  std::int64_t marker = 0;
  int line = 0;
};

struct ElementMesh {
  std::string file;
  // 3 if there are tetrahedra, or vertices of different z.
  int dimension = 2;
  std::vector<std::array<double, 3>> positions;
  std::vector<int> lines;  // of vertices
  std::vector<Element<1>> points;
  std::vector<Element<2>> segments;
  std::vector<Element<3>> triangles;
  std::vector<Element<4>> tetrahedra;
  std::map<std::pair<int, std::int64_t>, std::string> names;  // by dimension and marker
  std::size_t attributes = 0;                                 // of a vertex
  std::vector<double> values;                                 // `attributes` each
  // Attributes of triangles (3D: tetrahedra) that are no whole numbers, by the marker for them.
  std::map<std::int64_t, double> fractions;
  // Of triangles (3D: tetrahedra): the most area (volume), from .area or .vol; not above 0: none.
  std::vector<double> limits;  // empty: no such file
  std::vector<int> limit_lines;
  // Where these are not in `file`.
  std::string segment_file, triangle_file, tetrahedron_file, limit_file;

  static const std::string& Or(const std::string& other, const std::string& file) {
    return other.empty() ? file : other;
  }
};

// By the file's format (formats/formats.h chooses by its extension).
absl::StatusOr<ElementMesh> ReadMshFile(const std::string& path);
absl::StatusOr<ElementMesh> ReadMeditFile(const std::string& path);
absl::StatusOr<ElementMesh> ReadVtuFile(const std::string& path);

// From texts in memory.
absl::StatusOr<ElementMesh> ParseMsh(TextReader reader);
absl::StatusOr<ElementMesh> ParseMedit(TextReader reader);
absl::StatusOr<ElementMesh> ParseVtu(const std::string& name, const std::string& text);

// Opens a file by its path; NOT_FOUND if there is none.
using OpenFile = std::function<absl::StatusOr<TextReader>(const std::string& path)>;
// The mesh of Triangle or TetGen of which `path` is a file: .node, .ele, and if they are there
// .poly (2D), else .edge, .face (3D), .area or .vol.
absl::StatusOr<ElementMesh> ReadTriangleFiles(const std::string& path, const OpenFile& open);

// Which vertices become points.
enum class ElementVertices : std::uint8_t {
  kOfConstraints,  // those of the segments and faces below: input geometry
  kAll,            // all, but in 3D not those on faces: the mesh is to be refined
};
// The mesh as features: segments (3D: and polygons) for its lines (3D: triangles), for the border
// of its triangles (tetrahedra), and between those of different markers. Markers and names become
// labels. Seeds, with line 0: a region for each connected part of triangles (tetrahedra) of one
// marker but 0; a hole beyond each part of the border, which may lie outside of everything.
// Vertices are numbered from 1 in file order, without those left out; -0 is 0. O(n lg n) expected.
FileFeatures FeaturesOf(const ElementMesh& mesh, ElementVertices vertices);
// Adds the limits of simplices to the features of all vertices, as sizes: in 2D polygons, in 3D the
// inscribed balls. Ids follow the others'. O(n).
void AddLimits(const ElementMesh& mesh, FileFeatures& file);

// The mesh to be measured and judged. Lines and triangles of the border are owned by their marker,
// or 1. If most simplices are turned over, all are turned.
IndexedMesh ToIndexed(const ElementMesh& mesh);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_ELEMENTS_ELEMENT_MESH_H_
