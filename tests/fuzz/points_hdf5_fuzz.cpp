// Points and absolute poses in HDF5: the first byte chooses a sound file, the others change it (ChangeHdf5).

#include <H5Cpp.h>

#include <filesystem>
#include <mutex>

#include "diffsac/core/files.h"
#include "fuzz/fuzz_target.h"
#include "fuzz/hdf5_edits.h"
#include "lab/config/dataset_factory.h"
#include "lab/config/yaml.h"
#include "lab/data/point_files.h"
#include "lab/data/synthetic.h"
#include "lab/data/write_point_sets.h"
#include "lab/files/hdf5_numbers.h"

namespace diffsac::testing {
namespace {

std::string PointsSeed() {
  const std::string path = WriteScratch("seed.h5", "");
  SyntheticOptions options;
  options.num_points = {12, 12};
  const auto dataset = MakeSynthetic(Task::kPlane, options, 1);
  WritePointSets(path, {dataset->Get(0), dataset->Get(1)});
  return ReadFile(path);
}

std::string PosesSeed() {
  const std::string path = WriteScratch("seed.h5", "");
  {
    const std::lock_guard lock(Hdf5Mutex());
    H5::H5File file(path, H5F_ACC_TRUNC);
    const H5::Group group = file.createGroup("a");
    const std::vector<double> points(20, 1.0), ratios(4, 0.5), K = {100, 0, 0, 0, 100, 0, 0, 0, 1};
    const std::vector<double> pose = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 5};
    WriteNumbers(group, "points", points.data(), {4, 5});
    WriteNumbers(group, "ratios", ratios.data(), {4});
    WriteNumbers(group, "K", K.data(), {3, 3});
    WriteNumbers(group, "pose", pose.data(), {3, 4});
  }
  return ReadFile(path);
}

const std::string& SoundFile(int which) {
  static const std::string files[2] = {PointsSeed(), PosesSeed()};
  return files[which];
}

}  // namespace

std::vector<std::string> Seeds() { return EditSeeds(2); }

}  // namespace diffsac::testing

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace diffsac::testing;
  ByteReader reader(data, size);
  const std::string path = WriteScratch("scene/scene_points.h5", SoundFile(reader.Below(2)));
  ChangeHdf5(path, &reader);
  Parses({path}, [&] { diffsac::ReadPointFile(path); });
  Parses({path, Scratch()}, [&] {
    diffsac::MakeDataset(diffsac::ConfigFromYaml("{type: absolute_poses, paths: [" + Scratch() + "/scene]}"), 1);
  });
  return 0;
}
