// Ids of vertices that collide, which does not occur by chance with a hash of 64 bits. With a poor
// hash instead, an edit renames vertices all over the mesh. After every revision the diff leads a
// replica to the snapshot, and all is as from scratch, ids included.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <tuple>

#include "core/dynamic_mesh/live_mesh.h"
#include "dynmesh/slot_mesh.h"
#include "tests/support/workload.h"

namespace dynmesh::colliding_names_test {
namespace {

using test::Distribution;

// Unlike for each class and salt, and in no order.
VertexId IdOfClass(double name, std::uint64_t salt) {
  const double place[] = {name, static_cast<double>(salt)};
  return VertexIdAt(place, 2);
}

template <int kClasses>
VertexId OfFewClasses(const double* c, int dimension, std::uint64_t salt) {
  return IdOfClass(static_cast<double>(VertexIdAt(c, dimension) % kClasses), salt);
}

// Neighbours collide: all corners of most triangles are renamed at once.
VertexId OfSquare(const double* c, int dimension, std::uint64_t salt) {
  const double z = dimension == 3 ? std::floor(4 * c[2]) : 0;
  return IdOfClass(std::floor(4 * c[0]) + 100 * std::floor(4 * c[1]) + 10'000 * z, salt);
}

struct PoorHash {
  const char* name;
  VertexHash hash;
};
constexpr PoorHash kPoorHashes[] = {{"SixtyFourClasses", &OfFewClasses<64>},
                                    {"SixteenClasses", &OfFewClasses<16>},
                                    {"OneClass", &OfFewClasses<1>},
                                    {"Squares", &OfSquare}};

Mesh Canonical(Mesh mesh) {
  Canonicalize(mesh);
  return mesh;
}

// Empty if all parts and ids are the same.
std::string Differs(const Mesh& a, const Mesh& b) {
  if (!(a.vertices == b.vertices)) return "vertices differ";
  if (a.simplices != b.simplices) return "simplices differ";
  if (!(a.subsegments == b.subsegments)) return "subsegments differ";
  if (!(a.hash == b.hash)) return "hashes differ";
  return "";
}

// A mesh and a replica that follows it by diffs alone.
template <int D>
class Followed {
 public:
  Followed(const MeshOptions& options, const LiveMeshTuning& tuning)
      : tuning_(tuning), mesh_(options, tuning), replica_(*SlotMesh::FromMesh(mesh_.Snapshot())) {}

  LiveMesh<D>& mesh() { return mesh_; }

  // Empty if the replica follows `diff` and is what the features make from scratch.
  std::string Follow(const MeshDiff& diff) {
    if (const absl::Status s = replica_.Apply(diff); !s.ok()) return s.ToString();
    return Check();
  }
  std::string Check() {
    const Mesh snapshot = Canonical(mesh_.Snapshot());
    if (!(ComputeHash(snapshot) == snapshot.hash)) return "the hash is not the snapshot's";
    if (const auto d = Differs(Canonical(replica_.ToMesh()), snapshot); !d.empty()) {
      return "replica: " + d;
    }
    const Mesh fresh = Canonical(FromScratch());
    if (const auto d = Differs(fresh, snapshot); !d.empty()) return "from scratch: " + d;
    const AuditReport audit = mesh_.Audit();
    return audit.problems.empty() ? "" : audit.problems.front();
  }

 private:
  Mesh FromScratch() const {
    LiveMeshTuning tuning = tuning_;
    tuning.rebuild.at_least = 0;
    tuning.rebuild.features = -1;
    LiveMesh<D> fresh(mesh_.options(), tuning);
    EXPECT_TRUE(fresh.Apply(AddAll(mesh_.Features()), ApplyOptions{}).ok());
    return fresh.Snapshot();
  }

  LiveMeshTuning tuning_;
  LiveMesh<D> mesh_;
  SlotMesh replica_;
};

class CollidingNames : public testing::TestWithParam<std::tuple<int, Distribution>> {
 protected:
  const PoorHash& poor() const { return kPoorHashes[std::get<0>(GetParam())]; }
  template <int D>
  static MeshOptions Options() {
    MeshOptions options;
    options.dimension = D;
    if (D == 3) options.quality = kDefaultQuality3D;
    return options;
  }
  Distribution distribution() const { return std::get<1>(GetParam()); }

  template <int D>
  void Run(const LiveMeshTuning& tuning, int points, std::uint64_t seed, int revisions) {
    SCOPED_TRACE("seed " + std::to_string(seed) + ", points " + std::to_string(points));
    Followed<D> followed(Options<D>(), tuning);
    test::ScriptGenerator generator(distribution(), points, seed);
    int tries = 0;
    for (int r = 0; r < revisions; ++tries) {
      ASSERT_LT(tries, 50 * revisions) << "too many proposals were refused";
      const auto diff =
          followed.mesh().Apply(generator.Next(followed.mesh().Features()), ApplyOptions{});
      if (!diff.ok()) continue;
      ASSERT_EQ(followed.Follow(*diff), "") << "revision " << r + 1;
      ++r;
    }
  }

  // Some batches are cancelled before so many operations.
  template <int D>
  void RunCancelled(int batches, int most_operations) {
    LiveMeshTuning tuning;
    tuning.vertex_hash = poor().hash;
    tuning.rebuild.at_least = ~std::size_t{0};
    const std::uint64_t seed = 21;
    Followed<D> followed(Options<D>(), tuning);
    test::ScriptGenerator generator(distribution(), 15, seed);
    test::Random random(seed);
    int cancelled = 0, applied = 0;
    for (int i = 0; i < batches; ++i) {
      int left = random.OneIn(2) ? random.Below(most_operations) : 1'000'000;
      const auto diff = followed.mesh().Apply(generator.Next(followed.mesh().Features()),
                                              {.interrupted = [&] { return --left < 0; }});
      if (diff.ok()) {
        ++applied;
        ASSERT_EQ(followed.Follow(*diff), "") << "seed " << seed << ", batch " << i;
      } else if (absl::IsCancelled(diff.status())) {
        ++cancelled;
        ASSERT_EQ(followed.Check(), "") << "seed " << seed << ", batch " << i;
      }
    }
    EXPECT_GT(applied, batches / 13);
    EXPECT_GT(cancelled, batches / 13);
  }
};

TEST_P(CollidingNames, DiffLeadsToTheSnapshotAfterEveryRevision) {
  LiveMeshTuning tuning;
  tuning.vertex_hash = poor().hash;
  tuning.rebuild.at_least = ~std::size_t{0};
  if (DimensionOf(distribution()) == 3) {
    Run<3>(tuning, 10, 11, 4);
    tuning.global_neighbourhoods = false;
    tuning.rebuild.at_least = 8;
    return Run<3>(tuning, 30, 12, 2);
  }
  Run<2>(tuning, 6, 11, 25);
  Run<2>(tuning, 30, 12, 15);
  tuning.global_neighbourhoods = false;
  Run<2>(tuning, 30, 13, 10);
  tuning.rebuild.at_least = 8;
  Run<2>(tuning, 12, 14, 15);
}

// A cancelled batch restores every name.
TEST_P(CollidingNames, ACancelledBatchLeavesThemAsTheyWere) {
  if (DimensionOf(distribution()) == 3) {
    RunCancelled<3>(12, 300);
  } else {
    RunCancelled<2>(40, 40);
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, CollidingNames,
    testing::Combine(testing::Range(0, static_cast<int>(std::size(kPoorHashes))),
                     testing::Values(Distribution::kUniform, Distribution::kClustered,
                                     Distribution::kGrid, Distribution::kSegmentsTurned,
                                     Distribution::kDiagonals, Distribution::kParallel,
                                     Distribution::kSpaceGrid, Distribution::kTurnedGridEdges)),
    [](const auto& its) {
      return std::string(kPoorHashes[std::get<0>(its.param)].name) + NameOf(std::get<1>(its.param));
    });

}  // namespace
}  // namespace dynmesh::colliding_names_test
