// After every revision each operation of the trace, executed again as of its time, makes, requests
// and reads what its record says. So no filter of notifications has missed a change. A failure
// names the first operation that a change should have made stale.
//
// DYNMESH_NIGHTLY=1 runs long scripts.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>

#include "core/dynamic_mesh/live_mesh.h"
#include "tests/support/polygon_script.h"
#include "tests/support/workload.h"

namespace dynmesh::test::reproduction_test {
namespace {

// How many times as many seeds.
int Times() {
  const char* const nightly = std::getenv("DYNMESH_NIGHTLY");
  return nightly != nullptr && *nightly != '0' ? 40 : 1;
}

LiveMeshTuning AlwaysPropagate() {
  LiveMeshTuning tuning;
  tuning.rebuild.at_least = ~std::size_t{0};
  tuning.rebuild.at_least_work = ~std::uint64_t{0};
  return tuning;
}

template <int D, class Generator>
void ExpectReproducible(Generator generator, const MeshOptions& options, int revisions,
                        const std::string& what) {
  SCOPED_TRACE(what);
  LiveMesh<D> mesh(options, AlwaysPropagate());
  for (int done = 0, tries = 0; done < revisions && tries < 20 * revisions; ++tries) {
    const EditBatch batch = generator.Next(mesh.Features());
    if (batch.empty() || !mesh.Apply(batch, ApplyOptions{}).ok()) continue;
    ++done;
    ASSERT_EQ(mesh.FirstUnreproduced(), "") << "revision " << done;
  }
}

MeshOptions OptionsOf(Distribution d, int seed) {
  MeshOptions options;
  options.dimension = DimensionOf(d);
  constexpr double kQualities[][3] = {{kDefaultQuality2D, 2, 1.2}, {2, 1.5, 3}};
  options.quality = kQualities[options.dimension - 2][seed % 3];
  return options;
}

class Reproduction : public testing::TestWithParam<Distribution> {};

TEST_P(Reproduction, OfEveryOperationAfterEveryRevision) {
  const Distribution d = GetParam();
  const int seeds = Times() * (DimensionOf(d) == 2 ? 4 : 2);
  for (int seed = 1; seed <= seeds; ++seed) {
    const MeshOptions options = OptionsOf(d, seed);
    const std::string what = NameOf(d) + ", seed " + std::to_string(seed);
    if (options.dimension == 2) {
      ExpectReproducible<2>(ScriptGenerator(d, 16, seed), options, 8, what);
    } else {
      ExpectReproducible<3>(ScriptGenerator(d, 12, seed), options, 3, what);
    }
  }
}

const auto kName = [](const auto& info) { return NameOf(info.param); };
INSTANTIATE_TEST_SUITE_P(InPlane, Reproduction, testing::ValuesIn(kAllDistributions), kName);
INSTANTIATE_TEST_SUITE_P(InSpace, Reproduction, testing::ValuesIn(kSpaceDistributions), kName);

TEST(Reproduction, ByTheThesissCriterion) {
  MeshOptions options;
  options.criterion = Criterion::kThesis;
  MeshOptions in_space = options;
  in_space.dimension = 3;
  in_space.quality = 2.5;
  for (int seed = 1; seed <= Times(); ++seed) {
    for (const Distribution d :
         {Distribution::kUniform, Distribution::kGrid, Distribution::kSegmentsTurned,
          Distribution::kWedges, Distribution::kSized}) {
      ExpectReproducible<2>(ScriptGenerator(d, 10, seed), options, 6,
                            NameOf(d) + ", seed " + std::to_string(seed));
    }
    for (const Distribution d : {Distribution::kSpaceUniform, Distribution::kGridEdges}) {
      ExpectReproducible<3>(ScriptGenerator(d, 6, seed), in_space, 2,
                            NameOf(d) + ", seed " + std::to_string(seed));
    }
  }
}

TEST(Reproduction, WithCures) {
  MeshOptions options;
  options.dimension = 3;
  options.quality = 2;
  options.min_dihedral = 12;
  for (int seed = 1; seed <= Times(); ++seed) {
    const std::string with_seed = ", seed " + std::to_string(seed);
    for (const Distribution d : {Distribution::kSpaceUniform, Distribution::kSphere,
                                 Distribution::kTurnedGridEdges, Distribution::kSpaceSized}) {
      ExpectReproducible<3>(ScriptGenerator(d, 12, seed), options, 3, NameOf(d) + with_seed);
    }
    ExpectReproducible<3>(PolygonScript(PolygonKind::kMixture, 1, seed), options, 2,
                          "polygons" + with_seed);
  }
}

class ReproductionOfPolygons : public testing::TestWithParam<PolygonKind> {};

TEST_P(ReproductionOfPolygons, OfEveryOperationAfterEveryRevision) {
  MeshOptions options;
  options.dimension = 3;
  options.quality = 2;
  const bool is_large =
      GetParam() == PolygonKind::kManyBoxes || GetParam() == PolygonKind::kNestedBoxes;
  for (int seed = 1; seed <= Times(); ++seed) {
    ExpectReproducible<3>(PolygonScript(GetParam(), is_large ? 1 : 2, seed), options, 3,
                          "seed " + std::to_string(seed));
  }
}

INSTANTIATE_TEST_SUITE_P(InSpace, ReproductionOfPolygons, testing::ValuesIn(kPolygonKinds), kName);

}  // namespace
}  // namespace dynmesh::test::reproduction_test
