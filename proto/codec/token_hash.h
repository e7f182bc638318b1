// Bearer tokens: clients show them, servers know their hashes. Pure functions but for
// RandomToken, thread-safe.
#ifndef DYNMESH_PROTO_CODEC_TOKEN_HASH_H_
#define DYNMESH_PROTO_CODEC_TOKEN_HASH_H_

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "absl/strings/string_view.h"

namespace dynmesh::codec {

using TokenHash = std::array<std::uint8_t, 32>;

// SHA-256. No salt and no stretching: a token is random, there is nothing to guess.
TokenHash HashToken(absl::string_view token);

std::string ToHex(const TokenHash& hash);
// Nothing unless `hex` is 64 hexadecimal digits.
std::optional<TokenHash> TokenHashFromHex(absl::string_view hex);

// In a time that does not tell where they differ.
bool SameHash(const TokenHash& a, const TokenHash& b);

// 256 random bits of the system's, as 64 hexadecimal digits; empty if it has none.
std::string RandomToken();

}  // namespace dynmesh::codec

#endif  // DYNMESH_PROTO_CODEC_TOKEN_HASH_H_
