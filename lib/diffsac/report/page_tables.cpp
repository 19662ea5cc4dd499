#include "diffsac/report/page_tables.h"

#include <sstream>

#include "diffsac/core/files.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

constexpr std::string_view kRevision = "- git revision: ";

std::string Trimmed(std::string text) {
  const std::size_t first = text.find_first_not_of(' ');
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

std::string WithoutBold(const std::string& cell) {
  const bool bold = cell.size() > 4 && cell.starts_with("**") && cell.ends_with("**");
  return bold ? cell.substr(2, cell.size() - 4) : cell;
}

bool IsRule(const std::vector<std::string>& cells) {
  return !cells.empty() && cells.front().find_first_not_of("-:") == std::string::npos && !cells.front().empty();
}

// The one name that `name` is, or begins; else an error that lists what there is.
std::size_t FindName(const std::vector<std::string>& names, const std::string& name, const std::string& where) {
  std::vector<std::size_t> beginnings;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name) return i;
    if (names[i].starts_with(name)) beginnings.push_back(i);
  }
  if (beginnings.size() == 1) return beginnings.front();
  std::string known;
  for (const std::string& one : names) known += (known.empty() ? "" : "; ") + one;
  throw Error(where + (beginnings.empty() ? " has no '" : " has several that begin with '") + name +
              "', but: " + known);
}

std::vector<std::string> FirstCells(const PageTable& table) {
  std::vector<std::string> names;
  for (const auto& row : table.rows) names.push_back(row.front());
  return names;
}

}  // namespace

std::vector<std::string> TableCells(const std::string& line) {
  if (line.size() < 2 || line.front() != '|' || line.back() != '|') return {};
  std::vector<std::string> cells;
  std::istringstream in(line.substr(1));
  for (std::string cell; std::getline(in, cell, '|');) cells.push_back(WithoutBold(Trimmed(cell)));
  return cells;
}

const std::string& ResultsPage::Cell(const std::string& table, const std::string& row,
                                     const std::string& column) const {
  std::vector<std::string> headings;
  for (const PageTable& one : tables) headings.push_back(one.heading);
  const PageTable& found = tables[FindName(headings, table, path)];
  const std::string where = path + ", table '" + found.heading + "'";
  const std::size_t r = FindName(FirstCells(found), row, where);
  return found.rows[r][FindName(found.columns, column, where)];
}

ResultsPage ReadResultsPage(const std::string& path) {
  ResultsPage page{path, {}, {}};
  std::istringstream in(ReadFile(path));
  std::string heading;
  bool inside = false;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with(kRevision)) page.revision = line.substr(kRevision.size());
    if (line.starts_with("#")) heading = line.substr(line.find_first_not_of("# "));
    const std::vector<std::string> cells = TableCells(line);
    if (cells.empty()) {
      inside = false;
    } else if (!inside) {
      page.tables.push_back({heading, cells, {}});
      inside = true;
    } else if (!IsRule(cells)) {
      PageTable& table = page.tables.back();
      if (cells.size() != table.columns.size())
        throw Error(path + ": a row of '" + heading + "' has " + std::to_string(cells.size()) + " cells, its table " +
                    std::to_string(table.columns.size()) + " columns: " + line);
      table.rows.push_back(cells);
    }
  }
  return page;
}

}  // namespace diffsac
