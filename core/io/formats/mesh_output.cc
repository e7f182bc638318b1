#include "core/io/formats/mesh_output.h"

#include "core/base/text.h"
#include "core/io/common/extension.h"
#include "core/io/formats/formats.h"

namespace dynmesh::io {
namespace {

using text::Concat;

absl::Status Error(const std::string& path, const std::string& what) {
  return absl::InvalidArgumentError(Concat(path, ": ", what));
}

}  // namespace

absl::Status CheckMeshOutput(const std::string& path) {
  const Format* const format = FindFormat(path);
  if (format == nullptr || (format->write_mesh == nullptr && format->write_leaves == nullptr)) {
    if (ExtensionOf(path) == ".png") {
      return absl::UnimplementedError(
          Concat(path, ": .png files as output are not supported yet in this version"));
    }
    return Error(path, Concat("the extension must tell what to write: ", MeshOutputFormats()));
  }
  return absl::OkStatus();
}

void NoteOptions(const MeshOptions& options, MeshFileOptions& files) {
  files.is_triangulation = options.kind == MeshKind::kTriangulation;
  files.rho = options.quality;
  files.min_dihedral = options.min_dihedral;
}

absl::Status CheckMeshOutputOf(const MeshOptions& options, const std::string& path) {
  const Format* const format = FindFormat(path);
  if (format == nullptr) return CheckMeshOutput(path);
  if (options.kind == MeshKind::kQuadtree) {
    if (format->write_leaves != nullptr) return absl::OkStatus();
    return Error(path, Concat("a quadtree is written as ", ListOfFormats([](const Format& f) {
                                return f.write_leaves != nullptr;
                              })));
  }
  if (format->write_mesh == nullptr) {
    if (format->write_leaves == nullptr) return CheckMeshOutput(path);
    return Error(path, Concat("only the leaves of a quadtree are written as ", format->extension));
  }
  if (!format->IsOf(options.dimension)) {
    return options.dimension == 2
               ? Error(path, Concat("a ", format->extension, " is of 3D; a 2D mesh takes .poly"))
               : Error(path, Concat("a ", format->extension, " is of 2D"));
  }
  return absl::OkStatus();
}

std::string SecondOrderFormats() {
  return ListOfFormats([](const Format& f) { return f.Is(kSecondOrder) && f.IsMainFile(); }, "and");
}

absl::Status CheckOrder(int order, std::string_view name, const std::string& path) {
  if (order != 1 && order != 2) return Error(path, Concat(name, " is 1 or 2"));
  const Format* const format = FindFormat(path);
  if (order == 1 || format == nullptr || format->Is(kPicture) || format->Is(kSecondOrder)) {
    return absl::OkStatus();
  }
  return Error(path, Concat(name, " 2 is for ", SecondOrderFormats()));
}

absl::Status WriteMeshFile(const IndexedMesh& mesh, const MeshOutput& output,
                           const std::string& path) {
  const Format* const format = FindFormat(path);
  if (format == nullptr || format->write_mesh == nullptr) return CheckMeshOutputOf({}, path);
  return format->write_mesh(mesh, output, path);
}

absl::Status WriteLeafFile(const LeafList& list, const MeshOutput& output,
                           const std::string& path) {
  const Format* const format = FindFormat(path);
  if (format == nullptr || format->write_leaves == nullptr) {
    MeshOptions options;
    options.kind = MeshKind::kQuadtree;
    return CheckMeshOutputOf(options, path);
  }
  return format->write_leaves(list, output, path);
}

absl::Status CheckFeatureOutput(int dimension, const std::string& path) {
  const Format* const format = FindFormat(path);
  if (format != nullptr && format->write_features != nullptr && format->IsOf(dimension)) {
    return absl::OkStatus();
  }
  const auto list = [&](bool is_script) {
    return ListOfFormats([&](const Format& f) {
      return f.write_features != nullptr && f.IsOf(dimension) && f.Is(kScript) == is_script;
    });
  };
  return absl::InvalidArgumentError(
      Concat(path, " is neither a ", list(false), " nor a ", list(true), " (an edit script)"));
}

absl::Status WriteFeatureFile(const std::string& path, const FeatureOutput& output) {
  const Format* const format = FindFormat(path);
  if (format == nullptr || format->write_features == nullptr) {
    return CheckFeatureOutput(output.options.dimension, path);
  }
  return format->write_features(path, output);
}

}  // namespace dynmesh::io
