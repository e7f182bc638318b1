// The public functions on files, over the readers and writers.
#include "dynmesh/files.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "core/base/text.h"
#include "core/coplanar/merge_coplanar.h"
#include "core/io/common/extension.h"
#include "core/io/elements/element_mesh.h"
#include "core/io/meshes/indexed_mesh.h"
#include "core/io/meshes/medit_writer.h"
#include "core/io/meshes/mesh_files.h"
#include "core/io/meshes/msh_writer.h"
#include "core/io/meshes/vtu_writer.h"
#include "core/io/plane/planar_input.h"
#include "core/io/script/edit_script.h"
#include "core/io/space/space_input.h"
#include "core/io/space/surface_files.h"
#include "core/mesh_data/chambers.h"
#include "core/mesh_data/feature_set.h"
#include "core/mesh_data/region_filter.h"
#include "dynmesh/error.h"

namespace dynmesh {
namespace {

using text::Concat;

absl::StatusOr<io::FileFeatures> ReadFeatures(const std::string& path, int* dimension) {
  const std::string extension = io::ExtensionOf(path);
  if (extension == ".node" || extension == ".poly") {
    absl::StatusOr<io::FileFeatures> planar =
        extension == ".node" ? io::ReadNodeFile(path) : io::ReadPolyFile(path);
    if (!absl::IsUnimplemented(planar.status())) return planar;  // of 3D it says so
  }
  if (io::IsElementFile(path)) {
    const absl::StatusOr<io::ElementMesh> mesh = io::ReadElements(path);
    if (!mesh.ok()) return mesh.status();
    *dimension = mesh->dimension;
    return io::FeaturesOf(*mesh, io::ElementVertices::kOfConstraints);
  }
  *dimension = 3;
  if (extension == ".node") return io::ReadSpaceNodeFile(path);
  if (extension == ".poly") return io::ReadSpacePolyFile(path);
  if (extension == ".smesh") return io::ReadSmeshFile(path);
  if (extension == ".off") return io::ReadOffFile(path);
  if (extension == ".stl") return io::ReadStlFile(path);
  if (extension == ".obj") return io::ReadObjFile(path);
  if (extension == ".ply") return io::ReadPlyFile(path);
  return absl::InvalidArgumentError(
      Concat(path,
             ": the extension must be .node, .poly, .smesh, .off, .stl, .obj, .ply, .msh, "
             ".mesh, .vtu or .dynmesh"));
}

absl::StatusOr<FileInput> ReadScript(const std::string& path) {
  const absl::StatusOr<io::EditScript> script = io::ReadEditScript(path);
  if (!script.ok()) return script.status();
  FileInput input;
  input.options = script->Options();
  mesh_data::FeatureSet features;
  for (std::size_t b = 0; b < script->batches.size(); ++b) {
    const EditBatch& edits = script->batches[b].edits;
    for (std::size_t e = 0; e < edits.size(); ++e) {
      if (auto s = features.Apply({edits[e]}); !s.ok()) {
        return absl::InvalidArgumentError(
            Concat(script->Where(b, e), ": ", text::View(s.message())));
      }
      input.places[edits[e].feature.id] = script->Where(b, e);
    }
  }
  input.features = features.Sorted();
  io::SetLabels(script->labels, input.features);
  return input;
}

}  // namespace

absl::StatusOr<FileInput> ReadInput(const std::string& path, bool merge_coplanar) {
  if (io::ExtensionOf(path) == ".dynmesh") return ReadScript(path);
  int dimension = 2;
  absl::StatusOr<io::FileFeatures> file = ReadFeatures(path, &dimension);
  if (!file.ok()) return file.status();
  FileInput input;
  for (const Feature& f : file->features) input.places[f.id] = file->Where(f.id);
  input.features = std::move(file->features);
  input.options.dimension = dimension;
  input.options.quality = DefaultQuality(dimension);
  input.options.min_dihedral = DefaultMinDihedral(dimension);
  input.options.box = io::BoundingBox(input.features, dimension);
  for (const io::SeedRow& hole : file->holes) input.holes.push_back(hole.position);
  if (merge_coplanar && dimension == 3) {
    absl::StatusOr<std::vector<Feature>> merged = coplanar::MergeCoplanar(input.features);
    if (!merged.ok()) {
      const std::optional<ErrorDetail> detail = GetErrorDetail(merged.status());
      const std::string where = detail ? input.places[detail->features[0]] : path;
      return absl::Status(merged.status().code(),
                          Concat(where, ": ", text::View(merged.status().message())));
    }
    input.features = *std::move(merged);
  }
  io::SetLabels(file->labels, input.features);
  return input;
}

absl::StatusOr<Mesh> KeepInside(const Mesh& mesh, std::span<const std::array<double, 3>> holes) {
  const mesh_data::Chambers chambers = mesh_data::FindChambers(mesh);
  std::vector<bool> dropped(chambers.count());
  for (std::size_t c = 0; c < dropped.size(); ++c) {
    dropped[c] = chambers.is_outside[c] || chambers.is_hole[c];
  }
  for (const auto& place : mesh_data::LocateInChambers(mesh, chambers, holes)) {
    if (place.chamber != mesh_data::PlaceInChambers::kNone) dropped[place.chamber] = true;
  }
  std::vector<bool> keep(mesh.simplex_count());
  for (std::size_t i = 0; i < keep.size(); ++i) keep[i] = !dropped[chambers.of[i]];
  if (std::find(keep.begin(), keep.end(), true) == keep.end()) {
    return absl::InvalidArgumentError("no closed outline or surface encloses a part of the mesh");
  }
  return mesh_data::OnlyRows(mesh, keep);
}

absl::Status WriteMesh(const Mesh& mesh, const MeshOptions& options, const std::string& path) {
  absl::StatusOr<io::IndexedMesh> indexed = io::IndexMesh(mesh);
  if (!indexed.ok()) return indexed.status();
  if (!mesh.labels.empty()) {
    io::LabelRows(std::make_shared<const io::FeatureLabels>(io::FromLabelColumn(mesh.labels)),
                  false, *indexed);
  }
  const std::string extension = io::ExtensionOf(path);
  if (extension == ".vtu") {
    return io::WriteVtu(*indexed, options.quality, path, options.min_dihedral);
  }
  if (extension == ".msh") return io::WriteMsh(*indexed, path);
  if (extension == ".mesh") return io::WriteMedit(*indexed, path);
  if (extension == ".node") {
    io::MeshFileOptions files;
    files.rho = options.quality;
    files.min_dihedral = options.min_dihedral;
    return io::WriteMeshFiles(*indexed, path, files);
  }
  return absl::InvalidArgumentError(
      Concat(path, ": the extension must be .node, .vtu, .msh or .mesh"));
}

absl::StatusOr<Mesh> ReadMesh(const std::string& path) {
  const absl::StatusOr<io::MeshFiles> files = io::ReadMeshFiles(path);
  if (!files.ok()) return files.status();
  Mesh mesh = io::ToMesh(files->mesh);
  if (files->recorded_hash && !(*files->recorded_hash == mesh.hash)) {
    return absl::DataLossError(Concat(path, ": the file records ", files->recorded_hash->ToHex(),
                                      ", its rows have ", mesh.hash.ToHex()));
  }
  return mesh;
}

}  // namespace dynmesh
