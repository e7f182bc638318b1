#include "core/io/pictures/svg_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <string_view>
#include <utility>

#include "absl/strings/str_format.h"
#include "core/base/text.h"
#include "core/io/common/file_writer.h"
#include "core/io/pictures/clip_picture.h"
#include "core/io/pictures/colour_ramp.h"
#include "core/io/pictures/mesh_picture.h"
#include "core/io/pictures/picture_frame.h"
#include "core/io/pictures/simplex_colours.h"
#include "core/io/pictures/svg_legend.h"
#include "core/io/pictures/svg_path.h"

namespace dynmesh::io {

using text::Concat;
namespace {

// Lines over a fill. Segments are red on the blues of sizes.
struct LineStyle {
  std::string_view edge;
  double edge_opacity;
  std::string_view segment;
  std::string_view box;
};
constexpr LineStyle kDarkLines = {"#38495c", 0.75, "#14213d", "#7a8794"};
constexpr LineStyle kLinesOnSizes = {"#14213d", 0.5, "#b3261e", "#7a8794"};
// Triangles of polygons in perspective.
constexpr std::string_view kWallFill = "#e3b778";

class SvgDrawing {
 public:
  SvgDrawing(const IndexedMesh& mesh, const SvgOptions& options, FileWriter& out)
      : mesh_(mesh), options_(options), out_(out) {
    if (mesh.dimension == 3) {
      cut_at_ = options.cut_at ? *options.cut_at : MiddleAlong(options.cut_axis);
      picture_ = options.is_clip ? ClipAt(mesh, options.cut_axis, cut_at_, Shown())
                                 : CutThrough(mesh, options.cut_axis, cut_at_);
    } else {
      picture_ = PictureOf(mesh);
    }
    frame_ = Frame();
    FindVisible();
    std::vector<std::uint32_t> simplices;
    for (const std::uint32_t i : cells_) simplices.push_back(SimplexOf(i));
    colours_ = ColoursOf(mesh, options, simplices);
  }

  void Draw() {
    Open();
    DrawFills();
    DrawHighlight();
    DrawLines();
    DrawSubsegments();
    if (options_.points) DrawPoints();
    DrawLegend();
    out_ << "</svg>\n";
  }

 private:
  double MiddleAlong(int axis) const {
    const auto k = static_cast<std::size_t>(axis);
    const Box box = Shown();
    return box.lo[k] / 2 + box.hi[k] / 2;
  }

  // The crop, or the box of the vertices.
  Box Shown() const {
    if (options_.crop) return *options_.crop;
    Box box = {{0, 0, 0}, {0, 0, 0}};
    if (!mesh_.vertices.empty()) box.lo = box.hi = mesh_.vertices.front().position();
    for (const auto& v : mesh_.vertices) {
      for (std::size_t k = 0; k < 3; ++k) {
        box.lo[k] = std::min(box.lo[k], v.position()[k]);
        box.hi[k] = std::max(box.hi[k], v.position()[k]);
      }
    }
    return box;
  }

  // The crop, or all of the picture.
  PictureFrame Frame() const {
    PictureFrame::Position lo = {0, 0}, hi = {1, 1};
    if (options_.crop && !options_.is_clip) {
      const auto axes = AxesAcross(mesh_.dimension == 3 ? options_.cut_axis : 2);
      for (std::size_t k = 0; k < 2; ++k) {
        lo[k] = options_.crop->lo[axes[k]], hi[k] = options_.crop->hi[axes[k]];
      }
    } else if (!picture_.positions.empty()) {
      lo[0] = lo[1] = std::numeric_limits<double>::infinity();
      hi[0] = hi[1] = -lo[0];
      for (const auto& [x, y] : picture_.positions) {
        lo[0] = std::min(lo[0], x), lo[1] = std::min(lo[1], y);
        hi[0] = std::max(hi[0], x), hi[1] = std::max(hi[1], y);
      }
    }
    return {lo, hi, options_.width};
  }

  bool IsInView(std::span<const std::uint32_t> corners) const {
    PictureFrame::Position lo, hi;
    for (std::size_t k = 0; k < 2; ++k) {
      lo[k] = hi[k] = picture_.positions[corners[0]][k];
      for (const std::uint32_t c : corners) {
        lo[k] = std::min(lo[k], picture_.positions[c][k]),
        hi[k] = std::max(hi[k], picture_.positions[c][k]);
      }
    }
    return frame_.Shows(lo, hi);
  }

  void FindVisible() {
    for (std::uint32_t i = 0; i < picture_.cells.size(); ++i) {
      const MeshPicture::Cell& cell = picture_.cells[i];
      if (IsInView({cell.corners.data(), cell.count})) cells_.push_back(i);
    }
    std::vector<double> lengths;
    for (std::uint32_t i = 0; i < picture_.lines.size(); ++i) {
      const std::array ends = {picture_.lines[i].a, picture_.lines[i].b};
      if (!IsInView(ends)) continue;
      lines_.push_back(i);
      const auto &a = picture_.positions[ends[0]], &b = picture_.positions[ends[1]];
      lengths.push_back(std::hypot(a[0] - b[0], a[1] - b[1]) * frame_.scale);
    }
    if (lengths.empty()) return;
    const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
    std::nth_element(lengths.begin(), middle, lengths.end());
    typical_ = *middle;
  }

  Pixel At(std::uint32_t index) const { return PixelAt(frame_, picture_.positions[index]); }

  void Open() {
    const double width = std::ceil(options_.width);
    const double height =
        std::ceil(frame_.height) + (HasLegend() ? std::ceil(LegendHeight(options_.width)) : 0);
    out_ << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << width << "\" height=\""
         << height << "\" viewBox=\"0 0 " << width << ' ' << height << "\">\n<title>Delaunay mesh, "
         << mesh_.vertices.size() << " vertices, " << mesh_.simplex_count();
    if (mesh_.dimension == 3) {
      out_ << " tetrahedra, " << (options_.is_clip ? "clipped" : "cut") << " at "
           << "xyz"[options_.cut_axis] << " = " << cut_at_;
    } else {
      out_ << " triangles";
    }
    out_ << "</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
  }

  void WriteCell(const MeshPicture::Cell& cell) {
    std::array<Pixel, 4> pixels;
    for (std::uint32_t k = 0; k < cell.count; ++k) pixels[k] = At(cell.corners[k]);
    WriteLinePath({pixels.data(), cell.count}, out_);
    out_ << 'z';
  }

  void FillCells(const std::vector<std::uint32_t>& cells, std::string_view colour) {
    // The stroke covers the hairlines of antialiasing between neighbours.
    out_ << "<path fill=\"" << colour << "\" stroke=\"" << colour << "\" stroke-width=\".4\" d=\"";
    for (const std::uint32_t i : cells) WriteCell(picture_.cells[i]);
    out_ << "\"/>\n";
  }

  // One path for each colour keeps the file small.
  void DrawFills() {
    if (options_.is_clip) return DrawSolid();
    std::map<std::string_view, std::vector<std::uint32_t>> groups;
    for (std::size_t i = 0; i < colours_.of.size(); ++i)
      groups[colours_.of[i]].push_back(cells_[i]);
    for (const auto& [colour, cells] : groups) FillCells(cells, colour);
  }

  // In their order, each with its edges: what is drawn later hides what is behind it.
  void DrawSolid() {
    out_ << absl::StrFormat("<g stroke=\"%s\" stroke-width=\"%.2f\" stroke-linejoin=\"round\">\n",
                            style_.edge, options_.width / 1600);
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      const MeshPicture::Cell& cell = picture_.cells[cells_[i]];
      const std::string_view colour = cell.is_wall          ? kWallFill
                                      : colours_.of.empty() ? std::string_view("#ffffff")
                                                            : colours_.of[i];
      out_ << "<path fill=\"" << ShadedColour(colour, cell.light) << "\" d=\"";
      WriteCell(cell);
      out_ << "\"/>\n";
    }
    out_ << "</g>\n";
  }

  void DrawHighlight() {
    constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> cell_of(mesh_.simplex_count(), kNone);
    for (std::uint32_t i = 0; i < picture_.cells.size(); ++i) cell_of[SimplexOf(i)] = i;
    std::vector<std::uint32_t> shown;
    for (const std::uint32_t i : options_.highlight) {
      if (i < cell_of.size() && cell_of[i] != kNone) shown.push_back(cell_of[i]);
    }
    if (!shown.empty()) FillCells(shown, kHighlightFill);
  }

  bool HasLegend() const {
    const bool is_usual =
        options_.fill == SvgOptions::Fill::kDihedral || options_.fill == SvgOptions::Fill::kExempt;
    return (is_usual || options_.legend) &&
           !(colours_.scale.colours.empty() && colours_.entries.empty());
  }

  void DrawLegend() {
    if (!HasLegend()) return;
    const double top = std::ceil(frame_.height);
    if (colours_.entries.empty()) {
      WriteScale(colours_.scale, top, options_.width, out_);
    } else {
      WriteLegend(colours_.entries, top, options_.width, out_);
    }
  }

  template <class Wanted>
  void DrawOwned(std::string_view colour, double width, double opacity, Wanted wanted) {
    bool open = false;
    for (const std::uint32_t i : lines_) {
      if (!wanted(picture_.lines[i].owner)) continue;
      if (!open) {
        out_ << absl::StrFormat(
            "<path fill=\"none\" stroke=\"%s\" stroke-width=\"%.2f\" stroke-opacity=\"%.2f\" "
            "stroke-linecap=\"round\" d=\"",
            colour, width, opacity);
      }
      open = true;
      WriteLinePath(std::array{At(picture_.lines[i].a), At(picture_.lines[i].b)}, out_);
    }
    if (open) out_ << "\"/>\n";
  }

  void DrawLines() {
    DrawOwned(style_.edge, std::clamp(0.03 * typical_, 0.1, 0.8), style_.edge_opacity,
              [](FeatureId owner) { return owner == kNoFeature; });
  }

  void DrawSubsegments() {
    DrawOwned(style_.box, std::clamp(0.06 * typical_, 0.5, 1.5), 1,
              [](FeatureId owner) { return owner == kBoxFeature; });
    DrawOwned(style_.segment, std::clamp(0.12 * typical_, 0.9, 2.6), 1,
              [](FeatureId owner) { return owner != kNoFeature && owner != kBoxFeature; });
  }

  void DrawPoints() {
    const double radius = std::clamp(0.1 * typical_, 0.0, 3.0);
    if (radius < 0.6) return;
    out_ << "<g fill=\"" << style_.segment << "\">\n";
    for (const std::uint32_t dot : picture_.dots) {
      if (!IsInView({&dot, 1})) continue;
      const Pixel p = At(dot);
      out_ << "<circle cx=\"";
      WriteHundredths(p.x, out_);
      out_ << "\" cy=\"";
      WriteHundredths(p.y, out_);
      out_ << absl::StrFormat("\" r=\"%.2f\"/>\n", radius);
    }
    out_ << "</g>\n";
  }

  std::uint32_t SimplexOf(std::uint32_t cell) const { return picture_.cells[cell].simplex; }

  const IndexedMesh& mesh_;
  const SvgOptions& options_;
  FileWriter& out_;
  const LineStyle& style_ = options_.fill == SvgOptions::Fill::kSize ? kLinesOnSizes : kDarkLines;
  PictureFrame frame_{{0, 0}, {1, 1}, 1};
  double typical_ = 1;  // length of a visible edge, pixels
  double cut_at_ = 0;   // 3D
  MeshPicture picture_;
  std::vector<std::uint32_t> cells_;  // visible ones
  SimplexColours colours_;            // of these
  std::vector<std::uint32_t> lines_;
};

}  // namespace

absl::Status WriteSvg(const IndexedMesh& mesh, const SvgOptions& options, const std::string& path) {
  if (!(options.rho >= kMinQuality2D) || !(options.rho <= kMaxQuality)) {
    return absl::InvalidArgumentError("the rho of a picture must be 1 to 100");
  }
  if (!(options.width >= 1) || !(options.width <= 1e5)) {
    return absl::InvalidArgumentError("the width of a picture must be 1 to 100000 pixels");
  }
  if (options.cut_axis < 0 || options.cut_axis > 2) {
    return absl::InvalidArgumentError("a picture is cut across axis 0, 1 or 2");
  }
  if (!(options.min_dihedral >= 0) || !(options.min_dihedral <= kMaxMinDihedral)) {
    return absl::InvalidArgumentError("the least dihedral angle of a picture must be 0 to 20");
  }
  if (options.is_clip && mesh.dimension != 3) {
    return absl::InvalidArgumentError("only a mesh of 3D can be clipped");
  }
  MeshOptions of;
  of.dimension = mesh.dimension;
  if (auto status = CheckFill(options.fill, of); !status.ok()) return status;
  FileWriter out(path);
  SvgDrawing(mesh, options, out).Draw();
  return out.Close();
}

absl::StatusOr<SvgOptions::Fill> ParseFill(std::string_view text) {
  using Fill = SvgOptions::Fill;
  constexpr std::pair<std::string_view, Fill> kNames[] = {
      {"angle", Fill::kAngle}, {"dihedral", Fill::kDihedral}, {"quality", Fill::kQuality},
      {"size", Fill::kSize},   {"exempt", Fill::kExempt},     {"region", Fill::kRegion},
      {"plain", Fill::kPlain}, {"none", Fill::kNone}};
  for (const auto& [name, fill] : kNames) {
    if (text == name) return fill;
  }
  return absl::InvalidArgumentError(
      Concat("a fill is angle, dihedral, quality, size, exempt, region, plain or none, found ",
             text::Quoted(text)));
}

absl::Status CheckFill(SvgOptions::Fill fill, const MeshOptions& options) {
  using Fill = SvgOptions::Fill;
  if (options.kind == MeshKind::kQuadtree) {
    if (fill == Fill::kSize || fill == Fill::kPlain || fill == Fill::kNone) {
      return absl::OkStatus();
    }
    return absl::InvalidArgumentError("the fill of a quadtree's picture is size, plain or none");
  }
  if (fill != Fill::kDihedral || options.dimension == 3) return absl::OkStatus();
  return absl::InvalidArgumentError(
      "a fill by dihedral angle is of 3D, and the mesh is 2D: use angle");
}

}  // namespace dynmesh::io
