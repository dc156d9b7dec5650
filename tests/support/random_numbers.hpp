#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "spatial/se3.hpp"

namespace conddp {

/// Random numbers that are identical with every standard library.
class RandomNumbers {
 public:
  explicit RandomNumbers(std::uint64_t seed) : engine_(seed) {}

  double uniform(double lower, double upper) {
    return lower + (upper - lower) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  /// 0 .. n − 1.
  int index(int n) { return static_cast<int>(uniform(0, n)); }
  bool chance(double probability) { return uniform(0, 1) < probability; }
  /// n numbers in ±size.
  std::vector<double> numbers(int n, double size) {
    std::vector<double> a(static_cast<std::size_t>(n));
    for (double& value : a) value = uniform(-size, size);
    return a;
  }
  /// Three coordinates in ±size.
  Vector3<double> vector(double size) {
    const double x = uniform(-size, size), y = uniform(-size, size);
    return {x, y, uniform(-size, size)};
  }
  /// Uniform over all rotations.
  Quaternion<double> rotation() {
    for (;;) {
      const Vector3<double> v = vector(1);
      const double w = uniform(-1, 1);
      const double n = std::sqrt(squared_norm(v) + w * w);
      if (n > 0.1 && n < 1) return {v.x / n, v.y / n, v.z / n, w / n};
    }
  }
  SE3<double> placement(double size) {
    const Matrix3<double> r = rotation_matrix(rotation());
    return {r, vector(size)};
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace conddp
