#pragma once

#include <Eigen/Core>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

namespace diffsac {

// What the JSON of programs is made of: keys stand in the order in which they are written.
using Json = nlohmann::ordered_json;

/// null where it is no number.
inline Json FiniteJson(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

/// A list of rows.
inline Json MatrixJson(const Eigen::MatrixXd& matrix) {
  Json rows = Json::array();
  for (const auto& row : matrix.rowwise()) rows.push_back(Json(std::vector<double>(row.begin(), row.end())));
  return rows;
}

/// What `json` makes of a value; null where there is none.
template <class Optional, class ToJson>
Json OptionalJson(const Optional& value, const ToJson& json) {
  return value ? Json(json(*value)) : Json(nullptr);
}

/// The whole file. Names of files need not be UTF-8.
inline std::string JsonText(const Json& json, int indent = 2) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace diffsac
