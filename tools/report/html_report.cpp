#include "tools/report/html_report.hpp"

#include <fstream>
#include <iterator>

#include "tools/io/input_error.hpp"
#include "tools/io/writable.hpp"
#include "tools/report/base64.hpp"

namespace vergence::tools {
namespace {

// Figures keep a white ground in the dark as well: they are drawn on it.
constexpr std::string_view kStyle = R"(
:root{color-scheme:light dark;--ground:#fff;--text:#1d2125;--faint:#5d656d;--line:#d9dde1;--panel:#f5f6f8;
--good:#00694c;--bad:#a63c00}
@media(prefers-color-scheme:dark){:root{--ground:#15181b;--text:#e4e7ea;--faint:#9aa3ab;--line:#343a40;
--panel:#1e2226;--good:#4cc9a0;--bad:#ff9d66}}
*{box-sizing:border-box}
body{margin:0;background:var(--ground);color:var(--text);font:16px/1.5 system-ui,sans-serif}
main{max-width:72rem;margin:0 auto;padding:2rem 1.25rem 4rem}
h1{font-size:1.75rem;line-height:1.2;margin:0 0 .5rem}
h2{font-size:1.2rem;margin:2.25rem 0 .6rem}
.lead{max-width:46rem;margin:0 0 1rem}
.facts{color:var(--faint);font-size:.9rem;margin:0}
.facts span{margin-right:1.5rem;white-space:nowrap}
.scroll{overflow-x:auto}
table{border-collapse:collapse;width:100%;font-size:.93rem}
th,td{text-align:left;vertical-align:top;padding:.4rem .8rem .4rem 0;border-bottom:1px solid var(--line)}
th{color:var(--faint);font-weight:600}
.number{text-align:right;white-space:nowrap;font-variant-numeric:tabular-nums}
.thesis{text-align:right;font-variant-numeric:tabular-nums}
.name{font-family:ui-monospace,monospace;font-size:.87rem}
.why{color:var(--faint);min-width:14rem}
.good{color:var(--good);font-weight:600;white-space:nowrap}
.bad{color:var(--bad);font-weight:600;white-space:nowrap}
figure{margin:1.25rem 0}
figure img{display:block;max-width:100%;height:auto;background:#fff;border:1px solid var(--line);
border-radius:4px}
figcaption{color:var(--faint);font-size:.9rem;margin-top:.4rem;max-width:46rem}
pre,code{font-family:ui-monospace,monospace;font-size:.87rem}
pre{background:var(--panel);padding:.8rem 1rem;border-radius:4px;white-space:pre-wrap;
overflow-wrap:anywhere;margin:0}
@media print{:root{--ground:#fff;--text:#000;--faint:#444;--line:#bbb;--panel:#f5f6f8;--good:#00694c;
--bad:#a63c00}
main{max-width:none;padding:0}figure,tr{break-inside:avoid}h2{break-after:avoid}}
)";

std::string png_bytes(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(file, "", "cannot be read");
  std::string bytes{std::istreambuf_iterator<char>(in), {}};
  constexpr std::string_view kSignature("\x89PNG\r\n\x1a\n", 8);
  if (!bytes.starts_with(kSignature)) throw InputError(file, "", "is not a PNG");
  return bytes;
}

void write_metric(std::ostream& out, const Metric& metric) {
  out << "<tr><td class=\"name\">" << html_escaped(metric.name) << "</td><td class=\"number\">"
      << html_escaped(value_text(metric.value)) << "</td><td>" << html_escaped(metric.unit)
      << "</td><td class=\"number\">" << html_escaped(target_text(metric)) << "</td><td class=\"thesis\">"
      << html_escaped(metric.thesis.value_or("-")) << "</td>";
  if (!metric.target) {
    out << "<td></td>";
  } else {
    out << (metric.met() ? "<td class=\"good\" title=\"met\">✓</td>" : "<td class=\"bad\">not reached</td>");
  }
  out << "<td class=\"why\">" << html_escaped(metric.explanation) << "</td></tr>\n";
}

void write_metrics(std::ostream& out, const Summary& summary) {
  if (summary.metrics.empty()) return;
  out << "<h2>Measured</h2>\n<div class=\"scroll\"><table>\n<thead><tr><th>metric</th><th "
         "class=\"number\">value</th><th>unit</th><th class=\"number\">target</th><th "
         "class=\"thesis\">thesis</th><th>met</th><th>what it is</th></tr></thead>\n<tbody>\n";
  for (const Metric& metric : summary.metrics) write_metric(out, metric);
  out << "</tbody>\n</table></div>\n";
}

void write_pictures(std::ostream& out, const std::vector<Picture>& pictures,
                    const std::vector<std::string>& bytes) {
  if (pictures.empty()) return;
  out << "<h2>Figures</h2>\n";
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const std::string caption = html_escaped(pictures[i].caption);
    out << "<figure><img alt=\"" << caption << "\" src=\"data:image/png;base64," << base64(bytes[i])
        << "\"><figcaption>" << caption << "</figcaption></figure>\n";
  }
}

void write_notes(std::ostream& out, const std::vector<std::string>& notes) {
  if (notes.empty()) return;
  out << "<h2>Notes</h2>\n<ul>\n";
  for (const std::string& note : notes) out << "<li>" << html_escaped(note) << "</li>\n";
  out << "</ul>\n";
}

}  // namespace

std::string html_escaped(std::string_view text) {
  std::string escaped;
  escaped.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&': escaped += "&amp;"; break;
      case '<': escaped += "&lt;"; break;
      case '>': escaped += "&gt;"; break;
      case '"': escaped += "&quot;"; break;
      case '\'': escaped += "&#39;"; break;
      default: escaped += c;
    }
  }
  return escaped;
}

void write_html_report(const std::filesystem::path& file, const ReportPage& page) {
  std::vector<std::string> bytes;  // read before anything is written
  for (const Picture& picture : page.pictures) bytes.push_back(png_bytes(picture.png));
  require_writable(file);
  std::ofstream out(file, std::ios::binary);
  const Summary& summary = page.summary;
  out << "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>"
      << html_escaped(page.title) << "</title>\n<style>" << kStyle
      << "</style>\n</head>\n<body>\n<main>\n<h1>" << html_escaped(page.title) << "</h1>\n<p class=\"lead\">"
      << html_escaped(page.description) << "</p>\n<p class=\"facts\"><span>scenario "
      << html_escaped(summary.scenario) << "</span><span>seed " << summary.seed << "</span><span>"
      << html_escaped(value_text(summary.duration_s)) << " s simulated</span><span>signature <code>"
      << html_escaped(summary.signature) << "</code></span></p>\n";
  write_metrics(out, summary);
  write_pictures(out, page.pictures, bytes);
  write_notes(out, page.notes);
  out << "<h2>The same run again</h2>\n<pre>" << html_escaped(page.command)
      << "</pre>\n<p class=\"facts\">It gives the same log, bit by bit, with the signature <code>"
      << html_escaped(summary.signature) << "</code>.</p>\n</main>\n</body>\n</html>\n";
  if (!out.flush()) throw InputError(file, "", "cannot be written to its end", "is the disk full?");
}

}  // namespace vergence::tools
