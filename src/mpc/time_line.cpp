#include "mpc/time_line.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace conddp {

TimeLine::TimeLine(std::shared_ptr<const ShootingProblem> problem, bool held)
    : problem_(std::move(problem)), numbers_(problem_), held_(held) {
  if (problem_->has_free_durations())
    throw std::invalid_argument("a time line has no free durations");
  if (problem_->knots() == 0 || problem_->phases().front().instant)
    throw std::invalid_argument("a time line begins with a knot that takes time");
  for (int k = 0; k < problem_->knots(); ++k)
    if (!problem_->takes_no_time(k)) last_ = k;
}

void TimeLine::take_numbers(std::shared_ptr<const ShootingProblem> source) {
  bool same = source->times() == problem_->times();
  for (int k = 0; same && k <= problem_->knots(); ++k) {
    const KnotModel &own = *problem_->knot(k).model, &other = *source->knot(k).model;
    same = own.parameter_count() == other.parameter_count() && own.nx() == other.nx() &&
           own.nu() == other.nu();
  }
  if (!same) throw std::invalid_argument("the numbers are those of another structure");
  numbers_ = std::move(source);
}

int TimeLine::first_after(double time) const {
  const std::vector<double>& times = problem_->times();
  int k = static_cast<int>(std::lower_bound(times.begin(), times.end(), time - kSameTime) -
                           times.begin());
  // Knot k − 1 begins before the time and may end after it.
  if (k > 0 && is_before(time, times[std::min(k, problem_->knots())])) --k;
  return std::min(k, problem_->knots());
}

TimedKnot TimeLine::held(double time) const {
  const double step = problem_->knot(last_).dt;
  const double count = std::floor((time - end() + kSameTime) / step);
  return {last_, end() + count * step, end() + (count + 1) * step};
}

TimedKnot TimeLine::at(double time) const {
  int k = first_after(std::max(time, 0.0));
  while (k < problem_->knots() && problem_->takes_no_time(k)) ++k;
  if (k < problem_->knots()) return {k, problem_->times()[k], problem_->times()[k + 1]};
  if (held_) return held(time);
  return {last_, problem_->times()[last_], end()};
}

std::pair<int, int> TimeLine::instants_at(double time) const {
  const int N = problem_->knots();
  const int first = first_after(time);
  int end = first;
  while (end < N && problem_->takes_no_time(end) && !is_before(time, problem_->times()[end])) ++end;
  return {first, end};
}

void TimeLine::cut(double from, double to, std::vector<TimedKnot>& knots) const {
  knots.clear();
  const std::vector<double>& times = problem_->times();
  for (int k = first_after(from); k < problem_->knots() && is_before(times[k], to); ++k)
    if (problem_->takes_no_time(k))
      knots.push_back({k, times[k], times[k]});
    else if (is_before(from, times[k + 1]))
      knots.push_back({k, std::max(times[k], from), std::min(times[k + 1], to)});
  if (!held_) return;
  for (double time = std::max(from, end()); is_before(time, to);) {
    double end = held(time).end;
    // If rounding of a large time exceeds a knot, the knot is as short as floating-point spacing
    // allows.
    if (!is_before(time, end))
      end = std::max(time + problem_->knot(last_).dt,
                     std::nextafter(time, std::numeric_limits<double>::infinity()));
    knots.push_back({last_, time, std::min(end, to)});
    time = end;
  }
}

}  // namespace conddp
