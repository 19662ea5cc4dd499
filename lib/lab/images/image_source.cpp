#include "lab/images/image_source.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <set>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "diffsac/geometry/calibration.h"
#include "lab/colmap/model.h"
#include "lab/files/files.h"
#include "lab/files/text_scan.h"
#include "lab/images/run_pairs.h"

namespace diffsac {
namespace fs = std::filesystem;

bool PassOverOwnPicture(const std::string& path) {
  const bool own = fs::absolute(path).lexically_normal().parent_path().filename() == kPictureFolder;
  if (own) LogWarning("left out: " + path + ": a picture that DiffSAC drew");
  return own;
}

std::vector<std::string> ListImages(const std::string& folder) {
  // What OpenCV reads, as it was built; and what cameras write besides, which is not passed over without a word.
  static const std::set<std::string> kExtensions = {".png", ".jpg", ".jpeg", ".jpe", ".jp2", ".webp", ".avif", ".bmp",
                                                    ".dib", ".tif", ".tiff", ".ppm", ".pgm", ".pbm",  ".pnm",  ".pam",
                                                    ".pxm", ".pfm", ".sr",   ".ras", ".exr", ".hdr",  ".pic",  ".gif"},
                                     kNotRead = {".heic", ".heif", ".jxl", ".dng", ".cr2", ".cr3",
                                                 ".nef",  ".arw",  ".orf", ".raf", ".rw2"};
  std::error_code code;
  if (!fs::is_directory(folder, code)) throw Error(folder + ": no such folder");
  std::vector<std::string> paths;
  for (const auto& entry : fs::directory_iterator(folder)) {
    std::string extension = entry.path().extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    const std::string path = entry.path().string();
    if (kNotRead.contains(extension)) LogWarning("left out: " + path + ": no format of images that is read");
    if (kExtensions.contains(extension) && !PassOverOwnPicture(path)) paths.push_back(path);
  }
  if (paths.empty()) throw Error(folder + ": no images in this folder");
  std::sort(paths.begin(), paths.end());
  return paths;
}

std::string ImageName(const std::string& path) {
  std::string name = fs::path(path).stem().string();
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

std::vector<SourcePair> AllPairs(int num_images) {
  std::vector<SourcePair> pairs;
  for (int i = 0; i < num_images; ++i)
    for (int j = i + 1; j < num_images; ++j) pairs.push_back({i, j, {}});
  return pairs;
}

std::string FolderName(const std::string& folder) {
  std::error_code code;
  const fs::path whole = fs::weakly_canonical(folder, code);
  return (code ? fs::path(folder) : whole).filename().string();
}

void AddImage(const std::string& name, const std::function<SourceImage()>& read, ImageSource* source) {
  const int frame = static_cast<int>(source->images.size() + source->left_out.size());
  try {
    SourceImage image = read();
    if (image.camera) image.camera->K = CheckedCalibration(image.camera->K, image.path);
    image.frame = frame;
    source->images.push_back(std::move(image));
  } catch (const Error& error) {
    source->left_out.push_back({name, error.what()});
  }
}

std::string StepName(const std::string& name, int step) {
  const std::string number = std::to_string(step);
  return name + "_step_" + (number.size() < 2 ? "0" : "") + number;
}

std::vector<std::string> GivenCalibration::Inputs() const {
  std::vector<std::string> inputs = files;
  inputs.insert(inputs.end(), {file, cameras});
  std::error_code code;
  for (const char* extension : {".txt", ".bin"}) {
    if (cameras.empty()) break;
    const bool folder = fs::is_directory(cameras, code);
    inputs.push_back(FindColmapModel(folder ? cameras : fs::path(cameras).parent_path().string(), extension));
  }
  return inputs;
}

bool GivenCalibration::IsGiven() const {
  return !file.empty() || focal != 0.0 || !center.empty() || !files.empty() || !cameras.empty();
}

std::optional<LensCamera> CameraOf(const GivenCalibration& given) {
  LensCamera camera;
  if (!given.files.empty() || !given.cameras.empty()) throw Error("expected one calibration for all images");
  if (!given.file.empty()) {
    if (given.focal != 0.0 || !given.center.empty()) throw Error("--calibration excludes --focal and --center");
    camera.K = ReadCalibrationMatrix(given.file);
    return camera;
  }
  if (given.focal == 0.0 && given.center.empty()) return {};
  if (!(given.focal > 0.0) || given.center.size() != 2)
    throw Error("expected a positive --focal and two numbers as --center, both in pixels");
  camera.K << given.focal, 0.0, given.center[0], 0.0, given.focal, given.center[1], 0.0, 0.0, 1.0;
  if (!camera.K.allFinite()) throw Error("--focal and --center must be finite");
  return camera;
}

void CheckSource(const ImageSource& source, const std::string& folder) {
  std::set<std::string> names;
  for (const SourceImage& image : source.images)
    if (!names.insert(image.name).second) throw Error(folder + ": two images are named " + image.name);
  for (const SourceScene& scene : source.scenes) {
    if (!scene.pairs.empty()) continue;
    std::string text = folder + ": no pairs of images for " + scene.name;
    if (!source.left_out.empty())
      text += "; " + std::to_string(source.left_out.size()) + " images were left out: " + source.left_out[0].problem;
    throw Error(text);
  }
}

void AddAllPairs(const std::string& folder, ImageSource* source, const PairChoice& choice) {
  source->scenes.push_back({FolderName(folder), {}});
  if (choice.HasPairs()) return;
  source->scenes.back().pairs = AllPairs(static_cast<int>(source->images.size()));
  CheckSource(*source, folder);
}

ImageSource ReadImageFolder(const std::string& folder, const GivenCalibration& calibration, const PairChoice& choice) {
  ImageSource source;
  const std::optional<LensCamera> camera = CameraOf(calibration);
  for (const std::string& path : ListImages(folder))
    AddImage(
        ImageName(path),
        [&] {
          return SourceImage{ImageName(path), path, camera, {}};
        },
        &source);
  AddAllPairs(folder, &source, choice);
  return source;
}

namespace {

const Registered<ImageFormat> kImages("images", {.read =
                                                     [](const PairsRequest& request) {
                                                       return ReadImageFolder(request.input, request.calibration,
                                                                              request.choice);
                                                     },
                                                 .takes_calibration = true});

}  // namespace

ImageSource ReadColmapImages(const std::string& folder, const std::string& images) {
  ImageSource source;
  ReadColmapModel(folder, images,
                  [&](const std::string& name, const std::string& place, const std::function<ModelImage()>& read) {
                    const auto as_source = [&] {
                      const ModelImage image = read();
                      return SourceImage{ImageName(image.file), image.file, image.camera, image.pose};
                    };
                    AddImage(name.empty() ? place : ImageName(name), as_source, &source);
                  });
  return source;
}

ImageSource ReadColmap(const std::string& folder, const PairChoice& choice) {
  ImageSource source = ReadColmapImages(folder, (std::filesystem::path(folder) / "images").string());
  std::sort(source.images.begin(), source.images.end(),
            [](const SourceImage& a, const SourceImage& b) { return a.name < b.name; });
  std::vector<std::string> names;
  for (const SourceImage& image : source.images) names.push_back(image.name);
  for (const LeftOutImage& image : source.left_out) names.push_back(image.name);
  std::sort(names.begin(), names.end());
  for (SourceImage& image : source.images)
    image.frame = static_cast<int>(std::lower_bound(names.begin(), names.end(), image.name) - names.begin());
  AddAllPairs(folder, &source, choice);
  return source;
}

namespace {

const Registered<ImageFormat> kColmap("colmap", {.read = [](const PairsRequest& request) {
                                        return ReadColmap(request.input, request.choice);
                                      }});

// How a set names its files.
struct Naming {
  std::string image, matrix_prefix, matrix_suffix;
  std::string Matrix(int n) const { return matrix_prefix + std::to_string(n) + matrix_suffix; }
  std::string Image(int n) const { return image + std::to_string(n); }
};

std::string PathOf(const std::vector<std::string>& images, const std::string& stem, const std::string& folder) {
  const auto found =
      std::find_if(images.begin(), images.end(), [&](const auto& path) { return fs::path(path).stem() == stem; });
  if (found == images.end()) throw Error(folder + ": no image " + stem);
  return *found;
}

}  // namespace

ImageSource ReadHomographies(const std::string& folder) {
  const std::vector<std::string> images = ListImages(folder);
  for (const Naming& naming : {Naming{"img", "H1to", "p"}, Naming{"", "H_1_", ""}}) {
    ImageSource source;
    SourceScene scene{FolderName(folder), {}};
    for (int n = 2; fs::exists(fs::path(folder) / naming.Matrix(n)); ++n) {
      if (n == 2) source.images.push_back({naming.Image(1), PathOf(images, naming.Image(1), folder), {}, {}});
      Eigen::Matrix3d H;
      const auto read = [&] {
        H = ReadMatrixFile((fs::path(folder) / naming.Matrix(n)).string());
        if (!H.allFinite() || H.isZero(0.0)) throw Error(folder + "/" + naming.Matrix(n) + ": expected a homography");
        return SourceImage{naming.Image(n), PathOf(images, naming.Image(n), folder), {}, {}};
      };
      const std::size_t before = source.images.size();
      AddImage(naming.Image(n), read, &source);
      if (source.images.size() > before) scene.pairs.push_back({0, static_cast<int>(before), H});
    }
    if (source.images.empty()) continue;
    source.scenes.push_back(std::move(scene));
    CheckSource(source, folder);
    return source;
  }
  throw Error(folder + ": no homographies H1to2p ... or H_1_2 ...");
}

namespace {

const Registered<ImageFormat> kHomographies("homographies", {.read = [](const PairsRequest& request) {
                                              return ReadHomographies(request.input);
                                            }});

// "P0: " and twelve numbers, a row-major 3 × 4 matrix; the left grey camera is the origin, so its left part is K.
LensCamera ReadCalibration(const std::string& path) {
  const std::string text = ReadTextFile(path);
  std::string_view rest = text, line;
  for (int number = 1; TakeLine(&rest, &line); ++number) {
    const auto words = SplitWords(line, " \t");
    if (words.empty() || words[0] != "P0:") continue;
    double p[12];
    bool good = words.size() == 13;
    for (int i = 0; good && i < 12; ++i) good = ParseNumber(words[i + 1], &p[i]);
    if (!good) throw Error(path + ":" + std::to_string(number) + ": expected twelve numbers after P0:");
    LensCamera camera;
    camera.K << p[0], p[1], p[2], p[4], p[5], p[6], p[8], p[9], p[10];
    return camera;
  }
  throw Error(path + ": no line P0:");
}

// One frame of the file of poses.
struct PoseLine {
  RigidMotion pose;
  std::string problem;  // empty: none
};

// World-to-camera, of a camera-to-world matrix row by row; the nearest rotation in place of what is one within 1 %.
RigidMotion PoseOf(const std::vector<double>& values, const std::string& place) {
  constexpr double kTolerance = 0.01, kRounding = 1e-6;
  if (values.size() != 12) throw Error(place + ": expected 12 numbers, found " + std::to_string(values.size()));
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> rows(values.data());
  if (!rows.allFinite()) throw Error(place + ": the pose is not finite");
  RigidMotion to_world{rows.leftCols<3>(), rows.col(3)};
  const Eigen::Matrix3d square = to_world.rotation * to_world.rotation.transpose();
  if (!square.isApprox(Eigen::Matrix3d::Identity(), kTolerance) || to_world.rotation.determinant() < 0.0)
    throw Error(place + ": the pose holds no rotation");
  // Few digits, or a tracker that drifted: an essential matrix needs the rotation that is meant.
  if (!square.isApprox(Eigen::Matrix3d::Identity(), kRounding)) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(to_world.rotation, Eigen::ComputeFullU | Eigen::ComputeFullV);
    to_world.rotation = svd.matrixU() * svd.matrixV().transpose();
  }
  return Inverse(to_world);
}

// A line that makes no sense costs its frame alone.
std::vector<PoseLine> ReadPoseLines(const std::string& path) {
  const std::string text = ReadTextFile(path);
  std::vector<PoseLine> lines;
  std::string_view rest = text, line;
  for (int number = 1; TakeLine(&rest, &line); ++number) {
    const auto words = SplitWords(line, " \t");
    if (words.empty()) continue;
    const std::string place = path + ":" + std::to_string(number);
    PoseLine parsed;
    try {
      std::vector<double> values(words.size());
      for (std::size_t i = 0; i < words.size(); ++i)
        if (!ParseNumber(words[i], &values[i])) throw Error(place + ": '" + std::string(words[i]) + "' is no number");
      parsed.pose = PoseOf(values, place);
    } catch (const Error& error) {
      parsed.problem = error.what();
    }
    lines.push_back(std::move(parsed));
  }
  return lines;
}

int FrameNumber(const std::string& path) {
  const std::string name = fs::path(path).stem().string();
  int number = -1;
  const auto result = std::from_chars(name.data(), name.data() + name.size(), number);
  if (result.ec != std::errc() || result.ptr != name.data() + name.size() || number < 0)
    throw Error(path + ": expected a frame's number as name");
  return number;
}

}  // namespace

ImageSource ReadKitti(const std::string& root, const std::string& sequence, PairChoice choice) {
  const fs::path folder = fs::path(root) / "sequences" / sequence;
  const std::string pose_path = (fs::path(root) / "poses" / (sequence + ".txt")).string();
  const LensCamera camera = ReadCalibration((folder / "calib.txt").string());
  const std::vector<PoseLine> poses = ReadPoseLines(pose_path);
  ImageSource source;
  for (const std::string& path : ListImages((folder / "image_0").string())) {
    int frame = -1;
    const auto read = [&] {
      frame = FrameNumber(path);
      if (frame >= static_cast<int>(poses.size())) throw Error(pose_path + ": no pose for " + path);
      if (!poses[frame].problem.empty()) throw Error(poses[frame].problem);
      return SourceImage{ImageName(path), path, camera, poses[frame].pose};
    };
    const std::size_t before = source.images.size();
    AddImage(ImageName(path), read, &source);
    if (source.images.size() > before) source.images.back().frame = frame;
  }
  source.scenes.push_back({"kitti_" + sequence, {}});
  if (!choice.HasPairs()) choice.steps = {1};
  ChoosePairs(choice, folder.string(), &source);
  return source;
}

namespace {

const Registered<ImageFormat> kKitti("kitti", {.read =
                                                   [](const PairsRequest& request) {
                                                     return ReadKitti(request.input, request.sequence, request.choice);
                                                   },
                                               .takes_sequence = true,
                                               .chooses_pairs = true});

}  // namespace

}  // namespace diffsac
