// Verdicts on 3D batches.
#include "tests/golden/verdict_scene.h"

namespace dynmesh::test {
namespace {

constexpr Item kSpaceEdits[] = {
    {"id of a polygon", "add point 10 0.1 0.1 0.1"},
    {"move polygon", "move point 10 0.1 0.1 0.1"},
    {"move segment", "move point 11 0.1 0.1 0.1"},
    {"outside", "add point 30 0.5 0.5 1.5"},
    {"end unknown", "add segment 30 1 40"},
    {"end is a polygon", "add segment 30 1 10"},
    {"ends equal", "add segment 30 1 1"},
    {"in use", "remove 3"},
    {"polygon, corners unknown", "add polygon 30 1 77 78"},
    {"polygon of two points", "add polygon 30 1 2"},
    {"polygon, point twice", "add polygon 30 1 2 3 1"},
    {"polygon, edge twice", "add polygon 30 1 2 3 / 2 5 3"},
    {"size outside", "add size 30 point 0.5 0.5 1.5 0.1"},
    {"size ball outside", "add size 30 disc 0.5 0.5 -0.125 0.5 0.1"},
    {"size box outside", "add size 30 box 0 0 1.5 1 1 2 0.1"},
    {"size box swapped", "add size 30 box 0 0 0.5 1 1 0.375 0.1"},
    {"size box", "add size 30 box 0 0 0.5 1 1 1.5 0.1"},
    {"size target 0", "add size 30 point 0.5 0.5 0.5 0"},
    {"size polygon", "add size 30 polygon 1 2 3 0.1"},
    {"size capsule", "add size 30 capsule 0 0 0 1 1 1 0.5 0.25 0 0.125 0.1"},
    {"size capsule outside", "add size 30 capsule 0.5 0.5 0.5 0.5 0.5 1.5 0.125 0.1"},
};

constexpr Item kSpaceConflicts[] = {
    {"duplicate point", "add point 30 0.25 0.25 0.5"},
    {"duplicate segment", "add segment 30 6 5"},
    {"segment on an edge", "add segment 30 2 1"},
    {"point on segment", "add point 30 0.5 0.125 0.875"},
    {"point on an edge", "add point 30 0.5 0.25 0.5"},
    {"segment over point",
     "add point 30 0.5 0.125 0.75; add point 31 0.5 0.125 0.9375; add point 32 0.5 0.125 0.8125; "
     "add segment 33 30 31"},
    {"close points", "add point 30 0.125 0.125 0.8750000000000002"},
    {"close to segment", "add point 30 0.5 0.125 0.8750000000000002"},
    {"close segments",
     "add point 30 0.5 0.0625 0.8750000000000002; add point 31 0.5 0.25 0.8750000000000002; add "
     "segment 32 30 31"},
    {"segments cross",
     "add point 30 0.125 0.25 0.25; add point 31 0.875 0.75 0.25; add point 32 0.125 0.75 0.25; "
     "add point 33 0.875 0.25 0.25; add segment 34 30 31; add segment 35 32 33"},
    {"segments cross in fifths",
     "add point 30 0.125 0.25 0.1875; add point 31 0.875 0.625 0.421875; add point 32 0.125 0.5 "
     "0.21875; add point 33 0.625 0.125 0.296875; add segment 34 30 31; add segment 35 32 33"},
    {"segments cross, an edge",
     "add point 30 0.5 0.125 0.5; add point 31 0.5 0.875 0.5; add segment 32 30 31"},
    {"segments overlap",
     "add point 30 0.25 0.125 0.875; add point 31 0.9375 0.125 0.875; remove 11; remove 6; add "
     "segment 32 5 31; remove 30; add point 30 0.96875 0.125 0.875; add segment 33 5 30"},
    {"angle of segments", "add point 30 0.375 0.375 0.875; add segment 31 5 30"},
    {"angle of segments, too small",
     "add point 30 0.5 0.125 0.87500152587890625; add segment 31 5 30"},
    {"angle of segments, large enough", "add point 30 0.25 0.5 0.875; add segment 31 5 30"},
    {"angle of a polygon's own edges",
     "add point 30 0 0 0; add point 31 1 0 0; add point 32 1 0.5 0; add polygon 33 30 31 32"},
    {"angle of a segment with a polygon",
     "add point 30 0.5 0.5 0.500003814697265625; add segment 31 1 30"},
    {"angle of a segment with a polygon, right", "add point 30 0.5 0.5 0.875; add segment 31 1 30"},
    {"angle of a segment beside a polygon", "add point 30 0.125 0.125 0.625; add segment 31 1 30"},
    {"angle of polygons",
     "add point 30 0.5 0.75 0.50006103515625; add point 31 0.5 0.25 0.50006103515625; add polygon "
     "32 3 2 31 "
     "30"},
    {"angle of polygons at an edge",
     "add point 30 0.25 0.75 0.50006103515625; add point 31 0.25 0.25 0.50006103515625; add "
     "polygon 32 3 2 "
     "31 30"},
    {"angle of polygons that leads over the other",
     "add point 30 0.125 0.125 0.25; add point 31 0.875 0.125 0.25; add point 32 0.875 0.875 "
     "0.25; add point 33 0.5 0.875 0.25; add point 34 0.5 0.5 0.25; add point 35 0.125 0.5 0.25; "
     "remove 10; add polygon 36 30 31 32 33 34 35; add point 37 0.75 0.5 0.250003814697265625; add "
     "point 38 "
     "0.75 0.5 0.75; add point 39 0.125 0.5 0.75; add polygon 40 35 34 37 38 39"},
    {"angle of polygons, right",
     "add point 30 0.75 0.75 0.75; add point 31 0.75 0.25 0.75; add polygon 32 3 2 31 30"},
    {"angle of polygons moved",
     "add point 30 0.75 0.75 0.75; add point 31 0.75 0.25 0.75; add polygon 32 3 2 31 30; move "
     "point 30 0.5 0.75 0.50006103515625; move point 31 0.5 0.25 0.50006103515625"},
    {"edge that leans over a polygon", "add point 30 0.734375 0.625 0.5625; add polygon 31 2 3 30"},
    {"edge that leans away", "add point 30 0.765625 0.625 0.5625; add polygon 31 2 3 30"},
    {"earliest of three", "add point 40 0.1 0.1 0.1; add point 30 0.5 0.5 0.5; remove 77"},
};

constexpr Item kFacetConflicts[] = {
    {"not flat", "move point 3 0.75 0.75 0.50000001"},
    {"flat enough", "move point 3 0.75 0.75 0.5000000001"},
    {"not flat, of many corners",
     "add point 30 0.125 0.125 0.25; add point 31 0.5 0.0625 0.25; add point 32 0.875 0.125 "
     "0.25; add point 33 0.875 0.875 0.3125; add point 34 0.5 0.9375 0.25; add point 35 0.125 "
     "0.875 0.25; add polygon 36 30 31 32 33 34 35"},
    {"corners on a line",
     "add point 30 0.125 0.125 0.25; add point 31 0.5 0.125 0.25; add point 32 0.875 0.125 0.25; "
     "add polygon 36 30 31 32"},
    {"no area",  // a square as wide as the least distance
     "add point 30 0 0 0; add point 31 9.094947017729282379e-13 0 0; add point 32 "
     "9.094947017729282379e-13 9.094947017729282379e-13 0; add point 33 0 "
     "9.094947017729282379e-13 0; add polygon 34 30 31 32 33"},
    {"duplicate polygon", "add polygon 30 3 2 1 4"},
    {"point on polygon", "add point 30 0.5 0.375 0.5"},
    {"point within rounding of polygon", "add point 30 0.5 0.375 0.5000000000000002"},
    {"point close to polygon", "add point 30 0.5 0.375 0.5000000000005"},
    {"point at 2^-40 from polygon", "add point 30 0.5 0.375 0.50000000000090949471"},
    {"segment through polygon",
     "add point 30 0.375 0.5 0.25; add point 31 0.5 0.375 0.75; add segment 32 30 31"},
    {"segment through polygon in thirds",
     "add point 30 0.375 0.5 0.25; add point 31 0.5 0.375 0.625; add segment 32 30 31"},
    {"segment in polygon", "add segment 30 1 3"},
    {"segment close to polygon",
     "add point 30 0.125 0.5 0.50000000000000025; add point 31 0.875 0.5 0.50000000000000025; "
     "add segment 32 30 31"},
    {"polygon across polygon",
     "add point 30 0.125 0.5 0.25; add point 31 0.5 0.5 0.25; add point 32 0.5 0.5 0.75; add "
     "point 33 0.125 0.5 0.75; add polygon 34 30 31 32 33"},
    {"polygons along a diagonal",
     "add point 30 0.25 0.25 0.125; add point 31 0.25 0.25 0.875; add point 32 0.75 0.75 0.125; "
     "add point 33 0.75 0.75 0.875; add polygon 34 1 31 33 3 32 30"},
    {"polygons on one side of an edge",
     "add point 30 0.75 0.9375 0.5; add point 31 0.25 0.9375 0.5; add polygon 32 1 2 30 31"},
    {"polygon on half of a polygon", "add polygon 30 1 2 3"},
    {"polygon in a polygon",
     "add point 30 0.375 0.375 0.5; add point 31 0.625 0.375 0.5; add point 32 0.625 0.625 0.5; "
     "add point 33 0.375 0.625 0.5; add polygon 34 30 31 32 33"},
    {"polygon in a hole",
     "add point 30 0.375 0.375 0.5; add point 31 0.625 0.375 0.5; add point 32 0.625 0.625 0.5; "
     "add point 33 0.375 0.625 0.5; set polygon 10 1 2 3 4 / 30 31 32 33; add polygon 34 30 31 "
     "32 33"},
    {"polygon with a hole and one without",
     "add point 30 0.375 0.375 0.5; add point 31 0.625 0.375 0.5; add point 32 0.625 0.625 0.5; "
     "add point 33 0.375 0.625 0.5; add polygon 34 1 2 3 4 / 30 31 32 33"},
    {"polygon with a hole twice",
     "add point 30 0.375 0.375 0.5; add point 31 0.625 0.375 0.5; add point 32 0.625 0.625 0.5; "
     "add point 33 0.375 0.625 0.5; set polygon 10 1 2 3 4 / 30 31 32 33; add polygon 34 33 32 "
     "31 30 / 1 2 3 4"},
    {"polygons with a part in common",
     "add point 30 0.125 0.125 0; add point 31 0.25 0.125 0; add point 32 0.25 0.25 0; add point "
     "33 0.125 0.25 0; add point 34 0.375 0.125 0; add point 35 0.5 0.125 0; add point 36 0.5 "
     "0.25 0; add point 37 0.375 0.25 0; add point 38 0.625 0.125 0; add point 39 0.75 0.125 0; "
     "add point 40 0.75 0.25 0; add point 41 0.625 0.25 0; add polygon 50 30 31 32 33 / 34 35 36 "
     "37; add polygon 51 38 39 40 41 / 36 35 34 37"},
    {"close polygons",
     "add point 30 0.125 0.125 0.50000000000000025; add point 31 0.875 0.125 "
     "0.50000000000000025; add point 32 0.5 0.875 0.50000000000000025; add polygon 33 30 31 32"},
    {"unsplit segment", "set segment 11 5 6 unsplit"},
};

// These come before the plate, which is then the offender.
constexpr Item kBeforeThePlate[] = {

    {"point first", "add point 20 0.5 0.375 0.5"},
    {"close point first", "add point 20 0.5 0.375 0.5000000000005"},
    {"segment first",
     "add point 30 0.375 0.5 0.25; add point 31 0.5 0.375 0.75; add segment 32 30 31"},
    {"polygon first",
     "add point 30 0.25 0.25 0.125; add point 31 0.25 0.25 0.875; add point 32 0.75 0.75 "
     "0.125; add point 33 0.75 0.75 0.875; add polygon 34 1 31 33 3 32 30"},
};

}  // namespace

void AddSpaceVerdicts(std::vector<std::string>& lines) {
  const EditBatch plate = Batch(kPlate, 3);
  Scene scene(&lines, "3D", CubeOptions(), plate);
  AddMalformed(scene);
  scene.Validate(kSpaceEdits);
  scene.Validate(kSpaceConflicts);
  scene.Validate(kFacetConflicts);
  Scene empty(&lines, "3D", CubeOptions());
  for (const Item& item : kBeforeThePlate) empty.Validate(item.name, Batch(item.edits, 3) + plate);
  MeshOptions low = CubeOptions();
  low.quality = 1.25;
  Scene(&lines, "3D", low).Validate("quality too low for polygons", plate);
}

}  // namespace dynmesh::test
