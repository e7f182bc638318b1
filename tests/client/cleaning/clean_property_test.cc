// Random messy input: the result is accepted, is close to the input, and is a function of
// coordinates.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <utility>

#include "client/cleaning/clean_input.h"
#include "core/plc/plc.h"
#include "gtest/gtest.h"
#include "tests/client/cleaning/input_script.h"
#include "tests/client/cleaning/is_legal.h"
#include "tests/client/cleaning/messy_input.h"

namespace dynmesh::cleaning::clean_property_test {
namespace {

using Place = std::array<double, 2>;
using Parts = std::vector<std::pair<Place, Place>>;

Parts PartsOf(const std::vector<Feature>& features, bool ordered) {
  std::map<FeatureId, Place> at;
  for (const Feature& f : features) {
    if (f.kind == FeatureKind::kPoint) at[f.id] = {f.position[0] + 0.0, f.position[1] + 0.0};
  }
  Parts parts;
  for (const Feature& f : features) {
    // A point is a part of no length.
    if (f.kind == FeatureKind::kPoint) {
      parts.emplace_back(at[f.id], at[f.id]);
      continue;
    }
    Place p = at[f.ends[0]], q = at[f.ends[1]];
    if (ordered && q < p) std::swap(p, q);
    parts.emplace_back(p, q);
  }
  if (ordered) std::sort(parts.begin(), parts.end());
  return parts;
}

double Distance(const Place& p, const Place& a, const Place& b) {
  const double dx = b[0] - a[0], dy = b[1] - a[1];
  const double length2 = dx * dx + dy * dy;
  double t = length2 > 0 ? ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / length2 : 0;
  t = std::min(1.0, std::max(0.0, t));
  return std::hypot(p[0] - a[0] - t * dx, p[1] - a[1] - t * dy);
}

// The largest distance of a point of `of` from all of `from`.
double Deviation(const Parts& of, const Parts& from) {
  constexpr int kSteps = 16;
  double largest = 0;
  for (const auto& [p, q] : of) {
    for (int i = 0; i <= (p == q ? 0 : kSteps); ++i) {
      const double t = static_cast<double>(i) / kSteps;
      const Place x = {p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])};
      double least = 1e300;
      for (const auto& [a, b] : from) least = std::min(least, Distance(x, a, b));
      largest = std::max(largest, least);
    }
  }
  return largest;
}

absl::Status CoreAccepts(const std::vector<Feature>& features) {
  const MeshOptions options;  // the unit square
  return plc::Plc2(options).Check(AddAll(features)).status();
}

class CleanMessyInput : public ::testing::TestWithParam<double> {
 protected:
  static int Runs() { return std::getenv("DYNMESH_NIGHTLY") != nullptr ? 20000 : 400; }

  // The tolerance: 4 times what the core refuses, unless larger.
  static double Tolerance() { return std::max(GetParam(), 4 * plc::CloseLimit(MeshOptions())); }

  template <class Check>
  static void ForEachInput(Check check) {
    for (int run = 0; run < Runs(); ++run) {
      const auto seed = static_cast<std::uint64_t>(run) + 1;
      const std::vector<Feature> input = MessyInput(seed, Tolerance()).Features();
      CleanOptions options;
      options.tolerance = Tolerance();
      const auto result = CleanInput(input, options);
      ASSERT_TRUE(result.ok()) << "seed " << seed << ": " << result.status() << "\n"
                               << ScriptOf(input);
      check(input, *result, seed);
      if (::testing::Test::HasFailure()) {
        FAIL() << "seed " << seed << ", tolerance " << Tolerance() << "\n" << ScriptOf(input);
      }
    }
  }
};

TEST_P(CleanMessyInput, TheCoreAcceptsTheResult) {
  std::size_t refused = 0;
  ForEachInput([&](const auto& input, const CleanResult& result, std::uint64_t) {
    refused += CoreAccepts(input).ok() ? 0 : 1;
    const absl::Status status = CoreAccepts(result.features);
    EXPECT_TRUE(IsLegal(status, Tolerance())) << status;
  });
  EXPECT_GT(refused, static_cast<std::size_t>(Runs()) / 2);  // or there was nothing to test
}

TEST_P(CleanMessyInput, EverythingStaysWhereItWas) {
  double largest = 0;
  ForEachInput([&](const auto& input, const CleanResult& result, std::uint64_t) {
    const Parts before = PartsOf(input, false), after = PartsOf(result.features, false);
    // Needles may be wider than the tolerance.
    double allowed = 3 * Tolerance();
    for (const Change& change : result.changes) {
      if (change.kind != ChangeKind::kSmallAngle) continue;
      allowed += std::hypot(change.from[0] - change.to[0], change.from[1] - change.to[1]);
    }
    const double deviation = std::max(Deviation(before, after), Deviation(after, before));
    EXPECT_LE(deviation, allowed);
    largest = std::max(largest, deviation / Tolerance());
  });
  RecordProperty("largest_deviation_in_tolerances", std::to_string(largest));
}

TEST_P(CleanMessyInput, CleaningAgainChangesNothing) {
  ForEachInput([&](const auto&, const CleanResult& result, std::uint64_t) {
    CleanOptions options;
    options.tolerance = Tolerance();
    const auto again = CleanInput(result.features, options);
    ASSERT_TRUE(again.ok()) << again.status();
    EXPECT_TRUE(again->changes.empty());
    EXPECT_EQ(again->features, result.features);
  });
}

TEST_P(CleanMessyInput, TheOrderOfTheInputDoesNotMatter) {
  ForEachInput([&](std::vector<Feature> input, const CleanResult& result, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::vector<FeatureId> ids(input.size());
    std::iota(ids.begin(), ids.end(), FeatureId{1});
    std::shuffle(ids.begin(), ids.end(), random);
    for (Feature& f : input) {
      f.id = ids[f.id - 1];
      if (f.kind == FeatureKind::kPoint) continue;
      for (FeatureId& end : f.ends) end = ids[end - 1];
      if (random() % 2 == 0) std::swap(f.ends[0], f.ends[1]);
    }
    std::shuffle(input.begin(), input.end(), random);
    CleanOptions options;
    options.tolerance = Tolerance();
    const auto other = CleanInput(input, options);
    ASSERT_TRUE(other.ok()) << other.status();
    EXPECT_EQ(PartsOf(other->features, true), PartsOf(result.features, true));
  });
}

TEST_P(CleanMessyInput, IdsAreKeptWherePossible) {
  ForEachInput([&](const auto& input, const CleanResult& result, std::uint64_t) {
    std::map<FeatureId, Feature> before;
    for (const Feature& f : input) before[f.id] = f;
    std::set<FeatureId> seen;
    for (const Feature& f : result.features) {
      EXPECT_TRUE(seen.insert(f.id).second) << f.id << " stands twice";
      if (!before.contains(f.id)) continue;
      EXPECT_EQ(f.kind, before[f.id].kind);
      if (f.kind == FeatureKind::kSegment) continue;
      EXPECT_EQ(f.position, before[f.id].position);
    }
    // Removed points are reported.
    std::set<FeatureId> reported;
    for (const Change& change : result.changes) reported.insert(change.ids.front());
    for (const Feature& f : input) EXPECT_TRUE(seen.contains(f.id) || reported.contains(f.id));
  });
}

INSTANTIATE_TEST_SUITE_P(Tolerances, CleanMessyInput, ::testing::Values(0, 1e-6, 1e-3, 0.03, 0.3));

}  // namespace
}  // namespace dynmesh::cleaning::clean_property_test
