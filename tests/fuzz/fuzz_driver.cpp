// Runs a fuzz target without libFuzzer, so with any compiler: on given files, or on random bytes.

#include <chrono>
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

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Bytes = std::vector<std::uint8_t>;

struct Arguments {
  std::int64_t runs = 1000;
  double seconds = 0.0;               ///< when positive: instead of `runs`
  std::optional<std::uint64_t> seed;  ///< absent: another one each time
  std::string artifact;               ///< where each input lies while it runs
  std::vector<std::string> files;
};

[[noreturn]] void Usage() {
  std::fputs(
      "usage: estimate_fuzz_driver [--runs N | --seconds S] [--seed S] [--artifact FILE] [INPUT FILES...]\n"
      "  without files: random inputs, of another seed each time unless one is given; it is printed first, so that a\n"
      "  failure can be run again. FILE holds the input that runs, so the failing one after a crash.\n",
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

bool ReplayFiles(const std::vector<std::string>& files) {
  for (const std::string& path : files) {
    std::ifstream file(path, std::ios::binary);
    if (!file) {
      std::fprintf(stderr, "estimate_fuzz_driver: cannot read %s\n", path.c_str());
      return false;
    }
    const Bytes bytes((std::istreambuf_iterator<char>(file)), {});
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  }
  return true;
}

Bytes RandomBytes(diffsac::Rng rng) {
  Bytes bytes(64 + rng.Below(1024));
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(rng.Below(256));
  return bytes;
}

void Save(const std::string& path, const Bytes& bytes) {
  if (path.empty()) return;
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace

int main(int argc, char** argv) {
  const Arguments arguments = Parse(argc, argv);
  if (!arguments.files.empty()) return ReplayFiles(arguments.files) ? 0 : 1;
  const std::uint64_t seed = arguments.seed.value_or(std::random_device()());
  // At once and on standard error, so that a crash does not swallow it.
  std::fprintf(stderr, "estimate_fuzz_driver: --seed %llu\n", static_cast<unsigned long long>(seed));
  const diffsac::Rng rng(seed);
  const auto start = std::chrono::steady_clock::now();
  const auto elapsed = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
  std::int64_t run = 0;
  for (; arguments.seconds > 0.0 ? elapsed() < arguments.seconds : run < arguments.runs; ++run) {
    const Bytes bytes = RandomBytes(rng.Fork("input", static_cast<std::uint64_t>(run)));
    Save(arguments.artifact, bytes);
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  }
  if (!arguments.artifact.empty()) std::remove(arguments.artifact.c_str());
  std::printf("estimate_fuzz_driver: %lld inputs, no broken promise, %.1f s\n", static_cast<long long>(run), elapsed());
  return 0;
}
