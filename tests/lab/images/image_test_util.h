#pragma once

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/errors.h"
#include "diffsac/core/random.h"
#include "diffsac/geometry/rigid_motion.h"
#include "lab/colmap/lens.h"
#include "lab/data/two_view_test_util.h"

namespace diffsac {

// Smooth noise of several scales, in which SIFT finds many keypoints.
inline cv::Mat Texture(int width, int height, std::uint64_t seed) {
  Rng rng(seed);
  cv::Mat sum = cv::Mat::zeros(height, width, CV_32F);
  for (double sigma : {1.5, 3.0, 6.0}) {
    cv::Mat noise(height, width, CV_32F), smooth;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) noise.at<float>(y, x) = static_cast<float>(rng.Normal());
    cv::GaussianBlur(noise, smooth, cv::Size(), sigma);
    sum += smooth * (30.0 * sigma);
  }
  cv::Mat image;
  sum.convertTo(image, CV_8U, 1.0, 128.0);
  return image;
}

// What a camera sees of a texture on the world's plane z = 5, 100 texture pixels a unit.
inline cv::Mat Render(const cv::Mat& texture, const LensCamera& camera, const RigidMotion& pose,
                      const ImageSize& size) {
  cv::Mat map_x(size.height, size.width, CV_32F), map_y(size.height, size.width, CV_32F), image;
  const Eigen::Matrix3d inverse_K = camera.K.inverse();
  const Eigen::Vector3d centre = -pose.rotation.transpose() * pose.translation;
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const Eigen::Vector2d pixel = camera.Undistort({x, y});
      const Eigen::Vector3d ray = pose.rotation.transpose() * (inverse_K * pixel.homogeneous());
      const Eigen::Vector3d seen = centre + ray * ((5.0 - centre.z()) / ray.z());
      map_x.at<float>(y, x) = static_cast<float>(100.0 * seen.x() + texture.cols / 2.0);
      map_y.at<float>(y, x) = static_cast<float>(100.0 * seen.y() + texture.rows / 2.0);
    }
  }
  cv::remap(texture, image, map_x, map_y, cv::INTER_LINEAR, cv::BORDER_REFLECT);
  return image;
}

// COLMAP's text of one camera and of images with these names and poses, `images/` beside it.
inline void WriteColmapModel(const std::string& root, const std::string& camera, const std::vector<std::string>& names,
                             const std::vector<RigidMotion>& poses) {
  std::ostringstream images;
  images.precision(17);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const Eigen::Quaterniond q(poses[i].rotation);
    images << i + 1 << " " << q.w() << " " << q.x() << " " << q.y() << " " << q.z() << " "
           << poses[i].translation.transpose() << " 1 " << names[i] << "\n\n";
  }
  WriteRaw(root + "/images.txt", images.str());
  WriteRaw(root + "/cameras.txt", "1 " + camera + "\n");
}

// A camera about 5 units before the plane, moved and turned a little.
inline RigidMotion NearbyPose(int i) {
  RigidMotion pose;
  pose.rotation = Eigen::AngleAxisd(0.06 * i, Eigen::Vector3d(0.2, 1.0, 0.4).normalized()).toRotationMatrix();
  pose.translation = Eigen::Vector3d(0.25, 0.1, -0.3) * i;
  return pose;
}

inline void WriteImage(const std::string& path, const cv::Mat& grey) {
  cv::Mat image = grey;
  if (path.ends_with(".ppm")) cv::cvtColor(grey, image, cv::COLOR_GRAY2BGR);
  if (!cv::imwrite(path, image)) throw std::runtime_error("cannot write " + path);
}

inline void MakeFolder(const std::string& path) { std::filesystem::create_directories(path); }

// Small images, since readers of sources look at their names alone.
inline void WriteSmall(const std::string& path) { WriteImage(path, cv::Mat(8, 10, CV_8U, cv::Scalar(7))); }

}  // namespace diffsac
