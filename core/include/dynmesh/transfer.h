// Transfers fields across an edit: conservatively, and in time that depends on the edit alone.
//
//   SlotMesh mesh = ...;                       // at the revision that `u` belongs to
//   mesh.Apply(diff);
//   u.resize(mesh.ids().size());               // one value per vertex slot
//   auto transfer = Transfer::Make(mesh);      // for any number of fields
//   transfer->Carry({.kind = FieldKind::kP1}, u);
//
// A field is an array with one row per slot: of a vertex (P1, dual) or of a simplex (all others).
// Before Carry it holds the values on the old mesh, also in the slots that the patch freed. After
// Carry it holds the values on the new mesh. Values outside the patch stay, to the bit.
//
// The removed and the added simplices of a patch fill the same region, the cavity. Carry intersects
// them (Farrell and Maddison 2011) and moves the mass of each old simplex to the new ones that it
// overlaps. For every kind:
//   * the integral over the cavity (for P1: and the vertices around it that change) is conserved up
//     to rounding;
//   * constants are preserved to the bit where simplices are in proportion, else up to rounding;
//   * the result is a function of the two meshes and the field, not of slots or history.
//
// Mass stays in its region if the edit keeps the region's shape (and bounds have room for it).
// Otherwise Carry returns the mass that changed regions.
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

// The meaning of a field's values, and how they are transferred.
enum class FieldKind : std::uint8_t {
  // A mean per simplex, as of finite volumes. First order: a new simplex gets the mean over the old
  // ones that it overlaps. Stays within the range of these.
  kP0,
  // The same in second order: means are first extended to linear functions, by least squares over
  // two rings of neighbours, limited where the field is not smooth. Preserves linear fields.
  kP0Linear,
  // A value per vertex, linear in between. New vertices are interpolated. Then the difference to
  // the old field is projected (Galerkin) on the vertices of the cavity and of `rings` rings around
  // it. Preserves linear fields.
  kP1,
  // A value per corner of each simplex, in the order of its row in cells(); linear in each simplex.
  // The L2 projection. Preserves linear fields.
  kDG1,
  // A mean per vertex, over its median-dual cell: the places in the simplices around it where its
  // barycentric coordinate is the greatest. First order: a new cell gets the mean over the old ones
  // that it overlaps, so it stays within their range. A cell at a wall lies on both sides, and so
  // does what it gets; kDualCorners has its parts.
  kDual,
  // A mean over the part of a median-dual cell in each simplex, by corner, in the order of its row
  // in cells(). First order, as kDual. Mass stays in its region as that of simplices does.
  kDualCorners,
  // A new simplex gets the row of the old simplex with the largest overlap. For values that must
  // not be averaged, such as history variables and tags. Not conservative.
  kLargestOverlap,
};

// How one field is carried.
struct FieldOptions {
  FieldKind kind = FieldKind::kP1;  // the kind of its values
  int components = 1;               // in a row; of DG1 and the parts of dual cells per corner
  // P1: how many rings of vertices around the cavity the projection may change, 0 to 16. With 0 it
  // is lumped, which smears more. Any number conserves.
  int rings = 1;
  // Each component stays within the old values of the patch, exactly. Less accurate at extrema.
  // Without it, P1 overshoots at fronts: by 18 % of a jump in one edit, and more over several.
  //
  // P1: each region keeps its mass if some values within the bounds do so. Vertices on walls belong
  // to the regions on both sides, so at times there are none: then Carry returns what changes
  // sides.
  bool bounded = false;
};

// Mass that moved from region `from` to region `to`: the edit changed their shapes, or bounds left
// no room for it. The bounds' losses go to the regions that gain, in the order of ids; of regions
// with changed shapes they count all together, under the least id.
struct RegionFlow {
  RegionId from = kNoRegion;    // before the edit
  RegionId to = kNoRegion;      // after the edit
  std::vector<double> amounts;  // per component, in the field's unit times area or volume
};

// The overlap of an old and a new simplex.
struct OverlapPiece {
  Slot from = kNoSlot;  // of the removed simplex
  Slot to = kNoSlot;    // of the added one
  double measure = 0;   // area or volume of the overlap
};

// The overlap of the old and the new simplices of one patch; transfers fields.
class Transfer {
 public:
  // Makes the transfer for the patch of `mesh`, which must outlive it and stay at its revision. O(p
  // lg p) for a patch of p simplices. FAILED_PRECONDITION if the patch adds simplices where the
  // mesh had none, as when it was first filled.
  static absl::StatusOr<Transfer> Make(const SlotMesh& mesh);

  Transfer(Transfer&&) noexcept;
  Transfer& operator=(Transfer&&) noexcept;
  ~Transfer();

  // Transfers `field` in place, as `options` say; returns the flows between regions. Time: that of
  // the patch, for P1 also of the `rings`. INVALID_ARGUMENT if the field has not one row per slot,
  // has a value in the patch that is not finite, or options are out of range. FAILED_PRECONDITION
  // if the mesh has changed since Make. An error changes nothing.
  absl::StatusOr<std::vector<RegionFlow>> Carry(const FieldOptions& options,
                                                std::span<double> field);

  // Transfers a `density` and a `velocity` (of `options`.components) in place, such that mass and
  // momentum are conserved: transfers their product and divides it by the new density. Where that
  // is 0, the velocity is 0. Returns the flows of the momentum, then those of the density. Errors
  // as of Carry.
  absl::StatusOr<std::vector<RegionFlow>> CarryMomentum(const FieldOptions& options,
                                                        std::span<double> density,
                                                        std::span<double> velocity);

  // The overlaps, by new and then old simplex in the order of the patch. For custom transfers.
  std::vector<OverlapPiece> Pieces() const;
  // For each added simplex of the patch, the removed one that kLargestOverlap uses.
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
