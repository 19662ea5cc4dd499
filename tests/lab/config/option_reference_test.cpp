#include "lab/config/option_reference.h"
#include "lab/options/options.h"

#include <catch2/catch.hpp>

namespace diffsac {
namespace {

struct Inner {
  int width = 3;
  double rate = 0.5;
  void Bind(OptionsBinder& b) {
    b.Field("width", width, AtLeast(1)).Help("channels a|b");
    b.Field("rate", rate).OnlyIf(width > 1, "width above 1");
  }
};

struct Outer {
  Inner first, second;
  std::vector<std::string> names;
  void Bind(OptionsBinder& b) {
    b.Field("first", first).Help("the first");
    b.Field("second", second).Help("the second");
    b.Field("names", names);
  }
};

}  // namespace

TEST_CASE("A reference has a table for each map, and points to what it has described") {
  Outer outer;
  outer.second.width = 4;
  OptionReference reference;
  reference.AddText(2, "All", "Text.");
  reference.AddOptions("outer", "What it is.", "", typeid(Outer), DescribeOptions(outer));
  CHECK(reference.text() ==
        "## All\n\nText.\n\n"
        "### outer\n\nWhat it is.\n\n"
        "| key | default | value | meaning |\n|---|---|---|---|\n"
        "| `first` |  | a map | The first. |\n"
        "| `second` |  | a map | The second. |\n"
        "| `names` | `[]` | a list of texts |  |\n\n"
        "### `first`\n\nThe first.\n\n"
        "| key | default | value | meaning |\n|---|---|---|---|\n"
        "| `width` | `3` | an integer of at least 1 | Channels a\\|b. |\n"
        "| `rate` | `0.5` | a number | Only with width above 1. |\n\n"
        "`second`: keys as of `first`, with the defaults `width`: `4`.\n");
}

TEST_CASE("Two sections of one struct share a table") {
  Inner other;
  other.rate = 1.0;
  OptionReference reference;
  reference.AddOptions("a", "", "", typeid(Inner), DescribeOptions<Inner>());
  const std::size_t size = reference.text().size();
  reference.AddOptions("b", "", "", typeid(Inner), DescribeOptions(other));
  reference.AddOptions("c", "", "", typeid(Inner), DescribeOptions<Inner>());
  CHECK(reference.text().substr(size) ==
        "\n### b\n\nKeys as of a, with the defaults `rate`: `1`.\n\n### c\n\nKeys as of a.\n");
}

TEST_CASE("Keys that the described struct has not stand behind the pointer to it") {
  struct More : Inner {
    std::string model;
    void Bind(OptionsBinder& b) {
      b.Field("model", model).Help("which");
      Inner::Bind(b);
    }
  };
  OptionReference reference;
  reference.AddOptions("a", "", "", typeid(Inner), DescribeOptions<Inner>());
  const std::size_t size = reference.text().size();
  reference.AddOptions("b", "", "", typeid(Inner), DescribeOptions<More>());
  CHECK(reference.text().substr(size) ==
        "\n### b\n\nKeys as of a.\nBeside them:\n\n"
        "| key | default | value | meaning |\n|---|---|---|---|\n"
        "| `model` | `\"\"` | a text | Which. |\n");
}

TEST_CASE("Differences name other defaults and keys that are missing") {
  CHECK(DifferenceText(DescribeOptions<Outer>(), DescribeOptions<Outer>()).empty());
  CHECK(DifferenceText(DescribeOptions<Inner>(), {}) == "without `width`, `rate`");
  Outer outer;
  outer.first.rate = 2.0;
  auto keys = DescribeOptions(outer);
  keys.pop_back();
  CHECK(DifferenceText(DescribeOptions<Outer>(), keys) == "with the defaults `first.rate`: `2`; without `names`");
}

}  // namespace diffsac
