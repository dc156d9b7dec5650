#include "nlp/pair_relaxation.hpp"

#include <cmath>

namespace conddp {

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
