// Draws horizontal bars on a linear axis from 0 as SVG, each with one or several segments.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace skywave {

struct Bar {
  std::string name;
  std::vector<double> values;  // [unit of the chart], one per segment, not negative
};

struct BarChart {
  std::string title, unit;
  std::vector<std::string> segments;  // names for the legend; one segment needs no legend
  std::vector<Bar> bars;
};

// Returns one picture, 900 pixels wide. Values that are negative or not finite count as 0.
std::string Svg(const BarChart& chart);

}  // namespace skywave
