// The mesh options of a script, and the box of its positions.
#include <algorithm>
#include <array>
#include <limits>

#include "core/base/feature_kinds.h"
#include "core/base/size_shapes.h"
#include "core/io/script/edit_script.h"

namespace dynmesh::io {
namespace {

// Grows a box point by point.
class BoxBuilder {
 public:
  explicit BoxBuilder(int dimension) : dimension_(static_cast<std::size_t>(dimension)) {}
  void Add(const std::array<double, 3>& p) {
    for (std::size_t i = 0; i < dimension_; ++i) {
      lo_[i] = std::min(lo_[i], p[i]);
      hi_[i] = std::max(hi_[i], p[i]);
    }
  }
  Box Get() const {
    Box box;
    if (lo_[0] > hi_[0]) return box;
    for (std::size_t i = 0; i < dimension_; ++i) {
      box.lo[i] = lo_[i];
      box.hi[i] = hi_[i];
    }
    return box;
  }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::size_t dimension_;
  double lo_[3] = {kInfinity, kInfinity, kInfinity};
  double hi_[3] = {-kInfinity, -kInfinity, -kInfinity};
};

// Adds the positions of the feature that must lie in the mesh's box.
void AddPositions(const Feature& f, BoxBuilder& builder) {
  if (IsPoint(f)) builder.Add(f.position);
  if (!Is<ASize>(f, Not<APoint, ASegment, APolygon>)) return;
  const SizeShapeUse* const use = FindUse(f.sizing.shape);
  if (use == nullptr || !use->in_box) return;
  if (use->position) builder.Add(f.position);
  if (!use->path) return;
  for (const auto& vertex : f.sizing.path) builder.Add(vertex);
}

}  // namespace

MeshOptions EditScript::Options() const {
  MeshOptions options;
  options.dimension = dimension;
  if (kind) options.kind = *kind;
  options.quality = quality.value_or(DefaultQuality(dimension));
  if (criterion) options.criterion = *criterion;
  if (max_edge) options.max_edge = *max_edge;
  options.min_dihedral = min_dihedral.value_or(DefaultMinDihedral(dimension, options.kind));
  if (box) {
    options.box = *box;
    return options;
  }
  BoxBuilder builder(dimension);
  for (const ScriptBatch& batch : batches) {
    for (const Edit& edit : batch.edits) {
      if (edit.action != Edit::Action::kRemove) AddPositions(edit.feature, builder);
    }
  }
  options.box = builder.Get();
  return options;
}

Box BoundingBox(const std::vector<Feature>& features, int dimension) {
  BoxBuilder builder(dimension);
  for (const Feature& f : features) AddPositions(f, builder);
  return builder.Get();
}

}  // namespace dynmesh::io
