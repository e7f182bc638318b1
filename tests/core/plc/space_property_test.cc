// Random scripts in 3D: legality as in the oracle, the error about a fault that it found; the net
// change as the sets define; and verdict, error and change are functions of the set and the batch.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "core/plc/plc.h"
#include "dynmesh/error.h"
#include "tests/core/plc/naive_plc.h"
#include "tests/core/plc/naive_space.h"
#include "tests/core/plc/plc_test_util.h"
#include "tests/support/nightly.h"

namespace dynmesh::plc::space_property_test {
namespace {

using Place = std::array<double, 3>;

// Batches on a coarse grid of places, sometimes off it by about the close limit.
class Generator {
 public:
  Generator(std::uint64_t seed, double limit) : random_(seed), limit_(limit) {}

  EditBatch Batch(const FeatureMap& present, int most) {
    draft_ = present;
    batch_.clear();
    for (int n = Int(1, most); n > 0; --n) Append();
    return batch_;
  }
  const FeatureMap& draft() const { return draft_; }

 private:
  int Int(int lo, int hi) { return std::uniform_int_distribution<int>(lo, hi)(random_); }
  bool Chance(double p) { return std::bernoulli_distribution(p)(random_); }

  Place NewPlace() {
    if (const auto polygon = Pick(FeatureKind::kPolygon); polygon && Chance(0.1)) {
      return NearInsideOf(*polygon);
    }
    Place at;
    for (double& x : at) x = Int(0, 6) / 8.0 + 0.125;
    if (Chance(0.06)) at[Int(0, 2)] += limit_ * Int(-4, 4) / 2;
    return at;
  }
  // In the middle between corners of a ring, or off it by about the limit.
  Place NearInsideOf(const Feature& polygon) {
    const auto& ring = polygon.rings[0];
    const auto p = draft_.find(ring[0]), q = draft_.find(ring[2]);
    if (p == draft_.end() || q == draft_.end()) return {0.5, 0.5, 0.5};
    Place at;
    for (int i = 0; i < 3; ++i) at[i] = (p->second.position[i] + q->second.position[i]) / 2;
    double& x = at[Int(0, 2)];
    x = std::clamp(x + limit_ * Int(-4, 4) / 2, 0.0, 1.0);
    return at;
  }
  // The point there, a new one if there is none.
  FeatureId PointAt(const Place& at) {
    for (const auto& [id, f] : draft_) {
      if (f.kind == FeatureKind::kPoint && f.position == at) return id;
    }
    return Add(Feature::Point(FreeId(), at[0], at[1], at[2]));
  }
  FeatureId FreeId() {
    FeatureId id = Int(1, 5000);
    while (draft_.contains(id)) ++id;
    return id;
  }
  FeatureId Add(const Feature& f) {
    batch_.push_back(Edit::Add(f));
    draft_[f.id] = f;
    return f.id;
  }
  std::optional<Feature> Pick(FeatureKind kind) {
    std::vector<Feature> choice;
    for (const auto& [id, f] : draft_) {
      if (f.kind == kind) choice.push_back(f);
    }
    if (choice.empty()) return std::nullopt;
    return choice[Int(0, static_cast<int>(choice.size()) - 1)];
  }
  FeatureId SomePoint() {
    const auto point = Pick(FeatureKind::kPoint);
    return point && Chance(0.8) ? point->id : PointAt(NewPlace());
  }

  // A rectangle along two axes, or leaning over one; maybe with a hole.
  void AddRectangle() {
    Place o = NewPlace();
    if (const auto point = Pick(FeatureKind::kPoint); point && Chance(0.7)) o = point->position;
    const int i = Int(0, 2), j = (i + 1) % 3, k = (i + 2) % 3;
    const double across = Int(1, 3) / 8.0, along = Int(1, 3) / 8.0;
    const double lean = Chance(0.3) ? Int(-3, 3) / 8.0 : 0;
    const auto at = [&](double u, double v) {
      Place p = o;
      p[i] += u * across, p[j] += v * along, p[k] += v * lean;
      return p;
    };
    if (std::max(at(1, 1)[i], at(1, 1)[j]) > 1) return;
    if (at(1, 1)[k] > 1 || at(1, 1)[k] < 0) return;
    Rings rings = {{PointAt(at(0, 0)), PointAt(at(1, 0)), PointAt(at(1, 1)), PointAt(at(0, 1))}};
    if (Chance(0.2)) {
      rings.push_back({PointAt(at(0.25, 0.25)), PointAt(at(0.75, 0.25)), PointAt(at(0.75, 0.75)),
                       PointAt(at(0.25, 0.75))});
    }
    Turn(rings);
    Add(Feature::Polygon(FreeId(), rings));
  }
  void AddTriangle() {
    std::vector<FeatureId> ring;
    while (ring.size() < 3) {
      const FeatureId p = SomePoint();
      if (std::find(ring.begin(), ring.end(), p) == ring.end()) ring.push_back(p);
    }
    Add(Feature::Polygon(FreeId(), {ring}));
  }
  // The same rings otherwise: no verdict may change.
  void Turn(Rings& rings) {
    for (auto& ring : rings) {
      std::rotate(ring.begin(), ring.begin() + Int(0, static_cast<int>(ring.size()) - 1),
                  ring.end());
      if (Chance(0.5)) std::reverse(ring.begin(), ring.end());
    }
    std::shuffle(rings.begin(), rings.end(), random_);
  }
  void AddBox() {
    Place lo = NewPlace(), hi = lo;
    for (int i = 0; i < 3; ++i) hi[i] += Int(1, 3) / 8.0;
    if (*std::max_element(hi.begin(), hi.end()) > 1) return;
    std::map<FeatureId, FeatureId> ids;
    for (const Edit& edit : Corners(1, lo, hi)) {
      ids[edit.feature.id] = PointAt(edit.feature.position);
    }
    for (auto face : Faces(1)) {
      for (FeatureId& id : face) id = ids[id];
      Add(Feature::Polygon(FreeId(), {face}));
    }
  }
  void Remove() {
    const FeatureKind kinds[] = {FeatureKind::kPoint, FeatureKind::kSegment, FeatureKind::kPolygon};
    const auto f = Pick(kinds[Int(0, 2)]);
    if (!f) return;
    std::vector<FeatureId> gone = {f->id};
    for (const auto& [id, user] : draft_) {
      if (f->kind != FeatureKind::kPoint) break;
      bool uses =
          user.kind == FeatureKind::kSegment && (user.ends[0] == f->id || user.ends[1] == f->id);
      for (const auto& ring : user.rings) {
        uses = uses || std::find(ring.begin(), ring.end(), f->id) != ring.end();
      }
      if (uses) gone.push_back(id);
    }
    for (const FeatureId id : gone) {
      batch_.push_back(Edit::Remove(id));
      draft_.erase(id);
    }
  }

  void Append() {
    const int dice = Int(0, 99);
    if (dice < 12) {
      PointAt(NewPlace());
    } else if (dice < 30) {
      const FeatureId p = SomePoint(), q = SomePoint();
      if (p != q) Add(Feature::Segment(FreeId(), p, q));
    } else if (dice < 55) {
      AddRectangle();
    } else if (dice < 65) {
      AddTriangle();
    } else if (dice < 72) {
      AddBox();
    } else if (dice < 80) {
      const auto point = Pick(FeatureKind::kPoint);
      if (!point) return;
      const Place at = NewPlace();
      batch_.push_back(Edit::Move(point->id, at[0], at[1], at[2]));
      draft_[point->id].position = at;
    } else if (dice < 84) {
      auto polygon = Pick(FeatureKind::kPolygon);
      if (!polygon) return;
      Turn(polygon->rings);
      batch_.push_back(Edit::Set(*polygon));
      draft_[polygon->id] = *polygon;
    } else {
      Remove();
    }
  }

  std::mt19937_64 random_;
  double limit_;
  FeatureMap draft_;
  EditBatch batch_;
};

// `after` is `before` without the removed and with the added ones; none is on both sides.
template <class F>
void ExpectChange(std::vector<F> before, const std::vector<F>& removed, const std::vector<F>& added,
                  const std::vector<F>& after) {
  for (const F& f : removed) {
    const auto it = std::find(before.begin(), before.end(), f);
    ASSERT_NE(it, before.end());
    before.erase(it);
    ASSERT_EQ(std::count(added.begin(), added.end(), f), 0);
  }
  before.insert(before.end(), added.begin(), added.end());
  ASSERT_EQ(before.size(), after.size());
  ASSERT_TRUE(std::is_permutation(before.begin(), before.end(), after.begin()));
}

void ExpectChange(const Delta<3>& before, const Delta<3>& delta, const Delta<3>& after) {
  ExpectChange(before.added_points, delta.removed_points, delta.added_points, after.added_points);
  ExpectChange(before.added_segments, delta.removed_segments, delta.added_segments,
               after.added_segments);
  ExpectChange(before.added_polygons, delta.removed_polygons, delta.added_polygons,
               after.added_polygons);
  ExpectChange(before.added_facets, delta.removed_facets, delta.added_facets, after.added_facets);
}

bool IsAmong(const std::vector<Offence>& offences, const std::vector<FeatureId>& named) {
  return std::any_of(offences.begin(), offences.end(), [&](const Offence& o) {
    if (o.other.empty()) return o.one.contains(named[0]);
    return (o.one.contains(named[0]) && o.other.contains(named[1])) ||
           (o.one.contains(named[1]) && o.other.contains(named[0]));
  });
}

struct Tally {
  int accepted = 0, refused = 0;
  std::map<std::string, int> reasons;
};

void RunScript(std::uint64_t seed, int batches, int most, Tally& tally) {
  Plc3 grown(Cube(0, 1));
  const double limit = CloseLimit(Cube(0, 1));
  Generator generator(seed, limit);
  FeatureMap present;
  for (int i = 0; i < batches; ++i) {
    const EditBatch batch = generator.Batch(present, most);
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", batch " << i << "\n"
                                    << ScriptOf(AddAll(grown.Features())) << "# this one:\n"
                                    << ScriptOf(batch));
    const std::vector<Offence> offences = FindOffences(generator.draft(), limit);
    const auto delta = grown.Check(batch);
    ASSERT_EQ(delta.ok(), offences.empty())
        << delta.status() << "; oracle: " << (offences.empty() ? "legal" : offences[0].what);
    // Entered at once, in another order, the set gives the same answers.
    Plc3 fresh(Cube(0, 1));
    EditBatch all = AddAll(grown.Features());
    std::reverse(all.begin(), all.end());
    Apply(fresh, all);
    ASSERT_EQ(fresh.FromNothing(), grown.FromNothing());
    const auto again = fresh.Check(batch);
    ASSERT_EQ(again.status(), delta.status());
    if (!delta.ok()) {
      ++tally.refused;
      const ErrorDetail detail = *GetErrorDetail(delta.status());
      ++tally.reasons[detail.reason];
      ASSERT_TRUE(IsAmong(offences, detail.features)) << delta.status();
      continue;
    }
    ++tally.accepted;
    ASSERT_EQ(*again, *delta);
    const Delta<3> before = grown.FromNothing();
    grown.Apply(*delta);
    ExpectChange(before, *delta, grown.FromNothing());
    if (testing::Test::HasFatalFailure()) return;
    grown.Apply(delta->Inverse());
    ASSERT_EQ(grown.FromNothing(), before);
    grown.Apply(*delta);
    present = generator.draft();
  }
}

void RunScripts(std::uint64_t first, int scripts, int batches, int most) {
  Tally tally;
  for (int i = 0; i < scripts; ++i) {
    RunScript(first + i, batches, most, tally);
    if (testing::Test::HasFatalFailure()) return;
  }
  std::cout << "seeds from " << first << ": " << tally.accepted << " accepted, " << tally.refused
            << " refused;";
  for (const auto& [reason, count] : tally.reasons) std::cout << " " << reason << "=" << count;
  std::cout << "\n";
  EXPECT_GT(tally.accepted, scripts / 2);
  EXPECT_GT(tally.refused, scripts / 2);
}

// The oracle is slow.
int Scripts() { return test::IsNightly() ? 1000 : 8; }

TEST(SpaceProperty, SmallEditsAgreeWithTheOracle) { RunScripts(1000, Scripts(), 40, 2); }
TEST(SpaceProperty, LargerBatchesAgreeWithTheOracle) { RunScripts(200000, Scripts(), 15, 6); }

}  // namespace
}  // namespace dynmesh::plc::space_property_test
