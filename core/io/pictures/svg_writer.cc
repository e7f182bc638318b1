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
#include "core/io/pictures/colour_ramp.h"
#include "core/io/pictures/mesh_picture.h"
#include "core/io/pictures/picture_frame.h"
#include "core/io/pictures/svg_legend.h"
#include "dynmesh/quality.h"

namespace dynmesh::io {

using text::Concat;
namespace {

constexpr int kFillSteps = 31;
constexpr std::string_view kPlainFill = "#eaf1f6";
constexpr std::string_view kHighlightFill = "#f6a821";
constexpr std::string_view kExemptFill = "#f6a821";
constexpr std::string_view kOverRhoFill = "#b2182b";
constexpr std::string_view kBelowDihedralFill = "#7b3294";
// The least angle of the best simplex, in degrees.
constexpr double kBestAngle2D = 60;
constexpr double kBestAngle3D = 70.528779365509308;
// The position on the ramp of a triangle just within rho.
constexpr double kAtRho = 0.15;

// Lines over a fill: dark on pale fills, light on dark ones.
struct LineStyle {
  std::string_view edge;
  double edge_opacity;
  std::string_view segment;
  std::string_view box;
};
constexpr LineStyle kDarkLines = {"#38495c", 0.75, "#14213d", "#7a8794"};
constexpr LineStyle kLightLines = {"#ffffff", 0.35, "#ffb703", "#dfe7ea"};

// Hundredths of a pixel: small files, and relative moves without accumulated error.
struct Pixel {
  std::int64_t x, y;
};

void WriteHundredths(std::int64_t value, FileWriter& out) {
  if (value < 0) out << '-';
  const std::uint64_t magnitude = static_cast<std::uint64_t>(value < 0 ? -value : value);
  out << magnitude / 100;
  const std::uint64_t rest = magnitude % 100;
  if (rest == 0) return;
  out << '.' << static_cast<char>('0' + rest / 10);
  if (rest % 10 != 0) out << static_cast<char>('0' + rest % 10);
}

void WritePixel(char command, Pixel p, FileWriter& out) {
  out << command;
  WriteHundredths(p.x, out);
  out << ' ';
  WriteHundredths(p.y, out);
}

class SvgDrawing {
 public:
  SvgDrawing(const IndexedMesh& mesh, const SvgOptions& options, FileWriter& out)
      : mesh_(mesh), options_(options), out_(out) {
    if (mesh.dimension == 3) {
      cut_at_ = options.cut_at ? *options.cut_at : MiddleAlong(options.cut_axis);
      picture_ = CutThrough(mesh, options.cut_axis, cut_at_);
    } else {
      picture_ = PictureOf(mesh);
    }
    frame_ = Frame();
    FindVisible();
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
    if (options_.crop) return options_.crop->lo[k] / 2 + options_.crop->hi[k] / 2;
    double lo = 0, hi = 0;
    for (const auto& v : mesh_.vertices) {
      if (&v == &mesh_.vertices.front()) lo = hi = v.position()[k];
      lo = std::min(lo, v.position()[k]), hi = std::max(hi, v.position()[k]);
    }
    return lo / 2 + hi / 2;
  }

  // The crop, or all of the picture.
  PictureFrame Frame() const {
    PictureFrame::Position lo = {0, 0}, hi = {1, 1};
    if (options_.crop) {
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

  Pixel At(std::uint32_t index) const {
    // Far outside a narrow crop precision is irrelevant, the range is not.
    constexpr double kFar = 1e15;
    const double x = frame_.XOf(picture_.positions[index][0]) * 100;
    const double y = frame_.YOf(picture_.positions[index][1]) * 100;
    return {std::llround(std::clamp(x, -kFar, kFar)), std::llround(std::clamp(y, -kFar, kFar))};
  }

  void Open() {
    const double width = std::ceil(options_.width);
    const double height =
        std::ceil(frame_.height) + (HasLegend() ? std::ceil(LegendHeight(options_.width)) : 0);
    out_ << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << width << "\" height=\""
         << height << "\" viewBox=\"0 0 " << width << ' ' << height << "\">\n<title>Delaunay mesh, "
         << mesh_.vertices.size() << " vertices, " << mesh_.simplex_count();
    if (mesh_.dimension == 3) {
      out_ << " tetrahedra, cut at "
           << "xyz"[options_.cut_axis] << " = " << cut_at_;
    } else {
      out_ << " triangles";
    }
    out_ << "</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
  }

  void WriteCell(const MeshPicture::Cell& cell) {
    Pixel at = At(cell.corners[0]);
    WritePixel('M', at, out_);
    for (std::uint32_t k = 1; k < cell.count; ++k) {
      const Pixel next = At(cell.corners[k]);
      WritePixel('l', {next.x - at.x, next.y - at.y}, out_);
      at = next;
    }
    out_ << 'z';
  }

  void FillCells(const std::vector<std::uint32_t>& cells, std::string_view colour) {
    // The stroke covers the hairlines of antialiasing between neighbours.
    out_ << "<path fill=\"" << colour << "\" stroke=\"" << colour << "\" stroke-width=\".4\" d=\"";
    for (const std::uint32_t i : cells) WriteCell(picture_.cells[i]);
    out_ << "\"/>\n";
  }

  void DrawFills() {
    if (cells_.empty()) return;
    switch (options_.fill) {
      case SvgOptions::Fill::kNone:
        return;
      case SvgOptions::Fill::kPlain:
        return FillCells(cells_, kPlainFill);
      case SvgOptions::Fill::kExempt:
        return FillByVerdict();
      case SvgOptions::Fill::kRegion:
        return FillByRegion();
      case SvgOptions::Fill::kSize:
        return FillByValue(kSizeRamp, SizesOnRamp());
      case SvgOptions::Fill::kAngle:
      case SvgOptions::Fill::kDihedral:
      case SvgOptions::Fill::kQuality:
        return FillByValue(kQualityRamp, GoodnessOnRamp());
    }
  }

  void FillByVerdict() {
    const std::vector<SimplexVerdict> verdicts =
        JudgeSimplices(mesh_, options_.rho, options_.min_dihedral);
    constexpr std::string_view kFills[] = {kPlainFill, kExemptFill, kOverRhoFill,
                                           kBelowDihedralFill};
    std::vector<std::uint32_t> of[4];
    for (const std::uint32_t i : cells_) {
      const SimplexVerdict verdict = verdicts[SimplexOf(i)];
      of[verdict == SimplexVerdict::kGood            ? 0
         : IsExempt(verdict)                         ? 1
         : verdict == SimplexVerdict::kBelowDihedral ? 3
                                                     : 2]
          .push_back(i);
    }
    for (std::size_t v = 0; v < 4; ++v) {
      if (!of[v].empty()) FillCells(of[v], kFills[v]);
    }
  }

  void FillByRegion() {
    std::map<std::uint32_t, std::vector<std::uint32_t>> of;  // by number
    for (const std::uint32_t i : cells_) of[mesh_.regions.Of(SimplexOf(i))].push_back(i);
    for (const auto& [number, triangles] : of) {
      FillCells(triangles, number == 0 ? std::string(kPlainFill) : DistinctColour(number));
    }
  }

  // Of each visible cell, 0 (finest) to 1.
  std::vector<double> SizesOnRamp() const {
    std::vector<double> values;
    for (const std::uint32_t i : cells_) {
      values.push_back(
          std::log2(std::max(MeasureSimplex(mesh_, SimplexOf(i)).shortest_edge, 1e-300)));
    }
    const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
    const double lo = *least;
    const double extent = std::max(*greatest - lo, 1.0);
    for (double& value : values) value = (value - lo) / extent;
    return values;
  }

  // Of each visible cell, 0 (bad) to 1 (equilateral).
  std::vector<double> GoodnessOnRamp() const {
    const bool by_angle = options_.fill != SvgOptions::Fill::kQuality;
    const bool in_space = mesh_.dimension == 3;
    const double best = in_space ? std::sqrt(0.375) : 1 / std::sqrt(3.0);
    const double best_angle = in_space ? kBestAngle3D : kBestAngle2D;
    std::vector<SimplexVerdict> verdicts;
    if (!by_angle) verdicts = JudgeSimplices(mesh_, options_.rho);
    std::vector<double> values;
    for (const std::uint32_t i : cells_) {
      const SimplexMeasures q = MeasureSimplex(mesh_, SimplexOf(i));
      if (by_angle) {
        values.push_back(q.min_angle_deg / best_angle);
      } else if (IsOverRho(verdicts[SimplexOf(i)])) {
        values.push_back(0);
      } else {
        const double part = (options_.rho - q.radius_edge) / (options_.rho - best);
        values.push_back(kAtRho + (1 - kAtRho) * std::max(part, 0.0));
      }
    }
    return values;
  }

  // Groups the cells by colour: one path per colour keeps the file small.
  template <std::size_t N>
  void FillByValue(const ColourRamp<N>& ramp, const std::vector<double>& values) {
    std::map<int, std::vector<std::uint32_t>> groups;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double t = std::clamp(values[i], 0.0, 1.0);
      groups[static_cast<int>(t * (kFillSteps - 1))].push_back(cells_[i]);
    }
    for (const auto& [step, triangles] : groups) FillCells(triangles, StepColour(ramp, step));
  }

  template <std::size_t N>
  static std::string StepColour(const ColourRamp<N>& ramp, int step) {
    return ColourAt(ramp, static_cast<double>(step) / (kFillSteps - 1));
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
    return options_.fill == SvgOptions::Fill::kDihedral ||
           options_.fill == SvgOptions::Fill::kExempt;
  }

  void DrawLegend() {
    const double top = std::ceil(frame_.height);
    if (options_.fill == SvgOptions::Fill::kDihedral) {
      std::vector<std::string> colours;
      for (int step = 0; step < kFillSteps; ++step) {
        colours.push_back(StepColour(kQualityRamp, step));
      }
      WriteScale(colours, "least dihedral angle, degrees", kBestAngle3D, 10, top, options_.width,
                 out_);
    } else if (options_.fill == SvgOptions::Fill::kExempt) {
      std::vector<LegendEntry> entries = {{std::string(kPlainFill), "within rho"}};
      if (mesh_.dimension == 2) entries.push_back({std::string(kExemptFill), "over rho, exempt"});
      entries.push_back({std::string(kOverRhoFill), "over rho"});
      if (mesh_.dimension == 3 && options_.min_dihedral > 0) {
        entries.push_back(
            {std::string(kBelowDihedralFill),
             absl::StrFormat("dihedral angle below %g degrees", options_.min_dihedral)});
      }
      WriteLegend(entries, top, options_.width, out_);
    }
  }

  void WriteLine(const MeshPicture::Line& line) {
    const Pixel a = At(line.a);
    const Pixel b = At(line.b);
    WritePixel('M', a, out_);
    WritePixel('l', {b.x - a.x, b.y - a.y}, out_);
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
      WriteLine(picture_.lines[i]);
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
  const LineStyle& style_ = options_.fill == SvgOptions::Fill::kSize ? kLightLines : kDarkLines;
  PictureFrame frame_{{0, 0}, {1, 1}, 1};
  double typical_ = 1;  // length of a visible edge, pixels
  double cut_at_ = 0;   // 3D
  MeshPicture picture_;
  std::vector<std::uint32_t> cells_;  // visible ones
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
