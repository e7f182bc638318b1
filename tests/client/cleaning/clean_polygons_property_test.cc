// Random messy polygons: the result is accepted, has the same inside, and is a function of
// coordinates.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <string>
#include <utility>

#include "client/cleaning/clean_input.h"
#include "core/plc/plc.h"
#include "dynmesh/dynamic_mesh.h"
#include "gtest/gtest.h"
#include "tests/client/cleaning/input_script.h"
#include "tests/client/cleaning/is_legal.h"
#include "tests/client/cleaning/messy_polygons.h"

namespace dynmesh::cleaning::clean_polygons_property_test {
namespace {

using Spot = std::array<double, 2>;
using Sides = std::vector<std::pair<Spot, Spot>>;

std::map<FeatureId, Spot> SpotsOf(const std::vector<Feature>& features) {
  std::map<FeatureId, Spot> at;
  for (const Feature& f : features) {
    if (f.kind == FeatureKind::kPoint) at[f.id] = {f.position[0] + 0.0, f.position[1] + 0.0};
  }
  return at;
}

// By polygon, those with a size among them: each side as the rings have it.
std::map<FeatureId, Sides> SidesOf(const std::vector<Feature>& features) {
  const std::map<FeatureId, Spot> at = SpotsOf(features);
  std::map<FeatureId, Sides> sides;
  for (const Feature& f : features) {
    for (const auto& ring : f.rings) {
      for (std::size_t i = 0; i < ring.size(); ++i) {
        sides[f.id].emplace_back(at.at(ring[i]), at.at(ring[(i + 1) % ring.size()]));
      }
    }
  }
  return sides;
}

Sides SegmentsOf(const std::vector<Feature>& features) {
  const std::map<FeatureId, Spot> at = SpotsOf(features);
  Sides segments;
  for (const Feature& f : features) {
    if (f.kind == FeatureKind::kSegment) segments.emplace_back(at.at(f.ends[0]), at.at(f.ends[1]));
  }
  return segments;
}

bool IsInside(const Sides& sides, const Spot& x) {
  bool inside = false;
  for (const auto& [p, q] : sides) {
    if ((p[1] > x[1]) == (q[1] > x[1])) continue;
    inside ^= x[0] < p[0] + (x[1] - p[1]) / (q[1] - p[1]) * (q[0] - p[0]);
  }
  return inside;
}

double DistanceTo(const Sides& sides, const Spot& x) {
  double least = 1e300;
  for (const auto& [p, q] : sides) {
    const double dx = q[0] - p[0], dy = q[1] - p[1], length2 = dx * dx + dy * dy;
    double t = length2 > 0 ? ((x[0] - p[0]) * dx + (x[1] - p[1]) * dy) / length2 : 0;
    t = std::min(1.0, std::max(0.0, t));
    least = std::min(least, std::hypot(x[0] - p[0] - t * dx, x[1] - p[1] - t * dy));
  }
  return least;
}

class CleanMessyPolygons : public ::testing::TestWithParam<double> {
 protected:
  static int Runs() { return std::getenv("DYNMESH_NIGHTLY") != nullptr ? 20000 : 400; }
  static double Tolerance() { return std::max(GetParam(), 4 * plc::CloseLimit(MeshOptions())); }

  static CleanResult Clean(const std::vector<Feature>& input) {
    CleanOptions options;
    options.tolerance = Tolerance();
    const auto result = CleanInput(input, options);
    EXPECT_TRUE(result.ok()) << result.status();
    return result.ok() ? *result : CleanResult();
  }

  // The largest allowed displacement.
  static double Allowed(const CleanResult& result) {
    double allowed = 3 * Tolerance();
    for (const Change& change : result.changes) {  // needles may be wider than the tolerance
      if (change.kind != ChangeKind::kSmallAngle) continue;
      allowed += std::hypot(change.from[0] - change.to[0], change.from[1] - change.to[1]);
    }
    return allowed;
  }

  template <class Check>
  static void ForEachInput(Check check) {
    for (int run = 0; run < Runs(); ++run) {
      const auto seed = static_cast<std::uint64_t>(run) + 1;
      const std::vector<Feature> input = MessyPolygons(seed, Tolerance()).Features();
      check(input, Clean(input), seed);
      if (::testing::Test::HasFailure()) {
        FAIL() << "seed " << seed << ", tolerance " << Tolerance() << "\n" << ScriptOf(input);
      }
    }
  }
};

TEST_P(CleanMessyPolygons, TheCoreAcceptsTheResult) {
  const auto mesh = DynamicMesh::Create(MeshOptions());  // the unit square
  ASSERT_TRUE(mesh.ok());
  std::size_t refused = 0;
  ForEachInput([&](const auto& input, const CleanResult& result, std::uint64_t) {
    refused += (*mesh)->Validate(AddAll(input)).ok() ? 0 : 1;
    const absl::Status status = (*mesh)->Validate(AddAll(result.features));
    EXPECT_TRUE(IsLegal(status, Tolerance())) << status << "\n" << ScriptOf(result.features);
  });
  EXPECT_GT(refused, static_cast<std::size_t>(Runs()) / 2);  // or there was nothing to test
}

TEST_P(CleanMessyPolygons, WhatIsInsideStaysInside) {
  constexpr int kSamples = 300;
  std::size_t inside = 0;
  double farthest = 0;
  ForEachInput([&](const auto& input, const CleanResult& result, std::uint64_t seed) {
    const double allowed = Allowed(result);
    const auto before = SidesOf(input), after = SidesOf(result.features);
    std::mt19937_64 random(seed);
    const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    for (const auto& [id, sides] : before) {
      const auto it = after.find(id);
      const Sides& now = it == after.end() ? Sides() : it->second;
      for (int i = 0; i < kSamples; ++i) {
        // Half of them near an edge, where errors are likely.
        Spot x = {unit(), unit()};
        if (i % 2 == 0) {
          const auto& [p, q] = sides[random() % sides.size()];
          const double t = unit();
          x = {p[0] + t * (q[0] - p[0]) + allowed * (4 * unit() - 2),
               p[1] + t * (q[1] - p[1]) + allowed * (4 * unit() - 2)};
        }
        const bool was = IsInside(sides, x);
        inside += was ? 1 : 0;
        if (was == IsInside(now, x)) continue;
        const double distance = DistanceTo(sides, x);
        farthest = std::max(farthest, distance / Tolerance());
        EXPECT_LE(distance, allowed) << "polygon " << id << " at " << x[0] << ", " << x[1];
      }
    }
  });
  EXPECT_GT(inside, static_cast<std::size_t>(Runs()) * kSamples / 10);
  RecordProperty("farthest_change_in_tolerances", std::to_string(farthest));
}

TEST_P(CleanMessyPolygons, SegmentFeaturesAreWhereSegmentsWere) {
  ForEachInput([&](const auto& input, const CleanResult& result, std::uint64_t) {
    const Sides before = SegmentsOf(input), after = SegmentsOf(result.features);
    const double allowed = Allowed(result);
    for (const auto& [p, q] : after) {
      EXPECT_LE(DistanceTo(before, {(p[0] + q[0]) / 2, (p[1] + q[1]) / 2}), allowed);
    }
  });
}

TEST_P(CleanMessyPolygons, CleaningAgainChangesNothing) {
  ForEachInput([&](const auto&, const CleanResult& result, std::uint64_t) {
    const CleanResult again = Clean(result.features);
    EXPECT_TRUE(again.changes.empty());
    EXPECT_EQ(again.features, result.features);
  });
}

TEST_P(CleanMessyPolygons, TheOrderOfTheInputDoesNotMatter) {
  // Ids of `result` as they were before they were shuffled; sides with their lesser end first.
  const auto summary = [](const CleanResult& result, const std::map<FeatureId, FeatureId>& was) {
    std::set<Spot> points;
    for (const auto& [id, at] : SpotsOf(result.features)) points.insert(at);
    std::map<FeatureId, Sides> sides;
    for (auto [id, of] : SidesOf(result.features)) {
      for (auto& [p, q] : of) {
        if (q < p) std::swap(p, q);
      }
      std::sort(of.begin(), of.end());
      sides[was.empty() ? id : was.at(id)] = of;
    }
    return std::pair(points, sides);
  };
  ForEachInput([&](std::vector<Feature> input, const CleanResult& result, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::vector<FeatureId> ids(input.size());
    std::iota(ids.begin(), ids.end(), FeatureId{1});
    std::shuffle(ids.begin(), ids.end(), random);
    std::map<FeatureId, FeatureId> was;
    for (Feature& f : input) {
      was[ids[f.id - 1]] = f.id;
      f.id = ids[f.id - 1];
      for (FeatureId& end : f.ends) end = end == kNoFeature ? end : ids[end - 1];
      for (auto& ring : f.rings) {
        for (FeatureId& corner : ring) corner = ids[corner - 1];
        std::rotate(ring.begin(),
                    ring.begin() + static_cast<std::ptrdiff_t>(random() % ring.size()), ring.end());
        if (random() % 2 == 0) std::reverse(ring.begin(), ring.end());
      }
      std::shuffle(f.rings.begin(), f.rings.end(), random);
    }
    std::shuffle(input.begin(), input.end(), random);
    EXPECT_EQ(summary(Clean(input), was), summary(result, {}));
  });
}

TEST_P(CleanMessyPolygons, EveryChangeIsReported) {
  ForEachInput([&](const auto& input, const CleanResult& result, std::uint64_t) {
    std::map<FeatureId, Feature> after;
    for (const Feature& f : result.features) {
      EXPECT_TRUE(after.emplace(f.id, f).second) << f.id << " stands twice";
    }
    std::set<FeatureId> named, dropped;
    for (const Change& change : result.changes) {
      named.insert(change.ids.begin(), change.ids.end());
      if (change.kind == ChangeKind::kPolygonDropped) dropped.insert(change.ids.front());
    }
    for (const Feature& f : input) {
      const auto it = after.find(f.id);
      if (f.kind == FeatureKind::kPolygon || f.kind == FeatureKind::kSize) {
        EXPECT_EQ(it == after.end(), dropped.contains(f.id)) << f.id;
      }
      if (it == after.end()) {
        EXPECT_TRUE(named.contains(f.id)) << f.id;
      } else {
        EXPECT_EQ(it->second.kind, f.kind);
        EXPECT_EQ(it->second.sizing, f.sizing);
      }
    }
    EXPECT_EQ(result.changes.empty(), result.features == input);
  });
}

INSTANTIATE_TEST_SUITE_P(Tolerances, CleanMessyPolygons,
                         ::testing::Values(0, 1e-6, 1e-3, 0.03, 0.3));

}  // namespace
}  // namespace dynmesh::cleaning::clean_polygons_property_test
