#include "lab/config/yaml.h"

#include <catch2/catch.hpp>

namespace diffsac {
namespace {

/// "key: before -> now" of each, "-" where there is none.
std::vector<std::string> Texts(const std::string& before, const std::string& now) {
  std::vector<std::string> texts;
  for (const ChangedKey& key : ChangedKeys(before, now))
    texts.push_back(key.key + ": " + key.before.value_or("-") + " -> " + key.now.value_or("-"));
  return texts;
}

using Lines = std::vector<std::string>;

TEST_CASE("keys that differ are named with both values, in the order of the document") {
  CHECK(Texts("name: a\ntrain: {steps: 3, batch: 8}\n", "train: {batch: 16, steps: 3}\nname: b\n") ==
        Lines{"name: a -> b", "train.batch: 8 -> 16"});
  CHECK(Texts("a: 1\nb: 2\n", "b: 2\nc: {d: 3}\n") == Lines{"a: 1 -> -", "c.d: - -> 3"});
}

TEST_CASE("equal documents differ in nothing, however they are written") {
  CHECK(Texts("a: {b: [1, 2]}\n", "# a comment\na:\n  b:\n    - 1\n    - 2\n").empty());
  CHECK(Texts("", "").empty());
  CHECK(Texts("a: ~\nb: []\n", "a: ~\nb: []\n").empty());
}

TEST_CASE("a list of plain values is one value, of maps each counts by its name or place") {
  CHECK(Texts("ratios: [0.2, 0.5]\n", "ratios: [0.5]\n") == Lines{"ratios: [0.2, 0.5] -> [0.5]"});
  CHECK(Texts("methods: [{name: x, seed: 1}, {name: y, seed: 1}]\n",
              "methods: [{name: y, seed: 2}, {name: x, seed: 1}]\n") == Lines{"methods.y.seed: 1 -> 2"});
  CHECK(Texts("parts: [{weight: 1}, {weight: 2}]\n", "parts: [{weight: 1}, {weight: 3}]\n") ==
        Lines{"parts.1.weight: 2 -> 3"});
}

TEST_CASE("values that are nothing, or hold line breaks, stand on one line") {
  CHECK(Texts("a: ~\n", "a: 1\n") == Lines{"a: ~ -> 1"});
  for (const ChangedKey& key : ChangedKeys("a: \"x\\ny\"\n", "a: z\n"))
    CHECK(key.before->find('\n') == std::string::npos);
}

}  // namespace
}  // namespace diffsac
