#include "server/base/call_id.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <random>

#include "absl/strings/str_format.h"
#include "core/base/mix.h"

namespace dynmesh::server {
namespace {

constexpr std::size_t kMaxLength = 64;

bool IsUsable(absl::string_view id) {
  return !id.empty() && id.size() <= kMaxLength &&
         std::all_of(id.begin(), id.end(), [](unsigned char c) { return c > ' ' && c < 0x7F; });
}

}  // namespace

std::string ChooseCallId(absl::string_view given) {
  if (IsUsable(given)) return std::string(given);
  static std::atomic<std::uint64_t> next{(std::uint64_t{std::random_device{}()} << 32) +
                                         std::random_device{}()};
  // Distinct for distinct numbers, since MixBits is invertible.
  return absl::StrFormat("%016x", MixBits(next.fetch_add(1, std::memory_order_relaxed)));
}

std::string CallIdOf(const grpc::CallbackServerContext& call) {
  const auto& metadata = call.client_metadata();
  const auto found = metadata.find(kCallIdKey);
  return found == metadata.end() ? "" : std::string(found->second.data(), found->second.size());
}

}  // namespace dynmesh::server
