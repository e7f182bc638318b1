#include "client/c/support.h"

#include <algorithm>
#include <cstring>
#include <string_view>

#include "dynmesh/error.h"
#include "dynmesh/version.h"

namespace dynmesh::c {
namespace {

int CodeOf(absl::StatusCode code) {
  switch (code) {
    case absl::StatusCode::kOk:
    case absl::StatusCode::kCancelled:
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kNotFound:
    case absl::StatusCode::kAlreadyExists:
    case absl::StatusCode::kResourceExhausted:
    case absl::StatusCode::kFailedPrecondition:
    case absl::StatusCode::kOutOfRange:
    case absl::StatusCode::kUnimplemented:
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kDataLoss:
      return static_cast<int>(code);
    default:
      return DYNMESH_INTERNAL;
  }
}

template <std::size_t kSize>
void SetText(char (&to)[kSize], std::string_view from) {
  const std::size_t n = std::min(from.size(), kSize - 1);
  std::memcpy(to, from.data(), n);
  to[n] = 0;
}

}  // namespace

int ReportText(int code, std::string_view text, dynmesh_error* error) noexcept {
  if (error == nullptr) return code;
  *error = {};
  error->code = code, error->edit = -1;
  SetText(error->message, text);
  return code;
}

int Report(const absl::Status& status, dynmesh_error* error) noexcept {
  const int code =
      ReportText(CodeOf(status.code()), {status.message().data(), status.message().size()}, error);
  if (error == nullptr || status.ok()) return code;
  try {
    const auto detail = GetErrorDetail(status);
    if (!detail) return code;
    SetText(error->reason, detail->reason);
    if (detail->edit) error->edit = static_cast<std::int64_t>(*detail->edit);
    const std::size_t n = std::min(detail->features.size(), std::size(error->features));
    std::copy_n(detail->features.begin(), n, error->features);
    error->feature_count = static_cast<std::int32_t>(n);
  } catch (...) {  // no memory for the details
  }
  return code;
}

absl::Status CheckColumn(const dynmesh_column& column, const char* name, std::int32_t type,
                         std::int32_t least, std::int32_t most) {
  if (column.rows == 0) return absl::OkStatus();
  const auto wrong = [&](const std::string& what) {
    return absl::InvalidArgumentError("the column " + std::string(name) + " " + what);
  };
  if (column.data == nullptr) return wrong("has rows and no data");
  if (column.type != type) {
    return wrong("has values of type " + std::to_string(column.type) + ", not " +
                 std::to_string(type));
  }
  if (column.width < least || column.width > most) {
    return wrong("has " + std::to_string(column.width) + " values a row, not " +
                 std::to_string(least) +
                 (least == most ? std::string() : " to " + std::to_string(most)));
  }
  if (column.stride % 8 != 0) return wrong("has a stride that is no multiple of 8 bytes");
  if (!IsAligned(column.data, 8)) return wrong("has data at no multiple of 8 bytes");
  const auto width = static_cast<std::size_t>(column.width);
  if (column.rows > static_cast<std::size_t>(PTRDIFF_MAX) / sizeof(double) / width) {
    return wrong("has more rows than there can be in memory");
  }
  return absl::OkStatus();
}

absl::Status ReadIds(const dynmesh_column& column, const char* name,
                     std::vector<std::uint64_t>* ids) {
  if (auto status = CheckColumn(column, name, DYNMESH_U64, 1, 1); !status.ok()) return status;
  ids->resize(column.rows);
  for (std::size_t i = 0; i < column.rows; ++i) (*ids)[i] = *RowOf<std::uint64_t>(column, i);
  return absl::OkStatus();
}

absl::StatusOr<MeshOptions> OptionsOf(const dynmesh_options* options) {
  dynmesh_options given = {};
  if (auto status = ReadStructure(options, &given); !status.ok()) return status;
  given = DefaultOptions(given.dimension);  // and once more, over those of the dimension
  if (auto status = ReadStructure(options, &given); !status.ok()) return status;
  MeshOptions result;
  result.dimension = given.dimension;
  result.kind = static_cast<MeshKind>(given.kind);
  result.criterion = static_cast<Criterion>(given.criterion);
  std::copy_n(given.low, 3, result.box.lo.begin());
  std::copy_n(given.high, 3, result.box.hi.begin());
  result.quality = given.quality;
  result.max_edge = given.max_edge;
  result.min_dihedral = given.min_dihedral;
  result.limits.max_vertices = given.max_vertices;
  return result;
}

dynmesh_options OptionsFor(const MeshOptions& from) {
  dynmesh_options to = {};
  to.dimension = from.dimension;
  to.kind = static_cast<std::int32_t>(from.kind);
  to.criterion = static_cast<std::int32_t>(from.criterion);
  std::copy_n(from.box.lo.begin(), 3, to.low);
  std::copy_n(from.box.hi.begin(), 3, to.high);
  to.quality = from.quality;
  to.max_edge = from.max_edge;
  to.min_dihedral = from.min_dihedral;
  to.max_vertices = from.limits.max_vertices;
  return to;
}

dynmesh_options DefaultOptions(std::int32_t dimension) {
  MeshOptions usual;
  usual.dimension = dimension;
  usual.quality = DefaultQuality(dimension);
  usual.min_dihedral = DefaultMinDihedral(dimension);
  return OptionsFor(usual);
}

dynmesh_apply_options DefaultApplyOptions() { return {}; }

dynmesh_field DefaultField() {
  dynmesh_field field = {};
  field.kind = DYNMESH_P1, field.components = 1, field.rings = 1;
  return field;
}

dynmesh_choice DefaultChoice() {
  dynmesh_choice choice = {};
  choice.inside = 1;
  return choice;
}

}  // namespace dynmesh::c

extern "C" {

const char* dynmesh_version(void) { return dynmesh::LinkedVersion(); }

void dynmesh_fill_options(int32_t dimension, dynmesh_options* options, size_t size) {
  dynmesh::c::Fill(dynmesh::c::DefaultOptions(dimension), options, size);
}

void dynmesh_fill_apply_options(dynmesh_apply_options* options, size_t size) {
  dynmesh::c::Fill(dynmesh::c::DefaultApplyOptions(), options, size);
}

void dynmesh_fill_field(dynmesh_field* field, size_t size) {
  dynmesh::c::Fill(dynmesh::c::DefaultField(), field, size);
}

void dynmesh_fill_choice(dynmesh_choice* choice, size_t size) {
  dynmesh::c::Fill(dynmesh::c::DefaultChoice(), choice, size);
}

}  // extern "C"
