// The table of file formats: a row for each extension that dynmesh reads or writes, with what it is
// and the functions that read and write it. All that chooses by an extension asks this table:
// dynmesh/files.h, the command's reading, writing, help and errors. A new format is a row in
// formats.cc, a function that the row names, and a line in the row's document; a test compares the
// two. CONTRIBUTING.md has the other places ("A file format").
//
// Choosing goes through the functions of geometry.h, mesh_input.h and mesh_output.h. Constant data;
// functions are pure and thread-safe.
#ifndef DYNMESH_CORE_IO_FORMATS_FORMATS_H_
#define DYNMESH_CORE_IO_FORMATS_FORMATS_H_

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "dynmesh/feature.h"

namespace dynmesh::io {

struct ElementMesh;
struct FeatureOutput;
struct Geometry;
struct GeometryOptions;
struct IndexedMesh;
struct LeafList;
struct MeshFiles;
struct MeshOutput;
struct SizedInput;

// What else is to be known of a format.
enum FormatFlag : std::uint32_t {
  // The file of a mesh is one of several with a common base name; a .node is always among them.
  kBesideNode = 1 << 0,
  kPicture = 1 << 1,
  kSecondOrder = 1 << 2,    // has elements of order 2, too
  kChosenMarkers = 1 << 3,  // markers are ids of features, or on request the input's
  kMap = 1 << 4,            // rings are segments, or on request polygons
  kScript = 1 << 5,         // edits, batch by batch
  // What it keeps of features, beside points.
  kKeepsSegments = 1 << 6,
  kKeepsPolygons = 1 << 7,      // in 2D; in 3D each format of features does
  kKeepsPolygonHoles = 1 << 8,  // polygons of several rings in 3D
  kKeepsSizes = 1 << 9,
  kKeepsSeeds = 1 << 10,  // positions of holes and regions
  kKeepsMarkers = 1 << 11,
  kKeepsNames = 1 << 12,
  // Faces approximate a surface, and none has a meaning of its own: they are mended, and may be
  // joined (prepare_surface.h).
  kSurface = 1 << 13,
  kKeepsAllButSeeds = kKeepsSegments | kKeepsPolygons | kKeepsPolygonHoles | kKeepsSizes |
                      kKeepsMarkers | kKeepsNames,
};

struct Format {
  std::string_view extension;  // in lower case, with its dot
  std::string_view what;       // a few words, for lists
  bool in_2d = false, in_3d = false;
  std::uint32_t flags = 0;    // of FormatFlag
  std::string_view document;  // the file and the heading below which a table has the extension

  // What it is read as; null: it is not. A mesh of other programs is read as elements, too.
  absl::StatusOr<Geometry> (*read_geometry)(const std::string& path,
                                            const GeometryOptions& options) = nullptr;
  absl::StatusOr<ElementMesh> (*read_elements)(const std::string& path) = nullptr;
  absl::StatusOr<MeshFiles> (*read_mesh)(const std::string& path) = nullptr;
  absl::StatusOr<LeafList> (*read_leaves)(const std::string& path) = nullptr;
  absl::StatusOr<std::vector<Feature>> (*read_sizes)(const std::string& path,
                                                     const SizedInput& input) = nullptr;
  // What is written as it; null: that is not.
  absl::Status (*write_features)(const std::string& path, const FeatureOutput& output) = nullptr;
  absl::Status (*write_mesh)(const IndexedMesh& mesh, const MeshOutput& output,
                             const std::string& path) = nullptr;
  absl::Status (*write_leaves)(const LeafList& list, const MeshOutput& output,
                               const std::string& path) = nullptr;

  bool Is(FormatFlag flag) const { return (flags & flag) != 0; }
  bool IsOf(int dimension) const { return dimension == 2 ? in_2d : in_3d; }
  // Of meshes: the files that others are beside are not listed.
  bool IsMainFile() const { return !Is(kBesideNode); }
};

// All rows, in the order of lists.
std::span<const Format> Formats();

// The row of the path's extension, in any case; null if there is none.
const Format* FindFormat(const std::string& path);
// Is it the extension of geometry, a mesh or a picture that other programs have and no row is for?
// Such a file is surely no edit script.
bool IsOtherFormat(const std::string& path);

// The extensions of the rows for which `has` is true: ".off, .stl or .obj"; `last` is the word
// before the last one.
template <class Has>
std::string ListOfFormats(Has has, std::string_view last = "or", bool with_what = false);
// That of the names.
std::string JoinWords(const std::vector<std::string>& words, std::string_view last = "or");

// Lists for help and errors.
std::string GeometryFormats();  // that are input of a mesh: ".node, …; in 3D …; of meshes …"
std::string MeshOutputFormats();     // "… or .svg, of a quadtree …"
std::string FeatureOutputFormats();  // ".poly, or .dynmesh (an edit script); of 3D input also …"
// A table for `dynmesh help --formats`.
std::string FormatTable();

// ---- implementation
template <class Has>
std::string ListOfFormats(Has has, std::string_view last, bool with_what) {
  std::vector<std::string> words;
  for (const Format& format : Formats()) {
    if (!has(format)) continue;
    std::string word(format.extension);
    if (with_what) word.append(" (").append(format.what).append(")");
    words.push_back(std::move(word));
  }
  return JoinWords(words, last);
}

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_FORMATS_FORMATS_H_
