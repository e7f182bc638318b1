// The cleaning of a file's geometry with one tolerance, and a bound of how far it moves anything.
#ifndef DYNMESH_CLIENT_PREPARATION_CLEANER_H_
#define DYNMESH_CLIENT_PREPARATION_CLEANER_H_

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/preparation/prepare.h"
#include "core/io/formats/geometry.h"
#include "dynmesh/feature.h"

namespace dynmesh::preparation {

// How to clean.
struct Cleaning {
  double tolerance = 0;
  // In 3D: what meets at less than so many degrees becomes one.
  double least_angle = 0;
  // In 3D: so long edges of thin faces may become a point (SurfaceCleanOptions).
  double most_contraction = 0;
  std::uint64_t steps = 0;
};

// The geometry that a file has, as it is to be cleaned. Thread-compatible; const methods
// thread-safe.
class Cleaner {
 public:
  // `is_closed`: the input has no open edges. `within`: what may be moved by at most.
  Cleaner(io::Geometry raw, const io::GeometryOptions& reading, bool is_surface, bool is_closed,
          double within);

  // What cleaning makes.
  // RESOURCE_EXHAUSTED and INVALID_ARGUMENT as cleaning; OUT_OF_RANGE if it is too far from the
  // input; NOT_FOUND if nothing is left; FAILED_PRECONDITION if edges are open and that is no use.
  // Expected O(n lg n).
  absl::StatusOr<Prepared> Clean(const Cleaning& how, bool is_open_no_use) const;

  bool is_in_space() const { return raw_.options.dimension == 3; }

  // Of cleaning in 3D, for one tolerance.
  std::uint64_t Steps() const;

  // Those to be tried, ascending.
  std::vector<double> Tolerances() const;

 private:
  // A bound of how far the result and the input are from each other; nothing if it is too much.
  std::optional<double> FarthestOf(const Prepared& prepared) const;
  absl::Status CleanPlane(double tolerance, Prepared& prepared) const;
  absl::Status CleanSpace(const Cleaning& how, std::vector<FeatureId>& doubled,
                          Prepared& prepared) const;
  // New segments follow the one that they are a part of.
  std::vector<std::pair<FeatureId, FeatureId>> PartsOf(const std::vector<Feature>& features) const;

  io::Geometry raw_;
  io::GeometryOptions reading_;
  bool is_surface_, is_closed_;
  double within_;
};

}  // namespace dynmesh::preparation

#endif  // DYNMESH_CLIENT_PREPARATION_CLEANER_H_
