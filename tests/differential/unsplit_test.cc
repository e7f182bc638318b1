// Segments and polygons that stay whole (Feature::unsplit): after every revision of random scripts
// in which they come, go, move and change their marks, the dynamic mesh is, in mesh and complete
// trace, what its features make from scratch, and the verifier of mesh files finds no fault: each
// of them is one edge, no vertex is in its circle, and what is over rho is so because of one of
// them.
//
// DYNMESH_NIGHTLY=1 runs the long setting.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "tests/differential/differential.h"
#include "tests/support/judged.h"
#include "tests/support/nightly.h"

namespace dynmesh::test::unsplit_test {
namespace {

std::string Judge(const DynamicMesh& mesh) {
  return Judged(mesh.Snapshot(), mesh.options().quality, mesh.Features());
}

// Closed curves with points at a spacing, as polygons or as segments, with single points, segments
// and sizes around them.
class UnsplitScript {
 public:
  explicit UnsplitScript(std::uint64_t seed) : random_(seed) {}

  EditBatch Next(const std::vector<Feature>& present) {
    EditBatch batch;
    const int edits = random_.OneIn(5) ? 3 : 1;
    for (int i = 0; i < edits; ++i) Add(present, batch);
    return batch;
  }

 private:
  static constexpr FeatureId kStride = 100;  // ids of one curve

  double Place() { return random_.OneIn(2) ? random_.Unit() : random_.Below(17) / 16.0; }

  void Add(const std::vector<Feature>& present, EditBatch& batch) {
    const auto of_kind = [&](FeatureKind kind) {
      std::vector<Feature> found;
      for (const Feature& f : present) {
        if (f.kind == kind) found.push_back(f);
      }
      return found;
    };
    const auto pick = [&](const std::vector<Feature>& from) {
      return from[static_cast<std::size_t>(random_.Below(static_cast<int>(from.size())))];
    };
    const auto segments = of_kind(FeatureKind::kSegment), points = of_kind(FeatureKind::kPoint),
               polygons = of_kind(FeatureKind::kPolygon), sizes = of_kind(FeatureKind::kSize);
    switch (random_.Below(10)) {
      case 0:
      case 1:
        AddCurve(batch);
        break;
      case 2:  // a chain of a few edges, or one
        AddChain(batch);
        break;
      case 3:
        if (!points.empty()) {
          const Feature p = pick(points);
          const double by = random_.OneIn(2) ? 0.02 : 0.3;
          batch.push_back(Edit::Move(p.id, std::clamp(p.position[0] + by * Signed(), 0.0, 1.0),
                                     std::clamp(p.position[1] + by * Signed(), 0.0, 1.0)));
        }
        break;
      case 4:  // the mark
      case 5: {
        const auto& all = random_.OneIn(2) && !polygons.empty() ? polygons : segments;
        if (all.empty()) break;
        Feature f = pick(all);
        f.unsplit = !f.unsplit;
        batch.push_back(Edit::Set(f));
        break;
      }
      case 6:
        if (random_.OneIn(2) && !sizes.empty()) {
          batch.push_back(Edit::Remove(pick(sizes).id));
        } else {
          batch.push_back(
              Edit::Add(Feature::SizeDisc(next_++, Place(), Place(), 0.2 * random_.Unit(), 0.05)));
        }
        break;
      case 7:  // a curve or chain, all of it
        if (!points.empty()) {
          const FeatureId first = pick(points).id / kStride * kStride;
          std::vector<FeatureId> ids;
          for (const Feature& f : present) {
            if (f.id / kStride * kStride == first) ids.push_back(f.id);
          }
          std::ranges::sort(ids, std::greater());
          for (const FeatureId id : ids) batch.push_back(Edit::Remove(id));
        }
        break;
      default:
        batch.push_back(Edit::Add(Feature::Point(next_++ * kStride, Place(), Place())));
        break;
    }
  }

  double Signed() { return 2 * random_.Unit() - 1; }

  void AddCurve(EditBatch& batch) {
    const FeatureId first = next_++ * kStride;
    const int n = 3 + random_.Below(random_.OneIn(2) ? 4 : 30);
    const double x = Place(), y = Place(), r = 0.02 + 0.3 * random_.Unit() * random_.Unit(),
                 turned = random_.OneIn(2) ? 0 : random_.Unit();
    Rings rings(1);
    for (int i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * (i + turned) / n;
      const FeatureId id = first + static_cast<FeatureId>(i);
      batch.push_back(Edit::Add(Feature::Point(id, std::clamp(x + r * std::cos(angle), 0.0, 1.0),
                                               std::clamp(y + r * std::sin(angle), 0.0, 1.0))));
      rings[0].push_back(id);
    }
    const bool unsplit = !random_.OneIn(4);
    if (random_.OneIn(2)) {
      Feature polygon = Feature::Polygon(first + 50, rings);
      polygon.unsplit = unsplit;
      batch.push_back(Edit::Add(polygon));
      if (!random_.OneIn(3)) return;
    }
    for (int i = 0; i < n; ++i) {
      Feature s = Feature::Segment(first + 60 + static_cast<FeatureId>(i),
                                   first + static_cast<FeatureId>(i),
                                   first + static_cast<FeatureId>((i + 1) % n));
      s.unsplit = unsplit;
      batch.push_back(Edit::Add(s));
    }
  }

  void AddChain(EditBatch& batch) {
    const FeatureId first = next_++ * kStride;
    const int n = 1 + random_.Below(4);
    double x = Place(), y = Place();
    const double step = 0.02 + 0.2 * random_.Unit();
    for (int i = 0; i <= n; ++i) {
      batch.push_back(Edit::Add(Feature::Point(first + static_cast<FeatureId>(i),
                                               std::clamp(x, 0.0, 1.0), std::clamp(y, 0.0, 1.0))));
      x += step * Signed(), y += step * Signed();
    }
    for (int i = 0; i < n; ++i) {
      Feature s = Feature::Segment(first + 50 + static_cast<FeatureId>(i),
                                   first + static_cast<FeatureId>(i),
                                   first + static_cast<FeatureId>(i + 1));
      s.unsplit = random_.OneIn(2);
      batch.push_back(Edit::Add(s));
    }
  }

  Random random_;
  FeatureId next_ = 1;
};

constexpr double kQualities[] = {2.0, kDefaultQuality2D, 1.2, 1.0};

class UnsplitHistory : public ::testing::TestWithParam<int> {};

TEST_P(UnsplitHistory, DynamicIsFromScratchAndGoodAfterEveryRevision) {
  MeshOptions options = DefaultsIn<2>();
  options.quality = kQualities[GetParam()];
  const int scripts = IsNightly() ? 300 : 4;
  int revisions = 0;
  for (int k = 0; k < scripts; ++k) {
    const auto seed = static_cast<std::uint64_t>((IsNightly() ? 77'000 : 1'000) + k);
    SCOPED_TRACE("seed " + std::to_string(seed));
    RunPlan plan;
    plan.revisions = IsNightly() ? 60 : 25;
    plan.every_judged = 3;
    plan.judge = &Judge;
    const RunReport run = RunScriptOf<2>(UnsplitScript(seed), options, plan);
    if (run.difference.found) {
      FAIL() << run.difference.what << "\nshrunk script:\n"
             << ToScript(options, Shrink(run.script, options, plan));
    }
    revisions += run.revisions;
  }
  EXPECT_GE(revisions, scripts * 20) << "too many proposals were refused";
}

INSTANTIATE_TEST_SUITE_P(All, UnsplitHistory, ::testing::Range(0, 4));

// --- What it is good for ------------------------------------------------------------------------

std::vector<Feature> Circle(FeatureId first, double x, double y, double r, int n, bool unsplit) {
  std::vector<Feature> features;
  Rings rings(1);
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * i / n;
    const FeatureId id = first + static_cast<FeatureId>(i);
    features.push_back(Feature::Point(id, x + r * std::cos(angle), y + r * std::sin(angle)));
    rings[0].push_back(id);
  }
  features.push_back(Feature::Polygon(first + static_cast<FeatureId>(n), rings));
  features.back().unsplit = unsplit;
  return features;
}

MeshOptions Unit() {
  MeshOptions options = DefaultsIn<2>();
  options.box = {{0, 0, 0}, {1, 1, 0}};
  return options;
}

// Two circles with a narrow band between them: split, the band's circles would get vertices.
TEST(Unsplit, CirclesOfARotorKeepTheirPoints) {
  std::vector<Feature> features = Circle(1, 0.5, 0.5, 0.3, 120, true);
  for (Feature& f : Circle(1'001, 0.5, 0.5, 0.32, 120, true)) features.push_back(f);
  features.push_back(Feature::SizeDisc(5'000, 0.5, 0.5, 0.35, 0.005));
  const auto mesh = BuildMesh(features, Unit());
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ(Judged(*mesh, Unit().quality, features), "");
  std::size_t on_circles = 0;
  for (std::size_t s = 0; s < mesh->subsegments.size(); ++s) {
    on_circles += mesh->subsegments.owners[s] != kBoxFeature;
  }
  EXPECT_EQ(on_circles, 240u);
  std::vector<Feature> split = features;
  for (Feature& f : split) f.unsplit = false;
  const auto beside = BuildMesh(split, Unit());
  ASSERT_TRUE(beside.ok());
  EXPECT_GT(beside->subsegments.size(), mesh->subsegments.size());
}

// The two sides of a circle, meshed apart: equal on it.
TEST(Unsplit, BothSidesMeshedApartMeetOnTheCurve) {
  const std::vector<Feature> circle = Circle(1, 0.5, 0.5, 0.3, 60, true);
  std::vector<Feature> inside = circle, outside = circle;
  inside.push_back(Feature::Point(2'000, 0.52, 0.47));
  inside.push_back(Feature::SizeDisc(2'001, 0.5, 0.5, 0.1, 0.01));
  outside.push_back(Feature::Point(2'000, 0.9, 0.83));
  outside.push_back(Feature::Point(2'001, 0.91, 0.83));
  const auto on_curve = [&](const std::vector<Feature>& features) {
    const auto mesh = BuildMesh(features, Unit());
    EXPECT_TRUE(mesh.ok()) << mesh.status();
    std::vector<std::pair<VertexId, VertexId>> edges;
    for (std::size_t s = 0; s < mesh->subsegments.size(); ++s) {
      if (mesh->subsegments.owners[s] != 61) continue;
      edges.emplace_back(
          std::minmax(mesh->subsegments.ends[2 * s], mesh->subsegments.ends[2 * s + 1]));
    }
    std::ranges::sort(edges);
    return edges;
  };
  const auto a = on_curve(inside), b = on_curve(outside);
  EXPECT_EQ(a.size(), 60u);
  EXPECT_EQ(a, b);
}

// --- Locality -----------------------------------------------------------------------------------

// A point beside a border of n unsplit edges changes as much whatever n is.
TEST(UnsplitLocality, AnEditBesideALongBorderIsLocal) {
  std::size_t most_changed[2] = {0, 0};
  std::uint64_t most_operations[2] = {0, 0};
  int at = 0;
  for (const int n : {64, 1024}) {
    MeshOptions options = DefaultsIn<2>();
    options.box = {{0, 0, 0}, {1, 1, 0}};
    std::vector<Feature> features;
    const double h = 1.0 / n;
    for (int i = 0; i <= n; ++i) {
      features.push_back(Feature::Point(static_cast<FeatureId>(i + 1), i * h, 0.5));
    }
    for (int i = 0; i < n; ++i) {
      const auto id = static_cast<FeatureId>(i);
      features.push_back(Feature::Segment(10'000 + id, id + 1, id + 2).Unsplit());
    }
    LiveMesh<2> mesh(options, AlwaysPropagate());
    ASSERT_TRUE(mesh.Apply(AddAll(features), ApplyOptions{}).ok());
    for (int i = 0; i < 20; ++i) {
      const double x = 0.3 + 0.02 * i * 0.97, y = 0.5 + h * (0.51 + 0.2 * (i % 5));
      for (const Edit& edit : {Edit::Add(Feature::Point(20'000, x, y)), Edit::Remove(20'000)}) {
        const auto diff = mesh.Apply({edit}, ApplyOptions{});
        ASSERT_TRUE(diff.ok()) << diff.status();
        most_changed[at] =
            std::max(most_changed[at], diff->added_vertices.size() + diff->removed_vertices.size());
        most_operations[at] = std::max(most_operations[at], diff->work.executed);
      }
    }
    ++at;
  }
  EXPECT_LE(most_changed[1], 2 * most_changed[0] + 4);
  EXPECT_LE(most_operations[1], 2 * most_operations[0] + 16);
  EXPECT_LE(most_changed[1], 80u);
}

}  // namespace
}  // namespace dynmesh::test::unsplit_test
