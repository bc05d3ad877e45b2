// Draws curves as SVG, on logarithmic axes unless others are asked for.
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

// A dashed horizontal line across the plot, and a vertical one.
struct PlotLevel {
  std::string name;
  double y;
};
struct PlotMark {
  std::string name;
  double x;
};

enum class PlotScale { kLog, kLinear };

struct Plot {
  std::string title, x_label, y_label;
  std::vector<PlotSeries> series;
  // Drawn if they lie within the range of the series.
  std::vector<PlotLevel> levels = {};
  std::vector<PlotMark> marks = {};
  PlotScale x_scale = PlotScale::kLog, y_scale = PlotScale::kLog;
  bool markers = true;  // a marker at each point, for curves of few points
};

// Returns one picture with the plots stacked vertically, 900 pixels wide. Colours and markers
// depend on the position of a series, so plots of the same series agree. Points that are not
// finite, or on a logarithmic axis not positive, are left out.
std::string Svg(std::span<const Plot> plots);

// Returns `text` with the characters reserved by XML and HTML as entities, and with control
// characters other than line ends as spaces.
std::string EscapeXml(std::string_view text);

}  // namespace skywave
