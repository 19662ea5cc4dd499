#include "lab/images/adelaide_matches.h"

#include <matio.h>

#include <catch2/catch.hpp>
#include <vector>

#include "core/errors.h"

namespace diffsac {
namespace {

// A file as AdelaideRMF's: matches, labels, and images of 4 x 6 pixels.
void WritePair(const std::string& path, std::vector<double> data, std::vector<std::uint8_t> labels,
               bool with_images = true) {
  mat_t* file = Mat_CreateVer(path.c_str(), nullptr, MAT_FT_MAT5);
  REQUIRE(file != nullptr);
  const auto write = [&](const char* name, matio_classes kind, matio_types type, int rank, std::size_t* size,
                         void* values) {
    matvar_t* variable = Mat_VarCreate(name, kind, type, rank, size, values, 0);
    Mat_VarWrite(file, variable, MAT_COMPRESSION_NONE);
    Mat_VarFree(variable);
  };
  std::size_t matches[] = {6, data.size() / 6}, one[] = {1, labels.size()}, image[] = {4, 6, 3};
  std::vector<std::uint8_t> pixels(72, 9);
  write("data", MAT_C_DOUBLE, MAT_T_DOUBLE, 2, matches, data.data());
  write("label", MAT_C_UINT8, MAT_T_UINT8, 2, one, labels.data());
  if (with_images)
    for (const char* name : {"img1", "img2"}) write(name, MAT_C_UINT8, MAT_T_UINT8, 3, image, pixels.data());
  Mat_Close(file);
}

const std::vector<double> kTwo = {1.5, 2.0, 1.0, 3.0, 4.0, 1.0, 5.0, 6.0, 1.0, 7.0, 8.25, 1.0};

}  // namespace

TEST_CASE("AdelaideRMF's MATLAB files: matches, labels, sizes, pairs by name") {
  const TemporaryFolder folder;
  WritePair(folder / "toy.mat", kTwo, {0, 2});
  WritePair(folder / "cube.mat", kTwo, {1, 1});
  const CorrespondenceSet set = ReadAdelaideMatches(folder.path());
  REQUIRE(set.pairs.size() == 2);
  CHECK(set.pairs[0].id == "cubeA-cubeB");
  const Example& toy = set.pairs[1];
  CHECK(toy.problem.points.row(1) == Eigen::RowVector4d(5.0, 6.0, 7.0, 8.25));
  CHECK(toy.truth.assignment == std::vector<std::int32_t>{0, 2});
  CHECK(toy.problem.size1 == ImageSize{6, 4});
}

TEST_CASE("AdelaideRMF's MATLAB files: mistakes name the file and what it lacks") {
  const TemporaryFolder folder;
  const auto error = [&] { return ErrorOf([&] { ReadAdelaideMatches(folder.path()); }); };
  CHECK(Has(error(), "no files *.mat"));
  WriteRaw(folder / "toy.mat", "not one");
  CHECK(Has(error(), "toy.mat: not a readable MATLAB file"));
  WritePair(folder / "toy.mat", kTwo, {1});
  CHECK(Has(error(), "toy.mat: expected a variable label"));
  std::vector<double> inhomogeneous = kTwo;
  inhomogeneous[2] = 2.0;
  WritePair(folder / "toy.mat", inhomogeneous, {1, 1});
  CHECK(Has(error(), "toy.mat: expected a variable data, 6xN"));
  WritePair(folder / "toy.mat", kTwo, {1, 1}, false);
  CHECK(Has(error(), "toy.mat: expected a variable img1"));
  CHECK(Has(ErrorOf([&] { ReadAdelaideMatches(folder / "nowhere"); }), "no such folder"));
}

}  // namespace diffsac
