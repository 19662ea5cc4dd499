#include "lab/eval/results_page.h"

#include <algorithm>
#include <filesystem>
#include <vector>

#include "lab/files/files.h"

namespace diffsac {

namespace fs = std::filesystem;

bool IsMade(const ExperimentOptions& experiment, const std::string& folder) {
  const std::string table = folder + "/table.md", config_path = folder + "/config.yaml",
                    json = folder + "/results.json";
  for (const std::string& path : {table, config_path, json})
    if (!fs::exists(path)) return false;
  const std::string config = ReadFile(config_path);
  const std::size_t header = config.find("\n\n");
  if (header == std::string::npos || config.substr(header + 2) != WriteExperiment(experiment)) return false;
  if (ReadFile(json).find("\"partial\": false") == std::string::npos) return false;
  std::vector<fs::path> sources = {fs::read_symlink("/proc/self/exe")};
  for (const EstimatorRow& row : experiment.methods)
    if (row.config.Has("checkpoint")) sources.emplace_back(row.config.Text("checkpoint"));
  return std::all_of(sources.begin(), sources.end(), [&](const fs::path& source) {
    return fs::exists(source) && fs::last_write_time(source) < fs::last_write_time(table);
  });
}

}  // namespace diffsac
