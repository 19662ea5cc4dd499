#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace diffsac {

/// Progress of long work: a bar with rate and time left on a terminal, a plain line every few seconds in a log.
/// Thread-safe; costs almost nothing when nothing is due to be printed.
class Progress {
 public:
  Progress(std::string title, std::int64_t total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `note` stands behind the rate ("loss 0.12"). seconds_left: what is forecast; negative: as long for each of the
  /// rest as for those that are done.
  void Advance(std::int64_t count = 1, const std::string& note = "", double seconds_left = -1.0);
  void Finish();

 private:
  struct Impl;
  Impl* impl_;
};

/// The text of a progress line without its title: "57% 57/100 12.3/s, 0:35 left, note". A total of 0 is unknown.
/// seconds_left: as in Advance.
std::string ProgressText(std::int64_t done, std::int64_t total, double seconds, const std::string& note = "",
                         double seconds_left = -1.0);

/// Sends the log to the terminal (coloured, stderr) and, when `file` is not empty, to a log file as well, by spdlog.
/// Call once in a program. Files that see LibTorch must not see spdlog (both bring a version of fmt): they call
/// core/logging.h.
void InitLogging(const std::string& file = "", bool quiet = false);

}  // namespace diffsac
