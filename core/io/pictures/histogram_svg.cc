#include "core/io/pictures/histogram_svg.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "absl/strings/str_format.h"
#include "core/io/common/file_writer.h"

namespace dynmesh::io {
namespace {

constexpr double kLeft = 74;  // pixels around a plot, and its height
constexpr double kRight = 18;
constexpr double kAbove = 40;
constexpr double kBelow = 46;
constexpr double kPlotHeight = 220;
constexpr double kTitleHeight = 36;
constexpr std::string_view kBar = "#4a7fa8";
constexpr std::string_view kMark = "#b2182b";

std::string Escape(std::string_view text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      default:
        result += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return result;
}

// 1, 2 or 5 times a power of ten: about five steps up to `greatest`, at least 1.
double NiceStep(double greatest) {
  const double rough = std::max(greatest / 5, 1.0);
  const double power = std::pow(10, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough) return factor * power;
  }
  return 10 * power;
}

class Plot {
 public:
  Plot(const Histogram& histogram, const HistogramOptions& options, double top, FileWriter& out)
      : h_(histogram), out_(out), log_(options.log_scale), top_(top + kAbove) {
    width_ = options.width - kLeft - kRight;
    for (const std::uint64_t count : h_.counts) {
      greatest_ = std::max(greatest_, static_cast<double>(count));
    }
  }

  void Draw() {
    Text(kLeft, top_ - 22, "start", h_.title, "font-weight=\"bold\"");
    DrawLevels();
    DrawBars();
    DrawAxis();
    DrawMarks();
  }

 private:
  double X(double value) const { return kLeft + value / h_.hi * width_; }

  // The height of a count. On a logarithmic scale 1 is half a decade high, so that it is visible.
  double Y(double count) const {
    const auto height = [this](double c) {
      if (!log_) return c;
      return c > 0 ? std::log10(c) + 0.5 : 0;
    };
    return top_ + kPlotHeight * (1 - height(count) / height(std::max(greatest_, 1.0)));
  }

  void Text(double x, double y, std::string_view anchor, std::string_view text,
            std::string_view more = "") {
    out_ << absl::StrFormat("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\"", x, y,
                            std::string(anchor));
    if (!more.empty()) out_ << ' ' << more;
    out_ << '>' << Escape(text) << "</text>\n";
  }

  void Line(double x0, double y0, double x1, double y1, std::string_view style) {
    out_ << absl::StrFormat("<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" ", x0, y0, x1,
                            y1)
         << style << "/>\n";
  }

  void DrawLevel(double count) {
    Line(kLeft, Y(count), kLeft + width_, Y(count), "stroke=\"#dde3e8\"");
    Text(kLeft - 6, Y(count) + 4, "end", absl::StrFormat("%.0f", count));
  }

  void DrawLevels() {
    if (log_) {
      for (double count = 1; count <= greatest_; count *= 10) DrawLevel(count);
      return;
    }
    const double step = NiceStep(greatest_);
    for (double count = step; count <= greatest_; count += step) DrawLevel(count);
  }

  void DrawBars() {
    const double bar = width_ / static_cast<double>(h_.counts.size());
    out_ << "<path fill=\"" << kBar << "\" d=\"";
    for (std::size_t i = 0; i < h_.counts.size(); ++i) {
      if (h_.counts[i] == 0) continue;
      const double y = Y(static_cast<double>(h_.counts[i]));
      out_ << absl::StrFormat("M%.2f %.2fh%.2fV%.2fh%.2fz",
                              kLeft + bar * static_cast<double>(i) + 0.06 * bar, y, 0.88 * bar,
                              top_ + kPlotHeight, -0.88 * bar);
    }
    out_ << "\"/>\n";
  }

  void DrawAxis() {
    const double bottom = top_ + kPlotHeight;
    Line(kLeft, bottom, kLeft + width_, bottom, "stroke=\"#38495c\"");
    for (double i = 0; i * h_.tick <= h_.hi * (1 + 1e-9); ++i) {
      const double x = X(i * h_.tick);
      Line(x, bottom, x, bottom + 4, "stroke=\"#38495c\"");
      Text(x, bottom + 17, "middle", absl::StrFormat("%g", i * h_.tick));
    }
    Text(kLeft + width_, bottom + 33, "end", h_.unit);
  }

  void DrawMarks() {
    for (const Histogram::Mark& mark : h_.marks) {
      if (!(mark.value >= 0) || !(mark.value <= h_.hi)) continue;
      const double x = X(mark.value);
      Line(x, top_ - 4, x, top_ + kPlotHeight,
           absl::StrFormat("stroke=\"%s\" stroke-dasharray=\"5 3\"", std::string(kMark)));
      // Towards the middle, where there is room.
      const bool right = mark.value * 2 > h_.hi;
      Text(right ? x - 4 : x + 4, top_ - 8, right ? "end" : "start", mark.label,
           absl::StrFormat("fill=\"%s\"", std::string(kMark)));
    }
  }

  const Histogram& h_;
  FileWriter& out_;
  const bool log_;
  const double top_;  // of the plot's area
  double width_ = 0;
  double greatest_ = 0;
};

}  // namespace

absl::Status WriteHistogramSvg(const std::string& title, const std::vector<Histogram>& histograms,
                               const HistogramOptions& options, const std::string& path) {
  if (!(options.width >= 200) || !(options.width <= 1e5)) {
    return absl::InvalidArgumentError("the width of a histogram must be 200 to 100000 pixels");
  }
  for (const Histogram& h : histograms) {
    if (h.counts.empty() || !(h.hi > 0) || !(h.tick > 0) || !(h.hi <= 1000 * h.tick)) {
      return absl::InvalidArgumentError("a histogram needs bars, and an axis with some numbers");
    }
  }
  constexpr double kEach = kAbove + kPlotHeight + kBelow;
  const double height = kTitleHeight + kEach * static_cast<double>(histograms.size());
  FileWriter out(path);
  out << absl::StrFormat(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\" "
      "viewBox=\"0 0 %.0f %.0f\" font-family=\"sans-serif\" font-size=\"12\" fill=\"#14213d\">\n",
      options.width, height, options.width, height);
  out << "<title>" << Escape(title) << "</title>\n"
      << "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
  out << absl::StrFormat("<text x=\"%.1f\" y=\"24\" font-size=\"15\">", kLeft) << Escape(title)
      << "</text>\n";
  double top = kTitleHeight;
  for (const Histogram& histogram : histograms) {
    Plot(histogram, options, top, out).Draw();
    top += kEach;
  }
  out << "</svg>\n";
  return out.Close();
}

}  // namespace dynmesh::io
