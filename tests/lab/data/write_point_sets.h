#pragma once

#include <H5Cpp.h>

#include <cstdio>
#include <mutex>
#include <string>
#include <vector>

#include "lab/files/hdf5_numbers.h"
#include "lab/ground_truth/example.h"

namespace diffsac::testing {

inline void WriteText(const H5::Group& group, const char* name, const std::string& text) {
  const H5::StrType type(H5::PredType::C_S1, H5T_VARIABLE);
  group.createAttribute(name, type, H5::DataSpace(H5S_SCALAR)).write(type, text);
}

inline void WriteExample(const H5::H5File& file, std::size_t position, const Example& example) {
  // Padded numbers keep the order of the examples when the file is read in the order of the names.
  char name[32];
  std::snprintf(name, sizeof(name), "%08zu", position);
  const H5::Group group = file.createGroup(name);
  const PointMatrix& points = example.problem.points;
  WriteNumbers(group, "points", points.data(),
               {static_cast<hsize_t>(points.rows()), static_cast<hsize_t>(points.cols())});
  const ModelParameters& model = example.truth.model;
  if (model.size() > 0) WriteNumbers(group, "model", model.data(), {static_cast<hsize_t>(model.size())});
  const auto& inliers = example.truth.inliers;
  if (!inliers.empty()) {
    const hsize_t count = inliers.size();
    group.createDataSet("inliers", H5::PredType::STD_U8LE, H5::DataSpace(1, &count))
        .write(inliers.data(), H5::PredType::NATIVE_UINT8);
  }
  group.createAttribute("inlier_threshold", H5::PredType::IEEE_F64LE, H5::DataSpace(H5S_SCALAR))
      .write(H5::PredType::NATIVE_DOUBLE, &example.problem.inlier_threshold);
  WriteText(group, "id", example.id);
  WriteText(group, "scene", example.scene);
}

/// Writes examples as groups that ReadHdf5Points reads back without loss: double precision, order, id, scene,
/// threshold.
inline void WritePointSets(const std::string& path, const std::vector<Example>& examples) {
  const std::lock_guard lock(Hdf5Mutex());
  const H5::H5File file(path, H5F_ACC_TRUNC);
  for (std::size_t i = 0; i < examples.size(); ++i) WriteExample(file, i, examples[i]);
}

}  // namespace diffsac::testing
