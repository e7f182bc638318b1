// Compares the dihedral angles of a tetrahedron to a bound. Pure functions of coordinates, to the
// bit: corners are sorted by position, and libm is not used. Thread-safe; O(1).
#ifndef DYNMESH_CORE_GEOMETRY_DIHEDRAL_H_
#define DYNMESH_CORE_GEOMETRY_DIHEDRAL_H_

#include <algorithm>
#include <array>
#include <cmath>

#include "core/geometry/circumball.h"
#include "core/geometry/point.h"

namespace dynmesh::geometry {

class DihedralBound {
 public:
  // In degrees, from 0 to 30.
  explicit DihedralBound(double degrees) : degrees_(degrees), cosine_(CosineOf(degrees)) {}

  double degrees() const { return degrees_; }
  // A little less than the bound's; 2 for a bound of 0.
  double cosine() const { return cosine_; }

  // True if one of the six angles is less than the bound. Also true for flat tetrahedra, and for
  // angles that equal the bound within rounding. If it is false, no angle is less, however angles
  // are rounded.
  bool IsBelow(std::array<Point3, 4> corners) const {
    // A network of five comparisons.
    const auto sort = [&](int i, int j) {
      if (corners[j] < corners[i]) std::swap(corners[i], corners[j]);
    };
    sort(0, 1), sort(2, 3), sort(0, 2), sort(1, 3), sort(1, 2);
    return IsBelowSorted(corners);
  }
  // The same for corners sorted by position.
  bool IsBelowSorted(const std::array<Point3, 4>& p) const {
    return IsBelowSorted(p, [](int, int) { return false; });
  }
  // The same without the angles opposite to excused edges: is_excused(i, j), of the edge between
  // corners j < i.
  template <class IsExcused>
  bool IsBelowSorted(const std::array<Point3, 4>& p, IsExcused is_excused) const {
    const Normals of(p);
    bool is_below = false;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < i; ++j) {
        // Faces i and j meet at the edge opposite to that between corners i and j.
        const bool is_small = !(-Dot(of.n[i], of.n[j]) < cosine_ * (of.length[i] * of.length[j]));
        is_below |= is_small && !is_excused(i, j);
      }
    }
    return is_below;
  }

  // What is certain whatever the order of the corners, so that they need not be sorted: no angle is
  // below the bound; or one is, and counts. counts(i, j): the angle opposite to the edge between
  // corners j < i surely does. kUnsure: neither. Twice as fast.
  enum class Certain { kNone, kOne, kUnsure };
  template <class Counts>
  Certain Look(const std::array<Point3, 4>& p, Counts counts) const {
    const Normals of(p);
    // Components of a normal are sums of products of two edges, each rounded a few times; with
    // another corner as origin, other ones.
    const double error = kRounding * of.most2;
    if (!(of.most2 > kUnderflow)) return Certain::kUnsure;
    bool is_none = true, is_one = false;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < i; ++j) {
        const double at = -Dot(of.n[i], of.n[j]), bound = cosine_ * (of.length[i] * of.length[j]),
                     slack = error * (of.length[i] + of.length[j] + error) + kRounding * bound;
        is_none &= at < bound - slack;
        is_one |= at > bound + slack && counts(i, j);
      }
    }
    return is_none ? Certain::kNone : is_one ? Certain::kOne : Certain::kUnsure;
  }

 private:
  // 2^-43: a thousand roundings.
  static constexpr double kRounding = 1.13686837721616e-13;
  // Of more, numbers too small for a double are smaller than the roundings allowed for.
  static constexpr double kUnderflow = 1e-140;

  // Of the faces, all inwards or all outwards.
  struct Normals {
    explicit Normals(const std::array<Point3, 4>& p) {
      const Vector3 a = Difference(p[1].c, p[0].c), b = Difference(p[2].c, p[0].c),
                    c = Difference(p[3].c, p[0].c), u = Difference(p[2].c, p[1].c),
                    w = Difference(p[3].c, p[1].c);
      n = {Cross(w, u), Cross(b, c), Cross(c, a), Cross(a, b)};
      for (int i = 0; i < 4; ++i) length[i] = std::sqrt(Dot(n[i], n[i]));
      most2 = Dot(a, a) + Dot(b, b) + Dot(c, c);
    }
    std::array<Vector3, 4> n;
    std::array<double, 4> length;
    double most2;  // at least half of the product of any two edges
  };

  // Taylor's series, in a fixed order of operations; a little less than the cosine.
  static double CosineOf(double degrees) {
    if (degrees == 0) return 2;
    const double x = degrees * 0.017453292519943295, x2 = x * x;
    double sum = 0;
    for (int k = 9; k > 0; --k) sum = (1 - sum) * x2 / (2 * k * (2 * k - 1));
    return (1 - sum) * (1 - 1e-12);
  }

  double degrees_, cosine_;
};

}  // namespace dynmesh::geometry

#endif  // DYNMESH_CORE_GEOMETRY_DIHEDRAL_H_
