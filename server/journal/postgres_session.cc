#include "server/journal/postgres_session.h"

#include <poll.h>

#include <exception>
#include <functional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "server/journal/postgres_errors.h"

namespace dynmesh::server::postgres {
namespace {

// Waiting for a standby must not end by a time limit, and a row lock is waited for. The session of
// a server that is gone ends soon: it counts among max_connections.
constexpr char kSettings[] =
    "SET client_min_messages = warning; SET default_transaction_isolation = 'read committed'; "
    "SET statement_timeout = 0; SET lock_timeout = 0; "
    "SET idle_session_timeout = 0; SET bytea_output = 'hex'; "
    "SET tcp_keepalives_idle = 10; SET tcp_keepalives_interval = 5; SET tcp_keepalives_count = 3; "
    "SELECT set_config('synchronous_commit', 'on', false) "
    "WHERE current_setting('synchronous_commit') NOT IN ('on', 'remote_apply')";

// The library keeps the server's code of most errors, but not of all.
Failure Caught() {
  try {
    throw;
  } catch (const pqxx::broken_connection& error) {
    return ConnectionLost(error.what());
  } catch (const pqxx::statement_completion_unknown& error) {
    return ConnectionLost(error.what());
  } catch (const pqxx::transaction_rollback& error) {
    return FailureOf("40000", error.what());
  } catch (const pqxx::insufficient_privilege& error) {
    return FailureOf("42501", error.what());
  } catch (const pqxx::sql_error& error) {
    return FailureOf(error.sqlstate(), error.what());
  } catch (const std::exception& error) {
    return ConnectionLost(error.what());
  }
}

}  // namespace

std::int64_t Answer::Integer(std::size_t row, int column) const {
  return rows[static_cast<pqxx::result::size_type>(row)][column].as<std::int64_t>();
}

std::string Answer::Bytes(std::size_t row, int column) const {
  return pqxx::binarystring(rows[static_cast<pqxx::result::size_type>(row)][column]).str();
}

bool Answer::IsNull(std::size_t row, int column) const {
  return rows[static_cast<pqxx::result::size_type>(row)][column].is_null();
}

// Hears the server's warnings.
class Session::Listener final : public pqxx::errorhandler {
 public:
  using errorhandler::errorhandler;
  bool operator()(const char text[]) noexcept override {
    heard_ = text;
    return false;
  }
  std::string Take() { return std::exchange(heard_, ""); }

 private:
  std::string heard_;
};

Session::Session() = default;
Session::~Session() = default;

absl::StatusOr<std::unique_ptr<Session>> Session::Connect(const std::string& conninfo,
                                                          absl::Duration between_statements) {
  std::unique_ptr<Session> session(new Session);
  try {
    session->connection_ = std::make_unique<pqxx::connection>(conninfo);
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
    // A new connection in the middle of a transaction would lose its beginning.
    session->connection_->inhibit_reactivation(true);
#pragma GCC diagnostic pop
  } catch (const std::exception& error) {
    return NotConnected(error.what());
  }
  session->listener_ = std::make_unique<Listener>(*session->connection_);
  const Answer set = session->Execute(absl::StrCat(
      "SET idle_in_transaction_session_timeout = ", absl::ToInt64Milliseconds(between_statements),
      "; ", kSettings));
  if (!set.status.ok()) return set.status;
  return session;
}

Answer Session::Execute(const std::string& sql) {
  return Guarded([&sql](pqxx::nontransaction& work) { return work.exec(sql); });
}

Answer Session::Guarded(const std::function<pqxx::result(pqxx::nontransaction&)>& statement) {
  Answer answer;
  listener_->Take();
  try {
    pqxx::nontransaction work(*connection_);
    answer.rows = statement(work);
  } catch (...) {
    Failure failure = Caught();
    // The last words of a server that closed the connection; the library says only that it is so.
    const std::string heard = listener_->Take();
    if (failure.unknown && !heard.empty()) failure = ConnectionLost(heard);
    answer.status = std::move(failure.status);
    answer.unknown = failure.unknown;
    usable_ = false;
    return answer;
  }
  if (const std::string heard = listener_->Take(); !heard.empty()) {
    usable_ = false;
    answer.status = absl::UnavailableError(absl::StrCat("the database warns: ", heard));
    answer.unknown = true;
  }
  return answer;
}

bool Session::IsStale() const {
  pollfd connection{connection_->sock(), POLLIN, 0};
  return poll(&connection, 1, 0) != 0;
}

const std::string& Session::Prepared(const char* sql) {
  const auto [it, added] = prepared_.try_emplace(sql, absl::StrCat("s", prepared_.size()));
  if (added) connection_->prepare(it->second, sql);
  return it->second;
}

std::string Session::Encoded(const std::vector<std::int64_t>& numbers) {
  return absl::StrCat("{", absl::StrJoin(numbers, ","), "}");
}

}  // namespace dynmesh::server::postgres
