#include "core/io/formats/mesh_input.h"

#include "core/base/text.h"
#include "core/io/formats/formats.h"

namespace dynmesh::io {

using text::Concat;

bool IsElementFile(const std::string& path) {
  const Format* const format = FindFormat(path);
  return format != nullptr && format->read_elements != nullptr;
}

bool IsLeafFile(const std::string& path) {
  const Format* const format = FindFormat(path);
  return format != nullptr && format->read_leaves != nullptr;
}

absl::StatusOr<ElementMesh> ReadElements(const std::string& path) {
  if (IsElementFile(path)) return FindFormat(path)->read_elements(path);
  return ReadTriangleFiles(path, &TextReader::Open);
}

absl::StatusOr<MeshFiles> ReadAnyMesh(const std::string& path) {
  const Format* const format = FindFormat(path);
  if (format == nullptr) return ReadMeshFiles(path);
  if (format->read_mesh != nullptr) return format->read_mesh(path);
  return absl::InvalidArgumentError(Concat(
      path, ": no mesh that can be read: give ",
      ListOfFormats([](const Format& f) { return f.read_mesh != nullptr && f.IsMainFile(); })));
}

absl::StatusOr<LeafList> ReadLeaves(const std::string& path) {
  if (IsLeafFile(path)) return FindFormat(path)->read_leaves(path);
  return absl::InvalidArgumentError(
      Concat(path, ": leaves of a quadtree are read from ",
             ListOfFormats([](const Format& f) { return f.read_leaves != nullptr; })));
}

absl::StatusOr<std::vector<Feature>> ReadSizes(const std::string& path, const SizedInput& input) {
  const Format* const format = FindFormat(path);
  if (format != nullptr && format->read_sizes != nullptr) return format->read_sizes(path, input);
  return absl::InvalidArgumentError(
      Concat(path, ": target lengths are read from ",
             ListOfFormats([](const Format& f) { return f.read_sizes != nullptr; }, "or", true)));
}

}  // namespace dynmesh::io
