#pragma once

#include <cstdint>
#include <limits>
#include <string_view>
#include <vector>

namespace diffsac {

/// Counter-based random numbers: Philox4x32-10 (Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC 2011).
///
/// A generator is a key and a counter. `Fork` derives an independent key from a name and a number, so every
/// problem, worker and purpose has its own stream, whatever order they run in. There is no global generator.
///
/// Example:
/// ```
/// Rng rng(seed);
/// Rng noise = rng.Fork("noise", problem_index);   // the same for any number of threads
/// double x = noise.Normal();
/// ```
class Rng {
 public:
  using result_type = std::uint64_t;

  explicit Rng(std::uint64_t seed = 0);

  /// An independent stream; depends on this generator's key only, never on how much was drawn from it.
  Rng Fork(std::string_view name, std::uint64_t id = 0) const;

  /// A new seed, for interfaces that take a number.
  std::uint64_t Seed() const { return key_; }

  std::uint64_t operator()() { return NextU64(); }
  static constexpr std::uint64_t min() { return 0; }
  static constexpr std::uint64_t max() { return std::numeric_limits<std::uint64_t>::max(); }

  std::uint64_t NextU64();
  /// Uniform in [0, 1), 53 bits.
  double Uniform();
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  /// Standard normal (Box-Muller; both values are used).
  double Normal();
  /// What the index-th call of Normal() gives where nothing else is drawn, from 0; wherever this generator stands.
  double NormalAt(std::uint64_t index) const;
  /// Uniform integer in [0, n), unbiased. n must be positive.
  std::uint64_t Below(std::uint64_t n);
  /// `count` distinct integers of [0, n) in random order, into `out`. count must not exceed n.
  void Distinct(int n, int count, int* out);
  /// A random permutation of 0..n-1.
  std::vector<int> Permutation(int n);

 private:
  void Refill();

  std::uint64_t key_;
  std::uint64_t counter_ = 0;
  std::uint64_t block_[2] = {0, 0};
  int left_ = 0;
  bool has_spare_normal_ = false;
  double spare_normal_ = 0.0;
};

}  // namespace diffsac
