#include "diffsac/report/svg_fits.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include "diffsac/report/gnuplot.h"
#include "diffsac/report/match_kinds.h"
#include "diffsac/eval/structures_error.h"
#include "diffsac/report/svg_axes.h"

namespace diffsac {
namespace {

constexpr double kWidth = 400, kHeight = 340, kMargin = 12;
constexpr Eigen::Index kMostPoints = 1500;

/// From the data to the picture, both axes with the same scale.
struct Projection {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300), high = Eigen::Vector2d::Constant(-1e300);
  bool downwards = false;  // y as the rows of an image
  std::function<Eigen::Vector2d(const Eigen::VectorXd&)> flat;

  void Hold(const Eigen::VectorXd& point) {
    if (!point.allFinite()) return;
    low = low.cwiseMin(flat(point));
    high = high.cwiseMax(flat(point));
  }
  double Scale() const {
    const Eigen::Vector2d extent = (high - low).cwiseMax(1e-9);
    return std::min((kWidth - 2 * kMargin) / extent.x(), (kHeight - 2 * kMargin) / extent.y());
  }
  std::string At(const Eigen::Vector2d& place) const {
    const Eigen::Vector2d from_centre = (place - (low + high) / 2) * Scale();
    return SvgNumber(kWidth / 2 + from_centre.x()) + " " +
           SvgNumber(kHeight / 2 + (downwards ? 1.0 : -1.0) * from_centre.y());
  }
};

/// Seen from 30 degrees above, turned by 35.
Eigen::Vector2d FromAfar(const Eigen::VectorXd& point) {
  const double turn = 35.0 * M_PI / 180.0, up = 30.0 * M_PI / 180.0;
  const double right = std::cos(turn) * point[0] + std::sin(turn) * point[1];
  const double back = -std::sin(turn) * point[0] + std::cos(turn) * point[1];
  return {right, std::cos(up) * point[2] + std::sin(up) * back};
}

const char* ClassOf(MatchKind kind) {
  switch (kind) {
    case MatchKind::kRight: return "right";
    case MatchKind::kWrong: return "wrong";
    case MatchKind::kMissed: return "missed";
    case MatchKind::kOther: break;
  }
  return "other";
}

/// The points for which `shown(i)` holds as one path of dots: short, and quick to draw.
template <class Shown>
std::string Dots(const PointMatrix& points, const Projection& projection, const std::string& colour, const Shown& shown) {
  const Eigen::Index stride = std::max<Eigen::Index>(1, points.rows() / kMostPoints);
  std::string path;
  for (Eigen::Index i = 0; i < points.rows(); i += stride) {
    if (!points.row(i).allFinite() || !shown(static_cast<std::size_t>(i))) continue;
    path += "M" + projection.At(projection.flat(points.row(i).transpose())) + "h0";
  }
  if (path.empty()) return "";
  const std::string size = points.rows() > 600 ? "3" : "5";
  return std::string("<path d=\"") + path + "\" style=\"fill:none;stroke-linecap:round;stroke-width:" + size +
         ";stroke:var(--" + colour + ")\"/>\n";
}

std::string DotsOfKind(const KeptFit& fit, const PointMatrix& points, const Projection& projection, MatchKind kind) {
  return Dots(points, projection, ClassOf(kind), [&](std::size_t i) {
    return KindOfMatch(fit.estimate.inliers, fit.example.truth.inliers, i) == kind;
  });
}

/// A line beyond the picture, which cuts it off.
std::string LinePath(const ModelParameters& line, const Projection& projection, const std::string& style) {
  if (line.size() != 3 || !line.allFinite()) return "";
  const Eigen::Vector2d normal = line.head(2), centre = (projection.low + projection.high) / 2;
  const Eigen::Vector2d direction(-normal[1], normal[0]), foot = centre - (normal.dot(centre) + line[2]) * normal;
  const double reach = (projection.high - projection.low).norm() + 1.0;
  return "<path d=\"M" + projection.At(foot - reach * direction) + "L" + projection.At(foot + reach * direction) +
         "\" style=\"fill:none;" + style + "\"/>\n";
}

/// The part of a plane that these points cover.
std::string PlanePath(const ModelParameters& plane, const PointMatrix& points, const std::vector<std::uint8_t>& inliers,
                      const Projection& projection, const std::string& style) {
  if (plane.size() != 4 || !plane.allFinite() || inliers.size() != static_cast<std::size_t>(points.rows())) return "";
  const Eigen::Vector3d normal = plane.head(3), origin = -plane[3] * normal;
  Eigen::Index axis = 0;
  normal.cwiseAbs().minCoeff(&axis);
  const Eigen::Vector3d u = (Eigen::Vector3d::Unit(axis) - normal[axis] * normal).normalized(), v = normal.cross(u);
  Eigen::Array2d low(1e300, 1e300), high(-1e300, -1e300);
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    if (inliers[static_cast<std::size_t>(i)] == 0) continue;
    const Eigen::Vector3d offset = points.row(i).transpose() - origin;
    const Eigen::Array2d place(offset.dot(u), offset.dot(v));
    low = low.min(place);
    high = high.max(place);
  }
  if ((low > high).any()) return "";
  std::string path;
  for (const auto& [a, b] : {std::pair{low[0], low[1]}, {high[0], low[1]}, {high[0], high[1]}, {low[0], high[1]}})
    path += (path.empty() ? "M" : "L") + projection.At(projection.flat(origin + a * u + b * v));
  return "<path d=\"" + path + "Z\" style=\"" + style + "\"/>\n";
}

bool IsOfStructures(const KeptFit& fit) {
  return !fit.estimate.structures.empty() || !fit.example.truth.structures.empty();
}

std::string Legend(const KeptFit& fit) {
  const bool truth = !fit.example.truth.inliers.empty(), image = ImagePoints(fit.example.problem).size() > 0;
  struct Entry {
    const char *colour, *text;
  };
  std::vector<Entry> entries = {{"right", truth ? "right inlier" : "inlier"}, {"other", truth ? "right outlier" : "outlier"}};
  if (truth) entries.insert(entries.end(), {{"wrong", "wrong inlier"}, {"missed", "missed inlier"}});
  if (IsOfStructures(fit))
    entries = {{"other", "no structure"}, {"s0", "a colour for each structure that is found"}};
  else if (!image)
    entries.push_back({"s1", "estimate"});
  if (!image && fit.example.truth.model.size() > 0) entries.push_back({"ink", "truth (dashed)"});
  std::string svg;
  double x = 4, y = kHeight + 16;
  for (const Entry& entry : entries) {
    const double width = 18 + TextWidth(entry.text) + 8;
    if (x + width > kWidth) x = 4, y += 17;
    svg += "<rect x=\"" + SvgNumber(x) + "\" y=\"" + SvgNumber(y - 9) +
           "\" width=\"10\" height=\"10\" style=\"fill:var(--" + entry.colour + ")\"/>" + SvgText(x + 15, y, entry.text);
    x += width;
  }
  return svg + "\n";
}

constexpr const char* kEstimateStyle = "stroke:var(--s1);stroke-width:2";
constexpr const char* kTruthStyle = "stroke:var(--ink);stroke-width:1.3;stroke-dasharray:6 4";

std::string Models(const KeptFit& fit, const PointMatrix& points, const Projection& projection) {
  const GroundTruth& truth = fit.example.truth;
  if (points.cols() == 3)
    return PlanePath(fit.estimate.model, points, fit.estimate.inliers, projection,
                     std::string("fill:var(--s1);fill-opacity:.18;") + kEstimateStyle) +
           PlanePath(truth.model, points, truth.inliers, projection, std::string("fill:none;") + kTruthStyle);
  return LinePath(fit.estimate.model, projection, kEstimateStyle) + LinePath(truth.model, projection, kTruthStyle);
}

/// A colour for each structure that was found, for its points and its line or plane.
std::string Structures(const KeptFit& fit, const PointMatrix& points, const Projection& projection) {
  const EstimatedStructures found = StructuresOf(fit.estimate, fit.example.problem);
  const auto members = [&](std::int32_t label, const std::vector<std::int32_t>& labels) {
    std::vector<std::uint8_t> mask;
    for (const std::int32_t of_point : labels) mask.push_back(of_point == label);
    return mask;
  };
  const auto draw = [&](const ModelParameters& model, const std::vector<std::uint8_t>& mask, const std::string& style) {
    return points.cols() == 3 ? PlanePath(model, points, mask, projection, "fill:none;" + style)
                              : LinePath(model, projection, style);
  };
  std::string svg = Dots(points, projection, "other", [&](std::size_t i) { return found.assignment[i] == 0; });
  for (std::size_t k = 0; k < found.models.size(); ++k) {
    const auto label = static_cast<std::int32_t>(k) + 1;
    const std::string colour = "s" + std::to_string(k % (kSeriesColours - 1));
    svg += Dots(points, projection, colour, [&](std::size_t i) { return found.assignment[i] == label; }) +
           draw(found.models[k], members(label, found.assignment), "stroke:var(--" + colour + ");stroke-width:2");
  }
  const GroundTruth& truth = fit.example.truth;
  for (std::size_t k = 0; k < truth.structures.size(); ++k)
    svg += draw(truth.structures[k], members(static_cast<std::int32_t>(k) + 1, truth.assignment), kTruthStyle);
  return svg;
}

std::string OneModel(const KeptFit& fit, const PointMatrix& points, const Projection& projection, bool image) {
  std::string svg;
  for (const MatchKind kind : {MatchKind::kOther, MatchKind::kMissed, MatchKind::kRight, MatchKind::kWrong})
    svg += DotsOfKind(fit, points, projection, kind);
  return image ? svg : svg + Models(fit, points, projection);
}

}  // namespace

std::string SvgOfFit(const KeptFit& fit) {
  if (IsTwoView(fit.example.problem.task)) return "";
  const PointMatrix image = ImagePoints(fit.example.problem);
  const PointMatrix& points = image.size() > 0 ? image : fit.example.problem.points;
  if (points.cols() != 2 && points.cols() != 3) return "";
  Projection projection;
  projection.downwards = image.size() > 0;
  projection.flat = [&](const Eigen::VectorXd& p) { return points.cols() == 3 ? FromAfar(p) : Eigen::Vector2d(p); };
  for (Eigen::Index i = 0; i < points.rows(); ++i) projection.Hold(points.row(i).transpose());
  std::string svg = "<svg x=\"0\" y=\"0\" width=\"" + SvgNumber(kWidth) + "\" height=\"" + SvgNumber(kHeight) + "\">\n";
  svg += IsOfStructures(fit) ? Structures(fit, points, projection) : OneModel(fit, points, projection, image.size() > 0);
  svg += "</svg>\n<rect class=\"grid\" x=\"0.5\" y=\"0.5\" width=\"" + SvgNumber(kWidth - 1) + "\" height=\"" +
         SvgNumber(kHeight - 1) + "\"/>\n";
  return SvgPicture(kWidth, kHeight + 56, "fit of " + fit.example.id, svg + Legend(fit));
}

std::string FitCaption(const KeptFit& fit, const ExperimentOptions& experiment) {
  std::string text = experiment.methods[fit.method].label + ", " + fit.example.id;
  if (experiment.conditions.size() > 1)
    text += ", " + experiment.condition_label + " " + experiment.conditions[fit.condition].label;
  if (fit.estimate.status != Status::kOk) return text + ": no model (" + std::string(ToString(fit.estimate.status)) + ")";
  const EstimateError errors = MeasureError(fit.estimate, fit.example);
  const double error = ShownError(errors, experiment.tolerance());
  const bool structures = !std::isnan(errors.recall);
  char number[48];
  const std::string unit = ShownUnit(structures, experiment.tolerance());
  std::snprintf(number, sizeof(number), ": error %.3g%s%s", error, unit == "°" ? "" : " ", unit.c_str());
  if (!std::isnan(error)) text += number;
  const auto points = static_cast<std::size_t>(fit.example.problem.points.rows());
  const MatchCounts counts = CountMatches(fit.estimate.inliers, fit.example.truth.inliers, points);
  if (fit.example.truth.inliers.empty())
    return text + "; " + std::to_string(counts.right) + " of " + std::to_string(points) + " points are inliers";
  return text + "; " + std::to_string(points) + " points, inliers: " + std::to_string(counts.right) + " right, " +
         std::to_string(counts.wrong) + " wrong, " + std::to_string(counts.missed) + " missed";
}

}  // namespace diffsac
