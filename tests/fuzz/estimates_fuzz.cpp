// estimates.h5 as it is read back: bytes change a sound file (ChangeHdf5).

#include "fuzz/fuzz_target.h"
#include "fuzz/hdf5_edits.h"
#include "lab/eval/estimates.h"

namespace diffsac::testing {

std::string SoundFile() {
  EstimateRecord record;
  record.id = "a";
  record.scene = "s";
  record.status = Status::kOk;
  record.model = Eigen::Vector3d(1, 0, 2);
  record.pose.emplace();
  record.inliers = {0, 2};
  record.points = 4;
  record.inlier_probabilities = {0.5f, 0.25f, 0.5f, 1.0f};
  record.structures = {record.model, record.model};
  record.assignment = {1, 0, 2, 1};
  EstimateRecord failed;
  failed.id = "b";
  return EstimatesToBytes({"name", "line", "0", {{"ransac", "all", {record, failed}}}});
}

std::vector<std::string> Seeds() { return EditSeeds(1); }

}  // namespace diffsac::testing

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace diffsac::testing;
  static const std::string sound = SoundFile();
  ByteReader reader(data, size);
  const std::string path = WriteScratch("estimates.h5", sound);
  ChangeHdf5(path, &reader);
  Parses({path}, [&] { diffsac::ReadEstimates(path); });
  return 0;
}
