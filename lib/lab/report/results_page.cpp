#include "lab/report/results_page.h"

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <vector>

#include "diffsac/core/files.h"
#include "lab/config/yaml.h"
#include "lab/report/metric_table.h"
#include "lab/report/page_checks.h"
#include "lab/report/run_reader.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kShownDigits = 12;  // Of a digest.
constexpr std::size_t kMostMatches = 2;   // Pictures of matches on a page.
constexpr std::string_view kDataRoot = "data";

/// All but those of matches, then two of these, from first to last.
std::vector<fs::path> PicturesIn(const std::string& folder) {
  std::vector<fs::path> pictures, matches;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".png") continue;
    const bool of_matches = entry.path().filename().string().starts_with("matches_");
    (of_matches ? matches : pictures).push_back(entry.path());
  }
  std::sort(pictures.begin(), pictures.end());
  std::sort(matches.begin(), matches.end());
  const std::size_t most = std::min(kMostMatches, matches.size());
  for (std::size_t i = 0; i < most; ++i) pictures.push_back(matches[i * matches.size() / most]);
  return pictures;
}

/// The lines "# key: value" that a run's config.yaml begins with, without the "# ".
std::vector<std::string> HeaderOf(const std::string& config) {
  std::vector<std::string> lines;
  std::istringstream in(config);
  for (std::string line; std::getline(in, line) && line.starts_with("# ");) lines.push_back(line.substr(2));
  return lines;
}

/// What stands below that header.
std::string BodyOf(const std::string& config) {
  const std::size_t end = config.find("\n\n");
  return end == std::string::npos ? "" : config.substr(end + 2);
}

std::string DateLine(const std::string& config) {
  for (const std::string& line : HeaderOf(config))
    if (line.starts_with("date: ")) return line;
  return "";
}

}  // namespace

std::string PictureBeside(const std::string& picture, const std::string& page, const std::string& name) {
  const fs::path from(picture);
  const std::string copy = name + "_" + from.filename().string();
  WriteFileAtomically((fs::path(page).parent_path() / copy).string(), ReadFile(picture));
  return "![" + name + ": " + from.stem().string() + "](" + copy + ")\n\n";
}

std::string FactsOfRun(const std::string& folder) {
  std::string text;
  for (const std::string& line : HeaderOf(ReadFile(folder + "/config.yaml")))
    if (!line.starts_with("program: ")) text += "- " + line + "\n";
  const RunFacts facts = ReadRunFacts(folder);
  if (facts.seconds > 0.0) text += "- " + std::string(kRunSeconds) + FixedText(facts.seconds, 0) + " s\n";
  if (facts.peak_memory_mib > 0.0) text += "- peak memory: " + FixedText(facts.peak_memory_mib, 0) + " MiB\n";
  if (!facts.data_digest.empty()) text += "- data: sha256 " + facts.data_digest.substr(0, kShownDigits) + "\n";
  for (const auto& [path, digest] : facts.networks)
    text += "- network: " + path + ", sha256 " + digest.substr(0, kShownDigits) + "\n";
  return text;
}

namespace {

/// The run's configuration with every key, without what is this machine's: its header, and where its data is.
std::string ResolvedConfig(const std::string& folder) {
  std::string text = BodyOf(ReadFile(folder + "/config.yaml"));
  const Config config = ConfigFromYaml(text, folder + "/config.yaml");
  const std::string root = config.Has("data_root") ? config.Text("data_root") : "";
  if (!root.starts_with('/')) return text;
  for (std::size_t at = text.find(root); at != std::string::npos; at = text.find(root, at + kDataRoot.size()))
    text.replace(at, root.size(), kDataRoot);
  return text;
}

}  // namespace

void WritePage(const std::string& folder, const std::string& page, const std::string& command) {
  const fs::path path(page);
  const std::string name = path.stem().string();
  if (path.has_parent_path()) fs::create_directories(path.parent_path());
  std::string text = ReadFile(folder + "/table.md") + "\n";
  for (const fs::path& picture : PicturesIn(folder)) text += PictureBeside(picture.string(), page, name);
  const fs::path resolved = fs::path("resolved") / (name + ".yaml");
  fs::create_directories(path.parent_path() / "resolved");
  WriteFileAtomically((path.parent_path() / resolved).string(), ResolvedConfig(folder));
  text += "Written by `" + command + "`.\n\n" + FactsOfRun(folder) + "- configuration, with every key: [" + name +
          ".yaml](" + resolved.string() + ")\n";
  WriteFileAtomically(page, text + PageDigestLine(text));
}

bool IsMade(const ExperimentOptions& experiment, const std::string& folder, const std::string& page) {
  const std::string table = folder + "/table.md", config_path = folder + "/config.yaml",
                    json = folder + "/results.json";
  for (const std::string& path : {table, config_path, json})
    if (!fs::exists(path)) return false;
  const std::string config = ReadFile(config_path);
  if (BodyOf(config) != WriteExperiment(experiment)) return false;
  if (ReadFile(json).find("\"partial\": false") == std::string::npos) return false;
  if (!page.empty() && (!fs::exists(page) || ReadFile(page).find("- " + DateLine(config)) == std::string::npos))
    return false;
  std::vector<fs::path> sources = {fs::read_symlink("/proc/self/exe")};
  for (const EstimatorRow& row : experiment.methods)
    if (row.config.Has("checkpoint")) sources.emplace_back(row.config.Text("checkpoint"));
  return std::all_of(sources.begin(), sources.end(), [&](const fs::path& source) {
    return fs::exists(source) && fs::last_write_time(source) < fs::last_write_time(table);
  });
}

}  // namespace diffsac
