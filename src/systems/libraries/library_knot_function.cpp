#include "systems/libraries/library_knot_function.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include <fmt/format.h>

#include "spatial/dual.hpp"

namespace conddp {
namespace {

constexpr const char* kMakeAll =
    "generate f, f.jacobian() and, if you like, hess_f as one file of C (docs/problem_file.md)";

/// Number and ratio of the difference steps that confirm a Jacobian; each step is shorter than the
/// preceding one.
constexpr int kSteps = 3;
constexpr double kShorter = 32;

/// Value of a scalar in one lane, without its derivative.
double value_in(double a, int) { return a; }
double value_in(const Lane& a, int lane) { return a[lane]; }
double value_in(const Dual<Lane>& a, int lane) { return a.v[lane]; }
void set_value(double& a, int, double value) { a = value; }
void set_value(Lane& a, int lane, double value) { a.set(lane, value); }
void set_value(Dual<Lane>& a, int lane, double value) { a.v.set(lane, value); }

template <class S>
constexpr int kLanes = std::is_same_v<S, double> ? 1 : kLaneWidth;
template <class S>
constexpr bool kIsDual = std::is_same_v<S, Dual<Lane>>;

/// Extracts one lane of z, and its direction for dual numbers.
template <class S>
void take_lane(const S* z, int lane, std::vector<double>& values, std::vector<double>& direction) {
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = value_in(z[i], lane);
  if constexpr (kIsDual<S>)
    for (std::size_t i = 0; i < values.size(); ++i) direction[i] = z[i].d[lane];
}

/// Writes the derivatives of dual numbers in one lane from a Jacobian. Columns with zero direction
/// contribute nothing, even if their derivatives are not finite.
void set_slopes(Dual<Lane>* f, int lane, int rows, const std::vector<double>& J,
                const std::vector<double>& direction) {
  for (int row = 0; row < rows; ++row) {
    double along = 0;
    for (std::size_t i = 0; i < direction.size(); ++i)
      if (direction[i] != 0) along += J[i * rows + row] * direction[i];
    f[row].d.set(lane, along);
  }
}

}  // namespace

struct LibraryKnotFunction::Workspace {
  explicit Workspace(const LibraryKnotFunction& function)
      : values(*function.values_, wanted_values(function)),
        jacobian(*function.jacobian_, wanted(function)),
        z(function.columns()),
        direction(function.columns()),
        moved(function.columns()),
        weights(function.rows()),
        f(function.rows()),
        beside(f.size()),
        ahead(f.size()),
        behind(f.size()),
        measured(function.rows() * kSteps),
        confirmed_at(function.columns(), std::numeric_limits<double>::quiet_NaN()),
        J(function.rows() * function.columns()),
        dJ(J.size()),
        other(J.size()),
        dJ_of_shorter_step(J.size()),
        settled(J.size()),
        confirmed(J.size()),
        H(function.columns() * function.columns()) {
    if (function.hessian_)
      hessian = std::make_unique<LibraryFunction::Workspace>(*function.hessian_, std::vector{0});
    set_parameters(function.values_binding_, function.parameters_, values);
    set_parameters(function.jacobian_binding_, function.parameters_, jacobian);
    if (hessian) set_parameters(function.hessian_binding_, function.parameters_, *hessian);
  }

  static std::vector<int> wanted_values(const LibraryKnotFunction& function) {
    std::vector<int> outputs = {0};
    for (const NominalOutput& nominal : function.nominal_outputs_)
      if (nominal.output != 0) outputs.push_back(nominal.output);
    return outputs;
  }
  static std::vector<int> wanted(const LibraryKnotFunction& function) {
    std::vector<int> outputs;
    for (const JacobianPart& part : function.jacobian_parts_) outputs.push_back(part.output);
    return outputs;
  }
  static void set_parameters(const Binding& binding, const std::vector<double>& parameters,
                             LibraryFunction::Workspace& out) {
    if (binding.p) std::copy(parameters.begin(), parameters.end(), out.input(*binding.p));
  }

  LibraryFunction::Workspace values, jacobian;
  std::unique_ptr<LibraryFunction::Workspace> hessian;
  std::vector<double> z, direction, moved, weights, f;
  std::vector<double> beside, ahead, behind;  ///< values, and secant slopes to both sides
  std::vector<MeasuredSlope> measured;        ///< of a column: by row, then by step
  std::vector<double> confirmed_at;           ///< point z of the confirmed Jacobian
  std::vector<double> J, dJ, other, dJ_of_shorter_step;
  std::vector<bool> settled;  ///< entries confirmed by a shorter step
  std::vector<double> confirmed, H;
};

void LibraryKnotFunction::WorkspaceDeleter::operator()(Workspace* workspace) const {
  delete workspace;
}

/// Checks that the library's functions match the file's description, and assembles them.
class LibraryKnotFunction::Maker {
 public:
  Maker(const std::shared_ptr<const SharedLibrary>& library, const std::string& name, Sizes sizes,
        const std::vector<double>& parameters, std::optional<Defect>& defect)
      : library_(library), name_(name), defect_(defect), made_(new LibraryKnotFunction) {
    made_->sizes_ = sizes;
    made_->parameters_ = parameters;
  }

  std::shared_ptr<const LibraryKnotFunction> make() {
    try {
      if (make_values() && make_jacobian() && make_hessian()) return std::move(made_);
    } catch (const LibraryError& error) {
      fail(Defect::Part::kFunction, error.what(), kMakeAll);
    }
    return nullptr;
  }

 private:
  using Port = LibraryFunction::Port;
  using Part = Defect::Part;

  bool fail(Part part, std::string message, std::string hint = {}) {
    defect_ = Defect{part, std::move(message), std::move(hint)};
    return false;
  }

  /// Binds an input of the given size if the function has it. An empty input counts as absent.
  bool bind(const LibraryFunction& function, const char* name, Part part, int size,
            std::optional<int>& input) {
    input = find_port(function.inputs(), name);
    if (!input) return true;
    const Port& port = function.inputs()[*input];
    if (port.rows * port.columns == 0) {
      input.reset();
      return true;
    }
    if (port.is_vector(size)) return true;
    return fail(part,
                fmt::format("the input '{}' of '{}' is {} x {} with {} numbers, and the file has "
                            "{}",
                            name, function.name(), port.rows, port.columns, port.stored(), size),
                "it has to be a vector with as many numbers as the file has, all of them stored");
  }

  bool bind_all(const LibraryFunction& function, Binding& binding) {
    const int parameters = static_cast<int>(made_->parameters_.size());
    return bind(function, "x", Part::kStates, made_->sizes_.states, binding.x) &&
           bind(function, "u", Part::kControls, made_->sizes_.controls, binding.u) &&
           bind(function, "p", Part::kParameters, parameters, binding.p) &&
           bind(function, "t", Part::kFunction, 1, binding.t);
  }

  bool check_names(const LibraryFunction& function, const std::vector<std::string>& also) {
    for (const Port& port : function.inputs()) {
      const bool known = port.name == "x" || port.name == "u" || port.name == "p" ||
                         port.name == "t" || std::ranges::find(also, port.name) != also.end();
      if (!known)
        return fail(Part::kFunction,
                    fmt::format("'{}' has an input '{}'", function.name(), port.name),
                    "its inputs are x (the state), u (the control), p (parameters) and t (the "
                    "time), each of them if it is needed");
    }
    return true;
  }

  std::unique_ptr<LibraryFunction> load(const std::string& name) {
    return std::make_unique<LibraryFunction>(library_, name);
  }

  bool make_values() {
    made_->values_ = load(name_);
    const LibraryFunction& f = *made_->values_;
    if (!check_names(f, {}) || !bind_all(f, made_->values_binding_)) return false;
    if (f.outputs().empty())
      return fail(Part::kFunction, fmt::format("'{}' has no output", name_), kMakeAll);
    const Port& output = f.outputs().front();
    if (output.rows * output.columns == 0 || std::min(output.rows, output.columns) != 1)
      return fail(Part::kFunction,
                  fmt::format("the output '{}' of '{}' is {} x {}, and has to be a vector",
                              output.name, name_, output.rows, output.columns));
    made_->rows_ = output.rows * output.columns;
    made_->reads_time_ = made_->values_binding_.t.has_value();
    made_->reads_control_ = made_->values_binding_.u.has_value();
    if (!made_->values_binding_.p && !made_->parameters_.empty())
      return fail(Part::kParameters, fmt::format("'{}' has no input 'p' for parameters", name_));
    return true;
  }

  bool make_jacobian() {
    made_->jacobian_ = load("jac_" + name_);
    const LibraryFunction& jacobian = *made_->jacobian_;
    const Sizes& sizes = made_->sizes_;
    const Binding& f = made_->values_binding_;
    if (!check_names(jacobian, names_of_nominal_outputs()) ||
        !bind_all(jacobian, made_->jacobian_binding_) || !bind_nominal_outputs())
      return false;
    made_->structure_.resize(made_->rows_);
    return add_part(f.x, "x", 0, sizes.states) &&
           add_part(f.u, "u", sizes.states, sizes.controls) &&
           add_part(f.t, "t", sizes.states + sizes.controls, 1);
  }

  std::vector<std::string> names_of_nominal_outputs() const {
    std::vector<std::string> names;
    for (const Port& output : made_->values_->outputs()) names.push_back("out_" + output.name);
    return names;
  }

  /// Binds the outputs of f that the Jacobian reads.
  bool bind_nominal_outputs() {
    const LibraryFunction& jacobian = *made_->jacobian_;
    const std::vector<Port>& outputs = made_->values_->outputs();
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      const auto input = find_port(jacobian.inputs(), "out_" + outputs[i].name);
      if (!input) continue;
      const Port& port = jacobian.inputs()[*input];
      if (port.stored() == 0) continue;
      if (port.row_of != outputs[i].row_of || port.column_of != outputs[i].column_of)
        return fail(Part::kFunction,
                    fmt::format("the input '{}' of '{}' stores other numbers than the output '{}' "
                                "of '{}'",
                                port.name, jacobian.name(), outputs[i].name, name_),
                    kMakeAll);
      made_->nominal_outputs_.push_back({*input, static_cast<int>(i)});
    }
    return true;
  }

  /// Adds the derivative with respect to one input, if f has that input.
  bool add_part(const std::optional<int>& input, const char* name, int first, int columns) {
    if (!input) return true;
    const LibraryFunction& jacobian = *made_->jacobian_;
    const std::string wanted =
        fmt::format("jac_{}_{}", made_->values_->outputs().front().name, name);
    const auto output = find_port(jacobian.outputs(), wanted);
    if (!output)
      return fail(Part::kFunction, fmt::format("'{}' has no output '{}'", jacobian.name(), wanted),
                  kMakeAll);
    const Port& port = jacobian.outputs()[*output];
    if (port.rows != made_->rows_ || port.columns != columns)
      return fail(Part::kFunction,
                  fmt::format("the output '{}' of '{}' is {} x {}, and has to be {} x {}", wanted,
                              jacobian.name(), port.rows, port.columns, made_->rows_, columns));
    made_->jacobian_parts_.push_back({*output, first});
    for (int i = 0; i < port.stored(); ++i)
      made_->structure_[port.row_of[i]].push_back(first + port.column_of[i]);
    return true;
  }

  bool make_hessian() {
    const std::string name = "hess_" + name_;
    if (library_->find(name.c_str()) == nullptr) return true;
    made_->hessian_ = load(name);
    const LibraryFunction& hessian = *made_->hessian_;
    if (!check_names(hessian, {"lam"}) || !bind_all(hessian, made_->hessian_binding_)) return false;
    const auto weights = find_port(hessian.inputs(), "lam");
    if (!weights || !hessian.inputs()[*weights].is_vector(made_->rows_))
      return fail(Part::kFunction,
                  fmt::format("'{}' has no input 'lam' of {} numbers, one for each row of '{}'",
                              name, made_->rows_, name_));
    made_->weights_input_ = *weights;
    const int n = made_->columns();
    if (hessian.outputs().empty() || hessian.outputs()[0].rows != n ||
        hessian.outputs()[0].columns != n)
      return fail(Part::kFunction,
                  fmt::format("the output of '{}' has to be {} x {}: the Hessian with respect to "
                              "(x, u{})",
                              name, n, n, made_->reads_time_ ? ", t" : ""));
    return true;
  }

  const std::shared_ptr<const SharedLibrary>& library_;
  const std::string& name_;
  std::optional<Defect>& defect_;
  std::shared_ptr<LibraryKnotFunction> made_;
};

std::shared_ptr<const LibraryKnotFunction> LibraryKnotFunction::make(
    const std::shared_ptr<const SharedLibrary>& library, const std::string& name, Sizes sizes,
    const std::vector<double>& parameters, std::optional<Defect>& defect) {
  return Maker(library, name, sizes, parameters, defect).make();
}

LibraryKnotFunction::~LibraryKnotFunction() = default;

std::vector<std::string> LibraryKnotFunction::failed_functions() const {
  std::vector<std::string> names;
  for (const LibraryFunction* function : {values_.get(), jacobian_.get(), hessian_.get()})
    if (function != nullptr && function->has_failed()) names.push_back(function->name());
  return names;
}

LibraryKnotFunction::OwnedWorkspace LibraryKnotFunction::create_workspace() const {
  return OwnedWorkspace(new Workspace(*this));
}

void LibraryKnotFunction::set_inputs(const Binding& binding, const double* z,
                                     LibraryFunction::Workspace& out) const {
  const double* u = z + sizes_.states;
  if (binding.x) std::copy_n(z, sizes_.states, out.input(*binding.x));
  if (binding.u) std::copy_n(u, sizes_.controls, out.input(*binding.u));
  if (binding.t && reads_time_) *out.input(*binding.t) = u[sizes_.controls];
}

void LibraryKnotFunction::values_at(const double* z, Workspace& workspace, double* f) const {
  set_inputs(values_binding_, z, workspace.values);
  const bool done = values_->run(workspace.values);
  std::fill_n(f, rows_, done ? 0.0 : std::numeric_limits<double>::quiet_NaN());
  if (!done) return;
  const LibraryFunction::Port& port = values_->outputs().front();
  const double* output = workspace.values.output(0);
  for (int i = 0; i < port.stored(); ++i) f[port.row_of[i] + port.column_of[i]] = output[i];
}

/// Returns false if the function fails.
bool LibraryKnotFunction::set_nominal_outputs(const double* z, Workspace& workspace) const {
  if (nominal_outputs_.empty()) return true;
  set_inputs(values_binding_, z, workspace.values);
  if (!values_->run(workspace.values)) return false;
  for (const auto& [input, output] : nominal_outputs_)
    std::copy_n(workspace.values.output(output), values_->outputs()[output].stored(),
                workspace.jacobian.input(input));
  return true;
}

void LibraryKnotFunction::jacobian_at(const double* z, Workspace& workspace, double* J) const {
  set_inputs(jacobian_binding_, z, workspace.jacobian);
  const bool done = set_nominal_outputs(z, workspace) && jacobian_->run(workspace.jacobian);
  std::fill_n(J, rows_ * columns(), done ? 0.0 : std::numeric_limits<double>::quiet_NaN());
  if (!done) return;
  for (const JacobianPart& part : jacobian_parts_) {
    const LibraryFunction::Port& port = jacobian_->outputs()[part.output];
    const double* output = workspace.jacobian.output(part.output);
    for (int i = 0; i < port.stored(); ++i)
      J[(part.first + port.column_of[i]) * rows_ + port.row_of[i]] = output[i];
  }
}

void LibraryKnotFunction::hessian_at(const double* z, const double* weights, Workspace& workspace,
                                     double* H) const {
  LibraryFunction::Workspace& own = *workspace.hessian;
  set_inputs(hessian_binding_, z, own);
  std::copy_n(weights, rows_, own.input(weights_input_));
  const bool done = hessian_->run(own);
  const int n = columns();
  std::fill_n(H, n * n, done ? 0.0 : std::numeric_limits<double>::quiet_NaN());
  if (!done) return;
  const LibraryFunction::Port& port = hessian_->outputs().front();
  const double* output = own.output(0);
  for (int i = 0; i < port.stored(); ++i) H[port.column_of[i] * n + port.row_of[i]] = output[i];
}

/// Central differences with the longest step that a shorter one confirms, entry by entry. The first
/// step balances truncation and rounding error for functions that vary on the scale of their
/// coordinates.
void LibraryKnotFunction::jacobian_by_differences(const double* z, const double* direction,
                                                  Workspace& workspace, double* dJ) const {
  const int n = columns(), entries = rows_ * n;
  double largest = 0, scale = 0;
  for (int i = 0; i < n; ++i) {
    largest = std::max(largest, std::abs(direction[i]));
    if (direction[i] != 0) scale = std::max(scale, std::abs(z[i]));
  }
  std::fill_n(dJ, entries, 0.0);
  if (largest == 0) return;
  double h = difference_step(scale) / largest;
  differentiate_centrally(z, direction, h, workspace, dJ);
  std::vector<double>& shorter = workspace.dJ_of_shorter_step;
  std::fill(workspace.settled.begin(), workspace.settled.end(), false);
  bool all = false;
  for (int step = 1; step < kSteps && !all; ++step) {
    h /= kShorter;
    differentiate_centrally(z, direction, h, workspace, shorter.data());
    all = true;
    for (int i = 0; i < entries; ++i) {
      if (workspace.settled[i]) continue;
      workspace.settled[i] = confirms_slope(shorter[i], dJ[i], std::abs(workspace.J[i]) / h);
      if (workspace.settled[i] || !std::isfinite(shorter[i])) continue;
      dJ[i] = shorter[i];
      all = false;
    }
  }
}

/// Leaves the Jacobian at the forward point in the workspace.
void LibraryKnotFunction::differentiate_centrally(const double* z, const double* direction,
                                                  double step, Workspace& workspace,
                                                  double* dJ) const {
  const int n = columns();
  const auto jacobian = [&](double moved, std::vector<double>& J) {
    for (int i = 0; i < n; ++i) workspace.moved[i] = z[i] + moved * direction[i];
    jacobian_at(workspace.moved.data(), workspace, J.data());
  };
  jacobian(-step, workspace.other);
  jacobian(step, workspace.J);
  for (int i = 0; i < rows_ * n; ++i) dJ[i] = (workspace.J[i] - workspace.other[i]) / (2 * step);
}

/// Computes the result row by row from the Hessian of each row.
void LibraryKnotFunction::jacobian_along(const double* z, const double* direction,
                                         Workspace& workspace, double* dJ) const {
  if (!has_hessian()) return jacobian_by_differences(z, direction, workspace, dJ);
  const int n = columns();
  std::vector<double>& weights = workspace.weights;
  for (int row = 0; row < rows_; ++row) {
    std::fill(weights.begin(), weights.end(), 0.0);
    weights[row] = 1;
    hessian_at(z, weights.data(), workspace, workspace.H.data());
    for (int j = 0; j < n; ++j) {
      double sum = 0;
      for (int i = 0; i < n; ++i) sum += workspace.H[i * n + j] * direction[i];
      dJ[j * rows_ + row] = sum;
    }
  }
}

void LibraryKnotFunction::second_derivatives(const double* z, const double* weights,
                                             Workspace& workspace, double* H) const {
  if (has_hessian()) return hessian_at(z, weights, workspace, H);
  const int n = columns();
  for (int j = 0; j < n; ++j) {
    std::fill(workspace.direction.begin(), workspace.direction.end(), 0.0);
    workspace.direction[j] = 1;
    jacobian_by_differences(z, workspace.direction.data(), workspace, workspace.dJ.data());
    for (int i = 0; i < n; ++i) {
      double sum = 0;
      for (int row = 0; row < rows_; ++row) sum += weights[row] * workspace.dJ[i * rows_ + row];
      H[j * n + i] = sum;
    }
  }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < j; ++i) H[j * n + i] = H[i * n + j] = 0.5 * (H[j * n + i] + H[i * n + j]);
}

/// For every row, the secant slope from z to a point one step away along one coordinate.
void LibraryKnotFunction::slopes_beside(const double* z, int column, double step,
                                        Workspace& workspace, std::vector<double>& slopes) const {
  std::copy_n(z, columns(), workspace.moved.begin());
  workspace.moved[column] += step;
  values_at(workspace.moved.data(), workspace, workspace.beside.data());
  const double moved = workspace.moved[column] - z[column];  // the step after rounding
  for (int row = 0; row < rows_; ++row)
    slopes[row] = (workspace.beside[row] - workspace.f[row]) / moved;
}

/// For points without values on the other side.
SlopeInterval LibraryKnotFunction::one_sided_slopes(const double* z, int column, int row,
                                                    double step, double slope,
                                                    Workspace& workspace) const {
  slopes_beside(z, column, step / 4, workspace, workspace.weights);
  return at_edge(slope, workspace.weights[row]);
}

/// For every row, the derivative by one coordinate from differences with step h; workspace.f
/// contains the values at z. At the edge of the domain the shortest step is h/4.
void LibraryKnotFunction::measure_column(const double* z, int column, double h, int step,
                                         Workspace& workspace) const {
  constexpr double kRounding = 16 * std::numeric_limits<double>::epsilon();
  slopes_beside(z, column, h, workspace, workspace.ahead);
  slopes_beside(z, column, -h, workspace, workspace.behind);
  for (int row = 0; row < rows_; ++row) {
    const double ahead = workspace.ahead[row], behind = workspace.behind[row];
    const bool has_ahead = std::isfinite(ahead), has_behind = std::isfinite(behind);
    SlopeInterval interval = between_slopes(ahead, behind);
    if (has_ahead && !has_behind)
      interval = one_sided_slopes(z, column, row, h, ahead, workspace);
    else if (has_behind && !has_ahead)
      interval = one_sided_slopes(z, column, row, -h, behind, workspace);
    const double shortest = has_ahead == has_behind ? h : h / 4;
    const double size = std::max(std::abs(interval.lower), std::abs(interval.upper));
    const double noise = kRounding * (std::abs(workspace.f[row]) / shortest +
                                      size * (1 + std::abs(z[column]) / shortest));
    workspace.measured[row * kSteps + step] = {interval, noise};
  }
}

/// Confirms one column of the Jacobian at z. kLoss is the relative error of differences besides
/// rounding. It applies to the derivative, or to kFloor times the largest entry if that is larger.
void LibraryKnotFunction::confirm_column(const double* z, int column, double largest,
                                         Workspace& workspace) const {
  constexpr double kLoss = 1e-4, kFloor = 1e-3;
  double h = difference_step(z[column]);
  for (int step = 0; step < kSteps; ++step, h /= kShorter)
    measure_column(z, column, h, step, workspace);
  for (int row = 0; row < rows_; ++row) {
    const auto& [interval, noise] =
        best_measured({workspace.measured.data() + row * kSteps, kSteps});
    const double size = std::max(std::abs(interval.lower), std::abs(interval.upper));
    double& claimed = workspace.confirmed[column * rows_ + row];
    claimed = confirmed_slope(claimed, interval, kLoss * std::max(size, kFloor * largest) + noise);
  }
}

/// Updates workspace.confirmed. Skips the work if z has not changed: the lanes and directions of a
/// knot share one Jacobian.
void LibraryKnotFunction::confirmed_jacobian(const double* z, Workspace& workspace) const {
  if (std::equal(z, z + columns(), workspace.confirmed_at.begin())) return;
  std::vector<double>& J = workspace.confirmed;
  jacobian_at(z, workspace, J.data());
  values_at(z, workspace, workspace.f.data());
  double largest = 1;
  for (const double entry : J)
    if (std::isfinite(entry)) largest = std::max(largest, std::abs(entry));
  for (int column = 0; column < columns(); ++column) confirm_column(z, column, largest, workspace);
  std::copy_n(z, columns(), workspace.confirmed_at.begin());
}

template <class S>
void LibraryKnotFunction::evaluate(const S* z, Workspace& workspace, S* f) const {
  for (int lane = 0; lane < kLanes<S>; ++lane) {
    take_lane(z, lane, workspace.z, workspace.direction);
    values_at(workspace.z.data(), workspace, workspace.f.data());
    for (int row = 0; row < rows_; ++row) set_value(f[row], lane, workspace.f[row]);
    if constexpr (kIsDual<S>) {
      confirmed_jacobian(workspace.z.data(), workspace);
      set_slopes(f, lane, rows_, workspace.confirmed, workspace.direction);
    }
  }
}

template <class S>
void LibraryKnotFunction::differentiate(const S* z, Workspace& workspace, S* f, S* J) const {
  const int entries = rows_ * columns();
  for (int lane = 0; lane < kLanes<S>; ++lane) {
    take_lane(z, lane, workspace.z, workspace.direction);
    values_at(workspace.z.data(), workspace, workspace.f.data());
    jacobian_at(workspace.z.data(), workspace, workspace.J.data());
    for (int row = 0; row < rows_; ++row) set_value(f[row], lane, workspace.f[row]);
    for (int i = 0; i < entries; ++i) set_value(J[i], lane, workspace.J[i]);
    if constexpr (kIsDual<S>) {
      set_slopes(f, lane, rows_, workspace.J, workspace.direction);
      jacobian_along(workspace.z.data(), workspace.direction.data(), workspace,
                     workspace.dJ.data());
      for (int i = 0; i < entries; ++i) J[i].d.set(lane, workspace.dJ[i]);
    }
  }
}

#define CONDDP_INSTANTIATE(S)                                                     \
  template void LibraryKnotFunction::evaluate<S>(const S*, Workspace&, S*) const; \
  template void LibraryKnotFunction::differentiate<S>(const S*, Workspace&, S*, S*) const;
CONDDP_INSTANTIATE(double)
CONDDP_INSTANTIATE(Lane)
CONDDP_INSTANTIATE(Dual<Lane>)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
