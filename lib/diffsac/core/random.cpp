#include "diffsac/core/random.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "diffsac/core/philox.h"

namespace diffsac {
namespace {

constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15u;

/// The finaliser of splitmix64: a bijection that spreads every input bit over all output bits.
std::uint64_t Finalise(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}

/// FNV-1a, 64 bits: unlike std::hash the same everywhere.
std::uint64_t HashName(std::string_view name) {
  std::uint64_t hash = 0xCBF29CE484222325u;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3u;
  return hash;
}

bool UseRejection(int n, int count) {
  // Comparing with all earlier draws is quadratic in count; a redraw must be unlikely.
  constexpr int kMostCompared = 32;
  return count <= kMostCompared && count <= n / 2;
}

}  // namespace

Rng::Rng(std::uint64_t seed) : key_(seed) {}

Rng Rng::Fork(std::string_view name, std::uint64_t id) const {
  const std::uint64_t parent = Finalise(key_ + kGolden);
  const std::uint64_t named = Finalise((parent ^ HashName(name)) + kGolden);
  return Rng(Finalise(named + (id + 1) * kGolden));
}

void Rng::Refill() {
  const auto low = [](std::uint64_t x) { return static_cast<std::uint32_t>(x); };
  const auto high = [](std::uint64_t x) { return static_cast<std::uint32_t>(x >> 32); };
  const auto words = Philox4x32({low(counter_), high(counter_), 0, 0}, {low(key_), high(key_)});
  block_[0] = words[0] | (std::uint64_t{words[1]} << 32);
  block_[1] = words[2] | (std::uint64_t{words[3]} << 32);
  ++counter_;
  left_ = 2;
}

std::uint64_t Rng::NextU64() {
  if (left_ == 0) Refill();
  return block_[2 - left_--];
}

double Rng::Uniform() { return static_cast<double>(NextU64() >> 11) * 0x1.0p-53; }

double Rng::Normal() {
  if (has_spare_normal_) {
    has_spare_normal_ = false;
    return spare_normal_;
  }
  // 1 - u lies in (0, 1], where the logarithm is finite.
  const double radius = std::sqrt(-2.0 * std::log(1.0 - Uniform()));
  const double angle = 2.0 * std::numbers::pi * Uniform();
  spare_normal_ = radius * std::sin(angle);
  has_spare_normal_ = true;
  return radius * std::cos(angle);
}

double Rng::NormalAt(std::uint64_t index) const {
  Rng pair(key_);
  pair.counter_ = index / 2;  // a block of Philox makes two uniform values, these two normal ones
  const double first = pair.Normal();
  return index % 2 == 0 ? first : pair.Normal();
}

std::uint64_t Rng::Below(std::uint64_t n) {
  if (n == 0) throw std::invalid_argument("Rng::Below needs a positive n");
  // Lemire, "Fast random integer generation in an interval", TOMACS 2019: the high word of a product, redrawn when the
  // low word falls into the incomplete part.
  auto product = static_cast<unsigned __int128>(NextU64()) * n;
  if (static_cast<std::uint64_t>(product) < n) {
    const std::uint64_t incomplete = (0 - n) % n;
    while (static_cast<std::uint64_t>(product) < incomplete) {
      product = static_cast<unsigned __int128>(NextU64()) * n;
    }
  }
  return static_cast<std::uint64_t>(product >> 64);
}

void Rng::Distinct(int n, int count, int* out) {
  if (count < 0 || count > n) throw std::invalid_argument("Rng::Distinct needs 0 <= count <= n");
  if (UseRejection(n, count)) {
    for (int i = 0; i < count; ++i) {
      do {
        out[i] = static_cast<int>(Below(static_cast<std::uint64_t>(n)));
      } while (std::find(out, out + i, out[i]) != out + i);
    }
    return;
  }
  // The first `count` steps of a Fisher-Yates shuffle.
  std::vector<int> values(static_cast<std::size_t>(n));
  std::iota(values.begin(), values.end(), 0);
  for (int i = 0; i < count; ++i) {
    const int j = i + static_cast<int>(Below(static_cast<std::uint64_t>(n - i)));
    std::swap(values[i], values[j]);
    out[i] = values[i];
  }
}

std::vector<int> Rng::Permutation(int n) {
  std::vector<int> permutation(static_cast<std::size_t>(std::max(n, 0)));
  std::iota(permutation.begin(), permutation.end(), 0);
  for (int i = 0; i + 1 < n; ++i) {
    std::swap(permutation[i], permutation[i + static_cast<int>(Below(static_cast<std::uint64_t>(n - i)))]);
  }
  return permutation;
}

}  // namespace diffsac
