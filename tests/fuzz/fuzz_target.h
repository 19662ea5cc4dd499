#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "diffsac/core/status.h"

namespace diffsac::testing {

/// What hostile bytes are given to.
struct FuzzTarget {
  std::vector<std::string> (*seeds)();    ///< Valid inputs: those of seeds/, or what the program's own writers make.
  void (*run)(const std::string& bytes);  ///< Ends the program where a promise is broken.
};

/// The targets of this program, by name.
std::map<std::string, FuzzTarget>& FuzzTargets();

/// Adds one before main begins.
struct AddTarget {
  AddTarget(const char* name, std::vector<std::string> (*seeds)(), void (*run)(const std::string& bytes)) {
    FuzzTargets()[name] = {seeds, run};
  }
};

/// The inputs that tests/fuzz/seeds/NAME holds, between lines "==== seed".
std::vector<std::string> SeedsIn(const std::string& name);
/// The files below a folder whose name ends so, of at most `largest` bytes.
std::vector<std::string> FilesBelow(const std::string& folder, const std::string& ending, std::size_t largest);

/// Ends the program, with `what`, unless `holds`.
void Require(bool holds, const std::string& what);

/// Says it on standard error where the environment has DIFFSAC_FUZZ_VERBOSE.
void Note(const std::string& message);

/// A folder of this process in memory (/dev/shm, or else where temporary files go); it goes when the program ends.
const std::string& Scratch();
/// Writes a file of Scratch(), with the folders before it, and returns its path.
std::string WriteScratch(const std::string& name, std::string_view content);

/// Runs what parses hostile input: it may throw Error with one of `names` (of files) in its message, and nothing else.
/// True when it threw nothing.
template <class Call>
bool Parses(const std::vector<std::string>& names, Call call) {
  try {
    call();
    return true;
  } catch (const Error& error) {
    const std::string message = error.what();
    Note(message);
    bool named = names.empty();
    for (const std::string& name : names) named = named || message.find(name) != std::string::npos;
    Require(named, "an error names the file: " + message);
  } catch (const std::exception& error) {
    Require(false, std::string("only Error is thrown, not: ") + error.what());
  }
  return false;
}

/// Several files in one input, in the manner of `head`: a first line, then for each file "==> NAME <==" and its lines.
struct Bundle {
  struct File {
    std::string name, content;
  };
  std::string kind;  ///< The first line.
  std::vector<File> files;

  /// The content of a file; null pointer where there is none.
  const std::string* Find(const std::string& name) const;
};

/// At most 24 files; those whose names are no plain relative paths are left out.
Bundle ParseBundle(std::string_view text);
std::string BundleText(const Bundle& bundle);
/// Writes the files to an emptied Scratch(). A file that is the word "image" alone becomes a small picture.
void WriteBundle(const Bundle& bundle);

}  // namespace diffsac::testing
