#include "lab/report/html_page.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <utility>

#include "lab/eval/format.h"

namespace diffsac {

extern const char kHtmlPageCss[];
extern const char kHtmlPageJs[];

namespace {

// Nothing from elsewhere, whatever a name in the data may try.
constexpr const char* kPolicy =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data: blob:";

constexpr std::size_t kMostColumnsWithIntervals = 7;

/// The number that a cell begins with: "+0.21 [...]", "1.5e-3", "85 %". Nothing for other texts, as for "3 views".
std::optional<double> CellNumber(const std::string& cell) {
  if (cell.empty() || std::isspace(static_cast<unsigned char>(cell.front()))) return std::nullopt;
  char* end = nullptr;
  const double value = std::strtod(cell.c_str(), &end);
  if (end == cell.c_str()) return std::nullopt;
  const std::string rest = end;
  const bool number = rest.empty() || rest.starts_with(" [") || rest.starts_with(kUnknown) || rest == " %";
  return number ? std::optional<double>(value) : std::nullopt;
}

/// A column of numbers: every cell is one, or unknown or empty.
bool IsNumeric(const Table& table, std::size_t column) {
  bool any = false;
  for (const Table::Row& row : table.rows) {
    const std::string& cell = row.cells[column];
    if (cell.empty() || cell == kUnknown) continue;
    if (!CellNumber(cell)) return false;
    any = true;
  }
  return any;
}

/// The interval in smaller type.
std::string CellMarkup(const std::string& cell) {
  const std::size_t interval = CellNumber(cell) && cell.ends_with("]") ? cell.find(" [") : std::string::npos;
  if (interval == std::string::npos) return HtmlText(cell);
  return HtmlText(cell.substr(0, interval)) + " <small>" + HtmlText(cell.substr(interval + 1)) + "</small>";
}

std::string RowMarkup(const Table::Row& row, const std::vector<bool>& numeric) {
  std::string html = "<tr>";
  for (std::size_t c = 0; c < row.cells.size(); ++c) {
    std::string classes = numeric[c] ? "number" : "";
    if (c < row.best.size() && row.best[c]) classes += classes.empty() ? "best" : " best";
    html += c == 0 ? "<th scope=\"row\"" : "<td";
    if (!classes.empty()) html += " class=\"" + classes + "\"";
    const auto value = numeric[c] ? CellNumber(row.cells[c]) : std::nullopt;
    if (value) html += " data-value=\"" + Format("%.7g", *value) + "\"";
    const bool interval = c < row.intervals.size() && !row.intervals[c].empty();
    html += ">" + CellMarkup(interval ? row.cells[c] + " " + row.intervals[c] : row.cells[c]) +
            (c == 0 ? "</th>" : "</td>");
  }
  return html + "</tr>\n";
}

std::string HeadMarkup(const Table& table, const std::vector<bool>& numeric) {
  std::string html = "<thead><tr>";
  for (std::size_t c = 0; c < table.columns.size(); ++c)
    html += std::string("<th scope=\"col\" aria-sort=\"none\"") + (numeric[c] ? " class=\"number\"" : "") +
            "><button type=\"button\">" + HtmlText(table.columns[c]) + "</button></th>";
  return html + "</tr></thead>\n";
}

/// In JSON a '<' can only stand in a text, where it may be written so; no text ends the element then.
std::string JsonInScript(const std::string& json) {
  std::string out;
  out.reserve(json.size());
  for (const char c : json) {
    if (c == '<')
      out += "\\u003c";
    else
      out += c;
  }
  return out;
}

std::string ScriptElement(const std::string& type, const std::string& id, const std::string& content) {
  return "<script type=\"" + type + "\" id=\"" + HtmlText(id) + "\">" + content + "</script>\n";
}

}  // namespace

std::string HtmlText(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
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
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string Base64(std::string_view bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k)
      group = (group << 8) | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) out += k <= count ? kDigits[(group >> (18 - 6 * k)) & 63] : '=';
  }
  return out;
}

HtmlPage::HtmlPage(std::string title) : title_(std::move(title)) {}

void HtmlPage::AddReload(int seconds) { reload_seconds_ = seconds; }

void HtmlPage::AddSubtitle(const std::string& text) { subtitles_ += "<p>" + HtmlText(text) + "</p>\n"; }

void HtmlPage::AddSection(const std::string& heading) {
  const std::string id = "section-" + std::to_string(++section_count_);
  sections_ += "<a href=\"#" + id + "\">" + HtmlText(heading) + "</a>\n";
  body_ += "<h2 id=\"" + id + "\">" + HtmlText(heading) + "</h2>\n";
}

void HtmlPage::AddText(const std::string& text) { body_ += "<p>" + HtmlText(text) + "</p>\n"; }

void HtmlPage::AddWarning(const std::string& text) {
  body_ += "<p class=\"warning\" role=\"note\">" + HtmlText(text) + "</p>\n";
}

void HtmlPage::AddTable(const Table& table, const std::string& note) {
  std::vector<bool> numeric;
  for (std::size_t c = 0; c < table.columns.size(); ++c) numeric.push_back(IsNumeric(table, c));
  // Intervals stand below their values where they would make the table too wide.
  const bool wide = table.columns.size() > kMostColumnsWithIntervals;
  body_ += std::string("<div class=\"table\"><table class=\"sortable") + (wide ? " wide" : "") + "\">\n";
  if (!table.heading.empty()) body_ += "<caption>" + HtmlText(table.heading) + "</caption>\n";
  body_ += HeadMarkup(table, numeric);
  for (const bool paper : {false, true}) {
    std::string rows;
    for (const Table::Row& row : table.rows)
      if (row.from_paper == paper) rows += RowMarkup(row, numeric);
    if (!rows.empty()) body_ += std::string(paper ? "<tbody class=\"paper\">" : "<tbody>") + "\n" + rows + "</tbody>\n";
  }
  body_ += "</table></div>\n";
  if (!note.empty()) body_ += "<p class=\"note\">" + HtmlText(note) + "</p>\n";
}

void HtmlPage::AddPicture(std::string_view png, const std::string& caption) {
  const std::string text = HtmlText(caption);
  body_ += "<figure><img alt=\"" + text + "\" src=\"data:image/png;base64," + Base64(png) + "\"><figcaption>" + text +
           "</figcaption></figure>\n";
}

void HtmlPage::AddMarkup(const std::string& html) { body_ += html; }

void HtmlPage::AddJson(const std::string& id, const std::string& json) {
  data_ += ScriptElement("application/json", id, JsonInScript(json));
}

void HtmlPage::AddBytes(const std::string& id, std::string_view bytes) {
  data_ += ScriptElement("application/octet-stream", id, Base64(bytes));
}

void HtmlPage::AddScript(std::string_view script) {
  scripts_ += "<script>\n";
  scripts_ += script;
  scripts_ += "</script>\n";
}

std::string HtmlPage::Text() const {
  std::string html;
  html.reserve(body_.size() + data_.size() + scripts_.size() + (1 << 16));
  html += "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
  html += "<meta http-equiv=\"Content-Security-Policy\" content=\"" + std::string(kPolicy) + "\">\n";
  if (reload_seconds_ > 0)
    html += "<meta http-equiv=\"refresh\" content=\"" + std::to_string(reload_seconds_) + "\">\n";
  html += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
  html += "<title>" + HtmlText(title_) + "</title>\n<style>\n" + kHtmlPageCss + "</style>\n</head>\n<body>\n";
  html += "<header><h1>" + HtmlText(title_) + "</h1>\n" + subtitles_;
  if (section_count_ > 1) html += "<nav aria-label=\"Sections\">" + sections_ + "</nav>\n";
  html += "</header>\n<main>\n";
  html += body_;
  html += "</main>\n";
  html += data_;
  html += std::string("<script>\n") + kHtmlPageJs + "</script>\n";
  html += scripts_;
  return html + "</body>\n</html>\n";
}

}  // namespace diffsac
