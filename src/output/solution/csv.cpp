#include "output/solution/csv.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "ocp/problem/by_name.hpp"
#include "output/solution/csv_cells.hpp"
#include "output/solution/log_columns.hpp"
#include "problem_file/data/data_table.hpp"

namespace conddp {
namespace {

constexpr std::array<const char*, 6> kWrench = {"fx", "fy", "fz", "tx", "ty", "tz"};
constexpr int kForceParts = 3, kWrenchParts = 6;

void append_state(const Trajectory& trajectory, int knot, const std::vector<int>& states,
                  std::string& text) {
  for (const int i : states) {
    text += ',';
    append_cell(trajectory.x(knot)[i], text);
  }
}

/// Empty cells for nodes without a control.
void append_control(const Eigen::VectorXd& row, std::size_t first, std::size_t end,
                    std::string& text) {
  for (std::size_t i = first; i < end; ++i) {
    text += ',';
    if (static_cast<Eigen::Index>(i) < row.size()) append_cell(row[i], text);
  }
}

/// Columns of the table. A free initial state is carried along in the states and is omitted here.
/// Linear controls appear at the nodes, like states.
TableColumns columns_of(const BuiltProblem& built) {
  const ShootingProblem& problem = *built.problem;
  const Step& end = problem.terminal().model->step();
  const bool chosen = problem.phases().front().instant;
  const int own = built.plant.system->nx() + built.integrals, nx = problem.nx();
  TableColumns columns;
  for (int i = 0; i < nx; ++i)
    if (i < own || !chosen || end.source(i - built.plant.system->nx())) columns.states.push_back(i);
  columns.first_control = end.controls_in_state();
  return columns;
}

}  // namespace

std::string contact_headers(const ContactForces& forces) {
  std::string text;
  for (const auto& contact : forces.contacts)
    for (int i = 0; i < (contact.torque ? kWrenchParts : kForceParts); ++i)
      text += ',' + with_unit(csv_cell("contact/" + contact.name + '/' + kWrench[i]),
                              i < kForceParts ? "N" : "Nm");
  return text;
}

void append_contact_cells(const ContactForces& forces, int row, bool written, std::string& text) {
  for (const auto& contact : forces.contacts)
    for (int i = 0; i < (contact.torque ? kWrenchParts : kForceParts); ++i) {
      text += ',';
      if (written && contact.wrench[row]) append_cell((*contact.wrench[row])[i], text);
    }
}

std::string trajectory_csv(const BuiltProblem& built, const Trajectory& trajectory,
                           const ContactForces& forces) {
  const ShootingProblem& problem = *built.problem;
  // With a free initial state, the motion begins after its choice.
  const int first = problem.phases().front().instant ? 1 : 0;
  const TableColumns columns = columns_of(built);
  const ControlColumns controls(problem);
  std::string text =
      "t [s],phase" + column_headers(built, columns) + contact_headers(forces) + '\n';
  const std::vector<double> times = problem.times(trajectory);
  double written = -std::numeric_limits<double>::infinity();
  for (int k = first; k <= problem.knots(); ++k) {
    const bool last = k == problem.knots();
    const Phase& phase = last ? problem.terminal() : problem.phases()[problem.knot(k).phase];
    // Readers expect increasing times, but an impulse takes no time.
    written = std::max({times[k], written + kLeastTimeStep,
                        std::nextafter(written, std::numeric_limits<double>::infinity())});
    append_cell(written, text);
    text += ',' + csv_cell(phase.name);
    const bool controlled = !last && !problem.takes_no_time(k);
    append_state(trajectory, k, columns.states, text);
    const Eigen::VectorXd row = controlled ? controls.row(k, trajectory.u(k)) : Eigen::VectorXd();
    append_control(row, columns.first_control, built.control_columns.size(), text);
    append_contact_cells(forces, k, controlled, text);
    text += '\n';
  }
  return text;
}

namespace {

/// Appends a number, or nothing for null.
void append_json(const OrderedJson& value, std::string& text) {
  if (value.is_number_integer())
    text += fmt::format("{}", value.get<long long>());
  else if (value.is_number())
    append_cell(value.get<double>(), text);
}

}  // namespace

std::string iterations_csv(const OrderedJson& log) {
  std::string text;
  for (const LogColumn& column : log_columns())
    text += (text.empty() ? "" : ",") + with_unit(std::string(column.name), column.unit);
  text += '\n';
  for (const OrderedJson& row : log) {
    bool first = true;
    for (const LogColumn& column : log_columns()) {
      if (!first) text += ',';
      first = false;
      append_json(row.value(log_key(column), OrderedJson()), text);
    }
    text += '\n';
  }
  return text;
}

}  // namespace conddp
