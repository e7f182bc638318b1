#include "server/journal/postgres_ownership.h"

#include "absl/strings/str_cat.h"
#include "server/journal/journal_errors.h"

namespace dynmesh::server::postgres {
namespace {

constexpr char kClaim[] =
    "UPDATE dynmesh.meshes SET epoch = epoch + 1, owner = $2::text WHERE key = $1::bigint "
    "RETURNING epoch, head, answers";
constexpr char kClaimAgain[] =
    "UPDATE dynmesh.meshes SET epoch = epoch + 1 WHERE key = $1::bigint AND owner = $2::text "
    "RETURNING epoch, head, answers";
constexpr char kState[] =
    "SELECT epoch, head, answers, owner = $2::text FROM dynmesh.meshes WHERE key = $1::bigint";

Claimed Run(Session& session, const char* sql, std::int64_t mesh, const std::string& owner) {
  const Answer answer = session.Run(sql, mesh, owner);
  Claimed claimed{answer.status, answer.unknown, {}};
  if (!answer.status.ok()) return claimed;
  if (answer.empty()) {
    claimed.status = NoSuchMesh();
  } else {
    claimed.belief = {answer.Integer(0, 0), answer.Integer(0, 1), answer.Integer(0, 2)};
  }
  return claimed;
}

}  // namespace

Claimed ClaimMesh(Session& session, std::int64_t mesh, const std::string& owner) {
  return Run(session, kClaim, mesh, owner);
}

Claimed ClaimAgain(Session& session, std::int64_t mesh, const std::string& owner) {
  Claimed claimed = Run(session, kClaimAgain, mesh, owner);
  if (absl::IsNotFound(claimed.status)) {
    claimed.status = WhyRefused(session, mesh, owner, {});
  }
  return claimed;
}

absl::Status WhyRefused(Session& session, std::int64_t mesh, const std::string& owner,
                        const Belief& belief) {
  const Answer state = session.Run(kState, mesh, owner);
  if (!state.status.ok()) {
    return absl::AbortedError("another server claimed the mesh, or deleted it");
  }
  if (state.empty()) return NoSuchMesh();
  const bool is_mine = state.rows[0][3].as<bool>();
  if (!is_mine || state.Integer(0, 0) > belief.epoch) {
    return absl::AbortedError(
        absl::StrCat("another server claimed the mesh: its epoch is ", state.Integer(0, 0)));
  }
  return SetBack({0, state.Integer(0, 1), state.Integer(0, 2)}, belief);
}

absl::Status SetBack(const Belief& found, const Belief& belief) {
  return absl::DataLossError(absl::StrCat("the database is at revision ", found.head,
                                          " and request ", found.answers,
                                          ", not at the acknowledged ", belief.head, " and ",
                                          belief.answers, ": it lost what it had acknowledged"));
}

}  // namespace dynmesh::server::postgres
