// Checks that no edge of a simplex that meets a region with a target length is too long. Distances
// in long double, by more than rounding: a simplex is shrunk by a hair before, so that one which
// only touches a region counts as beside it.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "client/verify/unsplit.h"
#include "client/verify/vectors.h"
#include "client/verify/verify_internal.h"
#include "core/base/feature_kinds.h"
#include "core/base/text.h"

namespace dynmesh::cli {
namespace {

using text::Concat;

constexpr Real kHair = 1e-9L;

Vector operator-(const Vector& a, const Vector& b) { return Minus(a, b); }
Vector Along(const Vector& a, const Vector& b, Real t) {
  return {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])};
}

Real PointToSegment(const Vector& x, const Vector& a, const Vector& b) {
  const Vector u = b - a;
  const Real length2 = Dot(u, u);
  const Real t = length2 > 0 ? std::clamp<Real>(Dot(x - a, u) / length2, 0, 1) : 0;
  return Norm(x - Along(a, b, t));
}

Real SegmentToSegment(const Vector& a, const Vector& b, const Vector& p, const Vector& q) {
  const Real best = std::min({PointToSegment(a, p, q), PointToSegment(b, p, q),
                              PointToSegment(p, a, b), PointToSegment(q, a, b)});
  const Vector u = b - a, v = q - p, w = p - a;
  const Real uu = Dot(u, u), uv = Dot(u, v), vv = Dot(v, v), det = uu * vv - uv * uv;
  if (!(det > 0)) return best;
  const Real s = (Dot(u, w) * vv - uv * Dot(v, w)) / det;
  const Real t = (uv * Dot(u, w) - uu * Dot(v, w)) / det;
  if (!(s > 0 && s < 1 && t > 0 && t < 1)) return best;
  return std::min(best, Norm(Along(a, b, s) - Along(p, q, t)));
}

// Barycentric coordinates of x's projection into the triangle's plane all positive?
bool IsOver(const Vector& x, const std::array<Vector, 3>& t) {
  const Vector n = Cross(t[1] - t[0], t[2] - t[0]);
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector &a = t[i], &b = t[(i + 1) % 3];
    if (!(Dot(Cross(b - a, x - a), n) > 0)) return false;
  }
  return true;
}

Real SegmentToTriangle(const Vector& p, const Vector& q, const std::array<Vector, 3>& t) {
  Real best = INFINITY;
  for (std::size_t i = 0; i < 3; ++i) {
    best = std::min(best, SegmentToSegment(p, q, t[i], t[(i + 1) % 3]));
  }
  const Vector n = Cross(t[1] - t[0], t[2] - t[0]);
  const Real norm = Norm(n);
  if (!(norm > 0)) return best;
  const Real of_p = Dot(p - t[0], n) / norm, of_q = Dot(q - t[0], n) / norm;
  if (IsOver(p, t)) best = std::min(best, std::abs(of_p));
  if (IsOver(q, t)) best = std::min(best, std::abs(of_q));
  if (of_p * of_q < 0 && IsOver(Along(p, q, of_p / (of_p - of_q)), t)) return 0;
  return best;
}

struct Extent {
  std::array<double, 3> lo = {INFINITY, INFINITY, INFINITY};
  std::array<double, 3> hi = {-INFINITY, -INFINITY, -INFINITY};
  void Add(const Vector& p) {
    for (std::size_t k = 0; k < 3; ++k) {
      lo[k] = std::min(lo[k], static_cast<double>(p[k]));
      hi[k] = std::max(hi[k], static_cast<double>(p[k]));
    }
  }
  bool IsWithin(double distance, const Extent& other) const {
    for (std::size_t k = 0; k < 3; ++k) {
      if (lo[k] - distance > other.hi[k] || other.lo[k] - distance > hi[k]) return false;
    }
    return true;
  }
};

// A triangle in 2D, a tetrahedron in 3D, shrunk by a hair.
class Simplex {
 public:
  explicit Simplex(std::vector<Vector> corners) : corners_(std::move(corners)) {
    Vector middle = {0, 0, 0};
    for (const Vector& corner : corners_) {
      for (std::size_t k = 0; k < 3; ++k) {
        middle[k] += corner[k] / static_cast<Real>(corners_.size());
      }
    }
    for (Vector& corner : corners_) corner = Along(corner, middle, kHair);
  }

  std::span<const Vector> corners() const { return corners_; }

  bool Contains(const Vector& x) const {
    if (corners_.size() == 3) return IsOver(x, {corners_[0], corners_[1], corners_[2]});
    for (std::size_t i = 0; i < 4; ++i) {
      const auto [a, b, c] = FaceOf(i);
      const Vector n = Cross(b - a, c - a);
      if (!(Dot(n, x - a) * Dot(n, corners_[i] - a) > 0)) return false;
    }
    return true;
  }

  Real DistanceOf(const Vector& p, const Vector& q) const {
    if (Contains(p) || Contains(q)) return 0;
    Real best = INFINITY;
    if (corners_.size() == 3) {
      for (std::size_t i = 0; i < 3; ++i) {
        best = std::min(best, SegmentToSegment(p, q, corners_[i], corners_[(i + 1) % 3]));
      }
      return best;
    }
    for (std::size_t i = 0; i < 4; ++i) best = std::min(best, SegmentToTriangle(p, q, FaceOf(i)));
    return best;
  }

  // True if accept(a, b) holds for one of the edges.
  template <class Accept>
  bool AnyEdge(Accept accept) const {
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if (accept(corners_[i], corners_[j])) return true;
      }
    }
    return false;
  }

 private:
  std::array<Vector, 3> FaceOf(std::size_t opposite) const {
    return {corners_[(opposite + 1) % 4], corners_[(opposite + 2) % 4],
            corners_[(opposite + 3) % 4]};
  }

  std::vector<Vector> corners_;
};

Vector VectorOf(const std::array<double, 3>& p, int dimension) {
  return {p[0], p[1], dimension == 3 ? p[2] : 0};
}

// All within `radius` of some segments, in some shapes with what is between them.
class Region {
 public:
  Region(const Feature& size, int dimension,
         const absl::flat_hash_map<FeatureId, const Feature*>& points)
      : shape_(size.sizing.shape) {
    const Vector at = VectorOf(size.position, dimension);
    switch (shape_) {
      case SizeShape::kPoint:
        Add(at, at);
        break;
      case SizeShape::kDisc:
        radius_ = size.sizing.radius;
        Add(at, at);
        break;
      case SizeShape::kBox:
        AddBox(at, VectorOf(size.sizing.hi, dimension), dimension);
        break;
      case SizeShape::kPolygon:
        for (const auto& ring : size.rings) {
          for (std::size_t i = 0; i < ring.size(); ++i) {
            const auto p = points.find(ring[i]), q = points.find(ring[(i + 1) % ring.size()]);
            if (p == points.end() || q == points.end()) continue;  // CheckInput reports points
            Add(VectorOf(p->second->position, dimension), VectorOf(q->second->position, dimension));
          }
        }
        break;
      case SizeShape::kCapsule:
        radius_ = size.sizing.radius;
        for (std::size_t i = 1; i < size.sizing.path.size(); ++i) {
          Add(VectorOf(size.sizing.path[i - 1], dimension),
              VectorOf(size.sizing.path[i], dimension));
        }
        break;
    }
  }

  // Is it near that box? Conservative: may return true needlessly.
  bool IsNear(const Extent& extent) const { return extent_.IsWithin(radius_, extent); }

  // `around`: the simplex's box.
  bool Meets(const Simplex& simplex, const Extent& around) const {
    if (shape_ == SizeShape::kBox && MeetsBox(simplex)) return true;
    if (shape_ == SizeShape::kPolygon && IsInside(simplex.corners()[0])) return true;
    const Real reach = radius_ * (1 - kHair);
    for (std::size_t first = 0; first < segments_.size(); first += kBlock) {
      if (!blocks_[first / kBlock].IsWithin(radius_, around)) continue;
      const std::size_t last = std::min(first + kBlock, segments_.size());
      for (std::size_t i = first; i < last; ++i) {
        const auto& [p, q] = segments_[i];
        Extent extent;
        extent.Add(p), extent.Add(q);
        if (extent.IsWithin(radius_, around) && simplex.DistanceOf(p, q) <= reach) return true;
      }
    }
    return false;
  }

 private:
  static constexpr std::size_t kBlock = 64;

  void Add(const Vector& p, const Vector& q) {
    if (segments_.size() % kBlock == 0) blocks_.emplace_back();
    segments_.emplace_back(p, q);
    for (Extent* extent : {&extent_, &blocks_.back()}) extent->Add(p), extent->Add(q);
  }

  // Its edges.
  void AddBox(const Vector& lo, const Vector& hi, int dimension) {
    const int corners = 1 << dimension;
    const auto corner = [&](int i) {
      return Vector{(i & 1) != 0 ? hi[0] : lo[0], (i & 2) != 0 ? hi[1] : lo[1],
                    (i & 4) != 0 ? hi[2] : lo[2]};
    };
    for (int i = 0; i < corners; ++i) {
      for (int bit = 1; bit < corners; bit *= 2) {
        if ((i & bit) == 0) Add(corner(i), corner(i | bit));
      }
    }
  }

  // Does an edge of the simplex meet the box?
  bool MeetsBox(const Simplex& simplex) const {
    return simplex.AnyEdge([&](const Vector& a, const Vector& b) {
      Real from = 0, to = 1;
      for (std::size_t k = 0; k < 3; ++k) {
        const Real d = b[k] - a[k];
        if (d == 0 && (a[k] < extent_.lo[k] || a[k] > extent_.hi[k])) return false;
        if (d == 0) continue;
        const Real s = (extent_.lo[k] - a[k]) / d, t = (extent_.hi[k] - a[k]) / d;
        from = std::max(from, std::min(s, t)), to = std::min(to, std::max(s, t));
      }
      return from <= to;
    });
  }

  // In an odd number of rings? 2D.
  bool IsInside(const Vector& x) const {
    bool inside = false;
    for (const auto& [p, q] : segments_) {
      if ((p[1] > x[1]) == (q[1] > x[1])) continue;
      inside ^= p[0] + (x[1] - p[1]) / (q[1] - p[1]) * (q[0] - p[0]) > x[0];
    }
    return inside;
  }

  SizeShape shape_;
  double radius_ = 0;
  std::vector<std::pair<Vector, Vector>> segments_;
  // Of kBlock segments each. Segments of a polyline or ring that follow each other lie together.
  std::vector<Extent> blocks_;
  Extent extent_;
};

struct Candidate {
  double longest = 0;  // edge
  std::uint32_t simplex = 0;
  Extent extent;
};

std::vector<Vector> CornersOf(const io::IndexedMesh& mesh, std::uint32_t simplex) {
  std::vector<Vector> corners;
  const auto add = [&](const auto& vertices) {
    for (const std::uint32_t v : vertices) {
      corners.push_back(VectorOf(mesh.vertices[v].position(), mesh.dimension));
    }
  };
  mesh.dimension == 3 ? add(mesh.tetrahedra[simplex]) : add(mesh.triangles[simplex]);
  return corners;
}

// All simplices, those with long edges first.
std::vector<Candidate> CandidatesOf(const io::IndexedMesh& mesh) {
  std::vector<Candidate> candidates(mesh.simplex_count());
  for (std::uint32_t i = 0; i < candidates.size(); ++i) {
    candidates[i].simplex = i;
    const std::vector<Vector> corners = CornersOf(mesh, i);
    for (const Vector& a : corners) {
      candidates[i].extent.Add(a);
      for (const Vector& b : corners) {
        candidates[i].longest = std::max(candidates[i].longest, static_cast<double>(Norm(a - b)));
      }
    }
  }
  std::ranges::stable_sort(candidates, std::greater(), &Candidate::longest);
  return candidates;
}

}  // namespace

VerifyCheck CheckSizes(const io::IndexedMesh& mesh, const std::vector<Feature>& features) {
  Findings findings("sizes");
  absl::flat_hash_map<FeatureId, const Feature*> points;
  for (const Feature& f : features) {
    if (IsPoint(f)) points.emplace(f.id, &f);
  }
  const std::vector<Candidate> candidates = CandidatesOf(mesh);
  const double ulp = LargestUlp(mesh);
  const UnsplitCircles unsplit(mesh.dimension == 2 ? &features : nullptr);
  for (const Feature& f : features) {
    if (!Is<ASize>(f, Not<APoint, ASegment, APolygon>)) continue;
    const Region region(f, mesh.dimension, points);
    for (const Candidate& candidate : candidates) {
      const double most =
          std::numbers::sqrt2 * f.sizing.target * (1 + Slack(candidate.longest, ulp));
      if (candidate.longest <= most) break;
      if (!region.IsNear(candidate.extent)) continue;
      if (!region.Meets(Simplex(CornersOf(mesh, candidate.simplex)), candidate.extent)) continue;
      if (mesh.dimension == 2 && unsplit.ExcuseSize(mesh, mesh.triangles[candidate.simplex])) {
        continue;
      }
      findings.Add(Concat(mesh.dimension == 3 ? TetrahedronName(candidate.simplex)
                                              : TriangleName(candidate.simplex),
                          " meets the region of sizing feature ", f.id, " and has an edge of ",
                          candidate.longest, ", more than ", most));
    }
  }
  return findings.Take();
}

}  // namespace dynmesh::cli
