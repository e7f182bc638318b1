// Parts of messages.h's errors: features in words. Pure, thread-safe.
#ifndef DYNMESH_CORE_PLC_MESSAGE_PARTS_H_
#define DYNMESH_CORE_PLC_MESSAGE_PARTS_H_

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "core/plc/facet.h"
#include "core/plc/messages.h"
#include "core/plc/text.h"
#include "dynmesh/error.h"

namespace dynmesh::plc {

template <int D>
std::string Text(const PointFeature<D>& f) {
  return absl::StrCat("point ", f.id, " ", Text(f.p));
}

template <int D>
std::string Text(const SegmentFeature<D>& f) {
  return absl::StrCat(f.IsOfPolygon() ? "the edge of polygon " : "segment ", f.id, " from point ",
                      f.p_id, " ", Text(f.p), " to point ", f.q_id, " ", Text(f.q));
}

// Without its ends.
template <int D>
std::string ShortText(const SegmentFeature<D>& f) {
  if (!f.IsOfPolygon()) return absl::StrCat("segment ", f.id);
  return absl::StrCat("the edge from point ", f.p_id, " to point ", f.q_id, " of polygon ", f.id);
}

inline std::string Text(const Facet& f) { return absl::StrCat("polygon ", f.id()); }

template <int D>
std::string Text(const AnyFeature<D>& f) {
  return std::visit([](const auto& x) { return Text(x); }, f);
}

template <int D>
FeatureId IdOf(const AnyFeature<D>& f) {
  if (const Facet* facet = std::get_if<Facet>(&f)) return facet->id();
  if (const auto* point = std::get_if<PointFeature<D>>(&f)) return point->id;
  return std::get<SegmentFeature<D>>(f).id;
}

inline absl::Status Error(absl::StatusCode code, const char* reason,
                          std::vector<FeatureId> features, EditIndex edit, std::string message) {
  ErrorDetail detail{reason, std::move(features), std::nullopt};
  if (edit != kUntouched) detail.edit = static_cast<std::size_t>(edit);
  return MakeError(code, std::move(message), std::move(detail));
}

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_MESSAGE_PARTS_H_
