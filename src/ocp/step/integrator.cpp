#include "ocp/step/integrator.hpp"

#include <algorithm>
#include <numeric>

namespace conddp {

namespace {

constexpr int kBlock = StateManifold::kBlockSize;

/// Applies the diagonal blocks of curved segments to a column of ndx entries, in place.
template <class S>
void apply_blocks(const StateManifold& manifold, const S* blocks, S* column) {
  S old[6];
  for (const auto& segment : manifold.curved()) {
    S* c = column + segment.dx;
    for (int i = 0; i < segment.n; ++i) old[i] = c[i];
    for (int i = 0; i < segment.n; ++i) {
      S sum = blocks[i * segment.n] * old[0];
      for (int j = 1; j < segment.n; ++j) sum += blocks[i * segment.n + j] * old[j];
      c[i] = sum;
    }
    blocks += kBlock;
  }
}

/// Tangent velocity at a state from the system's answer there.
template <class S>
void state_rate(const System& system, const S* x, const SystemData<S>& data, S* rate) {
  if (system.kind() == SystemKind::second_order) {
    const int nv = system.nv();
    for (int i = 0; i < nv; ++i) {
      rate[i] = x[system.nq() + i];
      rate[nv + i] = data.f[i];
    }
  } else {
    std::copy(data.f.begin(), data.f.end(), rate);
  }
}

/// R = ∂rate/∂z given X = ∂x/∂z, of which a column by dt may follow. `passed`: how much of the step
/// has passed, the share that the controls at its end have where they are linear.
template <class S>
void state_rate_derivative(const System& system, const SystemData<S>& data, double passed,
                           const IntegratorWorkspace<S>& work, const AlignedVector<S>& X,
                           AlignedVector<S>& R) {
  const int n = system.ndx(), nu = system.nu(), rows = system.rows(), top = n - rows;
  const bool linear = work.variables > n + nu;
  for (int c = 0; c < work.columns; ++c) {
    const S* xc = &X[c * n];
    S* r = &R[c * n];
    for (int i = 0; i < top; ++i) r[i] = xc[top + i];
    if (c < n || c >= work.variables) {
      std::fill_n(r + top, rows, S(0.0));
    } else {
      const bool of_end = c >= n + nu;
      std::copy_n(&data.fu[(c - n - (of_end ? nu : 0)) * rows], rows, r + top);
      if (linear)
        for (int i = 0; i < rows; ++i) r[top + i] *= S(of_end ? passed : 1 - passed);
    }
    for (int k = 0; k < n; ++k)
      for (int i = 0; i < rows; ++i) r[top + i] += data.fx[k * rows + i] * xc[k];
  }
}

/// out += factor · in.
template <class S>
void add_scaled(const S& factor, const AlignedVector<S>& in, AlignedVector<S>& out) {
  for (std::size_t i = 0; i < in.size(); ++i) out[i] += factor * in[i];
}

/// Displacement (and its derivative) at which stage i, or the end of the step, stands.
template <class S>
void accumulate(const double* row, int count, const S& dt, bool derivatives,
                IntegratorWorkspace<S>& work, AlignedVector<S>& theta, AlignedVector<S>& Theta) {
  std::fill(theta.begin(), theta.end(), S(0.0));
  if (derivatives) std::fill(Theta.begin(), Theta.end(), S(0.0));
  for (int j = 0; j < count; ++j) {
    if (row[j] == 0) continue;
    const S factor = dt * S(row[j]);
    add_scaled(factor, work.stages[j].k, theta);
    if (!derivatives) continue;
    add_scaled(factor, work.stages[j].K, Theta);
    if (work.columns == work.variables) continue;
    S* by_step = &Theta[work.variables * theta.size()];
    for (std::size_t i = 0; i < theta.size(); ++i) by_step[i] += S(row[j]) * work.stages[j].k[i];
  }
}

/// X = ∂(x ⊕ θ)/∂z for a displacement with derivative Theta.
template <class S>
void displaced_state_derivative(const StateManifold& manifold, int columns,
                                const AlignedVector<S>& theta, const AlignedVector<S>& Theta,
                                IntegratorWorkspace<S>& work, S* X) {
  const int n = manifold.ndx();
  manifold.integrate_jacobians(theta.data(), work.wrt_x.data(), work.wrt_dx.data());
  for (int c = 0; c < columns; ++c) {
    S* column = X + c * n;
    for (int i = 0; i < n; ++i) column[i] = Theta[c * n + i];
    apply_blocks(manifold, work.wrt_dx.data(), column);
    if (c < n) add_state_column(manifold, work.wrt_x.data(), c, column);
  }
}

/// θ as dual numbers that move along coordinate d of every curved segment that has so many.
template <class S>
void move_displacement(const StateManifold& manifold, const AlignedVector<S>& theta, int d,
                       AlignedVector<Dual<S>>& out) {
  for (std::size_t i = 0; i < theta.size(); ++i) out[i] = {theta[i], S(0.0)};
  for (const auto& segment : manifold.curved())
    if (d < segment.n) out[segment.dx + d].d = S(1.0);
}

/// K += what the inverse Jacobian of a segment changes along coordinate d, times the rate.
template <class S>
void add_inverse_change(const StateManifold::Segment& segment, const Dual<S>* inverse, int d,
                        int columns, int n, typename IntegratorWorkspace<S>::Stage& stage) {
  S change[6];
  for (int i = 0; i < segment.n; ++i) {
    change[i] = S(0.0);
    for (int j = 0; j < segment.n; ++j)
      change[i] += inverse[i * segment.n + j].d * stage.rate[segment.dx + j];
  }
  for (int c = 0; c < columns; ++c)
    for (int i = 0; i < segment.n; ++i)
      stage.K[c * n + segment.dx + i] += change[i] * stage.Theta[c * n + segment.dx + d];
}

/// K = ∂(Jr⁻¹(θ) rate)/∂z, where K holds ∂rate/∂z at first.
template <class S>
void pull_back_derivative(const StateManifold& manifold, int columns,
                          typename IntegratorWorkspace<S>::Stage& stage,
                          IntegratorWorkspace<S>& work) {
  const int n = manifold.ndx();
  for (int c = 0; c < columns; ++c) apply_blocks(manifold, work.inverse.data(), &stage.K[c * n]);
  // The inverse Jacobian moves with θ: one dual direction for all curved segments at once.
  for (int d = 0; d < 6; ++d) {
    move_displacement(manifold, stage.theta, d, work.dual_theta);
    manifold.inverse_right_jacobian(work.dual_theta.data(), work.dual_inverse.data());
    const Dual<S>* block = work.dual_inverse.data();
    for (const auto& segment : manifold.curved()) {
      if (d < segment.n) add_inverse_change<S>(segment, block, d, columns, n, stage);
      block += kBlock;
    }
  }
}

template <class S>
void evaluate_system(const System& system, const S* x, const S* u, bool derivatives,
                     SystemData<S>& data) {
  if (derivatives)
    system.differentiate(x, u, data);
  else
    system.evaluate(x, u, data);
}

/// The controls of a step that stands at (x, u): constant, or linear where `end` is not null.
template <class S>
struct StepControls {
  const S *u, *end;

  /// When `passed` of the step has passed, in `at` where they are linear.
  const S* when(double passed, int nu, AlignedVector<S>& at) const {
    if (end == nullptr) return u;
    for (int i = 0; i < nu; ++i) at[i] = u[i] + S(passed) * (end[i] - u[i]);
    return at.data();
  }
};

/// Stage s, whose displacement is known and which stands where `passed` of the step has passed.
/// `data` has the system at the first one.
template <class S>
void run_stage(const System& system, int s, double passed, const StepControls<S>& controls,
               const S* x, bool derivatives, SystemData<S>& data, IntegratorWorkspace<S>& work,
               StageVisitor<S>* visitor) {
  const StateManifold& manifold = system.manifold();
  auto& stage = work.stages[s];
  const bool displaced = s > 0, turned = displaced && !manifold.curved().empty();
  manifold.integrate(x, stage.theta.data(), stage.x.data());
  const S* u = controls.when(passed, system.nu(), work.controls);
  if (displaced) evaluate_system(system, stage.x.data(), u, derivatives, data);
  state_rate(system, stage.x.data(), data, stage.rate.data());
  stage.k = stage.rate;
  if (turned) {
    manifold.inverse_right_jacobian(stage.theta.data(), work.inverse.data());
    apply_blocks(manifold, work.inverse.data(), stage.k.data());
  }
  if (derivatives) {
    displaced_state_derivative(manifold, work.columns, stage.theta, stage.Theta, work,
                               stage.X.data());
    state_rate_derivative(system, data, passed, work, stage.X, stage.K);
    if (turned) pull_back_derivative(manifold, work.columns, stage, work);
  }
  if (visitor) visitor->visit({s, passed, stage.x.data(), u, stage.X.data(), data});
}

template <class S>
void runge_kutta(const System& system, const RungeKuttaRule& rule, const S* x,
                 const StepControls<S>& controls, const S& dt, bool derivatives,
                 SystemData<S>& data, IntegratorWorkspace<S>& work, StageVisitor<S>* visitor) {
  const StateManifold& manifold = system.manifold();
  for (int s = 0; s < rule.stages; ++s) {
    auto& stage = work.stages[s];
    accumulate(rule.a[s], s, dt, derivatives, work, stage.theta, stage.Theta);
    const double passed = std::accumulate(rule.a[s], rule.a[s] + s, 0.0);
    run_stage(system, s, passed, controls, x, derivatives, data, work, visitor);
  }
  auto& last = work.stages.back();
  accumulate(rule.b, rule.stages, dt, derivatives, work, last.theta, last.Theta);
  manifold.integrate(x, last.theta.data(), work.next.data());
  if (derivatives)
    displaced_state_derivative(manifold, work.columns, last.theta, last.Theta, work, work.F.data());
}

/// v⁺ = v + dt a and q⁺ = q ⊕ dt v⁺.
template <class S>
void semi_implicit_euler(const System& system, const S* x, const S& dt, const SystemData<S>& data,
                         IntegratorWorkspace<S>& work) {
  const int nv = system.nv(), nq = system.nq();
  for (int i = 0; i < nv; ++i) {
    work.tangent[nv + i] = dt * data.f[i];
    work.tangent[i] = dt * (x[nq + i] + work.tangent[nv + i]);
  }
  system.manifold().integrate(x, work.tangent.data(), work.next.data());
}

template <class S>
void differentiate_semi_implicit(const System& system, const S& dt, const SystemData<S>& data,
                                 IntegratorWorkspace<S>& work) {
  const int n = system.ndx(), nv = system.nv(), nz = n + system.nu();
  for (int i = 0; i < nv * n; ++i) work.F[i] = dt * data.fx[i];
  for (int i = 0; i < nv; ++i) work.F[(nv + i) * nv + i] += S(1.0);
  for (int i = 0; i < nv * system.nu(); ++i) work.F[nv * n + i] = dt * data.fu[i];
  if (work.columns > nz) std::copy(data.f.begin(), data.f.end(), work.F.begin() + nv * nz);
  system.manifold().integrate_jacobians(work.tangent.data(), work.state_blocks.data(),
                                        work.step_blocks.data());
}

/// v⁺ is the system's, q⁺ = q.
template <class S>
void jump(const System& system, const S* x, const SystemData<S>& data,
          IntegratorWorkspace<S>& work) {
  std::copy(x, x + system.nq(), work.next.begin());
  std::copy(data.f.begin(), data.f.end(), work.next.begin() + system.nq());
}

/// The last stage of a rule that ends with the step.
template <class S>
void collocate(const System& system, const S* x, const S* w, const S& dt, bool derivatives,
               const SystemData<S>& data, IntegratorWorkspace<S>& work) {
  const auto& collocation = *system.as_collocation();
  const int last = collocation.later_stages();
  collocation.stage(last, x, w, dt, data, work.next.data());
  if (derivatives)
    collocation.differentiate_stage(last, x, w, dt, data, work.columns > system.ndx() + system.nu(),
                                    work.F.data());
}

}  // namespace

template <class S>
IntegratorWorkspace<S>::IntegratorWorkspace(const System& system, Integrator integrator,
                                            bool by_step, bool linear)
    : next(system.nx(), S(0.0)),
      variables(system.ndx() + system.nu()),
      tangent(system.ndx(), S(0.0)) {
  if (linear && info_of(integrator).kind == StepKind::runge_kutta) {
    variables += system.nu();
    controls.assign(system.nu(), S(0.0));
  }
  columns = variables + (by_step ? 1 : 0);
  if (integrator == Integrator::none) return;
  const int n = system.ndx();
  const std::size_t blocks = kBlock * system.manifold().curved().size();
  F.assign((is_structured(integrator) ? system.nv() : n) * columns, S(0.0));
  if (is_structured(integrator)) {
    state_blocks.assign(blocks, S(0.0));
    step_blocks.assign(blocks, S(0.0));
  }
  const IntegratorInfo& info = info_of(integrator);
  if (info.kind != StepKind::runge_kutta) return;
  wrt_x.assign(blocks, S(0.0));
  wrt_dx.assign(blocks, S(0.0));
  inverse.assign(blocks, S(0.0));
  dual_theta.assign(n, Dual<S>(0.0));
  dual_inverse.assign(blocks, Dual<S>(0.0));
  stages.resize(info.rule.stages + 1);
  for (Stage& stage : stages) {
    stage.theta.assign(n, S(0.0));
    stage.x.assign(system.nx(), S(0.0));
    stage.rate.assign(n, S(0.0));
    stage.k.assign(n, S(0.0));
    stage.Theta.assign(n * columns, S(0.0));
    stage.X.assign(n * columns, S(0.0));
    stage.K.assign(n * columns, S(0.0));
  }
}

template <class S>
void integrate(const System& system, Integrator integrator, const S* x, const S* u, const S& dt,
               SystemData<S>& data, IntegratorWorkspace<S>& work, const S* end,
               StageVisitor<S>* visitor) {
  switch (info_of(integrator).kind) {
    case StepKind::none:
      break;
    case StepKind::given:
      std::copy(data.f.begin(), data.f.end(), work.next.begin());
      break;
    case StepKind::impulse:
      jump(system, x, data, work);
      break;
    case StepKind::semi_implicit:
      semi_implicit_euler(system, x, dt, data, work);
      break;
    case StepKind::collocation:
      collocate(system, x, end ? end : u, dt, false, data, work);
      break;
    case StepKind::runge_kutta:
      runge_kutta(system, info_of(integrator).rule, x, {u, end}, dt, false, data, work, visitor);
      break;
  }
}

template <class S>
void integrate_derivatives(const System& system, Integrator integrator, const S* x, const S* u,
                           const S& dt, SystemData<S>& data, IntegratorWorkspace<S>& work,
                           const S* end, StageVisitor<S>* visitor) {
  const int n = system.ndx();
  switch (info_of(integrator).kind) {
    case StepKind::none:
      break;
    case StepKind::given:
      std::copy(data.f.begin(), data.f.end(), work.next.begin());
      std::copy(data.fx.begin(), data.fx.end(), work.F.begin());
      std::copy(data.fu.begin(), data.fu.end(), work.F.begin() + n * n);
      break;
    case StepKind::impulse:
      jump(system, x, data, work);
      std::copy(data.fx.begin(), data.fx.end(), work.F.begin());
      system.manifold().integrate_jacobians(work.tangent.data(), work.state_blocks.data(),
                                            work.step_blocks.data());
      break;
    case StepKind::semi_implicit:
      semi_implicit_euler(system, x, dt, data, work);
      differentiate_semi_implicit(system, dt, data, work);
      break;
    case StepKind::collocation:
      collocate(system, x, end ? end : u, dt, true, data, work);
      break;
    case StepKind::runge_kutta:
      runge_kutta(system, info_of(integrator).rule, x, {u, end}, dt, true, data, work, visitor);
      break;
  }
}

#define CONDDP_INSTANTIATE(S)                                                                      \
  template struct IntegratorWorkspace<S>;                                                          \
  template void integrate(const System&, Integrator, const S*, const S*, const S&, SystemData<S>&, \
                          IntegratorWorkspace<S>&, const S*, StageVisitor<S>*);                    \
  template void integrate_derivatives(const System&, Integrator, const S*, const S*, const S&,     \
                                      SystemData<S>&, IntegratorWorkspace<S>&, const S*,           \
                                      StageVisitor<S>*);
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
