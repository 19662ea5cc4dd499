#include <array>
#include <filesystem>
#include <set>

#include "diffsac/core/status.h"
#include "lab/files/correspondence_files.h"
#include "lab/files/files.h"
#include "lab/files/hdf5_numbers.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;
using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr const char* kFiles[] = {
    "matches.h5",     "match_conf.h5",    "K1_K2.h5",        "R.h5",           "T.h5",
    "Egt.h5",         "Fgt.h5",           "Hgt.h5",          "sizes.h5",       "labels.h5",
    "descriptors.h5", "match_indices.h5", "similarities.h5", "match_scores.h5"};

void PutMatrix(Hdf5Output& file, const std::string& key, const Eigen::Matrix3d& matrix) {
  const RowMajor3 rows = matrix;
  file.Put(key, rows.data(), {3, 3});
}

void PutSizes(Hdf5Output& file, const std::string& id, const ImageSize& size1, const ImageSize& size2) {
  const std::int32_t sizes[] = {size1.height, size1.width, size2.height, size2.width};
  file.Put(id, sizes, {4});
}

void PutRows(Hdf5Output& file, const std::string& id, const DescriptorMatrix& rows) {
  file.Put(id, rows.data(), {static_cast<hsize_t>(rows.rows()), static_cast<hsize_t>(rows.cols())});
}

// Writes the files of one set into one folder.
class SceneWriter {
 public:
  SceneWriter(const std::string& folder, const CorrespondenceSet& set) : folder_(folder), set_(set) {}

  void Write();

 private:
  std::string Path(const char* name) const { return (fs::path(folder_) / name).string(); }

  template <class Fill>
  void WriteFile(const char* name, Fill fill) const {
    if (only_check_) return;
    WriteHdf5(Path(name), fill);
  }

  // The file, when all pairs have what it holds.
  template <class HasIt, class Put>
  void WriteOptional(const char* name, HasIt has, Put put) const {
    std::size_t count = 0;
    for (const Example& pair : set_.pairs) count += has(pair) ? 1 : 0;
    if (count == 0) return;
    if (count < set_.pairs.size())
      throw Error(Path(name) + ": only " + std::to_string(count) + " of " + std::to_string(set_.pairs.size()) +
                  " pairs have a value for it");
    WriteFile(name, [&](Hdf5Output& file) {
      for (const Example& pair : set_.pairs) put(file, pair);
    });
  }

  // The same for values of each match; a pair without matches goes with the others.
  template <class SizeOf, class Put>
  void WritePerMatch(const char* name, SizeOf size_of, Put put) const {
    Eigen::Index total = 0;
    for (const Example& pair : set_.pairs) total += size_of(pair);
    if (total == 0) return;
    WriteOptional(
        name, [&](const Example& pair) { return size_of(pair) == pair.problem.points.rows(); }, put);
  }

  template <class Member>
  void WriteModel(const char* name, Member member) const {
    WriteOptional(
        name, [&](const Example& pair) { return (pair.truth.*member).has_value(); },
        [&](Hdf5Output& file, const Example& pair) { PutMatrix(file, pair.id, *(pair.truth.*member)); });
  }

  void WriteAll() const;
  void CheckPairs() const;
  void CheckCounts(const Example& pair) const;
  void RemoveEarlierFiles() const;
  void WriteMatches() const;
  void WriteInputs() const;
  void WriteCameras() const;
  void WriteDescriptors() const;
  void WriteLabels() const;
  void WriteMatchIndices() const;

  std::string folder_;
  const CorrespondenceSet& set_;
  bool only_check_ = false;  // go through all files without writing any
};

void SceneWriter::CheckCounts(const Example& pair) const {
  const Problem& problem = pair.problem;
  const Eigen::Index count = problem.points.rows();
  const bool fits = problem.points.cols() == 4 &&
                    (problem.snn_ratio.size() == 0 || problem.snn_ratio.size() == count) &&
                    (problem.scale_rotation_changes.size() == 0 ||
                     (problem.scale_rotation_changes.rows() == count && problem.scale_rotation_changes.cols() == 2)) &&
                    (problem.descriptors.size() == 0 || problem.descriptors.rows() == count) &&
                    (pair.truth.assignment.empty() || static_cast<Eigen::Index>(pair.truth.assignment.size()) == count);
  if (!fits) throw Error(folder_ + ": " + pair.id + ": the points are not Nx4, or other values are not N");
  if (!problem.scale_rotation_changes.allFinite())
    throw Error(Path("similarities.h5") + ": " + pair.id + ": a value is not finite");
}

void SceneWriter::CheckPairs() const {
  if (set_.pairs.empty()) throw Error(folder_ + ": there are no pairs to write");
  std::set<std::string> ids;
  for (const Example& pair : set_.pairs) {
    if (pair.id.empty() || pair.id == "." || pair.id.find('/') != std::string::npos)
      throw Error(folder_ + ": '" + pair.id + "' cannot name a data set");
    if (!ids.insert(pair.id).second) throw Error(folder_ + ": " + pair.id + ": two pairs have this name");
    if (!set_.cameras.empty() && (set_.cameras.count(pair.image1) == 0 || set_.cameras.count(pair.image2) == 0 ||
                                  pair.id != pair.image1 + "-" + pair.image2))
      throw Error(folder_ + ": " + pair.id + ": expected img1-img2 with a camera for each");
    CheckCounts(pair);
  }
}

void SceneWriter::RemoveEarlierFiles() const {
  for (const char* name : kFiles) RemoveFile(Path(name));
}

void SceneWriter::WriteMatches() const {
  WriteFile("matches.h5", [&](Hdf5Output& file) {
    for (const Example& pair : set_.pairs)
      file.Put(pair.id, pair.problem.points.data(), {static_cast<hsize_t>(pair.problem.points.rows()), 4});
  });
}

void SceneWriter::WriteInputs() const {
  for (const bool scored : {false, true})
    WritePerMatch(
        scored ? "match_scores.h5" : "match_conf.h5",
        [=](const Example& pair) { return pair.problem.scored == scored ? pair.problem.snn_ratio.size() : 0; },
        [=](Hdf5Output& file, const Example& pair) {
          Eigen::VectorXd values = pair.problem.snn_ratio;
          if (scored) values = 1.0 - values.array();
          file.Put(pair.id, values.data(), {static_cast<hsize_t>(values.size())});
        });
  WritePerMatch(
      "similarities.h5", [](const Example& pair) { return pair.problem.scale_rotation_changes.rows(); },
      [](Hdf5Output& file, const Example& pair) {
        const PointMatrix& rows = pair.problem.scale_rotation_changes;
        file.Put(pair.id, rows.data(), {static_cast<hsize_t>(rows.rows()), 2});
      });
  WriteOptional(
      "K1_K2.h5", [](const Example& pair) { return pair.problem.cameras.has_value(); },
      [](Hdf5Output& file, const Example& pair) {
        std::array<double, 18> both;
        Eigen::Map<RowMajor3>(both.data()) = pair.problem.cameras->K1;
        Eigen::Map<RowMajor3>(both.data() + 9) = pair.problem.cameras->K2;
        file.Put(pair.id, both.data(), {1, 2, 3, 3});
      });
  WriteOptional(
      "sizes.h5", [](const Example& pair) { return pair.problem.size1.width > 0 && pair.problem.size2.width > 0; },
      [](Hdf5Output& file, const Example& pair) { PutSizes(file, pair.id, pair.problem.size1, pair.problem.size2); });
}

void SceneWriter::WriteCameras() const {
  if (set_.cameras.empty()) return;
  WriteFile("R.h5", [&](Hdf5Output& file) {
    for (const auto& [image, camera] : set_.cameras) PutMatrix(file, image, camera.rotation);
  });
  WriteFile("T.h5", [&](Hdf5Output& file) {
    for (const auto& [image, camera] : set_.cameras) file.Put(image, camera.translation.data(), {3});
  });
}

void SceneWriter::WriteDescriptors() const {
  if (set_.descriptors) {
    WriteFile("descriptors.h5", [&](Hdf5Output& file) {
      for (std::size_t i = 0; i < set_.pairs.size(); ++i) {
        const DescriptorMatrix rows = set_.descriptors(i);
        if (rows.rows() != set_.pairs[i].problem.points.rows())
          throw Error(Path("descriptors.h5") + ": " + set_.pairs[i].id + ": expected one row a match");
        PutRows(file, set_.pairs[i].id, rows);
      }
    });
    return;
  }
  WritePerMatch(
      "descriptors.h5", [](const Example& pair) { return pair.problem.descriptors.rows(); },
      [&](Hdf5Output& file, const Example& pair) { PutRows(file, pair.id, pair.problem.descriptors); });
}

void SceneWriter::WriteLabels() const {
  WritePerMatch(
      "labels.h5", [](const Example& pair) { return static_cast<Eigen::Index>(pair.truth.assignment.size()); },
      [](Hdf5Output& file, const Example& pair) {
        file.Put(pair.id, pair.truth.assignment.data(), {static_cast<hsize_t>(pair.truth.assignment.size())});
      });
}

void SceneWriter::WriteMatchIndices() const {
  if (set_.match_indices.empty()) return;
  const std::size_t count = set_.pairs.size();
  bool fits = set_.match_indices.size() == count;
  for (std::size_t i = 0; fits && i < count; ++i)
    fits = set_.match_indices[i].rows() == set_.pairs[i].problem.points.rows();
  if (!fits) throw Error(Path("match_indices.h5") + ": expected two keypoints for each match of each pair");
  WriteFile("match_indices.h5", [&](Hdf5Output& file) {
    for (std::size_t i = 0; i < count; ++i)
      file.Put(set_.pairs[i].id, set_.match_indices[i].data(), {static_cast<hsize_t>(set_.match_indices[i].rows()), 2});
  });
}

void SceneWriter::WriteAll() const {
  WriteInputs();
  WriteCameras();
  WriteModel("Egt.h5", &GroundTruth::essential);
  WriteModel("Fgt.h5", &GroundTruth::fundamental);
  WriteModel("Hgt.h5", &GroundTruth::homography);
  WriteLabels();
  WriteMatchIndices();
  WriteDescriptors();
  WriteMatches();
}

void SceneWriter::Write() {
  CheckPairs();
  only_check_ = true;
  WriteAll();
  only_check_ = false;
  MakeWritableFolder(folder_);
  RemoveEarlierFiles();
  WriteAll();
}

}  // namespace

void WriteCorrespondences(const std::string& folder, const CorrespondenceSet& set) { SceneWriter(folder, set).Write(); }

}  // namespace diffsac
