#include "diffsac/eval/gnuplot.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "diffsac/core/files.h"
#include "diffsac/core/logging.h"

namespace diffsac {
namespace {

constexpr int kNotFound = 127;

// Runs gnuplot in a folder without a shell, so that no path needs quoting. Its messages are of no use to a reader.
int RunGnuplot(const std::string& folder, const std::vector<std::string>& arguments) {
  std::vector<char*> argv = {const_cast<char*>("gnuplot")};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  const pid_t child = ::fork();
  if (child < 0) return kNotFound;
  if (child == 0) {
    const int null = ::open("/dev/null", O_RDWR);
    ::dup2(null, STDIN_FILENO);
    ::dup2(null, STDOUT_FILENO);
    ::dup2(null, STDERR_FILENO);
    if (::chdir(folder.c_str()) == 0) ::execvp("gnuplot", argv.data());
    ::_exit(kNotFound);
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

// Not every gnuplot has the cairo terminal.
std::string Preamble(const std::string& name, int width, int height) {
  const std::string size = std::to_string(width) + "," + std::to_string(height);
  return "if (!exists(\"output\")) output = \"" + name + ".png\"\n" +
         "if (strstrt(GPVAL_TERMINALS, \"pngcairo\") > 0) {\n" +
         "  set terminal pngcairo noenhanced font \"DejaVu Sans,11\" size " + size + " background rgb \"white\"\n" +
         "} else {\n  set terminal png noenhanced font \"DejaVu Sans,11\" size " + size + "\n}\n" +
         "set output output\nset encoding utf8\nset style line 100 lc rgb \"#E0E0E0\" lw 1\n" +
         "set border lw 1 lc rgb \"#404040\"\nset tics textcolor rgb \"#404040\"\n";
}

}  // namespace

bool HasGnuplot() { return RunGnuplot(".", {"--version"}) == 0; }

bool DrawPicture(const std::string& folder, const std::string& name, const std::string& script, int width, int height) {
  namespace fs = std::filesystem;
  WriteFileAtomically((fs::path(folder) / (name + ".gp")).string(),
                      Preamble(name, width, height) + script + "\nunset output\n");
  const std::string temporary = "." + name + ".tmp.png";
  const int code = RunGnuplot(folder, {"-e", "output='" + temporary + "'", name + ".gp"});
  std::error_code error;
  if (code == 0) fs::rename(fs::path(folder) / temporary, fs::path(folder) / (name + ".png"), error);
  if (code == 0 && !error) return true;
  fs::remove(fs::path(folder) / temporary, error);
  LogWarning("no picture " + name + ".png: " +
             (code == kNotFound ? std::string("gnuplot was not found") : "gnuplot failed on " + name + ".gp"));
  return false;
}

std::string GnuplotText(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c == '\n' ? ' ' : c;
  }
  return out + "\"";
}

std::string GnuplotNumber(double value) {
  if (!std::isfinite(value)) return "NaN";
  char text[32];
  std::snprintf(text, sizeof(text), "%.7g", value);
  return text;
}

const char* SeriesColour(std::size_t index) {
  static constexpr std::array<const char*, kSeriesColours> kColours = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                                                       "#E69F00", "#56B4E9", "#555555"};
  return kColours[index % kColours.size()];
}

}  // namespace diffsac
