#pragma once

#include "spatial/vector3.hpp"

namespace conddp {

/// x → A x + p.
struct Affine {
  Matrix3<double> A = Matrix3<double>::identity();
  Vector3<double> p = Vector3<double>::zero();

  Vector3<double> operator*(const Vector3<double>& x) const { return A * x + p; }
  Affine operator*(const Affine& inner) const { return {A * inner.A, A * inner.p + p}; }
};

}  // namespace conddp
