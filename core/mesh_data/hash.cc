// Vertex ids and mesh hashes. Never change them: clients in other languages, journals and files
// depend on every bit.
//
// The specification is proto/dynmesh/v1/mesh.proto, with two meshes to test a client. This is the
// same in C++, tests/e2e/mesh_hash.py in Python.
//
// Two different bijective mixers (A, which is Mix, and B there) with different keys: a collision
// must occur in both words at once. Good against accidents. It is not cryptographic.
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "core/base/mix.h"
#include "core/base/steps.h"
#include "core/base/text.h"
#include "core/mesh_data/constraints.h"
#include "core/mesh_data/whole_mesh.h"
#include "dynmesh/mesh.h"

namespace dynmesh {
namespace {

constexpr std::uint64_t MixB(std::uint64_t z) {
  z += 0xd1b54a32d192ed03ULL;
  z = (z ^ (z >> 33)) * 0xff51afd7ed558ccdULL;
  z = (z ^ (z >> 33)) * 0xc4ceb9fe1a85ec53ULL;
  return z ^ (z >> 33);
}

constexpr std::uint64_t kIdKey = 0xa0761d6478bd642fULL;
constexpr std::uint64_t kRegionKey = 0xe7037ed1a0b428dbULL;
constexpr std::uint64_t kHiKey = 0x8ebc6af09c88c6e3ULL;
constexpr std::uint64_t kLoKey = 0x589965cc75374cc3ULL;

enum Tag : std::uint64_t { kVertexTag = 1, kSimplexTag = 2, kSubsegmentTag = 3, kSubfacetTag = 4 };

std::uint64_t Bits(double c) { return std::bit_cast<std::uint64_t>(c + 0.0); }

class WordHasher {
 public:
  constexpr explicit WordHasher(Tag tag) { Add(tag); }
  constexpr void Add(std::uint64_t word) {
    hash_.hi = Mix(hash_.hi ^ word);
    hash_.lo = MixB(hash_.lo ^ word);
  }
  MeshHash Get() const { return hash_; }

 private:
  MeshHash hash_{kHiKey, kLoKey};
};

// The hash of a simplex with kIds ids. The compiler hashes the common prefix once.
template <std::uint64_t kIds>
MeshHash HashOfIds(const VertexId* ids, RegionId region) {
  constexpr WordHasher kBegun = [] {
    WordHasher hasher(kSimplexTag);
    hasher.Add(kIds);
    return hasher;
  }();
  WordHasher hasher = kBegun;
  for (std::size_t i = 0; i < kIds; ++i) hasher.Add(ids[i]);
  if (region != kNoRegion) hasher.Add(region);
  return hasher.Get();
}

// The compiler hashes the common prefix once.
template <int D>
MeshHash HashOfPosition(const double* coordinates, int containing_dimension, FeatureId owner) {
  constexpr WordHasher kBegun = [] {
    WordHasher hasher(kVertexTag);
    hasher.Add(static_cast<std::uint64_t>(D));
    return hasher;
  }();
  WordHasher hasher = kBegun;
  for (int i = 0; i < D; ++i) hasher.Add(Bits(coordinates[i]));
  hasher.Add(static_cast<std::uint64_t>(containing_dimension));
  hasher.Add(owner);
  return hasher.Get();
}

template <std::size_t kIds>
MeshHash HashConstraint(Tag tag, std::array<VertexId, kIds> ids, FeatureId owner) {
  std::sort(ids.begin(), ids.end());
  WordHasher hasher(tag);
  for (const VertexId id : ids) hasher.Add(id);
  hasher.Add(owner);
  return hasher.Get();
}

template <class Columns>
MeshHash HashOfConstraints(const Columns& columns, Steps& steps) {
  MeshHash sum;
  for (std::size_t i = 0; i < columns.size() && !steps.Stop(); ++i) {
    sum += mesh_data::HashOf(mesh_data::KeyOf(columns, i));
  }
  return sum;
}

}  // namespace

VertexId VertexIdAt(const double* coordinates, int dimension, std::uint64_t salt) {
  constexpr std::uint64_t kUnsalted = Mix(kIdKey);
  std::uint64_t h = salt == 0 ? kUnsalted : Mix(kIdKey ^ salt);
  for (int i = 0; i < dimension; ++i) h = Mix(h ^ Bits(coordinates[i]));
  return h == 0 ? 1 : h;
}

MeshHash HashVertex(const double* coordinates, int dimension, int containing_dimension,
                    FeatureId owner) {
  if (dimension == 2) return HashOfPosition<2>(coordinates, containing_dimension, owner);
  if (dimension == 3) return HashOfPosition<3>(coordinates, containing_dimension, owner);
  WordHasher hasher(kVertexTag);
  hasher.Add(static_cast<std::uint64_t>(dimension));
  for (int i = 0; i < dimension; ++i) hasher.Add(Bits(coordinates[i]));
  hasher.Add(static_cast<std::uint64_t>(containing_dimension));
  hasher.Add(owner);
  return hasher.Get();
}

RegionId RegionIdOf(std::span<const FeatureId> polygons) {
  if (polygons.size() < 2) return polygons.empty() ? kNoRegion : polygons.front();
  std::uint64_t h = Mix(kRegionKey);
  for (const FeatureId id : polygons) h = Mix(h ^ id);
  return h | std::uint64_t{1} << 63;
}

std::vector<FeatureId> PolygonsOf(RegionId region, std::span<const RegionSet> sets) {
  if (region == kNoRegion) return {};
  const auto it = std::lower_bound(sets.begin(), sets.end(), region,
                                   [](const RegionSet& s, RegionId id) { return s.id < id; });
  return it != sets.end() && it->id == region ? it->polygons : std::vector<FeatureId>{region};
}

MeshHash HashSimplex(const VertexId* ids, int count, RegionId region) {
  if (count == 3) return HashOfIds<3>(ids, region);
  if (count == 4) return HashOfIds<4>(ids, region);
  WordHasher hasher(kSimplexTag);
  hasher.Add(static_cast<std::uint64_t>(count));
  for (int i = 0; i < count; ++i) hasher.Add(ids[i]);
  if (region != kNoRegion) hasher.Add(region);
  return hasher.Get();
}

MeshHash HashSubsegment(VertexId a, VertexId b, FeatureId owner) {
  return HashConstraint(kSubsegmentTag, std::array{a, b}, owner);
}

MeshHash HashSubfacet(const VertexId (&corners)[3], FeatureId owner) {
  return HashConstraint(kSubfacetTag, std::to_array(corners), owner);
}

MeshHash mesh_data::ComputeHash(const Mesh& mesh, Steps& steps) {
  MeshHash sum;
  const int d = mesh.dimension;
  for (std::size_t i = 0; i < mesh.vertices.size() && !steps.Stop(); ++i) {
    sum += HashVertex(&mesh.vertices.coordinates[i * d], d, mesh.vertices.containing_dimensions[i],
                      mesh.vertices.owners[i]);
  }
  for (std::size_t i = 0; i < mesh.simplex_count() && !steps.Stop(); ++i) {
    const VertexId* const ids = &mesh.simplices[i * (d + 1)];
    sum += d == 2 ? HashOfIds<3>(ids, mesh.region(i)) : HashSimplex(ids, d + 1, mesh.region(i));
  }
  sum += HashOfConstraints(mesh.subsegments, steps);
  sum += HashOfConstraints(mesh.subfacets, steps);
  return sum;
}

MeshHash ComputeHash(const Mesh& mesh) {
  AllSteps all;
  return mesh_data::ComputeHash(mesh, all);
}

std::string MeshHash::ToHex() const { return text::Hex(hi) + text::Hex(lo); }

absl::StatusOr<MeshHash> MeshHash::FromHex(std::string_view hex) {
  const absl::Status bad =
      absl::InvalidArgumentError("a mesh hash is 32 hexadecimal digits, high word first");
  if (hex.size() != 32) return bad;
  std::uint64_t words[2] = {0, 0};
  for (std::size_t i = 0; i < hex.size(); ++i) {
    const char c = hex[i];
    std::uint64_t digit = 0;
    if (c >= '0' && c <= '9') {
      digit = static_cast<std::uint64_t>(c - '0');
    } else if (c >= 'a' && c <= 'f') {
      digit = static_cast<std::uint64_t>(c - 'a') + 10;
    } else if (c >= 'A' && c <= 'F') {
      digit = static_cast<std::uint64_t>(c - 'A') + 10;
    } else {
      return bad;
    }
    words[i / 16] = words[i / 16] << 4 | digit;
  }
  return MeshHash{words[0], words[1]};
}

}  // namespace dynmesh
