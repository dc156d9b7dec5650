#pragma once

#include <string>
#include <vector>

#include "spatial/se3.hpp"

namespace conddp {

/// The space of states: a product of flat parts, rotations and rigid placements. Rotations are unit
/// quaternions x y z w with tangents in the body frame. Placements are (position, quaternion) with
/// tangents (linear, angular) in the body frame. A state has nx numbers, a tangent vector ndx.
///
/// ⊕ moves a state by a tangent vector at it; ⊖ is its inverse, x₁ ⊖ x₀ = log(x₀⁻¹ x₁). Methods are
/// defined for double, Lane, and dual numbers over them.
class StateManifold {
 public:
  enum class Part { flat, so3, se3 };
  struct Segment {
    Part part;
    int x;   ///< first index in the state
    int dx;  ///< first index in tangent vectors
    int n;   ///< dimension of the tangent space
  };
  /// The non-identity 6x6 or 3x3 diagonal blocks of a Jacobian, one per curved segment in order,
  /// each n x n by rows in a slot of 36.
  static constexpr int kBlockSize = 36;

  StateManifold() = default;
  /// n flat coordinates.
  static StateManifold flat(int n);
  void append(Part part, int flat_size = 0);
  /// Appends all parts of another manifold.
  void append(const StateManifold& other);

  int nx() const { return nx_; }
  int ndx() const { return ndx_; }
  const std::vector<Segment>& segments() const { return segments_; }
  const std::vector<Segment>& curved() const { return curved_; }

  /// out = x ⊕ dx; out may be x.
  template <class S>
  void integrate(const S* x, const S* dx, S* out) const;
  /// dx = x1 ⊖ x0.
  template <class S>
  void difference(const S* x0, const S* x1, S* dx) const;
  /// Derivatives of x ⊕ dx, tangent to tangent, as blocks: with respect to x (Ad exp(dx))⁻¹, with
  /// respect to dx the right Jacobian of exp. Identity on flat parts.
  template <class S>
  void integrate_jacobians(const S* dx, S* wrt_x, S* wrt_dx) const;
  /// Inverse of the right Jacobian of exp at dx: the derivative of dx = x1 ⊖ x0 with respect to x1.
  /// Its value at −dx is minus the derivative with respect to x0.
  template <class S>
  void inverse_right_jacobian(const S* dx, S* blocks) const;

  /// Scales quaternions to unit length. Returns false if the length of one differs from 1 by more
  /// than 1e-3.
  bool normalize(double* x) const;
  /// The state with all numbers zero and unit quaternions.
  std::vector<double> neutral() const;

 private:
  void append_flat(int n);
  void append_curved(Part part, int n);

  std::vector<Segment> segments_;
  std::vector<Segment> curved_;
  int nx_ = 0;
  int ndx_ = 0;
};

}  // namespace conddp
