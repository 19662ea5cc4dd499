#include "diffsac/data/label_cache.h"

#include <H5Cpp.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "data_test_util.h"
#include "diffsac/core/files.h"
#include "diffsac/core/parallel.h"
#include "diffsac/data/dataset_factory.h"
#include "diffsac/data/hdf5_numbers.h"

namespace diffsac {
namespace {

Config Data(const std::string& task, const std::string& more = "size: 20\n") {
  return Config::FromString("type: synthetic_two_view\ntask: " + task + "\nnum_points: [20, 60]\nplanar: 0\n" + more);
}

LabelOptions Labels(int top_m = 4, int fundamental_points = 7) {
  LabelOptions labels;
  labels.top_m = top_m;
  labels.draws = 40;
  labels.fundamental_points = fundamental_points;
  return labels;
}

// Counts how often examples are asked for.
class Counted : public Dataset {
 public:
  explicit Counted(const Config& data) : inner_(MakeDataset(data, 1)) {}
  Task task() const override { return inner_->task(); }
  std::int64_t size() const override { return inner_->size(); }
  Example Get(std::uint64_t index) const override {
    ++count;
    Example example = inner_->Get(index);
    if (shift != 0.0) example.problem.points.array() += shift;
    return example;
  }
  mutable std::atomic<int> count{0};
  double shift = 0.0;

 private:
  std::unique_ptr<Dataset> inner_;
};

bool Same(const std::vector<RankedSet>& a, const std::vector<RankedSet>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i].points != b[i].points || a[i].distance != b[i].distance) return false;
  return true;
}

}  // namespace

TEST_CASE("the label cache gives what the search gives, and searches once") {
  struct Case {
    const char* task;
    int fundamental_points;
  };
  for (const Case& c : {Case{"fundamental", 7}, Case{"fundamental", 8}, Case{"essential", 7}, Case{"homography", 7}}) {
    const TemporaryFolder folder;
    const std::string path = folder / "labels.h5";
    const Config data = Data(c.task);
    Counted dataset(data);
    const LabelOptions labels = Labels(4, c.fundamental_points);
    for (bool again : {false, true}) {
      dataset.count = 0;
      const LabelCache cache(dataset, DatasetKey(data, 1), labels, path, 2);
      CHECK(cache.computed() == !again);
      CHECK(dataset.count == (again ? 0 : 20));
      std::vector<int> same(20);
      ParallelFor(20, 4, [&](std::int64_t i) {
        const Example example = dataset.Get(i);
        same[i] = Same(cache.Sets(example), OptimalMinimalSets(example, labels, 4));
      });
      CHECK(std::count(same.begin(), same.end(), 1) == 20);
    }
  }
}

TEST_CASE("examples with fewer sets than asked, or none, come back as they are") {
  const TemporaryFolder folder;
  const Config data = Config::FromString("type: synthetic_line\nnum_points: 4\noutlier_ratio: 0.25\nsize: 3\n");
  const auto dataset = MakeDataset(data, 1);
  const LabelOptions labels = Labels(8);
  const LabelCache cache(*dataset, DatasetKey(data, 1), labels, folder / "labels.h5");
  CHECK(cache.Sets(dataset->Get(1)).size() == 3);  // of three inliers
  CHECK(Same(cache.Sets(dataset->Get(1)), OptimalMinimalSets(dataset->Get(1), labels, 8)));
}

TEST_CASE("a label cache that does not fit is made anew") {
  const TemporaryFolder folder;
  const std::string path = folder / "labels.h5";
  const Config data = Data("essential");
  const Counted dataset(data);
  const auto computed = [&](const std::string& key, const LabelOptions& labels) {
    return LabelCache(dataset, key, labels, path, 1).computed();
  };
  const std::string key = DatasetKey(data, 1);
  CHECK(computed(key, Labels()));
  CHECK_FALSE(computed(key, Labels()));
  CHECK(computed(DatasetKey(data, 2), Labels()));
  CHECK(computed(DatasetKey(Data("essential", "size: 20\nnoise_px: 0.1\n"), 2), Labels()));
  CHECK(computed(key, Labels(5)));
  LabelOptions more = Labels(5);
  more.draws = 50;
  CHECK(computed(key, more));
  CHECK_FALSE(computed(key, more));
  const std::string content = ReadFile(path);
  WriteRaw(path, content.substr(0, content.size() / 2));
  CHECK(computed(key, more));
  WriteRaw(path, "no HDF5");
  CHECK(computed(key, more));
  {
    const std::lock_guard lock(Hdf5Mutex());
    H5::H5File(path, H5F_ACC_RDWR).unlink("distances");
  }
  CHECK(computed(key, more));
  CHECK_FALSE(computed(key, more));
}

TEST_CASE("data that changed under the same options is found out") {
  const TemporaryFolder folder;
  const Config data = Data("fundamental");
  Counted dataset(data);
  const LabelCache cache(dataset, DatasetKey(data, 1), Labels(), folder / "labels.h5", 1);
  CHECK(cache.Sets(dataset.Get(3)).size() == 4);
  Example other = dataset.Get(3);
  other.index = 4;
  CHECK(Has(ErrorOf([&] { cache.Sets(other); }), "labels.h5"));
  other.index = 99;
  CHECK(Has(ErrorOf([&] { cache.Sets(other); }), "99"));
  dataset.shift = 1e-9;
  CHECK(Has(ErrorOf([&] { cache.Sets(dataset.Get(3)); }), "made for another example"));
}

TEST_CASE("label caches that cannot be are refused") {
  const TemporaryFolder folder;
  const Config endless = Data("fundamental", "size: -1\n");
  const auto dataset = MakeDataset(endless, 1);
  CHECK(Has(ErrorOf([&] { LabelCache(*dataset, DatasetKey(endless, 1), {}, folder / "labels.h5"); }), "endless"));
  const Config data = Data("fundamental", "size: 2\n");
  const auto finite = MakeDataset(data, 1);
  CHECK(ErrorOf([&] { LabelCache(*finite, DatasetKey(data, 1), {}, folder / "no/such/folder/labels.h5"); }) != "");
  CHECK(std::filesystem::is_empty(folder.path()));
}

}  // namespace diffsac
