#include "lab/files/segment_files.h"

#include <mutex>

#include "diffsac/core/status.h"
#include "diffsac/geometry/calibration.h"
#include "lab/files/hdf5_numbers.h"

namespace diffsac {
namespace {

using Matrix3Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

ImageSegments ReadImage(const H5::Group& group, const std::string& name, const std::string& place) {
  ImageSegments image;
  image.name = name;
  const Numbers segments = ReadNumbersOfShape(group, "segments", {0, 4}, place);
  image.segments =
      Eigen::Map<const PointMatrix>(segments.values.data(), static_cast<Eigen::Index>(segments.shape[0]), 4);
  if (group.nameExists("vanishing_points")) {
    const Numbers points = ReadNumbersOfShape(group, "vanishing_points", {0, 3}, place);
    for (std::size_t i = 0; i + 2 < points.values.size(); i += 3) {
      const Eigen::Vector3d point(points.values[i], points.values[i + 1], points.values[i + 2]);
      if (!point.allFinite() || !(point.norm() > 0.0))
        throw Error(place + "/vanishing_points: row " + std::to_string(i / 3) + " is no point");
      image.vanishing_points.push_back(point);
    }
  }
  if (group.nameExists("K")) {
    const Numbers k = ReadNumbersOfShape(group, "K", {3, 3}, place);
    image.K = CheckedCalibration(Eigen::Map<const Matrix3Rows>(k.values.data()), place + "/K");
  }
  if (group.nameExists("size")) {
    const Numbers size = ReadNumbersOfShape(group, "size", {2}, place);
    for (const double side : size.values)
      if (!(side >= 1.0 && side <= 1e9)) throw Error(place + "/size: expected width and height");
    image.size = {static_cast<int>(size.values[0]), static_cast<int>(size.values[1])};
  }
  return image;
}

void WriteVectors(const H5::Group& group, const char* name, const std::vector<Eigen::Vector3d>& vectors) {
  WriteNumbers(group, name, vectors.empty() ? nullptr : vectors[0].data(), {vectors.size(), 3});
}

void WriteCamera(const H5::Group& group, const std::optional<Eigen::Matrix3d>& camera) {
  if (!camera) return;
  const Matrix3Rows K = *camera;
  WriteNumbers(group, "K", K.data(), {3, 3});
}

void WriteImage(const H5::Group& group, const ImageSegments& image) {
  WriteNumbers(group, "segments", image.segments.data(), {static_cast<hsize_t>(image.segments.rows()), 4});
  if (!image.vanishing_points.empty()) WriteVectors(group, "vanishing_points", image.vanishing_points);
  WriteCamera(group, image.K);
  const double size[] = {static_cast<double>(image.size.width), static_cast<double>(image.size.height)};
  if (image.size.known()) WriteNumbers(group, "size", size, {2});
}

void WriteEstimate(const H5::Group& group, const VanishingPointsEstimate& estimate) {
  const H5::StrType text(H5::PredType::C_S1, H5T_VARIABLE);
  group.createAttribute("status", text, H5::DataSpace(H5S_SCALAR)).write(text, std::string(ToString(estimate.status)));
  WriteVectors(group, "vanishing_points", estimate.points);
  const std::vector<double> assignment(estimate.assignment.begin(), estimate.assignment.end());
  WriteNumbers(group, "assignment", assignment.data(), {assignment.size()});
  if (!estimate.directions.empty()) WriteVectors(group, "directions", estimate.directions);
  if (!estimate.values.empty()) WriteNumbers(group, "values", estimate.values.data(), {estimate.values.size()});
  WriteCamera(group, estimate.K);
  if (estimate.horizon) WriteNumbers(group, "horizon", estimate.horizon->line.data(), {3});
}

/// write(group, i): of each image.
template <class Write>
void WriteGroups(const std::string& path, const std::vector<ImageSegments>& images, const Write& write) {
  WriteHdf5(path, [&](Hdf5Output& output) {
    output.Use([&](H5::H5File& file) {
      for (std::size_t i = 0; i < images.size(); ++i) {
        const H5::Group group = file.createGroup(images[i].name);
        WriteImage(group, images[i]);
        write(group, i);
      }
    });
  });
}

}  // namespace

std::vector<ImageSegments> ReadSegments(const std::string& path) {
  const std::lock_guard lock(Hdf5Mutex());
  return WithClearErrors(path, [&] {
    const H5::H5File file = OpenHdf5(path);
    std::vector<ImageSegments> images;
    for (hsize_t i = 0; i < file.getNumObjs(); ++i) {
      const std::string name = file.getObjnameByIdx(i);
      images.push_back(ReadImage(file.openGroup(name), name, path + ":/" + name));
    }
    return images;
  });
}

void WriteSegments(const std::string& path, const std::vector<ImageSegments>& images) {
  WriteGroups(path, images, [](const H5::Group&, std::size_t) {});
}

void WriteSegments(const std::string& path, const std::vector<ImageSegments>& images,
                   const std::vector<VanishingPointsEstimate>& estimates) {
  WriteGroups(path, images, [&](const H5::Group& group, std::size_t i) {
    WriteEstimate(group.createGroup("estimate"), estimates.at(i));
  });
}

}  // namespace diffsac
