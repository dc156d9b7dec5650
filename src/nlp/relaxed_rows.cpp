#include "nlp/relaxed_rows.hpp"

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

double pair_value(PairRelaxation relaxation, const double* g, int count, double epsilon,
                  double* slope) {
  double value = 0;
  for (int i = 0; i < count; i += 2) {
    const double z = g[i], s = g[i + 1];
    if (relaxation == PairRelaxation::fischer_burmeister) {
      const double root = std::sqrt(z * z + s * s + 2 * epsilon);
      value += z + s - root;
      if (slope == nullptr) continue;
      slope[i] = 1 - z / root;
      slope[i + 1] = 1 - s / root;
      continue;
    }
    value += z * s;
    if (slope == nullptr) continue;
    slope[i] = s;
    slope[i + 1] = z;
  }
  return value;
}

Eigen::Vector3d pair_curvature(PairRelaxation relaxation, double z, double s, double epsilon) {
  if (relaxation != PairRelaxation::fischer_burmeister) return {0, 1, 0};
  const double square = z * z + s * s + 2 * epsilon, cube = square * std::sqrt(square);
  return {(z * z - square) / cube, z * s / cube, (s * s - square) / cube};
}

}  // namespace conddp
