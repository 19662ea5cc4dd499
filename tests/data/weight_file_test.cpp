#include "diffsac/data/weight_file.h"

#include <H5Cpp.h>

#include <catch2/catch.hpp>

#include "data_test_util.h"
#include "diffsac/data/hdf5_numbers.h"

namespace diffsac {
namespace {

void WriteText(const H5::H5File& file, const char* name, const std::string& text) {
  const H5::StrType type(H5::PredType::C_S1, H5T_VARIABLE);
  file.createAttribute(name, type, H5::DataSpace(H5S_SCALAR)).write(type, text);
}

void WriteFloats(const H5::Group& group, const char* name, const std::vector<float>& values,
                 const std::vector<hsize_t>& shape) {
  const H5::DataSpace space(static_cast<int>(shape.size()), shape.data());
  group.createDataSet(name, H5::PredType::IEEE_F32LE, space).write(values.data(), H5::PredType::NATIVE_FLOAT);
}

}  // namespace

TEST_CASE("weights of other programs: arrays by name, what they are for") {
  const TemporaryFolder folder;
  const std::string path = folder / "w.h5";
  {
    const H5::H5File file(path, H5F_ACC_TRUNC);
    WriteText(file, "method", "ng_ransac");
    WriteText(file, "task", "essential");
    const H5::Group group = file.createGroup("weights");
    WriteFloats(group, "input.weight", {1, 2, 3, 4, 5, 6}, {2, 3});
    WriteFloats(group, "input.bias", {0.5f, -1}, {2});
  }
  const WeightFile read = ReadWeightFile(path);
  CHECK(read.method == "ng_ransac");
  CHECK(read.task == "essential");
  REQUIRE(read.weights.size() == 2);
  CHECK(read.weights.at("input.weight").shape == std::vector<std::int64_t>{2, 3});
  CHECK(read.weights.at("input.weight").values == std::vector<float>{1, 2, 3, 4, 5, 6});
  CHECK(read.weights.at("input.bias").values == std::vector<float>{0.5f, -1});
  CHECK(Has(ErrorOf([&] { ReadWeightArrays(path, "example"); }), "no group 'example'"));
}

TEST_CASE("weights of other programs: mistakes name the file") {
  const TemporaryFolder folder;
  const std::string path = folder / "w.h5";
  const auto error = [&] { return ErrorOf([&] { ReadWeightFile(path); }); };
  CHECK(Has(error(), "w.h5: no such file"));
  WriteRaw(path, "torch");
  CHECK(Has(error(), "w.h5: not a readable file of weights"));
  { const H5::H5File file(path, H5F_ACC_TRUNC); }
  CHECK(Has(error(), "no attribute 'method'"));
  {
    const H5::H5File file(path, H5F_ACC_TRUNC);
    for (const char* name : {"method", "task"}) WriteText(file, name, "line");
  }
  CHECK(Has(error(), "no group 'weights'"));
  {
    const H5::H5File file(path, H5F_ACC_RDWR);
    const double value = 1.0;
    WriteNumbers(file.createGroup("weights"), "bias", &value, {1});
  }
  CHECK(Has(error(), "weights/bias: expected 32-bit floats"));
}

}  // namespace diffsac
