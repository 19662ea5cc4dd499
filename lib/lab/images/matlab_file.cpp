#include "lab/images/matlab_file.h"

#include <matio.h>

#include <cstdint>

#include "diffsac/core/status.h"

namespace diffsac {
namespace {

using Variable = std::unique_ptr<matvar_t, decltype(&Mat_VarFree)>;

template <class Value>
Eigen::MatrixXd Values(const matvar_t& variable) {
  return Eigen::Map<const Eigen::Matrix<Value, Eigen::Dynamic, Eigen::Dynamic>>(
             static_cast<const Value*>(variable.data), static_cast<Eigen::Index>(variable.dims[0]),
             static_cast<Eigen::Index>(variable.dims[1]))
      .template cast<double>();
}

}  // namespace

MatlabFile::MatlabFile(const std::string& path) : path_(path) {
  Mat_LogInit("diffsac_prepare");
  file_ = std::shared_ptr<mat_t>(Mat_Open(path.c_str(), MAT_ACC_RDONLY), [](mat_t* file) {
    if (file != nullptr) Mat_Close(file);
  });
  if (!file_) throw Error(path + ": not a readable MATLAB file");
}

Eigen::MatrixXd MatlabFile::Matrix(const std::string& name, const std::string& expected) const {
  const Variable variable(Mat_VarRead(file_.get(), name.c_str()), Mat_VarFree);
  if (variable && variable->rank == 2 && !variable->isComplex && variable->data != nullptr) {
    switch (variable->class_type) {
      case MAT_C_DOUBLE:
        return Values<double>(*variable);
      case MAT_C_SINGLE:
        return Values<float>(*variable);
      case MAT_C_UINT8:
        return Values<std::uint8_t>(*variable);
      case MAT_C_INT32:
        return Values<std::int32_t>(*variable);
      default:
        break;
    }
  }
  throw Error(path_ + ": expected a variable " + name + ", " + expected);
}

std::pair<int, int> MatlabFile::Size(const std::string& name) const {
  const Variable variable(Mat_VarReadInfo(file_.get(), name.c_str()), Mat_VarFree);
  if (!variable || variable->rank < 2 || variable->dims[0] == 0 || variable->dims[1] == 0)
    throw Error(path_ + ": expected a variable " + name + ", an image");
  return {static_cast<int>(variable->dims[0]), static_cast<int>(variable->dims[1])};
}

}  // namespace diffsac
