// Makes correspondence files from images, and says what stands in them.
#include <CLI/CLI.hpp>

#include <atomic>
#include <csignal>
#include <iostream>
#include <opencv2/core/utility.hpp>

#include "data_tools/inspect.h"
#include "data_tools/prepare_pairs.h"
#include "diffsac/core/logging.h"
#include "diffsac/core/run_directory.h"
#include "diffsac/core/status.h"
#include "diffsac/data/correspondence_files.h"

namespace {

constexpr int kExitOk = 0, kExitBadInput = 2, kExitInterrupted = 130;

std::atomic<bool> stop_requested{false};

void RequestStop(int) { stop_requested = true; }

struct InspectRequest {
  std::vector<std::string> folders;
  double threshold_px = 1.0;
};

void AddPairs(CLI::App* app, diffsac::PairsRequest* request) {
  app->add_option("--format", request->format, "What the images and their truth come as")
      ->required()
      ->check(CLI::IsMember({"kitti", "strecha", "colmap", "nerf", "poses", "homographies", "adelaidermf", "images"}));
  app->add_option("--input", request->input, "Folder of the images and their truth")->required();
  app->add_option("--output", request->output, "Folder for the scenes' folders")->required();
  app->add_option("--scene", request->scene, "Name of the scene (default: the folder's)");
  app->add_option("--sequence", request->sequence, "KITTI: the sequence, as 00");
  diffsac::PairChoice& choice = request->choice;
  app->add_option("--steps", choice.steps, "Frames between the images of a pair, as 1,2,5: a scene each (KITTI: 1)")
      ->delimiter(',');
  app->add_option("--every", choice.every, "Use only every so many images");
  app->add_option("--pairs-file", choice.pairs_file, "A text file with the names of two images in each line");
  diffsac::GivenCalibration& calibration = request->calibration;
  app->add_option("--calibration", calibration.file, "poses, images: a file with the 3x3 matrix K of all images");
  app->add_option("--focal", calibration.focal, "poses, images: focal length of all images, in pixels");
  app->add_option("--center", calibration.center, "poses, images: principal point, as 320,240")->delimiter(',');
  diffsac::PrepareOptions& options = request->options;
  app->add_option_function<std::string>(
         "--features",
         [&options](const std::string& name) { options.features.kind = diffsac::FeatureKindFromString(name); },
         "sift, rootsift (the default) or orb")
      ->check(CLI::IsMember({"sift", "rootsift", "orb"}));
  app->add_option("--import-descriptors", options.import_descriptors,
                  "Keypoints and descriptors from this HDF5 file, as hloc writes it");
  app->add_option("--max-keypoints", options.features.max_keypoints, "The strongest of an image; 0: all");
  app->add_option("--contrast-threshold", options.features.contrast_threshold, "Of SIFT; lower finds weaker keypoints");
  app->add_option("--max-image-size", options.features.max_image_size, "Reduce larger images to this side; 0: never");
  app->add_flag("--descriptors", options.descriptors, "Write descriptors.h5 as well");
  app->add_flag("--overwrite", options.overwrite, "Make scenes again that are there already");
  app->add_option("--max-pairs", options.max_pairs, "At most so many pairs a scene, evenly spaced; 0: all");
  app->add_option("--min-true-matches", options.min_true_matches, "Leave out pairs with fewer matches near the truth");
  app->add_option("--true-match-px", options.true_match_px, "What counts as near the truth, in pixels");
  app->add_option("--threads", options.threads, "Threads (0: all cores)");
}

int Inspect(const InspectRequest& request) {
  std::vector<diffsac::SceneSummary> summaries;
  bool good = true;
  for (const std::string& root : request.folders) {
    for (const std::string& folder : diffsac::FindCorrespondenceScenes(root)) {
      summaries.push_back(diffsac::InspectScene(folder, request.threshold_px, stop_requested));
      good = good && summaries.back().problems.empty();
      if (stop_requested) return kExitInterrupted;
    }
  }
  std::cout << diffsac::SummaryText(summaries, request.threshold_px) << std::flush;
  return good ? kExitOk : kExitBadInput;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Correspondence files in the layout of the CVPR 2020 RANSAC tutorial"};
  app.set_version_flag("--version", diffsac::VersionText("diffsac_prepare"));
  app.require_subcommand(1);
  diffsac::PairsRequest pairs;
  AddPairs(app.add_subcommand("pairs", "Images, calibration and truth to correspondence files"), &pairs);
  InspectRequest inspect;
  CLI::App* inspect_app = app.add_subcommand("inspect", "Counts, inliers and checks of correspondence files");
  inspect_app->add_option("folders", inspect.folders, "Scenes, or folders of scenes")->required();
  inspect_app->add_option("--threshold-px", inspect.threshold_px, "Distance to the truth that counts as an inlier")
      ->check(CLI::PositiveNumber);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    std::cerr << "diffsac_prepare: " << error.what() << std::endl;
    return kExitBadInput;
  }
  std::signal(SIGINT, RequestStop);
  std::signal(SIGTERM, RequestStop);
  try {
    diffsac::InitLogging();
    // Images are spread over threads here.
    cv::setNumThreads(1);
    if (inspect_app->parsed()) return Inspect(inspect);
    return diffsac::RunPairs(pairs, stop_requested).finished ? kExitOk : kExitInterrupted;
  } catch (const std::exception& error) {
    std::cerr << "diffsac_prepare: " << error.what() << std::endl;
    return kExitBadInput;
  }
}
