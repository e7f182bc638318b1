// Bearer tokens: clients send them, servers store their hashes. Pure functions except RandomToken,
// thread-safe.
#ifndef DYNMESH_PROTO_CODEC_TOKEN_HASH_H_
#define DYNMESH_PROTO_CODEC_TOKEN_HASH_H_

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "absl/strings/string_view.h"

namespace dynmesh::codec {

using TokenHash = std::array<std::uint8_t, 32>;

// SHA-256. No salt and no stretching, since a token is random and cannot be guessed.
TokenHash HashToken(absl::string_view token);

std::string ToHex(const TokenHash& hash);
// Nothing unless `hex` is 64 hexadecimal digits.
std::optional<TokenHash> TokenHashFromHex(absl::string_view hex);

// In constant time.
bool SameHash(const TokenHash& a, const TokenHash& b);

// 256 random bits from the system as 64 hexadecimal digits; empty if there are none.
std::string RandomToken();

}  // namespace dynmesh::codec

#endif  // DYNMESH_PROTO_CODEC_TOKEN_HASH_H_
