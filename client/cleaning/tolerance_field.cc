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
  BoxTree cubes;  // with their levels

  // The greatest level of the cubes for which the predicate holds; 0 if there is none.
  template <class Predicate>
  int MostLevel(const Predicate& predicate) const {
    std::uint32_t level = 0;
    for (auto it = cubes.qbegin(predicate); it != cubes.qend(); ++it) {
      level = std::max(level, it->second);
    }
    return static_cast<int>(level);
  }
};

ToleranceField::ToleranceField(double least) : least_(least), tree_(std::make_unique<Tree>()) {}

ToleranceField::~ToleranceField() = default;

int ToleranceField::LevelIn(const Box3& box) const {
  if (most_level_ == 0) return 0;
  return tree_->MostLevel(boost::geometry::index::intersects(TreeBoxOf(box)));
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
    if (tree_->MostLevel(boost::geometry::index::covers(TreeBoxOf(at.Grown(quarter)))) >= wanted[i])
      continue;
    tree_->cubes.insert({TreeBoxOf(at.Grown(2 * quarter)), static_cast<std::uint32_t>(wanted[i])});
    most_level_ = std::max(most_level_, wanted[i]);
  }
}

}  // namespace dynmesh::cleaning
