#include "lab/report/words.h"

#include <algorithm>

namespace diffsac {
namespace {

struct Word {
  const char* occurs;  ///< In a heading or a column.
  const char* term;
  const char* meaning;
};

constexpr Word kWords[] = {
    {"mAA@", "mAA@c",
     "Mean average accuracy, 0 to 1: the share of errors up to c/10, 2c/10, ... c, averaged over these ten. 1: all are "
     "within a tenth of c. @0.5deg: c is half a degree."},
    {"AUC@", "AUC@c", "Area under the curve of the share of errors below a limit, for limits up to c; 0 to 1."},
    {"median error", "median error",
     "Half of the problems have a smaller error. Without a model it is the worst there is."},
    {"median degrees", "median degrees", "The same for rotation or translation alone."},
    {"max(R, t)", "max(R, t)", "The error of a pose: the larger of its two angles, of rotation and of translation."},
    {"failures", "failures", "Problems without a model or a pose. They count with the worst error."},
    {"number of inliers", "inliers",
     "Points within the inlier threshold of the model. Without a truth that is all that is known."},
    {"all-inlier sets", "all-inlier sets",
     "Minimal sets, the few points a model is solved from, that hold true inliers alone."},
    {"misclassification", "misclassification",
     "Per cent of the points with a wrong label, the found structures matched to the true ones."},
    {"recall", "recall", "Share of the true structures that were found."},
    {"hypotheses", "hypotheses", "Models solved or scored: what an estimate costs, whatever the machine."},
    {"ms", "ms", "Milliseconds an estimate takes on this machine."},
    {"draws", "draws", "Minimal sets drawn."},
    {"training problems", "training problems",
     "Problems that the network was trained on; of a run of: those of the whole training."},
    {"minus", "A minus B", "The difference on the same problems. In bold: its interval leaves zero out."},
    {"normal x", "normal, d", "The line or plane n · x + d = 0; n has length 1, d is in the unit of the points."},
    {"noise", "noise", "Standard deviation of the inliers' distances, in the unit of the points."},
};

bool Occurs(const Table& table, const std::string& text) {
  if (table.heading.find(text) != std::string::npos) return true;
  return std::any_of(table.columns.begin(), table.columns.end(), [&](const std::string& column) {
    return text == "ms" ? column == "ms" : column.find(text) != std::string::npos;
  });
}

bool Any(const std::vector<Table>& tables, bool (*holds)(const Table::Row&)) {
  return std::any_of(tables.begin(), tables.end(),
                     [&](const Table& table) { return std::any_of(table.rows.begin(), table.rows.end(), holds); });
}

bool HasBest(const Table::Row& row) { return std::find(row.best.begin(), row.best.end(), true) != row.best.end(); }

bool HasInterval(const Table::Row& row) {
  return std::any_of(row.intervals.begin(), row.intervals.end(), [](const std::string& text) { return !text.empty(); });
}

bool HasOracle(const Table::Row& row) { return row.cells.front().find("racle") != std::string::npos; }

bool IsPaper(const Table::Row& row) { return row.from_paper; }

}  // namespace

std::vector<std::pair<std::string, std::string>> WordsOf(const std::vector<Table>& tables) {
  std::vector<std::pair<std::string, std::string>> words;
  for (const Word& word : kWords)
    if (std::any_of(tables.begin(), tables.end(), [&](const Table& table) { return Occurs(table, word.occurs); }))
      words.emplace_back(word.term, word.meaning);
  if (Any(tables, HasInterval))
    words.emplace_back("[0.45, 0.57]", "With other problems of the same kind the value lies there in 95 of 100 cases.");
  if (Any(tables, HasBest)) words.emplace_back("bold", "The best of its column; those that print the same are equal.");
  if (Any(tables, HasOracle))
    words.emplace_back("oracle",
                       "Told which points are inliers: the best that any method can do. It does not compete.");
  if (Any(tables, IsPaper)) words.emplace_back("paper", "What the paper reports, measured on its own data.");
  return words;
}

}  // namespace diffsac
