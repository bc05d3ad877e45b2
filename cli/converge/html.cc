#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/granted.h"
#include "base/version.h"
#include "bench/measure/html.h"
#include "cli/converge/report.h"

namespace skywave {
namespace {

constexpr std::string_view kStyle =
    "body{font:15px/1.45 sans-serif;max-width:1060px;margin:24px auto;padding:0 16px;color:#202020}"
    "h1{font-size:24px}h2{font-size:19px;margin-top:34px}"
    ".wide{overflow-x:auto}.lines{white-space:pre-line}table{border-collapse:collapse;font-size:"
    "13px}"
    "th,td{padding:3px 8px;text-align:left;white-space:nowrap;border-bottom:1px solid #d8d8d8}"
    "svg{max-width:100%;height:auto}"
    ".pair{display:flex;gap:12px}.pair img{width:calc(50% - 6px);height:auto}"
    ".warning{background:#fff3cd;border-left:4px solid #e69f00;padding:8px 12px}"
    "figure{margin:18px 0}figcaption{font-size:13px;color:#404040}code{font-size:13px}";

std::string Picture(const Image& image, const std::vector<std::uint8_t>& rgb,
                    const std::string& alt) {
  return fmt::format("<img width=\"{}\" height=\"{}\" alt=\"{}\" src=\"{}\">", image.width,
                     image.height, EscapeXml(alt),
                     DataAddress("image/png", EncodePng(image.width, image.height, rgb)));
}

// Returns one scale for all error maps, so that they can be compared: twice the typical relative
// error of the median strategy, to two digits.
double FullScale(const ConvergeReport& report) {
  std::vector<double> errors;
  for (const Contestant& contestant : report.contestants) {
    errors.push_back(Mean(contestant.ladder.back().errors(ErrorMeasure::kRelativeMse)));
  }
  const double scale = 2 * std::sqrt(Median(errors));
  if (!(scale > 1e-6) || !std::isfinite(scale)) return 1;
  const double unit = std::pow(10, std::floor(std::log10(scale)) - 1);
  return std::ceil(scale / unit) * unit;
}

std::string HtmlTable(const TextTable& table) {
  std::string html = "<div class=\"wide\"><table>\n";
  for (const auto& row : table) {
    const std::string_view cell = &row == &table.front() ? "th" : "td";
    html += "<tr>";
    for (const std::string& text : row) {
      html += fmt::format("<{0}>{1}</{0}>", cell, EscapeXml(text));
    }
    html += "</tr>\n";
  }
  return html + "</table></div>\n";
}

std::string Figure(const std::string& pictures, const std::string& caption) {
  return fmt::format(
      "<figure>\n<div class=\"pair\">{}</div>\n<figcaption>{}</figcaption>\n</figure>\n", pictures,
      caption);
}

}  // namespace

std::string Html(const ConvergeReport& report, const ToneMapping& tone) {
  const RenderOptions& options = report.job->options();
  std::string page = HtmlStart(report.scene + ": convergence", kStyle);
  page += fmt::format(
      "<h1>{}: error at equal time</h1>\n"
      "<p>{} x {} pixels, {} threads, {} runs each; skywave {}.<br>\n"
      "<code>{}</code></p>\n",
      EscapeXml(report.scene), options.width, options.height, ThreadsFor(options.threads),
      report.settings.repeats, Version(), EscapeXml(report.command));
  for (const std::string& warning : report.warnings) {
    page += fmt::format("<p class=\"warning\">{}</p>\n", EscapeXml(warning));
  }
  page += "<h2>Curves</h2>\n" + Svg(Plots(report));
  page += "<p>Whiskers: 95 % confidence intervals of the mean error.</p>\n";
  page += fmt::format("<h2>Figures</h2>\n<p class=\"lines\">{}</p>\n{}<p>{}.</p>\n{}",
                      EscapeXml(Introduction(report)), HtmlTable(BudgetTable(report)),
                      EscapeXml(TargetText(report)), HtmlTable(TargetTable(report)));

  const double full_scale = FullScale(report);
  page += "<h2>Pictures</h2>\n";
  page +=
      Figure(Picture(report.reference.image, ToneMap(report.reference.image, tone), "reference"),
             "The reference.");
  for (const Contestant& contestant : report.contestants) {
    const Image& image = contestant.picture;
    const Rung& rung = contestant.ladder.back();
    page += Figure(
        Picture(image, ToneMap(image, tone), contestant.name) + "\n" +
            Picture(image, ErrorMap(image, report.reference.image, full_scale),
                    "error of " + contestant.name),
        fmt::format("<code>{}</code>, {} samples a pixel, {:.3g} s, mse {:.3g}. Right: relative "
                    "error, black 0, yellow {:.2g} and more.",
                    EscapeXml(contestant.name), rung.samples_per_pixel, rung.runs.front().seconds,
                    rung.runs.front().error.mse, full_scale));
  }
  return page + HtmlEnd();
}

}  // namespace skywave
