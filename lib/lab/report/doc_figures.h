#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "diffsac/core/config.h"
#include "lab/report/page_tables.h"

namespace diffsac {

/// Fills the figures of documents from the pages of results, so that no figure is typed. A document has marks
///
///     <!-- figure: NAME -->.283<!-- / -->
///     <!-- claim: NAME -->in part<!-- / -->
///     <!-- evidence: NAME -->
///     | ... the claim's differences, as a table ... |
///     <!-- /evidence -->
///     <!-- figures: NAME -->
///     | ... a table ... |
///     <!-- /figures -->
///
/// and docs/figures.yaml says what stands between them:
///
///     figures:
///       NAME: {page: hard_fundamental, table: mAA@10deg by share, row: "learned PROSAC, until", column: "< 0.1"}
///     claims:
///       NAME:
///         differences:
///           - {page: hard_essential, table: differences in mAA by share, row: learned − PROSAC, column: "< 0.1"}
///     tables:
///       NAME:
///         first: share of right matches
///         columns:
///           - {title: "F: < .1", page: hard_fundamental, table: mAA@10deg by share, column: "< 0.1"}
///         rows:
///           - {title: ours, row: "learned PROSAC, until"}
///           - {title: published elsewhere, cells: [".50"]}
///     older_pages:   # --check-pages passes over them.
///       NAME: why it was not made again
///
/// A cell of a table is where its column and its row say together: either may name page, table, row and column, and the
/// row's word counts.
///
/// `columns: [A, B]` in the place of `column` joins two values by a slash, `interval: no` leaves out a figure's
/// interval. `cells` gives a row's values themselves.
///
/// A claim says that A is better than B, by differences A − B with their intervals: "yes" where each interval is above
/// zero, "in part" where some are, else "no" where one is below zero, and "open" where each holds it. With `every: yes`
/// there is no "in part"; `swapped: yes` is for a difference that the page has as B − A.
///
/// `best: higher` or `lower` prints the best value of each column of a table bold. Table, row and column are whole
/// names, or beginnings that only one has.
class DocFigures {
 public:
  /// `pages`: the folder of the pages.
  DocFigures(Config definitions, std::string pages);

  /// The document with every mark filled. Throws Error naming the mark, and the definition's line, where something is
  /// not there.
  std::string Fill(const std::string& document);

  /// Of the claims filled so far those that said something else, a line each: prose about them may be wrong now.
  const std::vector<std::string>& Changed() const { return changed_; }

  /// The names of all definitions that no document has asked for.
  std::vector<std::string> Unused() const;

 private:
  std::string Figure(const std::string& name);
  /// A difference of a claim: where it stands, its text, and 1 or −1 where its interval is on the side for or against
  /// the claim.
  struct Difference {
    Config place;
    std::string text;
    int side = 0;
    bool swapped = false;
  };
  std::vector<Difference> DifferencesOf(const std::string& name);
  std::string Claim(const std::string& name);
  std::string Evidence(const std::string& name);
  std::string Table(const std::string& name);
  std::string Value(const Config& place);
  /// The value, without its interval where the place says so.
  std::string Shown(const Config& place);
  const ResultsPage& Page(const std::string& name);

  Config definitions_;
  std::string pages_;
  std::map<std::string, ResultsPage> read_;
  std::map<std::string, bool> used_;
  std::vector<std::string> changed_;
};

}  // namespace diffsac
