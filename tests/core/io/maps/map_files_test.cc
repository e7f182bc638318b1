#include "core/io/maps/map_files.h"

#include <string>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io {
namespace {

using test::TempFolder;

Feature P(FeatureId id, double x, double y) { return Feature::Point(id, x, y); }
Feature S(FeatureId id, FeatureId p, FeatureId q) { return Feature::Segment(id, p, q); }
Feature G(FeatureId id, Rings rings) { return Feature::Polygon(id, std::move(rings)); }

class MapFiles : public ::testing::Test {
 protected:
  absl::StatusOr<FileFeatures> Read(const std::string& text, bool polygons = false) const {
    MapOptions options;
    options.polygons = polygons;
    return ReadMapFile(folder_.Write("m.json", text), options);
  }
  std::vector<Feature> Features(const std::string& text) const {
    const auto input = Read(text);
    EXPECT_TRUE(input.ok()) << input.status();
    return input.ok() ? input->features : std::vector<Feature>();
  }
  // The message, without the folder.
  std::string Error(const std::string& text) const {
    const auto input = Read(text);
    EXPECT_EQ(input.status().code(), absl::StatusCode::kInvalidArgument) << text;
    std::string message(input.status().message());
    const std::string before = folder_.Path("");
    return message.starts_with(before) ? message.substr(before.size()) : message;
  }

  TempFolder folder_;
};

TEST_F(MapFiles, EveryGeometryOfGeoJsonIsRead) {
  const std::pair<const char*, std::vector<Feature>> kCases[] = {
      {R"({"type": "Point", "coordinates": [1, 2]})", {P(1, 1, 2)}},
      {R"({"type": "MultiPoint", "coordinates": [[1, 2], [3, -4.5], [1, 2]]})",
       {P(1, 1, 2), P(2, 3, -4.5)}},
      {R"({"type": "LineString", "coordinates": [[0, 0], [1, 0], [1, 0], [1, 1]]})",
       {P(1, 0, 0), P(2, 1, 0), P(3, 1, 1), S(4, 1, 2), S(5, 2, 3)}},
      {R"({"type": "MultiLineString", "coordinates": [[[0, 0], [1, 0]], [[1, 0], [0, 0], [2, 2]]]})",
       {P(1, 0, 0), P(2, 1, 0), P(3, 2, 2), S(4, 1, 2), S(5, 1, 3)}},
      {R"({"type": "Polygon", "coordinates": [[[0, 0], [4, 0], [0, 4], [0, 0]],
                                              [[1, 1], [2, 1], [1, 2], [1, 1]]]})",
       {P(1, 0, 0), P(2, 4, 0), P(3, 0, 4), P(4, 1, 1), P(5, 2, 1), P(6, 1, 2), S(7, 1, 2),
        S(8, 2, 3), S(9, 3, 1), S(10, 4, 5), S(11, 5, 6), S(12, 6, 4)}},
      // Neighbours share a border.
      {R"({"type": "MultiPolygon", "coordinates": [[[[0, 0], [1, 0], [0, 1], [0, 0]]],
                                                   [[[1, 0], [1, 1], [0, 1], [1, 0]]]]})",
       {P(1, 0, 0), P(2, 1, 0), P(3, 0, 1), P(4, 1, 1), S(5, 1, 2), S(6, 2, 3), S(7, 3, 1),
        S(8, 2, 4), S(9, 4, 3)}},
      {R"({"type": "GeometryCollection", "geometries": [
           {"type": "Point", "coordinates": [5, 6, 7]},
           {"type": "GeometryCollection", "geometries": []},
           {"type": "LineString", "coordinates": [[5, 6], [-0.0, 0]]}]})",
       {P(1, 5, 6), P(2, 0, 0), S(3, 1, 2)}},
      {R"({"type": "Polygon", "coordinates": []})", {}},
  };
  for (const auto& [text, features] : kCases) EXPECT_EQ(Features(text), features) << text;
}

TEST_F(MapFiles, FeaturesOfACollectionAreReadInTheirOrder) {
  const auto input = Read(
      "{\"type\": \"FeatureCollection\", \"bbox\": [0, 0, 1, 1], \"features\": [\n"
      "{\"type\": \"Feature\", \"properties\": {\"type\": \"x\", \"arcs\": [[1]]},\n"
      " \"geometry\": {\"coordinates\": [[7, 8, 1],\n[9, 8, 1]], \"type\": \"LineString\"}},\n"
      "{\"type\": \"Feature\", \"properties\": null, \"geometry\": null},\n"
      "{\"type\": \"Feature\", \"geometry\": {\"type\": \"Point\", \"coordinates\": [1, 1]}}]}");
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_EQ(input->features,
            (std::vector<Feature>{P(1, 7, 8), P(2, 9, 8), P(3, 1, 1), S(4, 1, 2)}));
  EXPECT_EQ(input->point_count, 3U);
  EXPECT_EQ(input->segment_count, 1U);
  EXPECT_EQ(input->heights, 2U);
  const std::string file = folder_.Path("m.json");
  EXPECT_EQ(input->Where(1), file + ":3");
  EXPECT_EQ(input->Where(2), file + ":4");
  EXPECT_EQ(input->Where(3), file + ":6");
  EXPECT_EQ(input->Where(4), file + ":4");
  EXPECT_EQ(input->Where(5), "");
  EXPECT_EQ(
      Features(R"({"type": "Feature", "geometry": {"type": "Point", "coordinates": [1, 1]}})"),
      (std::vector<Feature>{P(1, 1, 1)}));
}

TEST_F(MapFiles, PolygonsOfGeoJsonStayPolygons) {
  const auto input = Read(
      R"({"type": "FeatureCollection", "features": [
{"type": "Feature", "id": 30, "properties": {"name": "two \"parts\""}, "geometry":
 {"type": "MultiPolygon", "coordinates": [[[[0, 0], [4, 0], [0, 4], [0, 0]],
                                           [[1, 1], [2, 1], [2, 1], [1, 2], [1, 1]]],
                                          [[[5, 5], [6, 5], [6, 6], [5, 5]]]]}},
{"type": "Feature", "properties": null, "geometry": {"type": "GeometryCollection", "geometries": [
  {"type": "LineString", "coordinates": [[4, 0], [0, 4]]},
  {"type": "Polygon", "coordinates": [[[0, 4], [4, 0], [4, 4], [0, 4]]]},
  {"type": "Polygon", "coordinates": []}]}}]})",
      true);
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_EQ(
      input->features,
      (std::vector<Feature>{P(1, 0, 0), P(2, 4, 0), P(3, 0, 4), P(4, 1, 1), P(5, 2, 1), P(6, 1, 2),
                            P(7, 5, 5), P(8, 6, 5), P(9, 6, 6), P(10, 4, 4), S(11, 2, 3),
                            G(12, {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}), G(13, {{3, 2, 10}})}));
  ASSERT_EQ(input->polygons.size(), 2U);
  EXPECT_EQ(input->polygons[0].id, 12U);
  EXPECT_EQ(input->polygons[0].key, "30");
  EXPECT_EQ(input->polygons[0].name, "two \"parts\"");
  EXPECT_EQ(input->polygons[1].id, 13U);
  EXPECT_EQ(input->polygons[1].key, "");
  EXPECT_EQ(input->Where(12), folder_.Path("m.json") + ":3");
}

TEST_F(MapFiles, MalformedGeoJsonIsRefusedWithItsLine) {
  const std::pair<const char*, const char*> kCases[] = {
      {"[1]", "m.json:1: a map must be an object, found an array"},
      {"{}", "m.json:1: a map has no member \"type\""},
      {"{\"type\": 7}", "m.json:1: member \"type\" of a map must be a string"},
      {"\n{\"type\": \"Circle\"}", "m.json:2: unknown type 'Circle'"},
      {"{\"type\": \"Point\"}", "m.json:1: Point has no member \"coordinates\""},
      {"{\"type\": \"Point\", \"coordinates\":\n [1]}", "m.json:2: a position needs x and y"},
      {"{\"type\": \"Point\", \"coordinates\":\n [1,\n\"2\"]}",
       "m.json:3: a coordinate must be a number, found a string"},
      {"{\"type\": \"Point\", \"coordinates\": [[1, 2], [3, 4]]}", "m.json:1: a coordinate"},
      {"{\"type\": \"Point\", \"coordinates\":\n[1, 1e300]}", "m.json:2: the coordinate 1e+300"},
      {"{\"type\": \"Point\", \"coordinates\":\n[1, -1e999]}", "m.json:2: the number '-1e999'"},
      {"{\"type\": \"Point\", \"coordinates\":\n[1, NaN]}", "m.json:2: this is no JSON"},
      {"{\"type\": \"MultiPoint\", \"coordinates\": [1, 2]}",
       "m.json:1: a position must be an array"},
      {"{\"type\": \"LineString\", \"coordinates\":\n[[1, 2]]}",
       "m.json:2: a line needs 2 positions"},
      {"{\"type\": \"Polygon\", \"coordinates\": [\n[[0, 0], [1, 0], [0, 0]]]}",
       "m.json:2: a polygon's ring needs 4 positions, found 3"},
      {"{\"type\": \"Polygon\", \"coordinates\": [\n[[0, 0], [1, 0], [0, 1], [1, 1]]]}",
       "m.json:2: a polygon's ring must end where it starts"},
      {"{\"type\": \"FeatureCollection\"}",
       "m.json:1: FeatureCollection has no member \"features\""},
      {"{\"type\": \"FeatureCollection\", \"features\": [\n3]}",
       "m.json:2: a feature must be an object, found a number"},
      {"{\"type\": \"FeatureCollection\", \"features\": [\n{\"type\": \"Point\"}]}",
       "m.json:2: features must be of type Feature"},
      {"{\"type\": \"Feature\"}", "m.json:1: a Feature has no member \"geometry\""},
      {"{\"type\": \"GeometryCollection\", \"geometries\": {}}",
       "m.json:1: member \"geometries\" of GeometryCollection must be an array"},
  };
  for (const auto& [text, message] : kCases) {
    EXPECT_TRUE(Error(text).starts_with(message)) << text << "\n" << Error(text);
  }
}

TEST_F(MapFiles, DeepNestingIsRefused) {
  std::string text = R"({"type": "Point", "coordinates": [1, 2]})";
  for (int i = 0; i < 40; ++i) {
    text = R"({"type": "GeometryCollection", "geometries": [)" + text + "]}";
  }
  EXPECT_NE(Error(text).find("64 deep"), std::string::npos);
}

// Two squares side by side; arc 1 is their common side, arc 3 is unused.
constexpr char kSquares[] = R"({
  "type": "Topology",
  "arcs": [
    [[1, 0], [0, 0], [0, 1], [1, 1]],
    [[1, 1], [1, 0]],
    [[1, 0], [2, 0], [2, 1], [1, 1]],
    [[7, 7], [8, 8]]],
  "objects": {
    "squares": {"type": "GeometryCollection", "geometries": [
      {"type": "Polygon", "arcs": [[0, 1]]},
      {"type": "MultiPolygon", "arcs": [[[-3, -2]]]},
      {"type": null}]},
    "places": {"type": "MultiPoint", "coordinates": [[0.5, 0.5], [1, 1]]},
    "line": {"type": "LineString", "arcs": [-2]}}})";

TEST_F(MapFiles, ArcsOfATopologyAreTakenOnceIfUsed) {
  const auto input = Read(kSquares);
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_EQ(input->features,
            (std::vector<Feature>{P(1, 1, 0), P(2, 0, 0), P(3, 0, 1), P(4, 1, 1), P(5, 2, 0),
                                  P(6, 2, 1), P(7, 0.5, 0.5), S(8, 1, 2), S(9, 2, 3), S(10, 3, 4),
                                  S(11, 4, 1), S(12, 1, 5), S(13, 5, 6), S(14, 6, 4)}));
  EXPECT_EQ(input->Where(8), folder_.Path("m.json") + ":4");
  EXPECT_EQ(input->Where(7), folder_.Path("m.json") + ":13");
}

TEST_F(MapFiles, PolygonsOfATopologySharePoints) {
  const auto input = Read(kSquares, true);
  ASSERT_TRUE(input.ok()) << input.status();
  EXPECT_EQ(input->features,
            (std::vector<Feature>{P(1, 1, 0), P(2, 0, 0), P(3, 0, 1), P(4, 1, 1), P(5, 2, 0),
                                  P(6, 2, 1), P(7, 0.5, 0.5), S(8, 4, 1), G(9, {{1, 2, 3, 4}}),
                                  G(10, {{4, 6, 5, 1}})}));
  EXPECT_EQ(input->segment_count, 1U);
  EXPECT_EQ(input->gaps, 0U);
  EXPECT_EQ(input->Where(10), folder_.Path("m.json") + ":11");
}

TEST_F(MapFiles, PolygonsOfATopologyHaveHolesPartsAndNames) {
  const auto input = Read(
      R"({"type": "Topology", "objects": {"a": {"type": "GeometryCollection", "geometries": [
            {"type": "MultiPolygon", "id": "840", "properties": {"name": "Usa", "id": 3},
             "arcs": [[[0], [-2]], [[2, 3]]]},
            {"type": "Polygon", "id": 7.5, "arcs": []},
            {"type": "Polygon", "id": 7, "properties": {"name": null}, "arcs": [[1, 1, -2]]}]}},
          "arcs": [[[0, 0], [9, 0], [9, 9], [0, 0]], [[3, 2], [4, 2], [4, 3], [3, 2]],
                   [[20, 0], [21, 0]], [[21, 0], [21, 1], [21, 1]]]})",
      true);
  ASSERT_TRUE(input.ok()) << input.status();
  ASSERT_EQ(input->point_count, 9U);
  EXPECT_EQ(input->segment_count, 0U);
  ASSERT_EQ(input->features.size(), 11U);
  EXPECT_EQ(input->features[9], G(10, {{1, 2, 3}, {4, 6, 5}, {7, 8, 9}}));
  EXPECT_EQ(input->features[10], G(11, {{4, 5, 6, 4, 5, 6, 4, 6, 5}}));  // as it is in the file
  ASSERT_EQ(input->polygons.size(), 2U);
  EXPECT_EQ(input->polygons[0].id, 10U);
  EXPECT_EQ(input->polygons[0].key, "840");
  EXPECT_EQ(input->polygons[0].name, "Usa");
  EXPECT_EQ(input->polygons[1].key, "7");
  EXPECT_EQ(input->polygons[1].name, "");
  EXPECT_EQ(input->gaps, 1U);  // from (21, 1) to (20, 0)
}

TEST_F(MapFiles, QuantisedTopologiesAreScaled) {
  const std::string text =
      R"({"type": "Topology", "transform": {"scale": [0.5, 0.25], "translate": [-10, 3]},
          "objects": {"a": {"type": "LineString", "arcs": [0]},
                      "b": {"type": "Point", "coordinates": [4, 4]},
                      "c": {"type": "MultiLineString", "arcs": [[-1]]}},
          "arcs": [[[2, 4], [2, 0], [0, 0], [-4, -8]]]})";
  EXPECT_EQ(Features(text),
            (std::vector<Feature>{P(1, -9, 4), P(2, -8, 4), P(3, -10, 2), S(4, 1, 2), S(5, 2, 3)}));
}

TEST_F(MapFiles, MalformedTopologiesAreRefusedWithTheirLine) {
  const auto topology = [](const std::string& arcs, const std::string& object,
                           const std::string& more = "") {
    return "{\"type\": \"Topology\", " + more + "\"arcs\": " + arcs +
           ",\n\"objects\": {\"a\": " + object + "}}";
  };
  const std::string arc = "[[[0, 0], [1, 1]]]";
  const std::pair<std::string, const char*> kCases[] = {
      {"{\"type\": \"Topology\"}", "m.json:1: a Topology has no member \"arcs\""},
      {"{\"type\": \"Topology\", \"arcs\": []}", "m.json:1: a Topology has no member \"objects\""},
      {topology(arc, "{\"type\": \"LineString\", \"arcs\": [1]}"), "m.json:2: there is no arc 1"},
      {topology(arc, "{\"type\": \"LineString\", \"arcs\": [-2]}"), "m.json:2: there is no arc -2"},
      {topology(arc, "{\"type\": \"LineString\", \"arcs\": [0.5]}"), "m.json:2: there is no arc"},
      {topology(arc, "{\"type\": \"LineString\", \"arcs\": [1e300]}"), "m.json:2: there is no arc"},
      {topology(arc, "{\"type\": \"Polygon\", \"arcs\": [0]}"), "m.json:2: a list of arcs"},
      {topology(arc, "{\"type\": \"LineString\", \"arcs\": [[0]]}"),
       "m.json:2: the number of an arc"},
      {topology(arc, "{\"type\": \"Sphere\"}"), "m.json:2: unknown type 'Sphere'"},
      {topology(arc, "7"), "m.json:2: a geometry must be an object"},
      {topology("[[[0, 0]]]", "{\"type\": \"LineString\", \"arcs\": [0]}"),
       "m.json:1: an arc needs"},
      {topology("[[[0, 0], [1]]]", "{\"type\": \"LineString\", \"arcs\": [0]}"),
       "m.json:1: a position needs"},
      {topology(arc, "{\"type\": \"LineString\", \"arcs\": [0]}", "\"transform\": {},"),
       "m.json:1: the transform has no member \"scale\""},
      {topology(arc, "{\"type\": \"LineString\", \"arcs\": [0]}",
                "\"transform\": {\"scale\": [1, 1e300], \"translate\": [0, 0]},"),
       "m.json:1: the coordinate 1e+300"},
  };
  for (const auto& [text, message] : kCases) {
    EXPECT_TRUE(Error(text).starts_with(message)) << text << "\n" << Error(text);
  }
}

TEST_F(MapFiles, EdgesAcrossTheAntimeridianAreCounted) {
  const auto input =
      Read(R"({"type": "LineString", "coordinates": [[179, 5], [-179, 6], [-170, 6]]})");
  ASSERT_TRUE(input.ok());
  EXPECT_EQ(input->wraps, 1U);
  // Twice the same one, and the way back.
  const auto polygon = Read(
      R"({"type": "Polygon", "coordinates": [[[179, 5], [-179, 5], [-179, 6], [179, 6], [179, 5]],
                                             [[-179, 5], [179, 5], [0, 0], [-179, 5]]]})",
      true);
  ASSERT_TRUE(polygon.ok()) << polygon.status();
  EXPECT_EQ(polygon->wraps, 2U);
  const auto metres = Read(R"({"type": "LineString", "coordinates": [[179, 5], [-179, 600]]})");
  ASSERT_TRUE(metres.ok());
  EXPECT_EQ(metres->wraps, 0U);
}

}  // namespace
}  // namespace dynmesh::io
