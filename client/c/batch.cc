// Batches of edits from columns.
#include <array>
#include <string>

#include "client/c/objects.h"
#include "client/c/support.h"

namespace dynmesh::c {
namespace {

constexpr std::int32_t kMostCoordinates = 3;

// OK if there are ids, and as many rows of another column.
absl::Status CheckIds(const dynmesh_column& ids, std::size_t rows, const char* name) {
  if (auto status = CheckColumn(ids, "ids", DYNMESH_U64, 1, 1); !status.ok()) return status;
  if (ids.rows == rows) return absl::OkStatus();
  return absl::InvalidArgumentError("there are " + std::to_string(ids.rows) + " ids and " +
                                    std::to_string(rows) + " rows of " + name);
}

absl::Status CheckPlaces(const dynmesh_column& ids, const dynmesh_column& places) {
  if (auto status = CheckColumn(places, "places", DYNMESH_F64, 2, kMostCoordinates); !status.ok()) {
    return status;
  }
  return CheckIds(ids, places.rows, "places");
}

std::array<double, 3> PlaceOf(const dynmesh_column& places, std::size_t row) {
  const double* const at = RowOf<double>(places, row);
  return {at[0], at[1], places.width == 3 ? at[2] : 0.0};
}

// Appends one edit for each of `rows`: edit(row). All or none.
template <class F>
absl::Status Append(dynmesh_batch* batch, std::size_t rows, F edit) {
  const std::size_t before = batch->edits.size();
  try {
    for (std::size_t i = 0; i < rows; ++i) batch->edits.push_back(edit(i));
  } catch (...) {
    batch->edits.erase(batch->edits.begin() + static_cast<std::ptrdiff_t>(before),
                       batch->edits.end());
    throw;
  }
  return absl::OkStatus();
}

absl::Status CheckAction(int action) {
  if (action == DYNMESH_ADD || action == DYNMESH_SET) return absl::OkStatus();
  return absl::InvalidArgumentError("the action " + std::to_string(action) +
                                    " is neither DYNMESH_ADD nor DYNMESH_SET");
}

Edit EditOf(int action, const Feature& feature) {
  return action == DYNMESH_SET ? Edit::Set(feature) : Edit::Add(feature);
}

FeatureId IdOf(const dynmesh_column& ids, std::size_t row) {
  return *RowOf<std::uint64_t>(ids, row);
}

absl::Status Polygon(dynmesh_batch* batch, int action, FeatureId id, const dynmesh_column& corners,
                     const dynmesh_column& ring_ends) {
  if (auto status = CheckAction(action); !status.ok()) return status;
  std::vector<std::uint64_t> points, ends;
  if (auto status = ReadIds(corners, "corners", &points); !status.ok()) return status;
  if (auto status = ReadIds(ring_ends, "ring_ends", &ends); !status.ok()) return status;
  Rings rings;
  std::size_t begin = 0;
  for (const std::uint64_t end : ends) {
    if (end < begin || end > points.size()) {
      return absl::InvalidArgumentError("ring_ends do not ascend up to the number of corners");
    }
    rings.emplace_back(points.begin() + static_cast<std::ptrdiff_t>(begin),
                       points.begin() + static_cast<std::ptrdiff_t>(end));
    begin = end;
  }
  if (begin != points.size()) {
    return absl::InvalidArgumentError("the last of ring_ends is not the number of corners");
  }
  return Append(batch, 1, [&](std::size_t) { return EditOf(action, Feature::Polygon(id, rings)); });
}

absl::Status Sizes(dynmesh_batch* batch, int action, const dynmesh_column& ids,
                   const dynmesh_column& places, const dynmesh_column& radii,
                   const dynmesh_column& targets) {
  if (auto status = CheckAction(action); !status.ok()) return status;
  if (auto status = CheckPlaces(ids, places); !status.ok()) return status;
  if (auto status = CheckColumn(targets, "targets", DYNMESH_F64, 1, 1); !status.ok()) return status;
  if (auto status = CheckIds(ids, targets.rows, "targets"); !status.ok()) return status;
  if (auto status = CheckColumn(radii, "radii", DYNMESH_F64, 1, 1); !status.ok()) return status;
  if (radii.rows > 0) {
    if (auto status = CheckIds(ids, radii.rows, "radii"); !status.ok()) return status;
  }
  return Append(batch, ids.rows, [&](std::size_t i) {
    Sizing sizing;
    sizing.target = *RowOf<double>(targets, i);
    if (radii.rows > 0) sizing.shape = SizeShape::kDisc, sizing.radius = *RowOf<double>(radii, i);
    return EditOf(action, Feature::Size(IdOf(ids, i), PlaceOf(places, i), sizing));
  });
}

}  // namespace
}  // namespace dynmesh::c

using namespace dynmesh::c;  // NOLINT(google-build-using-namespace): of functions for C
using dynmesh::Edit;
using dynmesh::Feature;

extern "C" {

int dynmesh_batch_new(dynmesh_batch** batch, dynmesh_error* error) {
  *batch = nullptr;
  return Guarded(error, [&] {
    *batch = new dynmesh_batch;
    return absl::OkStatus();
  });
}

void dynmesh_batch_free(dynmesh_batch* batch) { delete batch; }

void dynmesh_batch_clear(dynmesh_batch* batch) { batch->edits.clear(); }

size_t dynmesh_batch_count(const dynmesh_batch* batch) { return batch->edits.size(); }

int dynmesh_add_points(dynmesh_batch* batch, int action, dynmesh_column ids, dynmesh_column places,
                       dynmesh_error* error) {
  return Guarded(error, [&] {
    if (auto status = CheckAction(action); !status.ok()) return status;
    if (auto status = CheckPlaces(ids, places); !status.ok()) return status;
    return Append(batch, ids.rows, [&](std::size_t i) {
      const auto p = PlaceOf(places, i);
      return EditOf(action, Feature::Point(IdOf(ids, i), p[0], p[1], p[2]));
    });
  });
}

int dynmesh_add_segments(dynmesh_batch* batch, int action, dynmesh_column ids, dynmesh_column ends,
                         dynmesh_error* error) {
  return Guarded(error, [&] {
    if (auto status = CheckAction(action); !status.ok()) return status;
    if (auto status = CheckColumn(ends, "ends", DYNMESH_U64, 2, 2); !status.ok()) return status;
    if (auto status = CheckIds(ids, ends.rows, "ends"); !status.ok()) return status;
    return Append(batch, ids.rows, [&](std::size_t i) {
      const auto* const pair = RowOf<std::uint64_t>(ends, i);
      return EditOf(action, Feature::Segment(IdOf(ids, i), pair[0], pair[1]));
    });
  });
}

int dynmesh_add_polygon(dynmesh_batch* batch, int action, uint64_t id, dynmesh_column corners,
                        dynmesh_column ring_ends, dynmesh_error* error) {
  return Guarded(error, [&] { return Polygon(batch, action, id, corners, ring_ends); });
}

int dynmesh_add_sizes(dynmesh_batch* batch, int action, dynmesh_column ids, dynmesh_column places,
                      dynmesh_column radii, dynmesh_column targets, dynmesh_error* error) {
  return Guarded(error, [&] { return Sizes(batch, action, ids, places, radii, targets); });
}

int dynmesh_move_points(dynmesh_batch* batch, dynmesh_column ids, dynmesh_column places,
                        dynmesh_error* error) {
  return Guarded(error, [&] {
    if (auto status = CheckPlaces(ids, places); !status.ok()) return status;
    return Append(batch, ids.rows, [&](std::size_t i) {
      const auto p = PlaceOf(places, i);
      return Edit::Move(IdOf(ids, i), p[0], p[1], p[2]);
    });
  });
}

int dynmesh_remove(dynmesh_batch* batch, dynmesh_column ids, dynmesh_error* error) {
  return Guarded(error, [&] {
    if (auto status = CheckIds(ids, ids.rows, "ids"); !status.ok()) return status;
    return Append(batch, ids.rows, [&](std::size_t i) { return Edit::Remove(IdOf(ids, i)); });
  });
}

int dynmesh_set_label(dynmesh_batch* batch, uint64_t id, int64_t marker, const char* name,
                      dynmesh_error* error) {
  return Guarded(error, [&] {
    return Append(batch, 1, [&](std::size_t) {
      return Edit::SetLabel(id, {marker, name == nullptr ? "" : name});
    });
  });
}

}  // extern "C"
