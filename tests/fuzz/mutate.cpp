#include "fuzz/mutate.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstring>

namespace diffsac::testing {
namespace {

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

}  // namespace

std::string MutatedInput(const std::vector<std::string>& seeds, Rng rng) { return Mutator(seeds, rng).Input(); }

}  // namespace diffsac::testing
