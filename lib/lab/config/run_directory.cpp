#include "lab/config/run_directory.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "diffsac/core/parallel.h"
#include "diffsac/core/status.h"
#include "diffsac/core/version.h"
#include "diffsac_git_revision.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

constexpr const char* kConfigFile = "config.yaml";
constexpr std::string_view kProgram = "# program: ";  // What its first line begins with.

/// The text behind "name : " in a file of such lines, empty when there is none.
std::string ValueInFile(const char* file, const std::string& name) {
  std::ifstream in(file);
  std::string line;
  while (std::getline(in, line)) {
    const auto colon = line.find(':');
    if (!line.starts_with(name) || colon == std::string::npos) continue;
    const auto begin = line.find_first_not_of(" \t", colon + 1);
    return begin == std::string::npos ? "" : line.substr(begin);
  }
  return "";
}

std::string MemoryText() {
  const std::string text = ValueInFile("/proc/meminfo", "MemTotal");
  double kibibytes = 0.0;
  if (std::sscanf(text.c_str(), "%lf", &kibibytes) != 1) return "unknown memory";
  char gibibytes[32];
  std::snprintf(gibibytes, sizeof(gibibytes), "%.1f GiB", kibibytes / (1024.0 * 1024.0));
  return gibibytes;
}

std::string UtcNow() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  ::gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

}  // namespace

std::string GitRevision() { return DIFFSAC_GIT_REVISION; }

std::string VersionText(const std::string& program) {
  return program + " " + kVersion + " (git " + GitRevision() + ")";
}

std::string MachineText() {
  utsname system{};
  ::uname(&system);
  std::string processor = ValueInFile("/proc/cpuinfo", "model name");
  if (processor.empty()) processor = system.machine;
  const int cores = HardwareThreads();
  return processor + ", " + std::to_string(cores) + (cores == 1 ? " core, " : " cores, ") + MemoryText() + ", " +
         system.sysname + " " + system.release;
}

std::string ProgramOfRun(const std::string& folder) {
  std::ifstream file((std::filesystem::path(folder) / kConfigFile).string());
  std::string line;
  return std::getline(file, line) && line.starts_with(kProgram) ? line.substr(kProgram.size()) : "";
}

RunDirectory::RunDirectory(const std::string& path, const std::string& program, const std::string& resolved_config,
                           std::uint64_t seed)
    : path_(path) {
  MakeWritableFolder(path);
  const std::string header = std::string(kProgram) + program + "\n# git revision: " + GitRevision() +
                             "\n# seed: " + std::to_string(seed) + "\n# machine: " + MachineText() +
                             "\n# libraries: " + DIFFSAC_LIBRARIES + "\n# date: " + UtcNow() + "\n\n";
  WriteFileAtomically(File(kConfigFile), header + resolved_config);
}

std::string RunDirectory::File(const std::string& name) const { return (std::filesystem::path(path_) / name).string(); }

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
