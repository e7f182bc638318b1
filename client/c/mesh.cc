// Meshes, their columns, and fields across their diffs.
#include <algorithm>
#include <cstring>
#include <string>

#include "client/c/objects.h"
#include "client/c/support.h"

namespace dynmesh::c {
namespace {

absl::Status NoSuch(const char* what, int which) {
  return absl::InvalidArgumentError("there is no " + std::string(what) + " " +
                                    std::to_string(which));
}

absl::StatusOr<dynmesh_column> ArrayOf(const SlotMesh& mesh, int which) {
  const auto d = static_cast<std::size_t>(mesh.dimension());
  switch (which) {
    case DYNMESH_POINTS:
      return ColumnOf(mesh.points().span(), d);
    case DYNMESH_VERTEX_IDS:
      return ColumnOf(mesh.ids().span());
    case DYNMESH_OWNERS:
      return ColumnOf(mesh.owners().span());
    case DYNMESH_ON:
      return ColumnOf(mesh.containing_dimensions().span());
    case DYNMESH_CELLS:
      return ColumnOf(mesh.cells().span(), d + 1);
    case DYNMESH_NEIGHBOURS:
      return ColumnOf(mesh.neighbours().span(), d + 1);
    case DYNMESH_REGIONS:
      return ColumnOf(mesh.regions().span());
    case DYNMESH_SUBSEGMENTS:
      return ColumnOf(mesh.subsegments().span(), 2);
    case DYNMESH_SUBSEGMENT_OWNERS:
      return ColumnOf(mesh.subsegment_owners().span());
    case DYNMESH_SUBFACETS:
      return ColumnOf(mesh.subfacets().span(), 3);
    case DYNMESH_SUBFACET_OWNERS:
      return ColumnOf(mesh.subfacet_owners().span());
    default:
      return NoSuch("array", which);
  }
}

template <class T>
dynmesh_column ColumnOfVector(const std::vector<T>& values, std::size_t width = 1) {
  return ColumnOf(std::span<const T>(values), width);
}

absl::StatusOr<dynmesh_column> DiffOf(const dynmesh_mesh& mesh, int which) {
  static const MeshPatch kNoPatch;
  const MeshPatch& patch = mesh.was_empty ? kNoPatch : mesh.slots.patch();
  switch (which) {
    case DYNMESH_REMOVED_VERTICES:
      return ColumnOfVector(patch.removed_vertices);
    case DYNMESH_ADDED_VERTICES:
      return ColumnOfVector(patch.added_vertices);
    case DYNMESH_REMOVED_CELLS:
      return ColumnOfVector(patch.removed_simplices);
    case DYNMESH_REMOVED_CORNERS:
      return ColumnOfVector(patch.removed_corners,
                            static_cast<std::size_t>(mesh.slots.dimension() + 1));
    case DYNMESH_REMOVED_REGIONS:
      return ColumnOfVector(patch.removed_regions);
    case DYNMESH_ADDED_CELLS:
      return ColumnOfVector(patch.added_simplices);
    case DYNMESH_RELABELLED_CELLS:
      return ColumnOfVector(patch.relabelled_simplices);
    case DYNMESH_FORMER_REGIONS:
      return ColumnOfVector(patch.former_regions);
    default:
      return NoSuch("column of a diff", which);
  }
}

absl::Status Open(const dynmesh_options* options, dynmesh_mesh** mesh) {
  const auto asked = OptionsOf(options);
  if (!asked.ok()) return asked.status();
  auto mesher = DynamicMesh::Create(*asked);
  if (!mesher.ok()) return mesher.status();
  auto slots = SlotMesh::FromMesh((*mesher)->Snapshot());
  if (!slots.ok()) return slots.status();
  *mesh = new dynmesh_mesh(*std::move(mesher), *std::move(slots));
  return absl::OkStatus();
}

absl::Status Apply(dynmesh_mesh* mesh, const dynmesh_batch* batch,
                   const dynmesh_apply_options* options) {
  if (mesh->is_lost) {
    return absl::DataLossError(
        "an edit of this mesh was broken off, as by lack of memory: open a new one");
  }
  ApplyOptions apply;
  dynmesh_apply_options given = DefaultApplyOptions();
  if (options != nullptr) {
    if (auto status = ReadStructure(options, &given); !status.ok()) return status;
  }
  if (given.interrupted != nullptr) {
    apply.interrupted = [&given] { return given.interrupted(given.context) != 0; };
  }
  apply.max_operations = given.max_operations;
  // As the last step of the edit: if the slots cannot follow, the edit is undone.
  apply.commit = [mesh](const MeshDiff& diff) {
    if (diff.from_revision == diff.to_revision) return absl::OkStatus();
    mesh->transfer.reset();
    return mesh->slots.Apply(diff);
  };
  try {
    auto diff = mesh->mesher->Apply(batch->edits, apply);
    if (!diff.ok()) return diff.status();
    mesh->was_empty = diff->from_revision == diff->to_revision;
    if (!mesh->was_empty) mesh->diff = *std::move(diff), mesh->has_diff = true;
    return absl::OkStatus();
  } catch (const std::bad_alloc&) {
    mesh->is_lost = true;
    return absl::ResourceExhaustedError(  // or throws, which is reported as well
        "memory ran out in the middle of the edit: this mesh can be read, and takes no more edits");
  } catch (...) {
    mesh->is_lost = true;
    throw;
  }
}

absl::Status Locate(const dynmesh_mesh& mesh, const dynmesh_column& places, std::int32_t* cells) {
  const std::int32_t d = mesh.slots.dimension();
  if (mesh.mesher->options().kind == MeshKind::kQuadtree) {
    return absl::UnimplementedError("a quadtree has leaves, not cells of a triangulation");
  }
  if (auto status = CheckColumn(places, "places", DYNMESH_F64, d, d); !status.ok()) return status;
  if (places.rows > 0 && (cells == nullptr || !IsAligned(cells, sizeof(*cells)))) {
    return absl::InvalidArgumentError("`cells` is NULL or at no multiple of 4 bytes");
  }
  std::vector<double> points;
  points.reserve(places.rows * static_cast<std::size_t>(d));
  for (std::size_t i = 0; i < places.rows; ++i) {
    const double* const at = RowOf<double>(places, i);
    points.insert(points.end(), at, at + d);
  }
  const SimplexColumn ids = mesh.mesher->Locate(points);
  const auto width = static_cast<std::size_t>(d + 1);
  for (std::size_t i = 0; i < places.rows; ++i) {
    cells[i] = mesh.slots.FindSimplexSlot(std::span(ids).subspan(i * width, width));
  }
  return absl::OkStatus();
}

absl::StatusOr<FieldOptions> FieldOf(const dynmesh_field* given) {
  dynmesh_field field = DefaultField();
  if (auto status = ReadStructure(given, &field); !status.ok()) return status;
  FieldOptions options;
  constexpr FieldKind kKinds[] = {FieldKind::kP0,
                                  FieldKind::kP0Linear,
                                  FieldKind::kP1,
                                  FieldKind::kDG1,
                                  FieldKind::kDual,
                                  FieldKind::kDualCorners,
                                  FieldKind::kLargestOverlap};
  if (field.kind < DYNMESH_P0 || field.kind > DYNMESH_OVERLAP) {
    return NoSuch("kind of field", field.kind);
  }
  options.kind = kKinds[field.kind - DYNMESH_P0];
  options.components = field.components;
  options.rings = field.rings;
  options.bounded = field.bounded != 0;
  if (options.components < 1) return absl::InvalidArgumentError("a field has 1 component or more");
  return options;
}

absl::Status Carry(dynmesh_mesh* mesh, const dynmesh_field* field, double* values, std::size_t rows,
                   std::ptrdiff_t stride) {
  const auto options = FieldOf(field);
  if (!options.ok()) return options.status();
  if (!mesh->has_diff && !mesh->was_empty) {
    return absl::FailedPreconditionError("no batch was applied yet");
  }
  const SlotMesh& slots = mesh->slots;
  const bool by_vertex = options->kind == FieldKind::kP1 || options->kind == FieldKind::kDual;
  const bool by_corner =
      options->kind == FieldKind::kDG1 || options->kind == FieldKind::kDualCorners;
  const std::size_t wanted = by_vertex ? slots.ids().size() : slots.regions().size();
  if (rows != wanted) {
    return absl::InvalidArgumentError("the field has " + std::to_string(rows) + " rows, not " +
                                      std::to_string(wanted));
  }
  const std::size_t width = static_cast<std::size_t>(options->components) *
                            (by_corner ? static_cast<std::size_t>(slots.dimension() + 1) : 1);
  if (stride % 8 != 0 || stride < static_cast<std::ptrdiff_t>(width * sizeof(double))) {
    return absl::InvalidArgumentError("the stride is less than a row or no multiple of 8 bytes");
  }
  if (rows > 0 && (values == nullptr || !IsAligned(values, sizeof(*values)))) {
    return absl::InvalidArgumentError("`values` is NULL or at no multiple of 8 bytes");
  }
  if (mesh->was_empty) return absl::OkStatus();
  if (!mesh->transfer) {
    auto transfer = Transfer::Make(slots);
    if (!transfer.ok()) return transfer.status();
    mesh->transfer.emplace(*std::move(transfer));
  }
  const auto step = static_cast<std::size_t>(stride) / sizeof(double);
  if (step == width) return mesh->transfer->Carry(*options, {values, rows * width}).status();
  std::vector<double> packed(rows * width);
  for (std::size_t i = 0; i < rows; ++i) std::copy_n(values + i * step, width, &packed[i * width]);
  if (auto flows = mesh->transfer->Carry(*options, packed); !flows.ok()) return flows.status();
  for (std::size_t i = 0; i < rows; ++i) std::copy_n(&packed[i * width], width, values + i * step);
  return absl::OkStatus();
}

// Gives out the column, or the error.
absl::Status Give(const absl::StatusOr<dynmesh_column>& column, dynmesh_column* to) {
  if (column.ok()) *to = *column;
  return column.status();
}

}  // namespace
}  // namespace dynmesh::c

extern "C" {

int dynmesh_open(const dynmesh_options* options, dynmesh_mesh** mesh, dynmesh_error* error) {
  *mesh = nullptr;
  return dynmesh::c::Guarded(error, [&] { return dynmesh::c::Open(options, mesh); });
}

void dynmesh_close(dynmesh_mesh* mesh) { delete mesh; }

uint64_t dynmesh_revision(const dynmesh_mesh* mesh) { return mesh->slots.revision(); }

void dynmesh_hash(const dynmesh_mesh* mesh, char hash[33]) {
  const dynmesh::MeshHash sum = mesh->slots.hash();
  const char* const digits = "0123456789abcdef";
  for (int i = 0; i < 16; ++i) {
    hash[i] = digits[(sum.hi >> (60 - 4 * i)) & 15];
    hash[16 + i] = digits[(sum.lo >> (60 - 4 * i)) & 15];
  }
  hash[32] = 0;
}

uint64_t dynmesh_count(const dynmesh_mesh* mesh, int which) {
  switch (which) {
    case DYNMESH_VERTICES:
      return mesh->slots.vertex_count();
    case DYNMESH_CELLS_IN_USE:
      return mesh->slots.simplex_count();
    case DYNMESH_VERTEX_SLOTS:
      return mesh->slots.ids().size();
    case DYNMESH_CELL_SLOTS:
      return mesh->slots.regions().size();
    case DYNMESH_FEATURES:
      return mesh->mesher->Stats().features;
    default:
      return 0;
  }
}

int dynmesh_apply(dynmesh_mesh* mesh, const dynmesh_batch* batch,
                  const dynmesh_apply_options* options, dynmesh_error* error) {
  return dynmesh::c::Guarded(error, [&] { return dynmesh::c::Apply(mesh, batch, options); });
}

int dynmesh_array(const dynmesh_mesh* mesh, int which, dynmesh_column* column,
                  dynmesh_error* error) {
  return dynmesh::c::Guarded(
      error, [&] { return dynmesh::c::Give(dynmesh::c::ArrayOf(mesh->slots, which), column); });
}

int dynmesh_diff(const dynmesh_mesh* mesh, int which, dynmesh_column* column,
                 dynmesh_error* error) {
  return dynmesh::c::Guarded(
      error, [&] { return dynmesh::c::Give(dynmesh::c::DiffOf(*mesh, which), column); });
}

int dynmesh_locate(const dynmesh_mesh* mesh, dynmesh_column places, int32_t* cells,
                   dynmesh_error* error) {
  return dynmesh::c::Guarded(error, [&] { return dynmesh::c::Locate(*mesh, places, cells); });
}

int dynmesh_carry(dynmesh_mesh* mesh, const dynmesh_field* field, double* values, size_t rows,
                  ptrdiff_t stride, dynmesh_error* error) {
  return dynmesh::c::Guarded(error,
                             [&] { return dynmesh::c::Carry(mesh, field, values, rows, stride); });
}

}  // extern "C"
