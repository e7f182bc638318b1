// Verdicts on 2D batches.
#include "tests/golden/verdict_scene.h"

namespace dynmesh::test {
namespace {

// A square with three sides, its centre 5 and a segment beside it; as in plc_refusals_test.cc.
constexpr char kSquare[] =
    "add point 1 0.25 0.25; add point 2 0.75 0.25; add point 3 0.75 0.75; add point 4 0.25 0.75;"
    "add point 5 0.5 0.5; add point 6 0.875 0.25; add point 7 0.875 0.75;"
    "add segment 11 1 2; add segment 12 2 3; add segment 13 3 4; add segment 14 6 7";

constexpr Item kPlanarEdits[] = {
    {"id of a point", "add point 5 0.1 0.1"},
    {"id of a segment", "add point 11 0.1 0.1"},
    {"id of a point for a segment", "add segment 5 1 6"},
    {"id of a polygon", "add polygon 30 1 2 3 4; add polygon 30 1 2 3 4"},
    {"id of a size", "add size 30 point 0.5 0.5 0.1; add point 30 0.1 0.1"},
    {"id twice", "add point 30 0.1 0.1; add segment 30 1 5"},
    {"id set free", "remove 5; add point 5 0.1 0.1"},
    {"remove unknown", "remove 30"},
    {"remove twice", "remove 5; remove 5"},
    {"set unknown", "set point 30 0.1 0.1"},
    {"move unknown", "move point 30 0.1 0.1; add point 30 0.1 0.1"},
    {"move segment", "move point 11 0.1 0.1"},
    {"move polygon", "add polygon 30 1 2 3 4; move point 30 0 0"},
    {"move size", "add size 30 point 0.5 0.5 0.1; move point 30 0.1 0.1"},
    {"outside", "add point 30 7 0.5"},
    {"outside by an ulp", "add point 30 0.5 1.0000000000000002"},
    {"outside moved", "move point 5 -0.0000000000000002220446049250313 0.5"},
    {"on the border", "add point 30 0 0; add point 31 1 1"},
    {"end unknown", "add segment 30 5 40"},
    {"ends unknown", "add segment 30 41 40"},
    {"end is a segment", "add segment 30 5 11"},
    {"end is a size", "add size 30 point 0.5 0.5 0.1; add segment 31 5 30"},
    {"end removed", "remove 5; set segment 14 6 5"},
    {"ends equal", "add segment 30 5 5"},
    {"ends equal, set", "set segment 14 6 6"},
    {"in use", "remove 2"},
    {"in use by one", "remove 12; remove 2"},
    {"in use, set to a segment", "set segment 2 5 6"},
    {"in use by a polygon", "add polygon 30 1 2 3 4; remove 2"},
    {"in use by a size", "add size 30 polygon 1 5 3 0.1; remove 5"},
};

constexpr Item kPlanarConflicts[] = {
    {"duplicate point", "add point 30 0.5 0.5"},
    {"duplicate point moved", "move point 5 0.75 0.75"},
    {"duplicate point swapped", "move point 5 0.875 0.25; move point 6 0.5 0.5"},
    {"duplicate segment", "add segment 30 2 1"},
    {"duplicate segment set", "set segment 14 3 2"},
    {"point on segment", "add point 30 0.5 0.25"},
    {"point moved on segment", "move point 5 0.75 0.5"},
    {"segment over point", "add segment 30 1 3"},
    {"segment turned over point", "remove 13; move point 3 0.9375 0.25"},
    {"end on segment", "add point 30 0.5 0.25; add segment 31 5 30"},
    {"close point", "add point 30 0.5000000000000002 0.5"},
    {"close points at 2^-41 less an ulp",
     "add point 30 0.0000000000004545254533406286 0; add point 31 0 0"},
    {"points at 2^-41", "add point 30 0.50000000000045474735 0.5"},
    {"close to segment", "add point 30 0.5 0.2500000000000002"},
    {"segment close to point", "move point 5 0.5 0.5000000000000002; add segment 30 1 3"},
    {"close segments",
     "add point 30 0.125 0.125; add point 31 0.375 0.125; add point 32 0.125 "
     "0.12500000000000025; add point 33 0.375 0.12500000000000025; add segment 34 30 31; add "
     "segment 35 32 33"},
    {"segments cross", "add point 30 0.5 0.125; add segment 31 5 30"},
    {"segments cross, least id", "add point 30 1 0.5; add segment 31 5 30"},
    {"segments cross, moved", "move point 7 0.5 0.375"},
    {"segments cross, later end",
     "add segment 31 5 40; add point 41 0.1 0.1; add point 40 0.5 0.125"},
    {"segments cross, removed", "add segment 31 5 6; remove 12"},
    {"segments cross in thirds",
     "add point 30 0.125 0; add point 31 0.25 0.125; add point 32 0.125 0.0625; add point 33 "
     "0.375 0; add segment 34 30 31; add segment 35 32 33"},
    {"segments overlap",
     "add point 30 0.875 0.875; add point 31 0.9375 0.9375; add segment 32 30 31; add point 33 1 "
     "1; add segment 34 30 33"},
    {"segments overlap, ends apart",
     "add point 30 0.5 0; add point 31 0.75 0; add segment 41 30 31; add point 33 0.25 0; add "
     "point 34 0.875 0; add segment 42 34 33"},
    {"angle", "add point 30 0.5 0.2500039; add segment 31 1 30"},
    {"angle just large enough", "add point 30 0.5 0.2500048; add segment 31 1 30"},
    {"angle moved", "move point 3 0.5 0.2500039"},
    {"unsplit, a point on its circle", "set segment 11 1 2 unsplit"},
    {"unsplit, points on both sides of its circle",
     "set segment 11 1 2 unsplit; add point 30 0.5 0"},
    {"unsplit, a point in its circle",
     "set segment 12 2 3 unsplit; set segment 14 6 7 unsplit; add point 30 0.9375 0.5"},
    {"unsplit, a segment in its circle", "set segment 14 6 7 unsplit"},
    {"unsplit, a segment at an acute angle",
     "set segment 11 1 2 unsplit; add point 30 0.3125 0; add segment 31 1 30"},
    {"unsplit polygon", "add polygon 30 1 2 3 4 unsplit"},
};

constexpr Item kPlanarPolygons[] = {
    {"polygon of two points", "add polygon 30 1 2"},
    {"polygon, second ring of two points", "add polygon 30 1 2 3 / 5 6"},
    {"polygon, point twice", "add polygon 30 1 2 3 1"},
    {"polygon, edge twice", "add polygon 30 1 2 3 / 2 6 3"},
    {"polygon, corner unknown", "add polygon 30 1 2 77"},
    {"polygon, corner is a segment", "add polygon 30 1 2 11"},
    {"polygon crosses segment", "add polygon 30 5 6 7"},
    {"segment crosses polygon",
     "add point 40 0.0625 0.25; add point 41 0.125 0.5; add polygon 30 1 40 41; add segment 42 4 "
     "40; remove 42; add point 43 0.0625 0.375; add segment 44 43 1"},
    {"polygon over point", "add polygon 30 1 2 3"},
    {"polygons cross",
     "add point 40 0 0; add point 41 0.125 0; add point 42 0.125 0.125; add point 43 0.0625 "
     "0.03125; add point 44 0.1875 0.03125; add point 45 0.1875 0.125; add polygon 30 40 41 42; "
     "add polygon 31 43 44 45"},
    {"corner of a polygon on another's edge",
     "add point 40 0 0; add point 41 0.125 0; add point 42 0.125 0.125; add point 43 0.0625 "
     "0.0625; add point 44 0.1875 0.0625; add point 45 0.1875 0.125; add polygon 30 40 41 42; "
     "add polygon 31 43 44 45"},
    {"polygon without area",
     "add point 40 0 0; add point 41 0.125 0; add point 42 0.0625 0; add polygon 30 40 41 42"},
    {"polygons twice, nested and side by side",
     "add polygon 30 1 2 3 4; add polygon 31 4 3 2 1; add polygon 32 1 2 5 / 4 5 3; add polygon "
     "33 2 6 3; add segment 34 4 1"},
    {"polygon with a narrow corner",
     "add point 40 0 0; add point 41 0.125 0; add point 42 0.125 0.000001; add polygon 30 40 41 "
     "42"},
    {"size outside", "add size 30 point 1.0000000000000002 0.5 0.1"},
    {"size disc outside", "add size 30 disc 0.5 -0.125 0.5 0.1"},
    {"size box outside", "add size 30 box 1.5 0 2 1 0.1"},
    {"size box partly outside", "add size 30 box 0.5 0.5 0.5 7 0.5"},
    {"size box swapped", "add size 30 box 0.5 0.5 0.375 1 0.1"},
    {"size disc of negative radius", "add size 30 disc 0.5 0.5 -0.125 0.1"},
    {"size target 0", "add size 30 point 0.5 0.5 0"},
    {"size target negative", "add size 30 point 0.5 0.5 -1"},
    {"size target below the least", "add size 30 point 0.5 0.5 0.00000000001455191522836685"},
    {"size target, least", "add size 30 point 0.5 0.5 0.000000000029103830456733704"},
    {"size polygon of two points", "add size 30 polygon 1 2 0.1"},
    {"size polygon, corner unknown", "add size 30 polygon 1 2 77 0.1"},
    {"size polygon, target 0", "add size 30 polygon 1 2 3 0"},
    {"size polygon that crosses itself", "add size 30 polygon 1 3 2 4 / 6 5 1 0.1"},
    {"size capsule there and back", "add size 30 capsule 0 0 1 1 0.5 0.5 1 0 0 0 0.25 0.1"},
    {"size capsule of radius 0", "add size 30 capsule 0.25 0.5 0.75 0.5 0 0.1"},
    {"size capsule of negative radius", "add size 30 capsule 0.25 0.5 0.75 0.5 -0.125 0.1"},
    {"size capsule of one vertex", "add size 30 capsule 0.25 0.5 0.125 0.1"},
    {"size capsule, vertex twice", "add size 30 capsule 0.25 0.5 0.75 0.5 0.75 0.5 0.125 0.1"},
    {"size capsule, vertex outside", "add size 30 capsule 0.25 0.5 1.5 0.5 0.125 0.1"},
    {"size capsule, target 0", "add size 30 capsule 0.25 0.5 0.75 0.5 0.125 0"},
    {"move size capsule", "add size 30 capsule 0.25 0.5 0.75 0.5 0.125 0.1; move point 30 0.5 0.5"},
    {"earliest of three", "add point 40 0.1 0.1; add point 30 0.5 0.5; remove 77; remove 2"},
    {"earliest, a later edit repairs",
     "add point 30 0.5 0.5; add point 40 0.1 0.1; remove 77; move point 30 0.2 0.2"},
};

}  // namespace

void AddPlanarVerdicts(std::vector<std::string>& lines) {
  Scene scene(&lines, "2D", {}, Batch(kSquare, 2));
  AddMalformed(scene);
  scene.Validate("minus zero",
                 {Edit::Add(Feature::Point(31, 0, 0.5)), Edit::Add(Feature::Point(30, -0.0, 0.5))});
  scene.Validate(kPlanarEdits);
  scene.Validate(kPlanarConflicts);
  scene.Validate(kPlanarPolygons);
}

}  // namespace dynmesh::test
