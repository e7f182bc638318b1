// Carries fields across an edit: conservatively, and in time that depends on the edit alone.
//
//   SlotMesh mesh = ...;                       // at the revision that `u` belongs to
//   mesh.Apply(diff);
//   u.resize(mesh.ids().size());               // one value a vertex slot
//   auto transfer = Transfer::Make(mesh);      // for any number of fields
//   transfer->Carry({.kind = FieldKind::kP1}, u);
//
// A field is an array with a row for each slot of a vertex (P1) or a simplex (all others). Before
// Carry it holds the values on the old mesh: slots that the patch freed still have theirs. After it
// holds those on the new one. What the patch does not touch keeps its value, to the bit.
//
// The removed and the added simplices of a patch fill the same region, the cavity. They are laid
// over each other (Farrell and Maddison 2011), and the mass of each old one goes to the new ones
// where it lies. What holds for every kind:
//   * the integral over the cavity and, for P1, what is around it stays but for rounding;
//   * constants stay to the bit where simplices are in proportion, else to rounding;
//   * the result is a function of the two meshes and the field: no slot or history shows in it.
//
// Mass stays in its region where the edit leaves the region's shape as it was. If the shape
// changes, what changed sides is reported.
//
// Thread-compatible.
#ifndef DYNMESH_TRANSFER_H_
#define DYNMESH_TRANSFER_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "dynmesh/slot_mesh.h"

namespace dynmesh {

// What the values of a field are, and how they are carried.
enum class FieldKind : std::uint8_t {
  // A mean for each simplex, as of finite volumes. First order: each new one gets the mean over the
  // old ones that it overlaps. Never leaves the range of these.
  kP0,
  // The same in second order: means become linear functions first, by least squares over two
  // rings of neighbours, limited where the field is not smooth. Linear fields stay linear.
  kP0Linear,
  // A value for each vertex, linear between them. New vertices are interpolated; then the
  // difference to the old field is projected (Galerkin) on the cavity's vertices and `rings` rings
  // around them. Linear fields stay linear.
  kP1,
  // A value for each corner of each simplex, in the order of its row in cells(); linear in each.
  // The L2 projection. Linear fields stay linear.
  kDG1,
  // Each new simplex gets the row of the old one that it has most in common with: for what must not
  // be averaged, such as history variables and tags. Does not conserve.
  kLargestOverlap,
};

// How one field is carried.
struct FieldOptions {
  FieldKind kind = FieldKind::kP1;  // what its values are
  int components = 1;               // in a row; of DG1 for each corner
  // Of P1: how many rings of vertices around the cavity the projection may change, 0 to 16. At 0
  // it is lumped, which smears more. Any number conserves.
  int rings = 1;
  // Each component stays within the old values of the patch, exactly. Costs accuracy at extrema. Of
  // P1 the regions of the patch then keep their mass together, not each its own.
  bool bounded = false;
};

// Mass that lay in region `from` and lies in `to` now, since the edit changed their shapes.
struct RegionFlow {
  RegionId from = kNoRegion;    // where it lay
  RegionId to = kNoRegion;      // where it lies
  std::vector<double> amounts;  // by component, in the field's unit times area or volume
};

// An old and a new simplex that have something in common.
struct OverlapPiece {
  Slot from = kNoSlot;  // of the removed simplex
  Slot to = kNoSlot;    // of the added one
  double measure = 0;   // area or volume of what they have in common
};

// The overlap of the old and the new simplices of one patch, and what it does to fields.
class Transfer {
 public:
  // For the patch of `mesh`, which must outlive the result and stay at its revision while that is
  // used. O(p lg p) for a patch of p simplices. FAILED_PRECONDITION if simplices came where
  // none were, as when a mesh is filled for the first time.
  static absl::StatusOr<Transfer> Make(const SlotMesh& mesh);

  Transfer(Transfer&&) noexcept;
  Transfer& operator=(Transfer&&) noexcept;
  ~Transfer();

  // Carries `field`, in place, as `options` say; returns what changed regions. INVALID_ARGUMENT if
  // the field does not have one row a slot, has a value in the patch that is not finite, or options
  // are out of range; FAILED_PRECONDITION if the mesh has gone on since. An error changes nothing.
  // Time is that of the patch, and of its `rings` for P1.
  absl::StatusOr<std::vector<RegionFlow>> Carry(const FieldOptions& options,
                                                std::span<double> field);

  // Carries a `density` and a `velocity` (`options`.components of it), in place, such that density
  // and momentum are conserved: their product is carried, then divided by the new density. Where
  // that is 0 the velocity is 0. The flows are those of the momentum, then those of the density.
  absl::StatusOr<std::vector<RegionFlow>> CarryMomentum(const FieldOptions& options,
                                                        std::span<double> density,
                                                        std::span<double> velocity);

  // The pieces, by new and then old simplex in the order of the patch. For transfers of one's own.
  std::vector<OverlapPiece> Pieces() const;
  // For each added simplex of the patch, the removed one that kLargestOverlap takes.
  std::vector<Slot> Donors() const;

 private:
  class Impl;
  template <std::size_t D>
  class ImplOf;
  explicit Transfer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace dynmesh

#endif  // DYNMESH_TRANSFER_H_
