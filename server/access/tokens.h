// A table of bearer tokens, by their hashes, and their roles on meshes. Immutable, so thread-safe.
// Its file has a token per line; # begins a comment:
//
//   # name   SHA-256 of the token in hex   role=meshes ...
//   alice    9f86d081884c7d659a2f...       admin=*
//   lab      60303ae22b998861bce3...       edit=crack-* read=*
//
// A role includes those below it: admin (create and delete), edit, read (includes watch). Meshes
// are given by an id pattern; each * matches any characters.
#ifndef DYNMESH_SERVER_ACCESS_TOKENS_H_
#define DYNMESH_SERVER_ACCESS_TOKENS_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "proto/codec/token_hash.h"

namespace dynmesh::server {

enum class Role { kRead, kEdit, kAdmin };
const char* RoleName(Role role);

// True iff `text` matches `pattern`. Each * matches any characters.
bool MatchesPattern(absl::string_view pattern, absl::string_view text);

struct Token {
  struct Grant {
    Role role = Role::kRead;
    std::string meshes;
  };
  std::string name;
  codec::TokenHash hash = {};
  std::vector<Grant> grants;

  // "" stands for an id that the server is yet to choose: it needs the role on all meshes.
  bool Allows(Role role, absl::string_view mesh_id) const;
  // True if there may be a mesh on which it has the role.
  bool AllowsSome(Role role) const;
};

class TokenTable {
 public:
  // INVALID_ARGUMENT with the line number. An empty file is a valid table that admits no client.
  static absl::StatusOr<TokenTable> Parse(absl::string_view text);

  // Null if there is none. Takes constant time, whatever part of a hash matches.
  std::shared_ptr<const Token> Find(const codec::TokenHash& hash) const;
  std::size_t size() const { return tokens_.size(); }

 private:
  std::vector<std::shared_ptr<const Token>> tokens_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_ACCESS_TOKENS_H_
