#include "server/journal/postgres_errors.h"

#include <string>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"

namespace dynmesh::server::postgres {
namespace {

struct Advice {
  const char* state;  // of the code, the first characters
  const char* text;
};

// The first that fits.
constexpr Advice kAdvice[] = {
    {"53100", "the database's disk is full: free space there"},
    {"53300", "the database has no connection left: raise its max_connections"},
    {"53", "the database lacks a resource"},
    {"58030", "the database's disk failed"},
    {"58", "the database's system failed"},
    {"25006",
     "the database is read only: this is a standby, or default_transaction_read_only is on"},
    {"42501", "the database's user lacks a right: grant it on the schema dynmesh"},
    {"28", "the database refused the user or the password"},
    {"3D000", "there is no such database: create it"},
    {"42P01", "a table of the journal is missing: restore the schema dynmesh"},
    {"3F000", "the schema dynmesh is missing: restore it"},
    {"57014", "an administrator cancelled the statement"},
};

std::string OneLine(absl::string_view message) {
  return absl::StrReplaceAll(absl::StripAsciiWhitespace(message), {{"\n", "; "}});
}

}  // namespace

Failure FailureOf(absl::string_view sqlstate, absl::string_view message) {
  const std::string text = absl::StrCat(OneLine(message), " (", sqlstate, ")");
  if (sqlstate == "XX001" || sqlstate == "XX002") return {absl::DataLossError(text)};
  // Connection exceptions, an unknown completion, a shutdown or a crash, an internal error, or no
  // code at all.
  for (const char* state : {"08", "40003", "57P01", "57P02", "57P03", "57P05", "25P03", "XX"}) {
    if (absl::StartsWith(sqlstate, state)) return ConnectionLost(text);
  }
  if (sqlstate.empty()) return ConnectionLost(OneLine(message));
  for (const Advice& advice : kAdvice) {
    if (!absl::StartsWith(sqlstate, advice.state)) continue;
    return {absl::UnavailableError(absl::StrCat(advice.text, ": ", text))};
  }
  return {absl::UnavailableError(text)};
}

Failure ConnectionLost(absl::string_view message) {
  // The library has no code for it.
  const bool idle = absl::StrContains(message, "idle-in-transaction timeout");
  return {absl::UnavailableError(
              absl::StrCat(idle ? "the database ended a transaction, as this server did not go on "
                                  "with it in time: it was stopped, or had no processor time: "
                                : "the connection to the database was lost: ",
                           OneLine(message))),
          true};
}

absl::Status NotConnected(absl::string_view message) {
  // The library has no code for these.
  const bool full = absl::StrContains(message, "too many clients") ||
                    absl::StrContains(message, "remaining connection slots");
  return absl::UnavailableError(
      absl::StrCat(full ? "the database has no connection left: raise its max_connections: "
                        : "no connection to the database: ",
                   OneLine(message)));
}

}  // namespace dynmesh::server::postgres
