#include "lab/config/process.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <limits>
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace diffsac {

void KeepFreedMemory() {
#ifdef __GLIBC__
  // No request is mapped by itself, and what is free at the end of the heap is given back from here on only.
  constexpr int kGiveBackAbove = 1 << 30;
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, kGiveBackAbove);
#endif
}

double PeakMemoryMib() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

namespace {

/// The number that stands behind `key` in a file, in its unit; infinite where there is none.
double NumberIn(const char* path, const std::string& key) {
  std::ifstream file(path);
  for (std::string word; file >> word;)
    if (double value = 0.0; word == key && file >> value) return value;
  return std::numeric_limits<double>::infinity();
}

}  // namespace

double AvailableMemoryMib() {
  double most = std::numeric_limits<double>::infinity(), used = 0.0;
  // "max" where there is no limit.
  std::ifstream("/sys/fs/cgroup/memory.max") >> most;
  std::ifstream("/sys/fs/cgroup/memory.current") >> used;
  const double group = most > 0.0 ? (most - used) / (1 << 20) : std::numeric_limits<double>::infinity();
  double kept = 0.0;  // by KeepFreedMemory
#ifdef __GLIBC__
  kept = static_cast<double>(mallinfo2().fordblks) / (1 << 20);
#endif
  return kept + std::max(0.0, std::min(group, NumberIn("/proc/meminfo", "MemAvailable:") / 1024.0));
}

void WaitPassively(char** argv) {
  constexpr const char* kPolicy = "OMP_WAIT_POLICY";
  if (std::getenv(kPolicy) != nullptr || ::setenv(kPolicy, "passive", 0) != 0) return;
  ::execv("/proc/self/exe", argv);
}

int StartProgram(const std::vector<std::string>& words, int output, int death) {
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  const pid_t parent = ::getpid(), child = ::fork();
  if (child != 0) return child;
  // Only calls that a signal handler may make.
  const bool tied = ::prctl(PR_SET_PDEATHSIG, death) == 0 && ::getppid() == parent;
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
  ::dup2(::open("/dev/null", O_RDWR), STDIN_FILENO);
  if (tied && ::dup2(output, STDOUT_FILENO) >= 0 && ::dup2(output, STDERR_FILENO) >= 0) ::execvp(argv[0], argv.data());
  ::_exit(kCannotRun);
}

int EndOfProgram(int process) {
  int status = 0;
  while (::waitpid(process, &status, 0) < 0)
    if (errno != EINTR) return kCannotRun;
  return WIFEXITED(status) ? WEXITSTATUS(status) : kCannotRun;
}

}  // namespace diffsac
