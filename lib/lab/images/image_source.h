#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "diffsac/geometry/rigid_motion.h"
#include "lab/colmap/lens.h"

namespace diffsac {

/// An image with what its source knows about it.
struct SourceImage {
  std::string name;  ///< Unique in the source, without '-' (which joins the names of a pair).
  std::string path;
  std::optional<LensCamera> camera;
  std::optional<RigidMotion> pose;  ///< World-to-camera.
  int frame = -1;                   ///< Its place among all images of the source, those left out included; -1: unknown.
};

/// An image whose pose or calibration is missing or makes no sense.
struct LeftOutImage {
  std::string name, problem;  ///< The problem names the file.
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
  std::vector<LeftOutImage> left_out;
};

/// Which images and pairs of a source are used.
struct PairChoice {
  int every = 1;  ///< Only every so many images, from the first.
  /// A scene <name>_step_<step> for each: the pairs (i, i + step) of used images. Empty: all pairs.
  std::vector<int> steps = {};
  /// A text file with the names of two images in each line (with or without extension and folder); empty: all pairs.
  std::string pairs_file = {};
  /// Whether it says which pairs there are, not which of all are left out.
  bool HasPairs() const { return !steps.empty() || !pairs_file.empty(); }
  /// Whether every image that there is is used, in all the pairs that the source has.
  bool IsAll() const { return every == 1 && !HasPairs(); }
};

/// Calibration of images that come without one.
struct GivenCalibration {
  std::string file;                     ///< One 3 × 3 matrix for all images.
  double focal = 0.0;                   ///< Pixels; with `center` instead of a file.
  std::vector<double> center;           ///< cx, cy, pixels.
  std::vector<std::string> files = {};  ///< A 3 × 3 matrix for each image, instead of the above (ImageCameras).
  std::string cameras = {};             ///< COLMAP's cameras.txt, or the folder of a model of it, likewise.
  /// Whether there is anything.
  bool IsGiven() const;
  /// The files that are read for it, and folders of them, for RefuseInputsAsOutputs.
  std::vector<std::string> Inputs() const;
};

// The readers below throw Error with one line that names the file (and its line) when the source as a whole cannot be
// used. A single image without a sound pose is left out and listed.

/// KITTI odometry (Geiger et al., "Are we ready for autonomous driving?", CVPR 2012) in the official layout:
/// `sequences/<sequence>/image_0/%06d.png` and `calib.txt` (P0), `poses/<sequence>.txt`, camera-to-world, a line a
/// frame. A scene for each step, kitti_<sequence>_step_<step>: the pairs (i, i + step); of step 1 where no pairs are
/// chosen.
ImageSource ReadKitti(const std::string& root, const std::string& sequence, PairChoice choice = {});

/// A COLMAP model (cameras.txt and images.txt, or where there are none cameras.bin and images.bin; in the folder
/// itself, in colmap_ground_truth, sparse/0 or sparse) beside `images/`; every camera model of ColmapLens. All pairs.
/// COLMAP's first pixel has its centre at (0.5, 0.5), which the calibration takes back.
ImageSource ReadColmap(const std::string& folder, const PairChoice& choice = {});
/// The same without pairs, in the order of the model, of files in the folder `images`.
ImageSource ReadColmapImages(const std::string& folder, const std::string& images);

/// Images of a plane with homographies from the first one: `H1toNp` and `img1.png` (Mikolajczyk et al., IJCV 2005) or
/// `H_1_N` and `1.ppm` (HPatches: Balntas et al., CVPR 2017).
ImageSource ReadHomographies(const std::string& folder);

/// Any images, all pairs (AddAllPairs), without truth.
ImageSource ReadImageFolder(const std::string& folder, const GivenCalibration& calibration = {},
                            const PairChoice& choice = {});

/// Replaces the pairs of a source by those chosen. Pairs of images that were left out are dropped. Throws Error: a
/// source whose pairs have a truth of their own, an unknown name, no pairs.
void ChoosePairs(const PairChoice& choice, const std::string& folder, ImageSource* source);

/// The image files that a list of pairs names (PairChoice::pairs_file), each once: of the list's folder where there is
/// such a file. Throws Error.
std::vector<std::string> ImagesOfList(const std::string& path);

/// The folder in which programs draw pictures unless they are given a name.
inline constexpr const char* kPictureFolder = "diffsac_pictures";
/// Whether a file lies in a folder of that name; with a line in the log, for what lists photographs.
bool PassOverOwnPicture(const std::string& path);

// For the readers: the image files of a folder in the order of their names; pictures in kPictureFolder, and
// photographs in formats that are not read, are left out, with a warning each. Throws Error when there are none.
std::vector<std::string> ListImages(const std::string& folder);
/// A file's name without its extension and with '_' for '-'.
std::string ImageName(const std::string& path);
/// All pairs (i, j), i < j.
std::vector<SourcePair> AllPairs(int num_images);
/// The folder's own name, for a scene.
std::string FolderName(const std::string& folder);
/// Adds what `read` returns as the image of the next frame, or, when it throws Error or the
/// calibration is none, the image to those left out.
void AddImage(const std::string& name, const std::function<SourceImage()>& read, ImageSource* source);
/// "<name>_step_05".
std::string StepName(const std::string& name, int step);
/// K of a file: nine numbers row by row, with commas and brackets or without; NumPy's .npy; a JSON file, where it may
/// stand at K or camera_matrix, or as fx, fy, cx and cy. Throws Error unless it is a calibration matrix.
Eigen::Matrix3d ReadCalibrationMatrix(const std::string& path);
/// The camera of a calibration that is given for all images alike, none when nothing is given. Throws Error.
std::optional<LensCamera> CameraOf(const GivenCalibration& calibration);
/// Makes all pairs of the images the only scene, named like the folder, and checks the source (CheckSource). Where the
/// choice brings its own pairs there are none yet: those of 20 000 images would not fit into memory.
void AddAllPairs(const std::string& folder, ImageSource* source, const PairChoice& choice = {});
/// Throws Error unless the images' names are unique and there is a pair; with the first image that was left out.
void CheckSource(const ImageSource& source, const std::string& folder);

}  // namespace diffsac
