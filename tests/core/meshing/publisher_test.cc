// What a published output changes, and which of a few operations it makes stale.
#include "core/meshing/publisher.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/core/meshing/lone_complex.h"

namespace dynmesh::meshing::publisher_test {
namespace {

using geometry::Point2;
using Ops = std::vector<sac::OpId>;

class PublisherTest : public testing::Test {
 protected:
  using Record = LoneComplex<2>::Engine::Record;

  // Subscribes to the cells of the box about p.
  sac::OpId AddOperation(const Record& record, sac::OpId& head, const Point2& p, double radius,
                         bool attentive = false) {
    Extent<2> box = Extent<2>::Nothing();
    box.AddBall(p, radius);
    std::vector<sac::Place> places;
    complex_.tree.Cover(box, [&](sac::Place place, sac::Parts) { places.push_back(place); });
    return lone_.engine.Add(record, head, places, attentive);
  }
  bool IsInTree(VertexIndex v) {
    bool found = false;
    double r2 = 1e-20;
    complex_.tree.VisitBall(complex_.vertex(v).p, r2,
                            [&](std::uint32_t id, const Point2&, double) { found |= id == v; });
    return found;
  }
  bool IsSeen(SubsegmentIndex s, sac::Stamp now) {
    const bool visible = complex_.IsVisible(lone_.At(now), complex_.subsegment(s));
    EncroachmentSearch<2, test::RecordingEngine> search(complex_);
    const Subsegment<2>& sub = complex_.subsegment(s);
    const Point2 middle = geometry::Midpoint(complex_.vertex(sub.a).p, complex_.vertex(sub.b).p);
    bool found = false;
    for (const auto& e : search.EncroachedBy(lone_.At(now), middle)) found |= e.s == s;
    EXPECT_EQ(found, visible);
    return found;
  }
  void Publish(Made what, std::uint32_t i, sac::Stamp at) {
    lone_.publisher.Publish(MakeOutput(what, i), at);
  }
  void Withdraw(Made what, std::uint32_t i, sac::Stamp at) {
    lone_.publisher.Withdraw(MakeOutput(what, i), at);
  }

  LoneComplex<2> lone_;
  Complex<2, test::RecordingEngine>& complex_ = lone_.complex;
};

TEST_F(PublisherTest, AVertexIsThereFromItsPublicationToItsWithdrawal) {
  const std::size_t before = complex_.elements.vertex_count();
  const VertexIndex v = lone_.Add({{0.3, 0.4}}, 5);
  EXPECT_TRUE(complex_.vertex(v).present);
  EXPECT_TRUE(IsInTree(v));
  EXPECT_EQ(complex_.appeared.back(), v);
  EXPECT_EQ(complex_.elements.vertex_count(), before + 1);
  Withdraw(Made::kVertex, v, 5);
  EXPECT_FALSE(complex_.vertex(v).present);
  EXPECT_FALSE(IsInTree(v));
  EXPECT_EQ(complex_.elements.vertex_count(), before);
  lone_.publisher.Release(MakeOutput(Made::kVertex, v));
  EXPECT_NE(complex_.elements.NewVertex(), v);
  complex_.elements.TakeChanges([](auto...) {}, [](auto...) {});
  EXPECT_EQ(complex_.elements.NewVertex(), v);
}

// The nearest vertex of v, at distance 0.1, was read at time 5.
TEST_F(PublisherTest, ANearerVertexMattersToALaterNearest) {
  const VertexIndex v = lone_.Add({{0.5, 0.5}}), near = lone_.Add({{0.6, 0.5}}, 1);
  Record nearest = {kNearest, v, NearestEpoch(), 5};
  nearest.payload.radius2 = 0.0100001f;
  nearest.reads = {near};
  const sac::OpId op =
      AddOperation(nearest, complex_.vertex(v).operations, complex_.vertex(v).p, 0.11);
  lone_.engine.TakeStale();
  const VertexIndex later = lone_.Add({{0.51, 0.5}}, 6), farther = lone_.Add({{0.5, 0.62}}, 2),
                    as_far = lone_.Add({{0.4, 0.5}}, 2);
  EXPECT_EQ(lone_.engine.TakeStale(), Ops());
  for (const VertexIndex u : {later, farther, as_far}) {
    Withdraw(Made::kVertex, u, complex_.vertex(u).birth);
  }
  EXPECT_EQ(lone_.engine.TakeStale(), Ops());
  const VertexIndex nearer = lone_.Add({{0.5, 0.58}}, 4);
  EXPECT_EQ(lone_.engine.TakeStale(), Ops{op});
  Withdraw(Made::kVertex, nearer, 4);
  EXPECT_EQ(lone_.engine.TakeStale(), Ops()) << "it was not read";
  Withdraw(Made::kVertex, near, 1);
  EXPECT_EQ(lone_.engine.TakeStale(), Ops{op});
}

TEST_F(PublisherTest, AVertexInTheBallOfACleanSubsegmentMattersToItsCheck) {
  const VertexIndex a = lone_.Add({{0.25, 0.5}}), b = lone_.Add({{0.75, 0.5}});
  const SubsegmentIndex s = lone_.input.AddSegment(a, b, 1);
  const sac::OpId op = AddOperation({kCheck, s, FirstCheckEpoch(), 5},
                                    complex_.subsegment(s).operations, {{0.5, 0.5}}, 0.25);
  lone_.Add({{0.5, 0.76}}, 1);
  lone_.Add({{0.5, 0.6}}, 6);
  EXPECT_EQ(lone_.engine.TakeStale(), Ops()) << "outside, or later";
  lone_.Add({{0.5, 0.75}}, 1);
  EXPECT_EQ(lone_.engine.TakeStale(), Ops{op}) << "on the surface";
}

TEST_F(PublisherTest, ASubsegmentIsVisibleFromItsExposureToItsEarliestDeath) {
  const VertexIndex a = lone_.Add({{0.25, 0.5}}), b = lone_.Add({{0.75, 0.5}});
  const SubsegmentIndex s = lone_.input.AddSegment(a, b, 1);
  EXPECT_FALSE(IsSeen(s, 9));
  Publish(Made::kExposure, s, 2);
  EXPECT_FALSE(IsSeen(s, 2));
  EXPECT_TRUE(IsSeen(s, 3));
  const sac::Output death = MakeOutput(Made::kDeath, s);
  auto& head = complex_.subsegment(s).operations;
  const sac::OpId late = lone_.engine.Add({kSplit, s, MakeEpoch(3, 1, 0), 8, {}, {death}}, head),
                  early = lone_.engine.Add({kRecheck, s, MakeEpoch(2, 1, 0), 5, {}, {death}}, head);
  Publish(Made::kDeath, s, 8);
  EXPECT_TRUE(IsSeen(s, 8));
  EXPECT_FALSE(IsSeen(s, 9));
  EXPECT_EQ(lone_.engine.TakeStale(), Ops());
  Publish(Made::kDeath, s, 5);
  EXPECT_FALSE(IsSeen(s, 6));
  EXPECT_EQ(lone_.engine.TakeStale(), Ops{late}) << "the later split has nothing to do now";
  Withdraw(Made::kDeath, s, 8);
  EXPECT_FALSE(IsSeen(s, 6));
  Publish(Made::kDeath, s, 8);
  Withdraw(Made::kDeath, s, 5);
  EXPECT_TRUE(IsSeen(s, 8)) << "the later split is in force again";
  EXPECT_FALSE(IsSeen(s, 9));
  EXPECT_EQ(lone_.engine.TakeStale(), Ops{late});
  Withdraw(Made::kExposure, s, 2);
  EXPECT_FALSE(IsSeen(s, 5));
  EXPECT_LT(late, early);
}

// A row of subsegments along a border of cells, with no point on the other side: a leaf as large as
// half of the domain has their balls. Each search there would look at the whole row.
TEST_F(PublisherTest, SubsegmentsBesideAnEmptyCellAreNotKeptInOnePlace) {
  const int n = 4096;
  std::vector<VertexIndex> row;
  for (int i = 0; i <= n; ++i) row.push_back(lone_.Add({{i / double{n}, 0.5}}));
  for (int i = 0; i < n; ++i) lone_.AddSubsegment(row[i], row[i + 1]);
  std::size_t most = 0;
  for (sac::Place place = 0; place < complex_.exposures.places(); ++place) {
    most = std::max(most, complex_.exposures.at(place).size());
  }
  EXPECT_LE(most, 64U);
  // Each is found at its middle and beside it, on both sides.
  EncroachmentSearch<2, test::RecordingEngine> search(complex_);
  for (int i = 0; i < n; i += 7) {
    for (const double beside : {-0.3, 0.0, 0.3}) {
      const Point2 x = {{(i + 0.5) / n, 0.5 + beside / n}};
      EXPECT_EQ(search.EncroachedBy(lone_.At(3), x).size(), 1U) << i;
    }
  }
}

// A Complete made a vertex in the ball before the subsegment was visible; another yielded.
TEST_F(PublisherTest, AnExposureMattersToMakersInItsBallAndToAttentiveOperations) {
  const VertexIndex a = lone_.Add({{0.25, 0.5}}), b = lone_.Add({{0.75, 0.5}});
  const SubsegmentIndex s = lone_.input.AddSegment(a, b, 1);
  const VertexIndex v = lone_.Add({{0.5, 0.8}}), made = lone_.Add({{0.5, 0.6}}, 5),
                    outside = lone_.Add({{0.5, 0.77}}, 6);
  const auto add = [&](sac::Stamp stamp, bool attentive) {
    Record complete = {kComplete, v, MakeEpoch(9, 0, kQualityStep), stamp};
    complete.payload.flag = attentive;
    complete.payload.radius2 = 0.04f;
    return AddOperation(complete, complex_.vertex(v).operations, complex_.vertex(v).p, 0.2,
                        attentive);
  };
  const sac::OpId maker = add(5, false), other_maker = add(6, false), idle = add(7, false),
                  yielded = add(8, true), yielded_before = add(3, true);
  complex_.vertex(made).creator = maker;
  complex_.vertex(outside).creator = other_maker;
  Publish(Made::kExposure, s, 4);
  EXPECT_EQ(lone_.engine.TakeStale(), (Ops{maker, yielded}));
  Publish(Made::kDeath, s, 7);
  EXPECT_EQ(lone_.engine.TakeStale(), Ops{yielded}) << "the maker is earlier";
  Withdraw(Made::kDeath, s, 7);
  EXPECT_EQ(lone_.engine.TakeStale(), Ops{yielded});
  Withdraw(Made::kExposure, s, 4);
  EXPECT_EQ(lone_.engine.TakeStale(), (Ops{maker, yielded}));
  EXPECT_LT(idle, yielded_before);
}

}  // namespace
}  // namespace dynmesh::meshing::publisher_test
