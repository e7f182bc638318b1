// Sends features in parts, for loads and builds.
#ifndef DYNMESH_CLIENT_FEATURE_SENDER_INTERNAL_H_
#define DYNMESH_CLIENT_FEATURE_SENDER_INTERNAL_H_

#include <grpcpp/grpcpp.h>

#include <atomic>
#include <cstddef>
#include <utility>

#include "client/channel_internal.h"
#include "core/base/feature_kinds.h"
#include "proto/codec/edit_codec.h"

namespace dynmesh::client {

// `Stream` is a ClientReaderWriter of `Request`, a message with points, features and last. Used by
// one thread, but for IsCancelled.
template <class Request, class Stream>
class FeatureSender {
 public:
  // The parameters outlive the sender. `first` has the other fields of the first message;
  // `cancelled` may be null.
  FeatureSender(grpc::ClientContext& context, Stream& stream, Request first, int dimension,
                const std::atomic<bool>* cancelled)
      : context_(context),
        stream_(stream),
        message_(std::move(first)),
        dimension_(dimension),
        cancelled_(cancelled) {}

  // Sends all and the end. Stops early if the stream ends, which tells why.
  void SendAll(const FeatureSource& source) {
    for (auto some = source(); !some.empty(); some = source()) {
      for (const Feature& feature : some) {
        if (!Add(feature)) return;
      }
    }
    message_.set_last(true);
    if (Write()) stream_.WritesDone();
  }

  // If so, ends the call. From any thread.
  bool IsCancelled() const {
    if (cancelled_ == nullptr || !cancelled_->load()) return false;
    context_.TryCancel();
    return true;
  }

 private:
  static constexpr std::size_t kPointBytes = 34;  // upper bound of a row

  // Keeps the order of features: the points of a message precede its other features.
  bool Add(const Feature& feature) {
    if (IsPoint(feature) && !feature.label && message_.features_size() == 0) {
      codec::EncodePointRow(feature, dimension_, message_.mutable_points());
      bytes_ += kPointBytes;
    } else {
      codec::EncodeFeature(feature, dimension_, message_.add_features());
      bytes_ += WireBytes(feature);
    }
    return bytes_ < kMessageBytes || Write();
  }

  bool Write() {
    if (IsCancelled()) return false;
    const bool ok = stream_.Write(message_);
    message_.Clear();
    bytes_ = 0;
    return ok;
  }

  grpc::ClientContext& context_;
  Stream& stream_;
  Request message_;
  std::size_t bytes_ = 0;  // upper bound of its size
  const int dimension_;
  const std::atomic<bool>* const cancelled_;
};

// The stage of progress from the server.
LoadProgress::Stage StageOf(v1::LoadFeaturesResponse::Stage stage);

}  // namespace dynmesh::client

#endif  // DYNMESH_CLIENT_FEATURE_SENDER_INTERNAL_H_
