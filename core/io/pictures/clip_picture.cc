#include "core/io/pictures/clip_picture.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/geometry/circumball.h"
#include "core/io/meshes/tetrahedron_sides.h"

namespace dynmesh::io {
namespace {

using geometry::Cross;
using geometry::Difference;
using geometry::Dot;
using geometry::Vector3;
using Corners = std::array<std::uint32_t, 3>;

constexpr double kDistance = 3.4;  // of the eye from the middle, in half diagonals of the box
constexpr double kShadow = 0.72;   // the light on what faces away from the lamp

Vector3 Scaled(const Vector3& v, double factor) {
  return {v[0] * factor, v[1] * factor, v[2] * factor};
}
Vector3 Sum(const Vector3& a, const Vector3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Vector3 Unit(const Vector3& v) { return Scaled(v, 1 / std::sqrt(Dot(v, v))); }

struct Side {
  Corners corners;  // counter-clockwise as seen from outside
  std::uint32_t tetrahedron;
};

class Clip {
 public:
  Clip(const IndexedMesh& mesh, int axis, double position, const Box& box)
      : mesh_(mesh),
        axis_(static_cast<std::size_t>(axis)),
        position_(position),
        box_(box),
        camera_(box, axis),
        lamp_(Unit(Sum(Sum(Scaled(camera_.ahead, -1), Scaled(camera_.up, 0.7)),
                       Scaled(camera_.right, -0.45)))) {}

  MeshPicture Run() {
    const std::vector<Depth> depths = Depths();
    std::vector<std::pair<Depth, Side>> seen;
    for (const Side& side : Outer()) {
      if (IsSeen(side.corners)) seen.emplace_back(depths[side.tetrahedron], side);
    }
    std::sort(seen.begin(), seen.end(), [](const auto& a, const auto& b) {
      if (a.first.power != b.first.power) return a.first.power > b.first.power;
      return a.first.rank != b.first.rank ? a.first.rank < b.first.rank
                                          : a.second.corners < b.second.corners;
    });
    absl::flat_hash_map<Corners, FeatureId> owner_of;
    for (const IndexedMesh::Face& face : mesh_.faces) {
      if (face.owner != kBoxFeature) owner_of.emplace(face.corners, face.owner);
    }
    MeshPicture picture;
    for (const auto& [depth, side] : seen) {
      MeshPicture::Cell& cell = picture.cells.emplace_back();
      cell.count = 3;
      cell.simplex = side.tetrahedron;
      const double towards = std::max(Dot(Unit(Normal(side.corners)), lamp_), 0.0);
      cell.light = kShadow + (1 - kShadow) * towards;
      Corners ascending = side.corners;
      std::sort(ascending.begin(), ascending.end());
      cell.is_wall = owner_of.contains(ascending);
      for (std::size_t k = 0; k < 3; ++k) {
        cell.corners[k] = static_cast<std::uint32_t>(picture.positions.size());
        picture.positions.push_back(camera_.Project(At(side.corners[k])));
      }
    }
    return picture;
  }

 private:
  Vector3 At(std::uint32_t v) const { return mesh_.vertices[v].position(); }

  Vector3 Normal(const Corners& c) const {
    return Cross(Difference(At(c[1]), At(c[0])), Difference(At(c[2]), At(c[0])));
  }

  bool IsSeen(const Corners& c) const {
    return Dot(Normal(c), Difference(camera_.eye, At(c[0]))) > 0;
  }

  // Tetrahedra with a lesser power of the eye are in front. Those of one ball, as in a regular
  // grid, have one power. So among neighbours with one power up to rounding the side between them
  // decides: the rank is the number of them, one behind the other.
  struct Depth {
    double power = 0;
    int rank = 0;
  };
  std::vector<Depth> Depths() const {
    std::vector<Depth> depths(mesh_.tetrahedra.size());
    for (std::uint32_t i = 0; i < depths.size(); ++i) depths[i].power = PowerOf(i);
    const std::vector<std::pair<std::uint32_t, std::uint32_t>> ties = Ties(depths);
    // Each round moves the ranks, and one power for all of a ball, a step on. Balls have few
    // tetrahedra; rounding of flat ones might make a circle.
    constexpr int kMostRounds = 64;
    bool changes = true;
    for (int round = 0; changes && round < kMostRounds; ++round) {
      changes = false;
      for (const auto& [behind, front] : ties) {
        Depth &b = depths[behind], &f = depths[front];
        const double power = std::min(b.power, f.power);
        changes |= b.power != f.power || f.rank <= b.rank;
        b.power = f.power = power;
        f.rank = std::max(f.rank, b.rank + 1);
      }
    }
    return depths;
  }

  // Neighbours with one power up to rounding, the one behind first.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> Ties(
      const std::vector<Depth>& depths) const {
    constexpr double kRounding = 1e-11;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> ties;
    MatchSides([](const auto&) { return true; },
               [&](const Side& side, std::uint32_t other) {
                 const std::uint32_t i = side.tetrahedron;
                 const double a = depths[i].power, b = depths[other].power;
                 if (std::abs(a - b) > kRounding * std::max(std::abs(a), std::abs(b))) return;
                 ties.push_back(IsSeen(side.corners) ? std::pair(i, other) : std::pair(other, i));
               });
    return ties;
  }

  // Calls common(side, tetrahedron on the other side) for sides that two of the used tetrahedra
  // have. Returns those that one has.
  template <class IsUsed, class Common>
  absl::flat_hash_map<Corners, Side> MatchSides(IsUsed is_used, Common common) const {
    absl::flat_hash_map<Corners, Side> open;
    for (std::uint32_t i = 0; i < mesh_.tetrahedra.size(); ++i) {
      const IndexedMesh::Tetrahedron& t = mesh_.tetrahedra[i];
      if (!is_used(t)) continue;
      for (const auto& at : kTetrahedronSides) {
        const Side side = {{t[at[0]], t[at[1]], t[at[2]]}, i};
        Corners key = side.corners;
        std::sort(key.begin(), key.end());
        const auto [it, is_new] = open.try_emplace(key, side);
        if (is_new) continue;
        common(side, it->second.tetrahedron);
        open.erase(it);
      }
    }
    return open;
  }

  bool IsKept(const IndexedMesh::Tetrahedron& t) const {
    for (std::size_t k = 0; k < 3; ++k) {
      double middle = 0;
      for (const std::uint32_t v : t) middle += mesh_.vertices[v].position()[k] / 4;
      if (middle < box_.lo[k] || middle > box_.hi[k]) return false;
      if (k == axis_ && middle > position_) return false;
    }
    return true;
  }

  // The sides that only one of the kept tetrahedra has.
  std::vector<Side> Outer() const {
    const auto open =
        MatchSides([this](const auto& t) { return IsKept(t); }, [](const Side&, std::uint32_t) {});
    std::vector<Side> sides;
    for (const auto& [key, side] : open) sides.push_back(side);
    return sides;
  }

  // |eye - c|^2 - r^2 of the circumscribed ball.
  double PowerOf(std::uint32_t i) const {
    const IndexedMesh::Tetrahedron& t = mesh_.tetrahedra[i];
    const Vector3 o = At(t[0]);
    const Vector3 a = Difference(At(t[1]), o), b = Difference(At(t[2]), o),
                  c = Difference(At(t[3]), o);
    const double twice = 2 * Dot(a, Cross(b, c));
    const Vector3 sum = Sum(Sum(Scaled(Cross(b, c), Dot(a, a)), Scaled(Cross(c, a), Dot(b, b))),
                            Scaled(Cross(a, b), Dot(c, c)));
    const Vector3 to_eye = Difference(camera_.eye, o);
    // With the centre o + w the power is |e|^2 - 2 e . w, e from o to the eye.
    const double power = Dot(to_eye, to_eye) - 2 * Dot(to_eye, Scaled(sum, 1 / twice));
    return std::isfinite(power) ? power : Dot(to_eye, to_eye);  // flat up to rounding
  }

  const IndexedMesh& mesh_;
  const std::size_t axis_;
  const double position_;
  const Box box_;
  const ClipCamera camera_;
  const Vector3 lamp_;
};

}  // namespace

ClipCamera::ClipCamera(const Box& box, int axis) {
  // From above, whatever the axis.
  constexpr Vector3 kTowardsEye[] = {{0.78, -0.5, 0.42}, {0.5, 0.78, 0.42}, {0.36, -0.66, 0.68}};
  const Vector3 middle = Scaled(Sum(box.lo, box.hi), 0.5);
  const Vector3 diagonal = Difference(box.hi, box.lo);
  const double half = std::sqrt(Dot(diagonal, diagonal)) / 2;
  const Vector3 towards = Unit(kTowardsEye[axis]);
  eye = Sum(middle, Scaled(towards, kDistance * (half > 0 ? half : 1)));
  ahead = Scaled(towards, -1);
  right = Unit(Cross(ahead, {0, 0, 1}));
  up = Cross(right, ahead);
}

MeshPicture::Position ClipCamera::Project(const std::array<double, 3>& p) const {
  const Vector3 to = Difference(p, eye);
  const double depth = Dot(to, ahead);
  return {Dot(to, right) / depth, Dot(to, up) / depth};
}

MeshPicture ClipAt(const IndexedMesh& mesh, int axis, double position, const Box& box) {
  return Clip(mesh, axis, position, box).Run();
}

}  // namespace dynmesh::io
