#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>

#include "diffsac/problem/tasks.h"
#include "lab/eval/structures_error.h"
#include "lab/report/colours.h"
#include "lab/report/gnuplot.h"
#include "lab/report/plots.h"

namespace diffsac {
namespace {

constexpr int kMostPoints = 5000;  // More only make a picture of a scan slow.
constexpr int kMeshLines = 9;
constexpr int kMostPanels = 8;
constexpr int kTitleWidth = 560;  // In pixels, of the reverse steps' title.
constexpr const char* kEstimateColour = "#D55E00";
constexpr const char* kViridis =
    "set palette defined (0 \"#440154\", 0.25 \"#3B528B\", 0.5 \"#21918C\", 0.75 \"#5EC962\", 1 \"#FDE725\")\n";

std::string RowText(const Eigen::RowVectorXd& row) {
  std::string text;
  for (const double value : row) text += GnuplotNumber(value) + " ";
  return text + "\n";
}

// The points for which `kept(i)` holds, thinned evenly; a row that no range shows where there are none.
template <class Kept>
std::string PointBlock(const std::string& name, const PointMatrix& points, const Kept& kept) {
  const Eigen::Index stride = std::max<Eigen::Index>(1, points.rows() / kMostPoints);
  std::string text = "$" + name + " << EOD\n";
  bool any = false;
  for (Eigen::Index i = 0; i < points.rows(); i += stride) {
    if (!kept(i) || !points.row(i).allFinite()) continue;
    text += RowText(points.row(i));
    any = true;
  }
  if (!any) text += points.cols() == 2 ? "NaN NaN\n" : "NaN NaN NaN\n";
  return text + "EOD\n";
}

// The box around the finite points, a little larger.
struct Box {
  Eigen::VectorXd low;
  Eigen::VectorXd high;
  explicit Box(const PointMatrix& points)
      : low(Eigen::VectorXd::Constant(points.cols(), 1e300)), high(Eigen::VectorXd::Constant(points.cols(), -1e300)) {
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      if (!points.row(i).allFinite()) continue;
      low = low.cwiseMin(points.row(i).transpose());
      high = high.cwiseMax(points.row(i).transpose());
    }
    if ((low.array() > high.array()).any()) {
      low.setZero();
      high.setOnes();
    }
    const double margin = std::max(1e-9, 0.04 * (high - low).maxCoeff());
    low.array() -= margin;
    high.array() += margin;
  }
  // `downwards`: y as the rows of an image.
  std::string Ranges(bool downwards = false) const {
    static constexpr const char* kAxes[] = {"x", "y", "z"};
    std::string text;
    for (Eigen::Index d = 0; d < low.size(); ++d) {
      const bool turned = downwards && d == 1;
      text += std::string("set ") + kAxes[d] + "range [" + GnuplotNumber(turned ? high[d] : low[d]) + ":" +
              GnuplotNumber(turned ? low[d] : high[d]) + "]\n";
    }
    return text;
  }
};

// A line drawn beyond the box, which clips it.
std::string LineBlock(const std::string& name, const ModelParameters& model, const Box& box) {
  const Eigen::Vector2d normal = model.head(2), centre = 0.5 * (box.low + box.high);
  const Eigen::Vector2d direction(-normal[1], normal[0]), foot = centre - (normal.dot(centre) + model[2]) * normal;
  const double reach = (box.high - box.low).norm();
  return "$" + name + " << EOD\n" + RowText((foot - reach * direction).transpose()) +
         RowText((foot + reach * direction).transpose()) + "EOD\n";
}

// Where the mesh lies: the extent of the inliers along two directions in the plane.
template <class IsInlier>
std::string MeshBlock(const std::string& name, const ModelParameters& plane, const PointMatrix& points,
                      const IsInlier& is_inlier) {
  const Eigen::Vector3d normal = plane.head(3);
  Eigen::Vector3d u = normal.unitOrthogonal();
  // Along the axis that the plane contains best, so that the mesh follows the box.
  Eigen::Index axis = 0;
  normal.cwiseAbs().minCoeff(&axis);
  u = (Eigen::Vector3d::Unit(axis) - normal[axis] * normal).normalized();
  const Eigen::Vector3d v = normal.cross(u), origin = -plane[3] * normal;
  double low_u = 1e300, high_u = -1e300, low_v = 1e300, high_v = -1e300;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    if (!is_inlier(i)) continue;
    const Eigen::Vector3d offset = points.row(i).transpose() - origin;
    low_u = std::min(low_u, offset.dot(u));
    high_u = std::max(high_u, offset.dot(u));
    low_v = std::min(low_v, offset.dot(v));
    high_v = std::max(high_v, offset.dot(v));
  }
  std::string text = "$" + name + " << EOD\n";
  if (low_u > high_u) return text + "NaN NaN NaN\nEOD\n";
  for (int a = 0; a < kMeshLines; ++a) {
    for (int b = 0; b < kMeshLines; ++b) {
      const double at_u = low_u + (high_u - low_u) * a / (kMeshLines - 1);
      const double at_v = low_v + (high_v - low_v) * b / (kMeshLines - 1);
      text += RowText((origin + at_u * u + at_v * v).transpose());
    }
    text += "\n";
  }
  return text + "EOD\n";
}

std::string FitTitle(const KeptFit& fit, const ExperimentResults& results) {
  const EstimateError error = MeasureError(fit.estimate, fit.example);
  const auto inliers = std::count(fit.estimate.inliers.begin(), fit.estimate.inliers.end(), 1);
  const Condition& condition = results.experiment.conditions[fit.condition];
  std::string title = results.experiment.conditions.size() > 1
                          ? results.experiment.condition_label + " " + condition.label
                          : fit.example.id;
  if (error.failed) return title + ": " + std::string(ToString(fit.estimate.status));
  char text[64];
  if (!std::isnan(error.recall)) {
    std::snprintf(text, sizeof(text), ": recall %.2f, error %.1f %%", error.recall, error.misclassified);
    return title + text;
  }
  if (!fit.estimate.structures.empty()) title += ": " + std::to_string(fit.estimate.structures.size()) + " structures";
  if (!std::isnan(error.angle_deg) && fit.estimate.structures.empty()) {
    std::snprintf(text, sizeof(text), ": error %.2f°", error.angle_deg);
    return title + text;
  }
  return title + ": " + std::to_string(inliers) + " of " + std::to_string(fit.example.problem.points.rows()) +
         " inliers";
}

std::string InlierBlocks(const KeptFit& fit, const PointMatrix& points, const std::string& prefix) {
  const auto is_inlier = [&](Eigen::Index i) {
    return static_cast<std::size_t>(i) < fit.estimate.inliers.size() && fit.estimate.inliers[i] != 0;
  };
  return PointBlock(prefix + "_out", points, [&](Eigen::Index i) { return !is_inlier(i); }) +
         PointBlock(prefix + "_in", points, is_inlier);
}

std::string InliersPlot(const std::string& prefix) {
  return "plot $" + prefix + "_out with points pt 7 ps 0.6 lc rgb \"" + kOutlierColour + "\" title \"outliers\", $" +
         prefix + "_in with points pt 7 ps 0.6 lc rgb \"" + kInlierColour + "\" title \"inliers\"";
}

// Where the points are in the image.
std::string ImagePanel(const KeptFit& fit, const std::string& prefix) {
  const PointMatrix points = ImagePoints(fit.example.problem);
  return Box(points).Ranges(true) + InlierBlocks(fit, points, prefix) + InliersPlot(prefix) + "\n";
}

std::string LinePanel(const KeptFit& fit, const std::string& prefix) {
  const Box box(fit.example.problem.points);
  std::string text = box.Ranges() + InlierBlocks(fit, fit.example.problem.points, prefix);
  std::string plot = InliersPlot(prefix);
  if (fit.estimate.model.size() == 3) {
    text += LineBlock(prefix + "_est", fit.estimate.model, box);
    plot += ", $" + prefix + "_est with lines lw 2 lc rgb \"" + kEstimateColour + "\" title \"estimate\"";
  }
  if (fit.example.truth.model.size() == 3) {
    text += LineBlock(prefix + "_true", fit.example.truth.model, box);
    plot += ", $" + prefix + "_true with lines lw 1.5 dt 2 lc rgb \"#000000\" title \"true line\"";
  }
  return text + plot + "\n";
}

std::string PlanePanel(const KeptFit& fit, const std::string& prefix) {
  const std::string size = fit.example.problem.points.rows() > 1000 ? "0.2" : "0.6";
  std::string text = Box(fit.example.problem.points).Ranges() + InlierBlocks(fit, fit.example.problem.points, prefix);
  std::string plot = "splot $" + prefix + "_out with points pt 7 ps " + size + " lc rgb \"" + kOutlierColour +
                     "\" title \"outliers\", $" + prefix + "_in with points pt 7 ps " + size + " lc rgb \"" +
                     kInlierColour + "\" title \"inliers\"";
  if (fit.estimate.model.size() == 4) {
    const auto& inliers = fit.estimate.inliers;
    text += MeshBlock(prefix + "_est", fit.estimate.model, fit.example.problem.points, [&](Eigen::Index i) {
      return static_cast<std::size_t>(i) < inliers.size() && inliers[static_cast<std::size_t>(i)] != 0;
    });
    plot += ", $" + prefix + "_est with lines lw 1 lc rgb \"" + kEstimateColour + "\" title \"estimated plane\"";
  }
  return text + plot + "\n";
}

// A colour for each structure that was found, for its points and for its line or plane.
std::string StructuresPanel(const KeptFit& fit, const std::string& prefix) {
  const PointMatrix& points = fit.example.problem.points;
  const bool flat = points.cols() == 2;
  const Box box(points);
  const EstimatedStructures found = StructuresOf(fit.estimate, fit.example.problem);
  const auto has = [&](std::int32_t label) {
    return [&found, label](Eigen::Index i) { return found.assignment[static_cast<std::size_t>(i)] == label; };
  };
  const std::string points_style = std::string(" with points pt 7 ps ") + (points.rows() > 1000 ? "0.2" : "0.6");
  std::string text = box.Ranges() + PointBlock(prefix + "_out", points, has(0));
  std::string plot = std::string(flat ? "plot $" : "splot $") + prefix + "_out" + points_style + " lc rgb \"" +
                     kOutlierColour + "\" title \"outliers\"";
  for (std::size_t k = 0; k < fit.example.truth.structures.size() && flat; ++k) {
    const std::string name = prefix + "_true" + std::to_string(k);
    text += LineBlock(name, fit.example.truth.structures[k], box);
    plot +=
        ", $" + name + " with lines lw 1.5 dt 2 lc rgb \"#000000\" " + (k == 0 ? "title \"true lines\"" : "notitle");
  }
  for (std::size_t k = 0; k < found.models.size(); ++k) {
    const std::string name = prefix + "_s" + std::to_string(k), colour = std::string(" lc rgb \"") + StructureColour(k);
    const auto is_member = has(static_cast<std::int32_t>(k) + 1);
    text += PointBlock(name, points, is_member) + (flat ? LineBlock(name + "_est", found.models[k], box)
                                                        : MeshBlock(name + "_est", found.models[k], points, is_member));
    plot += ", $" + name + points_style + colour + "\" notitle, $" + name + "_est with lines lw " + (flat ? "2" : "1") +
            colour + "\" notitle";
  }
  return text + plot + "\n";
}

// The segments for which `kept(i)` holds; one that no range shows where there are none.
template <class Kept>
std::string SegmentBlock(const std::string& name, const PointMatrix& segments, const Kept& kept) {
  std::string text = "$" + name + " << EOD\n";
  bool any = false;
  for (Eigen::Index i = 0; i < segments.rows(); ++i) {
    if (!kept(i) || !segments.row(i).allFinite()) continue;
    text += RowText(segments.row(i).head(2)) + RowText(segments.row(i).tail(2)) + "\n";
    any = true;
  }
  return text + (any ? "EOD\n" : "NaN NaN\nEOD\n");
}

// Line segments of an image in the colour of their vanishing point.
std::string SegmentsPanel(const KeptFit& fit, const std::string& prefix) {
  const PointMatrix& segments = fit.example.problem.points;
  PointMatrix ends(2 * segments.rows(), 2);
  ends << segments.leftCols(2), segments.rightCols(2);
  const EstimatedStructures found = StructuresOf(fit.estimate, fit.example.problem);
  const auto has = [&](std::int32_t label) {
    return [&found, label](Eigen::Index i) { return found.assignment[static_cast<std::size_t>(i)] == label; };
  };
  std::string text = Box(ends).Ranges(true) + SegmentBlock(prefix + "_out", segments, has(0));
  std::string plot = "plot $" + prefix + "_out with lines lw 1 lc rgb \"" + kOutlierColour + "\" title \"others\"";
  for (std::size_t k = 0; k < found.models.size(); ++k) {
    const std::string name = prefix + "_s" + std::to_string(k), number = std::to_string(k + 1);
    text += SegmentBlock(name, segments, has(static_cast<std::int32_t>(k) + 1));
    plot += ", $" + name + " with lines lw 2 lc rgb \"" + StructureColour(k) + "\" title \"" + number + "\"";
  }
  return text + plot + "\n";
}

// Whether a fit is one of several structures.
bool HasStructures(const KeptFit& fit) {
  return !fit.estimate.structures.empty() || !fit.example.truth.structures.empty();
}

std::string FitPanel(const KeptFit& fit, const std::string& prefix) {
  if (ImagePoints(fit.example.problem).size() > 0) {
    const bool segments = fit.example.problem.task == Task::kVanishingPoint;
    return "set xlabel \"u [px]\"\nset ylabel \"v [px]\"\n" +
           (segments ? SegmentsPanel(fit, prefix) : ImagePanel(fit, prefix));
  }
  const std::string axes = fit.example.problem.points.cols() == 2 ? "set xlabel \"x\"\nset ylabel \"y\"\n" : "";
  if (HasStructures(fit)) return axes + StructuresPanel(fit, prefix);
  return axes + (axes.empty() ? PlanePanel(fit, prefix) : LinePanel(fit, prefix));
}

// The steps to show: all, or kMostPanels evenly spread with the first and the last.
std::vector<std::size_t> ShownSteps(std::size_t steps) {
  const std::size_t shown = std::min<std::size_t>(steps, kMostPanels);
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < shown; ++i) indices.push_back(shown == 1 ? 0 : i * (steps - 1) / (shown - 1));
  return indices;
}

std::vector<int> MostConfident(const std::vector<float>& confidence, int count) {
  std::vector<int> order(confidence.size());
  std::iota(order.begin(), order.end(), 0);
  const auto middle = order.begin() + std::min<std::ptrdiff_t>(count, order.size());
  std::partial_sort(order.begin(), middle, order.end(), [&](int a, int b) {
    return confidence[a] != confidence[b] ? confidence[a] > confidence[b] : a < b;
  });
  order.erase(middle, order.end());
  return order;
}

// Bright points are drawn last, so that they are not hidden. A point of confidence −∞ was left out before decoding.
std::string ConfidencePanel(const Problem& problem, const std::vector<float>& confidence, int set_size,
                            const std::string& prefix) {
  const std::vector<int> order = MostConfident(confidence, static_cast<int>(confidence.size()));
  std::string points = "$" + prefix + " << EOD\n", top = "$" + prefix + "_top << EOD\n";
  std::string left_out = "$" + prefix + "_out << EOD\n";
  bool any_left_out = false;
  for (auto i = order.rbegin(); i != order.rend(); ++i) {
    std::string row = RowText(problem.points.row(*i));
    if (!std::isfinite(confidence[*i])) {
      left_out += row;
      any_left_out = true;
      continue;
    }
    row.insert(row.size() - 1, GnuplotNumber(confidence[*i]));
    points += row;
  }
  for (const int i : MostConfident(confidence, set_size)) top += RowText(problem.points.row(i));
  const bool line = problem.points.cols() == 2;
  std::string command = line ? "plot " : "splot ";
  if (any_left_out) command += "$" + prefix + "_out with points pt 6 ps 0.6 lc rgb \"#BBBBBB\" notitle, ";
  return points + "EOD\n" + top + "EOD\n" + (any_left_out ? left_out + "EOD\n" : "") + command + "$" + prefix +
         " using " + (line ? "1:2:3" : "1:2:3:4") + " with points pt 7 ps 0.9 lc palette notitle, $" + prefix +
         "_top with points pt 6 ps 1.9 lw 2 lc rgb \"" + kEstimateColour + "\" notitle\n";
}

std::string CommonSettings(Eigen::Index dimension, bool ratio) {
  std::string text = "set clip two\nset tics font \",9\" nomirror\nset grid ls 100\n";
  if (dimension == 2) return text + (ratio ? "set size ratio -1\n" : "");
  return text + "set view 62,35\nset xyplane 0\nset ticslevel 0\nset view equal xyz\nset xtics offset 0,-0.3\n" +
         "unset grid\nset border 4095 lc rgb \"#C8C8C8\"\n";
}

// Points of an image where they are there, as points of the plane.
Problem InThePlane(const Problem& problem) {
  Problem flat;
  flat.points = ImagePoints(problem);
  return flat.points.size() > 0 ? flat : problem;
}

bool HasPoints(const ConfidenceTrace& trace, const Problem& problem) {
  if (trace.confidence.empty() || trace.timesteps.size() != trace.confidence.size()) return false;
  return std::all_of(trace.confidence.begin(), trace.confidence.end(), [&](const auto& values) {
    return !values.empty() && static_cast<Eigen::Index>(values.size()) == problem.points.rows();
  });
}

}  // namespace

bool PlotFits(const ExperimentResults& results, const std::string& folder) {
  if (results.fits.empty()) return false;
  const Task task = results.experiment.task;
  if (IsTwoView(task)) return false;
  const int dimension = static_cast<int>(InThePlane(results.fits[0].example.problem).points.cols());
  const bool one_condition = results.experiment.conditions.size() == 1;
  const int fits = static_cast<int>(results.fits.size());
  const int columns = std::min(4, one_condition ? fits : std::max(1, fits / results.experiment.figures.qualitative));
  const int rows = (fits + columns - 1) / columns;
  const std::string title =
      results.fits_label + ": " + ToString(task) + " fits" + (results.partial ? " (partial)" : "");
  std::string script = CommonSettings(dimension, true) + "set multiplot layout " + std::to_string(rows) + "," +
                       std::to_string(columns) + " title " + GnuplotText(title) + " font \",14\"\n" +
                       "set key below horizontal samplen 1.5 font \",9\"\n";
  // Row by row in the grid: the first problem of every condition, then the second.
  std::vector<const KeptFit*> ordered;
  for (const KeptFit& fit : results.fits) ordered.push_back(&fit);
  std::vector<int> seen(results.experiment.conditions.size(), 0);
  std::vector<int> rank;
  for (const KeptFit& fit : results.fits) rank.push_back(seen[fit.condition]++);
  std::stable_sort(ordered.begin(), ordered.end(), [&](const KeptFit* a, const KeptFit* b) {
    return rank[a - results.fits.data()] < rank[b - results.fits.data()];
  });
  for (int i = 0; i < fits; ++i) {
    script += "set title " + GnuplotText(FitTitle(*ordered[i], results)) + " font \",11\"\n";
    const std::string prefix = "fit" + std::to_string(i);
    script += FitPanel(*ordered[i], prefix);
  }
  return DrawPicture(folder, "fits", script + "unset multiplot\n", 380 * columns + 20, 420 * rows + 50);
}

bool PlotConfidenceTrace(const Problem& whole, const ConfidenceTrace& trace, const std::string& path) {
  if (!HasPoints(trace, whole)) return false;
  const Problem problem = InThePlane(whole);
  const std::vector<std::size_t> steps = ShownSteps(trace.confidence.size());
  const int panels = static_cast<int>(steps.size()), columns = panels <= 4 ? panels : (panels + 1) / 2;
  const int rows = (panels + columns - 1) / columns;
  std::string script = CommonSettings(problem.points.cols(), true) + kViridis +
                       Box(problem.points).Ranges(ImagePoints(whole).size() > 0) +
                       "set cbrange [-1:1]\nset cblabel \"confidence\"\nset cbtics (-1, 0, 1)\nset multiplot layout " +
                       std::to_string(rows) + "," + std::to_string(columns) +
                       " title \"Confidence over the reverse steps\\n(circled: the minimal set; grey: left out before "
                       "decoding)\" font \",13\"\n";
  for (int i = 0; i < panels; ++i) {
    const std::size_t step = steps[i];
    char title[64];
    std::snprintf(title, sizeof(title), "step %d of %d, t = %.3g", static_cast<int>(step) + 1,
                  static_cast<int>(trace.confidence.size()), trace.timesteps[step]);
    script += "set title " + GnuplotText(title) + " font \",11\"\n" +
              ConfidencePanel(problem, trace.confidence[step], MinimalSetSize(whole.task), "step" + std::to_string(i));
  }
  const std::filesystem::path file(path);
  const std::string folder = file.has_parent_path() ? file.parent_path().string() : ".";
  return DrawPicture(folder, file.stem().string(), script + "unset multiplot\n",
                     std::max(kTitleWidth, 390 * columns + 20), 360 * rows + 70);
}

}  // namespace diffsac
