#pragma once

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace diffsac::testing {

/// A port that nobody listens on at the moment.
inline int FreePort() {
  const int handle = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  if (handle < 0 || ::bind(handle, reinterpret_cast<sockaddr*>(&address), length) != 0 ||
      ::getsockname(handle, reinterpret_cast<sockaddr*>(&address), &length) != 0)
    throw std::runtime_error("no free port");
  ::close(handle);
  return ntohs(address.sin_port);
}

using Variables = std::map<std::string, std::string>;

/// Starts one process a rank: this test program again with a hidden test case, and the variables that torchrun sets.
inline std::vector<pid_t> StartRanks(const std::string& test_case, int size, Variables variables) {
  variables["WORLD_SIZE"] = std::to_string(size);
  variables["MASTER_ADDR"] = "127.0.0.1";
  variables["MASTER_PORT"] = std::to_string(FreePort());
  std::vector<pid_t> processes;
  for (int rank = 0; rank < size; ++rank) {
    const pid_t process = ::fork();
    if (process == 0) {
      for (const auto& [name, value] : variables) ::setenv(name.c_str(), value.c_str(), 1);
      ::setenv("RANK", std::to_string(rank).c_str(), 1);
      ::setenv("LOCAL_RANK", std::to_string(rank).c_str(), 1);
      ::execl("/proc/self/exe", "worker", test_case.c_str(), static_cast<char*>(nullptr));
      ::_exit(127);
    }
    processes.push_back(process);
  }
  return processes;
}

/// Waits; the exit statuses by rank, of a killed process 128 + signal.
inline std::vector<int> WaitForRanks(const std::vector<pid_t>& processes) {
  std::vector<int> statuses;
  for (const pid_t process : processes) {
    int status = 0;
    ::waitpid(process, &status, 0);
    statuses.push_back(WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status));
  }
  return statuses;
}

inline std::vector<int> RunRanks(const std::string& test_case, int size, const Variables& variables = {}) {
  return WaitForRanks(StartRanks(test_case, size, variables));
}

}  // namespace diffsac::testing
