// Traces as data, against what defines them: what was read was made before; the operations after a
// batch are those of a run from scratch; what ran again had a cause, and what did not is the same.
#include "dynmesh/trace.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "core/base/text.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/error.h"
#include "tests/support/seed.h"

namespace dynmesh::trace_test {
namespace {

using Fate = TraceOperation::Fate;

std::string TextOf(const Trace& trace, std::uint32_t vertex) {
  const auto& p = trace.vertices[vertex].position;
  return text::Concat("(", p[0], ", ", p[1], ", ", p[2], ")");
}

// What an operation is, by value.
std::string IdentityOf(const Trace& trace, const TraceOperation& operation) {
  std::string all = text::Concat(operation.procedure, " ", operation.bucket, "/", operation.round,
                                 "/", operation.step ? text::Concat(*operation.step) : "q");
  for (const std::uint32_t v : operation.item) all += " " + TextOf(trace, v);
  return all;
}

std::string Joined(std::multiset<std::string> parts) {
  std::string all;
  for (const std::string& part : parts) all += " " + part;
  return all;
}

std::string TextOf(const Trace& trace, const std::vector<TraceOutput>& made) {
  std::multiset<std::string> parts;
  for (const TraceOutput& output : made) {
    parts.insert(text::Concat(static_cast<int>(output.what), TextOf(trace, output.ends[0]),
                              TextOf(trace, output.ends[1])));
  }
  return Joined(parts);
}

// What it is, makes, requests, and reads. Which of several witnesses a check has read is not
// determined, so only stars are compared.
std::string WholeOf(const Trace& trace, const TraceOperation& operation) {
  std::multiset<std::string> requests, reads;
  for (const std::uint32_t r : operation.requests) {
    requests.insert(IdentityOf(trace, trace.operations[r]));
  }
  if (operation.procedure == "Complete") {
    for (const std::uint32_t v : operation.reads) reads.insert(TextOf(trace, v));
  }
  return text::Concat(IdentityOf(trace, operation), " makes", TextOf(trace, operation.made),
                      " requests", Joined(requests), " reads", Joined(reads));
}

template <class Of>
std::multiset<std::string> AllBut(Fate fate, const Trace& trace, Of of) {
  std::multiset<std::string> all;
  for (const TraceOperation& operation : trace.operations) {
    if (operation.fate != fate) all.insert(of(trace, operation));
  }
  return all;
}

// What was read is of the input, or an operation made it that is not later. Requests are later.
void CheckOrder(const Trace& trace) {
  std::map<std::uint32_t, std::size_t> maker;
  for (std::size_t i = 0; i < trace.operations.size(); ++i) {
    const TraceOperation& operation = trace.operations[i];
    for (const std::uint32_t r : operation.requests) ASSERT_LT(i, r);
    for (const std::uint32_t c : operation.cells) ASSERT_LT(c, trace.cells.size());
    if (operation.fate == Fate::kRemoved) continue;
    for (const TraceOutput& output : operation.made) {
      if (output.what != TraceOutput::What::kVertex) continue;
      ASSERT_FALSE(trace.vertices[output.ends[0]].is_input);
      ASSERT_TRUE(maker.try_emplace(output.ends[0], i).second) << "two operations made a vertex";
    }
    for (const auto* named : {&operation.reads, &operation.item}) {
      for (const std::uint32_t v : *named) {
        ASSERT_TRUE(trace.vertices[v].is_input || maker.contains(v))
            << IdentityOf(trace, operation) << " reads " << TextOf(trace, v);
      }
    }
  }
}

std::multiset<std::tuple<TraceOutput::What, std::uint32_t, std::uint32_t>> OutputsOf(
    const std::vector<TraceOutput>& made) {
  std::multiset<std::tuple<TraceOutput::What, std::uint32_t, std::uint32_t>> outputs;
  for (const TraceOutput& o : made) outputs.emplace(o.what, o.ends[0], o.ends[1]);
  return outputs;
}

void CheckCauses(const Trace& trace) {
  for (std::size_t i = 0; i < trace.operations.size(); ++i) {
    const TraceOperation& operation = trace.operations[i];
    if (operation.fate != Fate::kRerun) {
      ASSERT_FALSE(operation.because.has_value());
      ASSERT_TRUE(operation.made_before.empty());
      continue;
    }
    if (!operation.because) continue;  // of the input
    ASSERT_LT(*operation.because, i) << "a cause is earlier";
    const TraceOperation& cause = trace.operations[*operation.because];
    ASSERT_NE(cause.fate, Fate::kKept);
    if (cause.fate == Fate::kRerun) {
      // By vertex, not by position: one that is made with other properties is another one.
      ASSERT_NE(OutputsOf(cause.made), OutputsOf(cause.made_before));
    }
  }
}

// The features after the batch. REQUIRES: the batch is valid.
std::vector<Feature> After(const std::vector<Feature>& features, const EditBatch& batch,
                           const MeshOptions& options, std::uint64_t* operations) {
  auto mesh = *DynamicMesh::Create(options);
  EditBatch all;
  for (const Feature& feature : features) all.push_back(Edit::Add(feature));
  EXPECT_TRUE(mesh->Apply(all).ok());
  EXPECT_TRUE(mesh->Apply(batch).ok());
  *operations = mesh->Stats().operations;
  return mesh->Features();
}

struct Seen {
  std::size_t rerun = 0, caused = 0, added = 0, removed = 0;
};

void CheckTrace(const std::vector<Feature>& features, const EditBatch& batch,
                const MeshOptions& options, Seen* seen) {
  std::uint64_t operations = 0;
  const std::vector<Feature> after_features = After(features, batch, options, &operations);
  const auto trace = TraceOf(features, batch, options);
  const auto before = TraceOf(features, {}, options), after = TraceOf(after_features, {}, options);
  ASSERT_TRUE(trace.ok()) << trace.status();
  ASSERT_TRUE(before.ok() && after.ok());
  ASSERT_EQ(before->Count(Fate::kKept), before->operations.size()) << "nothing was changed";
  ASSERT_EQ(trace->operations.size() - trace->Count(Fate::kRemoved), operations);
  CheckOrder(*trace);
  CheckCauses(*trace);
  ASSERT_EQ(AllBut(Fate::kAdded, *trace, IdentityOf), AllBut(Fate::kAdded, *before, IdentityOf));
  ASSERT_EQ(AllBut(Fate::kRemoved, *trace, WholeOf), AllBut(Fate::kRemoved, *after, WholeOf));
  const std::multiset<std::string> was = AllBut(Fate::kAdded, *before, WholeOf);
  for (const TraceOperation& operation : trace->operations) {
    if (operation.fate == Fate::kKept) {
      ASSERT_TRUE(was.contains(WholeOf(*trace, operation))) << WholeOf(*trace, operation);
    }
    seen->caused += operation.because.has_value() ? 1 : 0;
  }
  seen->rerun += trace->Count(Fate::kRerun);
  seen->added += trace->Count(Fate::kAdded);
  seen->removed += trace->Count(Fate::kRemoved);
}

class TraceTest : public ::testing::Test {
 protected:
  double Coordinate() { return 0.05 + 0.9 * static_cast<double>(random_() % 1'000'003) / 1e6; }
  Feature RandomPoint(FeatureId id, int dimension) {
    const double x = Coordinate(), y = Coordinate();
    return dimension == 2 ? Feature::Point(id, x, y) : Feature::Point(id, x, y, Coordinate());
  }
  std::vector<Feature> RandomPoints(std::size_t count, int dimension) {
    std::vector<Feature> points;
    for (FeatureId id = 1; id <= count; ++id) points.push_back(RandomPoint(id, dimension));
    return points;
  }
  void CheckPoints(const MeshOptions& options, std::size_t count) {
    Seen seen;
    const std::vector<Feature> points = RandomPoints(count, options.dimension);
    for (const EditBatch& batch :
         {EditBatch{Edit::Add(RandomPoint(100, options.dimension))}, EditBatch{Edit::Remove(1)},
          EditBatch{Edit::Remove(2), Edit::Add(RandomPoint(100, options.dimension))}}) {
      ASSERT_NO_FATAL_FAILURE(CheckTrace(points, batch, options, &seen));
    }
    EXPECT_GT(seen.rerun, 0u);
    EXPECT_GT(seen.caused, 0u);
    EXPECT_GT(seen.added, 0u);
    EXPECT_GT(seen.removed, 0u);
  }

  std::mt19937_64 random_{test::NewSeed()};
};

TEST_F(TraceTest, OfPointsIsThatOfARunFromScratchWithCauses) {
  for (const std::size_t count : {3u, 12u, 60u}) CheckPoints(MeshOptions(), count);
}

TEST_F(TraceTest, InThreeDimensionsToo) {
  MeshOptions options;
  options.dimension = 3;
  CheckPoints(options, 4);
}

TEST_F(TraceTest, OfCuresToo) {
  MeshOptions options;
  options.dimension = 3;
  options.min_dihedral = 5;
  Seen seen;
  for (const std::uint64_t seed : {random_(), std::uint64_t{460204754}}) {
    SCOPED_TRACE(seed);
    random_.seed(seed);
    ASSERT_NO_FATAL_FAILURE(CheckTrace(RandomPoints(6, 3), {Edit::Remove(1)}, options, &seen));
  }
  EXPECT_GT(seen.rerun, 0u);
}

TEST_F(TraceTest, OfSegmentsAndSizesToo) {
  const std::vector<Feature> features = {Feature::Point(1, 0.2, 0.3), Feature::Point(2, 0.8, 0.35),
                                         Feature::Point(3, 0.5, 0.39), Feature::Segment(4, 1, 2),
                                         Feature::Point(5, 0.3, 0.8)};
  Seen seen;
  ASSERT_NO_FATAL_FAILURE(CheckTrace(features, {Edit::Remove(4)}, MeshOptions(), &seen));
  ASSERT_NO_FATAL_FAILURE(
      CheckTrace(features, {Edit::Add(Feature::Segment(6, 2, 5))}, MeshOptions(), &seen));
  ASSERT_NO_FATAL_FAILURE(
      CheckTrace(features, {Edit::Add(Feature::SizeAt(7, 0.6, 0.6, 0.02))}, MeshOptions(), &seen));
  EXPECT_GT(seen.caused, 0u);
}

TEST_F(TraceTest, OfTheBareBox) {
  const auto trace = TraceOf({}, {}, MeshOptions());
  ASSERT_TRUE(trace.ok()) << trace.status();
  EXPECT_GT(trace->operations.size(), 0u);
  EXPECT_EQ(trace->Count(Fate::kKept), trace->operations.size());
}

TEST_F(TraceTest, RefusesWhatItCannotTake) {
  const auto reason = [](const auto& result) {
    const auto detail = GetErrorDetail(result.status());
    return detail ? detail->reason : "";
  };
  MeshOptions quadtree;
  quadtree.kind = MeshKind::kQuadtree;
  EXPECT_EQ(reason(TraceOf({}, {}, quadtree)), reason::kBadOption);
  const std::vector<Feature> points = RandomPoints(50, 2);
  EXPECT_EQ(reason(TraceOf(points, {Edit::Remove(51)}, MeshOptions())), reason::kUnknownFeature);
  const std::uint64_t all = TraceOf(points, {}, MeshOptions())->operations.size();
  TraceOptions few;
  few.max_operations = all;
  EXPECT_TRUE(TraceOf(points, {}, MeshOptions(), few).ok());
  few.max_operations = all - 1;
  EXPECT_EQ(reason(TraceOf(points, {}, MeshOptions(), few)), reason::kWorkLimit);
  few.max_operations = 20;
  EXPECT_EQ(reason(TraceOf(points, {}, MeshOptions(), few)), reason::kWorkLimit);
  TraceOptions given_up;
  given_up.interrupted = [] { return true; };
  EXPECT_EQ(reason(TraceOf(points, {}, MeshOptions(), given_up)), reason::kCancelled);
}

}  // namespace
}  // namespace dynmesh::trace_test
