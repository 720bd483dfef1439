#include "gradus/io/html_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "markup.hpp"

namespace gradus {
namespace {

using markup::escape;

constexpr const char* style_sheet = R"(
:root { color-scheme: light dark; --line: #d8dde5; --soft: #f4f6f9; --ink: #1c2330; --dim: #5c677a; --page: #fff;
  --bar: #4878a8; --good: #1f7a4d; --bad: #b5392b; }
@media (prefers-color-scheme: dark) {
  :root { --line: #343b47; --soft: #20252e; --ink: #e4e8ee; --dim: #98a3b5; --page: #171a20;
  --bar: #6f9fd0; --good: #5cc08d; --bad: #ef8372; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 76rem; padding: 2rem 1.5rem 4rem; background: var(--page);
  color: var(--ink); font: 16px/1.5 system-ui, sans-serif; }
h1 { margin: 0; font-size: 1.9rem; line-height: 1.2; }
h2 { margin: 2.4rem 0 .8rem; padding-bottom: .25rem; border-bottom: 1px solid var(--line); font-size: 1.25rem; }
.sub, caption, figcaption { color: var(--dim); }
.scroll { overflow-x: auto; }
table { margin: .8rem 0; border-collapse: collapse; font-variant-numeric: tabular-nums; }
caption { padding-bottom: .3rem; text-align: left; }
th, td { padding: .3rem .9rem .3rem .5rem; border-bottom: 1px solid var(--line); text-align: right; }
th:first-child, td:first-child { text-align: left; }
thead th { background: var(--soft); font-weight: 600; }
td.bar { min-width: 9rem; text-align: left; }
.bar i { display: block; height: .7rem; border-radius: 2px; background: var(--bar); }
.good { color: var(--good); font-weight: 600; }
.bad { color: var(--bad); font-weight: 600; }
figure { margin: 1rem 0; }
figure img { max-width: 100%; height: auto; border: 1px solid var(--line); border-radius: 4px; background: #fff; }
.row { display: flex; flex-wrap: wrap; gap: 1rem; }
.row > * { flex: 1 1 24rem; min-width: 0; }
svg { max-width: 100%; height: auto; font-family: system-ui, sans-serif; }
)";

/// An element with escaped text inside.
std::string element(const char* name, const std::string& text) {
    return fmt::format("<{0}>{1}</{0}>", name, escape(text));
}

std::string open_table(const std::string& caption, const std::vector<std::string>& header) {
    std::string html = "<div class=\"scroll\"><table>\n";
    if (!caption.empty()) html += element("caption", caption) + "\n";
    html += "<thead><tr>";
    for (const std::string& cell : header) html += "<th scope=\"col\">" + escape(cell) + "</th>";
    return html + "</tr></thead>\n<tbody>\n";
}
constexpr const char* close_table = "</tbody></table></div>\n";

std::string bar_cell(double share) {
    return fmt::format("<td class=\"bar\"><i style=\"width:{:.1f}%\"></i></td>", 100 * std::clamp(share, 0.0, 1.0));
}

std::string mark_cell(const std::optional<bool>& met) {
    if (!met) return "<td></td>";
    return *met ? "<td class=\"good\">&#10003; met</td>" : "<td class=\"bad\">&#10007; missed</td>";
}

std::string seconds(double s) { return s < 1 ? fmt::format("{:.0f} ms", 1000 * s) : fmt::format("{:.2f} s", s); }

}  // namespace

HtmlReport::HtmlReport(const std::string& title, const std::string& subtitle) : title_(title), subtitle_(subtitle) {}

void HtmlReport::section(const std::string& title) {
    if (in_section_) body_ += "</section>\n";
    body_ += "<section>\n" + element("h2", title) + "\n";
    in_section_ = true;
}

void HtmlReport::text(const std::string& paragraph) { body_ += element("p", paragraph) + "\n"; }

void HtmlReport::table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows,
                       const std::string& caption) {
    std::string html = open_table(caption, header);
    for (const std::vector<std::string>& row : rows) {
        if (row.size() > header.size())
            throw std::invalid_argument("HtmlReport::table: a row is longer than the header");
        html += "<tr>";
        for (std::size_t i = 0; i < header.size(); ++i) html += i < row.size() ? element("td", row[i]) : "<td></td>";
        html += "</tr>\n";
    }
    body_ += html + close_table;
}

void HtmlReport::checks(std::span<const Check> rows, const std::string& caption) {
    const bool limits = std::ranges::any_of(rows, [](const Check& row) { return !row.limit.empty(); });
    const bool marks = std::ranges::any_of(rows, [](const Check& row) { return row.met.has_value(); });
    const bool bars = std::ranges::any_of(rows, [](const Check& row) { return row.bar.has_value(); });
    std::vector<std::string> header{"", "value"};
    if (limits) header.emplace_back("limit");
    if (marks) header.emplace_back("");
    if (bars) header.emplace_back("");
    std::string html = open_table(caption, header);
    for (const Check& row : rows) {
        html += "<tr>" + element("td", row.name) + element("td", row.value);
        if (limits) html += element("td", row.limit);
        if (marks) html += mark_cell(row.met);
        if (bars) html += row.bar ? bar_cell(*row.bar) : "<td></td>";
        html += "</tr>\n";
    }
    body_ += html + close_table;
}

void HtmlReport::stages(std::span<const Stage> stages) {
    double total = 0;
    for (const Stage& stage : stages) total += stage.seconds;
    std::string html = open_table("", {"stage", "time", ""});
    for (const Stage& stage : stages)
        html += "<tr>" + element("td", stage.name) + element("td", seconds(stage.seconds)) +
                bar_cell(total > 0 ? stage.seconds / total : 0) + "</tr>\n";
    html += "<tr>" + element("th", "total") + element("th", seconds(total)) + "<td></td></tr>\n";
    body_ += html + close_table;
}

void HtmlReport::histogram(const HistogramData& histogram, const HistogramStyle& style) {
    body_ += "<figure>\n" + histogram_svg(histogram, style) + "</figure>\n";
}

void HtmlReport::histograms(const HistogramData& left, HistogramStyle left_style, const HistogramData& right,
                            HistogramStyle right_style) {
    share_axis(left, left_style, right, right_style);
    body_ += "<figure class=\"row\">\n<div>" + histogram_svg(left, left_style) + "</div>\n<div>" +
             histogram_svg(right, right_style) + "</div>\n</figure>\n";
}

void HtmlReport::picture(const std::string& caption, const Image& image) { picture(caption, encode_png(image)); }

void HtmlReport::picture(const std::string& caption, std::string_view png) {
    body_ += "<figure><img alt=\"" + escape(caption) + "\" src=\"data:image/png;base64," + markup::base64(png) + "\">";
    if (!caption.empty()) body_ += element("figcaption", caption);
    body_ += "</figure>\n";
}

std::string HtmlReport::html() const {
    std::string page = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
    page += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n" + element("title", title_) +
            "\n<style>";
    page += std::string(style_sheet) + "</style>\n</head>\n<body>\n<header>" + element("h1", title_);
    if (!subtitle_.empty()) page += "<p class=\"sub\">" + escape(subtitle_) + "</p>";
    page += "</header>\n" + body_;
    if (in_section_) page += "</section>\n";
    return page + "</body>\n</html>\n";
}

}  // namespace gradus
