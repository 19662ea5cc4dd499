#include "lab/images/photographs.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "core/errors.h"
#include "core/temporary_folder.h"
#include "lab/images/image_test_util.h"
#include "lab/images/pictures.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

struct Folder {
  TemporaryFolder folder;
  Folder() {
    for (const char* name : {"b.jpg", "a-1.png", "c.jpg"}) WriteSmall(folder / name);
    fs::create_directories(folder / "sub");
    WriteSmall(folder / "sub/a.jpg");
    WriteRaw(folder / "notes.txt", "no image");
  }
};

TEST_CASE("the photographs of a folder, of patterns and of a list of files, with all their pairs") {
  const Folder photos;
  const std::string root = fs::absolute(photos.folder.path()).string();
  const Photographs all = ListPhotographs({root + "/"}, "");
  CHECK(all.files == std::vector<std::string>{"a-1.png", "b.jpg", "c.jpg"});
  CHECK(all.source.images[0].name == "a_1");
  CHECK(all.source.scenes.at(0).pairs.size() == 3);
  CHECK(all.folder == root);
  CHECK(ListPhotographs({root + "/*.jpg"}, "").files == std::vector<std::string>{"b.jpg", "c.jpg"});
  // Each once, and by the folder that all of them are in.
  const Photographs mixed = ListPhotographs({root + "/sub/a.jpg", root + "/*.jpg", root + "/c.jpg"}, "");
  CHECK(mixed.files == std::vector<std::string>{"b.jpg", "c.jpg", "sub/a.jpg"});
  CHECK(mixed.source.images[2].name == "sub_a");
  CHECK(AreTwoFiles({"a.jpg", "b.jpg"}));
  CHECK_FALSE(AreTwoFiles({root, "b.jpg"}));
  CHECK_FALSE(AreTwoFiles({root + "/*.jpg", "b.jpg"}));
  CHECK_FALSE(AreTwoFiles({"a.jpg", "b.jpg", "c.jpg"}));
}

TEST_CASE("a list has the pairs, with images beside it or those that it names") {
  const Folder photos;
  const std::string root = photos.folder.path(), list = photos.folder / "pairs.txt";
  WriteRaw(list, "# two a line\nc.jpg b.jpg\n\nsub/a.jpg c.jpg\r\n");
  const Photographs named = ListPhotographs({}, list);
  CHECK(named.files == std::vector<std::string>{"b.jpg", "c.jpg", "sub/a.jpg"});
  const auto& pairs = named.source.scenes.at(0).pairs;
  REQUIRE(pairs.size() == 2);
  CHECK((pairs[0].image1 == 1 && pairs[0].image2 == 0));
  CHECK((pairs[1].image1 == 2 && pairs[1].image2 == 1));
  WriteRaw(list, "a-1.png b\n");
  CHECK(ListPhotographs({root}, list).source.scenes.at(0).pairs.size() == 1);
  WriteRaw(list, "a-1.png d.jpg\n");
  CHECK(Has(ErrorOf([&] { ListPhotographs({root}, list); }), "pairs.txt:1: there is no image d.jpg"));
  WriteRaw(list, "a-1.png\n");
  CHECK(Has(ErrorOf([&] { ListPhotographs({}, list); }), "pairs.txt:1: expected the names of two images"));
  WriteRaw(list, "\n");
  CHECK(Has(ErrorOf([&] { ListPhotographs({}, list); }), "pairs.txt: it names no images"));
}

TEST_CASE("photographs count and own pictures do not") {
  const Folder photos;
  WriteSmall(photos.folder / "d.webp");
  WriteSmall(photos.folder / "E.DIB");
  WriteRaw(photos.folder / "f.heic", "not read");
  const std::string own = photos.folder / kPictureFolder;
  for (const char* name : {"/matches.png", "/points.jpg"})
    WritePicture(cv::Mat(8, 10, CV_8UC3, cv::Scalar(1, 2, 3)), own + name);
  CHECK(ListPhotographs({photos.folder.path()}, "").files ==
        std::vector<std::string>{"E.DIB", "a-1.png", "b.jpg", "c.jpg", "d.webp"});
  CHECK(ListPhotographs({photos.folder / "*.png", own + "/*.png", photos.folder / "b.jpg"}, "").files ==
        std::vector<std::string>{"a-1.png", "b.jpg"});
  CHECK(cv::imread(own + "/matches.png").cols == 10);
}

TEST_CASE("names with blanks in a list are found, or told apart by a tab") {
  const TemporaryFolder folder;
  for (const char* name : {"IMG 1.png", "IMG 2.png", "c.png"}) WriteSmall(folder / name);
  for (const char* line : {"IMG 1.png IMG 2.png\n", "IMG 1.png\tIMG 2.png\r\n", "IMG 1.png, IMG 2.png\n"}) {
    WriteRaw(folder / "pairs.txt", std::string("\xEF\xBB\xBF") + line);
    CHECK(ListPhotographs({}, folder / "pairs.txt").files == std::vector<std::string>{"IMG 1.png", "IMG 2.png"});
    CHECK(ListPhotographs({folder.path()}, folder / "pairs.txt").source.scenes.at(0).pairs.size() == 1);
  }
}

TEST_CASE("photographs that are not there are named") {
  const Folder photos;
  const std::string root = photos.folder.path();
  CHECK(Has(ErrorOf([&] { ListPhotographs({root + "/none"}, ""); }), "none: no such file or folder"));
  CHECK(Has(ErrorOf([&] { ListPhotographs({root + "/*.tif"}, ""); }), "*.tif: no such files"));
  CHECK(Has(ErrorOf([&] { ListPhotographs({root + "/sub"}, ""); }), "sub: expected two images at least, found one"));
}

}  // namespace
}  // namespace diffsac
