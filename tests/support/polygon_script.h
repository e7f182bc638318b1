// Random scripts in 3D with polygons: solids bounded by polygons, plates with holes and single
// segments are added and removed, turn, grow and move as a whole, so that faces stay planar; they
// lose faces and get them back, and faces get other rings. Free points and sizing features among
// them.
//
// Each solid has a home with room for it to turn in. Its present position is derived from the
// present features, so a refused batch causes no inconsistency. Now and then it proposes a batch
// that must be refused. Deterministic for a seed.
#ifndef DYNMESH_TESTS_SUPPORT_POLYGON_SCRIPT_H_
#define DYNMESH_TESTS_SUPPORT_POLYGON_SCRIPT_H_

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "dynmesh/feature.h"
#include "tests/support/workload.h"

namespace dynmesh::test {

enum class PolygonKind {
  kNestedBoxes,  // boxes in boxes, each turned
  kPlates,       // squares above each other, parallel and tilted
  kManyBoxes,    // in a grid, some turned, some two with a face in common
  kHoled,        // plates that are not convex, with holes and in several parts; tunnels
  kSticks,       // segments alone and at right angles, and plates
  kMixture,      // of all, with free points and sizing features
  kSharp,        // triangles and segments that meet at small angles: forks, needles, fans, surfaces
};
inline constexpr PolygonKind kPolygonKinds[] = {
    PolygonKind::kNestedBoxes, PolygonKind::kPlates,  PolygonKind::kManyBoxes, PolygonKind::kHoled,
    PolygonKind::kSticks,      PolygonKind::kMixture, PolygonKind::kSharp};
std::string NameOf(PolygonKind kind);

// Corners about the origin, within a ball of radius 1; points are identified by their numbers.
struct Solid {
  using Place = std::array<double, 3>;

  std::vector<Place> corners;
  std::vector<std::vector<Rings>> faces;  // of each, the rings that it may have
  std::vector<std::pair<int, int>> segments;
};
Solid MakeCuboid(double x, double y, double z);

class PolygonScript {
 public:
  // About `n` solids, in the unit cube.
  PolygonScript(PolygonKind kind, int n, std::uint64_t seed);

  EditBatch Next(const std::vector<Feature>& present);

 private:
  using Place = Solid::Place;
  using Present = std::map<FeatureId, Feature>;
  struct Home {
    Solid solid;
    Place centre;
    double size;  // radius of the ball about the solid
    bool turns;   // any way; else a little
  };

  FeatureId PointId(std::size_t k, std::size_t i) const { return 1000 * (k + 1) + i; }
  FeatureId FaceId(std::size_t k, std::size_t f) const { return 1000 * (k + 1) + 500 + f; }
  FeatureId SegmentId(std::size_t k, std::size_t s) const { return 1000 * (k + 1) + 800 + s; }

  std::size_t AnyHome() {
    return static_cast<std::size_t>(random_.Below(static_cast<int>(homes_.size())));
  }
  void Settle(PolygonKind kind, int n);
  Solid AnySolid(PolygonKind kind);
  std::vector<Place> PlacesOf(const Home& home);
  Feature Face(std::size_t k, std::size_t f);
  void Come(std::size_t k, EditBatch& batch);
  void Go(std::size_t k, const Present& present, EditBatch& batch) const;
  void Move(std::size_t k, const std::vector<Place>& places, EditBatch& batch) const;
  void ChangeFace(std::size_t k, const Present& present, bool other_rings, EditBatch& batch);
  void EditSolid(std::size_t k, const Present& present, EditBatch& batch);
  void MoveCorner(std::size_t k, const Present& present, EditBatch& batch);
  void BreakARule(std::size_t k, const Present& present, EditBatch& batch);
  void EditFree(const Present& present, EditBatch& batch);

  Random random_;
  std::vector<Home> homes_;
  int free_part_;  // one edit in so many is of a free point or a size
  bool sized_;
  bool moves_corners_;  // one at a time: faces are triangles
  FeatureId next_id_ = 1'000'000;
};

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_SUPPORT_POLYGON_SCRIPT_H_
