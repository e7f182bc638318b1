#include "server/meshes/edit_group.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace dynmesh::server {

const HeldEdit* EditGroup::Find(absl::string_view request_id) const {
  for (const HeldEdit& edit : edits_) {
    if (edit.unwritten && edit.job->request_id == request_id) return &edit;
  }
  return nullptr;
}

std::vector<MeshLog::Batch> EditGroup::Unwritten() const {
  std::vector<MeshLog::Batch> batches;
  for (const HeldEdit& edit : edits_) {
    if (edit.unwritten) batches.push_back({&edit.job->edits, edit.job->request_id, edit.answer});
  }
  return batches;
}

void EditGroup::Add(HeldEdit edit) {
  if (edit.unwritten && edit.answer.from_revision != edit.answer.to_revision) ++revisions_;
  edits_.push_back(std::move(edit));
}

std::vector<HeldEdit> EditGroup::TakeAnswers() {
  const auto end = std::ranges::find_if(edits_, &HeldEdit::unwritten);
  std::vector<HeldEdit> answers(std::make_move_iterator(edits_.begin()),
                                std::make_move_iterator(end));
  edits_.erase(edits_.begin(), end);
  return answers;
}

std::vector<HeldEdit> EditGroup::Take() {
  revisions_ = 0;
  return std::exchange(edits_, {});
}

}  // namespace dynmesh::server
