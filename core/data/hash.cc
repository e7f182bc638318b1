// Vertex ids and mesh hashes. Fixed for good: clients in other languages, journals
// and files depend on every bit, so this is a specification as much as code.
//
// All arithmetic is on unsigned 64-bit words modulo 2^64. bits(c) is the IEEE-754
// pattern of the coordinate c, after adding +0.0 (which turns -0 into +0).
//
//   MixA(z): z += 9e3779b97f4a7c15; z = (z ^ z >> 30) * bf58476d1ce4e5b9;
//            z = (z ^ z >> 27) * 94d049bb133111eb; z ^ z >> 31
//   MixB(z): z += d1b54a32d192ed03; z = (z ^ z >> 33) * ff51afd7ed558ccd;
//            z = (z ^ z >> 33) * c4ceb9fe1a85ec53; z ^ z >> 33
//
//   id(c_1..c_d, salt): h = MixA(a0761d6478bd642f ^ salt);
//                       h = MixA(h ^ bits(c_i)) for i = 1..d;
//                       the id is h, or 1 if h is 0
//   hash(w_1..w_n):     hi = 8ebc6af09c88c6e3; hi = MixA(hi ^ w_i) for i = 1..n
//                       lo = 589965cc75374cc3; lo = MixB(lo ^ w_i) for i = 1..n
//
//   vertex:     hash(1, d, bits(c_1)..bits(c_d), containing dimension, owner)
//   simplex:    hash(2, number of ids, ids in canonical order), in a region other than 0
//               hash(2, number of ids, ids in canonical order, region)
//   subsegment: hash(3, lesser end's id, greater end's id, owner)
//   subfacet:   hash(4, the three corners' ids in ascending order, owner)
//   region:     the id of a polygon if there is one, for several in ascending order
//               h = MixA(e7037ed1a0b428db); h = MixA(h ^ id_i) for i = 1..n; with the top
//               bit set
//   mesh:       the sum of all of these, hi and lo each modulo 2^64
//
// Two unlike bijective mixes under unlike keys: a collision must happen in both
// words at once. Good against accidents; not meant against an adversary.
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "core/data/pieces.h"
#include "core/data/text.h"
#include "dynmesh/mesh.h"

namespace dynmesh {
namespace {

constexpr std::uint64_t MixA(std::uint64_t z) {
  z += 0x9e3779b97f4a7c15ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

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
  explicit WordHasher(Tag tag) { Add(tag); }
  void Add(std::uint64_t word) {
    hash_.hi = MixA(hash_.hi ^ word);
    hash_.lo = MixB(hash_.lo ^ word);
  }
  MeshHash Get() const { return hash_; }

 private:
  MeshHash hash_{kHiKey, kLoKey};
};

template <std::size_t kIds>
MeshHash HashPiece(Tag tag, std::array<VertexId, kIds> ids, FeatureId owner) {
  std::sort(ids.begin(), ids.end());
  WordHasher hasher(tag);
  for (const VertexId id : ids) hasher.Add(id);
  hasher.Add(owner);
  return hasher.Get();
}

template <class Columns>
MeshHash HashOfPieces(const Columns& columns) {
  MeshHash sum;
  for (std::size_t i = 0; i < columns.size(); ++i) sum += data::HashOf(data::KeyOf(columns, i));
  return sum;
}

}  // namespace

VertexId VertexIdAt(const double* coordinates, int dimension, std::uint64_t salt) {
  std::uint64_t h = MixA(kIdKey ^ salt);
  for (int i = 0; i < dimension; ++i) h = MixA(h ^ Bits(coordinates[i]));
  return h == 0 ? 1 : h;
}

MeshHash HashVertex(const double* coordinates, int dimension, int containing_dimension,
                    FeatureId owner) {
  WordHasher hasher(kVertexTag);
  hasher.Add(static_cast<std::uint64_t>(dimension));
  for (int i = 0; i < dimension; ++i) hasher.Add(Bits(coordinates[i]));
  hasher.Add(static_cast<std::uint64_t>(containing_dimension));
  hasher.Add(owner);
  return hasher.Get();
}

RegionId RegionIdOf(std::span<const FeatureId> polygons) {
  if (polygons.size() < 2) return polygons.empty() ? kNoRegion : polygons.front();
  std::uint64_t h = MixA(kRegionKey);
  for (const FeatureId id : polygons) h = MixA(h ^ id);
  return h | std::uint64_t{1} << 63;
}

std::vector<FeatureId> PolygonsOf(RegionId region, std::span<const RegionSet> sets) {
  if (region == kNoRegion) return {};
  const auto it = std::lower_bound(sets.begin(), sets.end(), region,
                                   [](const RegionSet& s, RegionId id) { return s.id < id; });
  return it != sets.end() && it->id == region ? it->polygons : std::vector<FeatureId>{region};
}

MeshHash HashSimplex(const VertexId* ids, int count, RegionId region) {
  WordHasher hasher(kSimplexTag);
  hasher.Add(static_cast<std::uint64_t>(count));
  for (int i = 0; i < count; ++i) hasher.Add(ids[i]);
  if (region != kNoRegion) hasher.Add(region);
  return hasher.Get();
}

MeshHash HashSubsegment(VertexId a, VertexId b, FeatureId owner) {
  return HashPiece(kSubsegmentTag, std::array{a, b}, owner);
}

MeshHash HashSubfacet(const VertexId (&corners)[3], FeatureId owner) {
  return HashPiece(kSubfacetTag, std::to_array(corners), owner);
}

MeshHash ComputeHash(const Mesh& mesh) {
  MeshHash sum;
  const int d = mesh.dimension;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    sum += HashVertex(&mesh.vertices.coordinates[i * d], d, mesh.vertices.containing_dimensions[i],
                      mesh.vertices.owners[i]);
  }
  for (std::size_t i = 0; i < mesh.simplex_count(); ++i) {
    sum += HashSimplex(&mesh.simplices[i * (d + 1)], d + 1, mesh.region(i));
  }
  sum += HashOfPieces(mesh.subsegments);
  sum += HashOfPieces(mesh.subfacets);
  return sum;
}

std::string MeshHash::ToHex() const { return data::Hex(hi) + data::Hex(lo); }

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
