#include "client/preparation/attempts.h"

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dynmesh/error.h"
#include "gtest/gtest.h"

namespace dynmesh::preparation::attempts_test {
namespace {

struct FakeSurface {
  std::vector<Feature> features;
  std::optional<Report> preparation;
};

absl::Status Refusal(const char* why) {
  return MakeError(absl::StatusCode::kResourceExhausted, "too much", {why, {}, {}});
}

// A file whose surface with a tolerance takes so many vertices. D is 1: tolerances are 0, 0.1, 0.5
// and 1.
class MakeOfSurfaceTest : public ::testing::Test {
 protected:
  static constexpr std::uint64_t kEndless = 1'000'000'000, kMost = 2'000'000;

  absl::Status Make(FakeSurface& surface) {
    const auto make = [&](FakeSurface& at, std::optional<std::uint64_t> most) {
      const double tolerance = at.preparation->tolerance;
      tried_.emplace_back(tolerance, most.has_value());
      if (refused_.contains(tolerance)) return absl::InvalidArgumentError("refused");
      const std::uint64_t needed = vertices_.at(tolerance);
      if (needed > most.value_or(kMost)) return Refusal(reason::kVertexLimit);
      return needed == 0 ? Refusal(reason::kDepthLimit) : absl::OkStatus();
    };
    const auto prepare = [&](double tolerance) -> absl::StatusOr<FakeSurface> {
      return Of(tolerance);
    };
    return MakeOfSurface(surface, make, prepare, [&](std::string told) { told_.push_back(told); });
  }
  // Equal features for tolerances that change nothing.
  FakeSurface Of(double tolerance) {
    FakeSurface surface;
    surface.features = {Feature::Point(1, same_.contains(tolerance) ? 0 : tolerance, 0)};
    surface.preparation.emplace();
    surface.preparation->is_mended = is_mended_ || tolerance > 0;
    surface.preparation->within = 1;
    surface.preparation->tolerance = tolerance;
    if (tolerance > 0) surface.preparation->least_tolerance = tolerance;
    return surface;
  }

  using Tried = std::vector<std::pair<double, bool>>;
  std::map<double, std::uint64_t> vertices_;
  std::map<double, bool> same_, refused_;
  bool is_mended_ = true;
  Tried tried_;  // the tolerance, and whether with the first limit
  std::vector<std::string> told_;
};

TEST_F(MakeOfSurfaceTest, OneThatIsSmallEnoughIsTheFirst) {
  vertices_ = {{0, 1000}};
  FakeSurface surface = Of(0);
  EXPECT_TRUE(Make(surface).ok());
  EXPECT_EQ(tried_, (Tried{{0, true}}));
  EXPECT_TRUE(told_.empty());
}

TEST_F(MakeOfSurfaceTest, OneThatIsTooLargeEndsSoonIfALargerToleranceHelps) {
  vertices_ = {{0, kEndless}, {0.1, kEndless}, {0.5, 1000}};
  FakeSurface surface = Of(0);
  EXPECT_TRUE(Make(surface).ok());
  EXPECT_EQ(tried_, (Tried{{0, true}, {0.1, true}, {0.5, true}}));
  EXPECT_EQ(surface.preparation->least_tolerance, 0.5);
  ASSERT_EQ(told_.size(), 2U);
  EXPECT_EQ(told_[1],
            "its mesh would have more than 100000 vertices; tried again with --mending-tolerance "
            "0.5");
}

TEST_F(MakeOfSurfaceTest, AToleranceThatChangesNothingIsNotTried) {
  vertices_ = {{0, kEndless}, {0.1, 1000}, {0.5, 1000}};
  same_ = {{0.1, true}};
  FakeSurface surface = Of(0);
  EXPECT_TRUE(Make(surface).ok());
  EXPECT_EQ(tried_, (Tried{{0, true}, {0.5, true}}));
}

TEST_F(MakeOfSurfaceTest, WhereNoneHelpsTheFirstThatFitsIntoTheLimitOfAllMeshesIsTaken) {
  vertices_ = {{0, kEndless}, {0.1, kMost}, {0.5, kMost}, {1, 0}};
  FakeSurface surface = Of(0);
  EXPECT_TRUE(Make(surface).ok());
  EXPECT_EQ(tried_,
            (Tried{{0, true}, {0.1, true}, {0.5, true}, {1, true}, {0, false}, {0.1, false}}));
  EXPECT_EQ(surface.preparation->least_tolerance, 0.1);
  EXPECT_EQ(surface.features, Of(0.1).features);
  ASSERT_EQ(told_.size(), 5U);
  EXPECT_EQ(told_[3], "no larger tolerance helps; tried again, with a higher limit of vertices");
  EXPECT_EQ(told_[4],
            "no larger tolerance helps; tried again with --mending-tolerance 0.1, with a higher "
            "limit of vertices");
}

TEST_F(MakeOfSurfaceTest, WhereNothingHelpsItIsWhatTheLastAttemptSaid) {
  vertices_ = {{0, kEndless}, {0.1, kEndless}, {0.5, kEndless}, {1, kEndless}};
  FakeSurface surface = Of(0);
  EXPECT_TRUE(IsOfVertexLimit(Make(surface)));
  EXPECT_EQ(tried_.size(), 8U);
  EXPECT_EQ(surface.preparation->least_tolerance, 1);
}

TEST_F(MakeOfSurfaceTest, WhatWasNotMendedHasTheLimitOfAllMeshes) {
  is_mended_ = false;
  vertices_ = {{0, kEndless}, {0.1, 1000}};
  FakeSurface surface = Of(0);
  EXPECT_TRUE(Make(surface).ok());
  EXPECT_EQ(tried_, (Tried{{0, false}, {0.1, true}}));
}

TEST_F(MakeOfSurfaceTest, OtherRefusalsAreTheLast) {
  refused_ = {{0, true}};
  FakeSurface surface = Of(0);
  EXPECT_EQ(Make(surface).message(), "refused");
  EXPECT_EQ(tried_.size(), 1U);
  surface.preparation.reset();
  const auto make = [](FakeSurface&, std::optional<std::uint64_t> most) {
    EXPECT_FALSE(most);
    return Refusal(reason::kVertexLimit);
  };
  const auto prepare = [](double) -> absl::StatusOr<FakeSurface> {
    ADD_FAILURE();
    return absl::UnknownError("");
  };
  EXPECT_FALSE(MakeOfSurface(surface, make, prepare, [](const std::string&) {}).ok());
}

TEST(Attempts, TheFirstLimitIsAMultipleOfTheFeatures) {
  EXPECT_EQ(FirstMostVertices({}), 100'000U);
  EXPECT_EQ(FirstMostVertices(std::vector<Feature>(10'000)), 300'000U);
}

}  // namespace
}  // namespace dynmesh::preparation::attempts_test
