#include "proto/codec/features_codec.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "proto/codec/edit_codec.h"

namespace dynmesh::codec {

bool FeaturesFragmenter::Next(v1::FeaturesChunk* out) {
  out->Clear();
  if (done_) return false;
  out->set_revision(features_.revision);
  std::size_t bytes = 0;
  for (; next_ < features_.features.size(); ++next_) {
    EncodeFeature(features_.features[next_], dimension_, out->add_features());
    const std::size_t one = out->features(out->features_size() - 1).ByteSizeLong();
    if (bytes > 0 && bytes + one > chunk_bytes_) {
      out->mutable_features()->RemoveLast();
      return true;
    }
    bytes += one;
  }
  out->set_hash(features_.hash.ToHex());
  done_ = true;
  return true;
}

absl::StatusOr<std::optional<FeaturesAt>> FeaturesAssembler::Add(const v1::FeaturesChunk& chunk) {
  if (!features_.has_value()) features_.emplace().revision = chunk.revision();
  if (chunk.revision() != features_->revision) {
    return absl::DataLossError("the chunks are of different revisions");
  }
  EditBatch adds;
  if (absl::Status s = DecodeAdds(chunk.features(), dimension_, &adds); !s.ok()) {
    return absl::DataLossError(s.message());
  }
  for (Edit& add : adds) {
    std::vector<Feature>& all = features_->features;
    if (!all.empty() && add.feature.id <= all.back().id) {
      return absl::DataLossError(
          absl::StrCat("feature ", add.feature.id, " follows ", all.back().id));
    }
    all.push_back(std::move(add.feature));
  }
  if (chunk.hash().empty()) return std::optional<FeaturesAt>();
  const absl::StatusOr<MeshHash> hash = MeshHash::FromHex(chunk.hash());
  if (!hash.ok()) return absl::DataLossError(hash.status().message());
  features_->hash = *hash;
  return std::exchange(features_, std::nullopt);
}

}  // namespace dynmesh::codec
