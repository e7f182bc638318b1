#include "core/io/pictures/histogram_svg.h"

#include <cmath>
#include <limits>
#include <string>

#include "gtest/gtest.h"
#include "tests/support/count_of.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io {
namespace {

using test::CountOf;
using test::TempFolder;

Histogram Sample() {
  Histogram h;
  h.title = "Angles <of> a & b";
  h.unit = "degrees";
  h.hi = 10;
  h.tick = 5;
  h.counts = {0, 1, 0, 40, 7};
  h.marks = {{2.5, "bound"}, {11, "off the axis"}, {std::nan(""), "nowhere"}};
  return h;
}

TEST(HistogramSvg, DrawsABarForEveryCountAndTheMarksOnTheAxis) {
  const TempFolder folder;
  ASSERT_TRUE(WriteHistogramSvg("t", {Sample(), Sample()}, {}, folder.Path("h.svg")).ok());
  const std::string svg = folder.Read("h.svg");
  EXPECT_TRUE(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
  EXPECT_EQ(CountOf(svg, "z\"/>"), 2U);  // one path a histogram
  EXPECT_EQ(CountOf(svg, "h-"), 6U);     // with three bars
  EXPECT_EQ(CountOf(svg, ">bound<"), 2U);
  EXPECT_EQ(CountOf(svg, "off the axis") + CountOf(svg, "nowhere") + CountOf(svg, "nan"), 0U);
  EXPECT_EQ(CountOf(svg, "Angles &lt;of&gt; a &amp; b"), 2U);
}

// The upper ends of the bars, from "M x y h".
std::vector<double> Tops(const std::string& svg) {
  std::vector<double> tops;
  const std::size_t end = svg.find("z\"/>");
  for (std::size_t at = svg.find("d=\"M"); at < end; at = svg.find('M', at + 1)) {
    if (svg[at] == 'd') at += 3;
    tops.push_back(std::stod(svg.substr(svg.find(' ', at))));
  }
  return tops;
}

TEST(HistogramSvg, HeightsAreByCountOrItsLogarithm) {
  const TempFolder folder;
  HistogramOptions options;
  ASSERT_TRUE(WriteHistogramSvg("t", {Sample()}, options, folder.Path("a.svg")).ok());
  const std::vector<double> linear = Tops(folder.Read("a.svg"));
  ASSERT_EQ(linear.size(), 3U);
  const double bottom = linear[1] + 220;  // 40 is as high as the plot
  EXPECT_NEAR(bottom - linear[0], 220.0 / 40, 0.01);
  EXPECT_NEAR(bottom - linear[2], 220.0 * 7 / 40, 0.01);
  options.log_scale = true;
  ASSERT_TRUE(WriteHistogramSvg("t", {Sample()}, options, folder.Path("b.svg")).ok());
  const std::vector<double> logarithmic = Tops(folder.Read("b.svg"));
  ASSERT_EQ(logarithmic.size(), 3U);
  EXPECT_NEAR(bottom - logarithmic[0], 220 * 0.5 / (std::log10(40) + 0.5), 0.01);
}

TEST(HistogramSvg, TakesEmptyAndHugeCountsAndRefusesNonsense) {
  const TempFolder folder;
  Histogram h = Sample();
  h.counts.assign(5, 0);
  for (const bool log_scale : {false, true}) {
    HistogramOptions options;
    options.log_scale = log_scale;
    EXPECT_TRUE(WriteHistogramSvg("", {h}, options, folder.Path("h.svg")).ok());
    EXPECT_EQ(CountOf(folder.Read("h.svg"), "nan") + CountOf(folder.Read("h.svg"), "inf"), 0U);
    h.counts[2] = std::numeric_limits<std::uint64_t>::max();
    EXPECT_TRUE(WriteHistogramSvg("", {h}, options, folder.Path("h.svg")).ok());
  }
  HistogramOptions narrow;
  narrow.width = 10;
  EXPECT_FALSE(WriteHistogramSvg("", {h}, narrow, folder.Path("h.svg")).ok());
  h.tick = 0;
  EXPECT_FALSE(WriteHistogramSvg("", {h}, {}, folder.Path("h.svg")).ok());
  h = Sample();
  h.counts.clear();
  EXPECT_FALSE(WriteHistogramSvg("", {h}, {}, folder.Path("h.svg")).ok());
}

}  // namespace
}  // namespace dynmesh::io
