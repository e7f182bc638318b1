#include "server/journal/postgres_target.h"

#include <libpq-fe.h>

#include <map>
#include <memory>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/string_view.h"

namespace dynmesh::server::postgres {
namespace {

// Of what the address leaves out. Times in seconds, but for the last one in milliseconds.
constexpr std::pair<const char*, const char*> kDefaults[] = {
    {"application_name", "dynmeshd"},
    {"client_encoding", "UTF8"},
    {"target_session_attrs", "read-write"},
    {"connect_timeout", "5"},
    {"keepalives_idle", "5"},
    {"keepalives_interval", "2"},
    {"keepalives_count", "3"},
    {"tcp_user_timeout", "10000"},
};

std::string Quoted(absl::string_view value) {
  return absl::StrCat("'", absl::StrReplaceAll(value, {{"\\", "\\\\"}, {"'", "\\'"}}), "'");
}

}  // namespace

absl::StatusOr<Target> ParseTarget(const std::string& url) {
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
  std::map<std::string, std::string> values(std::begin(kDefaults), std::end(kDefaults));
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
