// Tests curves as SVG: well-formed, complete, and within the picture.
#include "bench/measure/plot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <regex>

#include "tests/support/xml.h"

namespace skywave {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::size_t Count(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++count;
  }
  return count;
}

Plot TwoCurves() {
  Plot plot = {.title = "a < b & \"c\"", .x_label = "time", .y_label = "mse"};
  plot.series = {{"hybrid:lights=64,from=<x>", {{0.01, 0.5, 0.4, 0.6}, {0.1, 0.04, 0.03, 0.05}}},
                 {"importance", {{0.02, 0.3}, {0.2, 0.002}}}};
  plot.levels = {{"target", 0.01}, {"far below", 1e-9}};
  return plot;
}

TEST(XmlChecker, FindsMalformedXml) {
  EXPECT_TRUE(IsWellFormedXml("<a b=\"c&lt;\"><d/>text</a>\n"));
  for (const char* const bad :
       {"<a><b></a>", "<a b=c></a>", "<a>x & y</a>", "<a b=\"<\"></a>", "<a/><a/>", "<a", "text",
        "<a b=\"1\" b=\"2\"/>", "</a>", "<a></b>", ""}) {
    EXPECT_FALSE(IsWellFormedXml(bad)) << bad;
  }
}

TEST(Svg, IsWellFormedWhateverTheNames) {
  Plot plot = TwoCurves();
  plot.series[1].name = "'&amp;' \x01 ]]>";
  EXPECT_TRUE(IsWellFormedXml(Svg(std::vector<Plot>{plot, TwoCurves()})));
  EXPECT_TRUE(IsWellFormedXml(Svg(std::vector<Plot>{Plot()})));
  EXPECT_TRUE(IsWellFormedXml(Svg({})));
}

TEST(Svg, HasACurveAMarkerAndALegendForEverySeries) {
  const std::string svg = Svg(std::vector<Plot>{TwoCurves()});
  EXPECT_EQ(Count(svg, "hybrid:lights=64,from=&lt;x&gt;</text>"), 1u);
  EXPECT_EQ(Count(svg, ">importance</text>"), 1u);
  EXPECT_EQ(Count(svg, "transform=\"translate("), 4u + 2u + 1u);  // points, legend, axis label
  EXPECT_EQ(Count(svg, "h10M"), 2u);                              // whiskers
  EXPECT_EQ(Count(svg, ">target</text>"), 1u);
  EXPECT_EQ(Count(svg, ">far below</text>"), 0u);
}

TEST(Svg, LabelsEveryPowerOfTen) {
  Plot plot;
  plot.series = {{"a", {{1, 3e-7}, {4e5, 0.2}}}};
  const std::string svg = Svg(std::vector<Plot>{plot});
  for (const char* const label : {">1</text>", ">10</text>", ">1000</text>", ">4</tspan>",
                                  ">5</tspan>", ">-6</tspan>", ">0.1</text>"}) {
    EXPECT_EQ(Count(svg, label), 1u) << label;
  }
}

// The coordinates of all marks lie in the picture and follow the logarithm.
TEST(Svg, PlacesPointsOnLogarithmicAxes) {
  Plot plot;
  plot.series = {{"a", {{1, 1}, {10, 0.1}, {100, 0.01}}}};
  const std::string svg = Svg(std::vector<Plot>{plot});
  const std::regex marker("translate\\(([0-9.]+),([0-9.]+)\\) scale");
  std::vector<double> xs, ys;
  for (std::sregex_iterator it(svg.begin(), svg.end(), marker), end; it != end; ++it) {
    xs.push_back(std::stod((*it)[1]));
    ys.push_back(std::stod((*it)[2]));
  }
  ASSERT_EQ(xs.size(), 4u);  // the last belongs to the legend
  EXPECT_NEAR(xs[1] - xs[0], xs[2] - xs[1], 0.11);
  EXPECT_NEAR(ys[1] - ys[0], ys[2] - ys[1], 0.11);
  EXPECT_GT(xs[1], xs[0]);
  EXPECT_GT(ys[1], ys[0]);  // y grows downwards
  for (double x : xs) EXPECT_TRUE(x > 0 && x < 900) << x;
}

// On linear axes equal steps are equally far apart, zero has a place, and a mark stands where it
// says.
TEST(Svg, PlacesPointsOnLinearAxes) {
  Plot plot;
  plot.series = {{"a", {{0, 0}, {0.5, 10}, {1, 20}}}};
  plot.x_scale = plot.y_scale = PlotScale::kLinear;
  plot.marks = {{"here", 0.25}};
  plot.markers = false;
  const std::string svg = Svg(std::vector<Plot>{plot});
  // The axes are 796 by 420 pixels and begin at (84, 460).
  EXPECT_NE(svg.find("M84.0,460.0L482.0,250.0L880.0,40.0"), std::string::npos) << svg;
  EXPECT_NE(svg.find("M283.0,460.0V40.0"), std::string::npos) << svg;
  for (const char* const label : {">0.4<", ">0<", ">15<"}) {
    EXPECT_NE(svg.find(label), std::string::npos) << label << svg;
  }
  EXPECT_EQ(svg.find(">-0<"), std::string::npos) << svg;
  EXPECT_EQ(svg.find("translate(482.0,250.0)"), std::string::npos) << svg;
  plot.series = {{"a", {{2, 11}, {3, 12}}}};
  EXPECT_NE(Svg(std::vector<Plot>{plot}).find("M84.0,460.0L880.0,40.0"), std::string::npos);
}

TEST(Svg, LeavesOutValuesWithoutALogarithm) {
  Plot plot = TwoCurves();
  const std::string before = Svg(std::vector<Plot>{plot});
  for (const double bad : {0.0, -1.0, kNan, std::numeric_limits<double>::infinity()}) {
    plot.series[0].points.push_back({1, bad});
    plot.series[0].points.push_back({bad, 1});
  }
  EXPECT_EQ(Svg(std::vector<Plot>{plot}), before);
  EXPECT_EQ(Count(before, "nan"), 0u);
  EXPECT_EQ(Count(before, "inf"), 0u);
}

// Two repetitions may give an unbounded interval; the curve must remain readable.
TEST(Svg, EndlessWhiskersDoNotSqueezeTheCurve) {
  Plot plot = TwoCurves();
  plot.series[0].points[0].low = 1e-300;
  plot.series[0].points[0].high = 1e300;
  const std::string svg = Svg(std::vector<Plot>{plot});
  EXPECT_EQ(Count(svg, "-300"), 0u);
  EXPECT_TRUE(IsWellFormedXml(svg));
}

TEST(EscapeXml, WritesReservedCharactersAsEntities) {
  EXPECT_EQ(EscapeXml("a<b>&\"'\x02"), "a&lt;b&gt;&amp;&quot;&#39; ");
  EXPECT_EQ(EscapeXml("two\nlines"), "two\nlines");
}

}  // namespace
}  // namespace skywave
