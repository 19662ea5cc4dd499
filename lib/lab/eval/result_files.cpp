#include "lab/eval/result_files.h"

#include <filesystem>
#include <utility>

namespace diffsac {
namespace {

namespace fs = std::filesystem;

/// What programs leave, in the order of use, and what it is for.
constexpr std::pair<const char*, const char*> kFiles[] = {
    {"report.html", " (open it in a browser)"},
    {"checkpoints/best.safetensors", " (the network, for --checkpoint)"},
    {"table.md", ""},
    {"problems.csv", ""},
    {"estimates.h5", ""},
    {"metrics.csv", ""},
    {"events.out.tfevents.diffsac", " (tensorboard --logdir of the folder)"},
    {"labels", " (the points with their labels)"},
};

}  // namespace

std::string ResultsText(const std::string& folder) {
  std::string files;
  for (const auto& [name, purpose] : kFiles)
    if (fs::exists(fs::path(folder) / name)) files += (files.empty() ? ": " : ", ") + std::string(name) + purpose;
  return "results are in " + folder + files;
}

}  // namespace diffsac
