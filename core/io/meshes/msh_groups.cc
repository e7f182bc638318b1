#include "core/io/meshes/msh_groups.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "core/base/text.h"
#include "core/io/meshes/region_labels.h"

namespace dynmesh::io {
namespace {

// The format's limit for the names of physical groups: Gmsh misreads longer ones.
constexpr std::size_t kMostNameLength = 127;
// Of groups with the name of one of a higher dimension, by dimension.
constexpr const char* kBelow[] = {" points", " edges", " faces"};
constexpr double kMostGroup = std::numeric_limits<std::int32_t>::max();

// Names stand in quotes, on a line.
std::string Quotable(std::string name) {
  for (char& c : name) {
    if (c == '"') c = '\'';
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  }
  return name;
}

// A positive whole number that a group can have, else 0.
int GroupOf(double value) {
  return value >= 1 && value <= kMostGroup && value == std::floor(value) ? static_cast<int>(value)
                                                                         : 0;
}

}  // namespace

MshGroups::MshGroups(const IndexedMesh& mesh, const References& references)
    : mesh_(mesh), references_(references) {
  std::map<std::string, int> first;  // reference of a name
  group_of_.push_back(0);
  for (int r = 1; r <= references.box(); ++r) {
    const FeatureId id = FeatureOf(r);
    if (mesh.labels.replace_ids) {
      const auto marker = id == kBoxFeature ? 0 : mesh.labels.features->MarkerOf(id);
      group_of_.push_back(GroupOf(static_cast<double>(marker)));
      continue;
    }
    const std::string name = mesh.labels.NameOf(id);
    group_of_.push_back(name.empty() ? r : first.emplace(name, r).first->second);
  }
  NumberRegions();
}

FeatureId MshGroups::FeatureOf(int reference) const {
  if (reference == references_.box()) return kBoxFeature;
  return references_.features()[static_cast<std::size_t>(reference) - 1];
}

// The numbers that regions have from the input: a region whose simplices all have the same
// attribute has it, others have the marker of their polygon; 0: none. Names come along.
std::vector<int> MshGroups::MarkersOfRegions() {
  const std::vector<RegionLabel> labels = RegionLabelsOf(mesh_);
  std::vector<int> result;
  for (const RegionLabel& label : labels) {
    result.push_back(GroupOf(static_cast<double>(label.marker)));
    name_of_region_.push_back(Quotable(label.name));
  }
  const std::vector<double>& values = mesh_.labels.simplex_values;
  if (values.empty()) return result;
  std::vector<std::optional<double>> value_of(result.size());
  std::vector<bool> is_mixed(result.size(), false);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::uint32_t region = mesh_.regions.Of(i);
    if (!value_of[region]) value_of[region] = values[i];
    if (*value_of[region] != values[i]) is_mixed[region] = true;
  }
  for (std::uint32_t region = 0; region < value_of.size(); ++region) {
    if (!value_of[region] || is_mixed[region]) continue;
    if (const int group = GroupOf(*value_of[region]); group != 0) result[region] = group;
    const auto name = mesh_.labels.value_names.find(*value_of[region]);
    if (name != mesh_.labels.value_names.end()) name_of_region_[region] = Quotable(name->second);
  }
  return result;
}

void MshGroups::NumberRegions() {
  const std::vector<int> markers = MarkersOfRegions();
  if (!mesh_.labels.replace_ids) {
    std::map<std::string, int> first;  // region of a name
    for (std::uint32_t region = 0; region < markers.size(); ++region) {
      const int number = static_cast<int>(region) + 1;
      const std::string& name = name_of_region_[region];
      group_of_region_.push_back(name.empty() ? number : first.emplace(name, number).first->second);
    }
    return;
  }
  const std::set<int> taken(markers.begin(), markers.end());
  int next = 1;
  for (const int marker : markers) {
    while (taken.contains(next)) ++next;
    group_of_region_.push_back(marker != 0 ? marker : next++);
  }
}

std::string MshGroups::NameOf(int reference) const {
  const FeatureId id = FeatureOf(reference);
  const std::string name = Quotable(mesh_.labels.NameOf(id));
  if (!name.empty()) return name;
  return mesh_.labels.replace_ids ? text::Concat("marker ", Of(reference))
                                  : references_.Name(reference);
}

// Regions of one marker without a name are a group without a polygon.
std::string MshGroups::NameOfRegion(std::uint32_t region) const {
  if (!name_of_region_[region].empty()) return name_of_region_[region];
  const int group = group_of_region_[region];
  if (std::ranges::count(group_of_region_, group) > 1) return text::Concat("marker ", group);
  return mesh_.regions.Name(region);
}

std::map<std::pair<int, int>, std::string> MshGroups::Names(
    const std::array<std::set<int>, 3>& features, const std::set<std::uint32_t>& regions,
    std::vector<std::pair<std::string, std::string>>& long_names) const {
  std::map<std::pair<int, int>, std::string> names;
  std::set<std::string> taken;
  const auto add = [&](int dimension, int group, std::string name) {
    const auto [at, is_new] = names.try_emplace({dimension, group});
    if (!is_new) return;
    if (taken.contains(name) && dimension < mesh_.dimension) name += kBelow[dimension];
    if (taken.contains(name)) name += text::Concat(' ', group);
    taken.insert(name);
    at->second = std::move(name);
  };
  // Named regions first: a name is not taken by what only has a number.
  for (const bool has_name : {true, false}) {
    for (const std::uint32_t region : regions) {
      if (name_of_region_[region].empty() == has_name) continue;
      std::string name = NameOfRegion(region);
      if (name.size() > kMostNameLength) {
        const std::string short_name = text::Concat("region ", region);
        long_names.emplace_back(short_name, std::exchange(name, short_name));
      }
      add(mesh_.dimension, group_of_region_[region], std::move(name));
    }
  }
  for (int dimension = mesh_.dimension - 1; dimension >= 0; --dimension) {
    for (const int reference : features[static_cast<std::size_t>(dimension)]) {
      if (const int group = Of(reference); group != 0) add(dimension, group, NameOf(reference));
    }
  }
  return names;
}

}  // namespace dynmesh::io
