// A real map under random edits: parts of the coast are removed and added again, points move,
// storms come and go. After every revision mesh and complete trace equal those of a run from
// scratch.
//
// DYNMESH_NIGHTLY=1 runs 1,000 revisions, DYNMESH_REVISIONS=N so many; DYNMESH_MAP=FILE.poly
// takes another map.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <iostream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/io/plane/planar_input.h"
#include "core/io/script/edit_script.h"
#include "dynmesh/quality.h"
#include "tests/differential/differential.h"
#include "tests/support/source_path.h"
#include "tests/support/workload.h"

namespace dynmesh::test::map_test {
namespace {

class MapEdits {
 public:
  MapEdits(const std::vector<Feature>& features, const Box& box, std::uint64_t seed)
      : random_(seed), box_(box) {
    for (const Feature& f : features) {
      if (f.kind == FeatureKind::kSegment) segments_.push_back(f);
      if (f.kind == FeatureKind::kPoint) points_[f.id] = f;
      next_id_ = std::max(next_id_, f.id + 1);
    }
  }

  EditBatch Next() {
    const int dice = random_.Below(10);
    const double size = box_.hi[0] - box_.lo[0];
    if (dice < 3 && !gone_.empty()) return ComeBack();
    if (dice < 5) return Go(1 + random_.Below(8));
    if (dice < 7) {
      // A little way: most such moves are legal.
      const Feature& s = AnySegment();
      const Feature& p = points_[s.ends[random_.Below(2)]];
      const Feature& q = points_[s.ends[0] == p.id ? s.ends[1] : s.ends[0]];
      const double step =
          0.3 * std::hypot(p.position[0] - q.position[0], p.position[1] - q.position[1]);
      return {Edit::Move(p.id, p.position[0] + step * (random_.Unit() - 0.5),
                         p.position[1] + step * (random_.Unit() - 0.5))};
    }
    if (dice == 7 && !storms_.empty()) {
      const FeatureId id = storms_.back();
      storms_.pop_back();
      return {Edit::Remove(id)};
    }
    const Feature& at = points_[AnySegment().ends[0]];
    const double radius = size * (0.002 + 0.01 * random_.Unit());
    const double target = radius * (0.1 + 0.4 * random_.Unit());
    if (storms_.size() > 3) {
      return {Edit::Set(Feature::SizeDisc(storms_[random_.Below(3)], at.position[0], at.position[1],
                                          radius, target))};
    }
    storms_.push_back(next_id_++);
    return {Edit::Add(
        Feature::SizeDisc(storms_.back(), at.position[0], at.position[1], radius, target))};
  }

  // A batch that was accepted.
  void Accepted(const EditBatch& batch) {
    for (const Edit& e : batch) {
      if (e.action == Edit::Action::kMove) points_[e.feature.id].position = e.feature.position;
    }
  }

  // Segments that could not come back go to the end of the queue.
  void Refused(const EditBatch& batch) {
    if (batch[0].action != Edit::Action::kAdd) return;
    gone_.insert(gone_.begin(), segments_.end() - static_cast<std::ptrdiff_t>(batch.size()),
                 segments_.end());
    segments_.resize(segments_.size() - batch.size());
  }

 private:
  const Feature& AnySegment() {
    return segments_[static_cast<std::size_t>(random_.Below(static_cast<int>(segments_.size())))];
  }
  EditBatch Go(int count) {
    EditBatch batch;
    auto at = static_cast<std::size_t>(random_.Below(static_cast<int>(segments_.size())));
    for (; count > 0 && segments_.size() > 10; --count) {
      at %= segments_.size();
      gone_.push_back(segments_[at]);
      segments_[at] = segments_.back();
      segments_.pop_back();
      batch.push_back(Edit::Remove(gone_.back().id));
    }
    return batch;
  }
  EditBatch ComeBack() {
    EditBatch batch;
    while (!gone_.empty() && batch.size() < 6) {
      segments_.push_back(gone_.back());
      batch.push_back(Edit::Add(gone_.back()));
      gone_.pop_back();
    }
    return batch;
  }

  Random random_;
  Box box_;
  std::map<FeatureId, Feature> points_;
  std::vector<Feature> segments_, gone_;
  std::vector<FeatureId> storms_;
  FeatureId next_id_ = 1;
};

TEST(Map, IsFromScratchAfterEveryRevision) {
  const char* nightly = std::getenv("DYNMESH_NIGHTLY");
  const char* other = std::getenv("DYNMESH_MAP");
  const char* asked = std::getenv("DYNMESH_REVISIONS");
  const int revisions = asked != nullptr                        ? std::atoi(asked)
                        : nightly != nullptr && *nightly != '0' ? 1000
                                                                : 25;
  const auto map =
      io::ReadPolyFile(other != nullptr ? other : SourcePath("deploy/data/coastline-110m.poly"));
  ASSERT_TRUE(map.ok()) << map.status();
  MeshOptions options;
  options.box = io::BoundingBox(map->features);
  LiveMesh<2> mesh(options, {});
  ASSERT_TRUE(mesh.Apply(AddAll(map->features), ApplyOptions{}).ok());
  const std::uint64_t seed = 110;
  SCOPED_TRACE("seed " + std::to_string(seed));
  MapEdits edits(map->features, options.box, seed);
  int refused = 0;
  for (int revision = 0; revision < revisions; ++revision) {
    const EditBatch batch = edits.Next();
    const auto diff = mesh.Apply(batch, ApplyOptions{});
    if (!diff.ok()) {
      // A moved point may meet its neighbours, a part of the coast may meet moved points.
      ASSERT_TRUE(batch[0].action == Edit::Action::kMove ||
                  batch[0].feature.kind == FeatureKind::kSegment)
          << diff.status();
      edits.Refused(batch);
      ++refused;
      continue;
    }
    edits.Accepted(batch);
    // Long runs compare mesh and complete trace every time, by the slower ways too now and then.
    const bool by_all = revisions <= 100 || revision % 10 == 0;
    const Difference difference = CompareWithScratch(mesh, by_all && revision % 4 < 2, by_all);
    ASSERT_EQ(difference.what, "") << "revision " << revision << ": " << io::FormatEdit(batch[0]);
    if (revision % 100 == 99) std::cout << revision + 1 << " revisions" << std::endl;
  }
  EXPECT_LT(refused, revisions / 4);
  const QualityReport quality = MeasureQuality(mesh.Snapshot(), options);
  EXPECT_EQ(quality.over_rho, quality.exempt);
}

}  // namespace
}  // namespace dynmesh::test::map_test
