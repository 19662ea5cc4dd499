#include "lab/data/pair_scenes.h"

#include <catch2/catch.hpp>

#include "core/errors.h"
#include "lab/data/two_view_test_util.h"

namespace diffsac {

TEST_CASE("a folder is a scene, or the folders in it are") {
  const TemporaryFolder folder;
  for (const char* name : {"root/b", "root/a"}) WriteCorrespondences(folder / name, SyntheticSet(1, 4, Rng(1)));
  const auto scenes = FindScenes(folder / "root");
  REQUIRE(scenes.size() == 2);
  CHECK(scenes[0].name == "a");
  CHECK(scenes[1].folder == folder / "root/b");
  REQUIRE(FindScenes(folder / "root/b/").size() == 1);
  CHECK(FindScenes(folder / "root/b/")[0].name == "b");
  CHECK(Has(ErrorOf([&] { FindScenes(folder / "nowhere"); }), "no such folder"));
  const TemporaryFolder empty;
  CHECK(Has(ErrorOf([&] { FindScenes(empty.path()); }), "matches.h5"));
}

TEST_CASE("positions are spread evenly") {
  using Positions = std::vector<std::int64_t>;
  CHECK(EvenlySpread(3, 0) == Positions{0, 1, 2});
  CHECK(EvenlySpread(3, 5) == Positions{0, 1, 2});
  CHECK(EvenlySpread(10, 4) == Positions{0, 2, 5, 7});
  CHECK(EvenlySpread(0, 4).empty());
}

}  // namespace diffsac
