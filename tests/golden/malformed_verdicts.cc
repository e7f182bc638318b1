// Verdicts on edits that are malformed by themselves.
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "tests/golden/verdict_scene.h"

namespace dynmesh::test {
void AddMalformed(Scene& scene) {
  const auto point = [](FeatureId id) { return Edit::Add(Feature::Point(id, 0.1, 0.1, 0.1)); };
  constexpr FeatureId kReserved = kLastFeatureId + 1;
  for (const FeatureId id : {FeatureId{0}, kReserved, kBoxFeature}) {
    const std::string name = "id " + std::to_string(id) + " ";
    scene.Validate(name + "point", {point(id)});
    scene.Validate(name + "set", {Edit::Set(Feature::Segment(id, 1, 2))});
    scene.Validate(name + "remove", {Edit::Remove(id)});
    scene.Validate(name + "move", {Edit::Move(id, 0.1, 0.1, 0.1)});
  }
  scene.Validate("id last", {point(kLastFeatureId)});
  scene.Validate("id of a set of polygons",
                 {Edit::Add(Feature::Polygon(kLastPolygonId + 1, {{1, 2, 3}}))});

  Edit odd = point(30);
  odd.feature.kind = static_cast<FeatureKind>(0);
  scene.Validate("kind unknown", {odd});
  odd = point(30);
  odd.action = static_cast<Edit::Action>(9);
  scene.Validate("action unknown", {odd});
  scene.Validate("label of nothing", {Edit::SetLabel(30, {1, "a"})});
  scene.Validate("label long", {Edit::SetLabel(4, {1, std::string(kMostNameBytes + 1, 'a')})});
  scene.Validate("label control", {Edit::SetLabel(4, {1, "a\nb"})});
  scene.Validate("label not utf-8", {Edit::SetLabel(4, {1, "a\xff"})});

  const auto capsule = [](Path path) {
    return Edit::Add(Feature::SizeCapsule(30, std::move(path), 0.125, 0.1));
  };
  for (const double bad : {kNan, kInf, -kInf}) {
    const std::string name = std::isnan(bad) ? "nan " : bad > 0 ? "inf " : "-inf ";
    scene.Validate(name + "point", {Edit::Add(Feature::Point(30, bad, 0.5, 0.5))});
    scene.Validate(name + "move", {Edit::Move(4, 0.5, bad, 0.5)});
    scene.Validate(name + "third", {Edit::Add(Feature::Point(30, 0.1, 0.1, bad))});
    scene.Validate(name + "size point", {Edit::Add(Feature::SizeAt(30, bad, 0.5, 0.1))});
    scene.Validate(name + "size target", {Edit::Add(Feature::SizeAt(30, 0.5, 0.5, bad))});
    scene.Validate(name + "size radius", {Edit::Add(Feature::SizeDisc(30, 0.5, 0.5, bad, 0.1))});
    scene.Validate(name + "size box", {Edit::Add(Feature::SizeBox(30, 0.5, 0.5, 1, bad, 0.1))});
    scene.Validate(name + "size capsule", {capsule({{0.5, 0.5, 0.5}, {bad, 0.5, 0.5}})});
  }
  scene.Validate("coordinate below 2^-200", {Edit::Add(Feature::Point(30, 0.5, 0x1p-201, 0.5))});
  scene.Validate(
      "coordinate denormal",
      {Edit::Add(Feature::Point(30, std::numeric_limits<double>::denorm_min(), 0.5, 0.5))});
  scene.Validate("coordinate of 2^-200", {Edit::Add(Feature::Point(30, 0.5, 0x1p-200, 0.5))});

  Feature size = Feature::SizeAt(30, 0.5, 0.5, 0.1);
  for (const int shape : {0, 9}) {
    size.sizing.shape = static_cast<SizeShape>(shape);
    scene.Validate("size shape " + std::to_string(shape), {Edit::Add(size)});
  }
  scene.Validate("segment from id 0", {Edit::Add(Feature::Segment(30, 0, 1))});
  scene.Validate("polygon without rings", {Edit::Add(Feature::Polygon(30, {}))});
  scene.Validate("polygon of an empty ring", {Edit::Add(Feature::Polygon(30, {{}}))});
  scene.Validate("size polygon without rings", {Edit::Add(Feature::SizePolygon(30, {}, 0.1))});
  scene.Validate("size capsule without vertices", {capsule({})});
  Path zigzag;
  for (std::size_t i = 0; i <= kMostPathVertices; ++i) {
    zigzag.push_back({i % 2 == 0 ? 0.25 : 0.75, 0.5, 0.5});
  }
  scene.Validate("size capsule of too many vertices", {capsule(zigzag)});
  zigzag.pop_back();
  scene.Validate("size capsule of the most vertices", {capsule(zigzag)});
  // The first 16 users and missing points are named.
  EditBatch users;
  std::vector<FeatureId> ring;
  for (FeatureId i = 0; i < 20; ++i) {
    users.push_back(Edit::Add(Feature::Segment(301 + i, 3, 1)));
    ring.push_back(501 + i);
  }
  scene.Validate("point with 20 users", users + EditBatch{Edit::Remove(3)});
  scene.Validate("polygon of 20 unknown points", {Edit::Add(Feature::Polygon(30, {ring}))});
}

}  // namespace dynmesh::test
