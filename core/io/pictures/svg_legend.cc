#include "core/io/pictures/svg_legend.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "absl/strings/str_format.h"

namespace dynmesh::io {
namespace {

void WriteRectangle(double x, double y, double width, double height, std::string_view colour,
                    FileWriter& out) {
  out << absl::StrFormat(
      "<rect x=\"%.2f\" y=\"%.2f\" width=\"%.2f\" height=\"%.2f\" fill=\"%s\"/>\n", x, y, width,
      height, colour);
}

void WriteText(double x, double y, std::string_view text, FileWriter& out) {
  out << absl::StrFormat("<text x=\"%.2f\" y=\"%.2f\">%s</text>\n", x, y, text);
}

// A white background, then a group of texts.
void Open(double top, double width, FileWriter& out) {
  const double height = LegendHeight(width);
  WriteRectangle(0, top, std::ceil(width), std::ceil(height) + 1, "#ffffff", out);
  out << absl::StrFormat("<g style=\"font:%.2fpx sans-serif\" fill=\"#14213d\">\n", 0.4 * height);
}

}  // namespace

double LegendHeight(double width) { return std::min(width / 32, 48.0); }

void WriteLegend(const std::vector<LegendEntry>& entries, double top, double width,
                 FileWriter& out) {
  Open(top, width, out);
  const double height = LegendHeight(width), side = 0.5 * height;
  const double each = width / static_cast<double>(std::max<std::size_t>(entries.size(), 1));
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const double left = each * static_cast<double>(i) + 0.3 * height;
    WriteRectangle(left, top + 0.25 * height, side, side, entries[i].colour, out);
    WriteText(left + 1.3 * side, top + 0.64 * height, entries[i].label, out);
  }
  out << "</g>\n";
}

void WriteScale(const Scale& scale, double top, double width, FileWriter& out) {
  Open(top, width, out);
  const double height = LegendHeight(width);
  // The title takes the left third.
  const double left = width / 3, extent = 0.64 * width;
  const double each = extent / static_cast<double>(std::max<std::size_t>(scale.colours.size(), 1));
  WriteText(0.3 * height, top + 0.64 * height, scale.title, out);
  for (std::size_t i = 0; i < scale.colours.size(); ++i) {
    WriteRectangle(left + each * static_cast<double>(i), top + 0.1 * height, each, 0.4 * height,
                   scale.colours[i], out);
  }
  for (const Scale::Tick& tick : scale.ticks) {
    // The last one ends where the scale does.
    const bool is_last = tick.at > 0.97;
    out << absl::StrFormat("<text x=\"%.2f\" y=\"%.2f\"%s>%s</text>\n", left + extent * tick.at,
                           top + 0.92 * height, is_last ? " text-anchor=\"end\"" : "", tick.label);
  }
  out << "</g>\n";
}

}  // namespace dynmesh::io
