#include "tests/golden/verdicts.h"

#include <cmath>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <utility>

#include "core/io/script/edit_script.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/error.h"

namespace dynmesh::test {
namespace {

std::string VerdictOf(const absl::Status& status) {
  if (status.ok()) return "accepted";
  std::string line = absl::StatusCodeToString(status.code());
  if (const auto detail = GetErrorDetail(status)) {
    line += " " + detail->reason;
    if (detail->edit) line += " edit " + std::to_string(*detail->edit);
    for (const FeatureId id : detail->features) line += " " + std::to_string(id);
  }
  return line + ": " + std::string(status.message());
}

// The first batch is applied, the others are validated, applied and, if accepted, taken back.
void AddScript(const std::string& name, std::vector<std::string>& lines) {
  const auto script = io::ReadEditScript(DYNMESH_SOURCE_DIR "/tests/golden/" + name + ".dynmesh");
  if (!script.ok()) {
    std::cerr << script.status() << "\n";
    std::abort();
  }
  const auto mesh = DynamicMesh::Create(script->Options());
  MeshHash first;
  for (std::size_t i = 0; i < script->batches.size(); ++i) {
    const io::ScriptBatch& batch = script->batches[i];
    const absl::Status validated = (*mesh)->Validate(batch.edits);
    ApplyOptions revocable;
    revocable.revocable = i > 0;
    const absl::Status applied = (*mesh)->Apply(batch.edits, revocable).status();
    if (i == 0) first = (*mesh)->hash();
    if (i > 0 && applied.ok()) (*mesh)->TakeBack(1);
    std::string line = name + ":" + std::to_string(batch.lines.front()) + " " + VerdictOf(applied);
    // Limits are judged when the mesh is made.
    if (validated != applied) line += " | validated: " + VerdictOf(validated);
    if (!((*mesh)->hash() == first)) line += " | the mesh has changed";
    lines.push_back(std::move(line));
  }
}

void AddEdits(std::vector<std::string>& lines) {
  const double nan = std::nan("");
  const auto mesh = DynamicMesh::Create(MeshOptions());
  const auto add = [&](const std::string& what, const EditBatch& batch) {
    lines.push_back(what + " " + VerdictOf((*mesh)->Apply(batch).status()));
  };
  add("edit:nan", {Edit::Add(Feature::Point(1, nan, 0.5))});
  add("edit:infinite", {Edit::Add(Feature::Point(1, 0.5, INFINITY))});
  add("edit:zero", {Edit::Add(Feature::Point(0, 0.5, 0.5))});
  add("edit:reserved", {Edit::Add(Feature::Point(~FeatureId{0}, 0.5, 0.5))});
  Feature unknown = Feature::Point(1, 0.5, 0.5);
  unknown.kind = static_cast<FeatureKind>(77);
  add("edit:kind", {Edit::Add(unknown)});
  MeshOptions fine;
  fine.dimension = 3;
  fine.quality = 1.2;
  const auto of_space = DynamicMesh::Create(fine);
  EditBatch triangle;
  for (const FeatureId id : {1, 2, 3}) {
    triangle.push_back(
        Edit::Add(Feature::Point(id, id == 1 ? 0.25 : 0.5, id == 2 ? 0.25 : 0.5, 0.5)));
  }
  triangle.push_back(Edit::Add(Feature::Polygon(4, {{1, 2, 3}})));
  lines.push_back("edit:quality " + VerdictOf((*of_space)->Apply(triangle).status()));
  ApplyOptions few;
  few.max_operations = 1;
  lines.push_back(
      "edit:work " +
      VerdictOf((*mesh)->Apply({Edit::Add(Feature::Point(1, 0.5, 0.5))}, few).status()));
  ApplyOptions interrupted;
  interrupted.interrupted = [] { return true; };
  lines.push_back(
      "edit:interrupted " +
      VerdictOf((*mesh)->Apply({Edit::Add(Feature::Point(1, 0.5, 0.5))}, interrupted).status()));
}

void AddOptions(std::vector<std::string>& lines) {
  const auto add = [&](const std::string& what, const auto& change) {
    MeshOptions options;
    change(options);
    lines.push_back("options:" + what + " " + VerdictOf(ValidateOptions(options)));
  };
  add("dimension", [](MeshOptions& o) { o.dimension = 4; });
  add("quality", [](MeshOptions& o) { o.quality = 0.5; });
  add("quality_nan", [](MeshOptions& o) { o.quality = std::nan(""); });
  add("box", [](MeshOptions& o) { o.box.hi[0] = o.box.lo[0]; });
  add("box_infinite", [](MeshOptions& o) { o.box.hi[1] = INFINITY; });
  add("max_edge", [](MeshOptions& o) { o.max_edge = -1; });
  add("max_depth", [](MeshOptions& o) { o.limits.max_depth = 0; });
  add("max_vertices", [](MeshOptions& o) { o.limits.max_vertices = ~std::uint64_t{0}; });
  add("min_dihedral", [](MeshOptions& o) { o.min_dihedral = 30; });
  add("thesis", [](MeshOptions& o) { o.criterion = Criterion::kThesis, o.quality = 1; });
}

}  // namespace

std::vector<std::string> Verdicts() {
  std::vector<std::string> lines;
  AddScript("refused-2d", lines);
  AddScript("refused-3d", lines);
  AddEdits(lines);
  AddOptions(lines);
  return lines;
}

}  // namespace dynmesh::test
