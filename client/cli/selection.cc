#include "client/cli/selection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "client/cli/command.h"
#include "client/cli/mesh_flags.h"
#include "client/preparation/winding.h"
#include "core/base/text.h"
#include "dynmesh/part.h"
#include "dynmesh/slot_mesh.h"

namespace dynmesh::cli {
namespace {

using text::Concat;

// The polygons that some simplex lies in.
std::set<FeatureId> PolygonsPresent(const Mesh& mesh) {
  const std::set<RegionId> regions(mesh.regions.begin(), mesh.regions.end());
  std::set<FeatureId> present;
  for (const RegionId region : regions) {
    const std::vector<FeatureId> polygons = PolygonsOf(region, mesh.region_sets);
    present.insert(polygons.begin(), polygons.end());
  }
  return present;
}

std::string WhatExists(const std::set<FeatureId>& present, int dimension) {
  if (present.empty()) {
    return "the mesh has no polygons: --inside keeps what a closed outline encloses";
  }
  const std::vector<FeatureId> ids(present.begin(), present.end());
  return Concat(
      "the mesh has polygon(s) ", ListOf(ids),
      dimension == 3 ? "; a closed surface goes by one of its polygons, mostly the least id" : "");
}

// Why nothing is enclosed, in 2D: the points that only one segment ends at.
std::vector<FeatureId> FreeEnds(const Mesh& mesh) {
  std::map<VertexId, int> uses;
  for (std::size_t i = 0; i < mesh.subsegments.size(); ++i) {
    if (mesh.subsegments.owners[i] == kBoxFeature) continue;
    ++uses[mesh.subsegments.ends[2 * i]], ++uses[mesh.subsegments.ends[2 * i + 1]];
  }
  std::vector<FeatureId> ends;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const auto use = uses.find(mesh.vertices.ids[i]);
    if (use != uses.end() && use->second == 1) ends.push_back(mesh.vertices.owners[i]);
  }
  std::ranges::sort(ends);
  return ends;
}

// The same in 3D: the polygons with an edge that no other one has.
std::vector<FeatureId> FreeEdges(const Mesh& mesh) {
  struct Use {
    VertexId a, b;
    FeatureId owner;
  };
  std::vector<Use> uses;
  uses.reserve(3 * mesh.subfacets.size());
  for (std::size_t i = 0; i < mesh.subfacets.size(); ++i) {
    const VertexId* const c = &mesh.subfacets.corners[3 * i];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(c[k], c[(k + 1) % 3]);
      uses.push_back({a, b, mesh.subfacets.owners[i]});
    }
  }
  std::ranges::sort(uses, {}, [](const Use& use) { return std::pair(use.a, use.b); });
  std::set<FeatureId> polygons;
  for (auto use = uses.begin(); use != uses.end();) {
    const auto end = std::find_if(
        use, uses.end(), [&](const Use& other) { return other.a != use->a || other.b != use->b; });
    if (end - use == 1) polygons.insert(use->owner);
    use = end;
  }
  return {polygons.begin(), polygons.end()};
}

}  // namespace

bool Encloses(const Mesh& mesh) {
  return std::ranges::count(mesh_data::FindChambers(mesh).is_outside, false) != 0;
}

std::string ListOf(std::span<const FeatureId> ids) {
  constexpr std::size_t kMost = 10;
  std::string list;
  for (std::size_t i = 0; i < std::min(ids.size(), kMost); ++i) {
    list += Concat(i == 0 ? "" : ", ", ids[i]);
  }
  if (ids.size() > kMost) list += Concat(" and ", ids.size() - kMost, " more");
  return list;
}

void AddSelectionFlags(CLI::App& command, SelectionFlags& flags) {
  command.add_flag("--inside", flags.inside,
                   "Only what closed outlines (in 3D surfaces) enclose, without the holes: as "
                   "Triangle and TetGen do");
  AddRegionFlag(command, flags.region);
  AddOutsideFlag(command, flags.outside);
  AddOpenFlag(command, flags.open);
}

void AddOpenFlag(CLI::App& command, std::string& text) {
  command
      .add_option("--open", text,
                  "With --region: open what is written along these segments (in 3D polygons), as "
                  "cracks: each side has vertices of its own")
      ->type_name("ID[,ID...]");
}

void AddSurroundingsFlag(CLI::App& command, SelectionFlags& flags) {
  command.add_flag("--surroundings", flags.surroundings,
                   "Of a surface file or a map: what is around it, too (default: --inside, if "
                   "anything is enclosed)");
}

absl::StatusOr<Selection> Selection::Parse(const SelectionFlags& flags, const Input& input,
                                           bool has_holes) {
  Selection selection;
  selection.input_ = &input;
  selection.is_default_ = flags.inside_by_default && !flags.surroundings && !flags.inside &&
                          flags.region.empty() && flags.outside.empty();
  selection.inside_ = flags.inside || selection.is_default_;
  absl::StatusOr<mesh_data::RegionChoice> choice = ParseRegionFlag(flags.region);
  if (!choice.ok()) return choice.status();
  selection.by_holes_ = has_holes && flags.outside == "holes" && input.options.dimension == 3;
  if (!selection.by_holes_) {
    const auto* const holes = has_holes ? &input.hole_polygons : nullptr;
    if (auto s = ApplyOutsideFlag(flags.outside, holes, *choice); !s.ok()) return s;
  }
  selection.choice_ = *std::move(choice);
  if (!flags.open.empty()) {
    absl::StatusOr<std::vector<FeatureId>> open = ParseOpenFlag(flags.open);
    if (!open.ok()) return open.status();
    if (selection.inside_ || selection.by_holes_ ||
        (selection.choice_.in.empty() && !selection.choice_.in_any)) {
      return absl::InvalidArgumentError(
          "--open is for a part in polygons: give --region ID or --region any with it");
    }
    selection.open_ = *std::move(open);
  }
  return selection;
}

absl::StatusOr<Mesh> Selection::Of(const Mesh& mesh) const {
  if (IsEverything()) return mesh;
  if (auto status = CheckPolygons(mesh); !status.ok()) return status;
  mesh_data::RegionFilter filter(choice_, mesh.region_sets);
  std::vector<bool> keep(mesh.simplex_count());
  for (std::size_t i = 0; i < keep.size(); ++i) keep[i] = filter.Has(mesh.region(i));
  if (inside_ || by_holes_) {
    if (auto status = DropChambers(mesh, keep); !status.ok()) return status;
  }
  if (std::find(keep.begin(), keep.end(), true) == keep.end()) {
    if (!is_default_) return NothingLeft(mesh);
    PrintWarning(
        Concat("nothing is enclosed, so the whole box is written: ", WhyNothingIsInside(mesh)));
    return mesh;
  }
  return mesh_data::OnlyRows(mesh, keep);
}

absl::StatusOr<Mesh> Selection::OpenedOf(const Mesh& mesh) const {
  const absl::StatusOr<SlotMesh> slots = SlotMesh::FromMesh(mesh);
  if (!slots.ok()) return slots.status();
  const MeshPart part(
      *slots,
      {.polygons = choice_.in, .inside = choice_.in_any, .without = choice_.out, .open = open_});
  const std::span<const FeatureId> owners = part.facet_owners().span();
  const std::set<FeatureId> there(owners.begin(), owners.end());
  for (const FeatureId id : open_) {
    if (there.contains(id)) continue;
    return absl::InvalidArgumentError(
        Concat("--open: nothing of the chosen part is on feature ", id, "; ",
               mesh.dimension == 3 ? "polygons" : "segments, or edges of polygons,",
               " are opened, by their ids"));
  }
  return part.ToMesh(*slots);
}

absl::Status Selection::CheckPolygons(const Mesh& mesh) const {
  if (choice_.in.empty() && choice_.out.empty()) return absl::OkStatus();
  const std::set<FeatureId> present = PolygonsPresent(mesh);
  const std::vector<FeatureId>& holes = input_->hole_polygons;
  for (const auto& [flag, ids] :
       {std::pair("--region", &choice_.in), {"--outside", &choice_.out}}) {
    for (const FeatureId id : *ids) {
      if (present.contains(id) || std::ranges::count(holes, id) > 0) continue;
      return absl::InvalidArgumentError(Concat(flag, ": nothing of the mesh lies in polygon ", id,
                                               "; ", WhatExists(present, mesh.dimension)));
    }
  }
  return absl::OkStatus();
}

absl::Status Selection::DropChambers(const Mesh& mesh, std::vector<bool>& keep) const {
  const mesh_data::Chambers chambers = mesh_data::FindChambers(mesh);
  std::vector<bool> dropped(chambers.count(), false);
  if (inside_) {
    for (std::size_t c = 0; c < dropped.size(); ++c) {
      dropped[c] = chambers.is_outside[c] || chambers.is_hole[c];
    }
    DropCavities(mesh, chambers, dropped);
  }
  std::vector<std::array<double, 3>> seeds;
  for (const io::SeedRow& hole : input_->holes) seeds.push_back(hole.position);
  const auto places = mesh_data::LocateInChambers(mesh, chambers, seeds);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const std::string where = Concat(input_->seed_file, ":", input_->holes[i].line);
    if (places[i].is_between) {
      return absl::InvalidArgumentError(Concat(where, ": the place of a hole is on a ",
                                               mesh.dimension == 3 ? "facet" : "segment",
                                               ": move it to one side"));
    }
    const std::uint32_t c = places[i].chamber;
    if (c != mesh_data::PlaceInChambers::kNone && !chambers.is_outside[c]) {
      dropped[c] = true;
    } else if (mesh.dimension == 3 &&
               input_->holes[i].line != 0) {  // in 2D told of when its face was searched
      PrintWarning(Concat(where, ": the place of a hole is outside everything, and is ignored"));
    }
  }
  for (std::size_t i = 0; i < keep.size(); ++i) {
    if (dropped[chambers.of[i]]) keep[i] = false;
  }
  return absl::OkStatus();
}

void Selection::DropCavities(const Mesh& mesh, const mesh_data::Chambers& chambers,
                             std::vector<bool>& dropped) const {
  if (!input_->read_faces || std::ranges::count(dropped, false) < 2) return;
  // In each chamber a place that is far from its walls: the middle of a large tetrahedron.
  std::vector<double> largest(chambers.count(), -1);
  std::vector<std::array<double, 3>> middles(chambers.count());
  for (std::size_t i = 0; i < chambers.of.size(); ++i) {
    const std::uint32_t c = chambers.of[i];
    if (dropped[c]) continue;
    std::array<double, 3> middle{}, lo{}, hi{};
    for (std::size_t k = 0; k < 3; ++k) {
      lo[k] = std::numeric_limits<double>::infinity(), hi[k] = -lo[k];
      for (std::size_t v = 0; v < 4; ++v) {
        const double x = mesh.vertices.coordinates[3 * chambers.corners[4 * i + v] + k];
        middle[k] += x / 4, lo[k] = std::min(lo[k], x), hi[k] = std::max(hi[k], x);
      }
    }
    const double size = std::min({hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]});
    if (size > largest[c]) largest[c] = size, middles[c] = middle;
  }
  std::vector<std::uint32_t> looked_at;
  std::vector<std::array<double, 3>> places;
  for (std::uint32_t c = 0; c < dropped.size(); ++c) {
    if (!dropped[c]) looked_at.push_back(c), places.push_back(middles[c]);
  }
  const std::vector<Feature> faces = input_->read_faces();
  // Beyond, everything that is enclosed stays.
  constexpr std::size_t kMostAngles = 1'000'000'000;
  if (faces.empty() || places.size() > kMostAngles / faces.size()) return;
  const auto numbers = preparation::WindingNumbers(faces, places);
  if (!numbers) return;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (std::abs((*numbers)[i]) < 0.5) dropped[looked_at[i]] = true;
  }
}

absl::Status Selection::NothingLeft(const Mesh& mesh) const {
  const std::string why = inside_ ? Concat("--inside: ", WhyNothingIsInside(mesh))
                                  : Concat("--region, --outside: no part of the mesh is chosen; ",
                                           WhatExists(PolygonsPresent(mesh), mesh.dimension));
  return absl::InvalidArgumentError(Concat(why, "; nothing is written"));
}

std::string Selection::WhyNothingIsInside(const Mesh& mesh) const {
  const mesh_data::Chambers chambers = mesh_data::FindChambers(mesh);
  const auto enclosed = std::ranges::count(chambers.is_outside, false);
  if (enclosed != 0) {
    return Concat("each of the ", enclosed, " enclosed part(s) is a hole",
                  is_default_ ? "" : " or left out by --region or --outside");
  }
  const bool in_space = mesh.dimension == 3;
  const std::vector<FeatureId> loose = in_space ? FreeEdges(mesh) : FreeEnds(mesh);
  std::string message = Concat("no closed ", in_space ? "surface" : "outline");
  if (!loose.empty()) {
    message += Concat(in_space ? "; polygons with a free edge: " : "; points with one segment: ",
                      ListOf(loose));
    const std::string place = input_->where ? input_->where(loose.front()) : "";
    if (!place.empty()) message += Concat(" (the first at ", place, ")");
  }
  return message;
}

}  // namespace dynmesh::cli
