#include "job/batch/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include "base/version.h"
#include "bench/measure/html.h"
#include "bench/measure/plot.h"
#include "job/picture.h"

namespace skywave {
namespace {

// With more columns than these, pictures are not laid out as a grid but flow from line to line.
constexpr std::size_t kMostColumns = 8;

constexpr std::string_view kPageStyle =
    ":root{color-scheme:light dark;--ink:#1f2328;--soft:#656d76;--line:#d8dee4;--paper:#fff;"
    "--plate:#f6f8fa;--bad:#b42318;--bad-plate:#fef3f2;--link:#0b62c4}"
    "@media(prefers-color-scheme:dark){:root{--ink:#e6e6e6;--soft:#9a9fa6;--line:#34383e;"
    "--paper:#16181b;--plate:#1f2226;--bad:#ff8a7a;--bad-plate:#2c1a18;--link:#7db4ff}}"
    "body{font:15px/1.5 system-ui,sans-serif;margin:0 auto;max-width:1480px;padding:24px;"
    "color:var(--ink);background:var(--paper)}"
    "h1{font-size:26px;margin:0 0 4px}h2{font-size:18px;margin:32px 0 10px}"
    "h3{font-size:15px;margin:20px 0 8px;color:var(--soft);font-weight:600}"
    "a{color:var(--link);text-decoration:none}a:hover{text-decoration:underline}"
    ".facts{display:flex;flex-wrap:wrap;gap:8px 28px;margin:14px 0 0;padding:0}"
    ".facts div{min-width:80px}.facts dt{font-size:12px;color:var(--soft)}"
    ".facts dd{margin:0;font-size:18px;font-variant-numeric:tabular-nums}"
    ".path{color:var(--soft);font-size:13px;margin:0}"
    ".bad{background:var(--bad-plate);border-left:4px solid var(--bad);padding:10px 14px;"
    "margin:8px 0;border-radius:0 6px 6px 0;overflow-wrap:anywhere}"
    ".wide{overflow-x:auto}"
    ".flow{display:flex;flex-wrap:wrap;gap:14px}"
    "figure{margin:0;width:160px}"
    "figure .plate{display:flex;align-items:center;justify-content:center;min-height:60px;"
    "background:var(--plate);border-radius:6px;overflow:hidden;color:var(--soft);font-size:13px}"
    "figure img{display:block;max-width:160px;max-height:160px}"
    "figure.failed .plate{background:var(--bad-plate);color:var(--bad)}"
    "figcaption{font-size:12px;color:var(--soft);margin-top:4px;overflow-wrap:anywhere;"
    "font-variant-numeric:tabular-nums}"
    "figcaption b{color:var(--ink);font-weight:600}"
    "table{border-collapse:collapse}"
    ".grid th{font-size:13px;font-weight:600;text-align:left;padding:6px 8px;vertical-align:top}"
    ".grid td{padding:6px 8px;vertical-align:top}"
    ".list{font-size:13px;font-variant-numeric:tabular-nums}"
    ".list th,.list td{padding:5px 10px;text-align:left;border-bottom:1px solid var(--line);"
    "white-space:nowrap}"
    ".list td.number{text-align:right}.list td.text{white-space:normal;min-width:200px}"
    ".list th button{all:unset;cursor:pointer;font-weight:600}"
    ".list th button:focus-visible{outline:2px solid var(--link)}"
    ".list th[aria-sort=ascending] button::after{content:\" \\25B2\"}"
    ".list th[aria-sort=descending] button::after{content:\" \\25BC\"}"
    ".list tbody tr:hover{background:var(--plate)}.list .failed{color:var(--bad)}"
    "footer{margin-top:36px;color:var(--soft);font-size:12px}"
    "@media print{body{max-width:none}.list{font-size:10px}}";

// Sorts the rows of the table by the column of the button that is pressed: numbers by value, empty
// cells last.
constexpr std::string_view kSortScript =
    "document.querySelectorAll('.list th button').forEach((button, column) => {\n"
    "  button.addEventListener('click', () => {\n"
    "    const head = button.parentNode, body = head.closest('table').tBodies[0];\n"
    "    const down = head.getAttribute('aria-sort') === 'ascending';\n"
    "    head.parentNode.querySelectorAll('th').forEach(th => th.removeAttribute('aria-sort'));\n"
    "    head.setAttribute('aria-sort', down ? 'descending' : 'ascending');\n"
    "    const key = row => row.cells[column].textContent.trim();\n"
    "    const compare = (a, b) => {\n"
    "      const x = key(a), y = key(b);\n"
    "      if (x === '' || y === '') return (x === '') - (y === '');\n"
    "      const order = x.localeCompare(y, 'en', {numeric: true});\n"
    "      const number = Number(x) - Number(y);\n"
    "      return (down ? -1 : 1) * (Number.isNaN(number) ? order : number);\n"
    "    };\n"
    "    body.append(...Array.from(body.rows).sort(compare));\n"
    "  });\n"
    "});\n";

std::string Seconds(double seconds) {
  if (seconds < 60) return fmt::format("{:.3g} s", seconds);
  const auto whole = std::uint64_t(seconds + 0.5);
  if (whole < 3600) return fmt::format("{}:{:02} min", whole / 60, whole % 60);
  return fmt::format("{}:{:02} h", whole / 3600, whole / 60 % 60);
}

double SecondsOf(const PictureResult& result) {
  return result.load_seconds + result.render_seconds + result.write_seconds;
}

// The rate of a picture in Msamples/s, or nothing.
std::string RateText(std::uint64_t samples, double seconds) {
  return seconds > 0 ? fmt::format("{:.3g}", double(samples) / seconds * 1e-6) : "";
}

std::string Fact(std::string_view name, const std::string& value) {
  return fmt::format("<div><dt>{}</dt><dd>{}</dd></div>", name, EscapeXml(value));
}

std::string Heading(const BatchPlan& plan, const BatchSummary& summary) {
  std::string facts = Fact("pictures", fmt::format("{}", plan.pictures.size()));
  for (const PictureStatus status : ValuesOf<PictureStatus>()) {
    const std::size_t count = summary.Count(status);
    if (count > 0) facts += Fact(ToString(status), fmt::format("{}", count));
  }
  facts += Fact("wall clock", Seconds(summary.seconds));
  facts += Fact("rendering", Seconds(summary.render_seconds()));
  const std::string rate = RateText(summary.samples(), summary.render_seconds());
  if (!rate.empty()) facts += Fact("Msamples/s", rate);
  return fmt::format("<h1>{}</h1>\n<p class=\"path\">{}</p>\n<dl class=\"facts\">{}</dl>\n",
                     EscapeXml(std::filesystem::path(plan.path).stem().string()),
                     EscapeXml(plan.path), facts);
}

// "env grace, seed 3"
std::string ValuesText(const BatchPicture& picture) {
  std::string text;
  for (const AxisValue& value : picture.axes) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", value.axis, value.label);
  }
  return text;
}

std::string Failures(const BatchPlan& plan, const BatchSummary& summary) {
  std::string html;
  if (!summary.stopped.empty()) {
    html +=
        fmt::format("<p class=\"bad\">The batch ended early: {}</p>\n", EscapeXml(summary.stopped));
  }
  for (std::size_t i = 0; i < plan.pictures.size(); ++i) {
    const PictureResult& result = summary.results[i];
    if (result.status != PictureStatus::kFailed) continue;
    html += fmt::format("<p class=\"bad\"><b>{}</b> ({})<br>{}</p>\n",
                        EscapeXml(RelativeName(plan.folder, plan.pictures[i].output)),
                        EscapeXml(ValuesText(plan.pictures[i])), EscapeXml(result.error));
  }
  return html.empty() ? html : "<h2>Failures</h2>\n" + html;
}

bool IsThere(const PictureResult& result) {
  return result.status == PictureStatus::kRendered || result.status == PictureStatus::kSkipped;
}

// Returns a link to a file beside the page.
std::string Link(const BatchPlan& plan, const std::string& file, const std::string& html) {
  return fmt::format("<a href=\"{}\">{}</a>", FileAddress(RelativeName(plan.folder, file)), html);
}

// A picture with a caption in HTML.
std::string FigureOf(const BatchPlan& plan, const BatchPicture& picture,
                     const PictureResult& result, const Thumbnail& thumbnail,
                     const std::string& caption) {
  const std::string png = PngBeside(picture.output);
  std::string plate(ToString(result.status));
  if (IsThere(result)) {
    const std::string name = RelativeName(plan.folder, png);
    plate = thumbnail.width > 0
                ? fmt::format("<img width=\"{}\" height=\"{}\" alt=\"{}\" src=\"{}\">",
                              thumbnail.width, thumbnail.height, EscapeXml(name),
                              DataAddress("image/jpeg", thumbnail.jpeg))
                : fmt::format("<img loading=\"lazy\" alt=\"{}\" src=\"{}\">", EscapeXml(name),
                              FileAddress(name));
    plate = Link(plan, png, plate);
  }
  std::string figures;
  if (IsThere(result) && SecondsOf(result) > 0) figures = Seconds(SecondsOf(result));
  if (IsThere(result) && result.noise)
    figures += fmt::format("{}noise {:.3g}", figures.empty() ? "" : ", ", *result.noise);
  if (!caption.empty() && !figures.empty()) figures = "<br>" + figures;
  return fmt::format(
      "<figure class=\"{}\"><div class=\"plate\">{}</div><figcaption>{}{}"
      "</figcaption></figure>",
      ToString(result.status), plate, caption, figures);
}

// How pictures are laid out: sections by all varying dimensions but the last one or two, and in
// each a grid or a flow.
struct SheetLayout {
  std::vector<std::size_t> sections;         // dimensions
  std::optional<std::size_t> rows, columns;  // dimensions of the grid; none: pictures flow
  std::optional<std::size_t> flow;           // the dimension that varies in a flow
};

SheetLayout LayoutOf(const BatchPlan& plan) {
  std::vector<std::size_t> varying;
  for (std::size_t d = 0; d < plan.dimensions.size(); ++d) {
    if (plan.dimensions[d].labels.size() > 1) varying.push_back(d);
  }
  SheetLayout layout;
  if (varying.empty()) return layout;
  const std::size_t last = varying.back();
  varying.pop_back();
  if (!varying.empty() && plan.dimensions[last].labels.size() <= kMostColumns) {
    layout.columns = last, layout.rows = varying.back();
    varying.pop_back();
  } else {
    layout.flow = last;
  }
  layout.sections = varying;
  return layout;
}

std::string LabelAt(const BatchPlan& plan, const BatchPicture& picture, std::size_t dimension) {
  return EscapeXml(plan.dimensions[dimension].labels[picture.place[dimension]]);
}

struct SheetInput {
  const BatchPlan& plan;
  const BatchSummary& summary;
  std::span<const Thumbnail> thumbnails;
};

void WriteGrid(const SheetInput& in, const std::vector<std::size_t>& pictures, std::size_t rows,
               std::size_t columns, const PieceWriter& out) {
  const BatchDimension &row = in.plan.dimensions[rows], &column = in.plan.dimensions[columns];
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> at;
  for (const std::size_t i : pictures) {
    const BatchPicture& picture = in.plan.pictures[i];
    at[{picture.place[rows], picture.place[columns]}] = i;
  }
  out(fmt::format("<div class=\"wide\"><table class=\"grid\">\n<tr><th>{} / {}</th>",
                  EscapeXml(row.name), EscapeXml(column.name)));
  for (const std::string& label : column.labels) {
    out(fmt::format("<th scope=\"col\">{}</th>", EscapeXml(label)));
  }
  out("</tr>\n");
  for (std::size_t r = 0; r < row.labels.size(); ++r) {
    out(fmt::format("<tr><th scope=\"row\">{}</th>", EscapeXml(row.labels[r])));
    for (std::size_t c = 0; c < column.labels.size(); ++c) {
      const auto found = at.find({r, c});
      out("<td>");
      if (found != at.end()) {
        const std::size_t i = found->second;
        out(FigureOf(in.plan, in.plan.pictures[i], in.summary.results[i], in.thumbnails[i], ""));
      }
      out("</td>");
    }
    out("</tr>\n");
  }
  out("</table></div>\n");
}

void WriteFlow(const SheetInput& in, const std::vector<std::size_t>& pictures,
               std::optional<std::size_t> dimension, const PieceWriter& out) {
  out("<div class=\"flow\">\n");
  for (const std::size_t i : pictures) {
    const BatchPicture& picture = in.plan.pictures[i];
    const std::string caption =
        dimension ? fmt::format("{} <b>{}</b>", EscapeXml(in.plan.dimensions[*dimension].name),
                                LabelAt(in.plan, picture, *dimension))
                  : EscapeXml(RelativeName(in.plan.folder, picture.output));
    out(FigureOf(in.plan, picture, in.summary.results[i], in.thumbnails[i], caption) + "\n");
  }
  out("</div>\n");
}

void WriteContactSheet(const SheetInput& in, const PieceWriter& out) {
  const SheetLayout layout = LayoutOf(in.plan);
  std::map<std::vector<std::size_t>, std::vector<std::size_t>> sections;
  for (std::size_t i = 0; i < in.plan.pictures.size(); ++i) {
    std::vector<std::size_t> key;
    for (const std::size_t d : layout.sections) key.push_back(in.plan.pictures[i].place[d]);
    sections[key].push_back(i);
  }
  out("<h2>Pictures</h2>\n");
  for (const auto& [key, pictures] : sections) {
    std::string heading;
    for (const std::size_t d : layout.sections) {
      heading +=
          fmt::format("{}{} {}", heading.empty() ? "" : ", ", EscapeXml(in.plan.dimensions[d].name),
                      LabelAt(in.plan, in.plan.pictures[pictures.front()], d));
    }
    if (!heading.empty()) out(fmt::format("<h3>{}</h3>\n", heading));
    if (layout.rows) {
      WriteGrid(in, pictures, *layout.rows, *layout.columns, out);
    } else {
      WriteFlow(in, pictures, layout.flow, out);
    }
  }
}

void WritePictureList(const BatchPlan& plan, const BatchSummary& summary, const PieceWriter& out) {
  std::vector<std::string> heads = {"picture", "file"};
  for (const AxisValue& value : plan.pictures.front().axes) heads.push_back(value.axis);
  heads.insert(heads.end(),
               {"status", "load [s]", "render [s]", "write [s]", "Msamples/s", "noise", "error"});
  out("<h2>Table</h2>\n<div class=\"wide\"><table class=\"list\">\n<thead><tr>");
  for (const std::string& head : heads) {
    out(fmt::format("<th scope=\"col\"><button type=\"button\">{}</button></th>", EscapeXml(head)));
  }
  out("</tr></thead>\n<tbody>\n");
  for (std::size_t i = 0; i < plan.pictures.size(); ++i) {
    const BatchPicture& picture = plan.pictures[i];
    const PictureResult& result = summary.results[i];
    const auto number = [&](const std::string& text) {
      out(fmt::format("<td class=\"number\">{}</td>", text));
    };
    const auto seconds = [&](double value) {
      number(value > 0 ? fmt::format("{:.3f}", value) : std::string());
    };
    out(fmt::format("<tr class=\"{}\">", ToString(result.status)));
    number(fmt::format("{}", picture.index));
    const std::string name = EscapeXml(RelativeName(plan.folder, picture.output));
    out(fmt::format("<td>{}</td>", IsThere(result) ? Link(plan, picture.output, name) : name));
    for (const AxisValue& value : picture.axes) {
      out(fmt::format("<td>{}</td>", EscapeXml(value.label)));
    }
    out(fmt::format("<td>{}</td>", ToString(result.status)));
    seconds(result.load_seconds), seconds(result.render_seconds), seconds(result.write_seconds);
    number(RateText(result.samples, result.render_seconds));
    number(result.noise ? fmt::format("{:.4g}", *result.noise) : std::string());
    out(fmt::format("<td class=\"text\">{}</td></tr>\n", EscapeXml(result.error)));
  }
  out("</tbody></table></div>\n");
}

}  // namespace

void WriteBatchPage(const BatchPlan& plan, const BatchSummary& summary,
                    std::span<const Thumbnail> thumbnails, const PieceWriter& out) {
  const std::string title = std::filesystem::path(plan.path).stem().string() + ": batch";
  out(HtmlStart(title, kPageStyle) + Heading(plan, summary) + Failures(plan, summary));
  WriteContactSheet({plan, summary, thumbnails}, out);
  WritePictureList(plan, summary, out);
  out(fmt::format("<footer>skywave {}</footer>\n<script>\n{}</script>\n", Version(), kSortScript) +
      HtmlEnd());
}

}  // namespace skywave
