#pragma once

#include <string>

namespace diffsac {

/// Keeps other processes from writing into a run's folder while this lives. The system gives the folder back when the
/// process ends, however it ends; nothing is left in it. On file systems without locks there is none.
class RunLock {
 public:
  /// Creates the folder. Throws Error naming it when another process holds it, or when it cannot be made.
  explicit RunLock(const std::string& folder);
  ~RunLock();
  RunLock(const RunLock&) = delete;
  RunLock& operator=(const RunLock&) = delete;

 private:
  int descriptor_ = -1;
};

}  // namespace diffsac
