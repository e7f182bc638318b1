#include "server/journal/postgres_target.h"

#include <libpq-fe.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/string_view.h"

namespace dynmesh::server::postgres {
namespace {

using Values = std::map<std::string, std::string>;

// Of what the address leaves out.
Values Defaults(absl::Duration lease) {
  absl::Duration silence = absl::Seconds(10);
  if (lease > absl::ZeroDuration()) {
    silence = std::clamp(lease / 2, absl::Milliseconds(500), silence);
  }
  // libpq takes seconds, and 2 at least to connect.
  const std::int64_t half = absl::ToInt64Seconds(silence / 2);
  const auto within = [half](std::int64_t least, std::int64_t most) {
    return absl::StrCat(std::clamp(half, least, most));
  };
  return {
      {"application_name", "dynmeshd"},
      {"client_encoding", "UTF8"},
      {"target_session_attrs", "read-write"},
      {"connect_timeout", within(2, 5)},
      {"keepalives_idle", within(1, 5)},
      {"keepalives_interval", within(1, 2)},
      {"keepalives_count", "3"},
      {"tcp_user_timeout", absl::StrCat(absl::ToInt64Milliseconds(silence))},
  };
}

std::string Quoted(absl::string_view value) {
  return absl::StrCat("'", absl::StrReplaceAll(value, {{"\\", "\\\\"}, {"'", "\\'"}}), "'");
}

}  // namespace

absl::StatusOr<Target> ParseTarget(const std::string& url, absl::Duration lease) {
  if (!IsAddress(url)) {
    return absl::InvalidArgumentError("the journal's address does not begin with postgresql://");
  }
  char* error = nullptr;
  const std::unique_ptr<PQconninfoOption, void (*)(PQconninfoOption*)> parsed(
      PQconninfoParse(url.c_str(), &error), &PQconninfoFree);
  const std::unique_ptr<char, void (*)(void*)> message(error, &PQfreemem);
  if (parsed == nullptr) {
    return absl::InvalidArgumentError(
        "the journal's address is malformed: give postgresql://[USER@]HOST[:PORT]/DATABASE");
  }
  Values values = Defaults(lease);
  for (const PQconninfoOption* option = parsed.get(); option->keyword != nullptr; ++option) {
    if (option->val != nullptr) values[option->keyword] = option->val;
  }
  const auto given = [&values](const char* key, const char* otherwise) {
    const auto it = values.find(key);
    return it == values.end() || it->second.empty() ? std::string(otherwise) : it->second;
  };
  Target target;
  target.name = absl::StrCat("postgresql://", given("host", given("hostaddr", "local").c_str()),
                             "/", given("dbname", given("user", "").c_str()));
  for (const auto& [key, value] : values) {
    absl::StrAppend(&target.conninfo, target.conninfo.empty() ? "" : " ", key, "=", Quoted(value));
  }
  return target;
}

}  // namespace dynmesh::server::postgres
