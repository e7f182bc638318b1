// Random inputs and edit scripts for tests: every distribution on which the guarantees are tested.
// Deterministic for a seed, on every machine (own mapping from random bits to numbers; no libm
// except sqrt and the trigonometric functions, which differ only in last bits that do not matter to
// a test).
#ifndef DYNMESH_TESTS_SUPPORT_WORKLOAD_H_
#define DYNMESH_TESTS_SUPPORT_WORKLOAD_H_

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh::test {

enum class Distribution {
  kUniform,
  kClustered,
  kCircle,
  kGrid,            // an integer grid, cocircular everywhere
  kLine,            // equally spaced on a line, spacing not exact
  kDyadicLine,      // the same with exact spacing
  kTwoScale,        // pairs at 2^-40
  kSegmentsAxis,    // segments at right angles, axis-parallel, on a grid
  kSegmentsTurned,  // the same, turned
  kDiagonals,       // squares and their diagonals: 45 degrees, cocircular
  kParallel,        // segments close to each other and points close to them: cascades of splits
  kWedges,          // fans of segments at angles down to 0.002 degrees, some acute at both ends
  kSized,           // a few points and segments among sizing features of all shapes
  kPolygons,        // polygons that share edges, lie in each other, have holes; some sizing
  kCapsules,        // a few points and segments among sizing capsules and discs
  // 3D.
  kSpaceUniform,
  kSpaceClustered,
  kSpaceGrid,  // cospherical everywhere
  kSphere,
  kLineAndCircle,    // a quadratic number of tetrahedra between the two
  kSpaceTwoScale,    // a grid, half of it shifted by 2^-30
  kGridEdges,        // segments at right angles
  kTurnedGridEdges,  // the same, turned
  kSpaceSized,       // a few points and segments among sizing features of all shapes
  kSkewGridEdges,    // segments that meet at 60 to 90 degrees
  kSpaceCapsules,    // a few points and segments among sizing capsules and balls
};
inline constexpr Distribution kAllDistributions[] = {  // 2D
    Distribution::kUniform,   Distribution::kClustered,    Distribution::kCircle,
    Distribution::kGrid,      Distribution::kLine,         Distribution::kDyadicLine,
    Distribution::kTwoScale,  Distribution::kSegmentsAxis, Distribution::kSegmentsTurned,
    Distribution::kDiagonals, Distribution::kParallel,     Distribution::kWedges,
    Distribution::kSized,     Distribution::kPolygons,     Distribution::kCapsules};
inline constexpr Distribution kSpaceDistributions[] = {
    Distribution::kSpaceUniform,  Distribution::kSpaceClustered,  Distribution::kSpaceGrid,
    Distribution::kSphere,        Distribution::kLineAndCircle,   Distribution::kSpaceTwoScale,
    Distribution::kGridEdges,     Distribution::kTurnedGridEdges, Distribution::kSpaceSized,
    Distribution::kSkewGridEdges, Distribution::kSpaceCapsules};
inline int DimensionOf(Distribution d) { return d < Distribution::kSpaceUniform ? 2 : 3; }
std::string NameOf(Distribution d);
bool HasSegments(Distribution d);
// The points that a feature needs: ends or corners.
std::vector<FeatureId> PointsOf(const Feature& feature);

class Random {
 public:
  explicit Random(std::uint64_t seed) : bits_(seed) {}
  double Unit() { return static_cast<double>(bits_() >> 11) * 0x1p-53; }
  int Below(int n) { return static_cast<int>(bits_() % static_cast<std::uint64_t>(n)); }
  bool OneIn(int n) { return Below(n) == 0; }

 private:
  std::mt19937_64 bits_;
};

// A polyline with up to `most` edges about as long as `length`, in the unit square or cube. Some
// are in one line, some go there and back, some close.
Path RandomPath(Random& random, int dimension, double length, int most);

// Features in the unit square or cube, about `n` points of a distribution; ids from 1. Valid
// input, unless two random points happen to coincide.
std::vector<Feature> MakeFeatures(Distribution d, int n, std::uint64_t seed);

// Makes random batches around the features present: adds, removals, moves, several at
// once, now and then all features at once. What it proposes may be refused.
class ScriptGenerator {
 public:
  // `n`: about how many points there should be.
  ScriptGenerator(Distribution d, int n, std::uint64_t seed);

  EditBatch Next(const std::vector<Feature>& present);

 private:
  Edit RandomEdit(const std::vector<Feature>& present, EditBatch& batch);
  Feature FreshPoint();

  int n_;
  int dimension_;
  Random random_;
  std::vector<Feature> pool_;  // what there might be
  FeatureId next_id_ = 1'000'000;
};

// One script, as text that the edit-script reader takes: for shrunk cases.
std::string ToScript(const MeshOptions& options, const std::vector<EditBatch>& batches);

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_SUPPORT_WORKLOAD_H_
