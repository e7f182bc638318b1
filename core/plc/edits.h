// A view of the edits of a batch, in order. So a first load need not copy its features into a
// batch. A value; the viewed data must outlive it and not change.
#ifndef DYNMESH_CORE_PLC_EDITS_H_
#define DYNMESH_CORE_PLC_EDITS_H_

#include <cstddef>
#include <span>

#include "absl/functional/function_ref.h"
#include "dynmesh/feature.h"

namespace dynmesh::plc {

// Polled with the number of features still to check, or kNotKnown before they are counted; true
// stops the check.
inline constexpr std::size_t kNotKnown = ~std::size_t{0};
using Interrupted = absl::FunctionRef<bool(std::size_t waiting)>;

class Edits {
 public:
  explicit Edits(const EditBatch& batch) : edits_(batch) {}
  // A batch that adds all of them.
  static Edits Adding(std::span<const Feature> features) { return Edits(features); }

  std::size_t size() const { return edits_.size() + added_.size(); }
  Edit::Action action(std::size_t i) const {
    return added_.empty() ? edits_[i].action : Edit::Action::kAdd;
  }
  const Feature& feature(std::size_t i) const {
    return added_.empty() ? edits_[i].feature : added_[i];
  }

 private:
  explicit Edits(std::span<const Feature> added) : added_(added) {}

  std::span<const Edit> edits_;  // one of the two is empty
  std::span<const Feature> added_;
};

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_EDITS_H_
