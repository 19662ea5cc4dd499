#include "lab/config/report_script.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <filesystem>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "lab/config/paths.h"
#include "lab/config/process.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

constexpr int kCannotWrite = 4;  // scripts/report/files.py.

// Starts it with the end of a pipe that has what it says.
int Spawn(const std::vector<std::string>& words, int* output) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return -1;
  const int child = StartProgram(words, ends[1], SIGKILL);
  ::close(ends[1]);
  if (child < 0) ::close(ends[0]);
  *output = ends[0];
  return child;
}

// What comes out of a pipe until its other end is closed, of which the last line says most.
std::string LastLine(int descriptor) {
  std::string text;
  std::array<char, 4096> buffer;
  for (;;) {
    const ssize_t count = ::read(descriptor, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    text.append(buffer.data(), static_cast<std::size_t>(count));
  }
  const std::size_t last = text.find_last_not_of(" \n");
  if (last == std::string::npos) return "";
  text.resize(last + 1);
  return text.substr(text.rfind('\n') + 1);
}

// The python3 of an environment may lack modules that the system's has. Empty without any.
std::string FindPython() {
  const std::string check = SharedFile("report/check_modules.py");
  for (const char* python : {"python3", "/usr/bin/python3"}) {
    int output = -1;
    const int process = Spawn({python, "-B", check}, &output);
    if (process < 0) continue;
    LastLine(output);
    ::close(output);
    if (EndOfProgram(process) == 0) return python;
  }
  return "";
}

/// Throws Error without any.
const std::string& Python() {
  static const std::string python = FindPython();
  if (python.empty())
    throw Error(
        "no python3 with matplotlib, jinja2, pandas, h5py, yaml, scipy and PIL was found (Debian: python3-matplotlib "
        "python3-jinja2 python3-pandas python3-h5py python3-yaml python3-scipy python3-pil)");
  return python;
}

}  // namespace

void ReportScript::Start(const std::string& name, const std::vector<std::string>& arguments) {
  Stop();
  try {
    std::vector<std::string> words = {Python(), "-B", SharedFile("report/" + name)};
    words.insert(words.end(), arguments.begin(), arguments.end());
    folder_ = words.back();
    process_ = Spawn(words, &output_);
  } catch (const Error& error) {
    LogWarning(std::string("no pictures and no page: ") + error.what());
  }
}

bool ReportScript::Runs() {
  if (process_ < 0) return false;
  siginfo_t state{};
  return ::waitid(P_PID, static_cast<id_t>(process_), &state, WEXITED | WNOHANG | WNOWAIT) == 0 && state.si_pid == 0;
}

bool ReportScript::Wait() {
  if (process_ < 0) return false;
  const std::string said = LastLine(output_);
  ::close(output_);
  const int code = EndOfProgram(process_);
  process_ = -1;
  RemoveLeftOver(folder_);
  if (code == kCannotWrite) throw Error(said);
  if (code != 0) LogWarning(folder_ + ": no pictures or no page: " + (said.empty() ? "the script was stopped" : said));
  return code == 0;
}

void ReportScript::Stop() {
  if (process_ < 0) return;
  ::kill(process_, SIGKILL);
  ::close(output_);
  EndOfProgram(process_);
  process_ = -1;
}

bool RunReportScript(const std::string& name, const std::vector<std::string>& arguments) {
  ReportScript script;
  script.Start(name, arguments);
  return script.Wait();
}

bool HasReportPython() {
  try {
    Python();
    return true;
  } catch (const Error&) {
    return false;
  }
}

void RunPythonScript(const std::string& shared_file, const std::vector<std::string>& arguments) {
  std::vector<std::string> words = {Python(), "-B", SharedFile(shared_file)};
  words.insert(words.end(), arguments.begin(), arguments.end());
  int output = -1;
  const int process = Spawn(words, &output);
  if (process < 0) throw Error(shared_file + ": cannot be started");
  const std::string said = LastLine(output);
  ::close(output);
  if (EndOfProgram(process) != 0) throw Error(said.empty() ? shared_file + ": was stopped" : said);
}

void ReadConverted(const std::string& format, const std::string& file,
                   const std::function<void(const std::string& text)>& read) {
  const std::string text = TemporaryBeside(std::filesystem::temp_directory_path() / "converted.csv");
  RunPythonScript("convert.py", {format, file, text});
  read(text);
  RemoveFile(text);
}

bool WriteReport(const std::string& folder) {
  RemoveFile((std::filesystem::path(folder) / kReportFile).string());  // An earlier run's.
  return RunReportScript("__main__.py", {folder});
}

}  // namespace diffsac
