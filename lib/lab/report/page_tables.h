#pragma once

#include <string>
#include <vector>

namespace diffsac {

/// A table of a page of results (docs/results/NAME.md), as its text has it, without bold type.
struct PageTable {
  std::string heading;
  std::vector<std::string> columns;            ///< The first is that of the rows' names.
  std::vector<std::vector<std::string>> rows;  ///< As many cells as columns; the first is the row's name.
};

/// A page of results, read back.
struct ResultsPage {
  std::string path;
  std::vector<PageTable> tables;
  std::string revision;               ///< Empty where the page names none.
  std::vector<std::string> networks;  ///< Files of the networks that its rows used.

  /// A cell by its table, row and column. Each is the whole name, or a beginning that only one of them has. Throws
  /// Error naming the page and what it has instead.
  const std::string& Cell(const std::string& table, const std::string& row, const std::string& column) const;

  /// The whole name of a row, as Cell finds it.
  const std::string& RowName(const std::string& table, const std::string& row) const;

  /// How many seeds its networks were trained with: those of networks named "..._seed_N"; 1 of others, 0 without any.
  std::size_t Trainings() const;
};

/// Throws Error where there is no such file or a row has more or fewer cells than its table has columns.
ResultsPage ReadResultsPage(const std::string& path);

/// What differs between a page and the same page made again, a line each: tables, rows and columns that one has alone,
/// and values that differ by more than one in their last digit, which another machine's rounding may do. Times are
/// passed over.
std::vector<std::string> PageDifferences(const ResultsPage& page, const ResultsPage& again);

/// The cells of one line of a Markdown table, without spaces around them and without bold type; empty for other lines.
std::vector<std::string> TableCells(const std::string& line);

}  // namespace diffsac
