#pragma once

#include <optional>
#include <string>
#include <vector>

#include "data_tools/lens_camera.h"
#include "diffsac/data/two_view.h"

namespace diffsac {

/// An image with what its source knows about it.
struct SourceImage {
  std::string name;  ///< Unique in the source, without '-' (which joins the names of a pair).
  std::string path;
  std::optional<LensCamera> camera;
  std::optional<RigidMotion> pose;  ///< World-to-camera.
};

struct SourcePair {
  int image1 = 0, image2 = 0;                 ///< Indices of images.
  std::optional<Eigen::Matrix3d> homography;  ///< x2 ~ H x1 in pixels.
};

/// Pairs that are evaluated together.
struct SourceScene {
  std::string name;
  std::vector<SourcePair> pairs;
};

/// A set of images and the pairs of them that are to be matched. Either all images have a pose, or none.
struct ImageSource {
  std::vector<SourceImage> images;
  std::vector<SourceScene> scenes;
};

// The readers below throw Error with one line that names the file (and its line).

/// KITTI odometry (Geiger et al., "Are we ready for autonomous driving?", CVPR 2012) in the official layout:
/// `sequences/<sequence>/image_0/%06d.png` and `calib.txt` (P0), `poses/<sequence>.txt`, camera-to-world, a line a
/// frame. A scene for each step, kitti_<sequence>_step_<step>: the pairs (i, i + step).
ImageSource ReadKitti(const std::string& root, const std::string& sequence, const std::vector<int>& steps);

/// The dense-matching benchmark of Strecha et al. (CVPR 2008): `images/`, and `gt_dense_cameras/<image file>.camera`
/// with K, zeros, the camera-to-world rotation, the camera's centre and width, height. All pairs.
ImageSource ReadStrecha(const std::string& folder);

/// A COLMAP text model (cameras.txt, images.txt; in the folder itself, in colmap_ground_truth, sparse/0 or sparse)
/// beside `images/`; the camera models SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL and OPENCV. All pairs. COLMAP's
/// first pixel has its centre at (0.5, 0.5), which the calibration takes back.
ImageSource ReadColmap(const std::string& folder);

/// Images of a plane with homographies from the first one: `H1toNp` and `img1.png` (Mikolajczyk et al., IJCV 2005) or
/// `H_1_N` and `1.ppm` (HPatches: Balntas et al., CVPR 2017).
ImageSource ReadHomographies(const std::string& folder);

/// Any images, all pairs, without truth. `calibration`: a file with one 3 × 3 matrix for all of them, or empty.
ImageSource ReadImageFolder(const std::string& folder, const std::string& calibration);

/// For the readers: the image files of a folder in the order of their names. Throws Error when there are none.
std::vector<std::string> ListImages(const std::string& folder);
/// A file's name without its extension and with '_' for '-'.
std::string ImageName(const std::string& path);
/// All pairs (i, j), i < j.
std::vector<SourcePair> AllPairs(int num_images);
/// The folder's own name, for a scene.
std::string FolderName(const std::string& folder);
/// Throws Error unless the images' names are unique and there is a pair.
void CheckSource(const ImageSource& source, const std::string& folder);

}  // namespace diffsac
