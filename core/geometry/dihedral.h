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
    const Vector3 a = Difference(p[1].c, p[0].c), b = Difference(p[2].c, p[0].c),
                  c = Difference(p[3].c, p[0].c), u = Difference(p[2].c, p[1].c),
                  w = Difference(p[3].c, p[1].c);
    // The normals of the faces, all inwards or all outwards.
    const std::array<Vector3, 4> n = {Cross(w, u), Cross(b, c), Cross(c, a), Cross(a, b)};
    std::array<double, 4> length;
    for (int i = 0; i < 4; ++i) length[i] = std::sqrt(Dot(n[i], n[i]));
    bool is_below = false;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < i; ++j) {
        // Faces i and j meet at the edge opposite to that between corners i and j.
        const bool is_small = !(-Dot(n[i], n[j]) < cosine_ * (length[i] * length[j]));
        is_below |= is_small && !is_excused(i, j);
      }
    }
    return is_below;
  }

 private:
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
