#include "lab/config/run_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>

#include "diffsac/core/status.h"
#include "lab/files/files.h"

namespace diffsac {

RunLock::RunLock(const std::string& folder) {
  MakeWritableFolder(folder);
  // Of the folder itself, so that no file stays behind; not for programs that this one starts.
  descriptor_ = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor_ < 0 || ::flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  ::close(descriptor_);
  throw Error(folder + ": another process is writing there; wait for it, or choose another --output");
}

RunLock::~RunLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

}  // namespace diffsac
