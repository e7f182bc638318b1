#include "core/io/pictures/leaf_svg.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>
#include <vector>

#include "absl/strings/str_format.h"
#include "core/io/common/file_writer.h"
#include "core/io/pictures/colour_ramp.h"
#include "core/io/pictures/mesh_picture.h"
#include "core/io/pictures/picture_frame.h"
#include "core/io/pictures/svg_legend.h"

namespace dynmesh::io {
namespace {

constexpr std::string_view kPlainFill = "#eaf1f6", kLine = "#38495c";

// All leaves of one level are one path.
void DrawLevel(const std::vector<const QuadtreeCell*>& leaves, const PictureFrame& frame,
               const std::array<std::size_t, 2>& axes, std::string_view fill, std::string_view line,
               FileWriter& out) {
  const double side = leaves.front()->side * frame.scale;
  out << absl::StrFormat("<path fill=\"%s\" stroke=\"%s\" stroke-width=\"%.2f\" d=\"", fill, line,
                         std::clamp(0.03 * side, 0.1, 0.8));
  for (const QuadtreeCell* leaf : leaves) {
    out << absl::StrFormat("M%.2f %.2fh%.2fv%.2fh%.2fz", frame.XOf(leaf->box.lo[axes[0]]),
                           frame.YOf(leaf->box.hi[axes[1]]), side, side, -side);
  }
  out << "\"/>\n";
}

}  // namespace

absl::Status WriteLeafSvg(const LeafList& list, const SvgOptions& options,
                          const std::string& path) {
  using Fill = SvgOptions::Fill;
  MeshOptions quadtree;
  quadtree.kind = MeshKind::kQuadtree;
  if (auto status = CheckFill(options.fill, quadtree); !status.ok()) return status;
  if (!(options.width >= 1) || !(options.width <= 1e5)) {
    return absl::InvalidArgumentError("the width of a picture must be 1 to 100000 pixels");
  }
  Box box;
  for (std::size_t k = 0; k < 3; ++k) {
    box.lo[k] = std::numeric_limits<double>::infinity(), box.hi[k] = -box.lo[k];
    for (const LeafList::Leaf& leaf : list.leaves) {
      box.lo[k] = std::min(box.lo[k], leaf.cell.box.lo[k]);
      box.hi[k] = std::max(box.hi[k], leaf.cell.box.hi[k]);
    }
  }
  if (options.crop) box = *options.crop;
  const bool is_cut = list.dimension == 3;
  const auto axes = AxesAcross(is_cut ? options.cut_axis : 2);
  const auto across = static_cast<std::size_t>(options.cut_axis);
  const double cut_at = options.cut_at.value_or(box.lo[across] / 2 + box.hi[across] / 2);
  const PictureFrame frame({box.lo[axes[0]], box.lo[axes[1]]}, {box.hi[axes[0]], box.hi[axes[1]]},
                           options.width);

  std::map<int, std::vector<const QuadtreeCell*>> levels;
  for (const LeafList::Leaf& leaf : list.leaves) {
    const Box& b = leaf.cell.box;
    if (is_cut && !(b.lo[across] <= cut_at && cut_at < b.hi[across])) continue;
    if (!frame.Shows({b.lo[axes[0]], b.lo[axes[1]]}, {b.hi[axes[0]], b.hi[axes[1]]})) continue;
    levels[leaf.cell.level].push_back(&leaf.cell);
  }

  FileWriter out(path);
  const bool has_legend = options.legend && options.fill == Fill::kSize && !levels.empty();
  const double width = std::ceil(options.width);
  const double height =
      std::ceil(frame.height) + (has_legend ? std::ceil(LegendHeight(options.width)) : 0);
  out << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << width << "\" height=\"" << height
      << "\" viewBox=\"0 0 " << width << ' ' << height << "\">\n<title>"
      << (is_cut ? "Octree, " : "Quadtree, ") << list.leaves.size() << " leaves";
  if (is_cut)
    out << ", cut at "
        << "xyz"[across] << " = " << cut_at;
  out << "</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
  Scale scale = {"side of a cell", {}, {}};
  for (const auto& [level, leaves] : levels) {
    const int coarsest = levels.begin()->first, finest = levels.rbegin()->first;
    const double t =
        finest > coarsest ? static_cast<double>(finest - level) / (finest - coarsest) : 1;
    const std::string fill = options.fill == Fill::kSize    ? ColourAt(kSizeRamp, t)
                             : options.fill == Fill::kPlain ? std::string(kPlainFill)
                                                            : "none";
    DrawLevel(leaves, frame, axes, fill, kLine, out);
    scale.colours.push_back(fill);
    if (level == coarsest) {
      scale.ticks.push_back({1, absl::StrFormat("%g", leaves.front()->side)});
    } else if (level == finest) {
      scale.ticks.push_back({0, absl::StrFormat("%g", leaves.front()->side)});
    }
  }
  if (has_legend) {
    std::reverse(scale.colours.begin(), scale.colours.end());  // the finest first
    WriteScale(scale, std::ceil(frame.height), options.width, out);
  }
  out << "</svg>\n";
  return out.Close();
}

}  // namespace dynmesh::io
