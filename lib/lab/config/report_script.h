#pragma once

#include <functional>
#include <string>
#include <vector>

namespace diffsac {

/// One of scripts/report (of share/diffsac beside the running program), which draw pictures and write pages from what a
/// run left in its folder. It is run by the first python3 that has their modules. That there is none, or that it fails
/// otherwise than by a disk, is one line in the log: the numbers are there already. It dies with this process, so that
/// it writes nothing later.
class ReportScript {
 public:
  ReportScript() = default;
  ReportScript(const ReportScript&) = delete;
  ReportScript& operator=(const ReportScript&) = delete;
  ~ReportScript() { Stop(); }

  /// Starts a script of this name; one that runs already is stopped. Last of the arguments: the folder it writes to.
  void Start(const std::string& name, const std::vector<std::string>& arguments);
  /// Whether it has not ended yet.
  bool Runs();
  /// Waits for its end, and removes what scripts that were killed left half written. True where it was started and
  /// succeeded. Throws Error where it cannot write a file.
  bool Wait();
  /// Ends it now.
  void Stop();

 private:
  int process_ = -1, output_ = -1;
  std::string folder_;
};

/// Starts it and waits for its end.
bool RunReportScript(const std::string& name, const std::vector<std::string>& arguments);

/// Whether a python3 has their modules.
bool HasReportPython();

/// Runs another Python script, of share/diffsac, by the same python3. What it says last is the Error where it fails.
void RunPythonScript(const std::string& shared_file, const std::vector<std::string>& arguments);

/// What convert.py's `format` makes of a file: `read` gets the name of a text file, which is gone afterwards. Throws
/// Error.
void ReadConverted(const std::string& format, const std::string& file,
                   const std::function<void(const std::string& text)>& read);

/// The page of a folder of diffsac_pair, in place of an earlier one.
bool WriteReport(const std::string& folder);

/// The file of a run's folder that is there to be looked at.
inline constexpr const char* kReportFile = "report.html";

}  // namespace diffsac
