#include "server/calls/build_request.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "proto/codec/edit_codec.h"
#include "proto/codec/status_codec.h"
#include "server/calls/requests.h"

namespace dynmesh::server {
namespace {

// What the first message alone may have; null if the message has none of it.
const char* FieldOfFirst(const v1::BuildMeshRequest& message) {
  if (message.has_options()) return "options";
  if (message.engine() != v1::BUILD_ENGINE_UNSPECIFIED) return "engine";
  if (message.only_inside()) return "only_inside";
  return message.has_max_time() ? "max_time" : nullptr;
}

absl::StatusOr<BuildEngine> DecodeEngine(v1::BuildEngine engine) {
  switch (engine) {
    case v1::BUILD_ENGINE_UNSPECIFIED:
    case v1::BUILD_ENGINE_DYNAMIC:
      return BuildEngine::kDynamic;
    case v1::BUILD_ENGINE_SVR:
      return BuildEngine::kSvr;
    default:
      return BadRequest("engine", "is unknown: DYNAMIC or SVR");
  }
}

// `most` is 0 without a limit.
absl::StatusOr<absl::Duration> DecodeMaxTime(const google::protobuf::Duration& proto,
                                             absl::Duration most) {
  const absl::Duration time = absl::Seconds(proto.seconds()) + absl::Nanoseconds(proto.nanos());
  if (time < absl::ZeroDuration()) return BadRequest("max_time", "must not be negative");
  const bool is_limited = most > absl::ZeroDuration();
  if (is_limited && time > most) {
    return BadRequest("max_time",
                      absl::StrCat("is above this server's limit of ", absl::FormatDuration(most)));
  }
  if (time > absl::ZeroDuration()) return time;
  return is_limited ? most : absl::InfiniteDuration();
}

std::uint64_t MaxVertices(const ServiceContext& context, int dimension) {
  const std::uint64_t own = context.config.max_build_vertices;
  return own != 0 ? own : context.registry->MaxVertices(dimension);
}

}  // namespace

absl::Status BuildRequest::Begin(ServiceContext& context, const v1::BuildMeshRequest& first) {
  if (!first.has_options()) {
    return BadRequest("options", "are missing: the first message must have them");
  }
  absl::StatusOr<MeshOptions> options = codec::DecodeOptions(
      first.options(), MaxVertices(context, first.options().dimension() == 3 ? 3 : 2));
  if (!options.ok()) return options.status();
  if (absl::Status s = CheckBoxOfNew(*options); !s.ok()) return s;
  const absl::StatusOr<BuildEngine> engine = DecodeEngine(first.engine());
  if (!engine.ok()) return engine.status();
  const absl::StatusOr<absl::Duration> max_time =
      DecodeMaxTime(first.max_time(), context.config.max_build_time);
  if (!max_time.ok()) return max_time.status();
  job_.options = *std::move(options);
  job_.engine = *engine;
  job_.only_inside = first.only_inside();
  job_.max_time = *max_time;
  return absl::OkStatus();
}

absl::Status BuildRequest::Reserve(ServiceContext& context, const Pass& pass,
                                   const v1::BuildMeshRequest& message) {
  const auto points = static_cast<std::size_t>(message.points().ids_size());
  const std::size_t weight = points + codec::Weight(message.features());
  codec::ServiceError error;
  if (weight_ + weight > context.config.max_batch_edits) {
    error.reason = codec::reason::kBatchTooLarge;
    error.field = "features";
    return codec::MakeServiceError(
        absl::StatusCode::kInvalidArgument,
        absl::StrCat("a build may have ", context.config.max_batch_edits,
                     " features at most, 8 points of a polygon count as one: leave some out, or "
                     "create a mesh and load them in several batches"),
        error);
  }
  const std::size_t features =
      edits_.size() + points + static_cast<std::size_t>(message.features_size());
  if (features > context.config.max_features) {
    error.reason = codec::reason::kFeatureLimit;
    return codec::MakeServiceError(
        absl::StatusCode::kResourceExhausted,
        absl::StrCat("the mesh would have more than the ", context.config.max_features,
                     " features that this server allows one mesh"),
        error);
  }
  weight_ += weight;
  return held_.Take(context, pass, weight);
}

absl::Status BuildRequest::Add(ServiceContext& context, const Pass& pass,
                               const v1::BuildMeshRequest& message) {
  if (!has_begun_) {
    if (absl::Status s = Begin(context, message); !s.ok()) return s;
    has_begun_ = true;
  } else if (const char* field = FieldOfFirst(message)) {
    return BadRequest(field, "belongs in the first message");
  }
  if (absl::Status s = Reserve(context, pass, message); !s.ok()) return s;
  parts_.Add(message, edits_.size());
  const int dimension = job_.options.dimension;
  if (absl::Status s = codec::DecodePointColumns(message.points(), dimension, &edits_); !s.ok()) {
    return s;
  }
  return codec::DecodeAdds(message.features(), dimension, &edits_);
}

BuildJob BuildRequest::TakeJob() {
  job_.features.reserve(edits_.size());
  for (Edit& edit : edits_) job_.features.push_back(std::move(edit.feature));
  EditBatch().swap(edits_);
  return std::move(job_);
}

}  // namespace dynmesh::server
