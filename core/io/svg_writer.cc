#include "core/io/svg_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string_view>
#include <utility>

#include "absl/strings/str_format.h"
#include "core/data/text.h"
#include "core/io/colour_ramp.h"
#include "core/io/file_writer.h"
#include "dynmesh/quality.h"

namespace dynmesh::io {

using data::Concat;
namespace {

constexpr int kFillSteps = 31;
constexpr std::string_view kPlainFill = "#eaf1f6";
constexpr std::string_view kHighlightFill = "#f6a821";
constexpr std::string_view kExemptFill = "#f6a821";
constexpr std::string_view kOverRhoFill = "#b2182b";
// Where on the ramp a triangle stands that is just within rho.
constexpr double kAtRho = 0.15;

// Lines over a fill: dark on the pale ones, light on the dark one.
struct LineStyle {
  std::string_view edge;
  double edge_opacity;
  std::string_view segment;
  std::string_view box;
};
constexpr LineStyle kDarkLines = {"#38495c", 0.75, "#14213d", "#7a8794"};
constexpr LineStyle kLightLines = {"#ffffff", 0.35, "#ffb703", "#dfe7ea"};

// Hundredths of a pixel: small files, and relative moves without drift.
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
    FitView();
    FindVisible();
  }

  void Draw() {
    Open();
    DrawFills();
    DrawHighlight();
    DrawLines();
    DrawSubsegments();
    if (options_.points) DrawPoints();
    out_ << "</svg>\n";
  }

 private:
  // Chooses the part shown and its scale; a crop without extent shows a little around it.
  void FitView() {
    double lo[2] = {0, 0};
    double hi[2] = {1, 1};
    if (options_.crop) {
      lo[0] = options_.crop->lo[0], lo[1] = options_.crop->lo[1];
      hi[0] = options_.crop->hi[0], hi[1] = options_.crop->hi[1];
    } else if (!mesh_.vertices.empty()) {
      lo[0] = lo[1] = std::numeric_limits<double>::infinity();
      hi[0] = hi[1] = -lo[0];
      for (const auto& v : mesh_.vertices) {
        lo[0] = std::min(lo[0], v.x), lo[1] = std::min(lo[1], v.y);
        hi[0] = std::max(hi[0], v.x), hi[1] = std::max(hi[1], v.y);
      }
    }
    double extent = std::max(hi[0] - lo[0], hi[1] - lo[1]);
    if (!(extent > 0)) extent = 1;
    // A margin, and no side less than a tenth of the other.
    for (std::size_t i = 0; i < 2; ++i) {
      const double grow = 0.02 * extent + std::max(0.0, 0.1 * extent - (hi[i] - lo[i])) / 2;
      lo_[i] = lo[i] - grow;
      hi_[i] = hi[i] + grow;
    }
    scale_ = options_.width / (hi_[0] - lo_[0]);
    height_ = (hi_[1] - lo_[1]) * scale_;
  }

  bool Overlaps(double x0, double y0, double x1, double y1) const {
    return x0 <= hi_[0] && x1 >= lo_[0] && y0 <= hi_[1] && y1 >= lo_[1];
  }

  void FindVisible() {
    for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i) {
      const auto& a = Corner(i, 0);
      const auto& b = Corner(i, 1);
      const auto& c = Corner(i, 2);
      const auto [x0, x1] = std::minmax({a.x, b.x, c.x});
      const auto [y0, y1] = std::minmax({a.y, b.y, c.y});
      if (Overlaps(x0, y0, x1, y1)) triangles_.push_back(i);
    }
    std::vector<double> lengths;
    for (std::uint32_t i = 0; i < mesh_.edges.size(); ++i) {
      const auto& a = mesh_.vertices[mesh_.edges[i].a];
      const auto& b = mesh_.vertices[mesh_.edges[i].b];
      const auto [x0, x1] = std::minmax(a.x, b.x);
      const auto [y0, y1] = std::minmax(a.y, b.y);
      if (!Overlaps(x0, y0, x1, y1)) continue;
      edges_.push_back(i);
      lengths.push_back(std::hypot(a.x - b.x, a.y - b.y) * scale_);
    }
    if (lengths.empty()) return;
    const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
    std::nth_element(lengths.begin(), middle, lengths.end());
    typical_ = *middle;
  }

  const IndexedMesh::Vertex& Corner(std::uint32_t triangle, std::size_t k) const {
    return mesh_.vertices[mesh_.triangles[triangle][k]];
  }

  Pixel At(const IndexedMesh::Vertex& v) const {
    // Far outside a narrow crop precision does not matter, range does.
    constexpr double kFar = 1e15;
    const double x = (v.x - lo_[0]) * scale_ * 100;
    const double y = (hi_[1] - v.y) * scale_ * 100;
    return {std::llround(std::clamp(x, -kFar, kFar)), std::llround(std::clamp(y, -kFar, kFar))};
  }

  void Open() {
    const double width = std::ceil(options_.width);
    const double height = std::ceil(height_);
    out_ << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << width << "\" height=\""
         << height << "\" viewBox=\"0 0 " << width << ' ' << height << "\">\n<title>Delaunay mesh, "
         << mesh_.vertices.size() << " vertices, " << mesh_.triangles.size()
         << " triangles</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
  }

  void WriteTriangle(std::uint32_t i) {
    const Pixel a = At(Corner(i, 0));
    const Pixel b = At(Corner(i, 1));
    const Pixel c = At(Corner(i, 2));
    WritePixel('M', a, out_);
    WritePixel('l', {b.x - a.x, b.y - a.y}, out_);
    WritePixel('l', {c.x - b.x, c.y - b.y}, out_);
    out_ << 'z';
  }

  void FillTriangles(const std::vector<std::uint32_t>& triangles, std::string_view colour) {
    // The stroke covers the hairlines that smoothing leaves between neighbours.
    out_ << "<path fill=\"" << colour << "\" stroke=\"" << colour << "\" stroke-width=\".4\" d=\"";
    for (const std::uint32_t i : triangles) WriteTriangle(i);
    out_ << "\"/>\n";
  }

  void DrawFills() {
    if (triangles_.empty()) return;
    switch (options_.fill) {
      case SvgOptions::Fill::kNone:
        return;
      case SvgOptions::Fill::kPlain:
        return FillTriangles(triangles_, kPlainFill);
      case SvgOptions::Fill::kExempt:
        return FillByVerdict();
      case SvgOptions::Fill::kRegion:
        return FillByRegion();
      case SvgOptions::Fill::kSize:
        return FillByValue(kSizeRamp, SizesOnRamp());
      case SvgOptions::Fill::kAngle:
      case SvgOptions::Fill::kQuality:
        return FillByValue(kQualityRamp, GoodnessOnRamp());
    }
  }

  void FillByVerdict() {
    const std::vector<SimplexVerdict> verdicts = JudgeTriangles(mesh_, options_.rho);
    std::vector<std::uint32_t> of[3];
    for (const std::uint32_t i : triangles_) {
      of[verdicts[i] == SimplexVerdict::kGood ? 0 : IsExempt(verdicts[i]) ? 1 : 2].push_back(i);
    }
    constexpr std::string_view kFills[] = {kPlainFill, kExemptFill, kOverRhoFill};
    for (std::size_t v = 0; v < 3; ++v) {
      if (!of[v].empty()) FillTriangles(of[v], kFills[v]);
    }
  }

  void FillByRegion() {
    std::map<std::uint32_t, std::vector<std::uint32_t>> of;  // by number
    for (const std::uint32_t i : triangles_) of[mesh_.regions.Of(i)].push_back(i);
    for (const auto& [number, triangles] : of) {
      FillTriangles(triangles, number == 0 ? std::string(kPlainFill) : DistinctColour(number));
    }
  }

  // Of each triangle shown, 0 (finest) to 1.
  std::vector<double> SizesOnRamp() const {
    std::vector<double> values;
    for (const std::uint32_t i : triangles_) {
      values.push_back(std::log2(std::max(MeasureTriangle(mesh_, i).shortest_edge, 1e-300)));
    }
    const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
    const double lo = *least;
    const double extent = std::max(*greatest - lo, 1.0);
    for (double& value : values) value = (value - lo) / extent;
    return values;
  }

  // Of each triangle shown, 0 (bad) to 1 (equilateral).
  std::vector<double> GoodnessOnRamp() const {
    const bool by_angle = options_.fill == SvgOptions::Fill::kAngle;
    const double best = 1 / std::sqrt(3.0);
    std::vector<SimplexVerdict> verdicts;
    if (!by_angle) verdicts = JudgeTriangles(mesh_, options_.rho);
    std::vector<double> values;
    for (const std::uint32_t i : triangles_) {
      const TriangleQuality q = MeasureTriangle(mesh_, i);
      if (by_angle) {
        values.push_back(q.min_angle_deg / 60);
      } else if (verdicts[i] != SimplexVerdict::kGood) {
        values.push_back(0);
      } else {
        const double part = (options_.rho - q.radius_edge) / (options_.rho - best);
        values.push_back(kAtRho + (1 - kAtRho) * std::max(part, 0.0));
      }
    }
    return values;
  }

  // Groups the triangles by colour: one path each keeps the file small.
  template <std::size_t N>
  void FillByValue(const ColourRamp<N>& ramp, const std::vector<double>& values) {
    std::map<int, std::vector<std::uint32_t>> groups;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double t = std::clamp(values[i], 0.0, 1.0);
      groups[static_cast<int>(t * (kFillSteps - 1))].push_back(triangles_[i]);
    }
    for (const auto& [step, triangles] : groups) {
      FillTriangles(triangles, ColourAt(ramp, static_cast<double>(step) / (kFillSteps - 1)));
    }
  }

  void DrawHighlight() {
    std::vector<std::uint32_t> shown;
    for (const std::uint32_t i : options_.highlight) {
      if (i < mesh_.triangles.size()) shown.push_back(i);
    }
    if (!shown.empty()) FillTriangles(shown, kHighlightFill);
  }

  void WriteEdge(const IndexedMesh::Edge& e) {
    const Pixel a = At(mesh_.vertices[e.a]);
    const Pixel b = At(mesh_.vertices[e.b]);
    WritePixel('M', a, out_);
    WritePixel('l', {b.x - a.x, b.y - a.y}, out_);
  }

  template <class Wanted>
  void DrawEdges(std::string_view colour, double width, double opacity, Wanted wanted) {
    bool open = false;
    for (const std::uint32_t i : edges_) {
      if (!wanted(mesh_.edges[i].owner)) continue;
      if (!open) {
        out_ << absl::StrFormat(
            "<path fill=\"none\" stroke=\"%s\" stroke-width=\"%.2f\" stroke-opacity=\"%.2f\" "
            "stroke-linecap=\"round\" d=\"",
            colour, width, opacity);
      }
      open = true;
      WriteEdge(mesh_.edges[i]);
    }
    if (open) out_ << "\"/>\n";
  }

  void DrawLines() {
    DrawEdges(style_.edge, std::clamp(0.03 * typical_, 0.1, 0.8), style_.edge_opacity,
              [](FeatureId owner) { return owner == kNoFeature; });
  }

  void DrawSubsegments() {
    DrawEdges(style_.box, std::clamp(0.06 * typical_, 0.5, 1.5), 1,
              [](FeatureId owner) { return owner == kBoxFeature; });
    DrawEdges(style_.segment, std::clamp(0.12 * typical_, 0.9, 2.6), 1,
              [](FeatureId owner) { return owner != kNoFeature && owner != kBoxFeature; });
  }

  void DrawPoints() {
    const double radius = std::clamp(0.1 * typical_, 0.0, 3.0);
    if (radius < 0.6) return;
    out_ << "<g fill=\"" << style_.segment << "\">\n";
    for (const auto& v : mesh_.vertices) {
      if (v.containing_dimension != 0 || v.owner == kBoxFeature || v.owner == kNoFeature) continue;
      if (!Overlaps(v.x, v.y, v.x, v.y)) continue;
      const Pixel p = At(v);
      out_ << "<circle cx=\"";
      WriteHundredths(p.x, out_);
      out_ << "\" cy=\"";
      WriteHundredths(p.y, out_);
      out_ << absl::StrFormat("\" r=\"%.2f\"/>\n", radius);
    }
    out_ << "</g>\n";
  }

  const IndexedMesh& mesh_;
  const SvgOptions& options_;
  FileWriter& out_;
  const LineStyle& style_ = options_.fill == SvgOptions::Fill::kSize ? kLightLines : kDarkLines;
  double lo_[2] = {0, 0};
  double hi_[2] = {1, 1};
  double scale_ = 1;                      // pixels a unit
  double height_ = 1;                     // pixels
  double typical_ = 1;                    // length of an edge shown, pixels
  std::vector<std::uint32_t> triangles_;  // those in view
  std::vector<std::uint32_t> edges_;
};

}  // namespace

absl::Status WriteSvg(const IndexedMesh& mesh, const SvgOptions& options, const std::string& path) {
  if (!(options.rho >= kMinQuality2D) || !(options.rho <= kMaxQuality)) {
    return absl::InvalidArgumentError("the rho of a picture must be 1 to 100");
  }
  if (!(options.width >= 1) || !(options.width <= 1e5)) {
    return absl::InvalidArgumentError("the width of a picture must be 1 to 100000 pixels");
  }
  FileWriter out(path);
  SvgDrawing(mesh, options, out).Draw();
  return out.Close();
}

absl::StatusOr<SvgOptions::Fill> ParseFill(std::string_view text) {
  using Fill = SvgOptions::Fill;
  constexpr std::pair<std::string_view, Fill> kNames[] = {
      {"angle", Fill::kAngle},   {"quality", Fill::kQuality}, {"size", Fill::kSize},
      {"exempt", Fill::kExempt}, {"region", Fill::kRegion},   {"plain", Fill::kPlain},
      {"none", Fill::kNone}};
  for (const auto& [name, fill] : kNames) {
    if (text == name) return fill;
  }
  return absl::InvalidArgumentError(Concat(
      "a fill is angle, quality, size, exempt, region, plain or none, found ", data::Quoted(text)));
}

std::vector<std::uint32_t> FindTriangles(const IndexedMesh& mesh, const SimplexColumn& simplices) {
  std::set<std::array<VertexId, 3>> wanted;
  for (std::size_t i = 0; i + 2 < simplices.size(); i += 3) {
    std::array<VertexId, 3> s = {simplices[i], simplices[i + 1], simplices[i + 2]};
    std::sort(s.begin(), s.end());
    wanted.insert(s);
  }
  std::vector<VertexId> ids;
  ids.reserve(mesh.vertices.size());
  for (const auto& v : mesh.vertices) {
    const double coordinates[2] = {v.x, v.y};
    ids.push_back(VertexIdAt(coordinates, 2));
  }
  std::vector<std::uint32_t> found;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    std::array<VertexId, 3> s = {ids[t[0]], ids[t[1]], ids[t[2]]};
    std::sort(s.begin(), s.end());
    if (wanted.contains(s)) found.push_back(i);
  }
  return found;
}

}  // namespace dynmesh::io
