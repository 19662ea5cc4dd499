#pragma once

#include <H5Cpp.h>

#include <Eigen/Core>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "lab/files/hdf5_numbers.h"

namespace diffsac {

/// A file as hloc writes it.
class FeatureFile {
 public:
  explicit FeatureFile(const std::string& path) : file_(path, H5F_ACC_TRUNC) {}

  void Put(const std::string& name, const Eigen::MatrixXd& values, bool is_vector = false) {
    const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows = values;
    std::vector<hsize_t> shape = {static_cast<hsize_t>(rows.rows()), static_cast<hsize_t>(rows.cols())};
    if (is_vector) shape = {static_cast<hsize_t>(rows.size())};
    H5::LinkCreatPropList links;
    H5Pset_create_intermediate_group(links.getId(), 1);
    const H5::DataSpace space(static_cast<int>(shape.size()), shape.data());
    const hid_t data =
        H5Dcreate2(file_.getId(), name.c_str(), H5T_IEEE_F32LE, space.getId(), links.getId(), H5P_DEFAULT, H5P_DEFAULT);
    H5Dwrite(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, rows.data());
    H5Dclose(data);
  }

 private:
  H5::H5File file_;
};

inline void WriteFeatureFile(const std::string& path, const std::function<void(FeatureFile&)>& fill) {
  const std::lock_guard lock(Hdf5Mutex());
  FeatureFile file(path);
  fill(file);
}

}  // namespace diffsac
