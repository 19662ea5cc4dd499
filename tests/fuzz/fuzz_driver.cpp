// Runs a fuzz target without libFuzzer, so with any compiler: on given files, or on changed seeds.

#include <sys/resource.h>
#include <sys/time.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "diffsac/core/random.h"
#include "fuzz/fuzz_target.h"
#include "fuzz/mutate.h"

namespace {

// What a target promises (docs/reliability.md).
constexpr unsigned kMostSeconds = 10;           // of the processor, so that other work on it does not count
constexpr unsigned kMostWaiting = 120;          // of the clock: an input that waits
constexpr rlim_t kMostBytes = rlim_t{2} << 30;  // beside what the program has when it starts

struct Arguments {
  std::int64_t runs = 1000;
  double seconds = 0.0;               ///< when positive: instead of `runs`
  std::optional<std::uint64_t> seed;  ///< absent: another one each time
  std::string artifact;               ///< where each input lies while it runs
  std::vector<std::string> files;
};

[[noreturn]] void Usage() {
  std::fputs(
      "usage: NAME_fuzz_driver [--runs N | --seconds S] [--seed S] [--artifact FILE] [INPUT FILES...]\n"
      "  without files: changed seeds and random bytes, of another seed each time unless one is given; it is printed\n"
      "  first, so that a failure can be run again. FILE holds the input that runs, so the failing one after a "
      "crash.\n",
      stderr);
  std::exit(2);
}

Arguments Parse(int argc, char** argv) {
  Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name.rfind("--", 0) != 0) {
      arguments.files.push_back(name);
      continue;
    }
    if (++i == argc) Usage();
    const char* value = argv[i];
    char* end = nullptr;
    if (name == "--runs") {
      arguments.runs = std::strtoll(value, &end, 10);
    } else if (name == "--seconds") {
      arguments.seconds = std::strtod(value, &end);
    } else if (name == "--seed") {
      arguments.seed = std::strtoull(value, &end, 10);
    } else if (name == "--artifact") {
      arguments.artifact = value;
      continue;
    } else {
      Usage();
    }
    if (end == value || *end != '\0') Usage();
  }
  return arguments;
}

void Run(const std::string& bytes) {
  const itimerval limit{{0, 0}, {kMostSeconds, 0}}, none{};
  ::setitimer(ITIMER_PROF, &limit, nullptr);
  ::alarm(kMostWaiting);
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  ::alarm(0);
  ::setitimer(ITIMER_PROF, &none, nullptr);
}

bool ReplayFiles(const std::vector<std::string>& files) {
  for (const std::string& path : files) {
    std::ifstream file(path, std::ios::binary);
    if (!file) {
      std::fprintf(stderr, "fuzz: cannot read %s\n", path.c_str());
      return false;
    }
    Run(std::string((std::istreambuf_iterator<char>(file)), {}));
  }
  return true;
}

void Save(const std::string& path, const std::string& bytes) {
  if (path.empty()) return;
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

void TooSlow(int) {
  constexpr char kText[] = "fuzz: broken promise: an input takes longer than 10 s\n";
  if (::write(STDERR_FILENO, kText, sizeof kText - 1) < 0) std::_Exit(1);
  std::abort();
}

// A request beyond it fails, with an exception that no target lets pass. Sanitizers reserve more than there is.
void LimitMemory() {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  std::ifstream file("/proc/self/statm");
  rlim_t pages = 0;
  if (!(file >> pages)) return;
  const rlim_t bytes = pages * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE)) + kMostBytes;
  const rlimit limit{bytes, bytes};
  ::setrlimit(RLIMIT_AS, &limit);
#endif
}

}  // namespace

int main(int argc, char** argv) {
  const Arguments arguments = Parse(argc, argv);
  std::signal(SIGALRM, TooSlow);
  std::signal(SIGPROF, TooSlow);
  if (!arguments.files.empty()) return ReplayFiles(arguments.files) ? 0 : 1;
  const std::uint64_t seed = arguments.seed.value_or(std::random_device()());
  // At once and on standard error, so that a crash does not swallow it.
  std::fprintf(stderr, "fuzz: --seed %llu\n", static_cast<unsigned long long>(seed));
  const std::vector<std::string> seeds = diffsac::testing::Seeds();
  LimitMemory();
  const diffsac::Rng rng(seed);
  const auto start = std::chrono::steady_clock::now();
  const auto elapsed = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
  // The seeds as they are come first.
  std::int64_t run = 0;
  for (; run < static_cast<std::int64_t>(seeds.size()); ++run) {
    Save(arguments.artifact, seeds[static_cast<std::size_t>(run)]);
    Run(seeds[static_cast<std::size_t>(run)]);
  }
  for (; arguments.seconds > 0.0 ? elapsed() < arguments.seconds : run < arguments.runs; ++run) {
    const std::string bytes = diffsac::testing::MutatedInput(seeds, rng.Fork("input", static_cast<std::uint64_t>(run)));
    Save(arguments.artifact, bytes);
    Run(bytes);
  }
  if (!arguments.artifact.empty()) std::remove(arguments.artifact.c_str());
  std::printf("fuzz: %lld inputs, no broken promise, %.1f s\n", static_cast<long long>(run), elapsed());
  return 0;
}
