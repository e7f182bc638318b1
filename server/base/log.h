// Structured logs: one line per event, key=value. Values are quoted where needed, so that no client
// can forge a line. UTC, to stderr. Thread-safe.
#ifndef DYNMESH_SERVER_BASE_LOG_H_
#define DYNMESH_SERVER_BASE_LOG_H_

#include <initializer_list>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace dynmesh::server {

enum class LogLevel { kDebug, kInfo, kWarning, kError, kOff };

// INVALID_ARGUMENT unless `name` is debug, info, warning, error or off.
absl::Status SetLogLevel(absl::string_view name);

bool IsLogLevel(absl::string_view name);

bool LogEnabled(LogLevel level);

struct LogField {
  LogField(absl::string_view k, const absl::AlphaNum& v) : key(k), value(v.Piece()) {}
  absl::string_view key;
  std::string value;
};

// The fields are evaluated before the call: guard a hot path with LogEnabled.
void Log(LogLevel level, absl::string_view event, std::initializer_list<LogField> fields = {});

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_BASE_LOG_H_
