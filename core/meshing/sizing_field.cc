#include "core/meshing/sizing_field.h"

#include <algorithm>
#include <cmath>

#include "core/base/rounding.h"

namespace dynmesh::meshing {

template <int D>
double SizingRegion<D>::SquaredDistanceToBox(const geometry::Point<D>& x) const {
  double d2 = 0;
  for (int i = 0; i < D; ++i) {
    const double d = std::max({lo[i] - x[i], x[i] - hi[i], 0.0});
    d2 += d * d;
  }
  return d2;
}

template <int D>
bool SizingRegion<D>::Meets(const geometry::Point<D>& centre, double ball_radius) const {
  const double reach = ball_radius + radius;
  if (SquaredDistanceToBox(centre) > reach * reach) return false;
  return shape == nullptr || shape->Meets(centre, reach);
}

template <int D>
int SizingRegion<D>::LevelNear(const geometry::Point<D>& x, double margin, int below) const {
  using Lattice = AnchorLattice<D>;
  // Nothing finer than `below` reaches farther.
  const double far = Lattice::MostReach(below) + margin + radius;
  const double d2 = SquaredDistanceToBox(x);
  if (!(far >= 0) || d2 > far * far * kBarelyWider) return below;
  const int own = Lattice::LevelOf(target);
  const double distance = std::sqrt(d2) - radius - margin;
  int level = own;
  if (distance > 0) {
    const int octaves = (Lattice::LeastLevelAt(distance) - own) / Lattice::kOctave;
    level += std::max(octaves, 0) * Lattice::kOctave;
  }
  for (; level < below; level += Lattice::kOctave) {
    const double reach = Lattice::Reach(own, level) + margin;
    if (reach >= 0 && Meets(x, reach)) return level;
  }
  return below;
}

template struct SizingRegion<2>;
template struct SizingRegion<3>;

}  // namespace dynmesh::meshing
