// Draws curves on logarithmic axes as SVG.
#pragma once

#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skywave {

struct PlotPoint {
  double x, y;
  // Ends of the whisker; NaN: no whisker.
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();
};

struct PlotSeries {
  std::string name;
  std::vector<PlotPoint> points;
};

// A dashed horizontal line across the plot.
struct PlotLevel {
  std::string name;
  double y;
};

struct LogPlot {
  std::string title, x_label, y_label;
  std::vector<PlotSeries> series;
  std::vector<PlotLevel> levels;  // drawn if they lie within the range of the series
};

// Returns one picture with the plots stacked vertically, 900 pixels wide. Colours and markers
// depend on the position of a series, so plots of the same series agree. Points that are not
// positive and finite cannot be drawn on logarithmic axes and are left out.
std::string Svg(std::span<const LogPlot> plots);

// Returns `text` with the characters reserved by XML and HTML as entities, and with control
// characters other than line ends as spaces.
std::string EscapeXml(std::string_view text);

}  // namespace skywave
