#pragma once

#include <CLI/CLI.hpp>

#include <sstream>
#include <string>

namespace diffsac {

/// Checks of numbers on a command line. CLI11's own print the ends of their ranges with all their digits, of doubles
/// 309.
inline CLI::Validator NumberCheck(const std::string& expected, bool (*good)(double value, double low, double high),
                                  double low, double high) {
  return CLI::Validator(
      [=](std::string& text) {
        double value = 0.0;
        const bool number = CLI::detail::lexical_cast(text, value);
        return number && good(value, low, high) ? "" : "expected " + expected + ", found '" + text + "'";
      },
      "");
}

/// A number as a person writes it: "0", "0.5", "1024".
inline std::string PlainNumber(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

inline CLI::Validator NumberAbove(double low) {
  return NumberCheck(
      "a number above " + PlainNumber(low), [](double v, double l, double) { return v > l; }, low, low);
}

inline CLI::Validator NumberFrom(double low) {
  return NumberCheck(
      "a number from " + PlainNumber(low) + " on", [](double v, double l, double) { return v >= l; }, low, low);
}

inline CLI::Validator NumberWithin(double low, double high) {
  return NumberCheck(
      "a number from " + PlainNumber(low) + " to " + PlainNumber(high),
      [](double v, double l, double h) { return v >= l && v <= h; }, low, high);
}

}  // namespace diffsac
