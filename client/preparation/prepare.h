// Reads a file of geometry and makes of it what a mesh accepts, and of a surface no more faces than
// its shape needs.
//
// What a mesh refuses is cleaned (client/cleaning), with the least of a few tolerances after which
// a mesh accepts it: that of `import --clean`, or some roundings of a surface file's numbers if
// that is more, then powers of ten up to the distance D. If a mesh refuses the result for an angle,
// what meets at less than twice what it takes becomes one. Of an input without open edges, faces
// that it was folded to and that enclose nothing go. Faces of a surface file are joined again after
// that.
//
// A result that is farther than D from the input is not taken: each point of an edge or face of it
// is within D of one of the input; in 3D the other way round, too (farthest.h). If no tolerance
// helps, the input is as it was read, and `found` says why a mesh refuses it.
//
// Also of a surface with open edges: if some tolerance closes all of them within D, it is taken.
//
// Then corners of a surface file's faces are dropped where what is left of D allows it
// (thinning.h), if a mesh accepts the result, and faces are not to be kept.
//
// Then holes are filled, if asked for: loops of open edges up to a length (open_loops.h). If a mesh
// refuses what they are filled with, the surface is cleaned once more, with what is left of D. If
// that does not help, no hole is filled, and `unfilled` says why. The distance is that of all but
// the filling.
//
// A function of the file; of coordinates, but for ids. Thread-safe. Expected O(n lg n) for each
// tolerance.
#ifndef DYNMESH_CLIENT_PREPARATION_PREPARE_H_
#define DYNMESH_CLIENT_PREPARATION_PREPARE_H_

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/preparation/open_loops.h"
#include "core/io/formats/geometry.h"

namespace dynmesh::preparation {

// D without a choice, in diagonals of the box of all points.
inline constexpr double kDefaultWithin = 1e-4;

struct PrepareOptions {
  // D, in the input's units. Given, files of all formats are prepared.
  std::optional<double> within = {};
  // Of 3D: the longest loop of open edges that is filled. Given, files of all formats are prepared.
  std::optional<double> fill_holes = {};
  // The least tolerance of cleaning, of surface files. Given, what a mesh accepts is cleaned, too.
  std::optional<double> least_tolerance = {};
};

struct Report {
  bool is_mended = false;   // what a mesh refuses, or open edges
  bool is_thinned = false;  // if neither, the input is as it was read
  absl::Status found;       // what a mesh refuses of the input first; OK if nothing
  std::size_t open_edges = 0, open_edges_after = 0;  // 3D: with one face
  std::vector<OpenLoop> open_loops;                  // after all, by ascending length
  absl::Status unfilled;               // what a mesh refuses of the surface with its holes filled
  double within = 0;                   // D
  std::optional<double> least_tolerance;  // the least one that was allowed, if any was given
  double tolerance = 0, farthest = 0;     // of the cleaning; a bound of how far the result is
  double seconds = 0;
  // What was done: "points merged", and how often. Only what was done.
  std::vector<std::pair<std::string, std::size_t>> changes;
  // If it is thinned: of all polygons, before that and after it.
  std::size_t triangles_read = 0, triangles = 0;

  void Add(const char* what, std::size_t count) {
    if (count != 0) changes.emplace_back(what, count);
  }
};

struct Prepared {
  io::Geometry geometry;
  Report report;
};

// May a file with this extension be prepared? Without a distance or a length: surfaces, maps, and
// points and segments of Triangle (not facets of TetGen, which have the same extension); no scripts
// and meshes.
bool MayBePrepared(const std::string& path, const PrepareOptions& options);

// A file that is not to be prepared is as io::ReadGeometry reads it.
// INVALID_ARGUMENT for a distance, length or tolerance that is not above 0 and finite; else as
// io::ReadGeometry.
absl::StatusOr<Prepared> Prepare(const std::string& path, const io::GeometryOptions& reading,
                                 const PrepareOptions& options);

// A larger tolerance that may help where a mesh of a prepared surface takes too many vertices
// (PrepareOptions::least_tolerance); nothing if D allows none.
std::optional<double> LargerTolerance(const Report& report);
// The same, if a mesh ended with `refusal` as the surface was too fine, after its validation. Many
// faces that cross at next to no angle do so with each tolerance: nothing for a surface
// with open edges that takes too many halvings.
std::optional<double> ToleranceIfTooFine(const Report& report, const absl::Status& refusal);

// "3 x points merged, 2 x edge split; at most 1.2e-07 from the input, tolerance 1e-9".
std::string TextOf(const Report& report);
// Of a surface with open loops: how many, the lengths and places of the shortest, and the flag that
// fills them, or why that did not help. Else empty.
std::string TextOfLoops(const Report& report);

}  // namespace dynmesh::preparation

#endif  // DYNMESH_CLIENT_PREPARATION_PREPARE_H_
