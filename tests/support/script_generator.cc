// Random batches of edits of a distribution (workload.h).
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/io/script/edit_script.h"
#include "tests/support/workload.h"

namespace dynmesh::test {

ScriptGenerator::ScriptGenerator(Distribution d, int n, std::uint64_t seed)
    : n_(n), dimension_(DimensionOf(d)), random_(seed), pool_(MakeFeatures(d, n, seed)) {}

Feature ScriptGenerator::FreshPoint() {
  const double x = random_.Unit(), y = random_.Unit();
  return Feature::Point(next_id_++, x, y, dimension_ == 3 ? random_.Unit() : 0);
}

Edit ScriptGenerator::RandomEdit(const std::vector<Feature>& present, EditBatch& batch) {
  const auto is_present = [&](FeatureId id) {
    return std::any_of(present.begin(), present.end(),
                       [&](const Feature& f) { return f.id == id; });
  };
  const auto in_batch = [&](FeatureId id) {
    return std::any_of(batch.begin(), batch.end(),
                       [&](const Edit& e) { return e.feature.id == id; });
  };
  const bool few = static_cast<int>(present.size()) < n_;
  const int dice = random_.Below(10);
  if (dice < (few ? 5 : 3)) {
    // Something of the distribution that is not there; a segment brings its ends.
    for (int tries = 0; tries < 20; ++tries) {
      const Feature& f =
          pool_[static_cast<std::size_t>(random_.Below(static_cast<int>(pool_.size())))];
      if (is_present(f.id) || in_batch(f.id)) continue;
      for (const FeatureId point : PointsOf(f)) {
        if (is_present(point) || in_batch(point)) continue;
        const auto it = std::find_if(pool_.begin(), pool_.end(),
                                     [&](const Feature& g) { return g.id == point; });
        batch.push_back(Edit::Add(*it));
      }
      return Edit::Add(f);
    }
  }
  if (dice < 5 || present.empty()) return Edit::Add(FreshPoint());
  const Feature& f =
      present[static_cast<std::size_t>(random_.Below(static_cast<int>(present.size())))];
  if (dice < 7 && f.kind == FeatureKind::kPoint) {
    const double step = std::ldexp(1.0, -random_.Below(20));
    Feature moved = f;
    for (int k = 0; k < dimension_; ++k) {
      moved.position[static_cast<std::size_t>(k)] += step * (random_.Unit() - 0.5);
    }
    return {Edit::Action::kMove, moved};
  }
  if (dice < 8 && f.kind == FeatureKind::kSize) {
    Feature other = f;
    other.sizing.target *= random_.OneIn(2) ? 0.7 : 1.6;
    if (random_.OneIn(2)) other.position[0] *= 0.97;
    if (Path& path = other.sizing.path; !path.empty()) {
      const auto at = static_cast<std::size_t>(random_.Below(static_cast<int>(path.size())));
      if (random_.OneIn(3)) std::reverse(path.begin(), path.end());
      if (random_.OneIn(2)) path[at][1] *= 0.95;
      if (random_.OneIn(3)) other.sizing.radius *= random_.OneIn(2) ? 0.5 : 1.5;
    }
    return Edit::Set(other);
  }
  if (dice < 8 && f.kind == FeatureKind::kPolygon) {
    // Other rings of the pool, or its own from another corner.
    const Feature& g = pool_[pool_.size() - 1 - static_cast<std::size_t>(random_.Below(n_))];
    Feature other = f;
    if (g.kind == FeatureKind::kPolygon) other.rings = g.rings;
    std::rotate(other.rings[0].begin(), other.rings[0].begin() + 1, other.rings[0].end());
    return Edit::Set(other);
  }
  for (const Feature& g : present) {
    if (g.kind == FeatureKind::kPoint || f.kind != FeatureKind::kPoint || in_batch(g.id)) continue;
    const std::vector<FeatureId> points = PointsOf(g);
    if (std::binary_search(points.begin(), points.end(), f.id)) {
      batch.push_back(Edit::Remove(g.id));
    }
  }
  return Edit::Remove(f.id);
}

EditBatch ScriptGenerator::Next(const std::vector<Feature>& present) {
  EditBatch batch;
  if (present.empty() && !random_.OneIn(3)) {
    return AddAll(pool_);
  }
  if (random_.OneIn(60)) {  // everything goes, points last
    for (const bool points : {false, true}) {
      for (const Feature& f : present) {
        if ((f.kind == FeatureKind::kPoint) == points) batch.push_back(Edit::Remove(f.id));
      }
    }
    return batch;
  }
  const int count = random_.OneIn(5) ? 2 + random_.Below(5) : 1;
  for (int i = 0; i < count; ++i) {
    const Edit edit = RandomEdit(present, batch);
    const bool again = std::any_of(batch.begin(), batch.end(),
                                   [&](const Edit& e) { return e.feature.id == edit.feature.id; });
    if (!again) batch.push_back(edit);
  }
  return batch;
}

std::string ToScript(const MeshOptions& options, const std::vector<EditBatch>& batches) {
  std::string text = io::FormatMeshLine(options) + "\n";
  for (const EditBatch& batch : batches) {
    for (const Edit& edit : batch) text += io::FormatEdit(edit, options.dimension) + "\n";
    text += "commit\n";
  }
  return text;
}

}  // namespace dynmesh::test
