// A dynamic mesh, its replica in slots, and fields on it that every edit transfers.
#ifndef DYNMESH_TESTS_CORE_TRANSFER_FIELD_LAB_H_
#define DYNMESH_TESTS_CORE_TRANSFER_FIELD_LAB_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iostream>
#include <memory>
#include <random>
#include <vector>

#include "core/transfer/compensated_sum.h"
#include "core/transfer/simplex.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/slot_mesh.h"
#include "dynmesh/transfer.h"
#include "gtest/gtest.h"

namespace dynmesh::testing {

using FieldFunction = std::function<double(const double* place)>;

inline std::size_t Index(Slot slot) { return static_cast<std::size_t>(slot); }

inline double MeasureOf(const SlotMesh& mesh, std::size_t cell) {
  const auto d = static_cast<std::size_t>(mesh.dimension());
  const auto measure = [&]<std::size_t D>() {
    transfer::Corners<D> corners;
    for (std::size_t k = 0; k <= D; ++k) {
      std::copy_n(&mesh.points()[Index(mesh.cells()[cell * (D + 1) + k]) * D], D,
                  corners[k].begin());
    }
    return transfer::Measure<D>(corners);
  };
  return d == 2 ? measure.template operator()<2>() : measure.template operator()<3>();
}

inline bool IsLive(const SlotMesh& mesh, std::size_t cell) {
  return mesh.cells()[cell * static_cast<std::size_t>(mesh.dimension() + 1)] != kNoSlot;
}

// Is there a value at each vertex, or at each corner of a simplex?
inline bool IsAtVertices(FieldKind kind) {
  return kind == FieldKind::kP1 || kind == FieldKind::kDual;
}
inline bool IsAtCorners(FieldKind kind) {
  return kind == FieldKind::kDG1 || kind == FieldKind::kDualCorners;
}

inline std::size_t RowCount(const SlotMesh& mesh, FieldKind kind) {
  if (IsAtVertices(kind)) return mesh.ids().size();
  const std::size_t cells = mesh.regions().size();
  return IsAtCorners(kind) ? cells * static_cast<std::size_t>(mesh.dimension() + 1) : cells;
}

// The mean of a field over a cell.
inline double MeanOf(const SlotMesh& mesh, FieldKind kind, const std::vector<double>& u,
                     std::size_t cell) {
  const auto corners = static_cast<std::size_t>(mesh.dimension() + 1);
  if (!IsAtVertices(kind) && !IsAtCorners(kind)) return u[cell];
  double sum = 0;
  for (std::size_t k = 0; k < corners; ++k) {
    sum += IsAtCorners(kind) ? u[cell * corners + k] : u[Index(mesh.cells()[cell * corners + k])];
  }
  return sum / static_cast<double>(corners);
}

struct Mass {
  double sum = 0, size = 0;  // of the values, and of their sizes
};

inline Mass MassOf(const SlotMesh& mesh, FieldKind kind, const std::vector<double>& u,
                   const std::function<bool(std::size_t)>& counts = nullptr) {
  transfer::Sum sum, size;
  for (std::size_t c = 0; c < mesh.regions().size(); ++c) {
    if (!IsLive(mesh, c) || (counts && !counts(c))) continue;
    const double mass = MeasureOf(mesh, c) * MeanOf(mesh, kind, u, c);
    sum.Add(mass), size.Add(std::abs(mass));
  }
  return {sum.value(), size.value()};
}

// The field of a function: its values at places, of means at centroids (exact if it is linear).
inline std::vector<double> Sample(const SlotMesh& mesh, FieldKind kind, const FieldFunction& f) {
  const auto d = static_cast<std::size_t>(mesh.dimension());
  std::vector<double> u(RowCount(mesh, kind), 0);
  if (IsAtVertices(kind)) {
    for (std::size_t v = 0; v < u.size(); ++v) u[v] = f(&mesh.points()[v * d]);
    return u;
  }
  for (std::size_t c = 0; c < mesh.regions().size(); ++c) {
    if (!IsLive(mesh, c)) continue;
    std::vector<double> centroid(d, 0);
    for (std::size_t k = 0; k <= d; ++k) {
      const double* place = &mesh.points()[Index(mesh.cells()[c * (d + 1) + k]) * d];
      if (IsAtCorners(kind)) u[c * (d + 1) + k] = f(place);
      for (std::size_t x = 0; x < d; ++x) centroid[x] += place[x] / static_cast<double>(d + 1);
    }
    if (!IsAtCorners(kind)) u[c] = f(centroid.data());
  }
  return u;
}

// Greatest difference to a function at the places where Sample takes it.
inline double GreatestError(const SlotMesh& mesh, FieldKind kind, const std::vector<double>& u,
                            const FieldFunction& f) {
  const std::vector<double> want = Sample(mesh, kind, f);
  const auto d = static_cast<std::size_t>(mesh.dimension());
  double worst = 0;
  for (std::size_t i = 0; i < u.size(); ++i) {
    const bool is_live =
        IsAtVertices(kind) ? mesh.ids()[i] != 0 : IsLive(mesh, IsAtCorners(kind) ? i / (d + 1) : i);
    if (is_live) worst = std::max(worst, std::abs(u[i] - want[i]));
  }
  return worst;
}

class FieldLab {
 public:
  struct Field {
    FieldOptions options;
    std::vector<double> values;
  };

  FieldLab(const MeshOptions& options, const EditBatch& first)
      : mesh_(std::move(DynamicMesh::Create(options)).value()) {
    EXPECT_TRUE(mesh_->Apply(first).ok());
    slots_ = SlotMesh::FromMesh(mesh_->Snapshot()).value();
  }

  std::size_t Add(const FieldOptions& options, const FieldFunction& f) {
    fields_.push_back({options, Sample(slots_, options.kind, f)});
    return fields_.size() - 1;
  }

  // False if the mesh refused the batch.
  bool Edit(const EditBatch& batch) {
    auto diff = mesh_->Apply(batch);
    if (!diff.ok()) return false;
    const absl::Status applied = slots_.Apply(*diff);
    EXPECT_TRUE(applied.ok()) << applied;
    auto transfer = Transfer::Make(slots_);
    EXPECT_TRUE(transfer.ok()) << transfer.status();
    for (Field& field : fields_) {
      field.values.resize(RowCount(slots_, field.options.kind), 0);
      auto flows = transfer->Carry(field.options, field.values);
      EXPECT_TRUE(flows.ok()) << flows.status();
    }
    return true;
  }

  Mass MassOfField(std::size_t i) const {
    return MassOf(slots_, fields_[i].options.kind, fields_[i].values);
  }
  DynamicMesh& mesh() { return *mesh_; }
  const SlotMesh& slots() const { return slots_; }
  std::vector<Field>& fields() { return fields_; }

 private:
  std::unique_ptr<DynamicMesh> mesh_;
  SlotMesh slots_;
  std::vector<Field> fields_;
};

inline MeshOptions UnitBox(int dimension) {
  MeshOptions options;
  options.dimension = dimension;
  return options;
}

}  // namespace dynmesh::testing

#endif  // DYNMESH_TESTS_CORE_TRANSFER_FIELD_LAB_H_
