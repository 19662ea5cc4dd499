#include "diffsac/report/svg_axes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "diffsac/report/html_page.h"

namespace diffsac {
namespace {

constexpr double kLetter = 6.7;  // Pixels, of a text of 12 pixels.

std::vector<double> LinearTicks(double low, double high, int count) {
  const double rough = (high - low) / std::max(1, count), power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10.0 * power;
  for (const double factor : {5.0, 2.0, 1.0})
    if (factor * power >= rough) step = factor * power;
  std::vector<double> ticks;
  for (double i = std::ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; ++i) ticks.push_back(i * step);
  return ticks;
}

std::vector<double> LogarithmicTicks(double low, double high) {
  const bool few = std::log10(high / low) < 2.5;
  std::vector<double> ticks;
  for (double power = std::pow(10.0, std::floor(std::log10(low))); power <= high; power *= 10.0)
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double tick = factor * power;
      if ((factor == 1.0 || few) && tick >= low * (1.0 - 1e-9) && tick <= high * (1.0 + 1e-9)) ticks.push_back(tick);
    }
  return ticks;
}

std::string SvgLine(double x1, double y1, double x2, double y2, const std::string& kind) {
  return "<line class=\"" + kind + "\" x1=\"" + SvgNumber(x1) + "\" y1=\"" + SvgNumber(y1) + "\" x2=\"" +
         SvgNumber(x2) + "\" y2=\"" + SvgNumber(y2) + "\"/>";
}

}  // namespace

std::string SvgNumber(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.1f", std::clamp(value, -1e6, 1e6));
  return text;
}

std::string ShortNumber(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), std::abs(value) >= 1000.0 && std::abs(value) < 1e6 ? "%.0f" : "%.3g",
                std::abs(value) < 1e-12 ? 0.0 : value);
  return text;
}

double SvgAxis::At(double value) const {
  const double share = logarithmic ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
  return first + share * (last - first);
}

std::vector<double> SvgAxis::Ticks(int count) const {
  return logarithmic ? LogarithmicTicks(low, high) : LinearTicks(low, high, count);
}

SvgAxis FitAxis(const std::vector<double>& values, bool logarithmic) {
  SvgAxis axis;
  axis.logarithmic = logarithmic;
  double low = 1e300, high = -1e300;
  for (const double value : values) {
    if (!std::isfinite(value) || (logarithmic && !(value > 0.0))) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  if (low > high) low = logarithmic ? 0.1 : 0.0, high = 1.0;
  if (logarithmic) {
    const double room = std::max(std::pow(high / low, 0.03), 1.05);
    axis.low = low / room;
    axis.high = high * room;
    return axis;
  }
  const double room = high > low ? 0.03 * (high - low) : std::max(0.5, 0.1 * std::abs(high));
  axis.low = low - room;
  axis.high = high + room;
  return axis;
}

double TextWidth(const std::string& text) {
  const auto letters =
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; });
  return kLetter * static_cast<double>(letters);
}

std::string SvgText(double x, double y, const std::string& text, const std::string& more) {
  return "<text x=\"" + SvgNumber(x) + "\" y=\"" + SvgNumber(y) + "\"" + (more.empty() ? "" : " ") + more + ">" +
         HtmlText(text) + "</text>";
}

std::string SvgFrame(const SvgAxis& x, const SvgAxis& y, const std::string& x_label, const std::string& y_label,
                     bool ticks_x) {
  std::string svg;
  for (const double tick : y.Ticks(6)) {
    svg += SvgLine(x.first, y.At(tick), x.last, y.At(tick), "grid");
    svg += SvgText(x.first - 6, y.At(tick) + 4, ShortNumber(tick), "text-anchor=\"end\" class=\"soft\"");
  }
  for (const double tick : ticks_x ? x.Ticks(8) : std::vector<double>()) {
    svg += SvgLine(x.At(tick), y.first, x.At(tick), y.last, "grid");
    svg += SvgText(x.At(tick), y.first + 17, ShortNumber(tick), "text-anchor=\"middle\" class=\"soft\"");
  }
  svg += SvgLine(x.first, y.first, x.last, y.first, "axis") + SvgLine(x.first, y.first, x.first, y.last, "axis");
  svg += SvgText((x.first + x.last) / 2, y.first + 36, x_label, "text-anchor=\"middle\"");
  const std::string middle = SvgNumber((y.first + y.last) / 2);
  return svg + SvgText(0, 0, y_label, "text-anchor=\"middle\" transform=\"translate(14 " + middle + ") rotate(-90)\"") +
         "\n";
}

std::string SvgPicture(double width, double height, const std::string& title, const std::string& content) {
  const std::string w = SvgNumber(width), h = SvgNumber(height);
  return "<svg viewBox=\"0 0 " + w + " " + h + "\" width=\"" + w + "\" height=\"" + h + "\" role=\"img\" aria-label=\"" +
         HtmlText(title) + "\">\n" + content + "</svg>\n";
}

}  // namespace diffsac
