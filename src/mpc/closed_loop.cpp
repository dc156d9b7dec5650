#include "mpc/closed_loop.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "base/random_numbers.hpp"

namespace conddp {
namespace {

bool is_finite(const std::vector<double>& x) {
  return std::all_of(x.begin(), x.end(), [](double value) { return std::isfinite(value); });
}

/// Plant driven by the loop's controls, period by period.
class Plant {
 public:
  Plant(Mpc& mpc, const ClosedLoopOptions& options, ClosedLoopResult& result)
      : mpc_(mpc),
        options_(options),
        result_(result),
        law_{mpc, options.plant, {}},
        motions_(options.plant, options.step, mpc.time_line()),
        appraisal_(mpc.time_line(), options.finds_contacts()),
        stop_(options.stop) {
    x = mpc.time_line().problem().initial_state();
  }

  /// Applies all jumps of the state that are due by this time.
  void jump(double time) {
    for (; jumps_ < options_.jumps.size() && !is_before(time, options_.jumps[jumps_].at); ++jumps_)
      mpc_.time_line().problem().manifold().integrate(
          x.data(), options_.jumps[jumps_].tangent.data(), x.data());
  }

  /// Advances the plant; false if the loop ends before `to`.
  bool advance(double from, double to) {
    for (double time = from; is_before(time, to);) {
      jump(time);
      const double stop = std::min(to, next_event(time));
      if (!run(time, stop)) return false;
      time = stop;
    }
    return true;
  }

  /// Adds the cost and violation of the last node at the current state.
  void appraise_end() { count(appraisal_.of_end(x.data())); }

  /// Contacts that are closed just before a time.
  std::uint32_t closed_contacts(double time) const { return motion_before(time).closed_contacts(); }

  std::vector<double> x;

 private:
  struct Law {
    Mpc& mpc;
    std::span<const PlantPeriod> periods;
    Eigen::VectorXd u;
    const double* control(double time, const double* state) {
      u = mpc.control(time, state);
      // The control already satisfies the model's own bounds.
      if (const PlantPeriod* now = period_at(periods, time); now != nullptr && now->problem) {
        const int k = mpc.time_line().at(mpc.line_time(time)).knot;
        clip_control(*now->problem->knot(k).model, u);
      }
      return u.data();
    }
    double next_change(double time) const { return mpc.next_change(time); }
  };

  /// Next time after `time` of a jump or of a change of the plant.
  double next_event(double time) const {
    double next = std::numeric_limits<double>::infinity();
    for (const double begin : motions_.begins())
      if (is_before(time, begin)) next = std::min(next, begin);
    for (const Jump& jump : options_.jumps)
      if (is_before(time, jump.at)) next = std::min(next, jump.at);
    return next;
  }

  bool run(double from, double to) {
    PlantMotion& motion = motions_.at(from);
    const std::size_t first = result_.steps.size();
    const auto end_step = [&] {
      const std::span<const double> forces = motion.contact_forces();
      if (result_.steps.size() > first)
        result_.steps.back().contact_forces.assign(forces.begin(), forces.end());
    };
    const auto begin = [&](double time, double length, const double* u) {
      end_step();
      if (!goes_on(time)) return false;
      result_.steps.push_back({time, length, x, {u, u + law_.u.size()}, mpc_.line_time(time)});
      count(appraisal_.of_step(mpc_.line_time(time), length, u, x.data()));
      return true;
    };
    if (!simulate(motion, from, to, law_, held_, x.data(), begin)) return false;
    end_step();
    return goes_on(to);
  }

  void count(const StepFigures& figures) {
    result_.cost += figures.cost;
    result_.violation = std::max(result_.violation, figures.violation);
  }

  bool goes_on(double time) {
    result_.end_time = time;
    if (!is_finite(x)) {
      result_.end = LoopEnd::diverged;
      result_.failure = motion_before(time).failure();
      return false;
    }
    if (!stop_.is_met(x.data())) return true;
    result_.end = LoopEnd::stopped;
    return false;
  }

  /// Motion of the plant just before a time.
  const PlantMotion& motion_before(double time) const { return motions_.at(time - 2 * kSameTime); }

  Mpc& mpc_;
  const ClosedLoopOptions& options_;
  ClosedLoopResult& result_;
  Law law_;
  PlantMotions motions_;
  HeldControl held_;
  Appraisal appraisal_;
  StopCheck stop_;
  std::size_t jumps_ = 0;  ///< number of jumps applied
};

/// State measurement as the controller receives it, with noise and distortion.
class Sensor {
 public:
  Sensor(const ClosedLoopOptions& options, const ShootingProblem& problem)
      : options_(options),
        manifold_(problem.manifold()),
        normal_(options.noise ? options.noise->seed : 0),
        tangent_(problem.ndx()) {
    if (options.noise && static_cast<int>(options.noise->sigma.size()) != problem.ndx())
      throw std::invalid_argument("the noise has another size than the state");
  }

  const std::vector<double>& measure(int tick, const std::vector<double>& x) {
    seen_ = x;
    if (options_.noise) {
      for (std::size_t i = 0; i < tangent_.size(); ++i)
        tangent_[i] = options_.noise->sigma[i] * normal_.next();
      manifold_.integrate(x.data(), tangent_.data(), seen_.data());
    }
    if (options_.distort) options_.distort(tick, seen_);
    return seen_;
  }

 private:
  const ClosedLoopOptions& options_;
  const StateManifold& manifold_;
  NormalNumbers normal_;
  std::vector<double> tangent_, seen_;
};

}  // namespace

std::string_view to_string(LoopEnd end) {
  switch (end) {
    case LoopEnd::finished:
      return "finished";
    case LoopEnd::stopped:
      return "stopped";
    case LoopEnd::diverged:
      return "diverged";
    case LoopEnd::interrupted:
      break;
  }
  return "interrupted";
}

bool ClosedLoopOptions::finds_contacts() const {
  return std::any_of(plant.begin(), plant.end(),
                     [](const PlantPeriod& period) { return period.motion != nullptr; });
}

ClosedLoopResult run_closed_loop(Mpc& mpc, const ClosedLoopOptions& options) {
  ClosedLoopResult result;
  const TimeLine& line = mpc.time_line();
  const double end = line.is_held() ? options.duration : std::min(options.duration, line.end());
  mpc.reserve(end);
  Plant plant(mpc, options, result);
  Sensor sensor(options, line.problem());
  auto command = options.commands.begin();
  while (is_before(mpc.time(), end) && mpc.goes_on()) {
    if (options.interrupted && options.interrupted()) {
      result.end = LoopEnd::interrupted;
      break;
    }
    const double from = mpc.time();
    plant.jump(from);
    mpc.see_contacts(plant.closed_contacts(from));
    // Commands are due by their time on the time line, whose past stays unchanged.
    for (; command != options.commands.end() && !is_before(mpc.line_time(from), command->at);
         ++command)
      mpc.take_numbers(command->numbers, command->terminal_path);
    mpc.prepare();
    mpc.feedback(sensor.measure(mpc.last_tick().tick, plant.x));
    result.ticks.push_back(mpc.last_tick());
    if (options.observe) options.observe(mpc);
    if (!plant.advance(from, std::min(mpc.time(), end))) break;
  }
  // With a delay, the last plan may begin after the end of the time line: the former plan
  // continues.
  if (result.end == LoopEnd::finished) plant.advance(mpc.time(), end);
  if (result.end == LoopEnd::finished && !line.is_held() && !is_before(end, line.end()))
    plant.appraise_end();
  result.last_state = plant.x;
  return result;
}

std::optional<double> largest_survived(double low, double high, double width,
                                       const std::function<bool(double)>& survives) {
  if (!survives(low)) return std::nullopt;
  if (survives(high)) return high;
  while (high - low > width) {
    const double middle = 0.5 * (low + high);
    if (middle <= low || middle >= high) break;  // no number lies in between
    (survives(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace conddp
