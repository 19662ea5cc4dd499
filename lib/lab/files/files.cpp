#include "lab/files/files.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>
#include <iterator>
#include <mutex>
#include <set>

#include "diffsac/core/status.h"

namespace diffsac {

namespace fs = std::filesystem;

namespace {

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

namespace {

[[noreturn]] void Fail(const std::string& what, const std::string& path, const std::string& cause) {
  throw Error("cannot " + what + " '" + path + "': " + cause);
}

[[noreturn]] void FailWithErrno(const std::string& what, const std::string& path) {
  const int code = errno;
  Fail(what, path, std::strerror(code));
}

/// Closes a file descriptor at the end of a scope.
class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  ~Descriptor() {
    if (value_ >= 0) ::close(value_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int value() const { return value_; }
  /// Some file systems report a full disk only here.
  bool Close() {
    const int value = value_;
    value_ = -1;
    return ::close(value) == 0;
  }

 private:
  int value_;
};

/// Removes a file at the end of a scope unless it was kept.
class RemovedUnlessKept {
 public:
  explicit RemovedUnlessKept(std::string path) : path_(std::move(path)) {}
  ~RemovedUnlessKept() {
    if (!path_.empty()) ::unlink(path_.c_str());
  }
  RemovedUnlessKept(const RemovedUnlessKept&) = delete;
  RemovedUnlessKept& operator=(const RemovedUnlessKept&) = delete;
  void Keep() { path_.clear(); }

 private:
  std::string path_;
};

void WriteAll(int descriptor, std::string_view content, const std::string& path) {
  while (!content.empty()) {
    const ssize_t written = ::write(descriptor, content.data(), content.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) FailWithErrno("write", path);
    content.remove_prefix(static_cast<std::size_t>(written));
  }
}

/// Writes and closes; `path` is the name for messages.
void WriteContent(const std::string& file, int flags, std::string_view content, const std::string& path) {
  Descriptor out(::open(file.c_str(), O_WRONLY | O_CLOEXEC | flags, 0666));
  if (out.value() < 0) FailWithErrno("write", path);
  WriteAll(out.value(), content, path);
  if (!out.Close()) FailWithErrno("write", path);
}

void Sync(const std::string& file, int flags, const std::string& path) {
  Descriptor opened(::open(file.c_str(), O_RDONLY | O_CLOEXEC | flags));
  if (opened.value() < 0) FailWithErrno("write", path);
  // Some network file systems cannot sync folders; the data is as safe there as it can be.
  if (::fsync(opened.value()) != 0 && errno != EINVAL && errno != ENOTSUP) FailWithErrno("write", path);
}

std::string FirstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

void CallWriter(const std::function<void(const std::string&)>& write, const std::string& file,
                const std::string& path) {
  try {
    write(file);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& exception) {
    Fail("write", path, FirstLine(exception.what()));
  }
}

/// What a rename must replace: the file behind a symbolic link.
fs::path Target(const std::string& path) {
  std::error_code code;
  return fs::is_symlink(path, code) ? fs::weakly_canonical(path, code) : fs::path(path);
}

void WriteThroughTemporary(const std::string& path, const std::function<void(const std::string&)>& write) {
  const fs::path target = Target(path);
  const std::string temporary = TemporaryBeside(target);
  RemovedUnlessKept guard(temporary);
  write(temporary);
  Sync(temporary, 0, path);
  if (::rename(temporary.c_str(), target.c_str()) != 0) FailWithErrno("write", path);
  guard.Keep();
  Sync(target.has_parent_path() ? target.parent_path().string() : ".", O_DIRECTORY, path);
}

/// Devices and pipes are written in place: a rename would replace the device itself.
bool IsDevice(const std::string& path) {
  struct stat info;
  if (::stat(path.c_str(), &info) != 0) return false;
  if (S_ISDIR(info.st_mode)) Fail("write", path, "it is a folder");
  return !S_ISREG(info.st_mode);
}

/// The encoding that the first bytes are of; empty for one byte a letter, as in UTF-8.
std::string WideEncoding(std::string_view text) {
  using namespace std::string_view_literals;
  for (const auto& [mark, name] : {std::pair("\xFF\xFE\0\0"sv, "UTF-32LE"), std::pair("\0\0\xFE\xFF"sv, "UTF-32BE"),
                                   std::pair("\xFF\xFE"sv, "UTF-16LE"), std::pair("\xFE\xFF"sv, "UTF-16BE")})
    if (text.starts_with(mark)) return name;
  // Without a mark: letters of ASCII have a zero beside them.
  if (text.size() < 4 || text.size() % 2 != 0 || (text[0] == '\0') == (text[1] == '\0')) return "";
  const std::size_t zero = text[0] == '\0' ? 0 : 1;
  if (text[zero + 2] != '\0' || text[3 - zero] == '\0') return "";
  return zero == 0 ? "UTF-16BE" : "UTF-16LE";
}

bool IsOneFile(const fs::path& a, const fs::path& b) {
  std::error_code code;
  if (fs::equivalent(a, b, code)) return fs::is_regular_file(a, code);
  // One of them is not there yet.
  return !fs::exists(a, code) && !fs::exists(b, code) && fs::weakly_canonical(a, code) == fs::weakly_canonical(b, code);
}

bool LiesIn(const fs::path& file, const fs::path& folder) {
  std::error_code code;
  if (!fs::is_directory(folder, code) || !fs::exists(file, code)) return false;
  for (fs::directory_iterator at(folder, code), end; !code && at != end; at.increment(code))
    if (IsOneFile(file, at->path())) return true;
  return false;
}

}  // namespace

void WriteFileAtomically(const std::string& path, std::string_view content) {
  if (IsDevice(path)) return WriteContent(path, 0, content, path);
  WriteThroughTemporary(
      path, [&](const std::string& temporary) { WriteContent(temporary, O_CREAT | O_EXCL, content, path); });
}

void WriteFileAtomically(const std::string& path, const std::function<void(const std::string& temporary)>& write) {
  if (IsDevice(path)) return CallWriter(write, path, path);
  WriteThroughTemporary(path, [&](const std::string& temporary) { CallWriter(write, temporary, path); });
}

std::string ReadFile(const std::string& path) {
  Descriptor in(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (in.value() < 0) FailWithErrno("read", path);
  std::string content;
  char buffer[1 << 16];
  for (;;) {
    const ssize_t count = ::read(in.value(), buffer, sizeof(buffer));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) FailWithErrno("read", path);
    if (count == 0) return content;
    content.append(buffer, static_cast<std::size_t>(count));
  }
}

std::string ReadTextFile(const std::string& path) {
  std::string text = ReadFile(path);
  if (const std::string encoding = WideEncoding(text); !encoding.empty())
    throw Error(path + ": its encoding is " + encoding + "; expected UTF-8: iconv -f " + encoding.substr(0, 6) +
                " -t UTF-8, or 'CSV UTF-8' where a spreadsheet saves it");
  if (const std::size_t zero = text.find('\0'); zero != std::string::npos)
    throw Error(path + ":" + std::to_string(1 + std::count(text.begin(), text.begin() + zero, '\n')) +
                ": a zero byte: damaged, or no text");
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  if (text.find('\n') == std::string::npos) std::replace(text.begin(), text.end(), '\r', '\n');
  return text;
}

void RefuseInputsAsOutputs(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs) {
  for (auto output = outputs.begin(); output != outputs.end(); ++output) {
    if (output->empty()) continue;
    for (const std::string& input : inputs)
      if (!input.empty() && (IsOneFile(*output, input) || LiesIn(*output, input)))
        throw Error("'" + *output + "' would be written over " +
                    (IsOneFile(*output, input) ? "an input, '" : "a file of an input, '") + input + "'");
    for (auto other = outputs.begin(); other != output; ++other)
      if (!other->empty() && IsOneFile(*output, *other))
        throw Error("'" + *other + "' and '" + *output + "' are one file, and both would be written");
  }
}

void RemoveFile(const std::string& path) {
  if (::unlink(path.c_str()) != 0 && errno != ENOENT && errno != ENOTDIR) FailWithErrno("remove", path);
}

void MakeWritableFolder(const std::string& path) {
  std::error_code code;
  fs::create_directories(path, code);
  if (code) Fail("create the folder", path, code.message());
  const std::string trial = TemporaryBeside(fs::path(path) / "trial");
  RemovedUnlessKept guard(trial);
  // A byte, because a full disk can still hold empty files.
  WriteContent(trial, O_CREAT | O_EXCL, "x", path);
}

}  // namespace diffsac
