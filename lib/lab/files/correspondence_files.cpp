#include "lab/files/correspondence_files.h"

#include <H5Cpp.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>

#include "diffsac/core/status.h"
#include "diffsac/geometry/calibration.h"
#include "diffsac/problem/tasks.h"
#include "lab/files/hdf5_numbers.h"
#include "lab/ground_truth/pair_truth.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;
using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

// By H5Literate, since asking for the i-th name walks the list anew: 100 000 pairs would take hours.
std::vector<std::string> NamesIn(const H5::H5File& file, const std::string& path) {
  std::vector<std::string> names;
  const auto append = [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
    static_cast<std::vector<std::string>*>(out)->push_back(name);
    return 0;
  };
  hsize_t position = 0;
  if (H5Literate(file.getId(), H5_INDEX_NAME, H5_ITER_INC, &position, append, &names) < 0)
    throw Error(path + ": damaged or truncated: its data sets cannot be listed");
  return names;
}

// One of the files of a scene. Callers hold the lock.
class LazyFile {
 public:
  LazyFile(const std::string& folder, const std::string& name) : path_((fs::path(folder) / name).string()) {
    std::error_code code;
    exists_ = fs::exists(path_, code);
  }

  bool exists() const { return exists_; }
  const std::string& path() const { return path_; }
  std::string Place(const std::string& key) const { return path_ + ": " + key; }

  std::vector<std::string> Names() {
    return WithClearErrors(path_, [&] { return NamesIn(Open(), path_); });
  }

  void Close() { file_.reset(); }

  Numbers Read(const std::string& key) {
    WithClearErrors(path_, [&] { Open(); });
    const std::string place = Place(key);
    return WithClearErrors(place, [&] {
      if (!file_->nameExists(key)) throw Error(place + ": no such data set in this file");
      if (file_->childObjType(key) != H5O_TYPE_DATASET) throw Error(place + ": expected a data set");
      return ReadNumbers(file_->openDataSet(key), place);
    });
  }

  // `shape` stands in the message ("3x3").
  Numbers ReadExactly(const std::string& key, std::size_t count, const char* shape) {
    Numbers numbers = Read(key);
    if (numbers.values.size() != count)
      throw Error(Place(key) + ": expected " + shape + ", found " + ShapeText(numbers));
    return numbers;
  }

  Eigen::Matrix3d ReadMatrix(const std::string& key) {
    const Numbers numbers = ReadExactly(key, 9, "3x3");
    const RowMajor3 matrix = Eigen::Map<const RowMajor3>(numbers.values.data());
    if (!matrix.allFinite()) throw Error(Place(key) + ": a value is not finite");
    return matrix;
  }

 private:
  H5::H5File& Open() {
    if (file_) return *file_;
    if (!fs::exists(path_)) throw Error(path_ + ": no such file");
    file_.emplace(OpenHdf5(path_));
    return *file_;
  }

  std::string path_;
  bool exists_ = false;
  std::optional<H5::H5File> file_;
};

void SplitId(const std::string& id, std::string* image1, std::string* image2) {
  const std::size_t dash = id.find('-');
  if (dash == std::string::npos || dash == 0 || dash + 1 == id.size() || id.find('-', dash + 1) != std::string::npos)
    return;
  *image1 = id.substr(0, dash);
  *image2 = id.substr(dash + 1);
}

bool IsRotation(const Eigen::Matrix3d& R) {
  return (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-3 && R.determinant() > 0.0;
}

}  // namespace

struct CorrespondenceScene::Impl {
  Impl(const std::string& path, const CorrespondenceOptions& o) : folder(path), options(o) {}

  // All that this thread does with HDF5, closing included, happens under the lock.
  static void Destroy(std::unique_ptr<Impl> impl) {
    const std::lock_guard lock(Hdf5Mutex());
    impl.reset();
  }

  LazyFile& File(const std::string& name) { return files.try_emplace(name, folder, name).first->second; }

  void ReadProblem(const std::string& id, Problem* problem);
  void ReadTruth(const Example& example, GroundTruth* truth);
  RigidMotion ReadCamera(const std::string& image);
  Numbers ReadPerMatch(LazyFile& file, const std::string& id, Eigen::Index count);
  PointMatrix ReadScaleRotationChanges(const std::string& id, Eigen::Index count);

  std::string folder, scene;
  CorrespondenceOptions options;
  std::vector<std::string> pairs;
  std::map<std::string, LazyFile> files;
};

Numbers CorrespondenceScene::Impl::ReadPerMatch(LazyFile& file, const std::string& id, Eigen::Index count) {
  Numbers numbers = file.Read(id);
  if (static_cast<Eigen::Index>(numbers.values.size()) != count)
    throw Error(file.Place(id) + ": expected " + std::to_string(count) + " values, one a match, found " +
                ShapeText(numbers));
  return numbers;
}

PointMatrix CorrespondenceScene::Impl::ReadScaleRotationChanges(const std::string& id, Eigen::Index count) {
  LazyFile& scale_rotation_changes = File("similarities.h5");
  const Numbers numbers = scale_rotation_changes.Read(id);
  if (numbers.shape != std::vector<hsize_t>{static_cast<hsize_t>(count), 2})
    throw Error(scale_rotation_changes.Place(id) + ": expected " + std::to_string(count) +
                "x2 (log of the sizes' ratio, turn), found " + ShapeText(numbers));
  const PointMatrix rows = Eigen::Map<const PointMatrix>(numbers.values.data(), count, 2);
  if (!rows.allFinite()) throw Error(scale_rotation_changes.Place(id) + ": a value is not finite");
  return rows;
}

void CorrespondenceScene::Impl::ReadProblem(const std::string& id, Problem* problem) {
  LazyFile &matches = File("matches.h5"), &quality = File("match_conf.h5"), &scores = File("match_scores.h5"),
           &calibration = File("K1_K2.h5"), &sizes = File("sizes.h5"), &descriptors = File("descriptors.h5");
  const Numbers points = matches.Read(id);
  if (points.shape.size() != 2 || points.shape[1] != 4)
    throw Error(matches.Place(id) + ": expected Nx4 (x1 y1 x2 y2), found " + ShapeText(points));
  const auto count = static_cast<Eigen::Index>(points.shape[0]);
  problem->points = Eigen::Map<const PointMatrix>(points.values.data(), count, 4);
  problem->scored = scores.exists();
  if (problem->scored && quality.exists())
    throw Error(scores.path() + ": expected ratios, match_conf.h5, or scores, found both");
  if (problem->scored || quality.exists()) {
    const Numbers values = ReadPerMatch(problem->scored ? scores : quality, id, count);
    problem->snn_ratio = Eigen::Map<const Eigen::VectorXd>(values.values.data(), count);
  }
  if (problem->scored) {
    if (!(problem->snn_ratio.array() >= 0.0 && problem->snn_ratio.array() <= 1.0).all())
      throw Error(scores.Place(id) + ": expected scores from 0 to 1");
    problem->snn_ratio = 1.0 - problem->snn_ratio.array();
  }
  if (File("similarities.h5").exists()) problem->scale_rotation_changes = ReadScaleRotationChanges(id, count);
  if (calibration.exists()) {
    const Numbers both = calibration.ReadExactly(id, 18, "1x2x3x3 (K1, K2)");
    problem->cameras =
        CameraPair{CheckedCalibration(RowMajor3(both.values.data()), calibration.Place(id) + ": K1"),
                   CheckedCalibration(RowMajor3(both.values.data() + 9), calibration.Place(id) + ": K2")};
  }
  if (sizes.exists()) {
    const Numbers values = sizes.ReadExactly(id, 4, "4 values (h1 w1 h2 w2)");
    for (double value : values.values)
      if (!(value >= 0.0 && value < 1e9)) throw Error(sizes.Place(id) + ": expected sizes in pixels");
    const auto pixels = [&](int i) { return static_cast<int>(values.values[i]); };
    problem->size1 = {pixels(1), pixels(0)};
    problem->size2 = {pixels(3), pixels(2)};
  }
  if (options.descriptors && descriptors.exists()) {
    const Numbers rows = descriptors.Read(id);
    if (rows.shape.size() != 2 || static_cast<Eigen::Index>(rows.shape[0]) != count || rows.shape[1] % 2 != 0)
      throw Error(descriptors.Place(id) + ": expected " + std::to_string(count) +
                  "x2d (image 1, then image 2), found " + ShapeText(rows));
    problem->descriptors =
        Eigen::Map<const PointMatrix>(rows.values.data(), count, static_cast<Eigen::Index>(rows.shape[1]))
            .cast<float>();
  }
}

RigidMotion CorrespondenceScene::Impl::ReadCamera(const std::string& image) {
  LazyFile &rotations = File("R.h5"), &translations = File("T.h5");
  RigidMotion camera;
  camera.rotation = rotations.ReadMatrix(image);
  if (!IsRotation(camera.rotation)) throw Error(rotations.Place(image) + ": not a rotation matrix");
  const Numbers values = translations.ReadExactly(image, 3, "3 values");
  camera.translation = Eigen::Map<const Eigen::Vector3d>(values.values.data());
  if (!camera.translation.allFinite()) throw Error(translations.Place(image) + ": a value is not finite");
  return camera;
}

void CorrespondenceScene::Impl::ReadTruth(const Example& example, GroundTruth* truth) {
  LazyFile &rotations = File("R.h5"), &translations = File("T.h5"), &labels = File("labels.h5");
  if (rotations.exists() != translations.exists()) {
    const bool has_rotations = rotations.exists();
    throw Error((has_rotations ? translations : rotations).path() + ": no such file, but " +
                (has_rotations ? "R.h5" : "T.h5") + " is there");
  }
  if (rotations.exists()) {
    if (example.image1.empty())
      throw Error(File("matches.h5").Place(example.id) + ": expected the name of a pair, img1-img2");
    truth->motion = RelativeMotion(ReadCamera(example.image1), ReadCamera(example.image2));
  }
  if (File("Egt.h5").exists()) truth->essential = File("Egt.h5").ReadMatrix(example.id);
  if (File("Fgt.h5").exists()) truth->fundamental = File("Fgt.h5").ReadMatrix(example.id);
  if (File("Hgt.h5").exists()) truth->homography = File("Hgt.h5").ReadMatrix(example.id);
  if (labels.exists()) {
    for (double value : ReadPerMatch(labels, example.id, example.problem.points.rows()).values) {
      if (!(value >= 0.0 && value < 1e9)) throw Error(labels.Place(example.id) + ": expected labels 0, 1, ...");
      truth->assignment.push_back(static_cast<std::int32_t>(value));
    }
  }
  CompleteTruth(example.problem, truth);
}

CorrespondenceScene::CorrespondenceScene(const std::string& folder, const CorrespondenceOptions& options) {
  std::error_code code;
  if (!fs::is_directory(folder, code)) throw Error(folder + ": no such folder");
  const std::lock_guard lock(Hdf5Mutex());
  impl_ = std::make_unique<Impl>(folder, options);
  // The last part of the path also for "a/b/" and ".".
  const fs::path whole = fs::weakly_canonical(folder, code);
  impl_->scene = (code ? fs::path(folder) : whole).filename().string();
  LazyFile& matches = impl_->File("matches.h5");
  if (!matches.exists())
    throw Error(matches.path() + ": no such file (no correspondences, or their writing was interrupted)");
  impl_->pairs = matches.Names();
  if (impl_->pairs.empty()) throw Error(matches.path() + ": holds no pairs");
}

CorrespondenceScene::~CorrespondenceScene() {
  if (impl_) Impl::Destroy(std::move(impl_));
}
CorrespondenceScene::CorrespondenceScene(CorrespondenceScene&&) noexcept = default;
CorrespondenceScene& CorrespondenceScene::operator=(CorrespondenceScene&& other) noexcept {
  std::swap(impl_, other.impl_);
  return *this;
}

const std::string& CorrespondenceScene::folder() const { return impl_->folder; }
const std::string& CorrespondenceScene::scene() const { return impl_->scene; }
const std::vector<std::string>& CorrespondenceScene::pairs() const { return impl_->pairs; }

Example CorrespondenceScene::Read(std::int64_t index) const {
  if (index < 0 || index >= size())
    throw Error(impl_->folder + ": no pair number " + std::to_string(index) + ", it holds " + std::to_string(size()));
  const std::lock_guard lock(Hdf5Mutex());
  Example example;
  example.problem.task = Task::kFundamental;
  example.problem.inlier_threshold = 1.0;
  example.id = impl_->pairs[static_cast<std::size_t>(index)];
  example.scene = impl_->scene;
  SplitId(example.id, &example.image1, &example.image2);
  impl_->ReadProblem(example.id, &example.problem);
  impl_->ReadTruth(example, &example.truth);
  return example;
}

MatchIndices CorrespondenceScene::ReadMatchIndices(const std::string& id, Eigen::Index num_matches) const {
  const std::lock_guard lock(Hdf5Mutex());
  LazyFile& file = impl_->File("match_indices.h5");
  const Numbers numbers = file.Read(id);
  const auto count = static_cast<hsize_t>(num_matches);
  if (numbers.shape != std::vector<hsize_t>{count, 2})
    throw Error(file.Place(id) + ": expected " + std::to_string(count) + "x2, found " + ShapeText(numbers));
  for (const double value : numbers.values)
    if (!(value >= 0.0 && value < 2147483648.0))
      throw Error(file.Place(id) + ": expected rows of keypoints, 0, 1, ...");
  return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>>(numbers.values.data(), num_matches,
                                                                                     2)
      .cast<std::int32_t>();
}

void CorrespondenceScene::CloseFiles() const {
  const std::lock_guard lock(Hdf5Mutex());
  for (auto& [name, file] : impl_->files) file.Close();
}

}  // namespace diffsac
