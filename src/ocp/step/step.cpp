#include "ocp/step/step.hpp"

#include <algorithm>
#include <stdexcept>

namespace conddp {
namespace {

constexpr int kStays = -1;

void require(bool holds, const char* otherwise) {
  if (!holds) throw std::invalid_argument(otherwise);
}

void check_integrator(const System& system, Integrator integrator) {
  require(system.kind() != SystemKind::discrete || system.manifold().curved().empty(),
          "a discrete system needs a flat state space");
  if (integrator == Integrator::none) return;
  require((system.kind() == SystemKind::discrete) == (integrator == Integrator::discrete),
          "a discrete system needs the discrete integrator, and only it");
  require(
      integrator != Integrator::semi_implicit_euler || system.kind() == SystemKind::second_order,
      "semi-implicit Euler needs a second-order system");
  require((system.kind() == SystemKind::impulse) == (integrator == Integrator::impulse),
          "an impulse needs the integrator of impulses, and only it");
  const auto* collocation = system.as_collocation();
  require(info_of(integrator).collocation ==
              (collocation ? std::optional(collocation->rule()) : std::nullopt),
          "a collocation system needs the integrator of its rule, and only it");
}

void check_linear_controls(Integrator integrator) {
  require(integrator == Integrator::none || follows_controls(integrator),
          "linear controls need an integrator that sees how they change");
}

void check_time(Integrator integrator) {
  require(info_of(integrator).order > 0, "what knows no time step has no free duration");
}

/// From the step dt v⁺ to the tangent at q⁺, in the curved parts of a column.
template <class S>
void turn_steps(const StateManifold& manifold, const S* step, S* out) {
  for (const auto& segment : manifold.curved()) {
    const int m = segment.n;
    S turned[6];
    for (int i = 0; i < m; ++i) {
      turned[i] = S(0.0);
      for (int j = 0; j < m; ++j) turned[i] += step[i * m + j] * out[segment.dx + j];
    }
    for (int i = 0; i < m; ++i) out[segment.dx + i] = turned[i];
    step += StateManifold::kBlockSize;
  }
}

/// A column of F with all rows of the system's next state, from those that the integrator gives.
template <class S>
void fill_column(const StateManifold& manifold, const IntegratorWorkspace<S>& base, const S& dt,
                 int column, int base_rows, S* out) {
  const int top = manifold.ndx() - base_rows;
  for (int i = 0; i < base_rows; ++i) out[top + i] = base.F[column * base_rows + i];
  if (top == 0) return;
  for (int i = 0; i < top; ++i) out[i] = dt * out[top + i];
  turn_steps(manifold, base.step_blocks.data(), out);
  if (column < top) add_state_column(manifold, base.state_blocks.data(), column, out);
}

}  // namespace

Step::Step(std::shared_ptr<const System> system, Integrator integrator)
    : system_(std::move(system)), integrator_(integrator), manifold_(system_->manifold()) {
  check_integrator(*system_, integrator);
  index_columns();
}

void Step::append(int first_source, int count, int stride) {
  if (count == 0) return;
  require(integrals_.empty(), "rates of integrals refer to columns behind a complete tail");
  for (int i = 0; i < count; ++i) sources_.push_back(first_source + i * stride);
  manifold_.append(StateManifold::Part::flat, count);
  index_columns();
}

Step& Step::hold(int count) {
  append(kStays, count, 0);
  return *this;
}

Step& Step::remember_controls(int first, int count) {
  require(system_->kind() != SystemKind::impulse, "an impulse has no control to remember");
  require(first >= 0 && first + count <= system_->nu(), "a state takes controls that its knot has");
  append(first, count, 1);
  return *this;
}

Step& Step::make_controls_linear() {
  check_linear_controls(integrator_);
  const int at = tail();
  remember_controls(0, system_->actuators());
  linear_at_ = at;
  index_columns();
  return *this;
}

void Step::check_duration(const FreeDuration& duration) const {
  require(duration.choice >= 0 && duration.choice < tail() && !source(duration.choice),
          "a free duration needs its place among held numbers");
}

Step& Step::scale_time(const FreeDuration& duration) {
  check_duration(duration);
  check_time(integrator_);
  duration_ = duration;
  return *this;
}

int Step::integrate(std::string name, std::shared_ptr<const Residual> residual, int number) {
  check_fit("integral " + name, *residual, has_control(), nz());
  if (residual->size() != 1 || number < 0 || number >= tail() || source(number))
    throw std::invalid_argument("integral " + name + ": one row, for one of the held numbers");
  const IntegralTerm* last = integrals_.empty() ? nullptr : &integrals_.back();
  const int jacobian = last ? last->jacobian + last->residual->jacobian_size() : 0;
  const int parameters = parameter_count_;
  parameter_count_ += residual->parameter_count();
  integrals_.push_back({std::move(name), std::move(residual), parameters, number, jacobian});
  return parameters;
}

Step Step::alike(std::shared_ptr<const System> system, Integrator integrator) const {
  Step step(std::move(system), integrator);
  return has_linear_controls() ? step.make_controls_linear() : step;
}

Step Step::with(Integrator integrator) const {
  check_integrator(*system_, integrator);
  if (has_linear_controls()) check_linear_controls(integrator);
  if (duration_) check_time(integrator);
  Step step = *this;
  step.integrator_ = integrator;
  step.index_columns();
  return step;
}

Step Step::without_dynamics() const {
  Step step = *this;
  step.duration_.reset();
  step.integrals_.clear();
  step.parameter_count_ = 0;
  return step.with(Integrator::none);
}

/// The system's next state depends on its state and its controls. Linear controls have two columns
/// each: explicit rules know the one at the end, implicit rules know it through their slopes.
void Step::index_columns() {
  const int n = system_->ndx(), actuators = system_->actuators();
  const bool is_explicit = info_of(integrator_).kind == StepKind::runge_kutta;
  columns_.assign(nz(), -1);
  for (int c = 0; c < n; ++c) columns_[c] = c;
  for (int c = 0; c < nu(); ++c) columns_[ndx() + c] = n + c;
  if (!has_linear_controls()) return;
  for (int c = 0; c < actuators; ++c) columns_[n + linear_at_ + c] = n + c;
  for (int c = 0; c < nu(); ++c)
    if (is_explicit)
      columns_[ndx() + c] = n + system_->nu() + c;
    else if (c < actuators)
      columns_[ndx() + c] = -1;
}

std::vector<int> Step::held_columns() const {
  std::vector<int> columns;
  for (int i = 0; i < tail(); ++i)
    if (!source(i)) columns.push_back(system_->ndx() + i);
  return columns;
}

bool Step::is_linear() const {
  if (has_linear_controls()) return false;
  if (integrator_ == Integrator::none) return true;
  const StepKind kind = info_of(integrator_).kind;
  const bool is_rule = kind == StepKind::semi_implicit || kind == StepKind::runge_kutta;
  return is_rule && system_->is_linear() && !duration_ && integrals_.empty() &&
         (manifold_.curved().empty() || semi_implicit());
}

int Step::jacobian_rows() const {
  if (integrator_ == Integrator::none) return 0;
  return semi_implicit() ? system_->nv() : ndx();
}

template <class S>
void Step::stage_state(const StageView<S>& stage, const S* begin, S* x) const {
  const int own = system_->nx();
  std::copy_n(stage.x, own, x);
  std::copy(begin + own, begin + nx(), x + own);
  if (has_linear_controls()) std::copy_n(stage.u, system_->actuators(), x + own + linear_at_);
}

template <class S>
S Step::stage_derivative(const StageView<S>& stage, int row, int column, const S& dt,
                         const StepWorkspace<S>& work) const {
  const int n = system_->ndx();
  if (row < n) {
    if (duration_ && column == n + duration_->choice)
      return dt * S(1 / duration_->written) * stage.X[work.integrator.variables * n + row];
    return columns_[column] < 0 ? S(0.0) : stage.X[columns_[column] * n + row];
  }
  const int actuator = row - n - linear_at_;
  if (!has_linear_controls() || actuator < 0 || actuator >= system_->actuators())
    return S(row == column ? 1.0 : 0.0);
  if (column == row) return S(1 - stage.passed);
  return S(column == ndx() + actuator ? stage.passed : 0.0);
}

template <class S>
void Step::begin(const StepInput<S>& in, StepWorkspace<S>& work, bool derivatives) const {
  const S* u = first_control(in.x, in.u);
  if (derivatives)
    system_->differentiate(in.x, u, *work.system);
  else
    system_->evaluate(in.x, u, *work.system);
  for (std::size_t i = 0; i < integrals_.size(); ++i) {
    const IntegralTerm& term = integrals_[i];
    const ResidualInput<S> input{in.x, u, in.parameters + term.parameters, *work.system,
                                 last_control(in.u)};
    if (derivatives)
      term.residual->differentiate(input, &work.rates[i],
                                   work.rate_jacobians.data() + term.jacobian);
    else
      term.residual->evaluate(input, &work.rates[i]);
  }
}

template <class S>
void Step::take(const StepInput<S>& in, StepWorkspace<S>& work, bool derivatives,
                StageVisitor<S>* visitor) const {
  const S dt = time_step(in.dt, in.x);
  const auto step = derivatives ? integrate_derivatives<S> : conddp::integrate<S>;
  step(*system_, integrator_, in.x, first_control(in.x, in.u), dt, *work.system, work.integrator,
       last_control(in.u), visitor);
  if (!work.has_tail) return;
  const int own = system_->nx();
  std::copy_n(work.integrator.next.begin(), own, work.whole_next.begin());
  std::copy(in.x + own, in.x + nx(), work.whole_next.begin() + own);
  hand_on(in.u, work.whole_next.data());
  for (std::size_t i = 0; i < integrals_.size(); ++i)
    work.whole_next[own + integrals_[i].number] += dt * work.rates[i];
  if (!derivatives) return;
  fill_jacobian(dt, work);
  fill_integrals(dt, work);
  if (duration_) fill_duration(in, dt, work);
}

template <class S>
void Step::fill_jacobian(const S& dt, StepWorkspace<S>& work) const {
  const int n = system_->ndx(), rows = ndx();
  const int base_rows = is_structured(integrator_) ? system_->nv() : n;
  for (int c = 0; c < nz(); ++c) {
    if (columns_[c] < 0) continue;
    S* out = &work.whole_F[c * rows];
    fill_column(system_->manifold(), work.integrator, dt, columns_[c], base_rows, out);
    std::fill_n(out + n, tail(), S(0.0));
  }
  for (int i = 0; i < tail(); ++i) {
    const int column = sources_[i] < 0 ? n + i : rows + sources_[i];
    work.whole_F[column * rows + n + i] = S(1.0);
  }
}

/// Rows of integrals in F, which may depend on all of z.
template <class S>
void Step::fill_integrals(const S& dt, StepWorkspace<S>& work) const {
  const int rows = ndx();
  for (const IntegralTerm& term : integrals_) {
    const S* derivative = work.rate_jacobians.data() + term.jacobian;
    const int row = system_->ndx() + term.number;
    for (int column = 0; column < nz(); ++column)
      work.whole_F[column * rows + row] = S(column == row ? 1.0 : 0.0);
    for (const int column : term.residual->blocks().front().columns)
      work.whole_F[column * rows + row] += dt * *derivative++;
  }
}

/// Column of the free duration T: ∂x⁺/∂T from the integrator's ∂x⁺/∂dt.
template <class S>
void Step::fill_duration(const StepInput<S>& in, const S& dt, StepWorkspace<S>& work) const {
  const IntegratorWorkspace<S>& base = work.integrator;
  const int n = system_->ndx();
  const int base_rows = is_structured(integrator_) ? system_->nv() : n;
  const int top = n - base_rows;
  const S* by_step = &base.F[base.variables * base_rows];
  S* out = &work.whole_F[(n + duration_->choice) * ndx()];
  for (int i = 0; i < base_rows; ++i) out[top + i] = by_step[i];
  // q⁺ = q ⊕ dt v⁺
  for (int i = 0; i < top; ++i) out[i] = base.next[system_->nq() + i] + dt * by_step[i];
  if (top > 0) turn_steps(system_->manifold(), base.step_blocks.data(), out);
  const S share = in.dt * S(1 / duration_->written);
  for (int i = 0; i < n; ++i) out[i] *= share;
  for (std::size_t i = 0; i < integrals_.size(); ++i)
    out[n + integrals_[i].number] += share * work.rates[i];
}

template <class S>
StepWorkspace<S>::StepWorkspace(const Step& step)
    : has_tail(step.tail() > 0),
      system(step.system().create_data(S{})),
      integrator(step.system(), step.integrator(), step.duration().has_value(),
                 step.has_linear_controls()),
      rates(step.integrals().size(), S(0.0)) {
  if (has_tail) {
    whole_next.assign(step.nx(), S(0.0));
    whole_F.assign(step.jacobian_rows() * step.nz(), S(0.0));
  }
  int derivatives = 0;
  for (const IntegralTerm& term : step.integrals()) derivatives += term.residual->jacobian_size();
  rate_jacobians.assign(derivatives, S(0.0));
}

#define CONDDP_INSTANTIATE(S)                                                    \
  template struct StepWorkspace<S>;                                              \
  template void Step::stage_state(const StageView<S>&, const S*, S*) const;      \
  template S Step::stage_derivative(const StageView<S>&, int, int, const S&,     \
                                    const StepWorkspace<S>&) const;              \
  template void Step::begin(const StepInput<S>&, StepWorkspace<S>&, bool) const; \
  template void Step::take(const StepInput<S>&, StepWorkspace<S>&, bool, StageVisitor<S>*) const;
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
