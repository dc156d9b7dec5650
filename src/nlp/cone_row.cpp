#include "nlp/cone_row.hpp"

#include <cmath>
#include <numbers>

namespace conddp {

double ConeRow::root(const double* g, int n) const {
  double square = smoothing * smoothing;
  for (int i = 0; i < norm_rows(n); ++i) square += g[i] * g[i];
  return std::sqrt(square);
}

double ConeRow::value(const double* g, int n, double* slope) const {
  const double norm = root(g, n), factor = form == Form::surface ? std::numbers::sqrt2 : 1;
  if (slope != nullptr) {
    slope[n - 1] = 0;
    for (int i = 0; i < norm_rows(n); ++i) slope[i] = -g[i] / norm;
    slope[n - 1] += factor;
  }
  return factor * g[n - 1] - norm + smoothing;
}

void ConeRow::add_curvature(const Eigen::Ref<const Eigen::VectorXd>& g,
                            const Eigen::Ref<const Eigen::MatrixXd>& C, double weight,
                            Eigen::Ref<Eigen::MatrixXd> H) const {
  const int rows = norm_rows(static_cast<int>(g.size()));
  const double norm = root(g.data(), static_cast<int>(g.size()));
  const auto part = C.topRows(rows);
  const Eigen::VectorXd along = part.transpose() * g.head(rows);
  H.noalias() -= (weight / norm) * (part.transpose() * part);
  H.noalias() += (weight / (norm * norm * norm)) * along * along.transpose();
}

double ConeRow::multiplier(const double* nu, int n) const {
  if (form == Form::distance) return nu[n - 1];
  return -Eigen::Map<const Eigen::VectorXd>(nu, n).norm();
}

}  // namespace conddp
