// The cost of transferring fields across an edit, beside the edit: medians over random moves of
// points.
//
//   dynmesh_transfer_tables [DIMENSION [POINTS [EDITS]]]
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/slot_mesh.h"
#include "dynmesh/transfer.h"

namespace dynmesh {
namespace {

double Now() {
  return std::chrono::duration<double, std::micro>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

struct Series {
  const char* name;
  std::vector<double> values;
  double Median() {
    std::nth_element(values.begin(),
                     values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    return values[values.size() / 2];
  }
};

int Run(int dimension, int points, int edits) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> draw(0, 1);
  MeshOptions options;
  options.dimension = dimension;
  options.quality = DefaultQuality(dimension);
  auto mesh = std::move(DynamicMesh::Create(options)).value();
  EditBatch batch;
  for (int i = 1; i <= points; ++i) {
    const double x = draw(random), y = draw(random), z = draw(random);
    batch.push_back(Edit::Add(Feature::Point(static_cast<FeatureId>(i), x, y, z)));
  }
  if (!mesh->Apply(batch).ok()) return 1;
  double start = Now();
  const Mesh snapshot = mesh->Snapshot();
  const double snapshot_ms = (Now() - start) / 1000;
  start = Now();
  SlotMesh slots = SlotMesh::FromMesh(snapshot).value();
  std::printf("%d dimensions, %zu vertices, %zu simplices; snapshot %.0f ms, slots %.0f ms\n",
              dimension, slots.vertex_count(), slots.simplex_count(), snapshot_ms,
              (Now() - start) / 1000);

  struct Field {
    Series time;
    FieldOptions options;
    std::vector<double> values;
  };
  std::vector<Field> fields = {{{"P0", {}}, {.kind = FieldKind::kP0}, {}},
                               {{"P0 linear", {}}, {.kind = FieldKind::kP0Linear}, {}},
                               {{"P1, 0 rings", {}}, {.kind = FieldKind::kP1, .rings = 0}, {}},
                               {{"P1", {}}, {.kind = FieldKind::kP1}, {}},
                               {{"P1, bounded", {}}, {.kind = FieldKind::kP1, .bounded = true}, {}},
                               {{"DG1", {}}, {.kind = FieldKind::kDG1}, {}}};
  const auto corners = static_cast<std::size_t>(dimension + 1);
  for (Field& field : fields) {  // anything that is not linear
    const bool at_vertices = field.options.kind == FieldKind::kP1;
    const std::size_t width = field.options.kind == FieldKind::kDG1 ? corners : 1;
    field.values.resize((at_vertices ? slots.ids().size() : slots.regions().size()) * width);
    for (double& value : field.values) value = draw(random);
  }
  Series edit{"edit", {}}, replica{"replica", {}}, overlay{"overlay", {}}, removed{"removed", {}};
  for (int e = 0; e < edits; ++e) {
    const auto id = 1 + random() % static_cast<FeatureId>(points);
    start = Now();
    const auto diff = mesh->Apply({Edit::Move(id, draw(random), draw(random), draw(random))});
    edit.values.push_back(Now() - start);
    if (!diff.ok()) continue;
    start = Now();
    if (!slots.Apply(*diff).ok()) return 1;
    replica.values.push_back(Now() - start);
    removed.values.push_back(static_cast<double>(diff->removed_simplex_count()));
    start = Now();
    auto transfer = Transfer::Make(slots);
    overlay.values.push_back(Now() - start);
    for (Field& field : fields) {
      const std::size_t rows = field.options.kind == FieldKind::kP1 ? slots.ids().size()
                               : field.options.kind == FieldKind::kDG1
                                   ? slots.regions().size() * corners
                                   : slots.regions().size();
      field.values.resize(rows, 1);
      start = Now();
      if (!transfer->Carry(field.options, field.values).ok()) return 1;
      field.time.values.push_back(Now() - start);
    }
  }
  for (Series* s : {&edit, &replica, &removed, &overlay}) {
    std::printf("  %-14s %9.1f\n", s->name, s->Median());
  }
  const double base = edit.Median();
  for (Field& field : fields) {
    const double carry = field.time.Median();
    std::printf("  %-14s %9.1f us after the overlay; together %.2f edits\n", field.time.name, carry,
                (overlay.Median() + carry) / base);
  }
  return 0;
}

}  // namespace
}  // namespace dynmesh

int main(int argc, char** argv) {
  const int dimension = argc > 1 ? std::atoi(argv[1]) : 2;
  const int points = argc > 2 ? std::atoi(argv[2]) : dimension == 2 ? 66'000 : 65'000;
  return dynmesh::Run(dimension, points, argc > 3 ? std::atoi(argv[3]) : 1000);
}
