#include "lab/images/network_keypoints.h"

#include <dlfcn.h>

#include <filesystem>

#include "diffsac/core/status.h"
#include "lab/config/paths.h"

namespace diffsac {
namespace {

FindNetworkKeypoints Load() {
  std::vector<std::string> places;
  for (const std::string& share : ShareFolders())
    AddPlace((std::filesystem::path(share) / "../../lib/diffsac/diffsac_keypoints.so").string(), &places);
  const std::string file = FirstPlace("xfeat needs LibTorch, and of an installation with the lab the module", places);
  void* module = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* function = module == nullptr ? nullptr : dlsym(module, "DiffsacFindNetworkKeypoints");
  if (function == nullptr) throw Error(file + ": cannot be loaded: " + dlerror());
  return reinterpret_cast<FindNetworkKeypoints>(function);
}

}  // namespace

FindNetworkKeypoints NetworkKeypointsFunction() {
  static const FindNetworkKeypoints function = Load();
  return function;
}

}  // namespace diffsac
