#include "output/report/certificate_report.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/json/ordered_json.hpp"
#include "base/text/diagnostic.hpp"
#include "base/text/utf8.hpp"
#include "output/report/contact_report.hpp"

namespace conddp {
namespace {

/// Deviations under feedback beyond this share of a quantity's range cause a warning.
constexpr double kFarOff = 0.1;

bool has_figures(const Check& check) { return !std::isnan(check.tolerance); }

std::string figure(double value) {
  return std::isnan(value) ? std::string("nothing") : fmt::format("{:.9g}", value);
}

std::string failure_text(const Check& check) {
  std::string text = check.name + ": ";
  // A check without claimed figures is explained by its message.
  const bool figures = has_figures(check) && (!std::isnan(check.claimed) || check.message.empty());
  if (figures)
    text += fmt::format("claimed {}, found {} (tolerance {:.1e})", figure(check.claimed),
                        figure(check.found), check.tolerance);
  if (!check.message.empty()) text += (figures ? ": " : "") + check.message;
  if (!check.place.empty()) text += " at " + check.place;
  return text;
}

std::string entry_name(const SolutionCertificate& certificate, const ReplayRun& run) {
  return run.entry < 0 ? std::string() : certificate.tangent_names[run.entry];
}

std::string run_text(const SolutionCertificate& certificate, const ReplayRun& run) {
  if (run.lost_at >= 0) return fmt::format("is no longer finite at knot {}", run.lost_at);
  if (run.knot < 0) return "no deviation";
  return fmt::format("{:.2g} in {} at knot {}", run.deviation, entry_name(certificate, run),
                     run.knot);
}

std::string limit_text(const BrokenLimit& limit) {
  return fmt::format("{} beyond its limit by {:.2g} {} at {:.3g} s (knot {}{})", limit.quantity,
                     limit.excess, limit.unit, limit.time, limit.knot,
                     limit.between ? ", between knots" : "");
}

OrderedJson optimality_json(const Optimality& o) {
  OrderedJson json = OrderedJson::object();
  for (const OptimalityFigure& figure : kOptimalityFigures)
    json[figure.name] = finite_or_null(o.*figure.value);
  return json;
}

OrderedJson second_order_json(const SecondOrder& found) {
  OrderedJson json = {{"least_curvature", finite_or_null(found.least)}, {"knot", found.knot}};
  for (const auto& [name, figure] : kSecondOrderFigures) json[name] = finite_or_null(found.*figure);
  return json;
}

OrderedJson run_json(const SolutionCertificate& certificate, const ReplayRun& run) {
  OrderedJson json = {{"deviation", finite_or_null(run.deviation)},
                      {"relative", finite_or_null(run.relative)},
                      {"final", finite_or_null(run.final_state)}};
  if (run.knot >= 0) {
    json["knot"] = run.knot;
    json["quantity"] = entry_name(certificate, run);
  }
  if (run.lost_at >= 0) json["lost_at"] = run.lost_at;
  return json;
}

OrderedJson replay_json(const SolutionCertificate& certificate) {
  const Replay& replay = *certificate.replay;
  if (!replay.impossible.empty()) return {{"impossible", replay.impossible}};
  OrderedJson broken = OrderedJson::array();
  for (const BrokenLimit& limit : replay.broken)
    broken.push_back({{"quantity", limit.quantity},
                      {"unit", limit.unit},
                      {"excess", limit.excess},
                      {"knot", limit.knot},
                      {"time_s", limit.time},
                      {"between_knots", limit.between}});
  OrderedJson json = {{"substeps", replay.substeps},
                      {"controls", run_json(certificate, replay.controls)},
                      {"feedback", run_json(certificate, replay.feedback)},
                      {"saturated_controls", replay.feedback.saturated},
                      {"broken_limits", std::move(broken)}};
  return json;
}

}  // namespace

namespace {

OrderedJson check_json(const Check& check) {
  OrderedJson row = json_object(7);
  row["name"] = check.name;
  row["holds"] = check.holds;
  if (!std::isnan(check.claimed)) row["claimed"] = finite_or_null(check.claimed);
  if (!std::isnan(check.found)) row["found"] = finite_or_null(check.found);
  if (has_figures(check)) row["tolerance"] = finite_or_null(check.tolerance);
  if (!check.place.empty()) row["place"] = check.place;
  if (!check.message.empty()) row["message"] = check.message;
  return row;
}

}  // namespace

OrderedJson checks_json(const Certificate& certificate) {
  OrderedJson checks = OrderedJson::array();
  for (const Check& check : certificate.checks) checks.push_back(check_json(check));
  return checks;
}

OrderedJson certificate_json(const SolutionCertificate& certificate) {
  OrderedJson json = json_object(10);
  json["holds"] = certificate.checks.holds();
  json["verdict"] = to_string(certificate.checks.verdict());
  json["checks"] = checks_json(certificate.checks);
  json["time_s"] = certificate.time_s;
  json["optimality"] = optimality_json(certificate.checks.optimality);
  if (certificate.checks.second_order)
    json["second_order"] = second_order_json(*certificate.checks.second_order);
  if (certificate.contacts)
    json["contacts"] = contact_certificate_json(*certificate.contacts, certificate.tangent_names);
  if (!certificate.replay) return json;
  json["replay"] = replay_json(certificate);
  json["warnings"] = certificate_warnings(certificate);
  return json;
}

std::string failure_line(const Certificate& certificate) {
  const auto& checks = certificate.checks;
  const auto first =
      std::find_if(checks.begin(), checks.end(), [](const Check& c) { return !c.holds; });
  std::string text = "DOES NOT HOLD: " + failure_text(*first);
  const int failures = certificate.failures();
  if (failures > 1) text += fmt::format("; and {} more", failures - 1);
  return text;
}

std::string verdict_text(Verdict verdict) {
  switch (verdict) {
    case Verdict::local_minimum:
      return "certified local minimum";
    case Verdict::stationary:
      return "stationary";
    case Verdict::not_a_minimum:
      return "stationary, not a minimum";
    case Verdict::consistent:
    case Verdict::contradicted:
      break;
  }
  return "consistency check passed";
}

std::string certificate_line(const SolutionCertificate& certificate) {
  if (!certificate.checks.holds()) return failure_line(certificate.checks);
  const Certificate& checks = certificate.checks;
  std::string text = verdict_text(checks.verdict());
  if (!checks.curvature.empty()) text += ": " + checks.curvature;
  return fmt::format("{} ({} checks)", text, checks.checks.size());
}

namespace {

/// Figures, place and message of a check, if present.
std::string behind_name(const Check& check) {
  std::string text;
  if (has_figures(check))
    text += fmt::format("  {:>17} {:>17.10g} {:>10.1e}",
                        std::isnan(check.claimed) ? "" : fmt::format("{:.10g}", check.claimed),
                        check.found, check.tolerance);
  if (!check.place.empty()) text += "  " + check.place;
  if (!check.message.empty()) text += "  " + check.message;
  return text;
}

}  // namespace

std::string certificate_table(const Certificate& certificate) {
  std::size_t width = 4;
  for (const Check& check : certificate.checks)
    width = std::max<std::size_t>(width, count_characters(check.name));
  std::string text = fmt::format("  {:<{}}  {:>17} {:>17} {:>10}\n", "", width + 6, "claimed",
                                 "found", "tolerance");
  for (const Check& check : certificate.checks) {
    const std::string rest = behind_name(check);
    text += fmt::format("  {} ", check.holds ? "ok   " : "FAILS") + check.name;
    if (!rest.empty()) text += std::string(width - count_characters(check.name), ' ') + rest;
    text += '\n';
  }
  return text;
}

std::string optimality_line(const SolutionCertificate& certificate) {
  const Optimality& o = certificate.checks.optimality;
  std::string text = fmt::format(
      "stationarity {:.1e} along own gains, which decides; reduced gradient {:.1e} (rounding "
      "{:.0e})",
      o.stationarity, o.reduced_gradient, o.reduced_rounding);
  // The Newton step is undefined for a stage without curvature.
  if (std::isfinite(o.expected_decrease))
    text += fmt::format("; a Newton step would gain {:.1e}", o.expected_decrease);
  return text;
}

std::string replay_line(const SolutionCertificate& certificate) {
  const Replay& replay = *certificate.replay;
  if (!replay.impossible.empty()) return "none: " + replay.impossible;
  return fmt::format("at dt/{}: with feedback {}; controls alone {}", replay.substeps,
                     run_text(certificate, replay.feedback),
                     run_text(certificate, replay.controls));
}

std::vector<std::string> certificate_warnings(const SolutionCertificate& certificate) {
  std::vector<std::string> list;
  if (!certificate.grid_warning.empty()) list.push_back(certificate.grid_warning);
  if (!certificate.replay || !certificate.replay->impossible.empty()) return list;
  const Replay& replay = *certificate.replay;
  if (replay.feedback.lost_at >= 0 || replay.feedback.relative > kFarOff)
    list.push_back(
        fmt::format("on a grid of dt/{} feedback does not stabilize the motion: {}; a smaller dt "
                    "or an integrator of higher order",
                    replay.substeps, run_text(certificate, replay.feedback)));
  for (const BrokenLimit& limit : replay.broken) list.push_back(limit_text(limit));
  return list;
}

}  // namespace conddp
