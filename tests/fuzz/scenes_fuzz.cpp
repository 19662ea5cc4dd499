// What diffsac_prepare reads of images' cameras and poses: a bundle (fuzz_target.h) whose first line is the format.

#include "fuzz/fuzz_target.h"
#include "lab/images/adelaide_rmf.h"
#include "lab/images/image_format.h"
#include "lab/images/image_sets.h"
#include "lab/images/numpy_file.h"

namespace diffsac::testing {

std::vector<std::string> Seeds() { return SeedFiles("scenes"); }

namespace {

void ReadSource(const ImageFormat& format, const Bundle& bundle) {
  PairsRequest request;
  request.format = bundle.kind;
  request.input = Scratch();
  request.sequence = "00";
  if (bundle.Find("pairs.txt") != nullptr) request.choice.pairs_file = Scratch() + "/pairs.txt";
  if (bundle.Find("K.txt") != nullptr && format.takes_calibration) request.calibration.file = Scratch() + "/K.txt";
  ImageSource source = format.read(request);
  if (!format.chooses_pairs && !request.choice.pairs_file.empty()) ChoosePairs(request.choice, request.input, &source);
  const auto images = static_cast<int>(source.images.size());
  for (const SourceScene& scene : source.scenes)
    for (const SourcePair& pair : scene.pairs)
      Require(pair.image1 >= 0 && pair.image1 < images && pair.image2 >= 0 && pair.image2 < images,
              "a pair is of two images");
  for (const SourceImage& image : source.images) {
    Require(!image.pose || (image.pose->rotation.allFinite() && image.pose->translation.allFinite()),
            "a pose is finite");
    Require(!image.camera || image.camera->K.allFinite(), "a calibration is finite");
  }
}

void Read(const Bundle& bundle) {
  const auto& formats = Registry<ImageFormat>::Instance();
  if (bundle.kind == "adelaidermf") {
    ReadAdelaideRmf(Scratch(), AdelaideCorrespondences::kLabelled);
    ReadAdelaideRmf(Scratch(), AdelaideCorrespondences::kTentative);
  } else if (bundle.kind == "npz") {
    ReadNpz(Scratch() + "/cameras.npz");
  } else if (bundle.kind == "sets") {
    ReadImageSets(Scratch() + "/sets.yaml");
  } else if (formats.Has(bundle.kind) && formats.Find(bundle.kind, "").read) {
    ReadSource(formats.Find(bundle.kind, ""), bundle);
  }
}

}  // namespace
}  // namespace diffsac::testing

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace diffsac::testing;
  const Bundle bundle = ParseBundle({reinterpret_cast<const char*>(data), size});
  WriteBundle(bundle);
  Parses({Scratch()}, [&] { Read(bundle); });
  return 0;
}
