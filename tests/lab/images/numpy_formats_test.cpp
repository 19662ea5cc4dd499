// NumPy's files, and the image formats that keep their cameras in them or in tables of their own.

#include "lab/images/numpy_file.h"

#include <zip.h>

#include <catch2/catch.hpp>
#include <cstring>

#include "core/errors.h"
#include "diffsac/core/files.h"
#include "lab/images/image_format.h"
#include "lab/images/image_test_util.h"

namespace diffsac {
namespace {

/// As NumPy writes it: `numbers` are the bytes of the array.
std::string Npy(const std::string& type, const std::string& order, const std::string& shape,
                const std::string& numbers) {
  std::string header = "{'descr': '" + type + "', 'fortran_order': " + order + ", 'shape': " + shape + ", }";
  header.resize((10 + header.size() + 1 + 63) / 64 * 64 - 10, ' ');
  header.back() = '\n';
  std::string text = "\x93NUMPY";
  text += std::string({1, 0, static_cast<char>(header.size() & 255), static_cast<char>(header.size() >> 8)});
  return text + header + numbers;
}

template <class Number>
std::string Bytes(const std::vector<Number>& values) {
  std::string bytes(values.size() * sizeof(Number), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

void WriteNpz(const std::string& path, const std::vector<std::pair<std::string, std::string>>& arrays) {
  zip_t* archive = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, nullptr);
  REQUIRE(archive != nullptr);
  for (const auto& [name, content] : arrays)
    zip_file_add(archive, (name + ".npy").c_str(), zip_source_buffer(archive, content.data(), content.size(), 0),
                 ZIP_FL_OVERWRITE);
  REQUIRE(zip_close(archive) == 0);
}

ImageSource Read(const std::string& format, const std::string& folder) {
  PairsRequest request;
  request.format = format;
  request.input = folder;
  return Registry<ImageFormat>::Instance().Find(format, "format").read(request);
}

std::string ErrorIn(const std::string& format, const std::string& folder) {
  return ErrorOf([&] { Read(format, folder); });
}

/// At (1, 2, 3), turned by 90° about z: its x axis is the world's y.
const RigidMotion kToWorld{(Eigen::Matrix3d() << 0, -1, 0, 1, 0, 0, 0, 0, 1).finished(), {1, 2, 3}};

void CheckPose(const SourceImage& image) {
  REQUIRE(image.pose);
  const RigidMotion pose = Inverse(kToWorld);
  CHECK((image.pose->rotation - pose.rotation).norm() < 1e-9);
  CHECK((image.pose->translation - pose.translation).norm() < 1e-9);
}

}  // namespace

TEST_CASE("NumPy: types, both orders, and files that are none") {
  const NumpyArray rows = ParseNpy(Npy("<f4", "False", "(2, 3)", Bytes<float>({1, 2, 3, 4, 5, 6})), "a.npy");
  CHECK(rows.shape == std::vector<std::size_t>{2, 3});
  CHECK(rows.values == std::vector<double>{1, 2, 3, 4, 5, 6});
  const NumpyArray columns = ParseNpy(Npy("<i8", "True", "(2, 3)", Bytes<std::int64_t>({1, 4, 2, 5, 3, 6})), "a.npy");
  CHECK(columns.values == rows.values);
  CHECK(ParseNpy(Npy("<f8", "False", "()", Bytes<double>({7})), "a.npy").values == std::vector<double>{7});
  const auto error = [](const std::string& content) { return ErrorOf([&] { ParseNpy(content, "a.npy"); }); };
  CHECK(Has(error("text"), "a.npy: not a file of NumPy's"));
  CHECK(Has(error(Npy("<f8", "False", "(2,)", Bytes<double>({1}))), "a.npy: truncated"));
  CHECK(Has(error(Npy("<c16", "False", "(1,)", Bytes<double>({1, 2}))), "type <c16"));
  CHECK(Has(error(Npy("<f8", "False", "(99999999999,)", "")), "too large"));
  CHECK(Has(error(Npy("<f8", "Maybe", "(1,)", Bytes<double>({1}))), "header"));
  CHECK(Has(error(std::string("\x93NUMPY\x01\x00\xff\xff", 10) + "xx"), "truncated"));
  TemporaryFolder folder;
  WriteRaw(folder / "b.npz", "no archive");
  CHECK(Has(ErrorOf([&] { ReadNpz(folder / "b.npz"); }), "b.npz: not an archive"));
  CHECK(Has(ErrorOf([&] { ReadNpy(folder / "none.npy"); }), "none.npy"));
}

TEST_CASE("NumPy: headers and sizes that only a hostile file has") {
  TemporaryFolder folder;
  const std::string path = folder / "a.npy";
  const auto error = [&](const std::string& content) {
    WriteRaw(path, content);
    return ErrorOf([&] { ReadNpy(path); });
  };
  CHECK(Has(error(Npy("<f8", "False", "(99999999999999999999,)", "")), "a.npy: expected a shape"));
  CHECK(Has(error(Npy("<f8", "False", "(4294967296, 4294967296)", "")), "a.npy: too large"));
  // A text of so many characters would exhaust the stack of std::regex.
  CHECK(Has(
      error("\x93NUMPY" + std::string("\x02\0\xf0\xff\x0f\0{'descr': '", 17) + std::string(std::size_t{1} << 21, 'x')),
      "a.npy: not a header of NumPy's"));
  const std::string numbers = Npy("<f8", "False", "(2,)", Bytes<double>({1, 2}));
  WriteNpz(folder / "a.npz", {{"a", numbers}});
  std::string archive = ReadFile(folder / "a.npz");
  // The size when unpacked, in the entry's header and in the directory.
  for (std::size_t at = 0; (at = archive.find("PK\1\2", at)) != std::string::npos; ++at)
    archive.replace(at + 24, 4, std::string("\0\0\0\x2f", 4));
  WriteRaw(folder / "a.npz", archive);
  CHECK(Has(ErrorOf([&] { ReadNpz(folder / "a.npz"); }), "a.npz: "));
}

TEST_CASE("LLFF: down, right, backwards, and a focal length for another size") {
  TemporaryFolder folder;
  const std::string root = folder / "shell";
  MakeFolder(root + "/images");
  for (const char* name : {"a.png", "b.png"}) WriteSmall(root + "/images/" + name);  // 10 × 8
  const Eigen::Matrix3d R = kToWorld.rotation;
  std::vector<double> values;
  for (int image = 0; image < 2; ++image) {
    const double hwf[] = {16, 20, 30};
    for (int row = 0; row < 3; ++row)
      values.insert(values.end(), {R(row, 1), R(row, 0), -R(row, 2), kToWorld.translation[row], hwf[row]});
    values.insert(values.end(), {0.1, 9.0});
  }
  WriteRaw(root + "/poses_bounds.npy", Npy("<f8", "False", "(2, 17)", Bytes(values)));
  const ImageSource source = Read("llff", root);
  REQUIRE(source.images.size() == 2);
  CHECK(source.images[0].camera->K(0, 0) == 15.0);
  CHECK(source.images[0].camera->K(0, 2) == 4.5);
  CHECK(source.images[0].camera->K(1, 2) == 3.5);
  CheckPose(source.images[1]);
  WriteSmall(root + "/images/c.png");
  CHECK(Has(ErrorIn("llff", root), "2 poses for 3 images"));
  WriteRaw(root + "/poses_bounds.npy", Npy("<f8", "False", "(17, 2)", Bytes(values)));
  CHECK(Has(ErrorIn("llff", root), "expected N rows of 17 numbers"));
}

TEST_CASE("projection matrices: of either sign, one for each image") {
  TemporaryFolder folder;
  const std::string root = folder / "scan";
  MakeFolder(root + "/image");
  for (const char* name : {"000.png", "001.png", "002.png"}) WriteSmall(root + "/image/" + name);
  Eigen::Matrix3d K;
  K << 50, 0, 4, 0, 60, 3, 0, 0, 1;
  const RigidMotion pose = Inverse(kToWorld);
  Eigen::Matrix<double, 4, 4, Eigen::RowMajor> P = Eigen::Matrix4d::Identity();
  P.topLeftCorner<3, 3>() = K * pose.rotation;
  P.topRightCorner<3, 1>() = K * pose.translation;
  const auto npy = [](const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>& m) {
    return Npy("<f8", "False", "(4, 4)", Bytes(std::vector<double>(m.data(), m.data() + 16)));
  };
  const std::string plus = npy(P), minus = npy(-P);
  WriteNpz(root + "/cameras.npz", {{"world_mat_0", plus}, {"world_mat_1", minus}, {"scale_mat_0", plus}});
  const ImageSource source = Read("projections", root);
  REQUIRE(source.images.size() == 2);
  for (const SourceImage& image : source.images) {
    CheckPose(image);
    CHECK((image.camera->K - K).norm() < 1e-9);
  }
  REQUIRE(source.left_out.size() == 1);
  CHECK(Has(source.left_out[0].problem, "there is no world_mat_2"));
  WriteRaw(root + "/cameras.npz", "broken");
  CHECK(Has(ErrorIn("projections", root), "cameras.npz: not an archive"));
}

TEST_CASE("Middlebury: K, R and t in a line") {
  TemporaryFolder folder;
  const std::string root = folder / "temple";
  MakeFolder(root);
  for (const char* name : {"t1.png", "t2.png"}) WriteSmall(root + "/" + name);
  const RigidMotion pose = Inverse(kToWorld);
  std::string numbers = " 50 0 4 0 60 3 0 0 1";
  for (int i = 0; i < 9; ++i) numbers += " " + std::to_string(pose.rotation(i / 3, i % 3));
  for (int i = 0; i < 3; ++i) numbers += " " + std::to_string(pose.translation[i]);
  WriteRaw(root + "/temple_par.txt", "3\nt1.png" + numbers + "\nt2.png" + numbers + "\nt3.png" + numbers + "\n");
  const ImageSource source = Read("middlebury", root);
  REQUIRE(source.images.size() == 2);
  CheckPose(source.images[0]);
  CHECK(source.images[1].camera->K(1, 1) == 60.0);
  REQUIRE(source.left_out.size() == 1);
  CHECK(Has(source.left_out[0].problem, "temple_par.txt:4: there is no"));
  WriteRaw(root + "/temple_par.txt", "2\nt1.png" + numbers + "\nt2.png 1 2 3\n");
  CHECK(Has(ErrorIn("middlebury", root), "temple_par.txt:3: expected an image and 21 numbers"));
  std::filesystem::remove(root + "/temple_par.txt");
  CHECK(Has(ErrorIn("middlebury", root), "no file NAME_par.txt"));
}

}  // namespace diffsac
