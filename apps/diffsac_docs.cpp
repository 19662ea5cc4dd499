// Fills the figures of the documents from the pages of results, or checks both. See docs/figures.yaml.
#include <CLI/CLI.hpp>

#include <cstdlib>
#include <filesystem>
#include <iostream>

#include "diffsac/core/files.h"
#include "diffsac/core/status.h"
#include "lab/config/run_directory.h"
#include "lab/config/yaml.h"
#include "lab/report/command_line.h"
#include "lab/report/doc_figures.h"
#include "lab/report/page_checks.h"

namespace {

using namespace diffsac;
namespace fs = std::filesystem;

constexpr int kExitFaults = 1;

struct Request {
  std::string definitions = "docs/figures.yaml", pages = "docs/results", tables = "configs/tables";
  bool check = false, check_pages = false;
  std::vector<std::string> compared;
  std::vector<std::string> documents;
};

/// Fills the documents' marks, or names those that are not what they should be.
int Documents(const Request& request) {
  DocFigures figures(ConfigFromFile(request.definitions), request.pages);
  int faults = 0;
  for (const std::string& path : request.documents) {
    const std::string text = ReadFile(path);
    std::string filled;
    try {
      filled = figures.Fill(text);
    } catch (const Error& error) {
      throw Error(path + ": " + error.what());
    }
    if (filled == text) continue;
    if (!request.check) {
      WriteFileAtomically(path, filled);
      std::cout << "filled: " << path << std::endl;
      continue;
    }
    ++faults;
    const auto at = std::mismatch(text.begin(), text.end(), filled.begin(), filled.end());
    const auto line = std::count(text.begin(), at.first, '\n') + 1;
    std::cout << path << ":" << line << ": a figure is not what its page has; diffsac_docs fills it" << std::endl;
  }
  for (const std::string& change : figures.Changed())
    std::cout << change << "; read again what is said about it" << std::endl;
  for (const std::string& name : figures.Unused()) {
    std::cout << request.definitions << ": no document asks for " << name << std::endl;
    ++faults;
  }
  return faults;
}

bool IsAncestor(const std::string& revision) {
  if (revision.find_first_not_of("0123456789abcdef") != std::string::npos) return false;
  return std::system(("git merge-base --is-ancestor " + revision + " HEAD 2>/dev/null").c_str()) == 0;
}

int Pages(const Request& request) {
  const Config definitions = ConfigFromFile(request.definitions);
  // A shallow clone does not know its ancestors.
  const bool checkout = std::system("test \"$(git rev-parse --is-shallow-repository 2>/dev/null)\" = false") == 0;
  if (!checkout) std::cout << "no whole git checkout here: the pages' revisions are not looked up" << std::endl;
  int faults = 0;
  for (const auto& entry : fs::directory_iterator(request.pages)) {
    if (entry.path().extension() != ".md") continue;
    const fs::path table = fs::path(request.tables) / entry.path().stem().concat(".yaml");
    const std::string config = fs::exists(table) ? table.string() : "", page = entry.path().string();
    const std::string revision = ReadResultsPage(page).revision;
    if (config.empty() && revision.empty()) continue;  // Written by hand.
    const std::string key = "older_pages." + entry.path().stem().string();
    if (definitions.Has(key)) {
      std::cout << page << ": of an older revision, " << revision << ": " << definitions.Text(key) << std::endl;
      continue;
    }
    std::vector<std::string> found = PageFaults(page, config);
    if (checkout && !revision.empty() && !revision.ends_with("-dirty") && !IsAncestor(revision))
      found.push_back(page + ": its revision " + revision + " is not an ancestor of this one");
    for (const std::string& fault : found) std::cout << fault << std::endl;
    faults += static_cast<int>(found.size());
  }
  return faults;
}

int Compare(const std::string& page, const std::string& again) {
  const std::vector<std::string> differences = PageDifferences(ReadResultsPage(page), ReadResultsPage(again));
  for (const std::string& difference : differences) std::cout << difference << std::endl;
  std::cout << page << ": " << (differences.empty() ? "the same values" : "other values than those of " + again)
            << std::endl;
  return static_cast<int>(differences.size());
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Fills the figures of documents from the pages of results, or checks both"};
  Request request;
  app.set_version_flag("--version", VersionText("diffsac_docs"));
  app.add_option("documents", request.documents, "Markdown files with marks (report/doc_figures.h)");
  app.add_option("--compare", request.compared, "A page and the same one made again: which values differ")->expected(2);
  app.add_flag("--check", request.check, "Only names the documents that differ");
  app.add_flag("--check-pages", request.check_pages,
               "Names pages of results that were changed by hand, are of another history, or have rows that no "
               "configuration has");
  app.add_option("--definitions", request.definitions, "What the marks stand for")->capture_default_str();
  app.add_option("--pages", request.pages, "Folder of the pages")->capture_default_str();
  app.add_option("--tables", request.tables, "Folder of their configurations")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    if (!request.compared.empty())
      return Compare(request.compared[0], request.compared[1]) == 0 ? kExitOk : kExitFaults;
    const int faults = Documents(request) + (request.check_pages ? Pages(request) : 0);
    return faults == 0 ? kExitOk : kExitFaults;
  } catch (const std::exception& error) {
    std::cerr << "diffsac_docs: " << MessageOf(error) << std::endl;
    return kExitBadInput;
  }
}
