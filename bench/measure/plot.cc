#include "bench/measure/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace skywave {
namespace {

// The layout of a plot [pixels].
constexpr double kWidth = 900, kLeft = 84, kRight = 20, kTop = 40, kAxes = 420, kBottom = 58;
constexpr double kLegendRow = 22, kGap = 24;

// These colours can be distinguished with impaired colour vision too (Okabe and Ito 2008); yellow
// is omitted because it is hard to see on white.
constexpr const char* kColors[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                   "#56b4e9", "#e69f00", "#000000"};
// Outlines of markers about the origin. There is one fewer than colours, so that pairs repeat late.
constexpr const char* kMarkers[] = {"M-5,0a5,5 0 1,0 10,0a5,5 0 1,0 -10,0z",
                                    "M-4.5,-4.5h9v9h-9z",
                                    "M0,-6l5.5,10h-11z",
                                    "M0,-6l5,6l-5,6l-5,-6z",
                                    "M0,6l5.5,-10h-11z",
                                    "M-5,-2h3v-3h4v3h3v4h-3v3h-4v-3h-3z"};

bool OnAxis(PlotScale scale, double value) {
  return std::isfinite(value) && (scale == PlotScale::kLinear || value > 0);
}
bool IsDrawn(const Plot& plot, const PlotPoint& point) {
  return OnAxis(plot.x_scale, point.x) && OnAxis(plot.y_scale, point.y);
}

// A tick at 1, 2 or 5 times a power of ten; on a linear axis a multiple of such a number, whose
// mantissa is 1.
struct Tick {
  double value;
  int mantissa, exponent;
};

// Returns ticks that are 1, 2 or 5 times a power of ten apart, at most ten of them.
std::vector<Tick> EvenTicks(double low, double high) {
  const double power = std::pow(10.0, std::floor(std::log10(high - low)) - 1);
  double step = power;
  for (const double multiple : {1, 2, 5, 10, 20, 50}) {
    step = multiple * power;
    if ((high - low) / step <= 9) break;
  }
  std::vector<Tick> ticks;
  // The 0 that is added makes 0 of -0.
  for (double i = std::ceil(low / step - 1e-9) + 0.0; i * step <= high + 1e-9 * step; ++i) {
    ticks.push_back({i * step, 1, 0});
  }
  return ticks;
}

std::vector<Tick> Ticks(PlotScale scale, double low, double high) {
  if (scale == PlotScale::kLinear) return EvenTicks(low, high);
  std::vector<Tick> ticks;
  for (int e = int(std::floor(std::log10(low))) - 1; e <= int(std::ceil(std::log10(high))); ++e) {
    for (const int mantissa : {1, 2, 5}) {
      const double value = mantissa * std::pow(10.0, e);
      if (value >= low * (1 - 1e-9) && value <= high * (1 + 1e-9)) {
        ticks.push_back({value, mantissa, e});
      }
    }
  }
  return ticks;
}

// An axis runs from one tick to another, so that both ends are labelled.
struct Axis {
  double low = 0, high = 0;  // values
  double from = 0, to = 0;   // pixels
  PlotScale scale = PlotScale::kLog;

  double At(double value) const {
    const double share = scale == PlotScale::kLinear ? (value - low) / (high - low)
                                                     : std::log(value / low) / std::log(high / low);
    return from + (to - from) * share;
  }
  std::vector<Tick> ticks() const { return Ticks(scale, low, high); }
};

Axis FitAxis(PlotScale scale, std::vector<double> values, double from, double to) {
  if (values.empty()) values.push_back(1);
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  Axis axis = {.low = *least, .high = *most, .from = from, .to = to, .scale = scale};
  if (scale == PlotScale::kLinear) {
    if (axis.low == axis.high) axis.high += std::max(std::abs(axis.low), 1.0);
    const std::vector<Tick> inside = axis.ticks();
    const double step = inside[1].value - inside[0].value;
    axis.low = std::floor(axis.low / step + 1e-9) * step;
    axis.high = std::ceil(axis.high / step - 1e-9) * step;
    return axis;
  }
  const std::vector<Tick> ticks = Ticks(scale, *least / 11, *most * 11);
  for (const Tick& tick : ticks) {
    if (tick.value <= *least * (1 + 1e-9)) axis.low = tick.value;
  }
  for (auto tick = ticks.rbegin(); tick != ticks.rend(); ++tick) {
    if (tick->value >= *most * (1 - 1e-9)) axis.high = tick->value;
  }
  if (axis.low == axis.high) axis.low /= 10, axis.high *= 10;
  return axis;
}

class Writer {
 public:
  template <class... T>
  void operator()(fmt::format_string<T...> format, T&&... values) {
    text_ += fmt::format(format, std::forward<T>(values)...) + "\n";
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

std::string TickLabel(PlotScale scale, const Tick& tick) {
  if (scale == PlotScale::kLinear || (tick.exponent >= -2 && tick.exponent <= 3)) {
    return fmt::format("{:g}", tick.value);
  }
  const std::string front = tick.mantissa == 1 ? "" : fmt::format("{}&#183;", tick.mantissa);
  return fmt::format("{}10<tspan dy=\"-6\" font-size=\"11\">{}</tspan>", front, tick.exponent);
}

// Every power of ten has a label; ticks between them have one if there is room.
bool IsLabelled(const Tick& tick, const Axis& axis) {
  return axis.scale == PlotScale::kLinear || tick.mantissa == 1 || axis.high / axis.low < 300;
}

void WriteAxes(const Plot& plot, const Axis& x, const Axis& y, Writer& write) {
  for (const Tick& tick : x.ticks()) {
    const double at = x.At(tick.value);
    write(R"(<path d="M{0:.1f},{1:.1f}V{2:.1f}" stroke="{3}"/>)", at, y.from, y.to,
          tick.mantissa == 1 ? "#c8c8c8" : "#ececec");
    if (!IsLabelled(tick, x)) continue;
    write(R"(<text x="{:.1f}" y="{:.1f}" text-anchor="middle">{}</text>)", at, y.from + 20,
          TickLabel(x.scale, tick));
  }
  for (const Tick& tick : y.ticks()) {
    const double at = y.At(tick.value);
    write(R"(<path d="M{0:.1f},{1:.1f}H{2:.1f}" stroke="{3}"/>)", x.from, at, x.to,
          tick.mantissa == 1 ? "#c8c8c8" : "#ececec");
    if (!IsLabelled(tick, y)) continue;
    write(R"(<text x="{:.1f}" y="{:.1f}" text-anchor="end">{}</text>)", x.from - 8, at + 5,
          TickLabel(y.scale, tick));
  }
  write(R"(<rect x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}" fill="none" )"
        R"(stroke="#404040"/>)",
        x.from, y.to, x.to - x.from, y.from - y.to);
  write(R"(<text x="{:.1f}" y="{:.1f}" font-size="17" font-weight="bold">{}</text>)", x.from,
        y.to - 14, EscapeXml(plot.title));
  write(R"(<text x="{:.1f}" y="{:.1f}" text-anchor="middle">{}</text>)", (x.from + x.to) / 2,
        y.from + 44, EscapeXml(plot.x_label));
  write(
      R"svg(<text transform="translate(20,{:.1f}) rotate(-90)" text-anchor="middle">{}</text>)svg",
      (y.from + y.to) / 2, EscapeXml(plot.y_label));
}

void WriteLevels(const Plot& plot, const Axis& x, const Axis& y, Writer& write) {
  for (const PlotLevel& level : plot.levels) {
    if (!(level.y >= y.low && level.y <= y.high)) continue;
    write(R"(<path d="M{:.1f},{:.1f}H{:.1f}" stroke="#707070" stroke-dasharray="6 4"/>)", x.from,
          y.At(level.y), x.to);
    write(R"(<text x="{:.1f}" y="{:.1f}" font-size="12" fill="#505050">{}</text>)", x.from + 6,
          y.At(level.y) - 5, EscapeXml(level.name));
  }
  for (const PlotMark& mark : plot.marks) {
    if (!(mark.x >= x.low && mark.x <= x.high)) continue;
    write(R"(<path d="M{:.1f},{:.1f}V{:.1f}" stroke="#707070" stroke-dasharray="6 4"/>)",
          x.At(mark.x), y.from, y.to);
    write(R"(<text x="{:.1f}" y="{:.1f}" font-size="12" fill="#505050">{}</text>)",
          x.At(mark.x) + 5, y.to + 16, EscapeXml(mark.name));
  }
}

// Later series are drawn over earlier ones, whose markers are larger, so that all remain visible
// where curves coincide.
void WriteMarker(std::size_t index, std::size_t count, double x, double y, Writer& write) {
  const double scale = 0.9 + 0.6 * double(count - index) / double(count);
  write(R"svg(<path transform="translate({:.1f},{:.1f}) scale({:.2f})" d="{}" fill="{}" )svg"
        R"svg(stroke="#ffffff"/>)svg",
        x, y, scale, kMarkers[index % std::size(kMarkers)], kColors[index % std::size(kColors)]);
}

void WriteSeries(const Plot& plot, std::size_t index, const Axis& x, const Axis& y, Writer& write) {
  const PlotSeries& series = plot.series[index];
  const char* const color = kColors[index % std::size(kColors)];
  std::string line;
  for (const PlotPoint& point : series.points) {
    if (!IsDrawn(plot, point)) continue;
    line += fmt::format("{}{:.1f},{:.1f}", line.empty() ? "M" : "L", x.At(point.x), y.At(point.y));
  }
  if (line.empty()) return;
  write(R"(<path d="{}" fill="none" stroke="{}" stroke-width="2"/>)", line, color);
  for (const PlotPoint& point : series.points) {
    if (!IsDrawn(plot, point)) continue;
    if (!plot.markers) break;
    const double at = x.At(point.x);
    if (OnAxis(plot.y_scale, point.low) && OnAxis(plot.y_scale, point.high)) {
      const double low = y.At(std::max(point.low, y.low));
      const double high = y.At(std::min(point.high, y.high));
      write(R"(<path d="M{0:.1f},{1:.1f}V{2:.1f}M{3:.1f},{1:.1f}h10M{3:.1f},{2:.1f}h10" )"
            R"(stroke="{4}" fill="none"/>)",
            at, low, high, at - 5, color);
    }
    WriteMarker(index, plot.series.size(), at, y.At(point.y), write);
  }
}

double PlotHeight(const Plot& plot) {
  return kTop + kAxes + kBottom + kLegendRow * double(plot.series.size()) + kGap;
}

std::vector<double> Values(const Plot& plot, double PlotPoint::*member) {
  const PlotScale scale = member == &PlotPoint::x ? plot.x_scale : plot.y_scale;
  std::vector<double> values;
  for (const PlotSeries& series : plot.series) {
    for (const PlotPoint& point : series.points) {
      if (IsDrawn(plot, point) && OnAxis(scale, point.*member)) values.push_back(point.*member);
    }
  }
  return values;
}

// Whiskers of two repetitions can be extremely long, so they are clamped to keep the curves
// readable.
std::vector<double> HeightsWithWhiskers(const Plot& plot) {
  std::vector<double> values = Values(plot, &PlotPoint::y);
  if (values.empty() || plot.y_scale == PlotScale::kLinear) return values;
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  const double low = *least / 3, high = *most * 3;
  for (const auto member : {&PlotPoint::low, &PlotPoint::high}) {
    for (const double end : Values(plot, member)) values.push_back(std::clamp(end, low, high));
  }
  return values;
}

void WritePlot(const Plot& plot, double top, Writer& write) {
  const Axis x = FitAxis(plot.x_scale, Values(plot, &PlotPoint::x), kLeft, kWidth - kRight);
  const Axis y = FitAxis(plot.y_scale, HeightsWithWhiskers(plot), top + kTop + kAxes, top + kTop);
  WriteAxes(plot, x, y, write);
  WriteLevels(plot, x, y, write);
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    WriteSeries(plot, i, x, y, write);
    const double row = y.from + kBottom + kLegendRow * (double(i) + 0.5);
    write(R"(<path d="M{:.1f},{:.1f}h32" stroke="{}" stroke-width="2"/>)", kLeft, row,
          kColors[i % std::size(kColors)]);
    if (plot.markers) WriteMarker(i, plot.series.size(), kLeft + 16, row, write);
    write(R"(<text x="{:.1f}" y="{:.1f}">{}</text>)", kLeft + 42, row + 5,
          EscapeXml(plot.series[i].name));
  }
}

}  // namespace

std::string Svg(std::span<const Plot> plots) {
  double height = 0;
  for (const Plot& plot : plots) height += PlotHeight(plot);
  Writer write;
  write(R"(<svg xmlns="http://www.w3.org/2000/svg" width="{0}" height="{1}" viewBox="0 0 {0} {1}" )"
        R"(font-family="sans-serif" font-size="14">)",
        kWidth, height);
  write(R"(<rect width="{}" height="{}" fill="#ffffff"/>)", kWidth, height);
  double top = 0;
  for (const Plot& plot : plots) {
    WritePlot(plot, top, write);
    top += PlotHeight(plot);
  }
  write("</svg>");
  return write.text();
}

std::string EscapeXml(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped += static_cast<unsigned char>(c) < 0x20 && c != '\n' ? ' ' : c;
    }
  }
  return escaped;
}

}  // namespace skywave
