#include "lab/data/warn_once.h"

#include <mutex>
#include <set>

#include "diffsac/core/logging.h"

namespace diffsac {

void WarnOnce(const std::string& line) {
  static std::mutex mutex;
  static std::set<std::string> told;
  const std::lock_guard lock(mutex);
  if (told.insert(line).second) LogWarning(line);
}

}  // namespace diffsac
