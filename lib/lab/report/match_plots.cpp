#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "diffsac/core/files.h"
#include "lab/eval/format.h"
#include "lab/eval/structures_error.h"
#include "lab/files/own_pictures.h"
#include "lab/report/colours.h"
#include "lab/report/match_kinds.h"
#include "lab/report/pair_images.h"
#include "lab/report/plots.h"

namespace diffsac {
namespace {

constexpr int kPanelWidth = 760, kPanelHeight = 600;  // An image is made as large as fits.
constexpr int kGap = 10, kTitleHeight = 62;
constexpr int kMostLines = 100;      // Of one kind: more hide the images and each other.
constexpr int kMark = 4;             // Radius of a structure's points.
constexpr double kPale = 0.35;       // How much of white is mixed into the images.
constexpr double kLineWeight = 0.6;  // Lines let what is below shine through.
constexpr double kTitleScale = 0.62, kTextScale = 0.5;

cv::Scalar BlueGreenRed(const char* colour) {
  const auto [red, green, blue] = ColourParts(colour);
  return {static_cast<double>(blue), static_cast<double>(green), static_cast<double>(red)};
}

const cv::Scalar kWhite(255, 255, 255), kBlack(32, 32, 32), kBlank(238, 238, 238);  // blue, green, red
const cv::Scalar kRight = BlueGreenRed(kInlierColour), kWrong = BlueGreenRed(kWrongColour),
                 kMissed = BlueGreenRed(kMissedColour), kOther = BlueGreenRed(kOutlierColour);

MatchKind KindOf(const KeptFit& fit, Eigen::Index i) {
  return KindOfMatch(fit.estimate.inliers, fit.example.truth.inliers, static_cast<std::size_t>(i));
}

MatchCounts Count(const KeptFit& fit) {
  return CountMatches(fit.estimate.inliers, fit.example.truth.inliers,
                      static_cast<std::size_t>(fit.example.problem.points.rows()));
}

// One image in the picture: where its corner is, and how its pixels are scaled.
struct Panel {
  cv::Mat image;
  double scale = 1.0;
  cv::Point origin;
  cv::Point At(double x, double y) const {
    return {origin.x + static_cast<int>(std::lround(x * scale)), origin.y + static_cast<int>(std::lround(y * scale))};
  }
};

Panel MakePanel(const std::string& file, ImageSize size) {
  cv::Mat image = file.empty() ? cv::Mat() : cv::imread(file, cv::IMREAD_COLOR);
  Panel panel;
  panel.scale =
      std::min(static_cast<double>(kPanelWidth) / size.width, static_cast<double>(kPanelHeight) / size.height);
  const cv::Size target(std::max(1, static_cast<int>(std::lround(size.width * panel.scale))),
                        std::max(1, static_cast<int>(std::lround(size.height * panel.scale))));
  if (image.empty()) {
    panel.image = cv::Mat(target, CV_8UC3, kBlank);
    return panel;
  }
  cv::resize(image, panel.image, target, 0.0, 0.0, cv::INTER_AREA);
  cv::addWeighted(panel.image, 1.0 - kPale, cv::Mat(target, CV_8UC3, kWhite), kPale, 0.0, panel.image);
  return panel;
}

// OpenCV's letters are those of ASCII.
std::string Ascii(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80)
      out += byte < 0x20 ? ' ' : c;
    else if (byte >= 0xC0)
      out += '?';
  }
  return out;
}

// Made smaller where it would not fit.
void PutText(cv::Mat& canvas, const std::string& text, int baseline, double scale) {
  const int room = canvas.cols - 2 * kGap;
  int below = 0;
  const int width = cv::getTextSize(Ascii(text), cv::FONT_HERSHEY_SIMPLEX, scale, 1, &below).width;
  if (width > room) scale *= static_cast<double>(room) / width;
  cv::putText(canvas, Ascii(text), {kGap, baseline}, cv::FONT_HERSHEY_SIMPLEX, scale, kBlack, 1, cv::LINE_AA);
}

std::string ErrorText(const EstimateError& error, const Estimate& estimate) {
  if (estimate.status != Status::kOk) return "no model (" + std::string(ToString(estimate.status)) + ")";
  if (!std::isnan(error.recall))
    return Format("misclassification error %.1f %%, recall %.2f", error.misclassified, error.recall);
  if (!std::isnan(error.rotation_deg))
    return (error.failed ? "no pose, " : "") +
           Format("error R %.2f deg, t %.2f deg", error.rotation_deg, error.translation_deg);
  if (std::isnan(error.error_px)) return "error unknown";
  return "error " + FixedNumber(error.error_px, 2) + " px";
}

std::string CountsText(const KeptFit& fit) {
  const MatchCounts counts = Count(fit);
  const std::string matches = " of " + std::to_string(fit.example.problem.points.rows()) + " matches";
  std::string text;
  if (fit.example.truth.inliers.empty()) {
    text = "inliers: " + std::to_string(counts.right) + " (green, truth unknown)" + matches;
  } else {
    text = "inliers: " + std::to_string(counts.right) + " right (green), " + std::to_string(counts.wrong) +
           " wrong (red), " + std::to_string(counts.missed) + " missed (blue)" + matches;
  }
  if (std::max({counts.right, counts.wrong, counts.missed}) > kMostLines)
    text += "; lines: " + std::to_string(kMostLines) + " of a colour at most";
  return text;
}

void DrawKind(cv::Mat& canvas, const KeptFit& fit, const Panel& left, const Panel& right, MatchKind kind,
              const cv::Scalar& colour) {
  const PointMatrix& points = fit.example.problem.points;
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    if (KindOf(fit, i) == kind && points.row(i).allFinite() && points.row(i).cwiseAbs().maxCoeff() < 1e6)
      rows.push_back(i);
  const std::size_t lines = kind == MatchKind::kOther ? 0 : std::min<std::size_t>(rows.size(), kMostLines);
  const cv::Mat below = canvas.clone();
  for (std::size_t k = 0; k < lines; ++k) {
    const auto row = points.row(rows[k * rows.size() / lines]);
    cv::line(canvas, left.At(row[0], row[1]), right.At(row[2], row[3]), colour, 1, cv::LINE_AA);
  }
  cv::addWeighted(canvas, kLineWeight, below, 1.0 - kLineWeight, 0.0, canvas);
  for (const Eigen::Index i : rows) {
    cv::circle(canvas, left.At(points(i, 0), points(i, 1)), 2, colour, cv::FILLED, cv::LINE_AA);
    cv::circle(canvas, right.At(points(i, 2), points(i, 3)), 2, colour, cv::FILLED, cv::LINE_AA);
  }
}

// Outliers first, as small dots, so that they hide nothing. `column`: where the points' x is.
void DrawLabels(cv::Mat& canvas, const PointMatrix& points, const std::vector<std::int32_t>& labels, const Panel& panel,
                int column) {
  for (const bool outliers : {true, false})
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      const std::int32_t label = labels[static_cast<std::size_t>(i)];
      if ((label == 0) != outliers || !points.row(i).allFinite() || points.row(i).cwiseAbs().maxCoeff() >= 1e6)
        continue;
      const cv::Point at = panel.At(points(i, column), points(i, column + 1));
      if (!outliers) cv::circle(canvas, at, kMark + 1, kWhite, cv::FILLED, cv::LINE_AA);
      cv::circle(canvas, at, outliers ? 2 : kMark, BlueGreenRed(LabelColour(label, true)), cv::FILLED, cv::LINE_AA);
    }
}

// Whether a fit is one of several structures, and whether the true ones are known.
bool ShowsStructures(const KeptFit& fit) {
  return !fit.estimate.structures.empty() || !fit.example.truth.structures.empty();
}
bool KnowsLabels(const KeptFit& fit) {
  return !fit.example.truth.assignment.empty() &&
         static_cast<Eigen::Index>(fit.example.truth.assignment.size()) == fit.example.problem.points.rows();
}

// A colour for each structure: those found in image 1, and beside them the true ones, with the colours of those that
// they are matched to; without a truth those found in both images.
void DrawStructures(cv::Mat& canvas, const KeptFit& fit, const Panel& left, const Panel& right) {
  const PointMatrix& points = fit.example.problem.points;
  const std::vector<std::int32_t> found = StructuresOf(fit.estimate, fit.example.problem).assignment;
  DrawLabels(canvas, points, found, left, 0);
  if (KnowsLabels(fit))
    DrawLabels(canvas, points, AlignedTruth(found, fit.example.truth.assignment), right, 0);
  else
    DrawLabels(canvas, points, found, right, 2);
}

std::string StructureCountsText(const KeptFit& fit) {
  const std::size_t found = StructuresOf(fit.estimate, fit.example.problem).models.size();
  const std::string matches = std::to_string(fit.example.problem.points.rows()) + " matches, outliers grey";
  if (!KnowsLabels(fit)) return std::to_string(found) + " structures found; " + matches;
  return "left: " + std::to_string(found) + " structures found, right: " +
         std::to_string(*std::max_element(fit.example.truth.assignment.begin(), fit.example.truth.assignment.end())) +
         " true ones; " + matches;
}

void DrawMatches(cv::Mat& canvas, const KeptFit& fit, const Panel& left, const Panel& right) {
  DrawKind(canvas, fit, left, right, MatchKind::kOther, kOther);
  DrawKind(canvas, fit, left, right, MatchKind::kMissed, kMissed);
  DrawKind(canvas, fit, left, right, MatchKind::kRight, kRight);
  DrawKind(canvas, fit, left, right, MatchKind::kWrong, kWrong);
}

cv::Mat MatchPicture(const KeptFit& fit, const ExperimentResults& results) {
  const ExperimentOptions& experiment = results.experiment;
  const Problem& problem = fit.example.problem;
  const auto [image1, image2] = ImageNames(fit.example);
  const auto& folders = experiment.figures.images;
  const bool structures = ShowsStructures(fit), twice = structures && KnowsLabels(fit);
  Panel left = MakePanel(ImageFile(folders, fit.example.scene, image1), CanvasSize(problem.size1, problem.points, 0));
  Panel right =
      twice ? left
            : MakePanel(ImageFile(folders, fit.example.scene, image2), CanvasSize(problem.size2, problem.points, 2));
  left.origin = {kGap, kTitleHeight};
  right.origin = {left.image.cols + 2 * kGap, kTitleHeight};
  cv::Mat canvas(kTitleHeight + std::max(left.image.rows, right.image.rows) + kGap,
                 left.image.cols + right.image.cols + 3 * kGap, CV_8UC3, kWhite);
  left.image.copyTo(canvas(cv::Rect(left.origin, left.image.size())));
  right.image.copyTo(canvas(cv::Rect(right.origin, right.image.size())));
  structures ? DrawStructures(canvas, fit, left, right) : DrawMatches(canvas, fit, left, right);
  // Points outside their image must not cover the text.
  canvas(cv::Rect(0, 0, canvas.cols, kTitleHeight)).setTo(kWhite);
  const std::string condition =
      experiment.conditions.size() > 1 ? ", " + experiment.conditions[fit.condition].label : std::string();
  PutText(canvas,
          experiment.methods[fit.method].label + ": " +
              ErrorText(MeasureError(fit.estimate, fit.example), fit.estimate) + " (" + fit.example.id + condition +
              ")",
          24, kTitleScale);
  PutText(canvas, structures ? StructureCountsText(fit) : CountsText(fit), 48, kTextScale);
  return canvas;
}

// A name without what a shell or a file system could mind.
std::string FileName(const KeptFit& fit, const ExperimentResults& results) {
  const ExperimentOptions& experiment = results.experiment;
  std::string name = "matches_" + experiment.conditions[fit.condition].name + "_" + fit.example.id + "_" +
                     experiment.methods[fit.method].name;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-' && c != '.') c = '_';
  return name + ".png";
}

}  // namespace

bool PlotMatches(const ExperimentResults& results, const std::string& folder) {
  if (!IsTwoView(results.experiment.task)) return false;
  for (const KeptFit& fit : results.fits) {
    const cv::Mat picture = MatchPicture(fit, results);
    std::vector<unsigned char> bytes;
    cv::imencode(".png", picture, bytes);
    WriteFileAtomically(folder + "/" + FileName(fit, results),
                        MarkedAsOwn({reinterpret_cast<const char*>(bytes.data()), bytes.size()}));
  }
  return !results.fits.empty();
}

}  // namespace diffsac
