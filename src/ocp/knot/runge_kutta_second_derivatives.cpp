#include "ocp/knot/runge_kutta_second_derivatives.hpp"

#include <algorithm>

#include "ocp/knot/gauss_newton.hpp"

namespace conddp {
namespace {

constexpr int kBlock = StateManifold::kBlockSize;

/// Seeds θ with a unit derivative along coordinate d of every curved segment with more than d
/// coordinates.
void move_along(const StateManifold& manifold, const AlignedVector<Lane>& theta, int d,
                AlignedVector<Dual<Lane>>& out) {
  for (std::size_t i = 0; i < theta.size(); ++i) out[i] = Dual<Lane>(theta[i], Lane(0.0));
  for (const auto& segment : manifold.curved())
    if (d < segment.n) out[segment.dx + d].d = Lane(1.0);
}

/// Seeds θ along two coordinates: j in the inner and k in the outer derivative.
void move_along(const StateManifold& manifold, const AlignedVector<Lane>& theta, int j, int k,
                AlignedVector<Dual<Dual<Lane>>>& out) {
  for (std::size_t i = 0; i < theta.size(); ++i)
    out[i] = {{theta[i], Lane(0.0)}, {Lane(0.0), Lane(0.0)}};
  for (const auto& segment : manifold.curved()) {
    if (j >= segment.n) continue;
    out[segment.dx + j].v.d = Lane(1.0);
    out[segment.dx + k].d.v = Lane(1.0);
  }
}

}  // namespace

RungeKuttaSecondDerivatives::RungeKuttaSecondDerivatives(const System& system,
                                                         const RungeKuttaRule& rule,
                                                         SecondDerivatives& of_system)
    : system_(system),
      rule_(rule),
      of_system_(of_system),
      n_(system.ndx()),
      nz_(system.ndx() + system.nu()),
      top_(system.ndx() - system.rows()),
      weights_(rule.stages, AlignedVector<Lane>(system.ndx())),
      slope_(n_),
      turned_(n_),
      pulled_(n_),
      row_(nz_),
      no_forces_(of_system.forces(), Lane(0.0)),
      x_(system.nx()),
      moved_(system.nx()),
      u_(system.nu()),
      step_(n_, D(0.0)),
      displacement_(n_),
      twice_(n_),
      of_stage_(nz_ * nz_),
      along_(nz_ * nz_),
      half_(nz_ * nz_) {
  const std::size_t segments = system.manifold().curved().size();
  wrt_x_.resize(kBlock * segments);
  wrt_dx_.resize(kBlock * segments);
  inverse_.resize(kBlock * segments);
  turns_.resize(segments);
  curved_.reserve(nz_);
}

void RungeKuttaSecondDerivatives::add_later_stages(const Step& step, const Lane* costates,
                                                   Lane* weights, Lane* hessian) {
  const auto& stages = step.work.stages;
  for (auto& weight : weights_) std::fill(weight.begin(), weight.end(), Lane(0.0));
  std::fill(slope_.begin(), slope_.end(), Lane(0.0));
  add_displacement(stages.back(), costates, hessian);
  distribute(rule_.b, rule_.stages, step.dt);
  for (int i = rule_.stages - 1; i > 0; --i) {
    const Stage& stage = stages[i];
    system_.differentiate(stage.x.data(), step.u, step.data);
    std::fill(slope_.begin(), slope_.end(), Lane(0.0));
    turn_back(stage, weights_[i].data(), step.data, hessian);
    add_system(step, stage, hessian);
    pull_through_system(step.data);
    add_displacement(stage, pulled_.data(), hessian);
    distribute(rule_.a[i], i, step.dt);
  }
  std::copy_n(weights_[0].begin() + top_, system_.rows(), weights);
}

/// Adds the slope, times dt and the coefficients in `row`, to the weights of the stages' k.
void RungeKuttaSecondDerivatives::distribute(const double* row, int count, const Lane& dt) {
  for (int j = 0; j < count; ++j) {
    if (row[j] == 0) continue;
    const Lane factor = dt * Lane(row[j]);
    for (int i = 0; i < n_; ++i) weights_[j][i] += factor * slope_[i];
  }
}

/// Adds the weighted second derivative of x ⊕ θ for constant velocities of x and θ, and its slope
/// with respect to θ.
void RungeKuttaSecondDerivatives::add_displacement(const Stage& stage, const Lane* pull,
                                                   Lane* hessian) {
  const StateManifold& manifold = system_.manifold();
  for (const auto& segment : manifold.segments())
    if (segment.part == StateManifold::Part::flat)
      for (int i = segment.dx; i < segment.dx + segment.n; ++i) slope_[i] += pull[i];
  if (manifold.curved().empty()) return;
  for (int d = 0; d < 6; ++d) {
    move_along(manifold, stage.theta, d, displacement_);
    manifold.integrate_jacobians(displacement_.data(), wrt_x_.data(), wrt_dx_.data());
    int offset = 0;
    for (const Segment& segment : manifold.curved()) {
      if (d < segment.n) bend_displacement(stage, segment, offset, d, pull, hessian);
      offset += kBlock;
    }
  }
}

/// Adds the terms along coordinate d of θ.
void RungeKuttaSecondDerivatives::bend_displacement(const Stage& stage, const Segment& segment,
                                                    int offset, int d, const Lane* pull,
                                                    Lane* hessian) {
  const D *by_x = &wrt_x_[offset], *by_theta = &wrt_dx_[offset];
  std::fill(row_.begin(), row_.end(), Lane(0.0));
  for (int i = 0; i < segment.n; ++i) {
    Lane of_x(0.0), of_theta(0.0);
    for (int k = 0; k < segment.n; ++k) {
      of_x += by_x[k * segment.n + i].d * pull[segment.dx + k];
      of_theta += by_theta[k * segment.n + i].d * pull[segment.dx + k];
    }
    row_[segment.dx + i] += of_x;
    for (int c = 0; c < nz_; ++c) row_[c] += of_theta * stage.Theta[c * n_ + segment.dx + i];
  }
  for (int k = 0; k < segment.n; ++k)
    slope_[segment.dx + d] += by_theta[k * segment.n + d].v * pull[segment.dx + k];
  add_outer(stage, segment.dx + d, hessian);
}

/// Adds (a row of ∂θ/∂z)ᵀ row_.
void RungeKuttaSecondDerivatives::add_outer(const Stage& stage, int row, Lane* hessian) const {
  for (int c = 0; c < nz_; ++c)
    for (int r = 0; r < nz_; ++r) hessian[c * nz_ + r] += stage.Theta[r * n_ + row] * row_[c];
}

/// Converts the weights of k = G ẋ into those of the rate; adds the second derivatives of G and its
/// slope with respect to θ.
void RungeKuttaSecondDerivatives::turn_back(const Stage& stage, const Lane* weight,
                                            const SystemData<Lane>& data, Lane* hessian) {
  std::copy_n(weight, n_, turned_.begin());
  const StateManifold& manifold = system_.manifold();
  if (manifold.curved().empty()) return;
  differentiate_turns(stage, weight);
  for (std::size_t s = 0; s < turns_.size(); ++s) {
    const Segment& segment = manifold.curved()[s];
    const Dual<D>* inverse = &inverse_[s * kBlock];
    for (int c = 0; c < segment.n; ++c) {
      Lane sum(0.0);
      for (int r = 0; r < segment.n; ++r)
        sum += inverse[r * segment.n + c].v.v * weight[segment.dx + r];
      turned_[segment.dx + c] = sum;
    }
    add_turn(stage, segment, turns_[s], data, hessian);
  }
}

void RungeKuttaSecondDerivatives::differentiate_turns(const Stage& stage, const Lane* weight) {
  const StateManifold& manifold = system_.manifold();
  for (int j = 0; j < 6; ++j)
    for (int k = 0; k <= j; ++k) {
      move_along(manifold, stage.theta, j, k, twice_);
      manifold.inverse_right_jacobian(twice_.data(), inverse_.data());
      for (std::size_t s = 0; s < turns_.size(); ++s) {
        const Segment& segment = manifold.curved()[s];
        if (j < segment.n)
          differentiate_turn(stage, segment, &inverse_[s * kBlock], weight, j, k, turns_[s]);
      }
    }
}

void RungeKuttaSecondDerivatives::differentiate_turn(const Stage& stage, const Segment& segment,
                                                     const Dual<D>* inverse, const Lane* weight,
                                                     int j, int k, Turn& turn) {
  Lane curvature(0.0);
  for (int c = 0; c < segment.n; ++c) {
    Lane first(0.0), second(0.0);
    for (int r = 0; r < segment.n; ++r) {
      const Dual<D>& entry = inverse[r * segment.n + c];
      first += entry.v.d * weight[segment.dx + r];
      second += entry.d.d * weight[segment.dx + r];
    }
    turn.slope[j][c] = first;
    curvature += second * stage.rate[segment.dx + c];
  }
  turn.curvature[j][k] = turn.curvature[k][j] = curvature;
}

void RungeKuttaSecondDerivatives::add_turn(const Stage& stage, const Segment& segment,
                                           const Turn& turn, const SystemData<Lane>& data,
                                           Lane* hessian) {
  for (int j = 0; j < segment.n; ++j) {
    std::fill(row_.begin(), row_.end(), Lane(0.0));
    for (int i = 0; i < segment.n; ++i) {
      slope_[segment.dx + j] += turn.slope[j][i] * stage.rate[segment.dx + i];
      for (int c = 0; c < nz_; ++c)
        row_[c] += Lane(2.0) * turn.slope[j][i] * rate_slope(stage, data, segment.dx + i, c) +
                   turn.curvature[j][i] * stage.Theta[c * n_ + segment.dx + i];
    }
    add_outer(stage, segment.dx + j, hessian);
  }
}

/// Entry of the derivative of a stage's rate with respect to z.
Lane RungeKuttaSecondDerivatives::rate_slope(const Stage& stage, const SystemData<Lane>& data,
                                             int row, int column) const {
  const Lane* x = &stage.X[column * n_];
  if (row < top_) return x[top_ + row];
  const int rows = system_.rows(), i = row - top_;
  Lane sum = column < n_ ? Lane(0.0) : data.fu[(column - n_) * rows + i];
  for (int k = 0; k < n_; ++k) sum += data.fx[k * rows + i] * x[k];
  return sum;
}

/// Adds (∂(x_i, u)/∂z)ᵀ H ∂(x_i, u)/∂z, where H is the Hessian of the weighted system output at the
/// stage.
void RungeKuttaSecondDerivatives::add_system(const Step& step, const Stage& stage, Lane* hessian) {
  differentiate_system(step, stage);
  find_curved_columns();
  add_system_along(stage, hessian);
}

void RungeKuttaSecondDerivatives::differentiate_system(const Step& step, const Stage& stage) {
  for (std::size_t i = 0; i < x_.size(); ++i) x_[i] = D(stage.x[i], Lane(0.0));
  for (std::size_t i = 0; i < u_.size(); ++i) u_[i] = D(step.u[i], Lane(0.0));
  std::fill(of_stage_.begin(), of_stage_.end(), Lane(0.0));
  of_system_.start(x_.data(), u_.data());
  of_system_.weigh(turned_.data() + top_, no_forces_.data());
  if (!of_system_.at_once()) {
    for (int d = 0; d < n_; ++d) {
      step_[d].d = Lane(1.0);
      system_.manifold().integrate(x_.data(), step_.data(), moved_.data());
      step_[d].d = Lane(0.0);
      of_system_.move(moved_.data(), d, of_stage_.data());
    }
  }
  of_system_.finish(of_stage_.data());
  for (int c = 0; c < nz_; ++c)
    for (int r = 0; r < c; ++r) {
      Lane &a = of_stage_[c * nz_ + r], &b = of_stage_[r * nz_ + c];
      a = b = 0.5 * (a + b);
    }
}

void RungeKuttaSecondDerivatives::find_curved_columns() {
  curved_.clear();
  for (int c = 0; c < nz_; ++c)
    if (!all_zero(&of_stage_[c * nz_], nz_)) curved_.push_back(c);
}

void RungeKuttaSecondDerivatives::add_system_along(const Stage& stage, Lane* hessian) {
  const int rows = static_cast<int>(curved_.size());
  for (int c = 0; c < nz_; ++c) {
    Lane* along = &along_[c * rows];
    for (int a = 0; a < rows; ++a)
      along[a] = curved_[a] < n_ ? stage.X[c * n_ + curved_[a]] : Lane(curved_[a] == c ? 1.0 : 0.0);
    for (int a = 0; a < rows; ++a) {
      Lane sum(0.0);
      for (int b = 0; b < rows; ++b) sum += of_stage_[curved_[a] * nz_ + curved_[b]] * along[b];
      half_[c * rows + a] = sum;
    }
  }
  for (int c = 0; c < nz_; ++c)
    for (int r = 0; r <= c; ++r) {
      Lane sum(0.0);
      for (int a = 0; a < rows; ++a) sum += along_[r * rows + a] * half_[c * rows + a];
      hessian[c * nz_ + r] += sum;
      if (r < c) hessian[r * nz_ + c] += sum;
    }
}

/// Converts the weights of a stage's rate into those of its state.
void RungeKuttaSecondDerivatives::pull_through_system(const SystemData<Lane>& data) {
  const int rows = system_.rows();
  const Lane* weight = turned_.data() + top_;
  for (int c = 0; c < n_; ++c) {
    Lane sum = top_ > 0 && c >= top_ ? turned_[c - top_] : Lane(0.0);
    for (int i = 0; i < rows; ++i) sum += data.fx[c * rows + i] * weight[i];
    pulled_[c] = sum;
  }
}

}  // namespace conddp
