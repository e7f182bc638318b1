#include <array>
#include <set>
#include <string>

#include "client/cli/input.h"
#include "core/io/common/extension.h"
#include "core/io/elements/element_mesh.h"
#include "dynmesh/error.h"
#include "tests/fuzz/small_mesh.h"
#include "tests/fuzz/targets.h"

namespace dynmesh::fuzz {
namespace {

constexpr char kName[] = "fuzz.node";

bool IsPlaced(const absl::Status& status) { return status.message().substr(0, 5) == "fuzz."; }

std::string CheckElements(const io::ElementMesh& mesh) {
  const std::size_t simplices =
      mesh.dimension == 2 ? mesh.triangles.size() : mesh.tetrahedra.size();
  if (!mesh.limits.empty() && mesh.limits.size() != simplices) return "limits of other simplices";
  if (mesh.limits.size() != mesh.limit_lines.size()) return "a limit without a line";
  if (mesh.values.size() != mesh.attributes * mesh.positions.size()) return "attributes disagree";
  const io::IndexedMesh indexed = io::ToIndexed(mesh);
  if (indexed.vertices.size() != mesh.positions.size()) return "a vertex was lost";
  return indexed.simplex_count() == simplices ? "" : "a simplex was lost";
}

std::string CheckFeatures(const cli::Input& input) {
  std::set<FeatureId> ids;
  for (const Feature& f : input.features) {
    if (f.id == kNoFeature || !ids.insert(f.id).second) return "an id stands twice";
    if (input.where(f.id).substr(0, 5) != "fuzz.") return "a feature without a place";
  }
  return "";
}

// Meshes the input, or it is refused at a place.
std::string Build(const cli::Input& input) {
  if (input.features.size() > kMostFeatures) return "";
  MeshOptions options = input.options;
  options.limits.max_vertices = options.dimension == 3 ? kMostVerticesInSpace : kMostVertices;
  const absl::StatusOr<Mesh> mesh = BuildMesh(input.features, options);
  if (mesh.ok()) return ComputeHash(*mesh) == mesh->hash ? "" : "the hash is not that of the parts";
  if (mesh.status().message().empty()) return "a refusal without a message";
  const std::optional<ErrorDetail> detail = GetErrorDetail(mesh.status());
  if (!detail || detail->features.empty()) return "";
  const absl::Status located = cli::Locate(mesh.status(), input.where);
  return IsPlaced(located) ? "" : "a refusal without a file: " + located.ToString();
}

std::string Check(const io::ElementMesh& mesh) {
  cli::InputFlags flags;
  flags.refine = true;
  absl::StatusOr<cli::Input> input = cli::InputOfElements(mesh, kName, flags);
  if (!input.ok()) {
    return IsPlaced(input.status()) ? "" : "an error without a file: " + input.status().ToString();
  }
  if (std::string problem = CheckFeatures(*input); !problem.empty()) return problem;
  if (const absl::Status seeds = cli::AddSeedPolygons(*input); !seeds.ok()) {
    return IsPlaced(seeds) ? "" : "an error without a file: " + seeds.ToString();
  }
  if (std::string problem = CheckFeatures(*input); !problem.empty()) return problem;
  return Build(*input);
}

}  // namespace

std::string FuzzMeshInput(std::string_view bytes) {
  const std::vector<std::string_view> parts = SplitFiles(bytes);
  constexpr std::array<std::string_view, 6> kExtensions = {".node", ".ele",  ".edge",
                                                           ".face", ".area", ".poly"};
  const auto open = [&](const std::string& path) -> absl::StatusOr<io::TextReader> {
    const std::string extension = io::ExtensionOf(path);
    const std::string of_part = extension == ".vol" ? ".area" : extension;
    for (std::size_t i = 0; i < kExtensions.size() && i < parts.size(); ++i) {
      if (kExtensions[i] != of_part || (i > 1 && parts[i].empty())) continue;
      return io::TextReader(path, std::string(parts[i]));
    }
    return absl::NotFoundError(path + ": no such file");
  };
  const absl::StatusOr<io::ElementMesh> mesh = io::ReadTriangleFiles(kName, open);
  if (!mesh.ok()) {
    return IsPlaced(mesh.status()) ? "" : "an error without a file: " + mesh.status().ToString();
  }
  if (std::string problem = CheckElements(*mesh); !problem.empty()) return problem;
  return Check(*mesh);
}

}  // namespace dynmesh::fuzz
