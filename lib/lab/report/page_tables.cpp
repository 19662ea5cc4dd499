#include "lab/report/page_tables.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "diffsac/core/files.h"
#include "diffsac/core/status.h"
#include "lab/report/missing_networks.h"

namespace diffsac {
namespace {

constexpr std::string_view kRevision = "- git revision: ", kNetwork = "- network: ";

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

bool IsTime(const PageTable& table, std::size_t column) {
  return table.columns[column] == "ms" || table.heading.find("milliseconds") != std::string::npos;
}

// The numbers in a cell, with the place of their last digit.
struct Number {
  double value = 0.0, last_digit = 1.0;
};

std::vector<Number> NumbersIn(const std::string& cell) {
  static const std::regex kNumber("[-+]?[0-9]*\\.?[0-9]+");
  std::vector<Number> numbers;
  for (std::sregex_iterator found(cell.begin(), cell.end(), kNumber), end; found != end; ++found) {
    const std::string text = found->str();
    const std::size_t point = text.find('.');
    const double digits = point == std::string::npos ? 0.0 : static_cast<double>(text.size() - point - 1);
    numbers.push_back({std::stod(text), std::pow(10.0, -digits)});
  }
  return numbers;
}

bool SameButForRounding(const std::string& a, const std::string& b) {
  if (a == b) return true;
  const std::vector<Number> of_a = NumbersIn(a), of_b = NumbersIn(b);
  return !of_a.empty() &&
         std::equal(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(), [](const Number& x, const Number& y) {
           return std::abs(x.value - y.value) < 1.5 * std::max(x.last_digit, y.last_digit);
         });
}

// The item of this name before which `before` others have it; null where there are not so many.
template <class Item, class NameOf>
const Item* FindNamed(const std::vector<Item>& items, const std::string& name, std::size_t before,
                      const NameOf& name_of) {
  for (const Item& item : items)
    if (name_of(item) == name && before-- == 0) return &item;
  return nullptr;
}

const std::string& HeadingOf(const PageTable& table) { return table.heading; }
const std::string& FirstCell(const std::vector<std::string>& row) { return row.front(); }

// Names that one of two lists has alone.
void AddMissing(const std::vector<std::string>& a, const std::vector<std::string>& b, const std::string& where,
                std::vector<std::string>* differences) {
  const auto only = [&](const auto& names, const auto& others, const char* which) {
    for (const std::string& name : names)
      if (std::find(others.begin(), others.end(), name) == others.end())
        differences->push_back(where + ": " + which + " has '" + name + "'");
  };
  only(a, b, "only the page");
  only(b, a, "only the new one");
}

void AddCellDifferences(const PageTable& table, const PageTable& again, std::vector<std::string>* differences) {
  AddMissing(table.columns, again.columns, table.heading, differences);
  AddMissing(FirstCells(table), FirstCells(again), table.heading, differences);
  std::map<std::string, std::size_t> met;  // Several rows may have one name: the first is the other's first.
  for (const auto& row : table.rows) {
    const std::vector<std::string>* other = FindNamed(again.rows, row.front(), met[row.front()]++, FirstCell);
    for (std::size_t c = 1; other != nullptr && c < table.columns.size(); ++c) {
      const auto at = std::find(again.columns.begin(), again.columns.end(), table.columns[c]);
      if (at == again.columns.end() || IsTime(table, c)) continue;
      const std::string& value = (*other)[static_cast<std::size_t>(at - again.columns.begin())];
      if (!SameButForRounding(row[c], value))
        differences->push_back(table.heading + ": " + row.front() + ", " + table.columns[c] + ": " + row[c] + ", now " +
                               value);
    }
  }
}

}  // namespace

std::vector<std::string> PageDifferences(const ResultsPage& page, const ResultsPage& again) {
  const auto headings = [](const ResultsPage& one) {
    std::vector<std::string> names;
    for (const PageTable& table : one.tables) names.push_back(table.heading);
    return names;
  };
  std::vector<std::string> differences;
  AddMissing(headings(page), headings(again), page.path, &differences);
  std::map<std::string, std::size_t> met;  // A page about several runs has a table of one heading for each.
  for (const PageTable& table : page.tables)
    if (const PageTable* other = FindNamed(again.tables, table.heading, met[table.heading]++, HeadingOf))
      AddCellDifferences(table, *other, &differences);
  return differences;
}

std::vector<std::string> TableCells(const std::string& line) {
  if (line.size() < 2 || line.front() != '|' || line.back() != '|') return {};
  std::vector<std::string> cells;
  std::istringstream in(line.substr(1));
  for (std::string cell; std::getline(in, cell, '|');) cells.push_back(WithoutBold(Trimmed(cell)));
  return cells;
}

namespace {

const PageTable& TableNamed(const ResultsPage& page, const std::string& name) {
  std::vector<std::string> headings;
  for (const PageTable& one : page.tables) headings.push_back(one.heading);
  return page.tables[FindName(headings, name, page.path)];
}

std::string PlaceOf(const ResultsPage& page, const PageTable& table) {
  return page.path + ", table '" + table.heading + "'";
}

}  // namespace

const std::string& ResultsPage::Cell(const std::string& table, const std::string& row,
                                     const std::string& column) const {
  const PageTable& found = TableNamed(*this, table);
  const std::string where = PlaceOf(*this, found);
  const std::size_t r = FindName(FirstCells(found), row, where);
  return found.rows[r][FindName(found.columns, column, where)];
}

const std::string& ResultsPage::RowName(const std::string& table, const std::string& row) const {
  const PageTable& found = TableNamed(*this, table);
  return found.rows[FindName(FirstCells(found), row, PlaceOf(*this, found))].front();
}

std::size_t ResultsPage::Trainings() const {
  std::set<std::string> seeds;
  for (const std::string& network : networks) {
    const std::size_t seed = network.find(kTrainingSeed);
    seeds.insert(seed == std::string::npos ? "" : network.substr(seed, network.find('/', seed) - seed));
  }
  return std::max(seeds.size() - seeds.count(""), std::size_t{networks.empty() ? 0U : 1U});
}

ResultsPage ReadResultsPage(const std::string& path) {
  ResultsPage page{path, {}, {}, {}};
  std::istringstream in(ReadFile(path));
  std::string heading;
  bool inside = false;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with(kRevision)) page.revision = line.substr(kRevision.size());
    if (line.starts_with(kNetwork))
      page.networks.push_back(line.substr(kNetwork.size(), line.find(',') - kNetwork.size()));
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
