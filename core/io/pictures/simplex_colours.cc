#include "core/io/pictures/simplex_colours.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "absl/strings/str_format.h"
#include "core/base/text.h"
#include "core/io/pictures/colour_ramp.h"
#include "dynmesh/quality.h"

namespace dynmesh::io {
namespace {

constexpr int kFillSteps = 31;
constexpr std::string_view kExemptFill = "#f6a821";
constexpr std::string_view kOverRhoFill = "#b2182b";
constexpr std::string_view kBelowDihedralFill = "#7b3294";
// The least angle of the best simplex, in degrees.
constexpr double kBestAngle2D = 60;
constexpr double kBestAngle3D = 70.528779365509308;
// The position on the ramp of a simplex just within rho.
constexpr double kAtRho = 0.15;
// The part of the simplices, at either end, that may be beyond the ramp of sizes.
constexpr double kBeyondRamp = 0.02;
constexpr std::size_t kMostEntries = 6;

// "0.25", "62", "2300".
std::string TwoDigits(double value) {
  const double unit = std::pow(10, std::floor(std::log10(value)) - 1);
  return absl::StrFormat("%g", std::round(value / unit) * unit);
}

class Colouring {
 public:
  Colouring(const IndexedMesh& mesh, const SvgOptions& options,
            std::span<const std::uint32_t> simplices)
      : mesh_(mesh), options_(options), simplices_(simplices) {}

  SimplexColours Run() {
    switch (options_.fill) {
      case SvgOptions::Fill::kNone:
        break;
      case SvgOptions::Fill::kPlain:
        colours_.of.assign(simplices_.size(), std::string(kPlainFill));
        break;
      case SvgOptions::Fill::kExempt:
        ByVerdict();
        break;
      case SvgOptions::Fill::kRegion:
        ByRegion();
        break;
      case SvgOptions::Fill::kSize:
        BySize();
        break;
      case SvgOptions::Fill::kAngle:
      case SvgOptions::Fill::kDihedral:
        ByAngle();
        break;
      case SvgOptions::Fill::kQuality:
        ByQuality();
        break;
    }
    return std::move(colours_);
  }

 private:
  bool InSpace() const { return mesh_.dimension == 3; }

  void ByVerdict() {
    const std::vector<SimplexVerdict> verdicts =
        JudgeSimplices(mesh_, options_.rho, options_.min_dihedral);
    for (const std::uint32_t i : simplices_) {
      const SimplexVerdict verdict = verdicts[i];
      colours_.of.emplace_back(verdict == SimplexVerdict::kGood            ? kPlainFill
                               : IsExempt(verdict)                         ? kExemptFill
                               : verdict == SimplexVerdict::kBelowDihedral ? kBelowDihedralFill
                                                                           : kOverRhoFill);
    }
    colours_.entries = {{std::string(kPlainFill), "within rho"}};
    if (!InSpace()) colours_.entries.push_back({std::string(kExemptFill), "over rho, exempt"});
    colours_.entries.push_back({std::string(kOverRhoFill), "over rho"});
    if (InSpace() && options_.min_dihedral > 0) {
      colours_.entries.push_back(
          {std::string(kBelowDihedralFill),
           absl::StrFormat("dihedral angle below %g degrees", options_.min_dihedral)});
    }
  }

  void ByRegion() {
    const auto colour_of = [](std::uint32_t number) {
      return number == 0 ? std::string(kPlainFill) : DistinctColour(number);
    };
    std::set<std::uint32_t> present;
    for (const std::uint32_t i : simplices_) {
      present.insert(mesh_.regions.Of(i));
      colours_.of.push_back(colour_of(mesh_.regions.Of(i)));
    }
    for (const std::uint32_t number : present) {
      if (colours_.entries.size() == kMostEntries && present.size() > kMostEntries) {
        colours_.entries.back() = {
            "#ffffff", text::Concat("and ", present.size() - kMostEntries + 1, " more")};
        return;
      }
      colours_.entries.push_back({colour_of(number), mesh_.regions.Name(number)});
    }
  }

  template <std::size_t N>
  void ByValue(const ColourRamp<N>& ramp, const std::vector<double>& values) {
    const auto step_colour = [&](int step) {
      return ColourAt(ramp, static_cast<double>(step) / (kFillSteps - 1));
    };
    for (const double value : values) {
      const double t = std::clamp(value, 0.0, 1.0);
      colours_.of.push_back(step_colour(static_cast<int>(t * (kFillSteps - 1))));
    }
    for (int step = 0; step < kFillSteps; ++step) {
      colours_.scale.colours.push_back(step_colour(step));
    }
  }

  void BySize() {
    std::vector<double> values;
    for (const std::uint32_t i : simplices_) {
      values.push_back(std::log2(std::max(MeasureSimplex(mesh_, i).shortest_edge, 1e-300)));
    }
    if (values.empty()) return;
    // A few tiny simplices leave the others their colours.
    std::vector<double> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    const auto beyond = static_cast<std::size_t>(kBeyondRamp * static_cast<double>(sorted.size()));
    const double lo = sorted[beyond];
    const double extent = std::max(sorted[sorted.size() - 1 - beyond] - lo, 1.0);
    for (double& value : values) value = (value - lo) / extent;
    ByValue(kSizeRamp, values);
    colours_.scale.title = "shortest edge";
    constexpr int kTicks = 4;
    for (int k = 0; k <= kTicks; ++k) {
      const double t = static_cast<double>(k) / kTicks;
      colours_.scale.ticks.push_back({t, TwoDigits(std::exp2(lo + t * extent))});
    }
  }

  void ByAngle() {
    const double best = InSpace() ? kBestAngle3D : kBestAngle2D;
    std::vector<double> values;
    for (const std::uint32_t i : simplices_) {
      values.push_back(MeasureSimplex(mesh_, i).min_angle_deg / best);
    }
    ByValue(kQualityRamp, values);
    colours_.scale.title = InSpace() ? "least dihedral angle, degrees" : "least angle, degrees";
    for (int degrees = 0; degrees <= best; degrees += 10) {
      colours_.scale.ticks.push_back({degrees / best, absl::StrFormat("%d", degrees)});
    }
  }

  void ByQuality() {
    const double best = InSpace() ? std::sqrt(0.375) : 1 / std::sqrt(3.0);
    const std::vector<SimplexVerdict> verdicts = JudgeSimplices(mesh_, options_.rho);
    std::vector<double> values;
    for (const std::uint32_t i : simplices_) {
      if (IsOverRho(verdicts[i])) {
        values.push_back(0);
        continue;
      }
      const double part =
          (options_.rho - MeasureSimplex(mesh_, i).radius_edge) / (options_.rho - best);
      values.push_back(kAtRho + (1 - kAtRho) * std::max(part, 0.0));
    }
    ByValue(kQualityRamp, values);
    colours_.scale.title = "circumradius / shortest edge";
    colours_.scale.ticks = {{0, "more"},
                            {kAtRho, absl::StrFormat("%.3g", options_.rho)},
                            {1, absl::StrFormat("%.2f", best)}};
  }

  const IndexedMesh& mesh_;
  const SvgOptions& options_;
  const std::span<const std::uint32_t> simplices_;
  SimplexColours colours_;
};

}  // namespace

SimplexColours ColoursOf(const IndexedMesh& mesh, const SvgOptions& options,
                         std::span<const std::uint32_t> simplices) {
  return Colouring(mesh, options, simplices).Run();
}

}  // namespace dynmesh::io
