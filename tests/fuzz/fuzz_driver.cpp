// Runs a fuzz target without libFuzzer, so with any compiler: on given files, or on changed seeds.

#include <sys/resource.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "diffsac/core/random.h"
#include "fuzz/fuzz_target.h"

namespace {

using diffsac::Rng;
using diffsac::testing::FuzzTarget;

// What a target promises (docs/reliability.md).
constexpr unsigned kMostSeconds = 10;           // of the processor, so that other work on it does not count
constexpr unsigned kMostWaiting = 120;          // of the clock: an input that waits
constexpr rlim_t kMostBytes = rlim_t{2} << 30;  // beside what the program has when it starts

struct Arguments {
  std::int64_t runs = 1000;
  double seconds = 0.0;               ///< when positive: instead of `runs`
  std::optional<std::uint64_t> seed;  ///< absent: another one each time
  std::string artifact;               ///< where each input lies while it runs
  std::string target;
  std::vector<std::string> files;
};

[[noreturn]] void Usage() {
  std::fputs(
      "usage: PROGRAM TARGET [--runs N | --seconds S] [--seed S] [--artifact FILE] [INPUT FILES...]\n"
      "  without files: changed seeds and random bytes, of another seed each time unless one is given; it is printed\n"
      "  first, so that a failure can be run again. FILE holds the input that runs, so the failing one after a "
      "crash.\n",
      stderr);
  for (const auto& [name, target] : diffsac::testing::FuzzTargets())
    std::fprintf(stderr, "  target: %s\n", name.c_str());
  std::exit(2);
}

Arguments Parse(int argc, char** argv) {
  Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name.rfind("--", 0) != 0) {
      (arguments.target.empty() ? arguments.target : arguments.files.emplace_back()) = name;
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

// What numbers of files are replaced by.
constexpr const char* kNumbers[] = {"0",
                                    "-1",
                                    "1",
                                    "2",
                                    "2147483647",
                                    "-2147483648",
                                    "1e9",
                                    "1e18",
                                    "nan",
                                    "-inf",
                                    "18446744073709551616",
                                    "4294967296",
                                    "1e308",
                                    "0.5",
                                    "-0",
                                    "1e-320",
                                    "99999999999999999999999",
                                    ""};
constexpr std::uint64_t kWords[] = {0,
                                    1,
                                    0xff,
                                    0x7f,
                                    0x7fff,
                                    0xffff,
                                    0x7fffffff,
                                    0xffffffff,
                                    0x100000000ull,
                                    0x7fffffffffffffffull,
                                    0xffffffffffffffffull,
                                    0x7ff0000000000000ull,
                                    1u << 20,
                                    1u << 30};

// One to eight random changes of one of the seeds: bits, bytes, numbers in text and in memory, pieces that go, come
// twice or come from another seed, a cut end. Without seeds, and now and then with them, random bytes.
class Mutator {
 public:
  Mutator(const std::vector<std::string>& seeds, Rng rng) : seeds_(seeds), rng_(rng) {}

  std::string Input() {
    if (seeds_.empty() || rng_.Below(32) == 0) return RandomBytes(64 + rng_.Below(1024));
    std::string input = AnySeed();
    // A seed as it stands is an input, too.
    for (int times = static_cast<int>(rng_.Below(9)); times > 0 && !input.empty(); --times) Change(&input);
    return input;
  }

 private:
  const std::string& AnySeed() { return seeds_[rng_.Below(seeds_.size())]; }
  std::size_t Place(const std::string& input) { return rng_.Below(input.size()); }
  std::size_t Length(const std::string& input, std::size_t from) {
    return 1 + rng_.Below(std::min<std::size_t>(input.size() - from, rng_.Below(4) == 0 ? 4096 : 32));
  }
  std::string RandomBytes(std::size_t count) {
    std::string bytes(count, '\0');
    for (char& byte : bytes) byte = static_cast<char>(rng_.Below(256));
    return bytes;
  }

  void Change(std::string* input) {
    const std::size_t at = Place(*input), length = Length(*input, at);
    switch (rng_.Below(10)) {
      case 0:
        (*input)[at] = static_cast<char>((*input)[at] ^ (1 << rng_.Below(8)));
        return;
      case 1:
        (*input)[at] = static_cast<char>(rng_.Below(256));
        return;
      case 2:
        input->insert(at, RandomBytes(1 + rng_.Below(8)));
        return;
      case 3:
        input->erase(at, length);
        return;
      case 4:
        input->insert(Place(*input), input->substr(at, length));
        return;
      case 5: {
        const std::string& other = AnySeed();
        if (!other.empty()) input->replace(at, length, other.substr(Place(other), length));
        return;
      }
      case 6:
        if (rng_.Below(4) == 0) input->resize(at);
        return;
      case 7:
        return PutWord(at, input);
      default:
        return ReplaceNumber(at, input);
    }
  }

  void PutWord(std::size_t at, std::string* input) {
    const std::uint64_t word = kWords[rng_.Below(std::size(kWords))];
    const std::size_t size = std::min<std::size_t>(input->size() - at, std::size_t{1} << rng_.Below(4));
    std::memcpy(input->data() + at, &word, size);
  }

  // The first number behind a place.
  void ReplaceNumber(std::size_t at, std::string* input) {
    const auto is_digit = [](unsigned char c) { return std::isdigit(c) != 0; };
    const auto begin = std::find_if(input->begin() + static_cast<std::ptrdiff_t>(at), input->end(), is_digit);
    if (begin == input->end()) return;
    const auto end = std::find_if_not(begin, input->end(), [&](unsigned char c) { return is_digit(c) || c == '.'; });
    input->replace(begin, end, kNumbers[rng_.Below(std::size(kNumbers))]);
  }

  const std::vector<std::string>& seeds_;
  Rng rng_;
};

void Run(const FuzzTarget& target, const std::string& bytes) {
  const itimerval limit{{0, 0}, {kMostSeconds, 0}}, none{};
  ::setitimer(ITIMER_PROF, &limit, nullptr);
  ::alarm(kMostWaiting);
  target.run(bytes);
  ::alarm(0);
  ::setitimer(ITIMER_PROF, &none, nullptr);
}

bool ReplayFiles(const FuzzTarget& target, const std::vector<std::string>& files) {
  for (const std::string& path : files) {
    std::ifstream file(path, std::ios::binary);
    if (!file) {
      std::fprintf(stderr, "fuzz: cannot read %s\n", path.c_str());
      return false;
    }
    Run(target, std::string((std::istreambuf_iterator<char>(file)), {}));
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
  if (!diffsac::testing::FuzzTargets().contains(arguments.target)) Usage();
  const FuzzTarget& target = diffsac::testing::FuzzTargets().at(arguments.target);
  std::signal(SIGALRM, TooSlow);
  std::signal(SIGPROF, TooSlow);
  if (!arguments.files.empty()) return ReplayFiles(target, arguments.files) ? 0 : 1;
  const std::uint64_t seed = arguments.seed.value_or(std::random_device()());
  // At once and on standard error, so that a crash does not swallow it.
  std::fprintf(stderr, "fuzz: --seed %llu\n", static_cast<unsigned long long>(seed));
  const std::vector<std::string> seeds = target.seeds();
  LimitMemory();
  const Rng rng(seed);
  const auto start = std::chrono::steady_clock::now();
  const auto elapsed = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
  // The seeds as they are come first.
  std::int64_t run = 0;
  for (; run < static_cast<std::int64_t>(seeds.size()); ++run) {
    Save(arguments.artifact, seeds[static_cast<std::size_t>(run)]);
    Run(target, seeds[static_cast<std::size_t>(run)]);
  }
  for (; arguments.seconds > 0.0 ? elapsed() < arguments.seconds : run < arguments.runs; ++run) {
    const std::string bytes = Mutator(seeds, rng.Fork("input", static_cast<std::uint64_t>(run))).Input();
    Save(arguments.artifact, bytes);
    Run(target, bytes);
  }
  if (!arguments.artifact.empty()) std::remove(arguments.artifact.c_str());
  std::printf("fuzz: %lld inputs, no broken promise, %.1f s\n", static_cast<long long>(run), elapsed());
  return 0;
}
