#include "lab/report/words.h"

#include <catch2/catch.hpp>
#include <cctype>

#include "lab/eval/eval_fixtures.h"
#include "lab/report/colours.h"
#include "lab/report/metric_table.h"
#include "lab/report/result_files.h"

namespace diffsac {

extern const char kHtmlPageCss[];

namespace {

using Catch::Contains;
using namespace testing;

bool Explains(const std::vector<Table>& tables, const std::string& term) {
  const auto words = WordsOf(tables);
  return std::any_of(words.begin(), words.end(), [&](const auto& word) { return word.first == term; });
}

}  // namespace

TEST_CASE("what occurs in the tables is explained, and nothing else") {
  const ExperimentResults results = MadeUpResults();
  const std::vector<Table> tables = MakeReport(results).tables;
  for (const char* term : {"mAA@c", "median error", "hypotheses", "ms", "[0.45, 0.57]", "bold", "oracle", "paper"})
    CHECK(Explains(tables, term));
  for (const char* term : {"AUC@c", "recall", "normal, d"}) CHECK_FALSE(Explains(tables, term));
  const ExperimentResults poses = MadeUpPoses(), structures = MadeUpStructures();
  CHECK(Explains(MakeReport(poses).tables, "AUC@c"));
  CHECK(Explains(MakeReport(structures).tables, "recall"));
  CHECK(WordsOf({}).empty());
}

TEST_CASE("no number is printed as a long row of digits") {
  CHECK(FixedText(0.12345, 3) == "0.123");
  CHECK(FixedText(123456.0, 1) == "123456.0");
  CHECK(FixedText(1e300, 3) == "1e+300");
  CHECK(FixedText(-1.5e12, 2) == "-1.5e+12");
  CHECK(FixedText(std::nan(""), 2) == kUnknown);
  ExperimentResults results = MadeUpResults();
  for (ProblemRecord& record : results.cells[0].records) record.error.angle_deg = 1e300;
  for (const Table& table : MakeReport(results).tables)
    for (const Table::Row& row : table.rows)
      for (const std::string& cell : row.cells) CHECK(cell.size() < 40);
}

TEST_CASE("an inlier is of one colour in pictures, pages and clouds") {
  std::string green = kInlierColour;
  for (char& c : green) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  CHECK_THAT(std::string(kHtmlPageCss), Contains("--right: " + green));
  CHECK(ColourParts("#0A9440") == std::array<std::uint8_t, 3>{10, 148, 64});
  CHECK(std::string(LabelColour(1, false)) == kInlierColour);
  CHECK(std::string(LabelColour(0, true)) == kOutlierColour);
  CHECK(std::string(LabelColour(2, true)) == StructureColour(1));
}

TEST_CASE("a run ends with where its results are, and only those that are there") {
  const TemporaryFolder folder;
  CHECK(ResultsText(folder.path()) == "results are in " + folder.path());
  WriteFileAtomically(folder.File("report.html"), "");
  WriteFileAtomically(folder.File("problems.csv"), "");
  CHECK(ResultsText(folder.path()) ==
        "results are in " + folder.path() + ": report.html (open it in a browser), problems.csv");
}

}  // namespace diffsac
