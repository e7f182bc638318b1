#include "proto/codec/journal_codec.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>

#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "dynmesh/v1/journal.pb.h"
#include "proto/codec/edit_codec.h"
#include "proto/codec/mesh_codec.h"

namespace dynmesh::codec {
namespace {

constexpr std::size_t kPartBytes = 1 << 20;

template <typename Message>
absl::StatusOr<Message> Parse(const std::string& bytes) {
  Message message;
  if (message.ParseFromString(bytes)) return message;
  return absl::DataLossError(
      absl::StrCat("these ", bytes.size(), " bytes are no ", message.GetTypeName()));
}

// An undecodable record of this program is damage, not an invalid argument of a caller.
absl::Status Damage(const absl::Status& status) {
  return status.ok() ? status : absl::DataLossError(status.message());
}

absl::Status DecodeHash(const std::string& hex, MeshHash* out) {
  const absl::StatusOr<MeshHash> hash = MeshHash::FromHex(hex);
  if (hash.ok()) *out = *hash;
  return Damage(hash.status());
}

// The first versions wrote no bits.
template <typename Message>
std::uint32_t DecodeBits(const Message& message) {
  return message.bits() == 0 ? 1 : message.bits();
}

class SnapshotParts {
 public:
  SnapshotParts(const MeshHash& hash, int dimension, std::uint32_t bits)
      : hash_(hash.ToHex()), dimension_(dimension), bits_(bits) {}

  void Add(const Feature& feature) {
    EncodeFeature(feature, dimension_, proto_.add_features());
    bytes_ += proto_.features(proto_.features_size() - 1).ByteSizeLong();
    if (bytes_ >= kPartBytes) Close();
  }
  std::vector<std::string> Take() {
    if (bytes_ > 0 || parts_.empty()) Close();
    return std::move(parts_);
  }

 private:
  void Close() {
    proto_.set_hash(hash_);
    proto_.set_bits(bits_);
    parts_.push_back(proto_.SerializeAsString());
    proto_.Clear();
    bytes_ = 0;
  }

  const std::string hash_;
  const int dimension_;
  const std::uint32_t bits_;
  std::vector<std::string> parts_;
  v1::JournalSnapshot proto_;
  std::size_t bytes_ = 0;
};

}  // namespace

std::string EncodeJournalMesh(const JournalMesh& mesh) {
  v1::JournalMesh proto;
  EncodeOptions(mesh.options, proto.mutable_options());
  EncodeTime(mesh.create_time, proto.mutable_create_time());
  proto.set_request_id(mesh.request_id);
  return proto.SerializeAsString();
}

absl::StatusOr<JournalMesh> DecodeJournalMesh(const std::string& bytes) {
  auto proto = Parse<v1::JournalMesh>(bytes);
  if (!proto.ok()) return proto.status();
  // Before bits 5 there was no such option, and slivers stayed.
  if (!proto->options().has_min_dihedral()) proto->mutable_options()->set_min_dihedral(0);
  const auto options = DecodeOptions(proto->options(), std::numeric_limits<std::uint64_t>::max());
  if (!options.ok()) return Damage(options.status());
  return JournalMesh{*options,
                     absl::FromUnixSeconds(proto->create_time().seconds()) +
                         absl::Nanoseconds(proto->create_time().nanos()),
                     proto->request_id()};
}

std::string EncodeJournalEntry(const EditBatch& edits, const MeshHash& hash, int dimension,
                               std::uint32_t bits) {
  v1::JournalEntry proto;
  proto.mutable_edits()->Reserve(static_cast<int>(edits.size()));
  for (const Edit& edit : edits) EncodeEdit(edit, dimension, proto.add_edits());
  proto.set_hash(hash.ToHex());
  proto.set_bits(bits);
  return proto.SerializeAsString();
}

absl::StatusOr<JournalEntry> DecodeJournalEntry(const std::string& bytes, int dimension) {
  const auto proto = Parse<v1::JournalEntry>(bytes);
  if (!proto.ok()) return proto.status();
  JournalEntry entry;
  absl::Status status = DecodeEdits(proto->edits(), dimension, &entry.edits);
  status.Update(DecodeHash(proto->hash(), &entry.hash));
  if (!status.ok()) return Damage(status);
  entry.bits = DecodeBits(*proto);
  return entry;
}

std::vector<std::string> EncodeJournalSnapshot(std::span<const Feature> features,
                                               const MeshHash& hash, int dimension,
                                               std::uint32_t bits) {
  SnapshotParts parts(hash, dimension, bits);
  for (const Feature& feature : features) parts.Add(feature);
  return parts.Take();
}

std::vector<std::string> EncodeJournalSnapshot(std::span<const Feature* const> features,
                                               const MeshHash& hash, int dimension,
                                               const std::atomic<bool>& cancelled) {
  SnapshotParts parts(hash, dimension, kMeshBits);
  for (const Feature* feature : features) {
    if (cancelled.load(std::memory_order_relaxed)) break;
    parts.Add(*feature);
  }
  return parts.Take();
}

absl::Status DecodeJournalSnapshot(const std::string& bytes, int dimension, JournalEntry* out) {
  const auto proto = Parse<v1::JournalSnapshot>(bytes);
  if (!proto.ok()) return proto.status();
  out->bits = DecodeBits(*proto);
  absl::Status status = DecodeAdds(proto->features(), dimension, &out->edits);
  status.Update(DecodeHash(proto->hash(), &out->hash));
  return Damage(status);
}

absl::StatusOr<MeshHash> DecodeJournalHash(const std::string& bytes) {
  using google::protobuf::internal::WireFormatLite;
  static_assert(int{v1::JournalEntry::kHashFieldNumber} == v1::JournalSnapshot::kHashFieldNumber);
  constexpr auto kHash = (std::uint32_t{v1::JournalEntry::kHashFieldNumber} << 3) |
                         WireFormatLite::WIRETYPE_LENGTH_DELIMITED;
  google::protobuf::io::CodedInputStream in(reinterpret_cast<const std::uint8_t*>(bytes.data()),
                                            static_cast<int>(bytes.size()));
  std::string hex;
  bool good = true;
  while (const std::uint32_t tag = good ? in.ReadTag() : 0) {
    good =
        tag == kHash ? WireFormatLite::ReadString(&in, &hex) : WireFormatLite::SkipField(&in, tag);
  }
  MeshHash hash;
  if (!good || !in.ConsumedEntireMessage()) {
    return absl::DataLossError(absl::StrCat("these ", bytes.size(), " bytes are no record"));
  }
  absl::Status status = DecodeHash(hex, &hash);
  if (!status.ok()) return status;
  return hash;
}

std::string EncodeJournalAnswer(const JournalAnswer& answer) {
  v1::JournalAnswer proto;
  proto.set_content_a(answer.content_a);
  proto.set_content_b(answer.content_b);
  proto.set_from_revision(answer.from_revision);
  proto.set_to_revision(answer.to_revision);
  proto.set_hash(answer.hash.ToHex());
  EncodeWork(answer.work, proto.mutable_work());
  return proto.SerializeAsString();
}

absl::StatusOr<JournalAnswer> DecodeJournalAnswer(const std::string& bytes) {
  const auto proto = Parse<v1::JournalAnswer>(bytes);
  if (!proto.ok()) return proto.status();
  JournalAnswer answer{proto->content_a(),
                       proto->content_b(),
                       proto->from_revision(),
                       proto->to_revision(),
                       {},
                       DecodeWork(proto->work())};
  if (absl::Status s = DecodeHash(proto->hash(), &answer.hash); !s.ok()) return s;
  return answer;
}

}  // namespace dynmesh::codec
