#include "lab/images/sensor_sizes.h"

#if defined(DIFFSAC_HAS_LENSFUN)
#include <lensfun/lensfun.h>

#include <memory>
#include <mutex>
#endif

namespace diffsac {

#if defined(DIFFSAC_HAS_LENSFUN)
namespace {

struct Destroy {
  void operator()(lfDatabase* database) const { lf_db_destroy(database); }
  void operator()(const lfCamera** cameras) const { lf_free(cameras); }
};

// The cameras that are installed with lensfun, read when they are first asked for.
class Cameras {
 public:
  Cameras() : database_(lf_db_new()) {
    if (database_ && lf_db_load(database_.get()) != LF_NO_ERROR) database_.reset();
  }

  std::optional<double> CropFactor(const std::string& maker, const std::string& model) {
    const std::lock_guard lock(mutex_);
    if (!database_) return std::nullopt;
    const std::unique_ptr<const lfCamera*, Destroy> found(
        lf_db_find_cameras(database_.get(), maker.c_str(), model.c_str()));
    if (!found || found.get()[0] == nullptr || !(found.get()[0]->CropFactor > 0.0F)) return std::nullopt;
    return found.get()[0]->CropFactor;
  }

 private:
  std::mutex mutex_;
  std::unique_ptr<lfDatabase, Destroy> database_;
};

}  // namespace
#endif

std::optional<double> CropFactor([[maybe_unused]] const std::string& maker, [[maybe_unused]] const std::string& model) {
  if (maker.empty() || model.empty()) return std::nullopt;
#if defined(DIFFSAC_HAS_LENSFUN)
  static Cameras cameras;
  return cameras.CropFactor(maker, model);
#else
  return std::nullopt;
#endif
}

}  // namespace diffsac
