#include "diffsac/core/status.h"

namespace diffsac {

std::string_view ToString(Status status) {
  switch (status) {
    case Status::kOk:
      return "ok";
    case Status::kTooFewPoints:
      return "too_few_points";
    case Status::kDegenerate:
      return "degenerate";
    case Status::kNoModel:
      return "no_model";
    case Status::kTooManyPoints:
      return "too_many_points";
  }
  return "unknown";
}

std::string MessageOf(const std::exception& exception) {
  const std::string text = exception.what();
  return dynamic_cast<const Error*>(&exception) != nullptr ? text : text.substr(0, text.find('\n'));
}

}  // namespace diffsac
