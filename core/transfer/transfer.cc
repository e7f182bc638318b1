#include "dynmesh/transfer.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "core/base/text.h"
#include "core/transfer/cell_transfer.h"
#include "core/transfer/compensated_sum.h"
#include "core/transfer/dual_transfer.h"
#include "core/transfer/exchange.h"
#include "core/transfer/nodal_transfer.h"
#include "core/transfer/overlay.h"
#include "core/transfer/stencil.h"

namespace dynmesh {
namespace {

using text::Concat;
using transfer::At;

constexpr int kMostRings = 16;
constexpr int kMostComponents = 4096;

// The rows of a field for old values and for new ones: those of `slots`. `width` numbers of a
// component in a row (for DG1 one per corner).
struct Rows {
  std::span<const Slot> slots;
  std::size_t width = 1;
};

bool IsAtVertices(FieldKind kind) { return kind == FieldKind::kP1 || kind == FieldKind::kDual; }
// Has it a value at each corner of a simplex?
bool IsAtCorners(FieldKind kind) {
  return kind == FieldKind::kDG1 || kind == FieldKind::kDualCorners;
}

absl::Status NotFinite(bool of_vertex, Slot slot, double value) {
  return absl::InvalidArgumentError(
      Concat("the field is ", value, " at slot ", slot, " of a ", of_vertex ? "vertex" : "simplex",
             " that the edit concerns: only finite values can be carried; mend it before the edit "
             "or set it after it"));
}

}  // namespace

class Transfer::Impl {
 public:
  virtual ~Impl() = default;
  virtual absl::StatusOr<std::vector<RegionFlow>> Carry(const FieldOptions& options,
                                                        std::span<double> density,
                                                        std::span<double> field) = 0;
  virtual std::vector<OverlapPiece> Pieces() const = 0;
  virtual std::vector<Slot> Donors() const = 0;
};

template <std::size_t D>
class Transfer::ImplOf final : public Transfer::Impl {
 public:
  explicit ImplOf(const SlotMesh& mesh)
      : mesh_(mesh),
        from_revision_(mesh.patch().from_revision),
        to_revision_(mesh.patch().to_revision),
        overlay_(transfer::Overlay<D>::Make(mesh)),
        exchange_(overlay_),
        cells_(overlay_, exchange_) {
    for (const auto& simplex : overlay_.from) from_slots_.push_back(simplex.slot);
    for (const auto& simplex : overlay_.to) to_slots_.push_back(simplex.slot);
  }

  // With a density, `field` is a velocity.
  absl::StatusOr<std::vector<RegionFlow>> Carry(const FieldOptions& options,
                                                std::span<double> density,
                                                std::span<double> field) override {
    if (auto status = Check(options, density, field); !status.ok()) return status;
    if (overlay_.from.empty() && mesh_.patch().relabelled_simplices.empty()) {
      return std::vector<RegionFlow>();
    }
    switch (options.kind) {
      case FieldKind::kP1:
        return CarryNodes(options, density, field);
      case FieldKind::kDual:
        return CarryDual(options, density, field);
      case FieldKind::kLargestOverlap:
        return CarryDonors(options, density, field);
      default:
        return CarryCells(options, density, field);
    }
  }

  std::vector<OverlapPiece> Pieces() const override {
    std::vector<OverlapPiece> pieces;
    pieces.reserve(overlay_.pieces.size());
    std::vector<const transfer::Piece<D>*> of_one;
    for (std::size_t j = 0; j < overlay_.to.size(); ++j) {
      of_one.clear();
      for (const auto& piece : overlay_.PiecesOf(j)) {
        if (exchange_.Counts(piece)) of_one.push_back(&piece);
      }
      std::sort(of_one.begin(), of_one.end(),
                [](const auto* a, const auto* b) { return a->from < b->from; });
      for (const auto* piece : of_one) {
        pieces.push_back({from_slots_[piece->from], to_slots_[j], piece->measure()});
      }
    }
    return pieces;
  }

  std::vector<Slot> Donors() const override {
    std::vector<Slot> donors;
    if (overlay_.from.empty()) return donors;
    for (const std::uint32_t i : transfer::DonorsOf(overlay_, exchange_)) {
      donors.push_back(from_slots_[i]);
    }
    return donors;
  }

 private:
  absl::Status Check(const FieldOptions& options, std::span<const double> density,
                     std::span<const double> field) const {
    if (mesh_.revision() != to_revision_ || mesh_.patch().from_revision != from_revision_) {
      return absl::FailedPreconditionError(
          Concat("the mesh is at revision ", mesh_.revision(), ", the transfer leads to revision ",
                 to_revision_, ": carry fields before the next edit is applied"));
    }
    if (options.components < 1 || options.components > kMostComponents) {
      return absl::InvalidArgumentError(Concat("a field of ", options.components,
                                               " components: there may be 1 to ", kMostComponents));
    }
    if (options.rings < 0 || options.rings > kMostRings) {
      return absl::InvalidArgumentError(
          Concat(options.rings, " rings: there may be 0 to ", kMostRings));
    }
    const bool at_vertices = IsAtVertices(options.kind);
    const std::size_t rows = at_vertices ? mesh_.ids().size() : mesh_.regions().size();
    const std::size_t width = IsAtCorners(options.kind) ? D + 1 : 1;
    const auto check = [&](const char* name, std::size_t size, std::size_t components) {
      if (size == rows * width * components) return absl::OkStatus();
      return absl::InvalidArgumentError(Concat(
          "the ", name, " has ", size, " numbers where ", rows, " slots of ",
          at_vertices ? "vertices" : "simplices", " with ", width * components, " each make ",
          rows * width * components, ": an array has a row for every slot of the new mesh"));
    };
    if (!density.empty()) {
      if (auto status = check("density", density.size(), 1); !status.ok()) return status;
    }
    return check("field", field.size(), static_cast<std::size_t>(options.components));
  }

  // Component c of the rows as a dense array, multiplied by the density if there is one. Rows with
  // `skip` are 0.
  template <class Skip>
  static absl::StatusOr<std::vector<double>> Gather(const Rows& rows, std::size_t c,
                                                    std::size_t components, bool of_vertices,
                                                    std::span<const double> density,
                                                    std::span<const double> field,
                                                    const Skip& skip) {
    std::vector<double> values(rows.slots.size() * rows.width, 0);
    for (std::size_t i = 0; i < rows.slots.size(); ++i) {
      if (skip(i)) continue;
      for (std::size_t k = 0; k < rows.width; ++k) {
        const std::size_t row = At(rows.slots[i]) * rows.width + k;
        double value = field[row * components + c];
        if (!density.empty()) value *= density[row];
        if (!std::isfinite(value)) return NotFinite(of_vertices, rows.slots[i], value);
        values[i * rows.width + k] = value;
      }
    }
    return values;
  }

  // Writes the results, computed before, to the field: by component, in the order of the rows.
  static void Scatter(const Rows& rows, const std::vector<std::vector<double>>& results,
                      std::span<const double> new_density, std::span<double> field) {
    const std::size_t components = results.size();
    for (std::size_t i = 0; i < rows.slots.size(); ++i) {
      for (std::size_t k = 0; k < rows.width; ++k) {
        const std::size_t row = At(rows.slots[i]) * rows.width + k;
        const std::size_t at = i * rows.width + k;
        for (std::size_t c = 0; c < components; ++c) {
          double value = results[c][at];
          if (!new_density.empty()) value = new_density[at] == 0 ? 0 : value / new_density[at];
          field[row * components + c] = value;
        }
      }
    }
  }

  // Carries all components, then the density, with `carry_one` (dense old values to dense new
  // ones). Writes them at the end.
  template <class Skip, class CarryOne, class AddFlows>
  absl::StatusOr<std::vector<RegionFlow>> CarryAll(const FieldOptions& options, const Rows& sources,
                                                   const Rows& results, const Skip& skip,
                                                   std::span<double> density,
                                                   std::span<double> field,
                                                   const CarryOne& carry_one,
                                                   const AddFlows& add_flows) {
    const auto components = static_cast<std::size_t>(options.components);
    const bool of_vertices = IsAtVertices(options.kind);
    std::vector<std::vector<double>> made;
    std::map<std::pair<RegionId, RegionId>, std::vector<double>> flows;
    const std::size_t all = components + (density.empty() ? 0 : 1);
    const auto carry = [&](std::size_t slot, std::size_t c, std::size_t of, auto weight,
                           auto values) -> absl::StatusOr<std::vector<double>> {
      auto old = Gather(sources, c, of, of_vertices, weight, values, skip);
      if (!old.ok()) return old.status();
      std::vector<double> result = carry_one(*old);
      add_flows(*old, [&](RegionId from, RegionId to, double amount) {
        auto& amounts = flows[{from, to}];
        amounts.resize(all, 0);
        amounts[slot] += amount;
      });
      return result;
    };
    const std::span<const double> no_weight;
    for (std::size_t c = 0; c < components; ++c) {
      auto result =
          carry(c, c, components, std::span<const double>(density), std::span<const double>(field));
      if (!result.ok()) return result.status();
      made.push_back(*std::move(result));
    }
    std::vector<double> new_density;
    if (!density.empty()) {
      auto result = carry(components, 0, 1, no_weight, std::span<const double>(density));
      if (!result.ok()) return result.status();
      new_density = *std::move(result);
    }
    Scatter(results, made, new_density, field);
    if (!density.empty()) Scatter(results, {new_density}, {}, density);
    std::vector<RegionFlow> report;
    for (auto& [sides, amounts] : flows) {
      report.push_back({sides.first, sides.second, std::move(amounts)});
    }
    return report;
  }

  absl::StatusOr<std::vector<RegionFlow>> CarryCells(const FieldOptions& options,
                                                     std::span<double> density,
                                                     std::span<double> field) {
    const bool is_linear = options.kind == FieldKind::kP0Linear;
    const std::size_t width = IsAtCorners(options.kind) ? D + 1 : 1;
    if (is_linear && !stencil_) stencil_.emplace(mesh_, overlay_);
    std::vector<Slot> sources = from_slots_;
    if (is_linear) sources.insert(sources.end(), stencil_->kept().begin(), stencil_->kept().end());
    const std::size_t kept_count = sources.size();
    const MeshPatch& patch = mesh_.patch();
    sources.insert(sources.end(), patch.relabelled_simplices.begin(),
                   patch.relabelled_simplices.end());
    std::vector<double> at_corners;
    const auto mean = [&](const std::vector<double>& old, std::size_t i) {
      double sum = 0;
      for (std::size_t k = 0; k < width; ++k) sum += old[i * width + k];
      return sum / static_cast<double>(width);
    };
    return CarryAll(
        options, {sources, width}, {to_slots_, width}, [](std::size_t) { return false; }, density,
        field,
        [&](const std::vector<double>& old) -> std::vector<double> {
          if (overlay_.from.empty()) return {};
          const std::span<const double> values(old.data(), kept_count * width);
          if (options.kind == FieldKind::kDG1) return cells_.Functions(values, options.bounded);
          if (options.kind == FieldKind::kDualCorners) return Dual().OfCorners(values);
          if (is_linear) {
            return cells_.LinearMeans(*stencil_, values, options.bounded, at_corners);
          }
          return cells_.Means(values, options.bounded);
        },
        [&](const std::vector<double>& old, const auto& add) {
          const bool is_dual = options.kind == FieldKind::kDualCorners;
          if (is_dual && !overlay_.from.empty()) Dual().ForEachChangeOfRegion(old, add);
          for (const auto& piece : overlay_.pieces) {
            if (is_dual || !exchange_.ChangesRegion(piece)) continue;
            const double mass = is_linear ? MassOf(piece, at_corners)
                                : options.kind == FieldKind::kDG1
                                    ? MassOf(piece, old)
                                    : piece.measure() * old[piece.from];
            add(overlay_.from[piece.from].region, overlay_.to[piece.to].region, mass);
          }
          for (std::size_t r = 0; r < patch.relabelled_simplices.size(); ++r) {
            const Slot slot = patch.relabelled_simplices[r];
            add(patch.former_regions[r], mesh_.regions()[At(slot)],
                MeasureOf(slot) * mean(old, kept_count + r));
          }
        });
  }

  // The integral over a piece of the functions with the values `at_corners` at old simplices'
  // corners.
  static double MassOf(const transfer::Piece<D>& piece, const std::vector<double>& at_corners) {
    double mass = 0;
    for (std::size_t a = 0; a <= D; ++a) {
      mass += piece.share(a) * at_corners[piece.from * (D + 1) + a];
    }
    return mass;
  }

  absl::StatusOr<std::vector<RegionFlow>> CarryNodes(const FieldOptions& options,
                                                     std::span<double> density,
                                                     std::span<double> field) {
    if (overlay_.from.empty()) return std::vector<RegionFlow>();
    if (!nodes_ || rings_ != options.rings) {
      nodes_.emplace(mesh_, overlay_, exchange_, options.rings);
      rings_ = options.rings;
    }
    std::vector<typename transfer::NodalTransfer<D>::Flow> by_bounds;
    return CarryAll(
        options, {nodes_->sources(), 1}, {nodes_->results(), 1},
        [&](std::size_t i) { return nodes_->is_added(i); }, density, field,
        [&](std::vector<double>& old) {
          by_bounds.clear();
          return nodes_->Values(old, options.bounded, by_bounds);
        },
        [&](const std::vector<double>& old, const auto& add) {
          for (const auto& flow : by_bounds) add(flow.from, flow.to, flow.amount);
          std::vector<double> at_corners;
          for (std::size_t i = 0; i < overlay_.from.size(); ++i) {
            for (const std::uint32_t corner : nodes_->corners(i)) at_corners.push_back(old[corner]);
          }
          for (const auto& piece : overlay_.pieces) {
            if (!exchange_.ChangesRegion(piece)) continue;
            add(overlay_.from[piece.from].region, overlay_.to[piece.to].region,
                MassOf(piece, at_corners));
          }
        });
  }

  absl::StatusOr<std::vector<RegionFlow>> CarryDual(const FieldOptions& options,
                                                    std::span<double> density,
                                                    std::span<double> field) {
    if (overlay_.from.empty()) return std::vector<RegionFlow>();
    if (!dual_nodes_) dual_nodes_.emplace(mesh_, overlay_);
    return CarryAll(
        options, {dual_nodes_->sources(), 1}, {dual_nodes_->results(), 1},
        [&](std::size_t i) { return dual_nodes_->is_added(i); }, density, field,
        [&](const std::vector<double>& old) {
          return dual_nodes_->Values(old, Dual().OfCorners(dual_nodes_->AtCorners(old)));
        },
        [&](const std::vector<double>& old, const auto& add) {
          Dual().ForEachChangeOfRegion(dual_nodes_->AtCorners(old), add);
        });
  }

  const transfer::DualTransfer<D>& Dual() {
    if (!dual_) dual_.emplace(overlay_, exchange_);
    return *dual_;
  }

  absl::StatusOr<std::vector<RegionFlow>> CarryDonors(const FieldOptions& options,
                                                      std::span<double> density,
                                                      std::span<double> field) {
    const std::vector<Slot> donors = Donors();
    const auto copy = [&](std::span<double> values, std::size_t components) {
      for (std::size_t j = 0; j < donors.size(); ++j) {
        std::copy_n(&values[At(donors[j]) * components], components,
                    &values[At(to_slots_[j]) * components]);
      }
    };
    copy(field, static_cast<std::size_t>(options.components));
    if (!density.empty()) copy(density, 1);
    return std::vector<RegionFlow>();
  }

  double MeasureOf(Slot slot) const {
    return transfer::Measure<D>(
        transfer::CornersOf<D>(mesh_, mesh_.cells().data() + At(slot) * (D + 1)));
  }

  const SlotMesh& mesh_;
  std::uint64_t from_revision_, to_revision_;
  transfer::Overlay<D> overlay_;
  transfer::Exchange<D> exchange_;
  transfer::CellTransfer<D> cells_;
  std::vector<Slot> from_slots_, to_slots_;
  std::optional<transfer::Stencil<D>> stencil_;
  std::optional<transfer::NodalTransfer<D>> nodes_;
  std::optional<transfer::DualTransfer<D>> dual_;
  std::optional<transfer::DualNodes<D>> dual_nodes_;
  int rings_ = 0;
};

Transfer::Transfer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Transfer::Transfer(Transfer&&) noexcept = default;
Transfer& Transfer::operator=(Transfer&&) noexcept = default;
Transfer::~Transfer() = default;

absl::StatusOr<Transfer> Transfer::Make(const SlotMesh& mesh) {
  const MeshPatch& patch = mesh.patch();
  if (patch.removed_simplices.empty() != patch.added_simplices.empty()) {
    return absl::FailedPreconditionError(
        "the patch has simplices where there were none, or none where there were some: there is "
        "nothing to carry from");
  }
  if (mesh.dimension() == 2) return Transfer(std::make_unique<ImplOf<2>>(mesh));
  return Transfer(std::make_unique<ImplOf<3>>(mesh));
}

absl::StatusOr<std::vector<RegionFlow>> Transfer::Carry(const FieldOptions& options,
                                                        std::span<double> field) {
  return impl_->Carry(options, {}, field);
}

absl::StatusOr<std::vector<RegionFlow>> Transfer::CarryMomentum(const FieldOptions& options,
                                                                std::span<double> density,
                                                                std::span<double> velocity) {
  if (density.empty()) return absl::InvalidArgumentError("the density is empty");
  return impl_->Carry(options, density, velocity);
}

std::vector<OverlapPiece> Transfer::Pieces() const { return impl_->Pieces(); }
std::vector<Slot> Transfer::Donors() const { return impl_->Donors(); }

}  // namespace dynmesh
