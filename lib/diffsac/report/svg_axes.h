#pragma once

#include <string>
#include <vector>

namespace diffsac {

/// A coordinate in pixels, with one decimal.
std::string SvgNumber(double value);

/// "0.512", short: what stands at axes and in legends.
std::string ShortNumber(double value);

/// From values to pixels along one axis.
struct SvgAxis {
  double low = 0.0, high = 1.0;     ///< Values at its ends; low < high.
  double first = 0.0, last = 0.0;   ///< Pixels of `low` and `high`.
  bool logarithmic = false;
  double At(double value) const;
  /// Round numbers within it, about `count` of them; powers of ten, with their 2 and 5 where these are few.
  std::vector<double> Ticks(int count) const;
};

/// The axis that holds these values with a little room around them; from 0 to 1 for no values.
SvgAxis FitAxis(const std::vector<double>& values, bool logarithmic);

/// How wide a text is about to be, in pixels.
double TextWidth(const std::string& text);

/// A text at a place; `more`: further attributes.
std::string SvgText(double x, double y, const std::string& text, const std::string& more = "");

/// Frame, grid, numbers and labels of two axes. `ticks_x` false: numbers and grid of y alone.
std::string SvgFrame(const SvgAxis& x, const SvgAxis& y, const std::string& x_label, const std::string& y_label,
                     bool ticks_x = true);

/// The picture's element around its content.
std::string SvgPicture(double width, double height, const std::string& title, const std::string& content);

}  // namespace diffsac
