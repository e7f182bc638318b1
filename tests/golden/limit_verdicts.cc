// Verdicts on batches that exceed limits, are cancelled, or make ids collide.
#include <array>
#include <random>
#include <utility>

#include "tests/golden/verdict_scene.h"
#include "tests/support/crafted.h"
#include "tests/support/polygon_script.h"

namespace dynmesh::test {
namespace {

// For meshes of few vertices, so that small features demand too many.
constexpr Item kPlanarDemands[] = {
    {"region", "add size 30 box 0 0 1 1 0.001953125"},
    {"region, disc", "add size 30 disc 0.5 0.5 0.25 0.001953125"},
    {"region, capsule", "add size 30 capsule 0.25 0.25 0.75 0.5 0.75 0.75 0.125 0.001953125"},
    {"region that fits", "add size 30 box 0 0 1 1 0.0625"},
    {"regions together",
     "add size 30 box 0 0 0.5 0.5 0.015625; add size 31 box 0.5 0.5 1 1 0.0155; add size 32 "
     "polygon 1 2 33 0.015625; add point 33 0.5 0; add size 34 disc 0.25 0.75 0.25 0.015625"},
    {"segments close together",
     "add point 30 0.125 0.50000001; add point 31 0.875 0.50000001; add segment 32 30 31"},
    {"segments close together, moved",
     "add point 30 0.125 0.625; add point 31 0.875 0.625; add segment 32 30 31; move point 30 "
     "0.125 0.50000001; move point 31 0.875 0.50000001"},
    {"pairs of segments",
     "add point 30 0.125 0.50006; add point 31 0.875 0.50006; add segment 32 30 31; add point 33 "
     "0.125 0.25; add point 34 0.875 0.25; add segment 35 33 34; add point 36 0.125 0.25006; add "
     "point 37 0.875 0.25006; add segment 38 36 37"},
};
constexpr Item kSpaceDemands[] = {
    {"region", "add size 30 box 0 0 0 1 1 1 0.015625"},
    {"region, ball", "add size 30 disc 0.5 0.5 0.5 0.25 0.001953125"},
    {"region, capsule", "add size 30 capsule 0.25 0.5 0.5 0.75 0.5 0.5 0.125 0.001953125"},
    {"segments close together",
     "add point 30 0.125 0.125 0.87500001; add point 31 0.875 0.125 0.87500001; add segment 32 "
     "30 31"},
    {"polygons close together",
     "add point 30 0.125 0.125 0.500001; add point 31 0.875 0.125 0.500001; add point 32 0.875 "
     "0.875 0.500001; add point 33 0.125 0.875 0.500001; add polygon 34 30 31 32 33"},
};

void AddDemands(std::vector<std::string>& lines) {
  MeshOptions options;
  options.limits.max_vertices = 1000;
  Scene(&lines, "demand 2D", options,
        Batch("add point 1 0.125 0.5; add point 2 0.875 0.5; add segment 3 1 2", 2))
      .Validate(kPlanarDemands);
  options = CubeOptions();
  options.limits.max_vertices = 2000;
  Scene(&lines, "demand 3D", options, Batch(kPlate, 3)).Validate(kSpaceDemands);
}

// The spokes of a wheel: points 1 and from 100 on. Without sines: along the sides of a square.
EditBatch Spokes(int count) {
  EditBatch batch = {Edit::Add(Feature::Point(1, 0.5, 0.5))};
  for (int i = 0; i < count; ++i) {
    const double along = 0.25 + 0.5 * (i / 4) / (count / 4);
    const double x = i % 4 == 0 ? along : i % 4 == 1 ? 0.75 : i % 4 == 2 ? 1 - along : 0.25;
    const double y = i % 4 == 0 ? 0.25 : i % 4 == 1 ? along : i % 4 == 2 ? 0.75 : 1 - along;
    const auto id = static_cast<FeatureId>(i);
    batch.push_back(Edit::Add(Feature::Point(100 + id, x, y)));
    batch.push_back(Edit::Add(Feature::Segment(300 + id, 1, 100 + id)));
  }
  return batch;
}

// What a run of `dimension` exceeds, or is ended by.
void AddRuns(std::vector<std::string>& lines, int dimension) {
  const std::string in = " " + std::to_string(dimension) + "D";
  const std::string z = dimension == 3 ? " 0.5" : "";
  const EditBatch segment =
      Batch("add point 1 0.125 0.5" + z + "; add point 2 0.875 0.5" + z + "; add segment 3 1 2",
            dimension);
  const EditBatch beside = Batch("add point 4 0.3125 0.5078125" + z, dimension);
  MeshOptions options;
  options.dimension = dimension;
  options.quality = DefaultQuality(dimension);
  Scene usual(&lines, "limits" + in, options, segment);
  ApplyOptions few, interrupted, vetoed;
  few.max_operations = 3;
  interrupted.interrupted = [] { return true; };
  vetoed.commit = [](const MeshDiff&) { return absl::DataLossError("the journal is full"); };
  usual.Apply("max_operations", beside, few);
  usual.Apply("interrupted", beside, interrupted);
  usual.Apply("refused by commit", beside, vetoed);
  usual.Apply("none", beside);
  options.limits.max_depth = 2;
  Scene(&lines, "limits" + in, options, segment).Apply("max_depth", beside);
  options.limits = {};
  options.limits.max_vertices = dimension == 2 ? 140 : 600;
  EditBatch points;
  for (FeatureId i = 0; i < 100; ++i) {
    const double x = (static_cast<double>(i) + 0.5) / 128;
    const double y = (static_cast<double>(i * i % 31) + 0.25) / 32;
    points.push_back(Edit::Add(Feature::Point(100 + i, x, y, 1 - y)));
  }
  Scene(&lines, "limits" + in, options, segment).Apply("max_vertices", points);
  options.limits = {};
  options.max_edge = 0x1p-5;
  const auto create = [&](const std::string& name, const ApplyOptions& apply) {
    lines.push_back("limits" + in + " create, " + name + ": " +
                    TextOf(DynamicMesh::Create(options, apply).status()));
  };
  create("interrupted", interrupted);
  create("max_operations", few);
}

// Of indices, and of the polygons at a place.
void AddSizeLimits(std::vector<std::string>& lines) {
  LiveMeshTuning tuning = AlwaysPropagate();
  tuning.engine_limits.reads = 60;
  Scene(&lines, "limits 2D", {}, {}, tuning).Apply("reads of an operation", Spokes(80));
  tuning = AlwaysPropagate();
  tuning.most_tetrahedra = 4000;
  EditBatch many;
  for (FeatureId i = 0; i < 120; ++i) {
    const auto at = [&](FeatureId step) { return static_cast<double>(i * step % 121) / 128; };
    many.push_back(Edit::Add(Feature::Point(100 + i, at(1), at(17), at(47))));
  }
  Scene(&lines, "limits 3D", CubeOptions(), {}, tuning).Apply("tetrahedra", many);

  EditBatch square = Batch(
      "add point 1 0.25 0.25; add point 2 0.75 0.25; add point 3 0.75 0.75; add point 4 "
      "0.25 0.75",
      2);
  for (FeatureId i = 0; i <= kMostPolygonsAtAPlace; ++i) {
    square.push_back(Edit::Add(Feature::Polygon(10 + i, {{1, 2, 3, 4}})));
  }
  Scene scene(&lines, "limits 2D", {});
  scene.Apply("polygons at a place", square);
  square.pop_back();
  scene.Apply("most polygons at a place", square);
}

// Ids made for their hashes (crafted.h).
void AddCollisions(std::vector<std::string>& lines) {
  const auto other = AnyPairOfRegionId(RegionIdOf(std::vector<FeatureId>{1, 2}), 3);
  const auto reserved = AnyPairOfRegionId(~RegionId{0}, 1000);
  const auto squares = [](FeatureId a, FeatureId b, FeatureId first, double x) {
    const auto at = [&](FeatureId id, double dx, double y) {
      return Edit::Add(Feature::Point(id, x + dx, y));
    };
    const Rings rings = {{first, first + 1, first + 2, first + 3}};
    return EditBatch{at(first, -0.125, 0.375),
                     at(first + 1, 0.125, 0.375),
                     at(first + 2, 0.125, 0.625),
                     at(first + 3, -0.125, 0.625),
                     Edit::Add(Feature::Polygon(a, rings)),
                     Edit::Add(Feature::Polygon(b, rings))};
  };
  Scene planar(&lines, "collision 2D", {}, squares(1, 2, 101, 0.25));
  planar.Apply("regions", squares(other[0], other[1], 201, 0.75));
  planar.Apply("reserved region", squares(reserved[0], reserved[1], 201, 0.75));

  std::mt19937_64 random(3);
  const auto at = [&](VertexId id) {
    return PlaceOfHash<2>(
        KeyOfVertexIds(0), [&] { return id; }, random);
  };
  std::array<double, 2> p = at(123456789), q = at(123456789);
  if (q < p) std::swap(p, q);  // so that q is salted
  const std::array<double, 2> r = at(VertexIdAt(q.data(), 2, 1));
  Scene(&lines, "collision 2D", {})
      .Apply("vertices",
             {Edit::Add(Feature::Point(1, p[0], p[1])), Edit::Add(Feature::Point(2, q[0], q[1])),
              Edit::Add(Feature::Point(3, r[0], r[1]))});

  const Solid solid = MakeCuboid(0.5, 0.5, 0.5);
  const auto box = [&](FeatureId least, FeatureId first, double x, double size) {
    EditBatch batch;
    for (std::size_t i = 0; i < solid.corners.size(); ++i) {
      const auto& c = solid.corners[i];
      batch.push_back(Edit::Add(
          Feature::Point(first + i, x + size * c[0], 0.5 + size * c[1], 0.5 + size * c[2])));
    }
    for (std::size_t f = 0; f < solid.faces.size(); ++f) {
      Rings rings = solid.faces[f][0];
      for (FeatureId& corner : rings[0]) corner += first;
      batch.push_back(
          Edit::Add(Feature::Polygon(f == 0 ? least : kLastPolygonId - first - f, rings)));
    }
    return batch;
  };
  Scene(&lines, "collision 3D", CubeOptions())
      .Apply("surfaces", box(1, 101, 0.25, 0.25) + box(2, 201, 0.25, 0.125) +
                             box(other[0], 301, 0.75, 0.25) + box(other[1], 401, 0.75, 0.125));
}

}  // namespace

void AddLimitVerdicts(std::vector<std::string>& lines) {
  AddDemands(lines);
  for (const int dimension : {2, 3}) AddRuns(lines, dimension);
  AddSizeLimits(lines);
  AddCollisions(lines);
}

}  // namespace dynmesh::test
