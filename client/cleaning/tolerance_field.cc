#include "client/cleaning/tolerance_field.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <utility>

#include "client/cleaning/box_tree.h"

namespace dynmesh::cleaning {
namespace {

// Half of a cube's side, in its tolerances. Repairs that undo each other are some tolerances apart.
constexpr double kHalfSide = 8;

}  // namespace

struct ToleranceField::Tree {
  BoxTree boxes;
};

ToleranceField::ToleranceField(double least) : least_(least), tree_(std::make_unique<Tree>()) {}

ToleranceField::~ToleranceField() = default;

int ToleranceField::LevelIn(const Box3& box) const {
  int level = 0;
  if (levels_.empty()) return level;
  const TreeBox there = TreeBoxOf(box);
  for (auto it = tree_->boxes.qbegin(boost::geometry::index::intersects(there));
       it != tree_->boxes.qend(); ++it) {
    level = std::max(level, levels_[it->second]);
  }
  return level;
}

// Of the cubes that contain it.
int ToleranceField::LevelAround(const Box3& box) const {
  int level = 0;
  if (levels_.empty()) return level;
  const TreeBox there = TreeBoxOf(box);
  for (auto it = tree_->boxes.qbegin(boost::geometry::index::intersects(there));
       it != tree_->boxes.qend(); ++it) {
    if (boost::geometry::covered_by(there, it->first)) level = std::max(level, levels_[it->second]);
  }
  return level;
}

void ToleranceField::RaiseAt(std::vector<StuckPlace> places, int most_level) {
  std::sort(places.begin(), places.end());
  std::vector<int> wanted;
  wanted.reserve(places.size());
  for (const StuckPlace& place : places) {
    int level = LevelAt(place.at) + 1;
    while (Of(level) < place.wanted) ++level;
    wanted.push_back(std::min(level, most_level));
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    // Is it near the middle of a cube that is enough?
    const Box3 at = {places[i].at, places[i].at};
    const double quarter = kHalfSide / 2 * Of(wanted[i]);
    if (LevelAround(at.Grown(quarter)) >= wanted[i]) continue;
    tree_->boxes.insert(
        {TreeBoxOf(at.Grown(2 * quarter)), static_cast<std::uint32_t>(levels_.size())});
    levels_.push_back(wanted[i]);
    most_level_ = std::max(most_level_, wanted[i]);
  }
}

}  // namespace dynmesh::cleaning
