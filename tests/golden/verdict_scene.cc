#include "tests/golden/verdict_scene.h"

#include <algorithm>
#include <cstdlib>
#include <iostream>

#include "core/io/script/edit_script.h"
#include "dynmesh/error.h"

namespace dynmesh::test {

std::string TextOf(const absl::Status& status) {
  if (status.ok()) return "OK";
  std::string text = absl::StatusCodeToString(status.code());
  if (const auto detail = GetErrorDetail(status)) {
    text += " " + detail->reason;
    for (std::size_t i = 0; i < detail->features.size(); ++i) {
      text += (i == 0 ? " features " : ", ") + std::to_string(detail->features[i]);
    }
    if (detail->edit) text += " edit " + std::to_string(*detail->edit);
  }
  return text + ": " + std::string(status.message());
}

EditBatch Batch(std::string text, int dimension) {
  std::replace(text.begin(), text.end(), ';', '\n');
  const auto script = io::ParseEditScript(io::TextReader("verdicts", std::move(text)),
                                          {.require_header = false, .dimension = dimension});
  if (!script.ok()) {
    std::cerr << script.status() << "\n";
    std::abort();
  }
  return script->batches.empty() ? EditBatch() : script->batches[0].edits;
}

Scene::Scene(std::vector<std::string>* lines, std::string name, const MeshOptions& options,
             const EditBatch& present, const LiveMeshTuning& tuning)
    : lines_(*lines),
      name_(std::move(name)),
      mesh_(InDimension(options.dimension, [&](auto d) -> std::unique_ptr<DynamicMesh> {
        return std::make_unique<LiveMesh<d()>>(options, tuning);
      })) {
  const auto diff = mesh_->Apply(present);
  if (!diff.ok()) {
    std::cerr << name_ << ": " << diff.status() << "\n";
    std::abort();
  }
}

void Scene::Add(const std::string& name, const absl::Status& status) {
  lines_.push_back(name_ + " " + name + ": " + TextOf(status));
}

void Scene::Validate(const std::string& name, const EditBatch& batch) {
  const absl::Status status = mesh_->Validate(batch);
  Add(name, status);
  if (status.ok()) return;
  const MeshHash before = mesh_->hash();
  const absl::Status applied = mesh_->Apply(batch).status();
  if (!(applied == status)) Add(name + " by Apply", applied);
  if (!(mesh_->hash() == before)) lines_.push_back(name_ + " " + name + ": changes the mesh");
}

void Scene::Validate(std::span<const Item> items) {
  for (const Item& item : items) {
    Validate(item.name, Batch(item.edits, mesh_->options().dimension));
  }
}

void Scene::Apply(const std::string& name, const EditBatch& batch, ApplyOptions options) {
  if (const absl::Status status = mesh_->Validate(batch); !status.ok()) {
    Add(name + " by Validate", status);
  }
  options.revocable = true;
  const auto diff = mesh_->Apply(batch, options);
  Add(name, diff.status());
  if (diff.ok() && diff->from_revision != diff->to_revision) mesh_->TakeBack(1);
}

}  // namespace dynmesh::test
