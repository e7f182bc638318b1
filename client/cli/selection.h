// The flags that choose a part of a mesh to write: --inside, --region, --outside, --open.
#ifndef DYNMESH_CLIENT_CLI_SELECTION_H_
#define DYNMESH_CLIENT_CLI_SELECTION_H_

#include <span>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/cli/input.h"
#include "core/mesh_data/chambers.h"
#include "core/mesh_data/region_filter.h"
#include "dynmesh/mesh.h"

namespace dynmesh::cli {

struct SelectionFlags {
  bool inside = false;
  std::string region;
  std::string outside;
  std::string open;  // features along which the part is opened
  // What is chosen without a flag: the inside, if there is any.
  bool inside_by_default = false;
  bool surroundings = false;  // not even then
};
void AddSelectionFlags(CLI::App& command, SelectionFlags& flags);
// --open
void AddOpenFlag(CLI::App& command, std::string& text);
// --surroundings
void AddSurroundingsFlag(CLI::App& command, SelectionFlags& flags);

// What the flags choose. Thread-compatible.
class Selection {
 public:
  // Checks the form of the flags. `input`: what the mesh is made of, after AddSeedPolygons; it must
  // outlive the result. `has_holes`: may the word holes be given?
  static absl::StatusOr<Selection> Parse(const SelectionFlags& flags, const Input& input,
                                         bool has_holes);

  bool IsEverything() const { return !inside_ && !by_holes_ && choice_.IsEverything(); }
  // Is it the inside, and nothing else?
  bool IsInside() const { return inside_ && !by_holes_ && choice_.IsEverything(); }
  // The chosen part of `mesh`, which is whole. INVALID_ARGUMENT, with a list of what exists, if it
  // is empty or a polygon is not in the mesh. Prints a warning for a hole that marks nothing, and
  // if nothing is enclosed where the inside is the default: then it is the whole mesh.
  absl::StatusOr<Mesh> Of(const Mesh& mesh) const;
  // Is it opened along features?
  bool IsOpened() const { return !open_.empty(); }
  // The same, opened: for files (MeshPart::ToMesh). INVALID_ARGUMENT, too, if one of the features
  // is nowhere in the chosen part.
  absl::StatusOr<Mesh> OpenedOf(const Mesh& mesh) const;

 private:
  absl::Status CheckPolygons(const Mesh& mesh) const;
  absl::Status DropChambers(const Mesh& mesh, std::vector<bool>& keep) const;
  // Of several chambers of a surface file: those that it does not wind around are no inside.
  void DropCavities(const Mesh& mesh, const mesh_data::Chambers& chambers,
                    std::vector<bool>& dropped) const;
  absl::Status NothingLeft(const Mesh& mesh) const;
  std::string WhyNothingIsInside(const Mesh& mesh) const;

  const Input* input_ = nullptr;
  bool inside_ = false;
  bool is_default_ = false;  // inside_, without a flag
  bool by_holes_ = false;    // leave out the chambers with the seeds of holes; 3D
  mesh_data::RegionChoice choice_;
  std::vector<FeatureId> open_;
};

// Is a part of the whole mesh enclosed? O(mesh).
bool Encloses(const Mesh& mesh);

// "3, 7, 12", of more than ten "3, 7, ... and 4 more".
std::string ListOf(std::span<const FeatureId> ids);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_SELECTION_H_
