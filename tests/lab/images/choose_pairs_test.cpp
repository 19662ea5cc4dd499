#include <catch2/catch.hpp>
#include <optional>

#include "core/errors.h"
#include "lab/images/image_source.h"
#include "lab/images/image_test_util.h"

namespace diffsac {
namespace {

// Images of a folder with these poses; no image for nothing.
ImageSource Posed(const TemporaryFolder& folder, const std::vector<std::optional<RigidMotion>>& poses) {
  ImageSource source;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const std::string name = "im-" + std::to_string(i), path = folder / (name + ".png");
    WriteSmall(path);
    AddImage(
        ImageName(name),
        [&] {
          if (!poses[i]) throw Error("no pose");
          return SourceImage{ImageName(name), path, {}, poses[i]};
        },
        &source);
  }
  AddAllPairs(folder.path(), &source);
  return source;
}

}  // namespace

TEST_CASE("pairs are chosen by step, by every n-th image, or by a list") {
  TemporaryFolder folder;
  std::vector<std::optional<RigidMotion>> poses(7, RigidMotion());
  poses[3].reset();
  const ImageSource all = Posed(folder, poses);
  REQUIRE(all.images.size() == 6);
  const auto choose = [&](const PairChoice& choice) {
    ImageSource source = all;
    ChoosePairs(choice, "here", &source);
    return source;
  };
  const auto names = [](const ImageSource& source, int scene) {
    std::string text;
    for (const SourcePair& pair : source.scenes.at(scene).pairs)
      text += source.images[pair.image1].name.substr(3) + source.images[pair.image2].name.substr(3) + " ";
    return text;
  };
  CHECK(names(choose({}), 0).size() == 15 * 3);
  // Image 3 was left out, which does not make 2 and 4 neighbours.
  const ImageSource steps = choose({1, {1, 2}, ""});
  CHECK(names(steps, 0) == "01 12 45 56 ");
  CHECK(names(steps, 1) == "02 24 46 ");
  CHECK(Has(steps.scenes[1].name, "_step_02"));
  CHECK(names(choose({2, {}, ""}), 0) == "02 04 06 24 26 46 ");
  CHECK(names(choose({2, {1}, ""}), 0) == "02 24 46 ");
  WriteRaw(folder / "pairs.txt", "# chosen\nim-0.png im-5.png\nsome/folder/im-2.png, im_1\nim-3.png im-4.png\n");
  CHECK(names(choose({1, {}, folder / "pairs.txt"}), 0) == "05 21 ");
  const auto error = [&](const PairChoice& choice) { return ErrorOf([&] { choose(choice); }); };
  WriteRaw(folder / "parts.txt", "# all\n[a]\nim-0 im-1\n[b]\nim-0 im-2\nim-4 im-5\n[c]\nim-9 im-9\n");
  CHECK(names(choose({1, {}, folder / "parts.txt#b"}), 0) == "02 45 ");
  CHECK(Has(error({1, {}, folder / "parts.txt#c"}), "parts.txt:8: there is no image im-9"));
  CHECK(Has(error({1, {}, folder / "parts.txt#d"}), "parts.txt: there is no part [d]"));
  const auto list_error = [&](const std::string& text) {
    WriteRaw(folder / "pairs.txt", text);
    return error({1, {}, folder / "pairs.txt"});
  };
  CHECK(Has(list_error("im-0 im-9\n"), "pairs.txt:1: there is no image im-9"));
  CHECK(Has(list_error("im-0\n"), "pairs.txt:1: expected the names of two images"));
  CHECK(Has(list_error("im-0 im-0\n"), "itself"));
  CHECK(Has(list_error("im-0 im-1\nim-0 im-1\n"), "pairs.txt:2: this pair stands there twice"));
  CHECK(Has(list_error("\n"), "no pairs"));
  CHECK(Has(error({1, {}, folder / "missing.txt"}), "missing.txt"));
  CHECK(Has(error({0, {}, ""}), "--every"));
  CHECK(Has(error({1, {0}, ""}), "positive"));
  CHECK(Has(error({1, {9}, ""}), "no pairs"));
  CHECK(Has(error({1, {1}, folder / "pairs.txt"}), "exclude"));
}

TEST_CASE("images of a list of pairs are not paired with all others first") {
  TemporaryFolder folder;
  for (int i = 0; i < 4; ++i) WriteSmall(folder / ("im" + std::to_string(i) + ".png"));
  WriteRaw(folder / "pairs.txt", "im0 im3\n");
  PairChoice choice;
  choice.pairs_file = folder / "pairs.txt";
  ImageSource source = ReadImageFolder(folder.path(), {}, choice);
  CHECK(source.scenes.at(0).pairs.empty());
  ChoosePairs(choice, "here", &source);
  REQUIRE(source.scenes.at(0).pairs.size() == 1);
  CHECK(source.scenes[0].pairs[0].image2 == 3);
}

}  // namespace diffsac
