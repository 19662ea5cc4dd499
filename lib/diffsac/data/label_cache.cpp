#include "diffsac/data/label_cache.h"

#include <H5Cpp.h>

#include <algorithm>
#include <bit>
#include <filesystem>
#include <mutex>

#include "diffsac/core/files.h"
#include "diffsac/core/parallel.h"
#include "diffsac/core/progress.h"
#include "diffsac/core/status.h"
#include "diffsac/data/dataset_factory.h"
#include "diffsac/data/hdf5_numbers.h"

namespace diffsac {
namespace {

constexpr const char* kVersion = "label cache 1\n";
// Examples that are labelled between two writes.
constexpr std::int64_t kBlock = 1024;

std::string KeyText(const std::string& dataset_key, const LabelOptions& options) {
  return kVersion + dataset_key + "labels:\n" + WriteOptions(options);
}

int SetSize(Task task, const LabelOptions& options) {
  return task == Task::kFundamental ? options.fundamental_points : MinimalSetSize(task);
}

// FNV-1a over 64-bit words (Fowler, Noll, Vo).
class Hash {
 public:
  void Add(std::uint64_t word) { value_ = (value_ ^ word) * 1099511628211ull; }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 14695981039346656037ull;
};

std::uint64_t Fingerprint(const Example& example) {
  Hash hash;
  for (unsigned char c : example.id) hash.Add(c);
  const PointMatrix& points = example.problem.points;
  hash.Add(static_cast<std::uint64_t>(points.rows()));
  for (Eigen::Index i = 0; i < points.size(); ++i) hash.Add(std::bit_cast<std::uint64_t>(points.data()[i]));
  for (std::uint8_t mark : example.truth.inliers) hash.Add(mark);
  return hash.value();
}

// One example's part of the file.
struct Row {
  std::vector<std::int32_t> sets;
  std::vector<double> distances;
  std::uint64_t fingerprint = 0;
};

Row MakeRow(const Example& example, const LabelOptions& options, int set_size) {
  Row row;
  row.fingerprint = Fingerprint(example);
  row.sets.assign(static_cast<std::size_t>(options.top_m) * set_size, -1);
  row.distances.assign(static_cast<std::size_t>(options.top_m), 0.0);
  const std::vector<RankedSet> sets = OptimalMinimalSets(example, options, options.top_m);
  for (std::size_t m = 0; m < sets.size(); ++m) {
    std::copy(sets[m].points.begin(), sets[m].points.end(),
              row.sets.begin() + static_cast<std::ptrdiff_t>(m * set_size));
    row.distances[m] = sets[m].distance;
  }
  return row;
}

// Reads or writes `values` as the rows [first, first + count) of a data set.
template <class Value, class Transfer>
void WithRows(const H5::DataSet& data, hsize_t first, hsize_t count, const Value& values, Transfer transfer) {
  const H5::DataSpace space = data.getSpace();
  std::vector<hsize_t> shape(static_cast<std::size_t>(space.getSimpleExtentNdims()));
  space.getSimpleExtentDims(shape.data());
  std::vector<hsize_t> start(shape.size(), 0);
  start[0] = first;
  shape[0] = count;
  space.selectHyperslab(H5S_SELECT_SET, shape.data(), start.data());
  transfer(data, values, H5::DataSpace(static_cast<int>(shape.size()), shape.data()), space);
}

template <class Value>
void WriteRows(const H5::DataSet& data, hsize_t first, hsize_t count, const std::vector<Value>& values,
               const H5::PredType& type) {
  WithRows(data, first, count, values.data(),
           [&](const auto& d, const Value* out, const auto& memory, const auto& space) {
             d.write(out, type, memory, space);
           });
}

template <class Value>
void ReadRow(const H5::DataSet& data, hsize_t index, std::vector<Value>* values, const H5::PredType& type) {
  WithRows(data, index, 1, values->data(),
           [&](const auto& d, Value* in, const auto& memory, const auto& space) { d.read(in, type, memory, space); });
}

}  // namespace

std::string DatasetKey(const Config& data, std::uint64_t seed) {
  return "seed: " + std::to_string(seed) + "\ndata:\n" + WriteDatasetOptions(data);
}

struct LabelCache::File {
  std::string path, key;
  LabelOptions options;
  int set_size = 0;
  std::int64_t examples = 0;
  std::unique_ptr<H5::H5File> file;  // this and the next are touched under the lock alone
  H5::DataSet sets, distances, fingerprints;

  ~File() {
    const std::lock_guard lock(Hdf5Mutex());
    Close();
  }

  // False when the file is not there, was made for something else or is damaged.
  bool Open() {
    if (!std::filesystem::exists(path)) return false;
    const std::lock_guard lock(Hdf5Mutex());
    H5::Exception::dontPrint();
    try {
      file = std::make_unique<H5::H5File>(path, H5F_ACC_RDONLY);
      if (Text("key") != key) {
        Close();
        return false;
      }
      sets = file->openDataSet("sets");
      distances = file->openDataSet("distances");
      fingerprints = file->openDataSet("fingerprints");
      const hsize_t top_m = static_cast<hsize_t>(options.top_m), count = static_cast<hsize_t>(examples);
      if (Shape(sets) == std::vector<hsize_t>{count, top_m, static_cast<hsize_t>(set_size)} &&
          Shape(distances) == std::vector<hsize_t>{count, top_m} && Shape(fingerprints) == std::vector<hsize_t>{count})
        return true;
    } catch (const H5::Exception&) {
      // Made anew, as any file that does not fit.
    }
    Close();
    return false;
  }

  void Write(const Dataset& dataset, int threads) {
    WriteFileAtomically(path, [&](const std::string& temporary) {
      try {
        Create(temporary);
        Progress progress("labels", examples);
        for (std::int64_t first = 0; first < examples; first += kBlock)
          WriteBlock(dataset, first, std::min(kBlock, examples - first), threads, &progress);
        const std::lock_guard lock(Hdf5Mutex());
        file->flush(H5F_SCOPE_GLOBAL);
        Close();
      } catch (const H5::Exception& e) {
        throw Error("cannot write '" + path + "': " + Describe(e));
      }
    });
  }

  Row Read(std::uint64_t index) {
    Row row;
    row.sets.resize(static_cast<std::size_t>(options.top_m) * set_size);
    row.distances.resize(static_cast<std::size_t>(options.top_m));
    std::vector<std::uint64_t> fingerprint(1);
    const std::lock_guard lock(Hdf5Mutex());
    H5::Exception::dontPrint();
    try {
      ReadRow(sets, index, &row.sets, H5::PredType::NATIVE_INT32);
      ReadRow(distances, index, &row.distances, H5::PredType::NATIVE_DOUBLE);
      ReadRow(fingerprints, index, &fingerprint, H5::PredType::NATIVE_UINT64);
    } catch (const H5::Exception& e) {
      throw Error(path + ": damaged or truncated: " + Describe(e));
    }
    row.fingerprint = fingerprint[0];
    return row;
  }

  // Callers hold the lock.
  void Close() {
    sets = distances = fingerprints = H5::DataSet();
    file.reset();
  }

 private:
  static std::vector<hsize_t> Shape(const H5::DataSet& data) {
    const H5::DataSpace space = data.getSpace();
    std::vector<hsize_t> shape(static_cast<std::size_t>(space.getSimpleExtentNdims()));
    if (!shape.empty()) space.getSimpleExtentDims(shape.data());
    return shape;
  }

  // As bytes: an attribute may not be longer than 64 KiB.
  std::string Text(const char* name) const {
    const H5::DataSet data = file->openDataSet(name);
    std::string text(static_cast<std::size_t>(data.getSpace().getSimpleExtentNpoints()), '\0');
    data.read(text.data(), H5::PredType::NATIVE_CHAR);
    return text;
  }

  void Create(const std::string& temporary) {
    const std::lock_guard lock(Hdf5Mutex());
    H5::Exception::dontPrint();
    file = std::make_unique<H5::H5File>(temporary, H5F_ACC_TRUNC);
    const hsize_t length = key.size(), count = static_cast<hsize_t>(examples);
    const hsize_t shape[3] = {count, static_cast<hsize_t>(options.top_m), static_cast<hsize_t>(set_size)};
    file->createDataSet("key", H5::PredType::STD_I8LE, H5::DataSpace(1, &length))
        .write(key.data(), H5::PredType::NATIVE_CHAR);
    sets = file->createDataSet("sets", H5::PredType::STD_I32LE, H5::DataSpace(3, shape));
    distances = file->createDataSet("distances", H5::PredType::IEEE_F64LE, H5::DataSpace(2, shape));
    fingerprints = file->createDataSet("fingerprints", H5::PredType::STD_U64LE, H5::DataSpace(1, shape));
  }

  void WriteBlock(const Dataset& dataset, std::int64_t first, std::int64_t count, int threads, Progress* progress) {
    std::vector<Row> rows(static_cast<std::size_t>(count));
    ParallelFor(count, threads, [&](std::int64_t i) {
      rows[i] = MakeRow(dataset.Get(static_cast<std::uint64_t>(first + i)), options, set_size);
      progress->Advance();
    });
    Row all;
    std::vector<std::uint64_t> prints;
    for (const Row& row : rows) {
      all.sets.insert(all.sets.end(), row.sets.begin(), row.sets.end());
      all.distances.insert(all.distances.end(), row.distances.begin(), row.distances.end());
      prints.push_back(row.fingerprint);
    }
    const std::lock_guard lock(Hdf5Mutex());
    const auto at = static_cast<hsize_t>(first), size = static_cast<hsize_t>(count);
    WriteRows(sets, at, size, all.sets, H5::PredType::NATIVE_INT32);
    WriteRows(distances, at, size, all.distances, H5::PredType::NATIVE_DOUBLE);
    WriteRows(fingerprints, at, size, prints, H5::PredType::NATIVE_UINT64);
  }
};

LabelCache::LabelCache(const Dataset& dataset, const std::string& dataset_key, const LabelOptions& options,
                       const std::string& path, int threads)
    : file_(std::make_unique<File>()) {
  if (dataset.size() < 0) throw Error(path + ": an endless dataset has no cache of labels");
  file_->path = path;
  file_->key = KeyText(dataset_key, options);
  file_->options = options;
  file_->set_size = SetSize(dataset.task(), options);
  file_->examples = dataset.size();
  if (file_->Open()) return;
  computed_ = true;
  file_->Write(dataset, threads);
  if (!file_->Open()) throw Error(path + ": cannot be read back");
}

LabelCache::~LabelCache() = default;

std::vector<RankedSet> LabelCache::Sets(const Example& example) const {
  const std::string stale = file_->path + ": made for another example " + std::to_string(example.index) + " than '" +
                            example.id + "' as it is now; remove the file to have it made anew";
  if (example.index >= static_cast<std::uint64_t>(file_->examples)) throw Error(stale);
  const Row row = file_->Read(example.index);
  if (row.fingerprint != Fingerprint(example)) throw Error(stale);
  std::vector<RankedSet> sets;
  const auto size = static_cast<std::size_t>(file_->set_size);
  for (std::size_t m = 0; m < row.distances.size() && row.sets[m * size] >= 0; ++m) {
    const auto first = row.sets.begin() + static_cast<std::ptrdiff_t>(m * size);
    sets.push_back({std::vector<int>(first, first + static_cast<std::ptrdiff_t>(size)), row.distances[m]});
  }
  return sets;
}

}  // namespace diffsac
