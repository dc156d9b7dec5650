#include "ocp/knot/collocation_residual.hpp"

#include <algorithm>

#include "ocp/knot/gauss_newton.hpp"

namespace conddp {
namespace {

class CollocationResidual : public ResidualBase<CollocationResidual> {
 public:
  CollocationResidual(std::shared_ptr<const CollocationSystem> system, int ndx,
                      const std::optional<FreeDuration>& duration, bool linear)
      : ResidualBase(structure(*system, ndx, duration, linear), 1, true),
        system_(std::move(system)),
        duration_(duration) {}

  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    auto& later = later_of(in);
    const S h = step(in);
    const int n = system_->rows();
    for (int i = 1; i <= system_->later_stages(); ++i, r += n) {
      system_->stage(i, in.x, own(in), h, in.system, later.x.data());
      system_->inside()->evaluate(later.x.data(), controls(i, in, later), *later.inside);
      write_values(i, in, h, *later.inside, r);
    }
  }

  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    auto& later = later_of(in);
    const S h = step(in);
    const int n = system_->rows(), ndx = system_->ndx();
    for (int i = 1; i <= system_->later_stages(); ++i, r += n) {
      system_->stage(i, in.x, own(in), h, in.system, later.x.data());
      system_->differentiate_stage(i, in.x, own(in), h, in.system, duration_.has_value(),
                                   later.X.data());
      system_->inside()->differentiate(later.x.data(), controls(i, in, later), *later.inside);
      write_values(i, in, h, *later.inside, r);
      jacobian = differentiate_state(later, 0, ndx, h, jacobian);
      if (duration_) {
        S* column = jacobian;
        jacobian = differentiate_state(later, ndx + system_->nu(), 1, h, jacobian);
        const S share = in.parameters[0] * S(1 / duration_->written);
        for (int row = 0; row < n; ++row)
          column[row] = share * (column[row] + excess(i, in, *later.inside, row));
      }
      jacobian = differentiate_controls(i, in, h, jacobian);
    }
  }

 private:
  static std::vector<RowBlock> structure(const CollocationSystem& system, int ndx,
                                         const std::optional<FreeDuration>& duration, bool linear) {
    std::vector<int> columns = column_range(0, system.ndx());
    if (duration) columns.push_back(system.ndx() + duration->choice);
    if (linear)
      for (const int c : column_range(ndx - system.actuators(), system.actuators()))
        columns.push_back(c);
    for (const int c : column_range(ndx, system.nu())) columns.push_back(c);
    return std::vector<RowBlock>(system.later_stages(), {system.rows(), columns});
  }

  template <class S>
  static CollocationSystem::Later<S>& later_of(const ResidualInput<S>& in) {
    return static_cast<CollocationSystem::Later<S>&>(*in.system.later);
  }

  /// The knot's control vector, which contains the slopes.
  template <class S>
  static const S* own(const ResidualInput<S>& in) {
    return in.end != nullptr ? in.end : in.u;
  }
  /// Controls at a stage.
  template <class S>
  const S* controls(int stage, const ResidualInput<S>& in,
                    CollocationSystem::Later<S>& later) const {
    if (in.end == nullptr) return in.u;
    const S passed(system_->time(stage));
    for (int c = 0; c < system_->actuators(); ++c)
      later.u[c] = in.u[c] + passed * (in.end[c] - in.u[c]);
    return later.u.data();
  }

  /// Writes the columns of the controls at the beginning of the step, of those at its end if they
  /// differ, and of the slopes. Returns the end of the output.
  template <class S>
  S* differentiate_controls(int stage, const ResidualInput<S>& in, const S& h, S* out) const {
    const auto& later = later_of(in);
    const int n = system_->rows(), ndx = system_->ndx(), actuators = system_->actuators();
    const int count = actuators * n;
    const double passed = in.end != nullptr ? system_->time(stage) : 0;
    S* next = differentiate_state(later, ndx, actuators, h, out);
    for (int c = 0; c < count; ++c) out[c] -= S(1 - passed) * h * later.inside->fu[c];
    if (in.end != nullptr)
      for (int c = 0; c < count; ++c) *next++ = S(-passed) * h * later.inside->fu[c];
    S* own_slopes = next + (system_->slopes(stage) - actuators) * n;
    next = differentiate_state(later, ndx + actuators, system_->nu() - actuators, h, next);
    for (int row = 0; row < n; ++row) own_slopes[row * n + row] += h;
    return next;
  }

  template <class S>
  S step(const ResidualInput<S>& in) const {
    if (!duration_) return in.parameters[0];
    return in.parameters[0] * in.x[system_->nx() + duration_->choice] * S(1 / duration_->written);
  }

  /// k_i − f(x_i, u).
  template <class S>
  S excess(int stage, const ResidualInput<S>& in, const SystemData<S>& there, int row) const {
    return own(in)[system_->slopes(stage) + row] - there.f[row];
  }
  template <class S>
  void write_values(int stage, const ResidualInput<S>& in, const S& h, const SystemData<S>& there,
                    S* r) const {
    for (int row = 0; row < system_->rows(); ++row) r[row] = h * excess(stage, in, there, row);
  }

  /// Writes −h ∂f/∂x_i ∂x_i/∂c for `count` columns c of the stage's derivative, from `first` on.
  /// Returns the end of the output.
  template <class S>
  S* differentiate_state(const CollocationSystem::Later<S>& later, int first, int count, const S& h,
                         S* out) const {
    const int n = system_->rows(), ndx = system_->ndx();
    for (int c = first; c < first + count; ++c, out += n) {
      std::fill_n(out, n, S(0.0));
      for (int k = 0; k < ndx; ++k) {
        const S moved = later.X[c * ndx + k];
        if (all_zero(&moved, 1)) continue;  // a slope moves only its own coordinate
        for (int row = 0; row < n; ++row) out[row] -= later.inside->fx[k * n + row] * moved;
      }
      for (int row = 0; row < n; ++row) out[row] *= h;
    }
    return out;
  }

  std::shared_ptr<const CollocationSystem> system_;
  std::optional<FreeDuration> duration_;
};

}  // namespace

std::shared_ptr<const Residual> collocation_residual(
    std::shared_ptr<const CollocationSystem> system, int ndx,
    const std::optional<FreeDuration>& duration, bool linear) {
  return std::make_shared<CollocationResidual>(std::move(system), ndx, duration, linear);
}

}  // namespace conddp
