#include "server/base/log.h"

#include <google/protobuf/stubs/logging.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "server/base/printable.h"

namespace dynmesh::server {
namespace {

spdlog::level::level_enum Translate(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug:
      return spdlog::level::debug;
    case LogLevel::kInfo:
      return spdlog::level::info;
    case LogLevel::kWarning:
      return spdlog::level::warn;
    case LogLevel::kError:
      return spdlog::level::err;
    case LogLevel::kOff:
      return spdlog::level::off;
  }
  return spdlog::level::off;
}

spdlog::logger& Logger() {
  static const auto logger = [] {
    auto made = std::make_shared<spdlog::logger>("dynmesh",
                                                 std::make_shared<spdlog::sinks::stderr_sink_mt>());
    made->set_pattern("time=%Y-%m-%dT%H:%M:%S.%eZ level=%l %v", spdlog::pattern_time_type::utc);
    return made;
  }();
  return *logger;
}

// By default protobuf writes a line to stderr for each message that does not parse, in its own
// form: a client could fill a disk. The sender gets an error anyway, which is counted.
void TakeFromProtobuf(google::protobuf::LogLevel level, const char*, int,
                      const std::string& message) {
  const bool fatal = level == google::protobuf::LOGLEVEL_FATAL;  // the process ends after this
  Log(fatal ? LogLevel::kError : LogLevel::kDebug, "protobuf", {{"message", message}});
}

bool IsPlain(absl::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return c > ' ' && c < 0x7F && c != '"' && c != '=' && c != '\\';
  });
}

std::optional<LogLevel> LevelNamed(absl::string_view name) {
  for (const auto& [text, level] :
       {std::pair{"debug", LogLevel::kDebug}, std::pair{"info", LogLevel::kInfo},
        std::pair{"warning", LogLevel::kWarning}, std::pair{"error", LogLevel::kError},
        std::pair{"off", LogLevel::kOff}}) {
    if (name == text) return level;
  }
  return std::nullopt;
}

}  // namespace

absl::Status SetLogLevel(absl::string_view name) {
  const std::optional<LogLevel> level = LevelNamed(name);
  if (!level.has_value()) {
    return absl::InvalidArgumentError(
        absl::StrCat("log level '", name, "': use debug, info, warning, error or off"));
  }
  google::protobuf::SetLogHandler(&TakeFromProtobuf);
  Logger().set_level(Translate(*level));
  return absl::OkStatus();
}

bool IsLogLevel(absl::string_view name) { return LevelNamed(name).has_value(); }

bool LogEnabled(LogLevel level) { return Logger().should_log(Translate(level)); }

void Log(LogLevel level, absl::string_view event, std::initializer_list<LogField> fields) {
  if (!LogEnabled(level)) return;
  std::string line = absl::StrCat("event=", event);
  for (const LogField& f : fields) {
    if (IsPlain(f.value)) {
      absl::StrAppend(&line, " ", f.key, "=", f.value);
    } else {
      absl::StrAppend(&line, " ", f.key, "=\"", Printable(absl::Utf8SafeCEscape(f.value)), "\"");
    }
  }
  // The line is data, never a format string.
  Logger().log(Translate(level), "{}", line);
}

}  // namespace dynmesh::server
