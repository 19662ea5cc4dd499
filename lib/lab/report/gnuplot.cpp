#include "lab/report/gnuplot.h"

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
#include "lab/files/own_pictures.h"

namespace diffsac {
namespace {

constexpr int kNotFound = 127;

// What comes out of a pipe until its other end is closed.
std::string ReadAll(int descriptor) {
  std::string content;
  std::array<char, 1 << 16> buffer;
  for (;;) {
    const ssize_t count = ::read(descriptor, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return content;
    content.append(buffer.data(), static_cast<std::size_t>(count));
  }
}

// Runs gnuplot in a folder without a shell, so that no path needs quoting. Its messages are of no use to a reader. What
// it prints comes through a pipe and not through a file: when this process is killed, gnuplot leaves nothing behind.
int RunGnuplot(const std::string& folder, const std::vector<std::string>& arguments, std::string* printed = nullptr) {
  std::vector<char*> argv = {const_cast<char*>("gnuplot")};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return kNotFound;
  const pid_t child = ::fork();
  if (child == 0) {
    const int null = ::open("/dev/null", O_RDWR);
    ::dup2(null, STDIN_FILENO);
    ::dup2(ends[1], STDOUT_FILENO);
    ::dup2(null, STDERR_FILENO);
    if (::chdir(folder.c_str()) == 0) ::execvp("gnuplot", argv.data());
    ::_exit(kNotFound);
  }
  ::close(ends[1]);
  const std::string output = child < 0 ? std::string() : ReadAll(ends[0]);
  ::close(ends[0]);
  if (child < 0) return kNotFound;
  if (printed != nullptr) *printed = output;
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
  std::string picture;
  const int code = RunGnuplot(folder, {"-e", "output='/dev/stdout'", name + ".gp"}, &picture);
  if (code == 0 && picture.starts_with("\x89PNG")) {
    WriteFileAtomically((fs::path(folder) / (name + ".png")).string(), MarkedAsOwn(picture));
    return true;
  }
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

}  // namespace diffsac
