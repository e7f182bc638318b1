#include "core/io/meshes/msh_groups.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "core/base/text.h"

namespace dynmesh::io {
namespace {

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

void MshGroups::NumberRegions() {
  for (std::uint32_t region = 0; region <= mesh_.regions.count(); ++region) {
    group_of_region_.push_back(static_cast<int>(region) + 1);
  }
  name_of_region_.resize(group_of_region_.size());
  const std::vector<double>& values = mesh_.labels.simplex_values;
  if (values.empty()) return;
  // A region whose simplices all have the same attribute has it as number.
  std::vector<std::optional<double>> value_of(group_of_region_.size());
  std::vector<bool> is_mixed(group_of_region_.size(), false);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::uint32_t region = mesh_.regions.Of(i);
    if (!value_of[region]) value_of[region] = values[i];
    if (*value_of[region] != values[i]) is_mixed[region] = true;
  }
  for (std::uint32_t region = 0; region < value_of.size(); ++region) {
    if (!value_of[region] || is_mixed[region]) continue;
    const auto name = mesh_.labels.value_names.find(*value_of[region]);
    if (name != mesh_.labels.value_names.end()) name_of_region_[region] = Quotable(name->second);
  }
  if (!mesh_.labels.replace_ids) return;
  std::set<int> taken;
  std::vector<std::uint32_t> rest;
  for (std::uint32_t region = 0; region < group_of_region_.size(); ++region) {
    const int group = value_of[region] && !is_mixed[region] ? GroupOf(*value_of[region]) : 0;
    if (group == 0) {
      rest.push_back(region);
    } else {
      taken.insert(group_of_region_[region] = group);
    }
  }
  int next = 1;
  for (const std::uint32_t region : rest) {
    while (taken.contains(next)) ++next;
    group_of_region_[region] = next++;
  }
}

std::string MshGroups::Name(int reference) const {
  const FeatureId id = FeatureOf(reference);
  const std::string name = Quotable(mesh_.labels.NameOf(id));
  if (!name.empty()) return name;
  return mesh_.labels.replace_ids ? text::Concat("marker ", Of(reference))
                                  : references_.Name(reference);
}

std::string MshGroups::NameOfRegion(std::uint32_t region) const {
  if (!name_of_region_[region].empty()) return name_of_region_[region];
  if (region != 0 && mesh_.regions.polygons[region - 1].size() == 1) {
    const std::string name = Quotable(mesh_.labels.NameOf(mesh_.regions.polygons[region - 1][0]));
    if (!name.empty()) return name;
  }
  return mesh_.regions.Name(region);
}

}  // namespace dynmesh::io
