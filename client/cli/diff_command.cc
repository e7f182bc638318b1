// dynmesh diff A B: common and different parts of two mesh files.
#include <memory>

#include "absl/strings/str_format.h"
#include "client/cli/command.h"
#include "client/cli/compare_meshes.h"
#include "client/cli/json.h"
#include "client/cli/words.h"
#include "core/base/text.h"
#include "core/io/formats/formats.h"
#include "core/io/formats/mesh_input.h"

namespace dynmesh::cli {
namespace {

struct DiffCommand {
  std::string a;
  std::string b;
  bool json = false;
};

std::string FormatJson(const MeshComparison& c) {
  JsonObject object;
  object.Add("same", c.Same());
  const auto add = [&object](const std::string& kind, const MeshComparison::Part& part) {
    object.Add(kind + "_shared", part.shared)
        .Add(kind + "_only_a", part.only_a)
        .Add(kind + "_only_b", part.only_b);
  };
  add("vertices", c.vertices);
  object.Add("vertices_remarked", c.remarked_vertices);
  add("simplices", c.simplices);
  object.Add("simplices_relabelled", c.relabelled_simplices);
  add("subsegments", c.subsegments);
  add("subfacets", c.subfacets);
  object.AddText("hash_a", c.hash_a.ToHex()).AddText("hash_b", c.hash_b.ToHex());
  return object.ToLine();
}

std::string FormatText(const MeshComparison& c, bool in_space) {
  const char* const simplices = SimplicesWord(in_space ? 3 : 2);
  std::string text;
  const auto add = [&text](const char* kind, const MeshComparison::Part& part) {
    text += absl::StrFormat("%-12s  %10d shared  %10d only in A  %10d only in B\n", kind,
                            part.shared, part.only_a, part.only_b);
  };
  add("vertices", c.vertices);
  add(simplices, c.simplices);
  add("subsegments", c.subsegments);
  if (in_space) add("subfacets", c.subfacets);
  if (c.remarked_vertices != 0) {
    text += absl::StrFormat("%d shared vertices differ in owner or containing dimension\n",
                            c.remarked_vertices);
  }
  if (c.relabelled_simplices != 0) {
    text +=
        absl::StrFormat("%d shared %s lie in other polygons\n", c.relabelled_simplices, simplices);
  }
  return text + (c.Same() ? "the meshes are the same\n" : "the meshes differ\n");
}

int Run(const DiffCommand& command) {
  const absl::StatusOr<io::MeshFiles> a = io::ReadAnyMesh(command.a);
  if (!a.ok()) return ReportError(a.status());
  const absl::StatusOr<io::MeshFiles> b = io::ReadAnyMesh(command.b);
  if (!b.ok()) return ReportError(b.status());
  if (a->mesh.dimension != b->mesh.dimension) {
    return ReportError(absl::InvalidArgumentError("one mesh is 2D, the other 3D"));
  }
  const bool in_space = a->mesh.dimension == 3;
  const MeshComparison comparison = CompareMeshes(io::ToMesh(a->mesh), io::ToMesh(b->mesh));
  if (!PrintOut(command.json ? FormatJson(comparison) : FormatText(comparison, in_space))) {
    return kExitFailed;
  }
  return comparison.Same() ? kExitDone : kExitFailed;
}

}  // namespace

void RegisterDiffCommand(CLI::App& app, CommandSlot& slot) {
  auto command = std::make_shared<DiffCommand>();
  CLI::App* const sub = AddCommand(
      app, slot, "diff", "Compare two mesh files: exit code 0 if they are the same, 1 if not",
      [command] { return Run(*command); });
  const auto is_mesh = [](const io::Format& f) { return f.read_mesh != nullptr && f.IsMainFile(); };
  sub->add_option("A", command->a,
                  text::Concat("A mesh as ", io::ListOfFormats(is_mesh),
                               ", with .ele and .edge beside a .node, in 3D .face"))
      ->required();
  sub->add_option("B", command->b, "Another")->required();
  sub->add_flag("--json", command->json, "Print one JSON object");
}

}  // namespace dynmesh::cli
