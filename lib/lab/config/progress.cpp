#include "lab/config/progress.h"

#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kBarInterval{100};
constexpr std::chrono::seconds kLineInterval{10};
constexpr int kBarWidth = 24;

std::string RateText(double rate) {
  char text[32];
  std::snprintf(text, sizeof(text), rate < 10.0 ? "%.2f/s" : rate < 100.0 ? "%.1f/s" : "%.0f/s", rate);
  return text;
}

/// "0:07", "12:34", "3:05:00".
std::string DurationText(double seconds) {
  // More than a year is no forecast.
  const auto total = static_cast<long>(std::lround(std::clamp(seconds, 0.0, 3.2e7)));
  const long hours = total / 3600, minutes = total / 60 % 60, rest = total % 60;
  char text[48];
  if (hours > 0) {
    std::snprintf(text, sizeof(text), "%ld:%02ld:%02ld", hours, minutes, rest);
  } else {
    std::snprintf(text, sizeof(text), "%ld:%02ld", minutes, rest);
  }
  return text;
}

std::string BarText(std::int64_t done, std::int64_t total) {
  if (total <= 0) return "";
  const double share = std::clamp(static_cast<double>(done) / static_cast<double>(total), 0.0, 1.0);
  std::string bar(kBarWidth, '.');
  std::fill_n(bar.begin(), static_cast<int>(share * kBarWidth), '#');
  return "[" + bar + "] ";
}

std::size_t TerminalWidth() {
  winsize size{};
  if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col < 20) return 80;
  return size.ws_col;
}

}  // namespace

std::string ProgressText(std::int64_t done, std::int64_t total, double seconds, const std::string& note,
                         double seconds_left) {
  std::string text;
  if (total > 0) {
    const double share = std::clamp(static_cast<double>(done) / static_cast<double>(total), 0.0, 1.0);
    // Rounded down: 100% stands for finished.
    text = std::to_string(static_cast<int>(std::floor(100.0 * share))) + "% ";
  }
  text += std::to_string(done) + (total > 0 ? "/" + std::to_string(total) : "");
  if (done > 0 && seconds > 0.0) {
    text += " " + RateText(static_cast<double>(done) / seconds);
    if (seconds_left < 0.0) seconds_left = seconds * static_cast<double>(total - done) / static_cast<double>(done);
    if (done < total) text += ", " + DurationText(seconds_left) + " left";
  }
  if (total <= 0 || done >= total) text += ", took " + DurationText(seconds);
  return note.empty() ? text : text + ", " + note;
}

struct Progress::Impl {
  std::string title;
  std::int64_t total = 0;
  bool terminal = false;
  Clock::time_point start;
  Clock::duration interval;
  std::atomic<std::int64_t> done{0};
  std::atomic<Clock::rep> next_due{0};  // Of the clock, in its ticks.
  std::mutex mutex;                     // Guards what follows, and the terminal.
  std::string note;
  double seconds_left = -1.0;
  bool finished = false;

  void Print(Clock::time_point now) {
    const std::int64_t count = done.load();
    const double seconds = std::chrono::duration<double>(now - start).count();
    const std::string text = ProgressText(count, total, seconds, note, seconds_left);
    if (!terminal) {
      LogInfo(title + ": " + text);
      return;
    }
    // A line that wraps could not be redrawn. Where it is too long the bar is what says least.
    const std::size_t room = TerminalWidth() - 1;
    std::string line = title + " " + BarText(count, total) + text;
    if (line.size() > room) line = title + " " + text;
    std::fprintf(stderr, "\r\033[K%s", line.substr(0, room).c_str());
    std::fflush(stderr);
  }
};

Progress::Progress(std::string title, std::int64_t total) : impl_(new Impl) {
  impl_->title = std::move(title);
  impl_->total = total;
  impl_->terminal = ::isatty(STDERR_FILENO) != 0;
  impl_->interval = impl_->terminal ? Clock::duration(kBarInterval) : Clock::duration(kLineInterval);
  impl_->start = Clock::now();
  impl_->next_due = (impl_->start + impl_->interval).time_since_epoch().count();
}

Progress::~Progress() {
  try {
    Finish();
  } catch (...) {
    // A progress line is never worth ending the program for.
  }
  delete impl_;
}

void Progress::Advance(std::int64_t count, const std::string& note, double seconds_left) {
  impl_->done += count;
  const Clock::time_point now = Clock::now();
  const bool due = now.time_since_epoch().count() >= impl_->next_due.load(std::memory_order_relaxed);
  if (!due && note.empty()) return;
  const std::lock_guard lock(impl_->mutex);
  if (!note.empty()) impl_->note = note;
  impl_->seconds_left = seconds_left;
  // Another thread may have printed in between.
  if (impl_->finished || now.time_since_epoch().count() < impl_->next_due) return;
  impl_->next_due = (now + impl_->interval).time_since_epoch().count();
  impl_->Print(now);
}

void Progress::Finish() {
  const std::lock_guard lock(impl_->mutex);
  if (impl_->finished) return;
  impl_->finished = true;
  impl_->Print(Clock::now());
  if (impl_->terminal) std::fputc('\n', stderr);
}

namespace {

spdlog::sink_ptr TerminalSink(bool quiet) {
  auto sink = std::make_shared<spdlog::sinks::stderr_color_sink_mt>();
  // On a terminal a line first wipes the progress bar that may stand there; the bar redraws itself.
  const std::string wipe = ::isatty(STDERR_FILENO) ? "\r\033[K" : "";
  sink->set_pattern(wipe + "[%H:%M:%S] [%^%l%$] %v");
  sink->set_level(quiet ? spdlog::level::warn : spdlog::level::info);
  return sink;
}

spdlog::sink_ptr FileSink(const std::string& file) {
  try {
    // Appends, so that a resumed run keeps what it logged before.
    auto sink = std::make_shared<spdlog::sinks::basic_file_sink_mt>(file, false);
    sink->set_pattern("[%Y-%m-%d %H:%M:%S.%e] [%l] %v");
    return sink;
  } catch (const spdlog::spdlog_ex& exception) {
    throw Error("cannot write the log file '" + file + "': " + exception.what());
  }
}

}  // namespace

void InitLogging(const std::string& file, bool quiet) {
  std::vector<spdlog::sink_ptr> sinks = {TerminalSink(quiet)};
  if (!file.empty()) sinks.push_back(FileSink(file));
  auto logger = std::make_shared<spdlog::logger>("diffsac", sinks.begin(), sinks.end());
  logger->set_level(spdlog::level::info);
  logger->flush_on(spdlog::level::info);
  spdlog::set_default_logger(std::move(logger));
  SetLog([](LogLevel level, const std::string& line) {
    spdlog::log(level == LogLevel::kWarning ? spdlog::level::warn : spdlog::level::info, "{}", line);
  });
}

}  // namespace diffsac
