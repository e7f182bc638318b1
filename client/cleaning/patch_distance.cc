#include "client/cleaning/patch_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "absl/container/inlined_vector.h"
#include "client/cleaning/vectors3.h"

namespace dynmesh::cleaning {
namespace {

using Piece = absl::InlinedVector<Point3, 8>;  // corners of a convex polygon, in order

// Pieces that a triangle may be cut into, and more for each target.
constexpr std::size_t kPieces = 32;
constexpr std::size_t kPiecesOfTarget = 8;

double SquaredDistanceTo(const Box3& box, const Point3& p) {
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double d = std::max({box.lo[k] - p[k], p[k] - box.hi[k], 0.0});
    sum += d * d;
  }
  return sum;
}

Point3 CenterOf(const Piece& piece) {
  Point3 sum{};
  for (const Point3& p : piece) {
    for (std::size_t k = 0; k < 3; ++k) sum[k] += p[k];
  }
  for (double& x : sum) x /= static_cast<double>(piece.size());
  return sum;
}

// Cuts at the plane through `at`: the part where `normal` points to, and the other one.
std::pair<Piece, Piece> Cut(const Piece& piece, const Point3& at, const Point3& normal) {
  std::pair<Piece, Piece> parts;
  for (std::size_t i = 0; i < piece.size(); ++i) {
    const Point3 &p = piece[i], &q = piece[(i + 1) % piece.size()];
    const double s = Dot(normal, Minus(p, at)), t = Dot(normal, Minus(q, at));
    if (s >= 0) parts.first.push_back(p);
    if (s <= 0) parts.second.push_back(p);
    if ((s > 0 && t < 0) || (s < 0 && t > 0)) {
      const Point3 x = Along(p, s / (s - t), Minus(q, p));
      parts.first.push_back(x);
      parts.second.push_back(x);
    }
  }
  return parts;
}

// At half of the longest side of its box.
std::pair<Piece, Piece> Halves(const Piece& piece) {
  const auto [lo, hi] = Box3::Of(piece);
  const std::size_t axis = AxisOf(Minus(hi, lo));
  Point3 normal{}, middle{};
  normal[axis] = 1;
  middle[axis] = lo[axis] + (hi[axis] - lo[axis]) / 2;
  return Cut(piece, middle, normal);
}

}  // namespace

Point3 NearestOn(const TriangleCorners& triangle, const Point3& p) {
  const auto& [a, b, c] = triangle;
  const Point3 ab = Minus(b, a), ac = Minus(c, a), ap = Minus(p, a);
  const double d1 = Dot(ab, ap), d2 = Dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Point3 bp = Minus(p, b);
  const double d3 = Dot(ab, bp), d4 = Dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return Along(a, d1 / (d1 - d3), ab);
  const Point3 cp = Minus(p, c);
  const double d5 = Dot(ab, cp), d6 = Dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return Along(a, d2 / (d2 - d6), ac);
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    return Along(b, (d4 - d3) / ((d4 - d3) + (d5 - d6)), Minus(c, b));
  }
  const double sum = va + vb + vc;
  return Along(Along(a, vb / sum, ab), vc / sum, ac);
}

DistanceTarget::DistanceTarget(const TriangleCorners& triangle)
    : corners(triangle), box(Box3::Of(triangle)) {
  const Point3 normal = NormalOf(corners[0], corners[1], corners[2]);
  for (std::size_t i = 0; i < 3; ++i) {
    inwards[i] = UnitOf(Cross(normal, Minus(corners[(i + 1) % 3], corners[i])));
  }
}

bool IsWithin(const TriangleCorners& triangle, std::span<const DistanceTarget> targets,
              double distance, std::vector<std::uint32_t>& used) {
  const double most = distance * distance;
  std::size_t left = kPieces + kPiecesOfTarget * targets.size();
  std::vector<Piece> pieces = {Piece(triangle.begin(), triangle.end())};
  while (!pieces.empty()) {
    if (left-- == 0) return false;
    const Piece piece = std::move(pieces.back());
    pieces.pop_back();
    const Point3 center = CenterOf(piece);
    double least = std::numeric_limits<double>::infinity();
    std::uint32_t nearest = 0;
    for (std::uint32_t i = 0; i < targets.size(); ++i) {
      if (SquaredDistanceTo(targets[i].box, center) >= least) continue;
      const double d2 = SquaredDistance<3>(center, NearestOn(targets[i].corners, center));
      if (d2 < least) least = d2, nearest = i;
    }
    if (!(least <= most)) return false;
    // Of the corners that are too far away: the edge that one is farthest beyond.
    const DistanceTarget& target = targets[nearest];
    bool is_near = true;
    double outmost = 0;
    std::size_t edge = 3;
    for (const Point3& p : piece) {
      if (SquaredDistance<3>(p, NearestOn(target.corners, p)) <= most) continue;
      is_near = false;
      for (std::size_t i = 0; i < 3; ++i) {
        const double s = Dot(target.inwards[i], Minus(p, target.corners[i]));
        if (s < outmost) outmost = s, edge = i;
      }
    }
    if (is_near) {
      used.push_back(nearest);
      continue;
    }
    std::pair<Piece, Piece> parts;
    if (edge < 3) parts = Cut(piece, target.corners[edge], target.inwards[edge]);
    if (parts.first.size() < 3 || parts.second.size() < 3) parts = Halves(piece);
    for (Piece* part : {&parts.first, &parts.second}) {
      if (part->size() > 2) pieces.push_back(std::move(*part));
    }
  }
  return true;
}

}  // namespace dynmesh::cleaning
