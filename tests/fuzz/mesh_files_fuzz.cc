#include <optional>

#include "client/verify/verify.h"
#include "core/io/meshes/mesh_files.h"
#include "dynmesh/quality.h"
#include "tests/fuzz/small_mesh.h"
#include "tests/fuzz/targets.h"

namespace dynmesh::fuzz {
namespace {

std::string Measure(const io::MeshFiles& files) {
  const Mesh mesh = io::ToMesh(files.mesh);
  if (mesh.vertices.size() != files.mesh.vertices.size()) return "a vertex was lost";
  if (!(ComputeHash(mesh) == mesh.hash)) return "the hash is not that of the parts";
  MeshOptions options;
  options.dimension = mesh.dimension;
  if (mesh.dimension == 3) options.min_dihedral = 10;
  const std::vector<SimplexVerdict> verdicts = JudgeSimplices(mesh, options);
  const QualityReport quality = MeasureQuality(mesh, options);
  std::uint64_t exempt = 0, over = 0, below = 0;
  for (const SimplexVerdict verdict : verdicts) {
    exempt += IsExempt(verdict) ? 1 : 0;
    over += IsOverRho(verdict) ? 1 : 0;
    below += verdict == SimplexVerdict::kBelowDihedral ? 1 : 0;
  }
  if (exempt != quality.exempt || over != quality.over_rho) return "two verdicts disagree";
  if (below > quality.below_dihedral || quality.below_dihedral > below + over) {
    return "two verdicts on dihedral angles disagree";
  }
  // A file may repeat what a mesh has once; then there is no index, but an error.
  const absl::StatusOr<io::IndexedMesh> indexed = io::IndexMesh(mesh);
  if (indexed.ok() && indexed->simplex_count() != files.mesh.simplex_count()) {
    return "a simplex was lost";
  }
  return "";
}

}  // namespace

std::string FuzzMeshFiles(std::string_view bytes) {
  const std::vector<std::string_view> parts = SplitFiles(bytes);
  const auto part = [&](std::size_t i, const char* name) {
    return io::TextReader(name, std::string(i < parts.size() ? parts[i] : std::string_view()));
  };
  std::optional<io::TextReader> edges;
  if (parts.size() > 2) edges = part(2, "fuzz.edge");
  std::optional<io::TextReader> faces;
  if (parts.size() > 3) faces = part(3, "fuzz.face");
  const absl::StatusOr<io::MeshFiles> files = io::ParseMeshFiles(
      part(0, "fuzz.node"), part(1, "fuzz.ele"), std::move(edges), std::move(faces));
  if (!files.ok()) {
    const bool placed = files.status().message().substr(0, 5) == "fuzz.";
    return placed ? "" : "an error without a file: " + files.status().ToString();
  }
  if (files->has_edges != (parts.size() > 2)) return "edges from nowhere";
  if (files->has_faces != (parts.size() > 3 && files->mesh.dimension == 3)) {
    return "faces from nowhere";
  }
  if (const std::string problem = Measure(*files); !problem.empty()) return problem;
  const cli::VerifyReport report = cli::VerifyMesh(*files, kDefaultQuality2D, nullptr);
  for (const auto scope : {cli::MeshScope::kPart, cli::MeshScope::kForeign}) {
    cli::VerifyMesh(*files, kDefaultQuality2D, nullptr, std::nullopt, scope, false);
  }
  return report.checks.empty() ? "the judge made no check" : "";
}

}  // namespace dynmesh::fuzz
