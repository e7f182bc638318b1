// The motions of corners that make patches flat, to first order: a linear system, solved by
// conjugate gradients on its normal equations. Without a solution the result is that of least
// squares; of several it is the least motion, in units of the corners' roundings.
//
// Patches without a corner in common that can move do not depend on each other. Each set of patches
// that depend on each other is solved by itself: most need few steps, and one without a solution
// takes steps of its own corners only.
//
// Thread-compatible. O(corners) for a step.
#ifndef DYNMESH_CORE_COPLANAR_FLATTEN_SYSTEM_H_
#define DYNMESH_CORE_COPLANAR_FLATTEN_SYSTEM_H_

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/geometry/circumball.h"

namespace dynmesh::coplanar {

class FlattenSystem {
 public:
  // `weights`: of corners; a coordinate with the weight 0 does not move.
  explicit FlattenSystem(std::vector<geometry::Vector3> weights) : weights_(std::move(weights)) {}

  struct Row {  // a corner of a patch
    std::size_t corner;
    double u, w;    // its place in the plane
    double height;  // over it
  };
  // Adds a patch: the heights of its corners are to be a linear function of places; or 0, if its
  // plane is `fixed`. `scale` is the unit of heights.
  void AddPatch(const geometry::Vector3& normal, std::vector<Row> rows, double scale, bool fixed);

  // The motion of each corner. Ends when heights are `enough` in the units of patches, or after
  // `most_steps`.
  std::vector<geometry::Vector3> Solve(double enough, int most_steps);

  std::size_t size() const { return corners_.size(); }
  // How many steps of corners were taken so far.
  std::size_t taken() const { return taken_; }

 private:
  struct Patch {
    std::size_t first = 0, last = 0;  // of corners_
    geometry::Vector3 normal{};       // over the scale
    bool fixed = false;
  };

  // The sets of patches that depend on each other, ascending.
  std::vector<std::vector<std::size_t>> Parts() const;
  // The system of these patches alone. corners[i]: here, of its corner i.
  FlattenSystem PartOf(const std::vector<std::size_t>& patches,
                       std::vector<std::size_t>* corners) const;
  std::vector<geometry::Vector3> SolvePart(double enough, int most_steps);

  // Of values at corners of patches: without what is linear.
  void Project(std::vector<double>& values) const;
  // Heights from motions, and back.
  void Apply(const std::vector<geometry::Vector3>& motions, std::vector<double>& heights) const;
  void Transpose(const std::vector<double>& heights, std::vector<geometry::Vector3>& motions) const;

  std::vector<geometry::Vector3> weights_;
  std::vector<Patch> patches_;
  std::vector<std::size_t> corners_;
  std::vector<double> heights_;
  std::vector<std::array<double, 3>> linear_;  // orthonormal in each patch
  std::size_t taken_ = 0;
};

}  // namespace dynmesh::coplanar

#endif  // DYNMESH_CORE_COPLANAR_FLATTEN_SYSTEM_H_
