#include "server/journal/losses.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/base/mesh_name.h"
#include "server/journal/row_sum.h"

namespace dynmesh::server {
namespace {

using RecordedHead = HeadsFile::Head;
using State = HeadsFile::State;

// nullopt: no loss.
std::optional<Loss::Kind> KindOf(const RecordedHead& recorded, const FoundMesh& found) {
  if (recorded.state == State::kUnconfirmed) return Loss::Kind::kUnconfirmed;
  if (found.named && found.head.id.substr(0, HeadsFile::kMaxNameBytes) != recorded.id) {
    return Loss::Kind::kOther;
  }
  if (found.head.revision < recorded.revision) return Loss::Kind::kBehind;
  if (found.sum_on_record.value_or(recorded.sum) != recorded.sum) return Loss::Kind::kOther;
  if (found.head.requests < recorded.requests) return Loss::Kind::kAnswers;
  return std::nullopt;
}

}  // namespace

std::string Loss::Acceptance() const {
  return found.key == 0 ? absl::StrCat(name, "@none") : absl::StrCat(name, "@", found.revision);
}

std::string Loss::Text() const {
  const auto told = [&]() -> std::string {
    switch (kind) {
      case Kind::kMissing:
        return absl::StrCat("revision ", recorded.revision,
                            " was acknowledged, the journal has nothing of the mesh. To go on "
                            "without it");
      case Kind::kBehind:
        return absl::StrCat("revision ", recorded.revision, " was acknowledged, the journal has ",
                            "revision ", found.revision, ". It is read only. To go on from there");
      case Kind::kAnswers:
        return absl::StrCat("of ", recorded.requests, " answers to requests the journal has ",
                            found.requests, ", and revision ", found.revision,
                            ". It is read only. To go on from there");
      case Kind::kOther:
        return absl::StrCat("the journal has revision ", found.revision,
                            ", which does not continue revision ", recorded.revision,
                            " that was acknowledged. It is read only. To go on from there");
      case Kind::kUnconfirmed:
        return absl::StrCat("the journal has revision ", found.revision,
                            "; whether later ones were acknowledged is not known. It is read "
                            "only. To go on from there");
    }
    return "";
  };
  return absl::StrCat(told(), ", start the server with --accept-loss=", Acceptance());
}

std::string SayableName(HeadsFile::Key key, absl::string_view id) {
  return IsMeshId(id) ? std::string(id) : RowName(key);
}

std::string SayableName(const FoundMesh& mesh, const RecordedHead* recorded,
                        const std::map<std::string, int>& others) {
  if (mesh.named) return SayableName(mesh.head.key, mesh.head.id);
  const auto count = [&](const std::string& id) {
    const auto it = others.find(id);
    return it == others.end() ? 0 : it->second;
  };
  const int itself = recorded != nullptr && recorded->id == mesh.head.id ? 1 : 0;
  if (recorded != nullptr && IsMeshId(recorded->id) && count(recorded->id) == itself) {
    return recorded->id;
  }
  return count(mesh.head.id) == 1 ? SayableName(mesh.head.key, mesh.head.id)
                                  : RowName(mesh.head.key);
}

std::vector<Loss> FindLosses(const std::vector<RecordedHead>& recorded, HeadsFile::Key confirmed,
                             const std::vector<FoundMesh>& found) {
  std::map<HeadsFile::Key, const FoundMesh*> by_key;
  std::map<std::string, int> names;
  for (const FoundMesh& mesh : found) {
    by_key.emplace(mesh.head.key, &mesh);
    ++names[mesh.head.id];
  }
  std::map<HeadsFile::Key, Loss> losses;
  for (const RecordedHead& head : recorded) {
    const auto it = by_key.find(head.key);
    if (it == by_key.end()) {
      if (head.state == State::kDeleting) continue;
      Loss& loss = losses[head.key];
      loss.recorded = head;
      loss.name = SayableName(head.key, head.id);
      continue;
    }
    const FoundMesh& mesh = *it->second;
    by_key.erase(it);
    if (const auto kind = KindOf(head, mesh)) {
      Loss& loss = losses[head.key];
      loss.kind = *kind;
      loss.recorded = head;
      loss.found = mesh.head;
      loss.name = SayableName(mesh, &head, names);
    }
  }
  for (const auto& [key, mesh] : by_key) {
    if (key > confirmed) continue;
    Loss& loss = losses[key];
    loss.kind = Loss::Kind::kUnconfirmed;
    loss.found = mesh->head;
    loss.name = SayableName(*mesh, nullptr, names);
  }
  std::vector<Loss> all;
  for (auto& [key, loss] : losses) {
    // A later mesh may have the same name.
    if (loss.kind == Loss::Kind::kMissing && names.contains(loss.name)) loss.name = RowName(key);
    all.push_back(std::move(loss));
  }
  return all;
}

std::string CodeOf(const std::vector<Loss>& losses) {
  RowSum sum;
  for (const Loss& loss : losses) {
    sum.Add(std::int64_t{loss.key()}).Add(static_cast<std::int64_t>(loss.kind));
    for (const RecordedHead* head : {&loss.recorded, &loss.found}) {
      sum.Add(static_cast<std::int64_t>(head->revision)).Add(head->sum).Add(head->requests);
    }
  }
  return absl::StrFormat("%08x", static_cast<std::uint32_t>(sum.value()));
}

}  // namespace dynmesh::server
