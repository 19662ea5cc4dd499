#include "lab/report/doc_figures.h"

#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <utility>

#include "diffsac/core/status.h"
#include "lab/report/markdown_report.h"

namespace diffsac {
namespace {

constexpr std::string_view kEnd = " -->";

enum class Mark { kFigure, kClaim, kEvidence, kTable };

// The kinds of marks: what begins one, and what ends what it holds.
struct MarkKind {
  std::string_view begin, end;
  Mark mark;
};
constexpr MarkKind kKinds[] = {{"<!-- figure: ", "<!-- / -->", Mark::kFigure},
                               {"<!-- claim: ", "<!-- / -->", Mark::kClaim},
                               {"<!-- evidence: ", "<!-- /evidence -->", Mark::kEvidence},
                               {"<!-- figures: ", "<!-- /figures -->", Mark::kTable}};

constexpr const char* kSections[] = {"figures", "claims", "tables"};

// "+0.153 [+0.099, +0.210]": 1 where the interval is above zero, −1 where it is below, else 0. Nothing for other texts.
std::optional<int> SideOf(const std::string& text) {
  double mean = 0.0, low = 0.0, high = 0.0;
  if (std::sscanf(text.c_str(), "%lf [%lf, %lf]", &mean, &low, &high) != 3) return std::nullopt;
  return low > 0.0 ? 1 : high < 0.0 ? -1 : 0;
}

// As documents write numbers: ".283", "+.118 [.069, .172]".
std::string WithoutLeadingZero(const std::string& text) {
  std::string shorter;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool leading = text[i] == '0' && i + 1 < text.size() && text[i + 1] == '.';
    const bool inside = i > 0 && (std::isdigit(static_cast<unsigned char>(text[i - 1])) != 0 || text[i - 1] == '.');
    if (!leading || inside) shorter += text[i];
  }
  return shorter;
}

std::optional<double> NumberOf(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  return end == text.c_str() ? std::nullopt : std::optional(value);
}

// Bold where it is the best of its column; values that print the same are equally good.
void MarkBestOf(std::size_t column, bool higher, Table* table) {
  std::optional<double> best;
  for (const Table::Row& row : table->rows) {
    const auto value = NumberOf(row.cells[column]);
    if (value && (!best || (higher ? *value > *best : *value < *best))) best = value;
  }
  for (Table::Row& row : table->rows) row.best[column] = best.has_value() && NumberOf(row.cells[column]) == best;
}

}  // namespace

DocFigures::DocFigures(Config definitions, std::string pages)
    : definitions_(std::move(definitions)), pages_(std::move(pages)) {
  for (const std::string section : kSections)
    for (const std::string& name : definitions_.Sub(section).Keys()) used_[section + "." + name] = false;
}

std::string DocFigures::Fill(const std::string& document) {
  std::string filled;
  std::size_t at = 0;
  while (true) {
    const MarkKind* kind = nullptr;
    std::size_t begin = std::string::npos;
    for (const MarkKind& one : kKinds) {
      const std::size_t found = document.find(one.begin, at);
      if (found < begin) begin = found, kind = &one;
    }
    if (kind == nullptr) return filled + document.substr(at);
    const std::size_t name_at = begin + kind->begin.size(), name_end = document.find(kEnd, name_at);
    const std::size_t end = document.find(kind->end, name_at);
    if (name_end == std::string::npos || end == std::string::npos || end < name_end)
      throw Error("the mark '" + document.substr(begin, 60) + "' is not closed by '" + std::string(kind->end) + "'");
    const std::string name = document.substr(name_at, name_end - name_at);
    filled += document.substr(at, name_end + kEnd.size() - at);
    if (kind->mark == Mark::kFigure) filled += Figure(name);
    if (kind->mark == Mark::kClaim) {
      const std::string answer = Claim(name),
                        before = document.substr(name_end + kEnd.size(), end - name_end - kEnd.size());
      if (answer != before) changed_.push_back("claim " + name + ": it said '" + before + "', now '" + answer + "'");
      filled += answer;
    }
    if (kind->mark == Mark::kEvidence) filled += "\n" + Evidence(name);
    if (kind->mark == Mark::kTable) filled += "\n" + Table(name);
    at = end;
  }
}

std::vector<std::string> DocFigures::Unused() const {
  std::vector<std::string> names;
  for (const auto& [name, used] : used_)
    if (!used) names.push_back(name);
  return names;
}

std::string DocFigures::Figure(const std::string& name) {
  const Config place = definitions_.Sub("figures." + name);
  if (place.Keys().empty()) throw Error(definitions_.Where() + ": no figures." + name);
  used_["figures." + name] = true;
  return Shown(place);
}

std::vector<DocFigures::Difference> DocFigures::DifferencesOf(const std::string& name) {
  const Config claim = definitions_.Sub("claims." + name);
  std::vector<Difference> differences;
  for (const Config& place : claim.Sequence("differences")) {
    const std::string value = Value(place);
    const std::optional<int> side = SideOf(value);
    if (!side) throw Error(place.Where() + ": '" + value + "' is no difference with its interval");
    const bool swapped = place.Has("swapped") && place.Text("swapped") == "yes";
    differences.push_back({place, value, swapped ? -*side : *side, swapped});
  }
  if (differences.empty()) throw Error(definitions_.Where() + ": no claims." + name + ".differences");
  used_["claims." + name] = true;
  return differences;
}

std::string DocFigures::Claim(const std::string& name) {
  const Config claim = definitions_.Sub("claims." + name);
  const std::vector<Difference> differences = DifferencesOf(name);
  std::size_t above = 0, below = 0;
  for (const Difference& difference : differences) {
    above += difference.side > 0;
    below += difference.side < 0;
  }
  if (above == differences.size()) return "yes";
  const bool every = claim.Has("every") && claim.Text("every") == "yes";
  if (above > 0 && !every) return "in part";
  return below > 0 ? "no" : "open";
}

std::string DocFigures::Evidence(const std::string& name) {
  diffsac::Table table;
  table.columns = {"A − B", "page", "of", "difference and 95 % interval", "trainings"};
  for (const auto& [place, value, side, swapped] : DifferencesOf(name)) {
    const std::string page_name = place.Text("page");
    const ResultsPage& page = Page(page_name);
    const std::size_t trainings = page.Trainings();
    const std::string& pair = page.RowName(place.Text("table"), place.Text("row"));
    table.rows.push_back(
        {{pair + (swapped ? " (below zero speaks for the claim)" : ""), "[" + page_name + "](" + page_name + ".md)",
          place.Text("column"), value, trainings == 0 ? "" : std::to_string(trainings)},
         {false, false, false, side != 0, false}});
  }
  return MarkdownTable(table);
}

std::string DocFigures::Table(const std::string& name) {
  const Config definition = definitions_.Sub("tables." + name);
  if (definition.Keys().empty()) throw Error(definitions_.Where() + ": no tables." + name);
  used_["tables." + name] = true;
  diffsac::Table table;
  table.columns = {definition.Text("first")};
  const std::vector<Config> columns = definition.Sequence("columns");
  for (const Config& column : columns) table.columns.push_back(column.Text("title"));
  for (const Config& row : definition.Sequence("rows")) {
    diffsac::Table::Row cells{{row.Text("title")}, std::vector<bool>(table.columns.size(), false)};
    for (const Config& given : row.Sequence("cells")) cells.cells.push_back(given.Text());
    if (!row.Has("cells"))
      for (const Config& column : columns) cells.cells.push_back(Shown(column.MergedWith(row)));
    if (cells.cells.size() != table.columns.size())
      throw Error(row.Where("cells") + ": the table has " + std::to_string(columns.size()) + " columns");
    table.rows.push_back(std::move(cells));
  }
  if (definition.Has("best"))
    for (std::size_t c = 1; c < table.columns.size(); ++c) MarkBestOf(c, definition.Text("best") == "higher", &table);
  return MarkdownTable(table);
}

std::string DocFigures::Shown(const Config& place) {
  const std::string value = Value(place);
  const bool whole = !place.Has("interval") || place.Text("interval") != "no";
  return whole ? value : value.substr(0, value.find(" ["));
}

std::string DocFigures::Value(const Config& place) {
  std::vector<std::string> columns;
  for (const Config& one : place.Sequence("columns")) columns.push_back(one.Text());
  if (columns.empty()) columns.push_back(place.Text("column"));
  const ResultsPage& page = Page(place.Text("page"));
  std::string text;
  for (const std::string& column : columns) {
    try {
      text += (text.empty() ? "" : "/") + WithoutLeadingZero(page.Cell(place.Text("table"), place.Text("row"), column));
    } catch (const Error& error) {
      throw Error(place.Where() + ": " + error.what());
    }
  }
  return text;
}

const ResultsPage& DocFigures::Page(const std::string& name) {
  const auto found = read_.find(name);
  return found != read_.end() ? found->second
                              : read_.emplace(name, ReadResultsPage(pages_ + "/" + name + ".md")).first->second;
}

}  // namespace diffsac
