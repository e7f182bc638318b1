#include "server/config.h"

#include "absl/strings/str_cat.h"

namespace dynmesh::server {
namespace {

absl::Status Bad(const char* field, const char* what) {
  return absl::InvalidArgumentError(absl::StrCat(field, " ", what));
}

}  // namespace

absl::Status ValidateConfig(const ServerConfig& c) {
  if (c.listen.empty()) return Bad("listen", "is empty: give host:port");
  if (c.writer_threads < 0 || c.writer_threads > 1024)
    return Bad("writer_threads", "not in 0..1024");
  if (c.reader_threads < 0 || c.reader_threads > 1024)
    return Bad("reader_threads", "not in 0..1024");
  if (c.max_meshes == 0) return Bad("max_meshes", "must be at least 1");
  if (c.max_vertices == 0) return Bad("max_vertices", "must be at least 1");
  if (c.max_batch_edits == 0) return Bad("max_batch_edits", "must be at least 1");
  if (c.max_pending_edits < c.max_batch_edits) {
    return Bad("max_pending_edits", "must be at least max_batch_edits");
  }
  if (c.max_message_bytes < 64 << 10) return Bad("max_message_bytes", "must be at least 65536");
  if (c.max_waiting_edits == 0) return Bad("max_waiting_edits", "must be at least 1");
  if (c.edit_window < 1) return Bad("edit_window", "must be at least 1");
  if (c.history_revisions == 0) return Bad("history_revisions", "must be at least 1");
  if (c.progress_interval < absl::Milliseconds(100)) {
    return Bad("progress_interval", "must be at least 100 ms");
  }
  if (c.report_interval <= absl::ZeroDuration()) return Bad("report_interval", "must be positive");
  if (c.drain_timeout < absl::ZeroDuration()) return Bad("drain_timeout", "is negative");
  return absl::OkStatus();
}

}  // namespace dynmesh::server
