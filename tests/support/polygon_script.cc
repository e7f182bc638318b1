#include "tests/support/polygon_script.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace dynmesh::test {
namespace {

using Place = Solid::Place;

Rings Numbered(std::vector<std::vector<FeatureId>> rings) { return rings; }

// Of four corners side by side on a ring.
void AddFace(Solid& solid, std::vector<FeatureId> ring) {
  solid.faces.push_back({Numbered({std::move(ring)})});
}

// Boxes one above the other, with a face in common: `layers` + 1 squares of corners.
Solid MakeStack(int layers, double x, double y, double z) {
  Solid solid;
  for (int layer = 0; layer <= layers; ++layer) {
    const double height = z * (2.0 * layer / layers - 1);
    for (const auto& [u, v] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) {
      solid.corners.push_back({u * x, v * y, height});
    }
    const auto first = static_cast<FeatureId>(4 * layer);
    AddFace(solid, {first, first + 1, first + 2, first + 3});
    if (layer == 0) continue;
    for (FeatureId i = 0; i < 4; ++i) {
      const FeatureId j = (i + 1) % 4;
      AddFace(solid, {first - 4 + i, first - 4 + j, first + j, first + i});
    }
  }
  return solid;
}

Solid MakePlate(double half) {
  Solid solid;
  solid.corners = {{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}};
  AddFace(solid, {0, 1, 2, 3});
  return solid;
}

// An L with a hole and a square beside it; which of them are there varies.
Solid MakeHoled(double s) {
  Solid solid;
  for (const auto& [u, v] : {std::pair(-1.0, -1.0),
                             {1.0, -1.0},
                             {1.0, 0.0},
                             {0.0, 0.0},
                             {0.0, 1.0},
                             {-1.0, 1.0},  // the L
                             {-0.75, -0.75},
                             {-0.3, -0.75},
                             {-0.3, -0.3},
                             {-0.75, -0.3},
                             {0.3, 0.3},
                             {1.0, 0.3},
                             {1.0, 1.0},
                             {0.3, 1.0}}) {
    solid.corners.push_back({s * u, s * v, 0});
  }
  const std::vector<FeatureId> ell = {0, 1, 2, 3, 4, 5}, hole = {6, 7, 8, 9},
                               square = {10, 11, 12, 13};
  solid.faces.push_back({{ell, hole}, {ell, hole, square}, {hole, square}, {square}, {ell, hole}});
  return solid;
}

// A box with a square hole through it.
Solid MakeTunnel(double s) {
  Solid solid;
  for (const double z : {-0.6, 0.6}) {
    for (const double r : {1.0, 0.45}) {
      for (const auto& [u, v] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) {
        solid.corners.push_back({s * r * u, s * r * v, s * z});
      }
    }
  }
  for (const FeatureId cap : {FeatureId{0}, FeatureId{8}}) {
    solid.faces.push_back(
        {{{cap, cap + 1, cap + 2, cap + 3}, {cap + 4, cap + 5, cap + 6, cap + 7}}});
  }
  for (const FeatureId wall : {FeatureId{0}, FeatureId{4}}) {
    for (FeatureId i = 0; i < 4; ++i) {
      const FeatureId j = (i + 1) % 4;
      AddFace(solid, {wall + i, wall + j, wall + 8 + j, wall + 8 + i});
    }
  }
  return solid;
}

Solid MakeStick(bool crossed) {
  Solid solid;
  solid.corners = {{-0.8, 0, 0}, {0.8, 0, 0}};
  solid.segments = {{0, 1}};
  if (crossed) {
    solid.corners.insert(solid.corners.end(), {{0.8, 0.5, 0}, {0.8, 0, -0.5}});
    solid.segments.insert(solid.segments.end(), {{1, 2}, {1, 3}});
  }
  return solid;
}

// Segments from one corner, within a cone.
Solid MakeFork(int prongs, double wide, Random& random) {
  Solid solid;
  solid.corners = {{0, 0, -0.8}};
  for (int i = 0; i < prongs; ++i) {
    const double aside = wide * std::sqrt(random.Unit()), turn = 6.283 * random.Unit();
    const double length = random.OneIn(3) ? 1.5 : 0.3 + 1.2 * random.Unit();
    solid.corners.push_back({length * std::sin(aside) * std::cos(turn),
                             length * std::sin(aside) * std::sin(turn),
                             length * std::cos(aside) - 0.8});
    solid.segments.emplace_back(0, i + 1);
  }
  return solid;
}

// A triangle with an angle of that size, in radians, at one end or both.
Solid MakeNeedle(double angle, bool both) {
  Solid solid;
  const double x = both ? 0.1 : 0.8 * std::cos(angle);
  solid.corners = {{-0.8, 0, 0}, {0.8, 0, 0}, {x, (x + 0.8) * std::tan(angle), 0}};
  AddFace(solid, {0, 1, 2});
  return solid;
}

// Triangles around a corner that is so much over the others.
Solid MakeFan(int n, double height, Random& random) {
  Solid solid;
  solid.corners = {{0, 0, height}};
  for (int i = 0; i < n; ++i) {
    const double turn = 2 * std::numbers::pi * (i + 0.5 * random.Unit()) / n;
    const double r = 0.5 + 0.4 * random.Unit();
    solid.corners.push_back({r * std::cos(turn), r * std::sin(turn), 0});
    AddFace(solid, {0, static_cast<FeatureId>(i + 1), static_cast<FeatureId>((i + 1) % n + 1)});
  }
  return solid;
}

// A wavy square of n by n cells, each cut into two triangles.
Solid MakeSurface(int n, Random& random) {
  Solid solid;
  const auto at = [n](int i, int j) { return static_cast<FeatureId>(i * (n + 1) + j); };
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      const double x = 1.2 * (i + 0.4 * random.Unit()) / n - 0.6;
      const double y = 1.2 * (j + 0.4 * random.Unit()) / n - 0.6;
      solid.corners.push_back({x, y, 0.1 * std::sin(3 * x + 2 * y)});
    }
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const FeatureId a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
      const bool turned = random.OneIn(2);
      AddFace(solid, turned ? std::vector{a, b, d} : std::vector{a, b, c});
      AddFace(solid, turned ? std::vector{b, c, d} : std::vector{a, c, d});
    }
  }
  return solid;
}

// A double pyramid: triangles that get narrow towards its ends.
Solid MakeSpindle(int n) {
  Solid solid;
  solid.corners = {{0, 0, 0.8}, {0, 0, -0.8}};
  for (int i = 0; i < n; ++i) {
    const double turn = 2 * std::numbers::pi * i / n;
    solid.corners.push_back({0.8 * std::cos(turn), 0.8 * std::sin(turn), 0});
  }
  for (int i = 0; i < n; ++i) {
    const auto p = static_cast<FeatureId>(i + 2), q = static_cast<FeatureId>((i + 1) % n + 2);
    AddFace(solid, {0, p, q});
    AddFace(solid, {1, q, p});
  }
  return solid;
}

Solid MakeSharp(Random& random) {
  const double angle = std::ldexp(0.8, -random.Below(6));
  switch (random.Below(5)) {
    case 0:
      return MakeFork(2 + random.Below(6), angle, random);
    case 1:
      return MakeNeedle(angle, random.OneIn(2));
    case 2:
      return MakeFan(4 + random.Below(12), 0.4 * random.Unit(), random);
    case 3:
      return MakeSurface(2 + random.Below(2), random);
    default:
      return MakeSpindle(5 + random.Below(8));
  }
}

// A turn by a quaternion, applied to p.
Place Turned(const std::array<double, 4>& q, const Place& p) {
  const auto [w, x, y, z] = q;
  return {
      (1 - 2 * (y * y + z * z)) * p[0] + 2 * (x * y - w * z) * p[1] + 2 * (x * z + w * y) * p[2],
      2 * (x * y + w * z) * p[0] + (1 - 2 * (x * x + z * z)) * p[1] + 2 * (y * z - w * x) * p[2],
      2 * (x * z - w * y) * p[0] + 2 * (y * z + w * x) * p[1] + (1 - 2 * (x * x + y * y)) * p[2]};
}

Feature PointAt(FeatureId id, const Place& p) { return Feature::Point(id, p[0], p[1], p[2]); }

}  // namespace

Solid MakeCuboid(double x, double y, double z) { return MakeStack(1, x, y, z); }

std::string NameOf(PolygonKind kind) {
  constexpr const char* kNames[] = {"NestedBoxes", "Plates",  "ManyBoxes", "Holed",
                                    "Sticks",      "Mixture", "Sharp"};
  return kNames[static_cast<int>(kind)];
}

PolygonScript::PolygonScript(PolygonKind kind, int n, std::uint64_t seed)
    : random_(seed),
      free_part_(kind == PolygonKind::kMixture ? 3 : 8),
      sized_(kind == PolygonKind::kMixture || kind == PolygonKind::kSticks),
      moves_corners_(kind == PolygonKind::kSharp) {
  Settle(kind, n);
  // Some scenes are small in the cube, so that sizes grow around them.
  const double zoom = std::ldexp(1.0, -2 * random_.Below(3));
  for (Home& home : homes_) {
    home.size *= zoom;
    for (double& c : home.centre) c = 0.5 + zoom * (c - 0.5);
  }
}

Solid PolygonScript::AnySolid(PolygonKind kind) {
  if (kind == PolygonKind::kMixture) {
    constexpr PolygonKind kSome[] = {PolygonKind::kManyBoxes, PolygonKind::kHoled,
                                     PolygonKind::kSticks};
    kind = kSome[random_.Below(3)];
  }
  if (kind == PolygonKind::kSharp) return MakeSharp(random_);
  if (kind == PolygonKind::kHoled) {
    return random_.OneIn(3) ? MakeTunnel(0.65) : MakeHoled(0.7);
  }
  if (kind == PolygonKind::kSticks && !random_.OneIn(3)) return MakeStick(random_.OneIn(2));
  if (kind == PolygonKind::kSticks) return MakePlate(0.7);
  return random_.OneIn(4) ? MakeStack(2, 0.4, 0.4, 0.8) : MakeCuboid(0.57, 0.57, 0.57);
}

void PolygonScript::Settle(PolygonKind kind, int n) {
  if (kind == PolygonKind::kNestedBoxes) {
    double size = 0.55;
    for (int i = 0; i < n; ++i, size *= 0.3) {
      homes_.push_back({MakeCuboid(0.57, 0.57, 0.57), {0.5, 0.5, 0.5}, size, i > 0});
    }
    return;
  }
  if (kind == PolygonKind::kPlates) {
    for (int i = 0; i < n; ++i) {
      const double gap = 0.7 / n;
      homes_.push_back(
          {MakePlate(0.7), {0.5, 0.5, 0.15 + (i + 0.5) * gap}, std::min(0.45, 3.5 * gap), false});
    }
    return;
  }
  const int side = static_cast<int>(std::ceil(std::cbrt(n)));
  const double cell = 1.0 / side;
  for (int i = 0; i < n; ++i) {
    const Place at = {(i % side + 0.5) * cell, (i / side % side + 0.5) * cell,
                      (i / (side * side) + 0.5) * cell};
    homes_.push_back({AnySolid(kind), at, 0.38 * cell, random_.OneIn(2)});
  }
}

// Another way to be at home. Some ways are those of neighbours, so that ties are common.
std::vector<Place> PolygonScript::PlacesOf(const Home& home) {
  std::array<double, 4> turn = {1, 0, 0, 0};
  if (!random_.OneIn(3)) {
    for (std::size_t k = 1; k < 4; ++k) turn[k] = (random_.Unit() - 0.5) * (home.turns ? 4 : 0.15);
  }
  double length = 0;
  for (const double x : turn) length += x * x;
  for (double& x : turn) x /= std::sqrt(length);
  const double scale = home.size * (random_.OneIn(2) ? 1 : 0.85 + 0.2 * random_.Unit());
  Place centre = home.centre;
  if (!random_.OneIn(3)) {
    for (double& c : centre) {
      c += home.size *
           (random_.OneIn(2) ? (random_.Below(3) - 1) / 16.0 : 0.1 * (random_.Unit() - 0.5));
    }
  }
  std::vector<Place> places;
  for (const Place& corner : home.solid.corners) {
    Place p = Turned(turn, corner);
    for (std::size_t k = 0; k < 3; ++k) p[k] = centre[k] + scale * p[k];
    places.push_back(p);
  }
  return places;
}

// Face f of solid k with any of its rings, from any corner, in any direction.
Feature PolygonScript::Face(std::size_t k, std::size_t f) {
  const std::vector<Rings>& variants = homes_[k].solid.faces[f];
  Rings rings =
      variants[static_cast<std::size_t>(random_.Below(static_cast<int>(variants.size())))];
  for (std::vector<FeatureId>& ring : rings) {
    for (FeatureId& id : ring) id = PointId(k, id);
    std::rotate(ring.begin(), ring.begin() + random_.Below(static_cast<int>(ring.size())),
                ring.end());
    if (random_.OneIn(2)) std::reverse(ring.begin(), ring.end());
  }
  return Feature::Polygon(FaceId(k, f), std::move(rings));
}

void PolygonScript::Come(std::size_t k, EditBatch& batch) {
  const Home& home = homes_[k];
  const std::vector<Place> places = PlacesOf(home);
  for (std::size_t i = 0; i < places.size(); ++i) {
    batch.push_back(Edit::Add(PointAt(PointId(k, i), places[i])));
  }
  for (std::size_t f = 0; f < home.solid.faces.size(); ++f) {
    if (home.solid.faces.size() == 1 || !random_.OneIn(8)) batch.push_back(Edit::Add(Face(k, f)));
  }
  for (std::size_t s = 0; s < home.solid.segments.size(); ++s) {
    const auto [p, q] = home.solid.segments[s];
    batch.push_back(
        Edit::Add(Feature::Segment(SegmentId(k, s), PointId(k, static_cast<std::size_t>(p)),
                                   PointId(k, static_cast<std::size_t>(q)))));
  }
}

void PolygonScript::Go(std::size_t k, const Present& present, EditBatch& batch) const {
  for (auto it = present.lower_bound(PointId(k, 0)); it != present.end(); ++it) {
    if (it->first >= PointId(k + 1, 0)) break;
    batch.push_back(Edit::Remove(it->first));
  }
}

void PolygonScript::Move(std::size_t k, const std::vector<Place>& places, EditBatch& batch) const {
  for (std::size_t i = 0; i < places.size(); ++i) {
    batch.push_back({Edit::Action::kMove, PointAt(PointId(k, i), places[i])});
  }
}

// A face goes or comes, or gets other rings.
void PolygonScript::ChangeFace(std::size_t k, const Present& present, bool other_rings,
                               EditBatch& batch) {
  const Solid& solid = homes_[k].solid;
  if (solid.faces.empty()) {
    const auto s = static_cast<std::size_t>(random_.Below(static_cast<int>(solid.segments.size())));
    const auto [p, q] = solid.segments[s];
    const FeatureId id = SegmentId(k, s);
    batch.push_back(present.contains(id)
                        ? Edit::Remove(id)
                        : Edit::Add(Feature::Segment(id, PointId(k, static_cast<std::size_t>(q)),
                                                     PointId(k, static_cast<std::size_t>(p)))));
    return;
  }
  const auto f = static_cast<std::size_t>(random_.Below(static_cast<int>(solid.faces.size())));
  const FeatureId id = FaceId(k, f);
  if (!present.contains(id)) {
    batch.push_back(Edit::Add(Face(k, f)));
  } else {
    batch.push_back(other_rings ? Edit::Set(Face(k, f)) : Edit::Remove(id));
  }
}

void PolygonScript::MoveCorner(std::size_t k, const Present& present, EditBatch& batch) {
  const auto count = static_cast<int>(homes_[k].solid.corners.size());
  const FeatureId id = PointId(k, static_cast<std::size_t>(random_.Below(count)));
  const auto it = present.find(id);
  if (it == present.end()) return;
  Place p = it->second.position;
  const double step = std::ldexp(0.2 * homes_[k].size, -random_.Below(8));
  for (double& x : p) x += step * (random_.Unit() - 0.5);
  batch.push_back({Edit::Action::kMove, PointAt(id, p)});
}

// Most of these have to be refused.
void PolygonScript::BreakARule(std::size_t k, const Present& present, EditBatch& batch) {
  const Home& home = homes_[k];
  const auto corner =
      static_cast<std::size_t>(random_.Below(static_cast<int>(home.solid.corners.size())));
  // A face that is no longer needed may be removed.
  const auto place_of = [&](std::size_t i) -> Place {
    const auto it = present.find(PointId(k, i));
    return it != present.end() ? it->second.position : PlacesOf(home)[i];
  };
  switch (random_.Below(5)) {
    case 0: {  // a corner alone: faces are no longer plane
      Place p = place_of(corner);
      for (double& x : p) x += 0.1 * home.size * (random_.Unit() - 0.5);
      batch.push_back({Edit::Action::kMove, PointAt(PointId(k, corner), p)});
      return;
    }
    case 1:  // a corner that is needed
      batch.push_back(Edit::Remove(PointId(k, corner)));
      return;
    case 2: {  // where another is, or across it
      Home other = home;
      other.centre = homes_[AnyHome()].centre;
      Move(k, PlacesOf(other), batch);
      return;
    }
    case 3: {  // a face twice
      if (home.solid.faces.empty()) return;
      Feature face = Face(k, 0);
      face.id = next_id_++;
      batch.push_back(Edit::Add(face));
      return;
    }
    default: {  // a point in a face, or nearly
      Place p = {0, 0, 0};
      for (std::size_t i = 0; i < 2; ++i) {
        for (std::size_t c = 0; c < 3; ++c) p[c] += 0.5 * place_of(i)[c];
      }
      p[2] += std::ldexp(1.0, -40 - random_.Below(20));
      batch.push_back(Edit::Add(PointAt(next_id_++, p)));
    }
  }
}

void PolygonScript::EditSolid(std::size_t k, const Present& present, EditBatch& batch) {
  if (!present.contains(PointId(k, 0))) return Come(k, batch);
  if (moves_corners_ && random_.OneIn(2)) return MoveCorner(k, present, batch);
  const int dice = random_.Below(20);
  if (dice < 3) return Go(k, present, batch);
  if (dice < 9) return Move(k, PlacesOf(homes_[k]), batch);
  if (dice < 13) return ChangeFace(k, present, false, batch);
  if (dice < 17) return ChangeFace(k, present, true, batch);
  BreakARule(k, present, batch);
}

// A point or a size that belongs to no solid.
void PolygonScript::EditFree(const Present& present, EditBatch& batch) {
  std::vector<const Feature*> free;
  for (auto it = present.lower_bound(1'000'000); it != present.end(); ++it) {
    free.push_back(&it->second);
  }
  Place at = {random_.Unit(), random_.Unit(), random_.Unit()};
  double size = 0.3;
  if (!random_.OneIn(4)) {  // beside a solid
    const Home& home = homes_[AnyHome()];
    for (std::size_t k = 0; k < 3; ++k) at[k] = home.centre[k] + 2 * home.size * (at[k] - 0.5);
    size = home.size;
  }
  if (free.size() < 3 || (free.size() < 8 && random_.OneIn(2))) {
    const FeatureId id = next_id_++;
    if (!sized_ || !random_.OneIn(3)) {
      batch.push_back(Edit::Add(PointAt(id, at)));
      return;
    }
    const double target = size * (0.3 + 0.3 * random_.Unit());
    batch.push_back(Edit::Add(Feature::Size(
        id, at, {random_.OneIn(2) ? SizeShape::kDisc : SizeShape::kPoint, target, 0, {}})));
    if (batch.back().feature.sizing.shape == SizeShape::kDisc) {
      batch.back().feature.sizing.radius = 0.6 * size * random_.Unit();
    }
    return;
  }
  Feature f = *free[static_cast<std::size_t>(random_.Below(static_cast<int>(free.size())))];
  if (random_.OneIn(2)) {
    batch.push_back(Edit::Remove(f.id));
  } else if (f.kind == FeatureKind::kPoint) {
    batch.push_back({Edit::Action::kMove, PointAt(f.id, at)});
  } else if (f.kind == FeatureKind::kSize) {
    f.sizing.target *= random_.OneIn(2) ? 0.8 : 1.3;
    batch.push_back(Edit::Set(f));
  }
}

EditBatch PolygonScript::Next(const std::vector<Feature>& features) {
  Present present;
  for (const Feature& f : features) present[f.id] = f;
  EditBatch batch;
  if (present.empty() && !random_.OneIn(3)) {
    for (std::size_t k = 0; k < homes_.size(); ++k) Come(k, batch);
    return batch;
  }
  if (random_.OneIn(40)) {  // all goes
    for (const auto& [id, feature] : present) batch.push_back(Edit::Remove(id));
    return batch;
  }
  std::set<std::size_t> edited;
  bool free = false;
  for (int i = random_.OneIn(5) ? 2 + random_.Below(3) : 1; i > 0; --i) {
    if (!free && random_.OneIn(free_part_)) {
      free = true;
      EditFree(present, batch);
      continue;
    }
    const auto k = AnyHome();
    if (edited.insert(k).second) EditSolid(k, present, batch);
  }
  return batch;
}

}  // namespace dynmesh::test
