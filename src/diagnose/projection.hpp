#pragma once
#include <Eigen/Core>

namespace quern {

// Takes what the columns explain out of other columns and a vector of as many rows; returns ln |R| of the columns.
double project_out(const Eigen::MatrixXd& columns, Eigen::MatrixXd& others, Eigen::VectorXd& rest);

}  // namespace quern
