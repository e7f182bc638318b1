// Parts of a mesh, and files.
#include "dynmesh/part.h"

#include <string>

#include "client/c/objects.h"
#include "client/c/support.h"
#include "dynmesh/files.h"

namespace dynmesh::c {
namespace {

absl::StatusOr<PartChoice> ChoiceOf(const dynmesh_choice* given) {
  dynmesh_choice choice = DefaultChoice();
  if (auto status = ReadStructure(given, &choice); !status.ok()) return status;
  PartChoice result;
  result.inside = choice.inside != 0;
  if (auto s = ReadIds(choice.polygons, "polygons", &result.polygons); !s.ok()) return s;
  if (auto s = ReadIds(choice.without, "without", &result.without); !s.ok()) return s;
  if (auto s = ReadIds(choice.open, "open", &result.open); !s.ok()) return s;
  return result;
}

absl::Status NewPart(const dynmesh_mesh& mesh, const dynmesh_choice* choice, dynmesh_part** part) {
  auto asked = ChoiceOf(choice);
  if (!asked.ok()) return asked.status();
  *part = new dynmesh_part{*asked, MeshPart(mesh.slots, *asked)};
  return absl::OkStatus();
}

absl::Status Update(dynmesh_part* part, const dynmesh_mesh& mesh) {
  if (part->part.revision() == mesh.slots.revision()) return absl::OkStatus();
  if (mesh.has_diff && part->part.revision() == mesh.diff.from_revision) {
    const MeshDiff* const diff = &mesh.diff;
    return part->part.Update(mesh.slots, {&diff, 1});
  }
  part->part = MeshPart(mesh.slots, part->choice);
  return absl::OkStatus();
}

absl::StatusOr<dynmesh_column> PartArrayOf(const MeshPart& part, int which) {
  const auto d = static_cast<std::size_t>(part.dimension());
  switch (which) {
    case DYNMESH_PART_POINTS:
      return ColumnOf(part.points().span(), d);
    case DYNMESH_PART_VERTEX_SLOTS:
      return ColumnOf(part.vertex_slots().span());
    case DYNMESH_PART_CELLS:
      return ColumnOf(part.cells().span(), d + 1);
    case DYNMESH_PART_CELL_SLOTS:
      return ColumnOf(part.cell_slots().span());
    case DYNMESH_PART_REGIONS:
      return ColumnOf(part.cell_regions().span());
    case DYNMESH_PART_FACETS:
      return ColumnOf(part.facets().span(), d);
    case DYNMESH_PART_FACET_OWNERS:
      return ColumnOf(part.facet_owners().span());
    case DYNMESH_PART_FACET_CELLS:
      return ColumnOf(part.facet_cells().span(), 2);
    default:
      return absl::InvalidArgumentError("there is no array " + std::to_string(which) +
                                        " of a part");
  }
}

absl::Status Read(const char* path, int flags, dynmesh_input** input) {
  InputChoices choices;
  choices.merge_coplanar = (flags & DYNMESH_MERGE_COPLANAR) != 0;
  choices.polygons = (flags & DYNMESH_MAP_POLYGONS) != 0;
  choices.refine = (flags & DYNMESH_REFINE) != 0;
  choices.keep_facets = (flags & DYNMESH_KEEP_FACETS) != 0;
  const auto read = ReadInput(path, choices);
  if (!read.ok()) return read.status();
  *input = new dynmesh_input{read->options, {AddAll(read->features)}};
  return absl::OkStatus();
}

absl::Status Write(const dynmesh_mesh& mesh, const dynmesh_part* part, const char* path,
                   int flags) {
  OutputChoices choices;
  if ((flags & DYNMESH_ORDER_2) != 0) choices.order = 2;
  choices.from_zero = (flags & DYNMESH_FROM_ZERO) != 0;
  choices.binary = (flags & DYNMESH_BINARY) != 0;
  choices.input_markers = (flags & DYNMESH_INPUT_MARKERS) != 0;
  choices.part = part != nullptr;
  const MeshOptions& options = mesh.mesher->options();
  if (part == nullptr) return WriteMesh(mesh.slots.ToMesh(), options, path, choices);
  const auto whole = part->part.ToMesh(mesh.slots);
  return whole.ok() ? WriteMesh(*whole, options, path, choices) : whole.status();
}

}  // namespace
}  // namespace dynmesh::c

extern "C" {

int dynmesh_part_new(const dynmesh_mesh* mesh, const dynmesh_choice* choice, dynmesh_part** part,
                     dynmesh_error* error) {
  *part = nullptr;
  return dynmesh::c::Guarded(error, [&] { return dynmesh::c::NewPart(*mesh, choice, part); });
}

void dynmesh_part_free(dynmesh_part* part) { delete part; }

int dynmesh_part_update(dynmesh_part* part, const dynmesh_mesh* mesh, dynmesh_error* error) {
  return dynmesh::c::Guarded(error, [&] { return dynmesh::c::Update(part, *mesh); });
}

int dynmesh_part_array(const dynmesh_part* part, int which, dynmesh_column* column,
                       dynmesh_error* error) {
  return dynmesh::c::Guarded(error, [&]() -> absl::Status {
    const auto array = dynmesh::c::PartArrayOf(part->part, which);
    if (array.ok()) *column = *array;
    return array.status();
  });
}

int dynmesh_read(const char* path, int flags, dynmesh_input** input, dynmesh_error* error) {
  *input = nullptr;
  return dynmesh::c::Guarded(error, [&] { return dynmesh::c::Read(path, flags, input); });
}

void dynmesh_input_free(dynmesh_input* input) { delete input; }

void dynmesh_input_fill_options(const dynmesh_input* input, dynmesh_options* options, size_t size) {
  dynmesh::c::Fill(dynmesh::c::OptionsFor(input->options), options, size);
}

const dynmesh_batch* dynmesh_input_batch(const dynmesh_input* input) { return &input->batch; }

int dynmesh_write(const dynmesh_mesh* mesh, const dynmesh_part* part, const char* path, int flags,
                  dynmesh_error* error) {
  return dynmesh::c::Guarded(error, [&] { return dynmesh::c::Write(*mesh, part, path, flags); });
}

}  // extern "C"
