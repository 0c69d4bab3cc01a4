#include "orchestrator/commands/report_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace phiz {
namespace {

using nlohmann::ordered_json;

constexpr const char* kStyle = R"(
:root{font:15px/1.5 system-ui,sans-serif;color-scheme:light dark}body{margin:0 auto;max-width:1180px;padding:24px}
table{border-collapse:collapse;margin:8px 0}th,td{padding:4px 12px;text-align:right;border-bottom:1px solid #8884}
th:first-child,td:first-child{text-align:left}th{cursor:pointer}img{max-width:100%;border-radius:8px}
.good{color:#2a8a4a}.look{color:#b87a00}.poor,.not{color:#c03030}section{border-top:2px solid #8886;margin-top:28px}
.gallery img{height:84px}details{margin:6px 0}pre{white-space:pre-wrap;font-size:12px;word-break:break-all}
svg{background:#8881;border-radius:6px;margin:4px 12px 4px 0}figure{margin:12px 0}figcaption{font-size:13px;opacity:.7})";

/// Sorts the gallery by the column that was pressed, numbers as numbers.
constexpr const char* kScript = R"(
document.querySelectorAll('table.gallery th').forEach((head,k)=>head.addEventListener('click',()=>{
const body=head.closest('table').tBodies[0],rows=[...body.rows],up=head.dataset.up!=='1';head.dataset.up=up?'1':'0';
const value=r=>{const t=r.cells[k].dataset.value??r.cells[k].textContent,n=parseFloat(t);return isNaN(n)?t:n};
rows.sort((a,b)=>{const x=value(a),y=value(b);return(x<y?-1:x>y?1:0)*(up?1:-1)});body.append(...rows)}));)";

std::string escape(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    switch (c) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      default:
        safe += c;
    }
  }
  return safe;
}

std::string to_base64(const std::string& bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned word = 0;
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k)
      word = word << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kDigits[word >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::string picture(const SubjectReport& report, const std::string& name, const std::string& caption) {
  const auto found = report.pictures.find(name);
  if (found == report.pictures.end()) return {};
  return fmt::format(
      "<figure><img loading=\"lazy\" alt=\"{}\" "
      "src=\"data:image/png;base64,{}\"><figcaption>{}</figcaption></figure>\n",
      escape(caption), to_base64(found->second), escape(caption));
}

std::string format_number(const ordered_json& value) {
  return value.is_number_float() ? fmt::format("{:.4g}", value.get<double>()) : value.dump();
}

/// A curve of numbers, drawn: what a stage reports round by round.
std::string plot(const std::string& name, const ordered_json& numbers) {
  constexpr double kWidth = 320, kHeight = 110, kEdge = 8;
  double low = 0, high = 0;
  for (const auto& number : numbers) high = std::max(high, number.get<double>());
  for (const auto& number : numbers) low = std::min(low, number.get<double>());
  if (!(high > low)) return {};
  std::string points;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const double x =
        kEdge + (kWidth - 2 * kEdge) * static_cast<double>(i) / static_cast<double>(numbers.size() - 1);
    const double y =
        kHeight - kEdge - (kHeight - 2 * kEdge) * (numbers[i].get<double>() - low) / (high - low);
    points += fmt::format("{:.1f},{:.1f} ", x, y);
  }
  return fmt::format(
      "<figure><svg width=\"{}\" height=\"{}\" role=\"img\"><polyline fill=\"none\" stroke=\"#3a78b8\" "
      "stroke-width=\"2\" points=\"{}\"/></svg>"
      "<figcaption>{}: {:.4g} to {:.4g}</figcaption></figure>",
      kWidth, kHeight, points, escape(name), numbers.front().get<double>(), numbers.back().get<double>());
}

/// Every figure of a stage's summary: lists of numbers as curves, the rest as a table.
void append_summary(const std::string& prefix, const ordered_json& object, std::string& rows,
                    std::string& plots) {
  for (const auto& [key, value] : object.items()) {
    const std::string name = prefix + key;
    const bool is_list = value.is_array() && value.size() > 2 &&
                         std::all_of(value.begin(), value.end(), [](const auto& v) { return v.is_number(); });
    if (is_list)
      plots += plot(name, value);
    else if (value.is_object())
      append_summary(name + ".", value, rows, plots);
    else if (value.is_number() || value.is_boolean() || value.is_string())
      rows += fmt::format("<tr><td>{}</td><td>{}</td></tr>\n", escape(name),
                          escape(value.is_string() ? value.get<std::string>() : format_number(value)));
  }
}

std::string residual_row(const std::string& name, const Residuals& r) {
  return fmt::format(
      "<tr><td>{}</td><td>{}</td><td>{:.3f}</td><td>{:.3f}</td><td>{:.3f}</td><td>{:.3f}</td></tr>\n",
      escape(name), r.points, r.mean_mm, r.median_mm, r.p95_mm, r.p99_mm);
}

std::string residual_tables(const SubjectReport& report) {
  std::string html =
      "<h3>Distance of the scan's points to the surface, "
      "mm</h3><table><tr><th>where</th><th>points</th><th>mean</th>"
      "<th>median</th><th>95 %</th><th>99 %</th></tr>\n" +
      residual_row("everywhere", report.residuals);
  for (const auto& [name, residuals] : report.regions) html += residual_row(name, residuals);
  html += "</table><figure><svg width=\"340\" height=\"120\" role=\"img\">";
  for (std::size_t k = 0; k < report.histogram.size(); ++k) {
    const double height = 110 * std::sqrt(report.histogram[k]);
    html += fmt::format("<rect x=\"{}\" y=\"{:.1f}\" width=\"18\" height=\"{:.1f}\" fill=\"#3a78b8\"/>",
                        8 + 20 * k, 116 - height, height);
  }
  return html +
         "</svg><figcaption>share of points by 0.1 mm (square root), the last bar beyond 1.5 "
         "mm</figcaption></figure>\n";
}

std::string stage_tables(const SubjectReport& report) {
  std::string
      html = "<h3>Stages</h3><table><tr><th>stage</th><th>state</th><th>seconds</th><th>peak MiB</th></tr>\n",
      rest;
  for (const StageReport& stage : report.stages) {
    html += fmt::format("<tr><td>{}</td><td>{}</td><td>{:.2f}</td><td>{:.0f}</td></tr>\n", escape(stage.name),
                        escape(stage.status), stage.seconds,
                        static_cast<double>(stage.peak_memory_bytes) / (1 << 20));
    std::string rows, plots;
    if (stage.summary.is_object()) append_summary("", stage.summary, rows, plots);
    rest += fmt::format(
        "<details><summary>{}: figures, parameters, provenance</summary>{}<table>{}</table><pre>{}",
        escape(stage.name), plots, rows, escape(stage.key_text));
    for (const auto& [name, digest] : stage.outputs)
      rest += fmt::format("\noutput {} {}", escape(name), digest);
    rest += "</pre></details>\n";
  }
  return html + "</table>\n" + rest;
}

std::string verdict_class(const std::string& verdict) {
  return verdict.substr(0, verdict.find_first_of(": "));
}

std::string chapter(const SubjectReport& report) {
  std::string html = fmt::format(
      "<section id=\"{0}\"><h2>{0} <span class=\"{1}\">{2}</span></h2><p>{3}<br><small>{4}</small></p>\n",
      escape(report.name), verdict_class(report.verdict), escape(report.verdict), escape(report.scan_path),
      report.scan_digest);
  html += picture(report, "head.png", "the finished head");
  html += picture(report, "distances.png",
                  "mean distance of the scan's points around each vertex; grey: nothing was scanned");
  for (const auto& [name, bytes] : report.pictures)
    if (name != "head.png" && name != "distances.png")
      html += picture(report, name, name.substr(0, name.find('.')));
  return html + residual_tables(report) + stage_tables(report) + "</section>\n";
}

}  // namespace

std::string make_report_page(const std::vector<SubjectReport>& reports) {
  std::string html =
      "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width,initial-scale=1\">"
      "<title>phiz report</title><style>" +
      std::string(kStyle) + "</style></head><body><h1>Fitted heads</h1>\n";
  html +=
      "<table class=\"gallery\"><thead><tr><th>subject</th><th>head</th><th>verdict</th><th>mean "
      "mm</th><th>95 % mm</th><th>seconds</th></tr></thead><tbody>\n";
  for (const SubjectReport& report : reports) {
    double seconds = 0;
    for (const StageReport& stage : report.stages) seconds += stage.seconds;
    html += fmt::format("<tr><td><a href=\"#{0}\">{0}</a></td><td data-value=\"{0}\">", escape(report.name));
    const auto head = report.pictures.find("head.png");
    if (head != report.pictures.end())
      html += fmt::format("<img loading=\"lazy\" alt=\"\" src=\"data:image/png;base64,{}\">",
                          to_base64(head->second));
    html += fmt::format("</td><td class=\"{}\">{}</td><td>{:.3f}</td><td>{:.3f}</td><td>{:.2f}</td></tr>\n",
                        verdict_class(report.verdict), escape(report.verdict), report.residuals.mean_mm,
                        report.residuals.p95_mm, seconds);
  }
  html += "</tbody></table>\n";
  for (const SubjectReport& report : reports) html += chapter(report);
  return html + "<script>" + kScript + "</script></body></html>\n";
}

}  // namespace phiz
