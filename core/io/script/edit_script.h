// Edit scripts: one edit a line, `#` comments.
//
//   mesh dim=2 box=x0,y0,x1,y1 rho=1.4142 [criterion=edge|thesis] [hmax=H]    first
//   mesh dim=2 box=x0,y0,x1,y1 kind=quadtree              or this; in 3D an octree
//   add point ID X Y              set point ID X Y       move point ID X Y
//   add segment ID P Q [unsplit]  set segment ID P Q [unsplit]   remove ID
//   add polygon ID P1 P2 P3 ... [/ Q1 Q2 Q3 ...] [unsplit]
//                                 its rings, with a lone / between (or set)
//   add size ID point X Y H       ... disc X Y RADIUS H  ... box X0 Y0 X1 Y1 H   (or set)
//                                 ... polygon P1 P2 P3 ... [/ Q1 Q2 Q3 ...] H
//                                 ... capsule X1 Y1 X2 Y2 ... RADIUS H    vertices of a polyline
//   commit                        ends a batch = one revision
//   marker ID N                   name ID TEXT           of a feature, for files; no edits of the
//                                                        mesh (LabelledBatches: of its label)
//
// With dim=3 every position has a z after its y: box=x0,y0,z0,x1,y1,z1, `add point ID X Y Z`, `...
// disc X Y Z RADIUS H` (a ball), `... box X0 Y0 Z0 X1 Y1 Z1 H`, `... capsule X1 Y1 Z1 ... RADIUS
// H`. Polygons are then planar facets. The default of dim is 2, that of rho sqrt 2 in 2D and 2 in
// 3D.
//
// The edits after the last commit are a batch, too; a batch without an edit is none.
#ifndef DYNMESH_CORE_IO_SCRIPT_EDIT_SCRIPT_H_
#define DYNMESH_CORE_IO_SCRIPT_EDIT_SCRIPT_H_

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/io/common/feature_labels.h"
#include "core/io/common/text_reader.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh::io {

// Ends the line of a segment or polygon that is to stay whole (Feature::unsplit).
inline constexpr std::string_view kUnsplitWord = "unsplit";

struct ScriptBatch {
  EditBatch edits;
  std::vector<int> lines;  // of edits[i]
};

// A line with a marker or a name.
struct LabelLine {
  std::size_t batch = 0;  // of the edits around it; one past the last behind them
  FeatureId id = kNoFeature;
  FeatureLabel label;  // the feature's, after this line
  int line = 0;
};

struct EditScript {
  std::string name;         // for messages: the path
  bool has_header = false;  // the `mesh` line
  int dimension = 2;
  std::optional<Box> box;  // if the header has one
  std::optional<MeshKind> kind;
  std::optional<double> quality;
  std::optional<Criterion> criterion;
  std::optional<double> max_edge;  // hmax
  std::optional<double> min_dihedral;
  int header_line = 0;
  std::vector<ScriptBatch> batches;
  FeatureLabels labels;                // after the last line
  std::vector<LabelLine> label_lines;  // in their order

  // The header's options, with defaults for missing ones. Without a box: the box of all points in
  // the script, those of sizing features included.
  MeshOptions Options() const;
  // "name:line" of an edit; of the batch's first line if there is no such edit.
  std::string Where(std::size_t batch, std::optional<std::size_t> edit) const;
  // "name:line: rho": the header's key for that member of MeshOptions; empty if it has none.
  std::string WhereOption(std::string_view option) const;
};

// The script's batches, with its labels in their edits, for a mesh that has labels. A line belongs
// to the batch that it stands in, one behind the last edit to the last batch. An added feature gets
// the label that it has at the end of its batch. Of other features a line becomes an edit of the
// label, unless the script knows that the feature is not there (yet). Without batches, the lines
// are one.
std::vector<ScriptBatch> LabelledBatches(const EditScript& script);

struct ScriptParseOptions {
  bool require_header = true;  // false if a mesh exists already
  int dimension = 2;           // without a header: that of the existing mesh
};

// INVALID_ARGUMENT as `file:line: ...`.
absl::StatusOr<EditScript> ParseEditScript(TextReader reader,
                                           const ScriptParseOptions& options = {});
absl::StatusOr<EditScript> ReadEditScript(const std::string& path,
                                          const ScriptParseOptions& options = {});

// The inverse: a script that parses to the same content.
std::string FormatMeshLine(const MeshOptions& options);  // "mesh dim=2 ...", no newline
// Its lines, each with its newline: of a marker, of a name, or none. In a name `#` becomes a blank,
// since it begins a comment.
std::string FormatLabel(FeatureId id, const FeatureLabel& label);
// One line, no newline; of an edit that sets a label, FormatLabel without the last newline.
std::string FormatEdit(const Edit& edit, int dimension = 2);

// "x0,y0,x1,y1", in 3D "x0,y0,z0,x1,y1,z1": finite numbers, x0 <= x1 and so on.
absl::StatusOr<Box> ParseBox(std::string_view text, int dimension = 2);
// "edge" or "thesis".
absl::StatusOr<Criterion> ParseCriterion(std::string_view text);

// The least box around all points among `features` and the positions of sizing features; the unit
// box if there is none.
Box BoundingBox(const std::vector<Feature>& features, int dimension = 2);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_SCRIPT_EDIT_SCRIPT_H_
