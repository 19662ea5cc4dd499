#pragma once

#include <cstdint>
#include <string>

namespace diffsac {

/// The git revision that was built, "unknown" outside a checkout; with "-dirty" when the tree had changes.
std::string GitRevision();
/// "diffsac_eval 0.1.0 (git 1234abcd)": kVersion and the revision.
std::string VersionText(const std::string& program);
/// One line: processor, usable cores, memory, operating system.
std::string MachineText();

/// The program that the `config.yaml` of a run's folder says it is of ("diffsac_train"); empty where it does not say
/// so, or where there is none.
std::string ProgramOfRun(const std::string& folder);

/// A folder for one run's results. Creates it and writes `config.yaml`: a comment block with program, git revision,
/// seed, machine and date, then the resolved configuration.
class RunDirectory {
 public:
  RunDirectory(const std::string& path, const std::string& program, const std::string& resolved_config,
               std::uint64_t seed);
  /// The folder of a run that another process writes: nothing is created.
  explicit RunDirectory(const std::string& path) : path_(path) {}
  const std::string& path() const { return path_; }
  /// `path()/name`.
  std::string File(const std::string& name) const;

 private:
  std::string path_;
};

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
