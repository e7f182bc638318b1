#include "server/access/tokens.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

namespace dynmesh::server {
namespace {

constexpr std::array kRoles = {Role::kRead, Role::kEdit, Role::kAdmin};

std::optional<Role> ParseRole(absl::string_view name) {
  const auto found = std::find_if(kRoles.begin(), kRoles.end(),
                                  [name](Role role) { return name == RoleName(role); });
  if (found == kRoles.end()) return std::nullopt;
  return *found;
}

bool IsPattern(absl::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '*';
  });
}

// The error lacks the line number. It repeats only names: a token written in place of its hash must
// not reach a log.
absl::StatusOr<Token> ParseToken(const std::vector<absl::string_view>& words) {
  if (words.size() < 3) return absl::InvalidArgumentError("want: NAME SHA256 ROLE=MESHES ...");
  Token token;
  token.name = std::string(words[0]);
  const auto hash = codec::TokenHashFromHex(words[1]);
  if (!hash.has_value()) {
    return absl::InvalidArgumentError(
        absl::StrCat("of ", token.name, ": the second word is not a SHA-256 in 64 hex digits"));
  }
  token.hash = *hash;
  for (std::size_t i = 2; i < words.size(); ++i) {
    const std::pair<absl::string_view, absl::string_view> parts =
        absl::StrSplit(words[i], absl::MaxSplits('=', 1));
    const std::optional<Role> role = ParseRole(parts.first);
    if (!role.has_value() || !IsPattern(parts.second)) {
      return absl::InvalidArgumentError(
          absl::StrCat("of ", token.name, ": word ", i + 1,
                       " is not read=, edit= or admin= with a mesh's id, in which * may stand"));
    }
    token.grants.push_back({*role, std::string(parts.second)});
  }
  return token;
}

}  // namespace

const char* RoleName(Role role) {
  switch (role) {
    case Role::kRead:
      return "read";
    case Role::kEdit:
      return "edit";
    case Role::kAdmin:
      return "admin";
  }
  return "";
}

bool MatchesPattern(absl::string_view pattern, absl::string_view text) {
  // After a mismatch only the last * retries, one character further.
  std::size_t p = 0, t = 0;
  std::size_t star = absl::string_view::npos, resume = 0;
  while (t < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      resume = t;
    } else if (p < pattern.size() && pattern[p] == text[t]) {
      ++p, ++t;
    } else if (star != absl::string_view::npos) {
      p = star + 1;
      t = ++resume;
    } else {
      return false;
    }
  }
  return std::all_of(pattern.begin() + static_cast<std::ptrdiff_t>(p), pattern.end(),
                     [](char c) { return c == '*'; });
}

bool Token::Allows(Role role, absl::string_view mesh_id) const {
  return std::any_of(grants.begin(), grants.end(), [&](const Grant& grant) {
    return grant.role >= role && MatchesPattern(grant.meshes, mesh_id);
  });
}

bool Token::AllowsSome(Role role) const {
  return std::any_of(grants.begin(), grants.end(),
                     [role](const Grant& grant) { return grant.role >= role; });
}

absl::StatusOr<TokenTable> TokenTable::Parse(absl::string_view text) {
  TokenTable table;
  int number = 0;
  for (absl::string_view line : absl::StrSplit(text, '\n')) {
    ++number;
    line = line.substr(0, line.find('#'));
    const std::vector<absl::string_view> words =
        absl::StrSplit(line, absl::ByAnyChar(" \t\r"), absl::SkipEmpty());
    if (words.empty()) continue;
    absl::StatusOr<Token> token = ParseToken(words);
    if (!token.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat("line ", number, " ", token.status().message()));
    }
    for (const auto& other : table.tokens_) {
      if (other->name == token->name || other->hash == token->hash) {
        return absl::InvalidArgumentError(absl::StrCat("line ", number, " of ", token->name,
                                                       ": name or token is ", other->name,
                                                       "'s already"));
      }
    }
    table.tokens_.push_back(std::make_shared<const Token>(*std::move(token)));
  }
  return table;
}

std::shared_ptr<const Token> TokenTable::Find(const codec::TokenHash& hash) const {
  std::shared_ptr<const Token> found;
  for (const auto& token : tokens_) {
    if (codec::SameHash(token->hash, hash)) found = token;
  }
  return found;
}

}  // namespace dynmesh::server
