#include "solvers/ddp/family.hpp"

namespace conddp {
namespace {

constexpr DdpMember kFamily[] = {
    {.name = "ilqr",
     .description = "single shooting, Gauss-Newton",
     .source = "Li, Todorov 2004",
     .recipe = {}},
    // What everybody starts with: the sweep knows nothing of the bounds and the rollout clamps the
    // controls. Its convergence test is everyone's, so that it often ends short of converged.
    {.name = "ilqr_clip",
     .description = "single shooting, Gauss-Newton, controls clamped at their bounds (a baseline)",
     .source = "Li, Todorov 2004, with clamped controls",
     .recipe = {.clamp_controls = true}},
    {.name = "ddp",
     .description = "single shooting, exact second derivatives",
     .source = "Mayne 1966",
     .recipe = {.hessian = HessianUse::exact}},
    {.name = "box_ddp",
     .description = "single shooting, control bounds by projected Newton",
     .source = "Tassa, Mansard, Todorov 2014",
     .recipe = {.clamp_controls = true, .box_stage = true, .hessian = HessianUse::when_slow}},
    // With an l1 merit; the step length contracts the gaps.
    {.name = "fddp",
     .description = "multiple shooting, Gauss-Newton",
     .source = "Mastalli et al. 2020",
     .recipe = {.open_gaps = true, .hessian = HessianUse::when_slow}},
    // Unlike the paper's, stage problems respect the bounds from the first iteration on, closed
    // gaps or not.
    {.name = "box_fddp",
     .description = "multiple shooting, Gauss-Newton, control bounds by projected Newton",
     .source = "Mastalli et al. 2022",
     .recipe = {.open_gaps = true,
                .clamp_controls = true,
                .box_stage = true,
                .hessian = HessianUse::when_slow}},
    // With terminal rows in the sweep.
    {.name = "intro",
     .description = "multiple shooting, equality constraints by null space",
     .source = "Mastalli et al. 2022",
     .recipe = {.open_gaps = true,
                .constraints = true,
                .multipliers = MultiplierSchedule::by_the_sweep,
                .hessian = HessianUse::when_slow}},
    // Bounds on the control stay with the stage problems, here and in proxddp.
    {.name = "altro",
     .description = "augmented Lagrangian around multiple shooting; all constraints",
     .source = "Howell, Jackson, Manchester 2019; cones: Jackson et al. 2021",
     .recipe = {.open_gaps = true,
                .clamp_controls = true,
                .box_stage = true,
                .constraints = true,
                .newton = true,
                .hessian = HessianUse::when_slow}},
    {.name = "proxddp",
     .description = "proximal augmented Lagrangian around multiple shooting; all constraints",
     .source = "Jallet, Bambade, Kazdadi, Carpentier, Mansard 2025",
     .recipe = {.open_gaps = true,
                .clamp_controls = true,
                .box_stage = true,
                .constraints = true,
                .multipliers = MultiplierSchedule::bound_constrained_lagrangian,
                .legs = true,
                .hessian = HessianUse::when_slow}},
};

}  // namespace

std::span<const DdpMember> ddp_family() { return kFamily; }

}  // namespace conddp
