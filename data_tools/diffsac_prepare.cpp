// Makes correspondence files from images.
#include <CLI/CLI.hpp>

#include <iostream>
#include <opencv2/core/utility.hpp>

#include "diffsac/core/status.h"
#include "lab/config/program.h"
#include "lab/config/progress.h"
#include "lab/config/run_directory.h"
#include "lab/images/modelnet_pairs.h"
#include "lab/images/run_pairs.h"
#include "lab/images/warp_images.h"

namespace {

using diffsac::kExitInterrupted, diffsac::kExitOk;

constexpr const char* kDocumentation =
    "\nDocumentation: data_tools/README.md has every format and file, docs/two_view.md what is estimated of them.\n";

/// What --help of a subcommand ends with.
std::string Footer(const std::string& examples) {
  return "\nExamples:\n" + examples + kDocumentation + diffsac::kExitCodesHelp;
}

constexpr const char* kPairsExamples =
    "  diffsac_prepare pairs --format images --input photographs --output runs/pairs\n"
    "  diffsac_prepare pairs --format colmap --input model --output runs/pairs --max-pairs 100\n"
    "  diffsac_prepare pairs --format kitti --input kitti --sequence 00 --steps 1,5 --output runs/pairs\n";

constexpr const char* kModelnetExamples =
    "  diffsac_prepare modelnet --input ModelNet40 --output runs/pairs --subset train --pairs 1000\n";

constexpr const char* kWarpExamples =
    "  diffsac_prepare warp --input photographs --output runs/warped\n"
    "  diffsac_prepare pairs --format homographies --input runs/warped --output runs/pairs\n";

using diffsac::stop_requested;

void AddPairs(CLI::App* app, diffsac::PairsRequest* request) {
  app->add_option("--format", request->format, "What the images and their truth come as")
      ->required()
      ->check(CLI::IsMember(diffsac::Registry<diffsac::ImageFormat>::Instance().Names()));
  app->add_option("--input", request->input, "Folder of the images and their truth; colmap_database: a file")
      ->required();
  app->add_option("--output", request->output, "Folder that gets a folder a scene")->required();
  app->add_option("--scene", request->scene, "Name of the scene (default: the folder's)");
  app->add_option("--sequence", request->sequence, "KITTI: the sequence, as 00");
  diffsac::PairChoice& choice = request->choice;
  app->add_option("--steps", choice.steps,
                  "Frames between the images of a pair, as 1,2,5: a scene each (default: all pairs; KITTI: 1)")
      ->delimiter(',');
  app->add_option("--every", choice.every, "Use only every so many images");
  app->add_option("--pairs-file", choice.pairs_file,
                  "A text file with the names of two images in each line (default: all pairs)");
  diffsac::GivenCalibration& calibration = request->calibration;
  app->add_option("--calibration", calibration.file, "images: a file with the 3x3 matrix K of all images");
  app->add_option("--focal", calibration.focal, "images: focal length of all images, in pixels")
      ->check(diffsac::NumberAbove(0));
  app->add_option("--center", calibration.center, "images: principal point, as 320,240")->delimiter(',');
  diffsac::PrepareOptions& options = request->options;
  app->add_option_function<std::string>(
         "--features",
         [&options](const std::string& name) {
           options.features.kind = diffsac::FromString<diffsac::FeatureKind>(name);
         },
         "sift, rootsift, orb or, where LibTorch is installed, xfeat (default: rootsift)")
      ->check(CLI::IsMember({"sift", "rootsift", "orb", "xfeat"}));
  app->add_option("--import-descriptors", options.import_descriptors,
                  "Keypoints and descriptors from this HDF5 file, as hloc writes it");
  app->add_flag("--ratios", request->ratios, "colmap_database: ratios of the matches, from the stored descriptors");
  app->add_option("--max-keypoints", options.features.max_keypoints, "The strongest of an image; 0: all");
  app->add_option("--max-image-size", options.features.max_image_size, "Reduce larger images to this side; 0: never");
  app->add_flag("--descriptors", options.descriptors, "Write descriptors.h5 as well");
  app->add_flag_callback(
      "--no-thumbnails", [&options] { options.thumbnails = false; },
      "No small copies of the images for reports (thumbnails.h5)");
  app->add_flag("--overwrite", options.overwrite, "Make scenes again that are there already");
  app->add_option("--max-pairs", options.max_pairs, "At most so many pairs a scene, evenly spaced; 0: all");
  app->add_option("--min-true-matches", options.min_true_matches, "Leave out pairs with fewer matches near the truth");
  app->add_option("--true-share", options.true_share,
                  "Only pairs of whose matches such a share is near the truth, least and greatest, as 0.02,0.25")
      ->delimiter(',');
  app->add_option("--max-disagreement", options.max_disagreement_deg,
                  "Leave out pairs whose pose turns by more degrees when it is refined on the matches; 0: none");
  app->add_option("--true-match-px", options.true_match_px, "What counts as near the truth, in pixels");
  app->add_option("--threads", options.threads, "Threads (0: all cores)")->check(diffsac::NumberWithin(0, 1024));
}

void AddModelnet(CLI::App* app, diffsac::ModelnetRequest* request) {
  app->add_option("--input", request->input, "Folder of OFF files, at any depth")->required();
  app->add_option("--output", request->output, "Folder for the scene's folder")->required();
  app->add_option("--scene", request->scene, "Name of the scene");
  app->add_option("--subset", request->subset, "Only meshes in folders of this name: train or test (default: all)");
  app->add_option("--pairs", request->pairs, "Pairs");
  app->add_option("--outlier-ratio", request->outlier_ratio, "Share of outliers, R or LOW,HIGH")->delimiter(',');
  app->add_option("--points", request->points, "Correspondences a pair");
  app->add_option("--seed", request->seed, "Seed of all that is drawn")->check(diffsac::NumberFrom(0));
  app->add_flag("--overwrite", request->overwrite, "Make the scene again when it is there already");
  app->add_option("--threads", request->threads, "Threads (0: all cores)")->check(diffsac::NumberWithin(0, 1024));
}

void AddWarp(CLI::App* app, diffsac::WarpRequest* request) {
  app->add_option("--input", request->input, "Folder of images")->required();
  app->add_option("--output", request->output, "Folder for the images' folders")->required();
  app->add_option("--images", request->images, "At most so many, evenly spread; 0: all")->check(diffsac::NumberFrom(0));
  app->add_option("--views", request->views, "Other views of each image")->check(diffsac::NumberWithin(1, 1000));
  app->add_option("--max-image-size", request->max_image_size, "Reduce larger images to this side; 0: never")
      ->check(diffsac::NumberFrom(0));
  app->add_option("--seed", request->seed, "Seed of all that is drawn")->check(diffsac::NumberFrom(0));
  app->add_option("--least-tilt", request->least_tilt, "Of the views, degrees")->check(diffsac::NumberWithin(0, 89));
  app->add_option("--greatest-tilt", request->greatest_tilt, "The same, the most")->check(diffsac::NumberWithin(0, 89));
  app->add_flag("--photograph", request->photograph, "As a small camera sees them: blur, sensor noise, tones, JPEG");
}

/// The last line of a run that made files.
int Ended(bool finished, const std::string& where) {
  if (!finished) return kExitInterrupted;
  std::cout << "results are in " << where << std::endl;
  return kExitOk;
}

/// What the command line asks for: one of the subcommands.
struct Requests {
  diffsac::PairsRequest pairs;
  diffsac::ModelnetRequest modelnet;
  diffsac::WarpRequest warp;
};

/// With the footer of its --help.
CLI::App* AddCommand(CLI::App* app, const std::string& name, const std::string& purpose, const std::string& examples) {
  CLI::App* command = app->add_subcommand(name, purpose);
  command->footer(Footer(examples));
  return command;
}

/// A list without values, or a focal length of 0, is no default that anybody could want to know.
void HideEmptyDefaults(CLI::App* app) {
  for (CLI::App* command : app->get_subcommands({}))
    for (CLI::Option* option : command->get_options({}))
      if (option->get_default_str() == "[]" || option->check_name("--focal")) option->default_str("");
}

void AddCommands(CLI::App* app, Requests* requests) {
  AddPairs(AddCommand(app, "pairs", "Images, calibration and truth to correspondence files", kPairsExamples),
           &requests->pairs);
  AddModelnet(AddCommand(app, "modelnet", "Virtual views of meshes to correspondence files", kModelnetExamples),
              &requests->modelnet);
  AddWarp(AddCommand(app, "warp", "Images as planes seen from other places, for pairs --format homographies",
                     kWarpExamples),
          &requests->warp);
}

int Run(const std::string& command, const Requests& requests) {
  if (command == "warp") return Ended(diffsac::WarpImages(requests.warp, stop_requested), requests.warp.output);
  if (command == "modelnet")
    return Ended(diffsac::WriteModelnetPairs(requests.modelnet, stop_requested).finished, requests.modelnet.output);
  return Ended(diffsac::RunPairs(requests.pairs, stop_requested).finished, requests.pairs.output);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Correspondence files in the layout of the CVPR 2020 RANSAC tutorial"};
  app.set_version_flag("--version", diffsac::VersionText("diffsac_prepare"));
  app.require_subcommand(1);
  app.option_defaults()->always_capture_default();
  app.footer(Footer(std::string(kPairsExamples) + "  diffsac_prepare pairs --help\n"));
  Requests requests;
  AddCommands(&app, &requests);
  HideEmptyDefaults(&app);
  return diffsac::RunProgram("diffsac_prepare", &app, argc, argv, [&] {
    diffsac::StopOnSignals();
    diffsac::InitLogging();
    // Images are spread over threads here.
    cv::setNumThreads(1);
    return Run(app.get_subcommands().front()->get_name(), requests);
  });
}
