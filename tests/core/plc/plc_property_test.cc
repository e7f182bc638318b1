// Random scripts against the oracle: verdict, blame, net change, state.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "core/plc/plc.h"
#include "dynmesh/error.h"
#include "tests/core/plc/naive_plc.h"
#include "tests/core/plc/plc_test_util.h"
#include "tests/support/nightly.h"

namespace dynmesh::plc::plc_property_test {
namespace {

// Legal means geometrically legal: a very large number of vertices does not matter here.
MeshOptions Unlimited() {
  MeshOptions options = Square(0, 1);
  options.limits.max_vertices = std::uint64_t{1} << 60;
  return options;
}

using geometry::Point2;

// Makes batches with about even chances to break a rule.
class Generator {
 public:
  enum class Style { kGrid, kFineGrid, kReal, kHatch, kClusters, kNearMisses };

  // `marks`: some segments and polygons are unsplit.
  Generator(std::uint64_t seed, Style style, bool polygons = false, bool marks = false)
      : random_(seed), style_(style), polygons_(polygons), marks_(marks) {}

  EditBatch Batch(const FeatureMap& present, int most) {
    EditBatch batch;
    FeatureMap draft = present;
    const int n = Int(1, most);
    while (static_cast<int>(batch.size()) < n) Append(draft, batch);
    if (Chance(0.1)) std::shuffle(batch.begin(), batch.end(), random_);
    return batch;
  }

  int Int(int lo, int hi) { return std::uniform_int_distribution<int>(lo, hi)(random_); }
  bool Chance(double p) { return std::bernoulli_distribution(p)(random_); }

 private:
  static double Round(double x) {
    return std::clamp(std::nearbyint(std::ldexp(x, 52)), 0.0, 0x1p52) * 0x1p-52;
  }
  double Real() { return Round(std::uniform_real_distribution<double>(0, 1)(random_)); }
  double Steps(double step, int most) { return step * Int(-most, most); }

  std::optional<Feature> Pick(const FeatureMap& draft, FeatureKind kind) {
    std::vector<Feature> choice;
    for (const auto& [id, f] : draft) {
      if (f.kind == kind) choice.push_back(f);
    }
    if (choice.empty()) return std::nullopt;
    return choice[Int(0, static_cast<int>(choice.size()) - 1)];
  }

  // A position on or next to a present feature.
  Point2 NearSomething(const FeatureMap& draft) {
    const double steps[] = {0, 0x1p-52, 0x1p-44, 0x1p-42, 0x1p-41, 0x1p-40, 0x1p-38};
    const double step = steps[Int(0, 6)];
    Point2 at{{Real(), Real()}};
    if (const auto point = Pick(draft, FeatureKind::kPoint)) {
      at = {{point->position[0], point->position[1]}};
    }
    if (const auto segment = Pick(draft, FeatureKind::kSegment); segment && Chance(0.6)) {
      const auto p = draft.find(segment->ends[0]), q = draft.find(segment->ends[1]);
      if (p != draft.end() && q != draft.end()) {
        const double t = Int(1, 3) / 4.0;
        for (int i = 0; i < 2; ++i) {
          at[i] = p->second.position[i] + t * (q->second.position[i] - p->second.position[i]);
        }
      }
    }
    return {{Round(at[0] + Steps(step, 2)), Round(at[1] + Steps(step, 2))}};
  }

  Point2 NewPlace(const FeatureMap& draft) {
    if (Chance(0.01)) {
      const double bad[] = {std::numeric_limits<double>::quiet_NaN(),
                            std::numeric_limits<double>::infinity(), -0x1p-52, 1.5};
      return {{bad[Int(0, 3)], 0.5}};
    }
    switch (style_) {
      case Style::kGrid:
        return {{Int(0, 8) / 8.0, Int(0, 8) / 8.0}};
      case Style::kFineGrid:
        return {{Int(0, 64) / 64.0, Int(0, 64) / 64.0}};
      case Style::kReal:
        return {{Real(), Real()}};
      case Style::kHatch:  // near the left and right, or lower and upper, border
        if (Chance(0.5)) return {{Int(0, 1) ? Int(0, 3) / 256.0 : 1 - Int(0, 3) / 256.0, Real()}};
        return {{Real(), Int(0, 1) ? Int(0, 3) / 256.0 : 1 - Int(0, 3) / 256.0}};
      case Style::kClusters: {
        const double scale = std::ldexp(1.0, -Int(0, 4) * 9);
        const double at = Int(1, 3) / 4.0;
        return {{Round(at + Steps(scale / 32, 8)), Round(0.5 + Steps(scale / 32, 8))}};
      }
      case Style::kNearMisses:
        return Chance(0.4) ? Point2{{Real(), Real()}} : NearSomething(draft);
    }
    return {};
  }

  FeatureId FreeId(const FeatureMap& draft) {
    if (Chance(0.01)) return Chance(0.5) ? 0 : FeatureId{0} - Int(1, 70000);
    FeatureId id = Int(1, 400);
    while (draft.contains(id) && !Chance(0.02)) id = Int(1, 400);
    return id;
  }

  Feature NewPoint(FeatureId id, const FeatureMap& draft) {
    const Point2 at = NewPlace(draft);
    return Feature::Point(id, at[0] == 0 && Chance(0.5) ? -0.0 : at[0], at[1]);
  }

  // Between two points, mostly to one of the nearest of a few: fewer crossings.
  Feature NewSegment(FeatureId id, const FeatureMap& draft) {
    const auto p = Pick(draft, FeatureKind::kPoint);
    if (!p || Chance(0.02)) return Feature::Segment(id, Int(0, 400), Int(1, 400));
    Feature q = *Pick(draft, FeatureKind::kPoint);
    const auto distance = [&](const Feature& f) {
      // In a hatch: long ones, but parallel.
      const double dx = f.position[0] - p->position[0], dy = f.position[1] - p->position[1];
      if (style_ == Style::kHatch) return std::min(std::abs(dx), std::abs(dy)) + (f.id == p->id);
      return f.id == p->id ? 9 : dx * dx + dy * dy;
    };
    for (int i = Int(0, 30); i > 0; --i) {
      const Feature r = *Pick(draft, FeatureKind::kPoint);
      if (distance(r) < distance(q)) q = r;
    }
    return Feature::Segment(id, p->id, q.id);
  }

  // Around a point by some of its nearest, in order of angle; some are no polygons.
  Feature NewPolygon(FeatureId id, const FeatureMap& draft) {
    const auto middle = Pick(draft, FeatureKind::kPoint);
    if (!middle || Chance(0.03)) return Feature::Polygon(id, {{1, 2, 3}});
    const auto offset = [&](const Feature& f, int i) {
      return f.position[i] - middle->position[i];
    };
    std::vector<Feature> corners;
    for (const auto& [other, f] : draft) {
      if (f.kind == FeatureKind::kPoint && std::isfinite(f.position[0])) corners.push_back(f);
    }
    std::sort(corners.begin(), corners.end(), [&](const Feature& a, const Feature& b) {
      return std::hypot(offset(a, 0), offset(a, 1)) < std::hypot(offset(b, 0), offset(b, 1));
    });
    if (Chance(0.7) && !corners.empty()) corners.erase(corners.begin());
    corners.resize(std::min<std::size_t>(corners.size(), static_cast<std::size_t>(Int(3, 6))));
    std::sort(corners.begin(), corners.end(), [&](const Feature& a, const Feature& b) {
      return std::atan2(offset(a, 1), offset(a, 0)) < std::atan2(offset(b, 1), offset(b, 0));
    });
    Rings rings(1);
    for (const Feature& f : corners) rings[0].push_back(f.id);
    if (Chance(0.03)) rings.push_back(rings[0]);
    if (Chance(0.02) && !corners.empty()) rings[0].push_back(corners[0].id);
    if (const auto other = Pick(draft, FeatureKind::kPolygon); other && Chance(0.2)) {
      rings.push_back(other->rings[0]);
    }
    return Feature::Polygon(id, rings);
  }

  void Append(FeatureMap& draft, EditBatch& batch) {
    if (polygons_ && Chance(0.2)) {
      const auto old = Pick(draft, FeatureKind::kPolygon);
      Edit edit = old && Chance(0.3) ? Edit::Set(NewPolygon(old->id, draft))
                                     : Edit::Add(NewPolygon(FreeId(draft), draft));
      edit.feature.unsplit = marks_ && Chance(0.3);
      draft[edit.feature.id] = edit.feature;
      batch.push_back(edit);
      return;
    }
    const int dice = Int(0, 99);
    Edit edit;
    if (dice < 38) {
      edit = Edit::Add(NewPoint(FreeId(draft), draft));
    } else if (dice < 70) {
      edit = Edit::Add(NewSegment(FreeId(draft), draft));
      edit.feature.unsplit = marks_ && Chance(0.6);
    } else if (dice < 80) {
      const auto point = Pick(draft, FeatureKind::kPoint);
      if (!point) return;
      const Point2 at = NewPlace(draft);
      edit = Edit::Move(point->id, at[0], at[1]);
    } else if (dice < 86) {
      const auto old = Pick(draft, Chance(0.5) ? FeatureKind::kPoint : FeatureKind::kSegment);
      if (!old) return;
      edit = Edit::Set(Chance(0.5) ? NewPoint(old->id, draft) : NewSegment(old->id, draft));
      if (marks_ && old->kind == FeatureKind::kSegment && Chance(0.7)) {
        edit = Edit::Set(*old);
        edit.feature.unsplit = !old->unsplit;
      }
    } else if (dice < 99) {
      RemoveSomething(draft, batch);
      return;
    } else {
      edit = Chance(0.5) ? Edit::Remove(Int(1, 400)) : Edit::Move(Int(1, 400), Real(), Real());
    }
    draft[edit.feature.id] = edit.feature;
    batch.push_back(edit);
    // Labels change no geometry, and are not to blame for it.
    if (Chance(0.1)) {
      batch.push_back(Edit::SetLabel(Chance(0.95) ? edit.feature.id : Int(1, 400), {1, "a"}));
    }
  }

  // A point goes with its segments, mostly.
  void RemoveSomething(FeatureMap& draft, EditBatch& batch) {
    const auto f = Pick(draft, polygons_ && Chance(0.4) ? FeatureKind::kPolygon
                               : Chance(0.5)            ? FeatureKind::kPoint
                                                        : FeatureKind::kSegment);
    if (!f) return;
    const FeatureId gone = f->id;
    batch.push_back(Edit::Remove(gone));
    draft.erase(gone);
    if (f->kind != FeatureKind::kPoint || Chance(0.2)) return;
    for (auto it = draft.begin(); it != draft.end();) {
      bool uses = it->second.kind == FeatureKind::kSegment &&
                  (it->second.ends[0] == gone || it->second.ends[1] == gone);
      for (const auto& ring : it->second.rings) {
        uses = uses || std::find(ring.begin(), ring.end(), gone) != ring.end();
      }
      if (uses) batch.push_back(Edit::Remove(it->first));
      it = uses ? draft.erase(it) : std::next(it);
    }
  }

  std::mt19937_64 random_;
  Style style_;
  bool polygons_, marks_;
};

// As Plc2 stores them.
std::vector<Feature> Normalized(const FeatureMap& features) {
  std::vector<Feature> result;
  for (const auto& [id, f] : features) {
    result.push_back(f.kind == FeatureKind::kPoint
                         ? Feature::Point(id, f.position[0] + 0.0, f.position[1] + 0.0)
                     : f.kind == FeatureKind::kSegment ? Feature::Segment(id, f.ends[0], f.ends[1])
                                                       : Feature::Polygon(id, f.rings));
    result.back().unsplit = f.kind != FeatureKind::kPoint && f.unsplit;
  }
  return result;
}

// The net change from one feature set to another, from their definition.
Delta<2> NaiveDelta(const FeatureMap& before, const FeatureMap& after) {
  const auto points = [](const FeatureMap& all) {
    std::map<FeatureId, PointFeature<2>> result;
    for (const Feature& f : Normalized(all)) {
      if (f.kind == FeatureKind::kPoint) {
        result[f.id] = {f.id, {{f.position[0], f.position[1]}}};
      }
    }
    return result;
  };
  const auto polygons = [](const FeatureMap& all) {
    std::map<FeatureId, PolygonFeature> result;
    for (const auto& [id, f] : all) {
      if (f.kind == FeatureKind::kPolygon) result[id] = {id, f.rings, f.unsplit};
    }
    return result;
  };
  // Segment features and edges of polygons, by owner and ends.
  const auto segments = [&](const FeatureMap& all) {
    const auto at = points(all);
    std::map<EdgeKey, SegmentFeature<2>> by_ends;
    for (const auto& [id, f] : all) {
      if (f.kind != FeatureKind::kPolygon) continue;
      for (const auto& ring : f.rings) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
          const auto [p, q] = KeyOf(ring[i], ring[(i + 1) % ring.size()]);
          SegmentFeature<2>& edge = by_ends[{p, q}];
          if (edge.id == kNoFeature) edge = {id, p, q, at.at(p).p, at.at(q).p};
          edge.polygons.push_back(id);
          edge.unsplit |= f.unsplit;
        }
      }
    }
    for (const auto& [id, f] : all) {
      if (f.kind != FeatureKind::kSegment) continue;
      SegmentFeature<2>& edge = by_ends[KeyOf(f.ends[0], f.ends[1])];
      const std::vector<FeatureId> users = edge.polygons;
      const bool unsplit = edge.unsplit || f.unsplit;
      edge = {id,    f.ends[0], f.ends[1], at.at(f.ends[0]).p, at.at(f.ends[1]).p,
              users, f.unsplit, unsplit};
    }
    std::map<std::tuple<FeatureId, FeatureId, FeatureId>, SegmentFeature<2>> result;
    for (const auto& [ends, edge] : by_ends) result[{edge.id, edge.p_id, edge.q_id}] = edge;
    return result;
  };
  const auto less = [](const auto& a, const auto& b, auto& out) {
    for (const auto& [id, f] : a) {
      if (!b.contains(id) || !(b.at(id) == f)) out.push_back(f);
    }
  };
  Delta<2> delta;
  less(points(before), points(after), delta.removed_points);
  less(points(after), points(before), delta.added_points);
  less(segments(before), segments(after), delta.removed_segments);
  less(segments(after), segments(before), delta.added_segments);
  less(polygons(before), polygons(after), delta.removed_polygons);
  less(polygons(after), polygons(before), delta.added_polygons);
  return delta;
}

struct Tally {
  int accepted = 0, refused = 0, ambiguous = 0;
  std::map<std::string, int> reasons;
};

// One script from empty. Every batch is judged by both; legal ones are committed,
// undone and committed again.
void RunScript(std::uint64_t seed, Generator::Style style, int batches, int most, bool polygons,
               bool marks, Tally& tally) {
  Generator generator(seed, style, polygons, marks);
  // So that few segments make a hub, too.
  constexpr std::uint32_t kHubDegrees[] = {FeatureIndex<2>::kHubDegree, 1, 2, 4};
  Plc2 plc(Unlimited(), kHubDegrees[seed % 4]);
  FeatureMap present;
  std::string script = "mesh dim=2 box=0,0,1,1\n";
  for (int i = 0; i < batches; ++i) {
    const EditBatch batch = generator.Batch(present, most);
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", style " << static_cast<int>(style)
                                    << ", batch " << i << "\n"
                                    << script << "# this one:\n"
                                    << ScriptOf(batch));
    const NaiveResult wanted = NaiveCheck(present, batch);
    const absl::StatusOr<Delta<2>> delta = plc.Check(batch);
    if (wanted.ambiguous) {
      ++tally.ambiguous;
      continue;
    }
    if (wanted.problem) {
      ++tally.refused;
      ++tally.reasons[wanted.problem->reason];
      ASSERT_FALSE(delta.ok()) << wanted.problem->reason;
      const std::optional<ErrorDetail> detail = GetErrorDetail(delta.status());
      ASSERT_TRUE(detail.has_value());
      ASSERT_EQ(detail->reason, wanted.problem->reason) << delta.status();
      ASSERT_EQ(detail->features, wanted.problem->features) << delta.status();
      ASSERT_EQ(detail->edit, static_cast<std::size_t>(wanted.problem->edit)) << delta.status();
      continue;
    }
    ++tally.accepted;
    ASSERT_TRUE(delta.ok()) << delta.status();
    ASSERT_EQ(*delta, NaiveDelta(present, wanted.features));
    plc.Apply(*delta);
    ASSERT_EQ(plc.Features(), Normalized(wanted.features));
    plc.Apply(delta->Inverse());
    ASSERT_EQ(plc.Features(), Normalized(present));
    const absl::StatusOr<Delta<2>> again = plc.Check(batch);
    ASSERT_TRUE(again.ok()) << again.status();
    ASSERT_EQ(*again, *delta);
    plc.Apply(*delta);
    present = wanted.features;
    script += ScriptOf(batch);
  }
}

void RunScripts(std::uint64_t first_seed, int scripts, Generator::Style style, int batches,
                int most, bool polygons = false, bool marks = false) {
  scripts = test::IsNightly() ? 4 * scripts : scripts / 2;
  Tally tally;
  for (int i = 0; i < scripts; ++i) {
    RunScript(first_seed + i, style, batches, most, polygons, marks, tally);
    if (testing::Test::HasFatalFailure()) return;
  }
  std::string reasons;
  for (const auto& [reason, count] : tally.reasons) {
    reasons += " " + reason + "=" + std::to_string(count);
  }
  std::cout << "seeds from " << first_seed << ": " << tally.accepted << " accepted, "
            << tally.refused << " refused, " << tally.ambiguous << " ambiguous;" << reasons << "\n";
  // Otherwise the scripts would test nothing.
  EXPECT_GT(tally.accepted, scripts / 2);
  EXPECT_GT(tally.refused, scripts / 2);
  EXPECT_LT(tally.ambiguous, (tally.accepted + tally.refused) / 10);
}

using Style = Generator::Style;

TEST(PlcProperty, CoarseGridScriptsAgreeWithTheOracle) {
  RunScripts(1000, 800, Style::kGrid, 40, 8);
}
TEST(PlcProperty, FineGridScriptsAgreeWithTheOracle) {
  RunScripts(20000, 400, Style::kFineGrid, 60, 10);
}
TEST(PlcProperty, ScriptsOfRandomPlacesAgreeWithTheOracle) {
  RunScripts(30000, 400, Style::kReal, 60, 10);
}
TEST(PlcProperty, ScriptsOfLongSegmentsAgreeWithTheOracle) {
  RunScripts(40000, 400, Style::kHatch, 80, 6);
}
TEST(PlcProperty, ScriptsOfClustersAgreeWithTheOracle) {
  RunScripts(50000, 300, Style::kClusters, 80, 6);
}
TEST(PlcProperty, ScriptsOfNearMissesAgreeWithTheOracle) {
  RunScripts(60000, 800, Style::kNearMisses, 60, 5);
}
// One batch, everything at once: the order of blame matters most.
TEST(PlcProperty, LargeBatchesAgreeWithTheOracle) {
  RunScripts(70000, 300, Style::kGrid, 8, 40);
  RunScripts(71000, 300, Style::kReal, 8, 60);
}

TEST(PlcProperty, ScriptsWithPolygonsAgreeWithTheOracle) {
  RunScripts(80000, 400, Style::kGrid, 40, 8, true);
  RunScripts(81000, 400, Style::kReal, 60, 8, true);
  RunScripts(82000, 300, Style::kNearMisses, 50, 6, true);
  RunScripts(83000, 300, Style::kFineGrid, 12, 25, true);
}

// The oracle does not know what to blame for the marks of polygons.
TEST(PlcProperty, ScriptsWithUnsplitSegmentsAgreeWithTheOracle) {
  RunScripts(90000, 800, Style::kGrid, 40, 6, false, true);
  RunScripts(91000, 400, Style::kFineGrid, 40, 8, false, true);
  RunScripts(92000, 400, Style::kReal, 40, 8, false, true);
  RunScripts(93000, 200, Style::kClusters, 60, 6, false, true);
  RunScripts(94000, 200, Style::kGrid, 6, 30, false, true);
}

// A set that grew by many batches and the same set entered at once have the same verdicts.
TEST(PlcProperty, AnswersDoNotDependOnHistory) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const Style style = static_cast<Style>(seed % 6);
    Generator generator(seed, style, seed % 2 == 0, seed % 3 == 0);
    Plc2 grown(Unlimited());
    FeatureMap present;
    for (int i = 0; i < 150; ++i) {
      const absl::StatusOr<Delta<2>> delta = grown.Check(generator.Batch(present, 6));
      if (!delta.ok()) continue;
      grown.Apply(*delta);
      present.clear();
      for (const Feature& f : grown.Features()) present[f.id] = f;
    }
    EditBatch all;
    for (const auto& [id, f] : present) all.push_back(Edit::Add(f));
    std::reverse(all.begin(), all.end());
    Plc2 fresh(Unlimited());
    Apply(fresh, all);
    ASSERT_EQ(fresh.Features(), grown.Features()) << "seed " << seed;
    for (int i = 0; i < 100; ++i) {
      const EditBatch batch = generator.Batch(present, 4);
      const absl::StatusOr<Delta<2>> a = grown.Check(batch), b = fresh.Check(batch);
      ASSERT_EQ(a.status(), b.status()) << "seed " << seed << "\n" << ScriptOf(batch);
      if (a.ok()) {
        ASSERT_EQ(*a, *b) << "seed " << seed << "\n" << ScriptOf(batch);
      }
    }
  }
}

}  // namespace
}  // namespace dynmesh::plc::plc_property_test
