#include "lab/files/temporary_files.h"

#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <mutex>
#include <set>

namespace diffsac {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMark = ".tmp-";
constexpr std::size_t kLongestStem = 100;  // Bytes; the rest of a name has to fit behind it.
constexpr std::chrono::hours kAbandoned{24};

/// Without dots, so that it ends where an extension begins.
std::string MachineName() {
  char name[256] = "";
  if (::gethostname(name, sizeof name - 1) != 0) return "unknown";
  std::string text(name);
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  return text;
}

/// Whether a process of this machine has ended; init may be slow to take note of it, or never do.
bool HasEnded(long process) {
  if (::kill(static_cast<pid_t>(process), 0) != 0) return errno == ESRCH;
  std::ifstream file("/proc/" + std::to_string(process) + "/stat");
  const std::string stat((std::istreambuf_iterator<char>(file)), {});  // "PID (NAME) STATE ..."
  const std::size_t name_end = stat.rfind(')');
  return name_end != std::string::npos && stat.compare(name_end, 3, ") Z") == 0;
}

/// "PID-N-MACHINE" and an extension, as TemporaryBeside puts them behind the mark.
bool IsLeftOver(const fs::directory_entry& entry) {
  const std::string name = entry.path().filename().string();
  const std::size_t mark = name.rfind(kMark);
  if (!name.starts_with('.') || mark == std::string::npos) return false;
  long process = 0;
  unsigned number = 0;
  int length = 0;
  const std::string rest = name.substr(mark + std::string(kMark).size());
  if (std::sscanf(rest.c_str(), "%ld-%u-%n", &process, &number, &length) != 2 || length == 0 || process <= 0)
    return false;
  std::error_code code;
  const auto written = entry.last_write_time(code);
  if (!code && fs::file_time_type::clock::now() - written > kAbandoned) return true;
  const std::string machine = rest.substr(static_cast<std::size_t>(length));
  const bool here = machine.substr(0, machine.find('.')) == MachineName();
  return here && HasEnded(process);
}

bool IsSeenFirst(const fs::path& folder) {
  static std::mutex mutex;
  static std::set<fs::path> seen;
  const std::lock_guard lock(mutex);
  return seen.insert(folder).second;
}

}  // namespace

void RemoveLeftOver(const fs::path& folder) {
  // What cannot be listed or removed is in nobody's way.
  std::error_code code;
  for (fs::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code)) {
    std::error_code ignored;
    if (IsLeftOver(*entry)) fs::remove(entry->path(), ignored);
  }
}

std::string TemporaryBeside(const fs::path& path) {
  static std::atomic<unsigned> next{0};
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (IsSeenFirst(folder)) RemoveLeftOver(folder);
  for (;;) {
    const std::string name = "." + path.stem().string().substr(0, kLongestStem) + kMark + std::to_string(::getpid()) +
                             "-" + std::to_string(next++) + "-" + MachineName() + path.extension().string();
    const std::string temporary = (path.parent_path() / name).string();
    struct stat info;
    if (::lstat(temporary.c_str(), &info) != 0) return temporary;
  }
}

}  // namespace diffsac
