// Curves on logarithmic axes as SVG.
#pragma once

#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skywave {

struct PlotPoint {
  double x, y;
  // Ends of the whisker; NaN: none.
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();
};

struct PlotSeries {
  std::string name;
  std::vector<PlotPoint> points;
};

// A horizontal line across the plot, dashed.
struct PlotLevel {
  std::string name;
  double y;
};

struct LogPlot {
  std::string title, x_label, y_label;
  std::vector<PlotSeries> series;
  std::vector<PlotLevel> levels;  // drawn where they lie within the range of the series
};

// One picture with the plots one below the other, 900 pixels wide. Colours and markers belong to
// the position of a series, so plots of the same series agree. Points that are not positive and
// finite have no place on logarithmic axes and are left out.
std::string Svg(std::span<const LogPlot> plots);

// `text` with what XML and HTML reserve written as entities, and control characters as spaces
// but for line ends.
std::string EscapeXml(std::string_view text);

}  // namespace skywave
