#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "src/batch/batch.h"
#include "src/batch/summary.h"

namespace overtet {

namespace {

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        // Other control characters are none of HTML's.
        out += static_cast<unsigned char>(c) < ' ' && c != '\n' && c != '\t' ? ' ' : c;
    }
  return out;
}

std::string axis_label(double x) {
  char text[32];
  std::snprintf(text, sizeof text, std::abs(x) < 1000 ? "%.3g" : "%.0f", x);
  return text;
}

const char* const style = R"css(
:root { color-scheme: light dark; }
body { font: 15px/1.5 system-ui, sans-serif; max-width: 72rem; margin: 2rem auto; padding: 0 1rem; }
.charts { display: flex; flex-wrap: wrap; gap: 1.5rem; }
figure { margin: 0; } figcaption { font-weight: 600; }
svg { font: 11px system-ui, sans-serif; } svg text { fill: currentColor; } svg rect { fill: #3b7dbb; }
svg line { stroke: currentColor; stroke-opacity: .4; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: .2rem .6rem; border-bottom: 1px solid #8884; vertical-align: top; }
td.number, th.number { text-align: right; }
th button { all: unset; cursor: pointer; font-weight: 600; } th button:focus-visible { outline: 2px solid; }
)css";

// Sorts the table by the column whose heading is pressed: numbers as numbers, missing ones last.
const char* const script = R"js(
for (const button of document.querySelectorAll("th button")) button.addEventListener("click", () => {
  const heading = button.parentElement, column = heading.cellIndex, body = document.querySelector("tbody");
  const up = heading.getAttribute("aria-sort") !== "ascending", number = heading.className === "number";
  for (const other of heading.parentElement.children) other.removeAttribute("aria-sort");
  heading.setAttribute("aria-sort", up ? "ascending" : "descending");
  const key = row => number ? (row.cells[column].textContent === "" ? Infinity : +row.cells[column].textContent)
                            : row.cells[column].textContent;
  const rows = [...body.rows].map(row => [key(row), row]);
  rows.sort(([a], [b]) => a === b ? 0 : a === Infinity ? 1 : b === Infinity ? -1 : (a < b) === up ? -1 : 1);
  body.append(...rows.map(([, row]) => row));
});
)js";

std::string chart(const std::string& title, const std::vector<double>& values, bool logarithmic) {
  const Histogram h = histogram(values, logarithmic);
  if (h.counts.empty()) return {};
  const int most = *std::max_element(h.counts.begin(), h.counts.end());
  const double width = 320, height = 140, step = width / static_cast<double>(h.counts.size());
  char text[256];
  std::string svg =
      "<figure><figcaption>" + escaped(title) +
      "</figcaption><svg role=\"img\" width=\"375\" height=\"180\" viewBox=\"-25 -16 375 180\"><title>" +
      escaped(title) + "</title>";
  for (std::size_t i = 0; i < h.counts.size(); ++i) {
    const double tall = height * h.counts[i] / most, left = step * static_cast<double>(i);
    std::snprintf(
        text, sizeof text,
        "<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\"><title>%s to %s: %d</title></rect>",
        left + 1, height - tall, std::max(1., step - 2), tall, axis_label(h.limits[i]).c_str(),
        axis_label(h.limits[i + 1]).c_str(), h.counts[i]);
    svg += text;
    if (h.counts[i] > 0 && step > 14) {
      std::snprintf(text, sizeof text, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%d</text>",
                    left + step / 2, height - tall - 3, h.counts[i]);
      svg += text;
    }
  }
  const std::size_t every = std::max<std::size_t>(1, (h.limits.size() + 7) / 8);
  for (std::size_t i = 0; i < h.limits.size(); i += every) {
    std::snprintf(text, sizeof text, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%s</text>",
                  step * static_cast<double>(i), height + 14, axis_label(h.limits[i]).c_str());
    svg += text;
  }
  std::snprintf(text, sizeof text, "<line x1=\"0\" y1=\"%.0f\" x2=\"%.0f\" y2=\"%.0f\"/></svg></figure>\n",
                height, width, height);
  return svg + text;
}

template <class Value>
std::vector<double> all(const BatchSummary& s, Value&& value) {
  std::vector<double> values;
  for (const JournalEntry& e : s.models)
    if (const std::optional<double> x = value(e)) values.push_back(*x);
  return values;
}

std::string charts(const BatchSummary& s) {
  return "<div class=\"charts\">\n" +
         chart("Seconds a model", all(s, [](const auto& e) { return std::optional(e.seconds); }), true) +
         chart("Peak memory, MiB", all(s, [](const auto& e) { return std::optional(peak_mib(e)); }), true) +
         chart("Faces of the surface", all(s, [](const auto& e) { return std::optional<double>(e.faces); }),
               true) +
         chart("Tets", all(s, [](const auto& e) { return std::optional<double>(e.tets); }), true) +
         chart("Smallest dihedral angle of a mesh, degrees",
               all(s, [](const auto& e) { return e.dihedral_min; }), false) +
         "</div>\n";
}

std::string table(const BatchSummary& s) {
  std::string html = "<table><thead><tr>";
  const std::pair<const char*, bool> columns[] = {
      {"model", false},      {"status", false},        {"seconds", true},
      {"CPU seconds", true}, {"peak MiB", true},       {"faces", true},
      {"tets", true},        {"smallest angle", true}, {"message", false}};
  for (const auto& [name, is_number] : columns)
    html +=
        std::string("<th") + (is_number ? " class=\"number\"" : "") + "><button>" + name + "</button></th>";
  html += "</tr></thead><tbody>\n";
  const auto number = [](const std::optional<double>& x, int digits) {
    char text[64] = "";
    if (x) std::snprintf(text, sizeof text, "%.*f", digits, *x);
    return "<td class=\"number\">" + std::string(text) + "</td>";
  };
  for (const JournalEntry& e : s.models)
    html += "<tr><td>" + escaped(e.name) + "</td><td>" + escaped(e.status) + "</td>" + number(e.seconds, 3) +
            number(e.cpu_seconds, 3) + number(peak_mib(e), 1) + number(e.faces, 0) + number(e.tets, 0) +
            number(e.dihedral_min, 2) + "<td>" + escaped(has_mesh(e) ? "" : e.message) + "</td></tr>\n";
  return html + "</tbody></table>\n";
}

}  // namespace

std::string to_html(const BatchSummary& s) {
  std::map<std::string, std::int64_t> statuses;
  for (const JournalEntry& e : s.models) ++statuses[e.status];
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Overtet: a batch of " +
      std::to_string(s.models.size()) + " models</title><style>" + style + "</style></head><body>\n<h1>" +
      std::to_string(s.models.size()) + " models</h1>\n<p>" + escaped(listed(statuses)) + "</p>\n" +
      charts(s) + "<h2>Models</h2>\n<p>Press a heading to sort.</p>\n" + table(s);
  for (const std::string& note : s.notes) html += "<p>" + escaped(note) + "</p>\n";
  return html + "<script>" + script + "</script></body></html>\n";
}

}  // namespace overtet
