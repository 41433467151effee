/// What the logs in memory ask of the columns they are given. Every complaint is an InvalidArgument that names the row, counted from 1.
#pragma once

#include <Eigen/Core>

namespace ssjs {

void check_rows(const char* what, Eigen::Index rows, Eigen::Index expected);  ///< as many as times
void check_columns(const char* what, Eigen::Index columns, Eigen::Index expected);
void check_times(const char* what, const Eigen::Ref<const Eigen::VectorXd>& time_s);  ///< finite, not decreasing
void check_finite(const char* what, const char* column, const Eigen::Ref<const Eigen::MatrixXd>& values);

}  // namespace ssjs
