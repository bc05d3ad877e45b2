// Horizontal bars on a linear axis from 0 as SVG, each of one or several segments.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace skywave {

struct Bar {
  std::string name;
  std::vector<double> values;  // [unit of the chart], one a segment, not negative
};

struct BarChart {
  std::string title, unit;
  std::vector<std::string> segments;  // names for the legend; one: no legend
  std::vector<Bar> bars;
};

// One picture, 900 pixels wide. Values that are negative or not finite count as 0.
std::string Svg(const BarChart& chart);

}  // namespace skywave
