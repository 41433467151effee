#include "ssjs/io/log_checks.hpp"

#include <cmath>
#include <string>

#include "ssjs/base/error.hpp"

namespace ssjs {

void check_rows(const char* what, Eigen::Index rows, Eigen::Index expected) {
  if (rows == expected) return;
  throw InvalidArgument(what, std::to_string(rows) + " rows", "must have as many rows as time_s, " + std::to_string(expected));
}

void check_columns(const char* what, Eigen::Index columns, Eigen::Index expected) {
  if (columns == expected) return;
  throw InvalidArgument(what, std::to_string(columns) + " columns", "must have " + std::to_string(expected));
}

void check_times(const char* what, const Eigen::Ref<const Eigen::VectorXd>& time_s) {
  for (Eigen::Index i = 0; i < time_s.size(); ++i) {
    const std::string name = std::string(what) + " time_s, row " + std::to_string(i + 1);
    if (!std::isfinite(time_s(i))) throw InvalidArgument(name, time_s(i), "must be finite");
    if (i > 0 && time_s(i) < time_s(i - 1)) throw InvalidArgument(name, time_s(i), "goes back: times must not decrease");
  }
}

void check_finite(const char* what, const char* column, const Eigen::Ref<const Eigen::MatrixXd>& values) {
  for (Eigen::Index i = 0; i < values.rows(); ++i) {
    if (values.row(i).allFinite()) continue;
    throw InvalidArgument(std::string(what) + " " + column + ", row " + std::to_string(i + 1), "not finite",
                          "remove the row or mend the log");
  }
}

}  // namespace ssjs
