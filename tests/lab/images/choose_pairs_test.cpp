#include <catch2/catch.hpp>
#include <numbers>
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

RigidMotion Turned(double degrees, double x) {
  return {Eigen::AngleAxisd(degrees * std::numbers::pi / 180.0, Eigen::Vector3d::UnitZ()).toRotationMatrix(),
          {x, 0, 0}};
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

TEST_CASE("pairs of cameras that stand still are left out on demand") {
  TemporaryFolder folder;
  std::vector<std::optional<RigidMotion>> poses;
  for (const double x : {0.0, 0.0, 1.0, 3.0}) poses.push_back(Turned(90.0, x));
  const auto left = [&](double min_motion) {
    ImageSource source = Posed(folder, poses);
    RequireMotion(min_motion, "here", &source);
    return source.scenes[0].pairs.size();
  };
  CHECK(left(0.0) == 6);
  CHECK(left(0.5) == 5);
  CHECK(left(2.0) == 3);
  CHECK(Has(ErrorOf([&] { left(9.0); }), "no pairs"));
  CHECK(Has(ErrorOf([&] { left(-1.0); }), "--min-motion"));
  ImageSource plain = ReadImageFolder(folder.path());
  CHECK(Has(ErrorOf([&] { RequireMotion(1.0, "here", &plain); }), "needs poses"));
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

TEST_CASE("pairs are chosen by how far their cameras are turned, and at random") {
  TemporaryFolder folder;
  std::vector<std::optional<RigidMotion>> poses;
  for (int i = 0; i < 6; ++i) poses.push_back(Turned(10.0 * i, 0.0));
  const auto choose = [&](std::vector<double> turn_deg, int random_pairs) {
    ImageSource source = Posed(folder, poses);
    PairChoice choice;
    choice.turn_deg = std::move(turn_deg);
    choice.random_pairs = random_pairs;
    ChoosePairs(choice, "here", &source);
    return source.scenes[0].pairs;
  };
  CHECK(choose({}, 0).size() == 15);
  const auto turned = choose({15.0, 35.0}, 0);
  CHECK(turned.size() == 4 + 3);
  for (const SourcePair& pair : turned) CHECK((pair.image2 - pair.image1 == 2 || pair.image2 - pair.image1 == 3));
  const auto random = choose({15.0, 35.0}, 3);
  REQUIRE(random.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) CHECK(random[i].image1 == choose({15.0, 35.0}, 3)[i].image1);
  CHECK(choose({15.0, 35.0}, 100).size() == 7);
  CHECK(Has(ErrorOf([&] { choose({60.0, 90.0}, 0); }), "no pairs"));
  CHECK(Has(ErrorOf([&] { choose({30.0, 10.0}, 0); }), "--turn"));
  CHECK(Has(ErrorOf([&] { choose({30.0}, 0); }), "--turn"));
  CHECK(Has(ErrorOf([&] { choose({}, -1); }), "--random-pairs"));
  ImageSource plain = ReadImageFolder(folder.path());
  PairChoice turn;
  turn.turn_deg = {0.0, 10.0};
  CHECK(Has(ErrorOf([&] { ChoosePairs(turn, "here", &plain); }), "needs poses"));
}

}  // namespace diffsac
