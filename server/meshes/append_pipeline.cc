#include "server/meshes/append_pipeline.h"

#include <iterator>

#include "proto/codec/edit_codec.h"

namespace dynmesh::server {
namespace {

std::size_t BytesOf(const HeldEdit& edit) {
  const std::size_t bytes = sizeof(HeldEdit) + codec::Weight(edit.job->edits) * sizeof(Edit);
  return edit.outcome.ok() ? bytes + BytesOf(*edit.outcome) : bytes;
}

}  // namespace

const HeldEdit* AppendPipeline::Find(absl::string_view request_id) const {
  const HeldEdit* const found = in_flight_.Find(request_id);
  return found != nullptr ? found : waiting_.Find(request_id);
}

void AppendPipeline::Add(HeldEdit edit) {
  edit.bytes = BytesOf(edit);
  bytes_ += edit.bytes;
  ++size_;
  waiting_.Add(std::move(edit));
}

const AppendPipeline::FlightPtr& AppendPipeline::Begin() {
  in_flight_ = std::exchange(waiting_, {});
  flight_ = std::make_shared<Flight>(in_flight_.Unwritten(), in_flight_.front().job);
  return flight_;
}

std::vector<HeldEdit> AppendPipeline::TakeWritten() {
  std::vector<HeldEdit> written = in_flight_.Take();
  for (HeldEdit& edit : waiting_.TakeAnswers()) written.push_back(std::move(edit));
  flight_ = nullptr;
  size_ -= written.size();
  for (const HeldEdit& edit : written) bytes_ -= edit.bytes;
  return written;
}

std::vector<HeldEdit> AppendPipeline::TakeAll(std::size_t* flown) {
  std::vector<HeldEdit> all = in_flight_.Take();
  *flown = all.size();
  for (HeldEdit& edit : waiting_.Take()) all.push_back(std::move(edit));
  flight_ = nullptr;
  size_ = bytes_ = 0;
  return all;
}

}  // namespace dynmesh::server
