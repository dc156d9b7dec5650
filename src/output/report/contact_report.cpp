#include "output/report/contact_report.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "base/text/diagnostic.hpp"

namespace conddp {
namespace {

struct Figure {
  const char* name;
  const char* unit;
  WorstFigure ContactMeasures::*worst;
};

/// In the order of the files. Figures divided by the weight m g have the remaining unit.
constexpr Figure kFigures[] = {
    {"stepping", "1", &ContactMeasures::stepping},
    {"complementarity", "min(N, m)", &ContactMeasures::complementarity},
    {"product", "J", &ContactMeasures::product},
    {"penetration", "m", &ContactMeasures::penetration},
    {"penetration_between", "m", &ContactMeasures::between},
    {"pull", "1", &ContactMeasures::signs},
    {"friction", "min(N, m/s)", &ContactMeasures::friction},
    {"beyond_cone", "1", &ContactMeasures::cone},
    {"dissipation", "m/s", &ContactMeasures::dissipation},
    {"slip_inside_cone", "m/s", &ContactMeasures::slip},
    {"force_at_distance", "m", &ContactMeasures::distant},
    {"contact_work", "J", &ContactMeasures::work},
};

OrderedJson run_json(const ReplayRun& run, const std::vector<std::string>& names) {
  OrderedJson json = {{"deviation", finite_or_null(run.deviation)},
                      {"final", finite_or_null(run.final_state)}};
  if (run.knot >= 0) {
    json["knot"] = run.knot;
    json["quantity"] = names[run.entry];
  }
  if (run.lost_at >= 0) json["lost_at"] = run.lost_at;
  return json;
}

std::string run_text(const ReplayRun& run, const std::vector<std::string>& names) {
  std::string text = "no deviation";
  if (run.knot >= 0)
    text = fmt::format("{:.2g} in {} at knot {}", run.deviation, names[run.entry], run.knot);
  if (run.lost_at >= 0) text += fmt::format(", no step found at knot {}", run.lost_at);
  return text;
}

std::string place(const WorstFigure& worst) {
  return worst.knot < 0 ? std::string() : fmt::format(" ({}, knot {})", worst.what, worst.knot);
}

std::vector<std::string> closed_names(const ContactCertificate& certificate,
                                      const ContactStretch& stretch) {
  std::vector<std::string> names;
  for (std::size_t c = 0; c < stretch.closed.size(); ++c)
    if (stretch.closed[c]) names.push_back(certificate.candidates[c]);
  return names;
}

}  // namespace

namespace {

/// Forces of open candidates, for example "foot pushes with up to 3 N in 2 steps; ...".
std::string pushes_text(const ContactCertificate& certificate, const ContactStretch& stretch) {
  std::string text;
  for (std::size_t c = 0; c < stretch.pushes.size(); ++c)
    if (const auto& push = stretch.pushes[c]; push.steps > 0)
      text += fmt::format("{}{} pushes with up to {:.3g} N in {} step{}", text.empty() ? "" : "; ",
                          certificate.candidates[c], push.largest, push.steps,
                          push.steps == 1 ? "" : "s");
  return text;
}

}  // namespace

std::string contact_sequence_text(const ContactCertificate& certificate) {
  std::string text;
  for (const ContactStretch& stretch : certificate.sequence) {
    const auto names = closed_names(certificate, stretch);
    text += fmt::format("{}{} x {}", text.empty() ? "" : ", ", stretch.steps,
                        names.empty() ? "none" : fmt::format("{}", fmt::join(names, "+")));
    const std::string pushes = pushes_text(certificate, stretch);
    if (!pushes.empty()) text += " (" + pushes + ")";
  }
  return text;
}

namespace {

OrderedJson stretch_json(const ContactCertificate& certificate, const ContactStretch& stretch) {
  OrderedJson pushes = OrderedJson::array();
  for (std::size_t c = 0; c < stretch.pushes.size(); ++c)
    if (const auto& push = stretch.pushes[c]; push.steps > 0)
      pushes.push_back({{"contact", certificate.candidates[c]},
                        {"knots", push.steps},
                        {"largest_N", finite_or_null(push.largest)}});
  return {{"first_knot", certificate.first_knot + stretch.first},
          {"knots", stretch.steps},
          {"closed", closed_names(certificate, stretch)},
          {"pushes", std::move(pushes)}};
}

OrderedJson replay_runs_json(const ContactReplay& replay,
                             const std::vector<std::string>& tangent_names) {
  OrderedJson json = {{"substeps", replay.substeps},
                      {"each_step", run_json(replay.each_step, tangent_names)},
                      {"each_step_fine", run_json(replay.each_step_fine, tangent_names)},
                      {"ambiguous_steps", replay.ambiguous_steps},
                      {"controls", run_json(replay.controls, tangent_names)},
                      {"controls_fine", run_json(replay.controls_fine, tangent_names)}};
  if (replay.ambiguous_steps > 0) json["ambiguous"] = run_json(replay.ambiguous, tangent_names);
  if (replay.feedback_fine) json["feedback_fine"] = run_json(*replay.feedback_fine, tangent_names);
  return json;
}

}  // namespace

OrderedJson contact_certificate_json(const ContactCertificate& certificate,
                                     const std::vector<std::string>& tangent_names) {
  const ContactMeasures& m = certificate.measures;
  OrderedJson figures = OrderedJson::array();
  for (const Figure& figure : kFigures) {
    const WorstFigure& worst = m.*figure.worst;
    OrderedJson row = {
        {"name", figure.name}, {"value", finite_or_null(worst.value)}, {"unit", figure.unit}};
    if (worst.knot >= 0) {
      row["knot"] = worst.knot;
      row["at"] = worst.what;
    }
    figures.push_back(std::move(row));
  }
  OrderedJson sequence = OrderedJson::array();
  for (const ContactStretch& stretch : certificate.sequence)
    sequence.push_back(stretch_json(certificate, stretch));
  OrderedJson json = {{"figures", std::move(figures)},
                      {"energy",
                       {{"start_J", finite_or_null(m.energy_start)},
                        {"end_J", finite_or_null(m.energy_end)},
                        {"controls_J", finite_or_null(m.work_controls)},
                        {"contacts_J", finite_or_null(m.work_contacts)},
                        {"damping_J", finite_or_null(m.work_damping)},
                        {"stepping_J", finite_or_null(-m.stepping_loss())}}},
                      {"sequence", std::move(sequence)}};
  if (certificate.replay) json["replay"] = replay_runs_json(*certificate.replay, tangent_names);
  return json;
}

std::string contact_summary(const ContactCertificate& certificate) {
  const ContactMeasures& m = certificate.measures;
  return fmt::format("complementarity {:.1e}, penetration {:.1e} m, between knots {:.1e} m",
                     m.complementarity.value, m.penetration.value, m.between.value);
}

std::vector<std::string> contact_lines(const ContactCertificate& certificate,
                                       const std::vector<std::string>& tangent_names) {
  const ContactMeasures& m = certificate.measures;
  std::vector<std::string> lines;
  lines.push_back(fmt::format(
      "contacts: residual of the steps {:.1e} of h m g; min(force, gap) {:.1e}{}; penetration "
      "{:.1e} m at knots, {:.1e} m between{}",
      m.stepping.value, m.complementarity.value, place(m.complementarity), m.penetration.value,
      m.between.value, place(m.between)));
  lines.push_back(fmt::format(
      "friction: {:.1e} off Coulomb's law, {:.1e} m g beyond its cone; slip inside the cone {:.1e} "
      "m/s; forces act across {:.1e} m at most",
      m.friction.value, m.cone.value, m.slip.value, m.distant.value));
  lines.push_back(
      fmt::format("energy: {:.4g} J and {:+.4g} J of the controls, {:+.4g} J of contacts and "
                  "friction, {:+.4g} J "
                  "of damping, {:+.4g} J of the stepping make {:.4g} J",
                  m.energy_start, m.work_controls, m.work_contacts, m.work_damping,
                  -m.stepping_loss(), m.energy_end));
  lines.push_back("sequence: " + contact_sequence_text(certificate));
  if (!certificate.replay) return lines;
  const ContactReplay& replay = *certificate.replay;
  lines.push_back(fmt::format("each step by the simulator: {}; in dt/{}: {}",
                              run_text(replay.each_step, tangent_names), replay.substeps,
                              run_text(replay.each_step_fine, tangent_names)));
  if (replay.ambiguous_steps > 0)
    lines.push_back(fmt::format(
        "warning: {} step{} more than one solution; those that are not the plan's are off by up to "
        "{}",
        replay.ambiguous_steps, replay.ambiguous_steps == 1 ? " has" : "s have",
        run_text(replay.ambiguous, tangent_names)));
  lines.push_back(fmt::format("controls alone by the simulator: {}; in dt/{}: {}",
                              run_text(replay.controls, tangent_names), replay.substeps,
                              run_text(replay.controls_fine, tangent_names)));
  if (replay.feedback_fine)
    lines.push_back(fmt::format("with feedback in dt/{}: {}", replay.substeps,
                                run_text(*replay.feedback_fine, tangent_names)));
  return lines;
}

}  // namespace conddp
