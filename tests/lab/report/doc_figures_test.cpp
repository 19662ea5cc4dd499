#include "lab/report/doc_figures.h"

#include <catch2/catch.hpp>

#include "core/temporary_folder.h"
#include "diffsac/core/files.h"
#include "diffsac/core/status.h"
#include "lab/config/yaml.h"

namespace diffsac {
namespace {

using Catch::Contains;

constexpr const char* kPage =
    "# a title\n\n## mAA@10deg, higher is better\n\n"
    "| method      | all matches | ratio 0.85 |   ms |\n"
    "|-------------|------------:|-----------:|-----:|\n"
    "| PROSAC 1000 |       0.401 |  **0.456** | 3.18 |\n"
    "| PROSAC 20   |   **0.430** |      0.406 | 1.51 |\n\n"
    "## differences\n\n"
    "| A minus B |                 all |\n"
    "|-----------|--------------------:|\n"
    "| a − b     | +0.118 [0.01, 0.20] |\n\n"
    "- git revision: abc123\n";

constexpr const char* kDefinitions =
    "figures:\n"
    "  both: {page: x, table: mAA, row: PROSAC 1000, columns: [all matches, ratio 0.85]}\n"
    "  gain: {page: x, table: differences, row: a, column: all}\n"
    "tables:\n"
    "  two:\n"
    "    first: right\n"
    "    best: higher\n"
    "    columns: [{title: all, page: x, table: mAA, column: all}]\n"
    "    rows: [{title: a, row: PROSAC 1000}, {title: b, row: PROSAC 20}, {title: elsewhere, cells: ['.2']}]\n";

struct Pages {
  TemporaryFolder folder;
  Pages() { WriteFileAtomically(folder.File("x.md"), kPage); }
  DocFigures Figures(const std::string& definitions = kDefinitions) const {
    return DocFigures(ConfigFromYaml(definitions, "figures.yaml"), folder.File(""));
  }
};

TEST_CASE("a page of results is read back: tables, cells without bold type, revision") {
  const Pages pages;
  const ResultsPage page = ReadResultsPage(pages.folder.File("x.md"));
  REQUIRE(page.tables.size() == 2);
  CHECK(page.tables[0].heading == "mAA@10deg, higher is better");
  CHECK(page.tables[0].columns == std::vector<std::string>{"method", "all matches", "ratio 0.85", "ms"});
  CHECK(page.tables[0].rows[1] == std::vector<std::string>{"PROSAC 20", "0.430", "0.406", "1.51"});
  CHECK(page.revision == "abc123");
  CHECK(page.Cell("mAA", "PROSAC 20", "ratio") == "0.406");
  CHECK_THROWS_WITH(page.Cell("mAA", "PROSAC", "ratio"), Contains("several that begin with 'PROSAC'"));
  CHECK_THROWS_WITH(page.Cell("mAA", "RANSAC", "ratio"), Contains("no 'RANSAC', but: PROSAC 1000; PROSAC 20"));
  CHECK_THROWS_WITH(page.Cell("recall", "RANSAC", "ratio"), Contains("x.md has no 'recall'"));
}

TEST_CASE("a page made again differs where a value moves by more than rounding, times apart") {
  const Pages pages;
  const auto against = [&](const std::string& from, const std::string& to) {
    std::string text = kPage;
    text.replace(text.find(from), from.size(), to);
    WriteFileAtomically(pages.folder.File("y.md"), text);
    return PageDifferences(ReadResultsPage(pages.folder.File("x.md")), ReadResultsPage(pages.folder.File("y.md")));
  };
  CHECK(against("0.401", "0.402").empty());
  CHECK(against("3.18", "9.99").empty());
  CHECK(against("0.401", "0.403") ==
        std::vector<std::string>{"mAA@10deg, higher is better: PROSAC 1000, all matches: 0.401, now 0.403"});
  CHECK(against("[0.01, 0.20]", "[0.01, 0.25]").size() == 1);
  CHECK(against("PROSAC 20 ", "PROSAC 30 ") ==
        std::vector<std::string>{"mAA@10deg, higher is better: only the page has 'PROSAC 20'",
                                 "mAA@10deg, higher is better: only the new one has 'PROSAC 30'"});
}

TEST_CASE("rows of one name are compared in their order, which once were all compared with each other") {
  const Pages pages;
  const auto page = [&](const std::string& file, const std::string& second) {
    WriteFileAtomically(pages.folder.File(file),
                        "## t\n\n| method | x |\n|---|---:|\n| a | 0.10 |\n| a | " + second + " |\n");
    return ReadResultsPage(pages.folder.File(file));
  };
  CHECK(PageDifferences(page("p.md", "0.90"), page("q.md", "0.90")).empty());
  CHECK(PageDifferences(page("p.md", "0.90"), page("q.md", "0.80")).size() == 1);
}

TEST_CASE("tables of one heading are compared in their order, which once were all compared with the first") {
  const Pages pages;
  const auto page = [&](const std::string& file, const std::string& second) {
    const std::string head = "## t\n\n| method | x |\n|---|---:|\n| a | ";
    WriteFileAtomically(pages.folder.File(file), head + "0.10 |\n\n" + head + second + " |\n");
    return ReadResultsPage(pages.folder.File(file));
  };
  CHECK(PageDifferences(page("p.md", "0.90"), page("q.md", "0.90")).empty());
  CHECK(PageDifferences(page("p.md", "0.90"), page("q.md", "0.80")).size() == 1);
}

TEST_CASE("marks are filled, and what stands around them stays") {
  const Pages pages;
  DocFigures figures = pages.Figures();
  CHECK(figures.Fill("F <!-- figure: both -->.1/.2<!-- / -->, +<!-- figure: gain --><!-- / -->.\n") ==
        "F <!-- figure: both -->.401/.456<!-- / -->, +<!-- figure: gain -->+.118 [.01, .20]<!-- / -->.\n");
  CHECK(figures.Unused() == std::vector<std::string>{"tables.two"});
  const std::string filled = figures.Fill("<!-- figures: two -->\nold\n<!-- /figures -->\n");
  CHECK_THAT(filled, Contains("| right") && Contains("**.430**") && Contains(" .401 |") && Contains("| elsewhere") &&
                         !Contains("old") && !Contains("**.401"));
  CHECK(figures.Fill(filled) == filled);
  CHECK(figures.Unused().empty());
}

TEST_CASE("a figure may leave out its interval") {
  const Pages pages;
  CHECK(pages.Figures("figures: {a: {page: x, table: diff, row: a, column: all, interval: no}}")
            .Fill("<!-- figure: a --><!-- / -->") == "<!-- figure: a -->+.118<!-- / -->");
}

TEST_CASE("a table may have the page's columns as its rows") {
  const Pages pages;
  const std::string filled =
      pages
          .Figures(
              "tables: {t: {first: x, columns: [{title: a, page: x, table: mAA, row: PROSAC 1000}, {title: b, "
              "page: x, table: mAA, row: PROSAC 20}], rows: [{title: all, column: all}, {title: r, column: ratio}]}}")
          .Fill("<!-- figures: t --><!-- /figures -->");
  CHECK_THAT(filled, Contains("| all | .401 | .430 |") && Contains("| r   | .456 | .406 |"));
}

TEST_CASE("a claim follows from the intervals of its differences") {
  const Pages pages;
  WriteFileAtomically(pages.folder.File("d.md"),
                      "## differences\n\n| A minus B | x |\n|---|---:|\n| up | **+0.118 [+0.069, +0.172]** |\n"
                      "| down | **-0.02 [-0.03, -0.01]** |\n| level | +0.007 [-0.01, +0.02] |\n| few | +0.1 |\n");
  const auto answer = [&](const std::vector<std::string>& rows, const std::string& every = "no") {
    std::string definition = "claims:\n  c:\n    every: " + every + "\n    differences:\n";
    for (const std::string& row : rows)
      definition += "    - {page: d, table: differences, row: " + row + ", column: x}\n";
    return pages.Figures(definition).Fill("<!-- claim: c --><!-- / -->");
  };
  CHECK_THAT(answer({"up"}), Contains(">yes<"));
  CHECK_THAT(answer({"up", "level"}), Contains(">in part<"));
  CHECK_THAT(answer({"up", "down"}), Contains(">in part<"));
  CHECK_THAT(answer({"up", "down"}, "yes"), Contains(">no<"));
  CHECK_THAT(answer({"up", "level"}, "yes"), Contains(">open<"));
  CHECK_THAT(answer({"down, swapped: yes"}), Contains(">yes<"));
  CHECK_THAT(answer({"level", "down"}), Contains(">no<"));
  CHECK_THAT(answer({"level"}), Contains(">open<"));
  CHECK_THROWS_WITH(answer({"few"}), Contains("no difference with its interval"));
}

TEST_CASE("a claim that changes is told, and its evidence is a table with the number of trainings") {
  const Pages pages;
  WriteFileAtomically(pages.folder.File("d.md"),
                      "## differences\n\n| A minus B | x |\n|---|---:|\n| up − b | **+0.118 [+0.069, +0.172]** |\n\n"
                      "- network: a_seed_1/checkpoints/best.safetensors, sha256 1\n"
                      "- network: b_seed_1/checkpoints/best.safetensors, sha256 2\n"
                      "- network: a_seed_2/checkpoints/best.safetensors, sha256 3\n");
  DocFigures figures = pages.Figures("claims: {c: {differences: [{page: d, table: differences, row: up, column: x}]}}");
  const std::string filled = figures.Fill("<!-- claim: c -->no<!-- / --> <!-- evidence: c --><!-- /evidence -->");
  CHECK_THAT(filled,
             Contains("up − b") && Contains("[d](d.md)") && Contains("**+.118 [+.069, +.172]**") && Contains("2 |"));
  const std::string swapped =
      pages.Figures("claims: {c: {differences: [{page: d, table: differences, row: up, column: x, swapped: yes}]}}")
          .Fill("<!-- evidence: c --><!-- /evidence -->");
  CHECK_THAT(swapped, Contains("up − b (below zero speaks for the claim)"));
  REQUIRE(figures.Changed().size() == 1);
  CHECK_THAT(figures.Changed()[0], Contains("claim c: it said 'no', now 'yes'"));
  CHECK(ReadResultsPage(pages.folder.File("d.md")).Trainings() == 2);
  CHECK(ReadResultsPage(pages.folder.File("x.md")).Trainings() == 0);
}

TEST_CASE("a mark without a definition, an end or a cell is an error that says where") {
  const Pages pages;
  CHECK_THROWS_WITH(pages.Figures().Fill("<!-- figure: nothing -->1<!-- / -->"), Contains("figures.nothing"));
  CHECK_THROWS_WITH(pages.Figures().Fill("<!-- figure: both -->1"), Contains("is not closed by '<!-- / -->'"));
  CHECK_THROWS_WITH(pages.Figures("figures: {a: {page: x, table: mAA, row: LMEDS, column: ms}}")
                        .Fill("<!-- figure: a -->1<!-- / -->"),
                    Contains("figures.yaml:1") && Contains("no 'LMEDS'"));
  CHECK_THROWS_WITH(pages.Figures("tables: {a: {first: x, columns: [{title: t}], rows: [{title: u, cells: [1, 2]}]}}")
                        .Fill("<!-- figures: a -->\n<!-- /figures -->"),
                    Contains("1 columns"));
}

}  // namespace
}  // namespace diffsac
