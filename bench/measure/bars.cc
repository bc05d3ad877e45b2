#include "bench/measure/bars.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "bench/measure/plot.h"

namespace skywave {
namespace {

// The layout of the chart [pixels].
constexpr double kWidth = 900, kLeft = 190, kRight = 76, kTop = 40, kRow = 26, kBar = 18;
constexpr double kAxis = 46, kLegendRow = 20, kLegendColumn = 150;

// Neighbours differ in lightness as well as in hue; colours repeat after the number of stages of a
// wave at the earliest.
constexpr const char* kColors[] = {"#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00",
                                   "#404040", "#b8b800", "#7b4fa3", "#8fd0b5", "#a0a0a0"};

double Length(double value) { return std::isfinite(value) && value > 0 ? value : 0; }

double Total(const Bar& bar) {
  double sum = 0;
  for (const double value : bar.values) sum += Length(value);
  return sum;
}

// Returns 1, 2 or 5 times a power of ten, such that at most ten steps fit up to `most`.
double TickStep(double most) {
  const double power = std::pow(10, std::floor(std::log10(most)) - 1);
  for (const int factor : {1, 2, 5}) {
    if (factor * power * 10 >= most) return factor * power;
  }
  return 10 * power;
}

}  // namespace

std::string Svg(const BarChart& chart) {
  double most = 0;
  for (const Bar& bar : chart.bars) most = std::max(most, Total(bar));
  if (most == 0) most = 1;
  const double step = TickStep(most), scale = (kWidth - kLeft - kRight) / most;
  const double bottom = kTop + kRow * double(chart.bars.size());
  const int columns = int((kWidth - kLeft) / kLegendColumn);
  const bool has_legend = chart.segments.size() > 1;
  const double legend =
      has_legend ? kLegendRow * std::ceil(double(chart.segments.size()) / columns) : 0;
  std::string text = fmt::format(
      R"(<svg xmlns="http://www.w3.org/2000/svg" width="{0}" height="{1}" viewBox="0 0 {0} {1}" )"
      R"(font-family="sans-serif" font-size="14"><rect width="{0}" height="{1}" fill="#ffffff"/>)"
      "\n",
      kWidth, bottom + kAxis + legend);
  const auto write = [&]<class... T>(fmt::format_string<T...> format, T&&... values) {
    text += fmt::format(format, std::forward<T>(values)...) + "\n";
  };
  write(R"(<text x="8" y="24" font-size="17" font-weight="bold">{}</text>)",
        EscapeXml(chart.title));
  for (int tick = 0; tick * step <= most * (1 + 1e-9); ++tick) {
    const double x = kLeft + tick * step * scale;
    write(R"(<path d="M{0:.1f},{1}V{2:.1f}" stroke="#d8d8d8"/>)", x, kTop, bottom);
    write(R"(<text x="{:.1f}" y="{:.1f}" text-anchor="middle" font-size="12">{:g}</text>)", x,
          bottom + 15, tick * step);
  }
  write(R"(<text x="{:.1f}" y="{:.1f}" text-anchor="middle" font-size="12">{}</text>)",
        (kLeft + kWidth - kRight) / 2, bottom + 32, EscapeXml(chart.unit));
  for (std::size_t row = 0; row < chart.bars.size(); ++row) {
    const Bar& bar = chart.bars[row];
    const double y = kTop + kRow * double(row) + (kRow - kBar) / 2;
    write(R"(<text x="{:.1f}" y="{:.1f}" text-anchor="end">{}</text>)", kLeft - 8, y + 14,
          EscapeXml(bar.name));
    double x = kLeft;
    for (std::size_t i = 0; i < bar.values.size(); ++i) {
      const double width = Length(bar.values[i]) * scale;
      if (width == 0) continue;
      const std::string name = i < chart.segments.size() ? chart.segments[i] : "";
      write(R"(<rect x="{:.2f}" y="{:.1f}" width="{:.2f}" height="{}" fill="{}">)"
            R"(<title>{} {:.4g} {}</title></rect>)",
            x, y, width, kBar, kColors[i % std::size(kColors)], EscapeXml(name), bar.values[i],
            EscapeXml(chart.unit));
      x += width;
    }
    write(R"(<text x="{:.1f}" y="{:.1f}" font-size="12">{:.4g}</text>)", x + 5, y + 13, Total(bar));
  }
  for (std::size_t i = 0; has_legend && i < chart.segments.size(); ++i) {
    const double x = kLeft + kLegendColumn * double(int(i) % columns);
    const double y = bottom + kAxis + kLegendRow * double(int(i) / columns);
    write(R"(<rect x="{:.1f}" y="{:.1f}" width="12" height="12" fill="{}"/>)", x, y - 6,
          kColors[i % std::size(kColors)]);
    write(R"(<text x="{:.1f}" y="{:.1f}" font-size="12">{}</text>)", x + 17, y + 5,
          EscapeXml(chart.segments[i]));
  }
  return text + "</svg>";
}

}  // namespace skywave
