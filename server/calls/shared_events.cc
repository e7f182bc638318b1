#include "server/calls/shared_events.h"

#include <grpcpp/impl/codegen/proto_utils.h>

#include "proto/codec/mesh_codec.h"

namespace dynmesh::server {

grpc::ByteBuffer EncodeEvent(const v1::WatchEvent& event) {
  grpc::ByteBuffer bytes;
  bool own = false;
  // Fails only beyond 2 GB.
  grpc::SerializationTraits<v1::WatchEvent>::Serialize(event, &bytes, &own);
  return bytes;
}

std::shared_ptr<const SharedEvents::Events> SharedEvents::Find(
    const std::shared_ptr<const MeshDiff>& diff, std::size_t fragment_bytes) {
  std::shared_ptr<Entry> entry;
  {
    const MutexLock lock(mutex_);
    const auto [place, is_new] = kept_.try_emplace(diff.get());
    if (is_new) {
      place->second = {diff, std::make_shared<Entry>()};
      order_.push_back(diff.get());
    }
    entry = place->second.entry;
  }
  std::call_once(entry->once, [&] { Encode(diff, fragment_bytes, *entry); });
  if (entry->events.empty()) return nullptr;
  return {entry, &entry->events};
}

void SharedEvents::Encode(const std::shared_ptr<const MeshDiff>& diff, std::size_t fragment_bytes,
                          Entry& entry) {
  codec::DiffFragmenter fragments(diff, /*omit_columns=*/false, fragment_bytes);
  v1::WatchEvent event;
  std::size_t bytes = sizeof(Entry);
  while (entry.events.size() < most_messages_ && fragments.Next(event.mutable_diff())) {
    entry.events.push_back(EncodeEvent(event));
    bytes += entry.events.back().Length();
  }
  if (!fragments.done()) {
    Events().swap(entry.events);
    bytes = sizeof(Entry);
  }
  const MutexLock lock(mutex_);
  ++encoded_;
  // It may have been dropped meanwhile.
  const auto kept = kept_.find(diff.get());
  if (kept == kept_.end() || kept->second.entry.get() != &entry) return;
  entry.bytes = bytes;
  held_ += bytes;
  Trim();
}

// The newest stays. A watch that sends an entry keeps it until then.
void SharedEvents::Trim() {
  while (held_ > bytes_ && order_.size() > 1) {
    const auto oldest = kept_.find(order_.front());
    order_.pop_front();
    held_ -= oldest->second.entry->bytes;
    kept_.erase(oldest);
  }
}

std::size_t SharedEvents::encoded() const {
  const MutexLock lock(mutex_);
  return encoded_;
}

std::size_t SharedEvents::held_bytes() const {
  const MutexLock lock(mutex_);
  return held_;
}

}  // namespace dynmesh::server
