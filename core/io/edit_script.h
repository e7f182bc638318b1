// Edit scripts: one edit a line, `#` comments.
//
//   mesh dim=2 box=x0,y0,x1,y1 rho=1.4142 [criterion=edge|thesis] [hmax=H]    first
//   add point ID X Y              set point ID X Y       move point ID X Y
//   add segment ID P Q            set segment ID P Q     remove ID
//   add polygon ID P1 P2 P3 ... [/ Q1 Q2 Q3 ...]         its rings, with a lone / between (or set)
//   add size ID point X Y H       ... disc X Y RADIUS H  ... box X0 Y0 X1 Y1 H   (or set)
//                                 ... polygon P1 P2 P3 ... [/ Q1 Q2 Q3 ...] H
//   commit                        ends a batch = one revision
//
// What follows the last commit is a batch too; a batch without an edit is none.
// dim=3 is part of the grammar and refused with UNIMPLEMENTED until there are such meshes.
#ifndef DYNMESH_CORE_IO_EDIT_SCRIPT_H_
#define DYNMESH_CORE_IO_EDIT_SCRIPT_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/io/text_reader.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh::io {

struct ScriptBatch {
  EditBatch edits;
  std::vector<int> lines;  // of edits[i]
};

struct EditScript {
  std::string name;         // stands in messages: the path
  bool has_header = false;  // the `mesh` line
  std::optional<Box> box;   // if the header gives one
  std::optional<double> quality;
  std::optional<Criterion> criterion;
  std::optional<double> max_edge;  // hmax
  std::vector<ScriptBatch> batches;

  // The header's options; what it leaves out has its default. Without a box: that
  // of all points the script mentions, those of sizing features included.
  MeshOptions Options() const;
  // "name:line" of an edit; of the batch's first line if there is no such edit.
  std::string Where(std::size_t batch, std::optional<std::size_t> edit) const;
};

struct ScriptParseOptions {
  bool require_header = true;  // not needed where a mesh is there already
};

// INVALID_ARGUMENT (UNIMPLEMENTED for what is to come) as `file:line: ...`.
absl::StatusOr<EditScript> ParseEditScript(TextReader reader,
                                           const ScriptParseOptions& options = {});
absl::StatusOr<EditScript> ReadEditScript(const std::string& path,
                                          const ScriptParseOptions& options = {});

// The other way: a script that parses to the same thing.
std::string FormatMeshLine(const MeshOptions& options);  // "mesh dim=2 ...", no newline
std::string FormatEdit(const Edit& edit);                // one line, no newline

// "x0,y0,x1,y1": four finite numbers, x0 <= x1, y0 <= y1.
absl::StatusOr<Box> ParseBox(std::string_view text);
// "edge" or "thesis".
absl::StatusOr<Criterion> ParseCriterion(std::string_view text);

// The least box around all points among `features` and places of sizing features; the unit
// box if there is none.
Box BoundingBox(const std::vector<Feature>& features, int dimension = 2);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_EDIT_SCRIPT_H_
