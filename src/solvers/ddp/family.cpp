#include "solvers/ddp/family.hpp"

#include <algorithm>
#include <iterator>

namespace conddp {
namespace {

constexpr DdpMember kFamily[] = {
    // Li, Todorov 2004.
    {.name = "ilqr", .description = "single shooting, Gauss-Newton", .recipe = {}},
    // The usual baseline: the sweep ignores the bounds and the rollout clamps the controls. Its
    // convergence test is that of all members, so it often ends without converging.
    // Li, Todorov 2004, with clamped controls.
    {.name = "ilqr_clip",
     .description = "single shooting, Gauss-Newton, controls clamped at their bounds (a baseline)",
     .recipe = {.clamp_controls = true}},
    // Mayne 1966.
    {.name = "ddp",
     .description = "single shooting, exact second derivatives",
     .recipe = {.hessian = HessianUse::exact}},
    // Tassa, Mansard, Todorov 2014.
    {.name = "box_ddp",
     .description = "single shooting, control bounds by projected Newton",
     .recipe = {.clamp_controls = true, .box_stage = true, .hessian = HessianUse::when_slow}},
    // Uses an l1 merit; the step length contracts the gaps.
    // Mastalli et al. 2020.
    {.name = "fddp",
     .description = "multiple shooting, Gauss-Newton",
     .recipe = {.open_gaps = true, .hessian = HessianUse::when_slow}},
    // Unlike in the paper, stage problems respect the bounds from the first iteration on, even with
    // open gaps.
    // Mastalli et al. 2022.
    {.name = "box_fddp",
     .description = "multiple shooting, Gauss-Newton, control bounds by projected Newton",
     .recipe = {.open_gaps = true,
                .clamp_controls = true,
                .box_stage = true,
                .hessian = HessianUse::when_slow}},
    // The sweep includes terminal rows.
    // Mastalli et al. 2022.
    {.name = "intro",
     .description = "multiple shooting, equality constraints by null space",
     .recipe = {.open_gaps = true,
                .constraints = true,
                .multipliers = MultiplierSchedule::by_the_sweep,
                .hessian = HessianUse::when_slow}},
    // Stage problems handle the control bounds, here and in proxddp.
    // Howell, Jackson, Manchester 2019; cones: Jackson et al. 2021.
    {.name = "altro",
     .description = "augmented Lagrangian around multiple shooting; all constraints",
     .recipe = {.open_gaps = true,
                .clamp_controls = true,
                .box_stage = true,
                .constraints = true,
                .newton = true,
                .hessian = HessianUse::when_slow}},
    // Jallet, Bambade, Kazdadi, Carpentier, Mansard 2025.
    {.name = "proxddp",
     .description = "proximal augmented Lagrangian around multiple shooting; all constraints",
     .recipe = {.open_gaps = true,
                .clamp_controls = true,
                .box_stage = true,
                .constraints = true,
                .multipliers = MultiplierSchedule::bound_constrained_lagrangian,
                .hessian = HessianUse::when_slow}},
};

}  // namespace

std::span<const DdpMember> ddp_family() { return kFamily; }

const DdpMember* find_ddp_member(std::string_view name) {
  const auto found = std::find_if(std::begin(kFamily), std::end(kFamily),
                                  [name](const DdpMember& member) { return member.name == name; });
  return found == std::end(kFamily) ? nullptr : found;
}

}  // namespace conddp
