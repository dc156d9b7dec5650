#include "systems/libraries/library_system.hpp"

#include <algorithm>

namespace conddp {
namespace {

class LibrarySystem : public SystemBase<LibrarySystem> {
 public:
  LibrarySystem(const LibrarySystemColumns& columns,
                std::shared_ptr<const LibraryKnotFunction> function)
      : SystemBase(columns.kind, StateManifold::flat(count_states(columns, *function)),
                   static_cast<int>(columns.controls.size())),
        function_(std::move(function)) {
    const Column clock{kClock, "s", true}, clock_rate{kClockRate, "s/s", true};
    state_columns_ = columns.states;
    if (function_->reads_time()) state_columns_.push_back(clock);
    const bool second_order = kind() == SystemKind::second_order;
    state_columns_.insert(state_columns_.end(), columns.velocities.begin(),
                          columns.velocities.end());
    if (function_->reads_time() && second_order) state_columns_.push_back(clock_rate);
    control_columns_ = columns.controls;
    sources_ = own_states(*this);
    for (int i = 0; i < nu(); ++i) sources_.push_back(nx() + i);
    if (!function_->reads_time()) return;
    clock_ = static_cast<int>(columns.states.size());
    sources_.push_back(clock_);
  }

  template <class S>
  struct Data : SystemData<S> {
    explicit Data(const LibrarySystem& system)
        : z(system.function_->columns()),
          f_of_library(system.function_->rows()),
          J(system.function_->rows() * system.function_->columns()),
          workspace(system.function_->create_workspace()) {}
    AlignedVector<S> z, f_of_library, J;
    LibraryKnotFunction::OwnedWorkspace workspace;
  };

  template <class S>
  void evaluate_as(const S* x, const S* u, Data<S>& data) const {
    gather(x, u, data.z.data());
    function_->evaluate(data.z.data(), *data.workspace, data.f_of_library.data());
    set_values(data);
  }

  template <class S>
  void differentiate_as(const S* x, const S* u, Data<S>& data) const {
    gather(x, u, data.z.data());
    function_->differentiate(data.z.data(), *data.workspace, data.f_of_library.data(),
                             data.J.data());
    set_values(data);
    const int own = function_->rows();
    for (int j = 0; j < function_->columns(); ++j) {
      const int source = sources_[j];
      S* column = source < nx() ? data.fx.data() + source * rows()
                                : data.fu.data() + (source - nx()) * rows();
      std::copy_n(data.J.data() + j * own, own, column);
    }
  }

  template <class S>
  void update_kinematics_as(const S*, Data<S>&) const {}

  std::vector<std::string> failed_functions() const override {
    return function_->failed_functions();
  }
  bool has_claimed_hessian() const override { return function_->has_hessian(); }

  std::unique_ptr<SecondDerivatives> second_derivatives(SystemData<Lane>&,
                                                        SystemData<Dual<Lane>>&) const override;

 private:
  class Hessian;

  static int count_states(const LibrarySystemColumns& columns,
                          const LibraryKnotFunction& function) {
    const std::size_t clock = function.reads_time() ? 1 : 0;
    const std::size_t twice = columns.kind == SystemKind::second_order ? 2 : 1;
    return static_cast<int>(twice * (columns.states.size() + clock));
  }

  template <class S>
  void gather(const S* x, const S* u, S* z) const {
    for (std::size_t i = 0; i < sources_.size(); ++i)
      z[i] = sources_[i] < nx() ? x[sources_[i]] : u[sources_[i] - nx()];
  }

  /// The rows of the library come first; the last row is that of the clock.
  template <class S>
  void set_values(Data<S>& data) const {
    std::copy(data.f_of_library.begin(), data.f_of_library.end(), data.f.begin());
    if (clock_ >= 0) data.f[rows() - 1] = S(kind() == SystemKind::first_order ? 1.0 : 0.0);
  }

  std::shared_ptr<const LibraryKnotFunction> function_;
  std::vector<int> sources_;  ///< for each number of the function's z, its index in (x, u)
  int clock_ = -1;
};

/// Adds the whole Hessian at once, lane by lane.
class LibrarySystem::Hessian : public SecondDerivatives {
 public:
  explicit Hessian(const LibrarySystem& system)
      : system_(system),
        function_(*system.function_),
        workspace_(function_.create_workspace()),
        z_(function_.columns()),
        weights_(function_.rows()),
        lane_z_(z_.size()),
        lane_weights_(weights_.size()),
        H_(z_.size() * z_.size()) {}

  int forces() const override { return 0; }
  bool at_once() const override { return true; }
  void start(const Dual<Lane>* x, const Dual<Lane>* u) override {
    for (std::size_t i = 0; i < z_.size(); ++i) {
      const int source = system_.sources_[i];
      z_[i] = source < system_.nx() ? x[source].v : u[source - system_.nx()].v;
    }
  }
  void move_force(int) override {}
  void weigh(const Lane* of_f, const Lane*) override {
    std::copy_n(of_f, weights_.size(), weights_.begin());
  }
  void move(const Dual<Lane>*, int, Lane*) override {}
  void finish(Lane* gradients) override {
    for (int lane = 0; lane < kLaneWidth; ++lane) {
      for (std::size_t i = 0; i < z_.size(); ++i) lane_z_[i] = z_[i][lane];
      for (std::size_t i = 0; i < weights_.size(); ++i) lane_weights_[i] = weights_[i][lane];
      function_.second_derivatives(lane_z_.data(), lane_weights_.data(), *workspace_, H_.data());
      add(lane, gradients);
    }
  }

 private:
  /// The state is flat, so a number of (x, u) has the same index in tangent vectors.
  void add(int lane, Lane* gradients) const {
    const int n = function_.columns(), nz = system_.ndx() + system_.nu();
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        Lane& entry = gradients[system_.sources_[j] * nz + system_.sources_[i]];
        entry.set(lane, entry[lane] + H_[j * n + i]);
      }
  }

  const LibrarySystem& system_;
  const LibraryKnotFunction& function_;
  LibraryKnotFunction::OwnedWorkspace workspace_;
  AlignedVector<Lane> z_, weights_;
  std::vector<double> lane_z_, lane_weights_, H_;
};

std::unique_ptr<SecondDerivatives> LibrarySystem::second_derivatives(
    SystemData<Lane>&, SystemData<Dual<Lane>>&) const {
  return std::make_unique<Hessian>(*this);
}

}  // namespace

std::shared_ptr<const System> make_library_system(
    const LibrarySystemColumns& columns, std::shared_ptr<const LibraryKnotFunction> function) {
  return std::make_shared<LibrarySystem>(columns, std::move(function));
}

std::vector<double> usual_library_state(const System& system) {
  std::vector<double> state(system.nx(), 0.0);
  for (int i = 0; i < system.nx(); ++i)
    if (system.state_columns()[i].name == kClockRate) state[i] = 1;
  return state;
}

}  // namespace conddp
