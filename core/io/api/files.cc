// The public functions on files, over the table of formats.
#include "dynmesh/files.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "core/base/text.h"
#include "core/io/api/file_input.h"
#include "core/io/common/feature_labels.h"
#include "core/io/formats/geometry.h"
#include "core/io/formats/mesh_input.h"
#include "core/io/formats/mesh_output.h"
#include "core/io/meshes/indexed_mesh.h"
#include "core/mesh_data/chambers.h"
#include "core/mesh_data/region_filter.h"

namespace dynmesh {
namespace {

// A quadtree's mesh: a vertex at the centre of each leaf.
Mesh MeshOfLeaves(const io::LeafList& list) {
  io::IndexedMesh mesh;
  mesh.dimension = list.dimension;
  for (const io::LeafList::Leaf& leaf : list.leaves) {
    const auto& [x, y, z] = leaf.centre;
    mesh.vertices.push_back({x, y, list.dimension, kNoFeature, z});
  }
  return io::ToMesh(mesh);
}

}  // namespace

FileInput io::InputOf(Geometry geometry) {
  FileInput input;
  input.features = std::move(geometry.features);
  input.options = geometry.options;
  for (const SeedRow& hole : geometry.holes) input.holes.push_back(hole.position);
  for (const Feature& f : input.features) input.places[f.id] = geometry.where(f.id);
  input.warnings = std::move(geometry.warnings);
  SetLabels(*geometry.labels, input.features);
  return input;
}

absl::StatusOr<FileInput> ReadInput(const std::string& path, const InputChoices& choices) {
  io::GeometryOptions reading;
  reading.polygons = choices.polygons;
  reading.refine = choices.refine;
  reading.keep_facets = choices.keep_facets;
  absl::StatusOr<io::Geometry> geometry = io::ReadGeometry(path, reading);
  if (!geometry.ok()) return geometry.status();
  if (geometry->options.dimension == 3 && (choices.merge_coplanar || choices.refine)) {
    if (auto s = io::JoinFaces(0, nullptr, path, *geometry); !s.ok()) return s;
  }
  return io::InputOf(*std::move(geometry));
}

absl::StatusOr<FileInput> ReadInput(const std::string& path, bool merge_coplanar) {
  return ReadInput(path, InputChoices{.merge_coplanar = merge_coplanar});
}

absl::StatusOr<std::vector<Feature>> ReadSizes(const std::string& path, const FileInput& input) {
  FeatureId last = 0;
  for (const Feature& f : input.features) last = std::max(last, f.id);
  return io::ReadSizes(path, {input.features, input.options, last + 1});
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

absl::Status WriteMesh(const Mesh& mesh, const MeshOptions& options, const std::string& path,
                       const OutputChoices& choices) {
  if (auto s = io::CheckMeshOutputOf(options, path); !s.ok()) return s;
  if (auto s = io::CheckOrder(choices.order, "order", path); !s.ok()) return s;
  const auto msh_version = io::MshVersionOf(choices.msh_version, "msh_version");
  if (!msh_version.ok()) return msh_version.status();
  io::MeshOutput output;
  output.msh_version = *msh_version;
  output.binary = choices.binary;
  output.files.from_zero = choices.from_zero;
  output.files.neighbours = choices.neighbours;
  output.files.voronoi = choices.voronoi;
  output.files.is_part = choices.part;
  io::NoteOptions(options, output.files);
  output.picture.rho = options.quality;
  output.picture.min_dihedral = options.min_dihedral;
  output.picture.crop = options.box;
  if (options.kind == MeshKind::kQuadtree) {
    output.picture.fill = io::SvgOptions::Fill::kSize;
    const absl::StatusOr<io::LeafList> leaves = io::LeavesOf(mesh, options);
    return leaves.ok() ? io::WriteLeafFile(*leaves, output, path) : leaves.status();
  }
  absl::StatusOr<io::IndexedMesh> indexed = io::IndexMesh(mesh);
  if (!indexed.ok()) return indexed.status();
  if (!mesh.labels.empty() || choices.input_markers) {
    io::LabelRows(std::make_shared<const io::FeatureLabels>(io::FromLabelColumn(mesh.labels)),
                  choices.input_markers, *indexed);
  }
  io::IndexedMesh first_order;  // of which a picture is
  if (choices.order == 2) {
    first_order = *indexed;
    output.shown = &first_order;
    io::AddMidpoints(*indexed);
  }
  return io::WriteMeshFile(*indexed, output, path);
}

absl::StatusOr<Mesh> ReadMesh(const std::string& path) {
  if (io::IsLeafFile(path)) {
    const absl::StatusOr<io::LeafList> leaves = io::ReadLeaves(path);
    return leaves.ok() ? MeshOfLeaves(*leaves) : absl::StatusOr<Mesh>(leaves.status());
  }
  const absl::StatusOr<io::MeshFiles> files = io::ReadAnyMesh(path);
  if (!files.ok()) return files.status();
  Mesh mesh = io::ToMesh(files->mesh);
  if (files->recorded_hash && !(*files->recorded_hash == mesh.hash)) {
    return absl::DataLossError(text::Concat(path, ": the file records ",
                                            files->recorded_hash->ToHex(), ", its rows have ",
                                            mesh.hash.ToHex()));
  }
  return mesh;
}

}  // namespace dynmesh
