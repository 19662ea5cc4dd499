#include "lab/eval/estimates.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

#include "diffsac/core/former_names.h"
#include "diffsac/core/status.h"
#include "diffsac/estimate/diagnose.h"
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

/// `width` numbers a row; 0: a list.
template <class Value>
void Put(const H5::Group& group, const std::string& name, const std::vector<Value>& values, std::size_t width = 0) {
  const H5::DSetCreatPropList properties = WithoutTimes();
  if (values.size() > kChunk && width == 0) {
    properties.setChunk(1, &kChunk);
    properties.setDeflate(4);
  }
  const std::vector<hsize_t> list = {values.size()};
  WriteNumbers(group, name, values.data(), width == 0 ? list : std::vector<hsize_t>{values.size() / width, width},
               properties);
}

const H5::StrType& TextType() {
  static const H5::StrType type(H5::PredType::C_S1, H5T_VARIABLE);
  return type;
}

void Put(const H5::Group& group, const std::string& name, const std::vector<std::string>& texts) {
  const hsize_t count = texts.size();
  const H5::DataSet data = group.createDataSet(name, TextType(), H5::DataSpace(1, &count), WithoutTimes());
  std::vector<const char*> pointers;
  for (const std::string& text : texts) pointers.push_back(text.c_str());
  if (count > 0) data.write(pointers.data(), TextType());
}

void PutText(const H5::H5Object& object, const char* name, const std::string& text) {
  object.createAttribute(name, TextType(), H5::DataSpace(H5S_SCALAR)).write(TextType(), text);
}

void CheckCount(std::size_t count, std::size_t expected, const std::string& name) {
  if (count != expected) throw Error(name + ": expected " + std::to_string(expected) + " values");
}

/// The name under which a file has a column: the current or the former one.
std::string NameIn(const H5::Group& group, const std::string& name) {
  return group.nameExists(name) ? name : FormerName(name);
}

template <class Value>
std::vector<Value> GetAll(const H5::Group& group, const std::string& name) {
  const H5::DataSet data = group.openDataSet(NameIn(group, name));
  std::vector<Value> values(CountOf(data, name));
  if (!values.empty()) data.read(values.data(), Hdf5Type<Value>());
  return values;
}

template <>
std::vector<std::string> GetAll(const H5::Group& group, const std::string& name) {
  const H5::DataSet data = group.openDataSet(NameIn(group, name));
  std::vector<char*> pointers(CountOf(data, name));
  if (pointers.empty()) return {};
  data.read(pointers.data(), TextType());
  std::vector<std::string> texts;
  // A text that was never written is a null pointer.
  for (const char* text : pointers) texts.emplace_back(text == nullptr ? "" : text);
  H5::DataSet::vlenReclaim(pointers.data(), TextType(), data.getSpace());
  return texts;
}

template <class Value>
std::vector<Value> Get(const H5::Group& group, const std::string& name, std::size_t count) {
  CheckCount(CountOf(group.openDataSet(NameIn(group, name)), name), count, name);
  return GetAll<Value>(group, name);
}

std::string GetText(const H5::H5Object& object, const char* name) { return ReadText(object.openAttribute(name), name); }

using Row = std::span<const double>;

Eigen::Map<const Eigen::VectorXd> AsVector(Row row) { return {row.data(), static_cast<Eigen::Index>(row.size())}; }

template <class Matrix>
std::vector<double> NumbersOf(const Matrix& matrix) {
  return {matrix.data(), matrix.data() + matrix.size()};
}

/// Which files have a column: all; all but those of earlier versions; those in which some record has a value.
enum class Presence { kAlways, kSince, kSome };

/// One group's columns: written where its records are const, read into them else, so that each column is said once. In
/// all of them, get(record) is what is written of a record and set(record, value) takes what was read.
template <class Records>
class Columns {
 public:
  static constexpr bool kWrites = std::is_const_v<Records>;
  Columns(const H5::Group& group, Records& records) : group_(group), records_(records) {}

  /// A number or text a record. get: an optional.
  template <class Get, class Set>
  void Values(const std::string& name, Presence presence, const Get& get, const Set& set) {
    using Value = typename decltype(get(records_[0]))::value_type;
    if constexpr (kWrites) {
      std::vector<Value> values;
      bool some = presence != Presence::kSome;
      for (const EstimateRecord& record : records_) {
        const std::optional<Value> value = get(record);
        some = some || value.has_value();
        values.push_back(value.value_or(Value()));
      }
      if (some) Put(group_, name, values);
    } else if (IsThere(name, presence)) {
      const auto values = diffsac::Get<Value>(group_, name, records_.size());
      for (std::size_t i = 0; i < values.size(); ++i) set(records_[i], values[i]);
    }
  }
  template <class Value>
  void Member(const std::string& name, Value EstimateRecord::*member, Presence presence = Presence::kAlways) {
    using Stored = std::conditional_t<std::is_same_v<Value, int>, std::int64_t, Value>;
    Values(
        name, presence, [&](const EstimateRecord& record) { return std::optional<Stored>(record.*member); },
        [&](EstimateRecord& record, const Stored& value) { record.*member = static_cast<Value>(value); });
  }

  /// A row of numbers a record, as wide as the widest and at least `width`; NaN where a record has none. What is read
  /// is `width` wide, or whatever it is for `width` 1. Returns the width.
  template <class Get, class Set>
  std::size_t Rows(const std::string& name, Presence presence, std::size_t width, const Get& get, const Set& set) {
    if constexpr (kWrites) {
      std::vector<std::vector<double>> rows;
      bool some = presence != Presence::kSome;
      for (const EstimateRecord& record : records_) {
        rows.push_back(get(record));
        some = some || !rows.back().empty();
        width = std::max(width, rows.back().size());
      }
      std::vector<double> all;
      for (std::vector<double>& row : rows) {
        row.resize(width, kNan);
        all.insert(all.end(), row.begin(), row.end());
      }
      if (some) Put(group_, name, all, width);
    } else if (IsThere(name, presence)) {
      const auto all = GetAll<double>(group_, name);
      const std::size_t count = records_.size();
      if (width > 1) CheckCount(all.size(), width * count, name);
      if (count == 0 || all.size() % count != 0) {
        CheckCount(all.size(), 0, name);
        return 0;
      }
      width = all.size() / count;
      for (std::size_t i = 0; i < count; ++i) set(records_[i], Row(all).subspan(i * width, width));
    }
    return width;
  }
  void Pose(const std::string& name, std::optional<RigidMotion> EstimateRecord::*member, Presence presence) {
    using Pose = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;
    Rows(
        name, presence, 12,
        [&](const EstimateRecord& record) {
          if (!(record.*member)) return std::vector<double>();
          return NumbersOf((Pose() << (record.*member)->rotation, (record.*member)->translation).finished());
        },
        [&](EstimateRecord& record, Row row) {
          const Eigen::Map<const Pose> pose(row.data());
          if (pose.allFinite()) record.*member = RigidMotion{pose.leftCols<3>(), pose.col(3)};
        });
  }

  /// A list a record, one after the other, with where each ends, in units of `each` values; 0: a list's values are
  /// single.
  template <class Get, class Set>
  void Lists(const std::string& name, const std::string& ends_name, std::size_t each, Presence presence, const Get& get,
             const Set& set) {
    using Value = typename decltype(get(records_[0]))::value_type;
    const std::size_t unit = std::max<std::size_t>(each, 1);
    if constexpr (kWrites) {
      std::vector<Value> all;
      std::vector<std::int64_t> ends;
      for (const EstimateRecord& record : records_) {
        const std::vector<Value> list = get(record);
        all.insert(all.end(), list.begin(), list.end());
        ends.push_back(static_cast<std::int64_t>(all.size() / unit));
      }
      if (presence == Presence::kSome && all.empty()) return;
      Put(group_, name, all, each);
      if (!group_.nameExists(ends_name)) Put(group_, ends_name, ends);
    } else if (IsThere(name, presence)) {
      const auto all = GetAll<Value>(group_, name);
      const auto ends = diffsac::Get<std::int64_t>(group_, ends_name, records_.size());
      if (all.size() % unit != 0) throw Error(name + ": expected " + std::to_string(unit) + " numbers in each row");
      std::int64_t begin = 0;
      for (std::size_t i = 0; i < ends.size(); begin = ends[i++]) {
        if (ends[i] < begin || ends[i] > static_cast<std::int64_t>(all.size() / unit))
          throw Error(ends_name + ": ends that are not in order");
        set(records_[i], std::vector<Value>(all.begin() + begin * static_cast<std::ptrdiff_t>(unit),
                                            all.begin() + ends[i] * static_cast<std::ptrdiff_t>(unit)));
      }
    }
  }
  template <class Value>
  void Lists(const std::string& name, std::vector<Value> EstimateRecord::*member, Presence presence) {
    Lists(
        name, name + "_end", 0, presence, [&](const EstimateRecord& record) { return record.*member; },
        [&](EstimateRecord& record, std::vector<Value> values) { record.*member = std::move(values); });
  }

  bool HaveInstances() const {
    if constexpr (!kWrites) return group_.nameExists("structures");
    return std::any_of(records_.begin(), records_.end(), [](const auto& record) { return !record.instances.empty(); });
  }

 private:
  bool IsThere(const std::string& name, Presence presence) const {
    return presence == Presence::kAlways || group_.nameExists(NameIn(group_, name));
  }

  const H5::Group& group_;
  Records& records_;
};

/// `width`: values of a model.
template <class Records>
void VisitInstances(Columns<Records>& columns, std::size_t width) {
  using R = EstimateRecord;
  columns.Lists(
      "structures", "structures_end", width, Presence::kAlways,
      [](const R& r) {
        std::vector<double> values;
        for (const ModelParameters& model : r.instances)
          values.insert(values.end(), model.data(), model.data() + model.size());
        return values;
      },
      [&](R& r, const std::vector<double>& values) {
        for (std::size_t at = 0; at < values.size(); at += width)
          r.instances.emplace_back(AsVector(Row(values).subspan(at, width)));
      });
  columns.Lists("labels", &R::assignment, Presence::kAlways);
}

/// One for each structure, of which some may have none: NaN.
template <class Records>
void VisitInstanceValues(Columns<Records>& columns, const std::vector<EstimateRecord>& records) {
  using R = EstimateRecord;
  const auto knows = [](const R& r) { return !r.instances.empty() && r.instance_values.size() == r.instances.size(); };
  if (Columns<Records>::kWrites && std::none_of(records.begin(), records.end(), knows)) return;
  columns.Lists(
      "structure_values", "structures_end", 0, Presence::kSome,
      [&](const R& r) { return knows(r) ? r.instance_values : std::vector<double>(r.instances.size(), kNan); },
      [](R& r, std::vector<double> values) { r.instance_values = std::move(values); });
}

/// Of unknown focal lengths, with their intervals.
template <class Records>
void VisitFocals(Columns<Records>& columns) {
  using R = EstimateRecord;
  columns.Rows(
      "focal", Presence::kSome, 6,
      [](const R& r) {
        std::vector<double> row;
        for (int i = 0; r.focal && i < 2; ++i)
          row.insert(row.end(), {r.focal->focal_px[i], r.focal->low_px[i], r.focal->high_px[i]});
        return row;
      },
      [](R& r, Row row) {
        if (std::isfinite(row[0])) r.focal = FocalEstimate{{row[0], row[3]}, {row[1], row[4]}, {row[2], row[5]}};
      });
  columns.Values(
      "focal_observable", Presence::kSome,
      [](const R& r) -> std::optional<std::int32_t> {
        if (!r.focal) return std::nullopt;
        const auto& [first, second] = r.focal->observable;
        return first && second ? 1 : first ? 2 : second ? 3 : 0;
      },
      [](R& r, std::int32_t which) {
        if (r.focal) r.focal->observable = {which == 1 || which == 2, which == 1 || which == 3};
      });
}

/// All columns, in the order of the file (docs/estimates.md).
template <class Records>
void VisitColumns(const H5::Group& group, Records& records) {
  using R = EstimateRecord;
  Columns<Records> columns(group, records);
  columns.Member("index", &R::index);
  columns.Member("id", &R::id);
  columns.Member("scene", &R::data_scene);
  columns.Values(
      "status", Presence::kAlways, [](const R& r) { return std::optional<std::string>(ToString(r.status)); },
      [](R& r, const std::string& text) { r.status = StatusFromText(text); });
  const std::size_t width = columns.Rows(
      "model", Presence::kAlways, 1, [](const R& r) { return NumbersOf(r.model); },
      [](R& r, Row row) {
        if (r.status == Status::kOk) r.model = AsVector(row);
      });
  columns.Pose("pose", &R::pose, Presence::kAlways);
  columns.Values(
      "degeneracy", Presence::kSince, [](const R& r) { return std::optional<std::string>(ToString(r.degeneracy)); },
      [](R& r, const std::string& text) { r.degeneracy = FromString<Degeneracy>(text); });
  columns.Pose("ambiguous_pose", &R::ambiguous_pose, Presence::kSome);
  columns.Member("cheirality_failure_ratio", &R::cheirality_failure_ratio, Presence::kSince);
  columns.Rows(
      "pose_covariance", Presence::kSome, 1,
      [](const R& r) { return r.pose_covariance ? NumbersOf(*r.pose_covariance) : std::vector<double>(); },
      [](R& r, Row row) {
        const auto side = static_cast<Eigen::Index>(std::lround(std::sqrt(row.size())));
        if (static_cast<std::size_t>(side * side) != row.size())
          throw Error("pose_covariance: expected a square matrix for each problem");
        const Eigen::Map<const Eigen::MatrixXd> covariance(row.data(), side, side);
        if (covariance.allFinite()) r.pose_covariance = covariance;
      });
  VisitFocals(columns);
  columns.Member("score", &R::score);
  columns.Member("sigma", &R::sigma);
  columns.Member("log10_nfa", &R::log10_nfa, Presence::kSince);
  columns.Member("draws", &R::draws);
  columns.Member("points", &R::points);
  columns.Lists("inliers", &R::inlier_rows, Presence::kAlways);
  columns.Member("inlier_threshold", &R::inlier_threshold, Presence::kSince);
  columns.Lists("rows", &R::rows, Presence::kSome);
  columns.Lists("probabilities", &R::inlier_probabilities, Presence::kAlways);
  if (!columns.HaveInstances()) return;
  VisitInstances(columns, width);
  VisitInstanceValues(columns, records);
}

std::vector<EstimateRecord> ReadRecords(const H5::Group& group) {
  std::vector<EstimateRecord> records(CountOf(group.openDataSet("index"), "index"));
  VisitColumns(group, records);
  return records;
}

}  // namespace

Status StatusFromText(const std::string& text) {
  for (const Status status :
       {Status::kOk, Status::kTooFewPoints, Status::kDegenerate, Status::kNoModel, Status::kTooManyPoints})
    if (ToString(status) == text) return status;
  throw Error("unknown status '" + text + "'");
}

EstimateRecord RecordOf(const Example& example, const Estimate& estimate, bool whole) {
  EstimateRecord record;
  record.index = example.index;
  record.id = ProblemName(example);
  record.data_scene = example.scene;
  record.status = estimate.status;
  record.points = static_cast<int>(example.problem.points.rows());
  record.draws = estimate.stats.iterations;
  if (record.points > 0) record.largest_coordinate = example.problem.points.cwiseAbs().maxCoeff();
  record.log10_nfa = estimate.log10_nfa;
  if (estimate.status != Status::kOk) return record;
  record.degeneracy = estimate.degeneracy;
  if (!whole) return record;
  record.model = estimate.model;
  record.pose = PoseOfEstimate(estimate, example.problem);
  for (std::size_t i = 0; i < estimate.inliers.size(); ++i)
    if (estimate.inliers[i] != 0) record.inlier_rows.push_back(static_cast<std::int32_t>(i));
  record.inlier_threshold = estimate.inlier_threshold;
  if (record.pose) record.pose_covariance = estimate.pose_covariance;
  record.ambiguous_pose = estimate.ambiguous_pose;
  record.cheirality_failure_ratio = estimate.cheirality_failure_ratio;
  record.focal = estimate.focal;
  record.score = estimate.score;
  record.sigma = estimate.sigma;
  record.inlier_probabilities = estimate.inlier_probabilities;
  record.instances = estimate.instances;
  record.assignment = estimate.assignment;
  record.instance_values = estimate.instance_values;
  return record;
}

std::array<double, 7> PoseNumbers(const std::optional<RigidMotion>& pose) {
  std::array<double, 7> numbers;
  numbers.fill(kNan);
  if (!pose) return numbers;
  Eigen::Quaterniond q(pose->rotation);
  if (q.w() < 0.0) q.coeffs() *= -1.0;
  numbers = {q.w(), q.x(), q.y(), q.z(), kNan, kNan, kNan};
  if (!pose->translation.isZero(0.0)) std::copy_n(pose->translation.data(), 3, numbers.begin() + 4);
  return numbers;
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
    const H5::Group written = file.createGroup(method + "/" + condition);
    PutText(written, "method", group.method);
    PutText(written, "condition", group.condition);
    VisitColumns(written, group.records);
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
  std::string place = name;
  try {
    const H5::H5File file = OpenHdf5Bytes(bytes);
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
  } catch (const std::bad_alloc&) {
    throw Error(place + ": too large for the memory");
  }
}

void WriteEstimates(const std::string& path, const EstimateFile& content) {
  WriteFileAtomically(path, EstimatesToBytes(content));
}

EstimateFile ReadEstimates(const std::string& path) { return EstimatesFromBytes(ReadFile(path), path); }

}  // namespace diffsac
