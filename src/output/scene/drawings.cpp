#include "output/scene/drawings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>

#include "output/scene/form_json.hpp"
#include "problem_file/terms/drawing_builder.hpp"

namespace conddp {
namespace {

/// The numbers of an expression at each node.
using Course = std::vector<std::vector<double>>;

/// Evaluates the expressions of the drawings along a trajectory.
class Courses {
 public:
  Courses(const ShootingProblem& drawn, const Trajectory& trajectory, std::span<const int> knots)
      : drawn_(drawn), trajectory_(trajectory), nodes_(trajectory.knots() + 1) {
    for (int i = 0; i < nodes_; ++i) evaluate(i, knots.empty() ? i : knots[i]);
    for (auto& [name, course] : courses_) fill(course);
  }

  const Course& operator[](const std::string& name) { return courses_[name]; }

 private:
  /// The control at a node; at a last node that is a knot of the problem, the control before it.
  std::vector<double> control(int node, int nu) const {
    std::vector<double> u(nu, 0.0);
    const int knot = std::min(node, trajectory_.knots() - 1);
    if (nu == trajectory_.nu(knot)) std::copy_n(trajectory_.u(knot).data(), nu, u.begin());
    return u;
  }

  void evaluate(int node, int knot) {
    const KnotView& view = drawn_.knot(knot);
    const KnotModel& model = *view.model;
    auto& work = workspaces_[&model];
    if (!work) work = std::make_unique<KnotWorkspace<double>>(model);
    const std::vector<double> u = control(node, model.nu());
    model.evaluate(KnotInput<double>{trajectory_.x(node).data(), u.empty() ? nullptr : u.data(),
                                     view.parameters, view.dt, view.cost_scale},
                   *work);
    for (const ConstraintTerm& term : model.constraints()) {
      if (view.parameters[term.active()] == 0) continue;
      const double* values = work->constraint.data() + term.row;
      Course& course = courses_[term.name];
      course.resize(nodes_);
      course[node].assign(values, values + term.rows);
    }
  }

  /// Nodes without numbers take those of the node before, the first ones those of the next.
  static void fill(Course& course) {
    for (std::size_t k = 1; k < course.size(); ++k)
      if (course[k].empty()) course[k] = course[k - 1];
    for (std::size_t k = course.size() - 1; k-- > 0;)
      if (course[k].empty()) course[k] = course[k + 1];
  }

  const ShootingProblem& drawn_;
  const Trajectory& trajectory_;
  int nodes_;
  std::map<std::string, Course> courses_;
  std::map<const KnotModel*, std::unique_ptr<KnotWorkspace<double>>> workspaces_;
};

std::array<double, 3> point(const std::vector<double>& numbers) {
  return {numbers[0], numbers[1], numbers.size() > 2 ? numbers[2] : 0};
}

/// Position and quaternion x y z w of a place, turned about its z axis by an angle.
std::array<double, 7> pose(const std::vector<double>& place, double angle) {
  const auto [px, py, pz] = point(place);
  std::array<double, 4> q{0, 0, 0, 1};
  if (place.size() == 7) std::copy_n(place.begin() + 3, 4, q.begin());
  const auto [x, y, z, w] = q;
  const double norm = std::sqrt(x * x + y * y + z * z + w * w);
  const double s = std::sin(0.5 * angle) / norm, c = std::cos(0.5 * angle) / norm;
  return {px, py, pz, x * c + y * s, y * c - x * s, z * c + w * s, w * c - z * s};
}

template <class Numbers>
void append(const Numbers& numbers, OrderedJson& list) {
  for (const double x : numbers) list.push_back(eight_digits(x));
}

OrderedJson shape_json(const DrawingSpec& drawing) {
  return std::visit(
      [](const auto& form) -> OrderedJson {
        if constexpr (std::is_same_v<std::decay_t<decltype(form)>, std::monostate>)
          return {{"kind", "dot"}};
        else
          return form_json(form);
      },
      drawing.shape);
}

/// Adds drawings to a scene one by one.
class DrawnScene {
 public:
  DrawnScene(Courses courses, int nodes, OrderedJson& scene)
      : courses_(std::move(courses)),
        nodes_(nodes),
        scene_(scene),
        planar_(scene["bodies"].size() == 1),
        poses_(nodes) {
    scene_["lines"] = OrderedJson::array();
  }

  void add(const DrawingSpec& drawing) {
    if (!drawing.line.empty())
      add_line(drawing);
    else if (drawing.at)
      add_body(drawing);
    else
      add_fixed(drawing);
  }

  /// Writes the poses of all bodies; a scene in the plane is marked.
  void finish() {
    const OrderedJson before = std::move(scene_["poses"]);
    OrderedJson poses = OrderedJson::array();
    const std::size_t own = before.size() / static_cast<std::size_t>(nodes_);
    for (std::size_t k = 0; k < poses_.size(); ++k) {
      for (std::size_t i = 0; i < own; ++i) poses.push_back(before[k * own + i]);
      append(poses_[k], poses);
    }
    scene_["poses"] = std::move(poses);
    scene_["planar"] = planar_;
  }

 private:
  void add_fixed(const DrawingSpec& drawing) {
    OrderedJson shape = {{"name", drawing.name.value}, {"inside", false}, {"scenery", true}};
    shape.update(shape_json(drawing));
    scene_["obstacles"].push_back(std::move(shape));
  }

  void add_body(const DrawingSpec& drawing) {
    const std::string& name = drawing.name.value;
    const Course& places = courses_[name + "/at"];
    const Course* angles = drawing.angle ? &courses_[name + "/angle"] : nullptr;
    OrderedJson way = OrderedJson::array();
    for (int k = 0; k < nodes_; ++k) {
      const auto numbers = pose(places[k], angles ? (*angles)[k][0] : 0);
      poses_[k].insert(poses_[k].end(), numbers.begin(), numbers.end());
      append(point(places[k]), way);
      planar_ &= places[k].size() == 2;
    }
    scene_["bodies"].push_back(
        {{"name", name}, {"parent", 0}, {"shapes", OrderedJson::array({shape_json(drawing)})}});
    const auto moves = [&](const std::vector<double>& place) { return place != places.front(); };
    if (std::any_of(places.begin(), places.end(), moves)) scene_["paths"][name] = std::move(way);
  }

  void add_line(const DrawingSpec& drawing) {
    OrderedJson positions = OrderedJson::array();
    for (int k = 0; k < nodes_; ++k)
      for (const DrawnText& corner : drawn_texts(drawing)) {
        const std::vector<double>& numbers = courses_[corner.name][k];
        append(point(numbers), positions);
        planar_ &= numbers.size() == 2;
      }
    scene_["lines"].push_back({{"name", drawing.name.value},
                               {"corners", drawing.line.size()},
                               {"positions", std::move(positions)}});
  }

  Courses courses_;
  int nodes_;
  OrderedJson& scene_;
  bool planar_;  ///< so far
  std::vector<std::vector<double>> poses_;
};

}  // namespace

void add_drawings(const BuiltProblem& built, const Trajectory& trajectory,
                  std::span<const int> knots, OrderedJson& scene) {
  DrawnScene drawn(Courses(*built.drawn, trajectory, knots), trajectory.knots() + 1, scene);
  for (const DrawingSpec& drawing : built.facts().drawings) drawn.add(drawing);
  drawn.finish();
}

}  // namespace conddp
