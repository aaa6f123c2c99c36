#include "src/diagnose/projection.hpp"
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace quern {

double project_out(const Eigen::MatrixXd& columns, Eigen::MatrixXd& others, Eigen::VectorXd& rest) {
  if (columns.cols() == 0) return 0;
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
  const Eigen::Index rank = std::min<Eigen::Index>(qr.rank(), columns.rows());
  const Eigen::MatrixXd basis = qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), rank);
  others -= basis * (basis.transpose() * others);
  rest -= basis * (basis.transpose() * rest);
  double log_size = 0;
  for (Eigen::Index k = 0; k < rank; ++k) log_size += std::log(std::abs(qr.matrixQR()(k, k)));
  return log_size;
}

}  // namespace quern
