#include "lab/eval/estimates.h"

#include <H5Cpp.h>

#include <algorithm>
#include <cmath>
#include <mutex>

#include "diffsac/core/status.h"
#include "diffsac/problem/problem.h"
#include "lab/files/files.h"
#include "lab/files/hdf5_input.h"
#include "lab/files/hdf5_numbers.h"

namespace diffsac {
namespace {

constexpr const char* kFormat = "diffsac estimates 1";
constexpr hsize_t kChunk = 1 << 14;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// A link's name cannot hold a slash.
std::string LinkName(std::string name) {
  std::replace(name.begin(), name.end(), '/', '_');
  return name.empty() || name == "." || name == ".." ? "_" + name : name;
}

template <class Value>
H5::PredType TypeOf();
template <>
H5::PredType TypeOf<double>() {
  return H5::PredType::NATIVE_DOUBLE;
}
template <>
H5::PredType TypeOf<float>() {
  return H5::PredType::NATIVE_FLOAT;
}
template <>
H5::PredType TypeOf<std::int32_t>() {
  return H5::PredType::NATIVE_INT32;
}
template <>
H5::PredType TypeOf<std::int64_t>() {
  return H5::PredType::NATIVE_INT64;
}
template <>
H5::PredType TypeOf<std::uint64_t>() {
  return H5::PredType::NATIVE_UINT64;
}

template <class Value>
void Put(H5::Group& group, const char* name, const std::vector<Value>& values, hsize_t columns = 0) {
  std::vector<hsize_t> shape = {columns == 0 ? values.size() : values.size() / columns};
  if (columns > 0) shape.push_back(columns);
  const H5::DataSpace space(static_cast<int>(shape.size()), shape.data());
  const H5::DSetCreatPropList properties = WithoutTimes();
  if (values.size() > kChunk && columns == 0) {
    properties.setChunk(1, &kChunk);
    properties.setDeflate(4);
  }
  const H5::DataSet data = group.createDataSet(name, TypeOf<Value>(), space, properties);
  if (!values.empty()) data.write(values.data(), TypeOf<Value>());
}

const H5::StrType& TextType() {
  static const H5::StrType type(H5::PredType::C_S1, H5T_VARIABLE);
  return type;
}

void PutTexts(H5::Group& group, const char* name, const std::vector<std::string>& texts) {
  const hsize_t count = texts.size();
  const H5::DataSet data = group.createDataSet(name, TextType(), H5::DataSpace(1, &count), WithoutTimes());
  std::vector<const char*> pointers;
  for (const std::string& text : texts) pointers.push_back(text.c_str());
  if (count > 0) data.write(pointers.data(), TextType());
}

void PutText(const H5::H5Object& object, const char* name, const std::string& text) {
  object.createAttribute(name, TextType(), H5::DataSpace(H5S_SCALAR)).write(TextType(), text);
}

/// The columns of one group, gathered from its records.
class Columns {
 public:
  explicit Columns(const std::vector<EstimateRecord>& records) {
    for (const EstimateRecord& record : records) {
      width_ = std::max(width_, static_cast<hsize_t>(record.model.size()));
      if (record.pose_covariance) covariance_width_ = static_cast<hsize_t>(record.pose_covariance->size());
    }
    for (const EstimateRecord& record : records) Add(record);
  }

  void Write(H5::Group& group) const {
    Put(group, "index", index_);
    PutTexts(group, "id", ids_);
    PutTexts(group, "scene", scenes_);
    PutTexts(group, "status", statuses_);
    Put(group, "model", models_, width_);
    Put(group, "pose", poses_, 12);
    PutTexts(group, "translation", translations_);
    if (has_other_pose_) Put(group, "other_pose", other_poses_, 12);
    Put(group, "share_behind", shares_behind_);
    if (covariance_width_ > 0) Put(group, "pose_covariance", covariances_, covariance_width_);
    if (has_focal_) {
      Put(group, "focal", focals_, kFocalWidth);
      Put(group, "focal_observable", focal_observable_);
    }
    Put(group, "score", scores_);
    Put(group, "noise_scale", noise_scales_);
    Put(group, "log_false_alarms", log_false_alarms_);
    Put(group, "draws", draws_);
    Put(group, "points", points_);
    Put(group, "inliers", inliers_);
    Put(group, "inliers_end", inliers_end_);
    Put(group, "inlier_threshold", inlier_thresholds_);
    if (!rows_.empty()) {
      Put(group, "rows", rows_);
      Put(group, "rows_end", rows_end_);
    }
    Put(group, "probabilities", probabilities_);
    Put(group, "probabilities_end", probabilities_end_);
    if (structures_.empty()) return;
    Put(group, "structures", structures_, width_);
    Put(group, "structures_end", structures_end_);
    Put(group, "labels", labels_);
    Put(group, "labels_end", labels_end_);
    if (has_values_) Put(group, "structure_values", structure_values_);
  }

 private:
  static void AddPose(const std::optional<RigidMotion>& pose, std::vector<double>* poses) {
    for (int i = 0; i < 12; ++i)
      poses->push_back(!pose ? kNan : i % 4 == 3 ? pose->translation[i / 4] : pose->rotation(i / 4, i % 4));
  }

  void Add(const EstimateRecord& record) {
    index_.push_back(record.index);
    ids_.push_back(record.id);
    scenes_.push_back(record.scene);
    statuses_.emplace_back(ToString(record.status));
    for (hsize_t i = 0; i < width_; ++i)
      models_.push_back(record.model.size() > 0 ? record.model[static_cast<Eigen::Index>(i)] : kNan);
    AddPose(record.pose, &poses_);
    AddPose(record.other_pose, &other_poses_);
    has_other_pose_ = has_other_pose_ || record.other_pose;
    shares_behind_.push_back(record.share_behind);
    translations_.push_back(ToString(record.translation));
    if (record.pose_covariance) {
      covariances_.insert(covariances_.end(), record.pose_covariance->data(),
                          record.pose_covariance->data() + record.pose_covariance->size());
    } else {
      covariances_.insert(covariances_.end(), covariance_width_, kNan);
    }
    AddFocal(record.focal);
    scores_.push_back(record.score);
    noise_scales_.push_back(record.noise_scale);
    log_false_alarms_.push_back(record.log_false_alarms);
    draws_.push_back(record.draws);
    points_.push_back(record.points);
    inliers_.insert(inliers_.end(), record.inliers.begin(), record.inliers.end());
    inliers_end_.push_back(static_cast<std::int64_t>(inliers_.size()));
    inlier_thresholds_.push_back(record.inlier_threshold);
    rows_.insert(rows_.end(), record.rows.begin(), record.rows.end());
    rows_end_.push_back(static_cast<std::int64_t>(rows_.size()));
    const auto& probabilities = record.inlier_probabilities;
    probabilities_.insert(probabilities_.end(), probabilities.begin(), probabilities.end());
    probabilities_end_.push_back(static_cast<std::int64_t>(probabilities_.size()));
    for (const ModelParameters& model : record.structures)
      structures_.insert(structures_.end(), model.data(), model.data() + model.size());
    structures_end_.push_back(static_cast<std::int64_t>(structures_.size() / width_));
    AddValues(record);
    labels_.insert(labels_.end(), record.assignment.begin(), record.assignment.end());
    labels_end_.push_back(static_cast<std::int64_t>(labels_.size()));
  }

  /// One for each structure: NaN where there is none.
  void AddValues(const EstimateRecord& record) {
    const bool known = record.structure_values.size() == record.structures.size();
    has_values_ = has_values_ || (known && !record.structures.empty());
    for (std::size_t k = 0; k < record.structures.size(); ++k)
      structure_values_.push_back(known ? record.structure_values[k] : kNan);
  }

  void AddFocal(const std::optional<FocalEstimate>& focal) {
    has_focal_ = has_focal_ || focal.has_value();
    focal_observable_.push_back(focal && focal->observable ? 1 : 0);
    for (int image = 0; image < 2; ++image) {
      focals_.push_back(focal ? focal->focal_px[image] : kNan);
      focals_.push_back(focal ? focal->low_px[image] : kNan);
      focals_.push_back(focal ? focal->high_px[image] : kNan);
    }
  }

  static constexpr hsize_t kFocalWidth = 6;
  hsize_t width_ = 1, covariance_width_ = 0;
  bool has_focal_ = false, has_values_ = false;
  std::vector<std::uint64_t> index_;
  std::vector<std::string> ids_, scenes_, statuses_, translations_;
  bool has_other_pose_ = false;
  std::vector<double> models_, poses_, other_poses_, shares_behind_, scores_, noise_scales_, log_false_alarms_,
      structures_, covariances_, focals_, inlier_thresholds_, structure_values_;
  std::vector<std::int64_t> draws_, points_, inliers_end_, rows_end_, probabilities_end_, structures_end_, labels_end_;
  std::vector<std::int32_t> inliers_, rows_, labels_, focal_observable_;
  std::vector<float> probabilities_;
};

template <class Value>
std::vector<Value> Get(const H5::Group& group, const char* name, std::size_t count) {
  const H5::DataSet data = group.openDataSet(name);
  std::vector<Value> values(CountOf(data, name));
  if (count != values.size()) throw Error(std::string(name) + ": expected " + std::to_string(count) + " values");
  if (!values.empty()) data.read(values.data(), TypeOf<Value>());
  return values;
}

template <class Value>
std::vector<Value> GetAll(const H5::Group& group, const char* name) {
  return Get<Value>(group, name, CountOf(group.openDataSet(name), name));
}

std::vector<std::string> GetTexts(const H5::Group& group, const char* name, std::size_t count) {
  const H5::DataSet data = group.openDataSet(name);
  if (CountOf(data, name) != count) throw Error(std::string(name) + ": expected " + std::to_string(count) + " texts");
  std::vector<char*> pointers(count);
  if (count > 0) data.read(pointers.data(), TextType());
  std::vector<std::string> texts;
  // A text that was never written is a null pointer.
  for (const char* text : pointers) texts.emplace_back(text == nullptr ? "" : text);
  if (count > 0) H5::DataSet::vlenReclaim(pointers.data(), TextType(), data.getSpace());
  return texts;
}

std::string GetText(const H5::H5Object& object, const char* name) { return ReadText(object.openAttribute(name), name); }

/// The part of `values` that belongs to record i.
template <class Value>
std::vector<Value> Slice(const std::vector<Value>& values, const std::vector<std::int64_t>& ends, std::size_t i) {
  const std::int64_t begin = i == 0 ? 0 : ends[i - 1], end = ends[i];
  if (begin < 0 || begin > end || end > static_cast<std::int64_t>(values.size()))
    throw Error("ends that are not in order");
  return {values.begin() + begin, values.begin() + end};
}

/// Of groups that have several structures; `width`: values in a model.
void ReadStructures(const H5::Group& group, std::size_t width, std::vector<EstimateRecord>* records) {
  if (!group.nameExists("structures")) return;
  const std::size_t count = records->size();
  const auto structures = GetAll<double>(group, "structures");
  const auto structures_end = Get<std::int64_t>(group, "structures_end", count),
             labels_end = Get<std::int64_t>(group, "labels_end", count);
  const auto labels = GetAll<std::int32_t>(group, "labels");
  if (width == 0 || structures.size() % width != 0) throw Error("structures: expected a model in each row");
  const auto rows = static_cast<std::int64_t>(structures.size() / width);
  std::vector<std::int64_t> ends;
  for (const std::int64_t end : structures_end) {
    if (end < 0 || end > rows) throw Error("structures_end: ends that are not in order");
    ends.push_back(end * static_cast<std::int64_t>(width));
  }
  std::vector<double> values;
  if (group.nameExists("structure_values"))
    values = Get<double>(group, "structure_values", static_cast<std::size_t>(rows));
  for (std::size_t i = 0; i < count; ++i) {
    const std::vector<double> models = Slice(structures, ends, i);
    if (!values.empty()) (*records)[i].structure_values = Slice(values, structures_end, i);
    for (std::size_t at = 0; at < models.size(); at += width)
      (*records)[i].structures.push_back(
          Eigen::Map<const Eigen::VectorXd>(models.data() + at, static_cast<Eigen::Index>(width)));
    (*records)[i].assignment = Slice(labels, labels_end, i);
  }
}

/// Of a row of 12; nothing where it is not finite.
std::optional<RigidMotion> PoseAt(const std::vector<double>& poses, std::size_t i) {
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> pose(poses.data() + 12 * i);
  if (!pose.allFinite()) return std::nullopt;
  return RigidMotion{pose.leftCols<3>(), pose.col(3)};
}

/// Of groups that have covariances, other poses or focal lengths.
void ReadUncertainty(const H5::Group& group, std::vector<EstimateRecord>* records) {
  const std::size_t count = records->size();
  if (group.nameExists("other_pose")) {
    const auto poses = Get<double>(group, "other_pose", 12 * count);
    for (std::size_t i = 0; i < count; ++i) (*records)[i].other_pose = PoseAt(poses, i);
  }
  if (group.nameExists("pose_covariance")) {
    const auto values = GetAll<double>(group, "pose_covariance");
    const auto side = count == 0 ? 0 : static_cast<Eigen::Index>(std::lround(std::sqrt(values.size() / count)));
    if (values.size() != count * static_cast<std::size_t>(side * side))
      throw Error("pose_covariance: expected a square matrix for each problem");
    for (std::size_t i = 0; i < count; ++i) {
      const Eigen::Map<const Eigen::MatrixXd> covariance(values.data() + i * side * side, side, side);
      if (covariance.allFinite()) (*records)[i].pose_covariance = covariance;
    }
  }
  if (!group.nameExists("focal")) return;
  const auto focals = Get<double>(group, "focal", 6 * count);
  const auto observable = Get<std::int32_t>(group, "focal_observable", count);
  for (std::size_t i = 0; i < count; ++i) {
    const double* values = focals.data() + 6 * i;
    if (!std::isfinite(values[0])) continue;
    FocalEstimate& focal = (*records)[i].focal.emplace();
    focal.focal_px = {values[0], values[3]};
    focal.low_px = {values[1], values[4]};
    focal.high_px = {values[2], values[5]};
    focal.observable = observable[i] != 0;
  }
}

/// Which files have only lately, or only for points of which some are left out.
void ReadRows(const H5::Group& group, std::vector<EstimateRecord>* records) {
  const std::size_t count = records->size();
  if (group.nameExists("inlier_threshold")) {
    const auto thresholds = Get<double>(group, "inlier_threshold", count);
    for (std::size_t i = 0; i < count; ++i) (*records)[i].inlier_threshold = thresholds[i];
  }
  if (group.nameExists("translation")) {
    const auto translations = GetTexts(group, "translation", count);
    for (std::size_t i = 0; i < count; ++i) (*records)[i].translation = FromString<Translation>(translations[i]);
  }
  if (group.nameExists("share_behind")) {
    const auto shares = Get<double>(group, "share_behind", count);
    for (std::size_t i = 0; i < count; ++i) (*records)[i].share_behind = shares[i];
  }
  if (!group.nameExists("rows")) return;
  const auto rows = GetAll<std::int32_t>(group, "rows");
  const auto ends = Get<std::int64_t>(group, "rows_end", count);
  for (std::size_t i = 0; i < count; ++i) (*records)[i].rows = Slice(rows, ends, i);
}

std::vector<EstimateRecord> ReadRecords(const H5::Group& group) {
  const auto index = GetAll<std::uint64_t>(group, "index");
  const std::size_t count = index.size();
  const auto ids = GetTexts(group, "id", count), scenes = GetTexts(group, "scene", count),
             statuses = GetTexts(group, "status", count);
  const auto models = GetAll<double>(group, "model"), poses = Get<double>(group, "pose", 12 * count);
  const auto scores = Get<double>(group, "score", count), noise_scales = Get<double>(group, "noise_scale", count);
  std::vector<double> log_false_alarms(count, std::numeric_limits<double>::quiet_NaN());  // Older files have none.
  if (group.nameExists("log_false_alarms")) log_false_alarms = Get<double>(group, "log_false_alarms", count);
  const auto draws = Get<std::int64_t>(group, "draws", count), points = Get<std::int64_t>(group, "points", count),
             inliers_end = Get<std::int64_t>(group, "inliers_end", count),
             probabilities_end = Get<std::int64_t>(group, "probabilities_end", count);
  const auto inliers = GetAll<std::int32_t>(group, "inliers");
  const auto probabilities = GetAll<float>(group, "probabilities");
  if (count > 0 && models.size() % count != 0) throw Error("model: expected a row for each problem");
  const std::size_t width = count == 0 ? 0 : models.size() / count;
  std::vector<EstimateRecord> records(count);
  for (std::size_t i = 0; i < count; ++i) {
    EstimateRecord& record = records[i];
    record.index = index[i];
    record.id = ids[i];
    record.scene = scenes[i];
    record.status = StatusFromText(statuses[i]);
    if (record.status == Status::kOk)
      record.model = Eigen::Map<const Eigen::VectorXd>(models.data() + i * width, static_cast<Eigen::Index>(width));
    record.pose = PoseAt(poses, i);
    record.score = scores[i];
    record.noise_scale = noise_scales[i];
    record.log_false_alarms = log_false_alarms[i];
    record.draws = draws[i];
    record.points = static_cast<int>(points[i]);
    record.inliers = Slice(inliers, inliers_end, i);
    record.inlier_probabilities = Slice(probabilities, probabilities_end, i);
  }
  ReadStructures(group, width, &records);
  ReadUncertainty(group, &records);
  ReadRows(group, &records);
  return records;
}

}  // namespace

Status StatusFromText(const std::string& text) {
  for (const Status status :
       {Status::kOk, Status::kTooFewPoints, Status::kDegenerate, Status::kNoModel, Status::kTooManyPoints})
    if (ToString(status) == text) return status;
  throw Error("unknown status '" + text + "'");
}

EstimateRecord RecordOf(const Example& example, const Estimate& estimate) {
  EstimateRecord record;
  record.index = example.index;
  record.id = ProblemName(example);
  record.scene = example.scene;
  record.status = estimate.status;
  record.points = static_cast<int>(example.problem.points.rows());
  record.draws = estimate.report.draws;
  if (record.points > 0) record.largest_coordinate = example.problem.points.cwiseAbs().maxCoeff();
  if (estimate.status != Status::kOk) return record;
  record.model = estimate.model;
  record.pose = PoseOfEstimate(estimate, example.problem);
  for (std::size_t i = 0; i < estimate.inliers.size(); ++i)
    if (estimate.inliers[i] != 0) record.inliers.push_back(static_cast<std::int32_t>(i));
  record.inlier_threshold = estimate.inlier_threshold;
  if (record.pose) record.pose_covariance = estimate.pose_covariance;
  record.translation = estimate.translation;
  record.other_pose = estimate.other_pose;
  record.share_behind = estimate.share_behind;
  record.focal = estimate.focal;
  record.score = estimate.score;
  record.noise_scale = estimate.noise_scale;
  record.log_false_alarms = estimate.log_false_alarms;
  record.inlier_probabilities = estimate.inlier_probabilities;
  record.structures = estimate.structures;
  record.assignment = estimate.assignment;
  record.structure_values = estimate.structure_values;
  return record;
}

namespace {

void WriteTo(H5::H5File& file, const EstimateFile& content) {
  H5::Group root = file.openGroup("/");
  PutText(root, "format", kFormat);
  PutText(root, "experiment", content.experiment);
  PutText(root, "task", content.task);
  PutText(root, "git_revision", content.git_revision);
  for (const EstimateGroup& group : content.groups) {
    const std::string method = LinkName(group.method), condition = LinkName(group.condition);
    if (!file.nameExists(method)) file.createGroup(method);
    H5::Group written = file.createGroup(method + "/" + condition);
    PutText(written, "method", group.method);
    PutText(written, "condition", group.condition);
    Columns(group.records).Write(written);
  }
}

H5::FileAccPropList InMemory() {
  constexpr std::size_t kIncrement = 1 << 20;
  H5::FileAccPropList access;
  access.setCore(kIncrement, false);
  return access;
}

}  // namespace

std::string EstimatesToBytes(const EstimateFile& content) {
  const std::lock_guard lock(Hdf5Mutex());
  H5::Exception::dontPrint();
  try {
    H5::H5File file("estimates", H5F_ACC_TRUNC, H5::FileCreatPropList::DEFAULT, InMemory());
    WriteTo(file, content);
    file.flush(H5F_SCOPE_GLOBAL);
    const ssize_t size = H5Fget_file_image(file.getId(), nullptr, 0);
    std::string bytes(static_cast<std::size_t>(std::max<ssize_t>(size, 0)), '\0');
    if (size <= 0 || H5Fget_file_image(file.getId(), bytes.data(), bytes.size()) != size)
      throw Error("cannot hold the estimates");
    return bytes;
  } catch (const H5::Exception& e) {
    throw Error("cannot hold the estimates: " + Describe(e));
  }
}

EstimateFile EstimatesFromBytes(std::string bytes, const std::string& name) {
  const std::lock_guard lock(Hdf5Mutex());
  H5::Exception::dontPrint();
  std::string place = name;
  try {
    const H5::H5File file = OpenHdf5Bytes(bytes, name);
    const H5::Group root = file.openGroup("/");
    if (GetText(root, "format") != kFormat) throw Error("another format");
    EstimateFile content{GetText(root, "experiment"), GetText(root, "task"), GetText(root, "git_revision"), {}};
    for (hsize_t m = 0; m < file.getNumObjs(); ++m) {
      const H5::Group method = file.openGroup(file.getObjnameByIdx(m));
      for (hsize_t c = 0; c < method.getNumObjs(); ++c) {
        place = name + ": " + file.getObjnameByIdx(m) + "/" + method.getObjnameByIdx(c);
        const H5::Group group = method.openGroup(method.getObjnameByIdx(c));
        content.groups.push_back({GetText(group, "method"), GetText(group, "condition"), ReadRecords(group)});
      }
    }
    return content;
  } catch (const H5::Exception& e) {
    throw Error(place + ": no estimates of diffsac_eval: " + Describe(e));
  } catch (const Error& e) {
    throw Error(place + ": no estimates of diffsac_eval: " + e.what());
  }
}

void WriteEstimates(const std::string& path, const EstimateFile& content) {
  WriteFileAtomically(path, EstimatesToBytes(content));
}

EstimateFile ReadEstimates(const std::string& path) { return EstimatesFromBytes(ReadFile(path), path); }

}  // namespace diffsac
