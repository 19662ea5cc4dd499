#include "lab/images/write_scene.h"

#include <filesystem>

#include "diffsac/core/logging.h"

namespace diffsac {

namespace fs = std::filesystem;

void WriteScene(const PairsRequest& request, const std::string& name, const std::function<CorrespondenceSet()>& read,
                const std::atomic<bool>& stop, PrepareResult* result) {
  const std::string folder = (fs::path(request.output) / name).string();
  RefuseInputsInScene(request, folder);
  if (!request.options.overwrite && fs::exists(fs::path(folder) / "matches.h5")) {
    LogInfo(folder + ": already there");
    result->already_there += 1;
    return;
  }
  const CorrespondenceSet set = read();
  result->finished = !stop;
  if (stop) return;
  WriteCorrespondences(folder, set);
  LogInfo(folder + ": " + std::to_string(set.pairs.size()) + " pairs");
  result->written += 1;
}

}  // namespace diffsac
